# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds the Blender scene of an isoshade volume, and saves or renders it.

Run by Blender:  blender -b --factory-startup -P build_scene.py -- DESCRIPTION.json Paths of further descriptions come
from stdin, one per line, until it ends; "isoshade: finished" follows each. describe.c writes the description: plain
numbers in Blender units. These scripts make no decisions. The picture is that of scene/scene.h:

    emission = sigma(s) shade(d) c(s),  absorption = sigma(s),  shade = ka + sum of I (kd |n.l| + ks |n.h|^p)

Node groups:  isoshade  >  isoshade transfer function, isoshade ramp, isoshade box, isoshade shade. Positions are
relative to the frame, an object that represents the volume and is the parent of its levels: moving it moves box, grids
and normals together."""
import json
import os
import shutil
import sys

import bpy

OLDEST = (3, 4, 0)  # same as in device.c

# ---- the scene -------------------------------------------------------------------------------------------------


def play(volume, count):
    """Shows files numbered from 0 in frames 1 and on."""
    volume.is_sequence = True
    volume.frame_start = 1
    volume.frame_duration = count
    volume.frame_offset = -1


def add_levels(about, shift, frame, look, collection):
    drive_rate(look, frame)
    levels = about["levels"]
    several = len({level["level"] for level in levels}) > 1
    if several:
        frame["level"] = levels[0]["level"]
        frame.id_properties_ui("level").update(min=levels[0]["level"], max=levels[-1]["level"],
                                               description="Visible level of the pyramid")
        frame.property_overridable_library_set('["level"]', True)
    for level in levels:
        name = f"{about['name']} level {level['level']}" if several else about["name"]
        roi = level.get("roi", {"lo": [0, 0, 0], "hi": [1, 1, 1], "band": [1, 1, 1], "side": [1, 0, 0]})
        thing = volume_object(f"{name} {'roi' if roi['side'][0] == 0 else 'volume'}", level["vdb"], collection)
        if "sequence" in about:
            play(thing.data, about["sequence"])
        thing.parent = frame
        thing.location = [-shift * h for h in level["voxel_diagonal"]]
        give_material(thing, look)
        thing["isoshade_level"] = level["level"]
        if "values" in level:
            thing["isoshade_values"] = level["values"]
        tables = about["tf"]["tables"]
        thing["isoshade_table"] = table_properties(tables[level["table"]])
        thing["isoshade_ramp"] = float(tables[level["table"]]["ramp"])
        thing["isoshade_row"] = float(sum(table["rows"] for table in tables[:level["table"]]))
        thing["isoshade_last_row"] = float(tables[level["table"]]["rows"] - 1)
        thing["isoshade_offset"] = [float(v) for v in thing.location]
        thing["isoshade_physical"] = 0.0
        thing.data.render.step_size = level["step"]
        drive_step(thing, look)
        for key, value in level.get("labels", {}).items():
            thing[f"isoshade_labels_{key}"] = [float(v) for v in value]
        for key, value in roi.items() if "roi" in level or several else ():
            thing[f"isoshade_roi_{key}"] = [float(v) for v in value]
        reasons = {"level": f"level != {level['level']}"} if several else {}
        reasons |= {"show": "show < 1"} if "show" in frame else {}
        for hidden in ("hide_render", "hide_viewport") if reasons else ():
            drive(thing, hidden, None, " or ".join(reasons.values()), {name: (frame, f'["{name}"]') for name in reasons})


def add_switch(frame):
    """Adds the property "show", for volumes that share a scene."""
    frame["show"] = 1
    frame.id_properties_ui("show").update(min=0, max=1, description="0: hidden, 1: shown")
    frame.property_overridable_library_set('["show"]', True)


def add_volume(about, shift, parent, camera):
    """Adds a volume: its box, levels and material in a collection of their own, with the existing lights."""
    collection = bpy.data.collections.new(about["name"])
    parent.children.link(collection)
    frame = frame_object(about, collection)
    add_switch(frame)
    look = material(about)
    add_levels(about, shift, frame, look, collection)
    light_handles(about, look, collection)
    missing_signs(about, frame, camera, collection)


def build(about, shift):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.name = about.get("scene", about["name"])
    configure(scene, about)
    scene.unit_settings.scale_length = 0.001 / about["units_per_mm"]
    scene.unit_settings.length_unit = 'MILLIMETERS'
    collection = bpy.data.collections.new(scene.name)
    scene.collection.children.link(collection)
    frame = frame_object(about, collection)
    note_scene(about, frame)
    if "more" in about:
        add_switch(frame)
    look = material(about)
    add_levels(about, shift, frame, look, collection)
    scene.camera = camera_object(about["camera"], collection)
    if "save" in about:
        light_handles(about, look, collection)
        choose_material(about, frame)
        light_world(about, scene.world)
        missing_signs(about, frame, scene.camera, collection)
        for other in about.get("more", ()):
            add_volume(other, shift, collection, scene.camera)
        choose(frame, collection)
    return scene


def save(about, shift):
    scene = bpy.context.scene
    # The window may use steps of half a voxel; the final picture does not depend on it.
    scene.cycles.volume_preview_step_rate = max(1.0, 0.5 / about["step_voxels"])
    scene.cycles.preview_samples = 16
    scene.cycles.use_preview_denoising = False
    scene.render.filepath = "//" + scene.name + "_"
    scene.frame_start, scene.frame_end = 1, about.get("sequence", scene.frame_end)
    scene.frame_set(1)
    set_for_artist(scene)
    explain(about, shift)
    arrange_windows(scene, about)
    bpy.context.preferences.filepaths.save_version = 0
    # Not compressed: the checksum after the end (base/stamp.h) would hide the table of compressed blocks.
    try:
        bpy.ops.wm.save_as_mainfile(filepath=about["save"], check_existing=False, compress=False, relative_remap=False)
    except RuntimeError as why:  # reports "No such file" for a full disk
        free = shutil.disk_usage(os.path.dirname(about["save"])).free / 1e6
        raise OSError(f"cannot save the file in the temporary folder ($TMPDIR), which has {free:.1f} MB left: {why}")


def work(path, shift):
    """Runs a description. shift: offset of voxels in this Blender, None: unknown yet. Returns it."""
    with open(path, encoding="utf-8") as file:
        about = json.load(file)
    print("isoshade: progress 0.1 Blender", flush=True)
    if shift is None:
        shift = calibrate({**about["calibration"], "device": about["device"]})
    if "probe" in about:
        return shift
    print("isoshade: progress 0.3 Blender", flush=True)
    scene = build(about, shift)
    if "frames" in about:
        print("isoshade: pictures begin", flush=True)
        render_frames(scene, about["frames"])
        report_peak()
    if "save" in about:
        save(about, shift)
    print("isoshade: progress 1 Blender", flush=True)
    return shift


def main():
    """Runs the given description, then those whose paths come as lines of stdin."""
    if bpy.app.version < OLDEST:
        print(f"isoshade: is too old: Blender {bpy.app.version_string} is too old; needs {OLDEST[0]}.{OLDEST[1]} or newer",
              flush=True)
        sys.exit(8)
    shift = work(sys.argv[sys.argv.index("--") + 1], None)
    print("isoshade: finished", flush=True)
    for line in sys.stdin:
        shift = work(line.rstrip("\n"), shift)
        print("isoshade: finished", flush=True)


try:
    main()
except Exception as error:
    print(f"isoshade: failed: {type(error).__name__}: {error}".replace("\n", " "), flush=True)
    raise

# SPDX-License-Identifier: GPL-3.0-or-later
"""Certifies the open scene: isoshade validates the volume with this scene, and a copy of the open file is rendered as it
stands and compared with the reference (own_picture.py)."""
import json
import os
import pathlib
import tempfile

import bpy

from . import cutter, place, volume
from .operators import Button, isoshade
from .tables import Refused

LIMIT = 1 / 255  # RMSE between the file's picture and the reference, as a step of 8 bits
MOST_CLIPS = 6  # ISO_MAX_CLIP_PLANES
LEAST_CHANGE = 1e-4  # of settings that are named


def report_folder():
    if bpy.data.filepath:
        return os.path.splitext(bpy.data.filepath)[0] + "_report"
    return os.path.join(tempfile.mkdtemp(prefix="isoshade-"), "report")


def read_json(path, keys, complaint):
    """Returns a JSON object that has the keys."""
    try:
        root = json.loads(pathlib.Path(path).read_text(encoding="utf-8"))
        if all(key in root for key in keys):
            return root
    except (OSError, ValueError, TypeError, RecursionError):
        pass
    raise Refused(complaint)


def read_report(folder, code, complaint):
    """Returns the verdict as a word and as a sentence, and True if it is good."""
    report = read_json(os.path.join(folder, "report.json"), ("verdict", "sentence"), complaint)
    verdict, sentence = str(report["verdict"]), str(report["sentence"])
    levels = str(report.get("levels_sentence", "")).split(". ")[0].rstrip(".")
    sentence += f" {levels}." if levels else ""
    return verdict, sentence, code == 0 and verdict == "agree"


# ---- this file's own picture -------------------------------------------------------------------------------------


def suspects(frame, scene):
    """Returns reasons why the shown level may render another picture than exported."""
    thing, found = volume.shown_object(frame), []
    if any(name == thing.name for name, _ in volume.missing_files(scene)):
        found.append(f"the file of {thing.name} is missing")
    offset = thing.get("isoshade_offset")
    moved = offset is not None and any(abs(a - b) > 1e-6 * max(1, abs(b)) for a, b in zip(thing.location, offset))
    if moved or any(abs(a) > 1e-6 for a in thing.rotation_euler) or any(abs(a - 1) > 1e-6 for a in thing.scale):
        found.append(f"{thing.name} was moved, turned or scaled inside its box")
    if thing.modifiers:
        found.append(f"{thing.name} has modifiers")
    found += unseen(frame, thing, scene)
    voxel, look = volume.voxel_units(thing), thing.active_material
    step = thing.data.render.step_size * look.cycles.volume_step_rate / frame.matrix_world.median_scale
    voxels = step / voxel if voxel else 0
    if voxel and not 0 < voxels <= 1:
        found.append(f"its step is {voxels:.3g} voxels: set Step Size of its data; a volume of another size than the first one with "
                     "this material needs its own, with another Step Rate")
    if look.cycles.volume_interpolation != 'LINEAR':
        found.append("its material interpolates cubically")
    if volume.look_of(thing)[0].inputs["Use Ramp"].default_value > 0.5:
        found.append("Cycles evaluates the ramp at 256 places: bake it and use the exact table")
    if volume.left_out_but_shown(frame):
        found.append("the transfer function shows values that the grids leave out")
    return found


def unseen(frame, thing, scene):
    """Returns what keeps a volume, or lights of its material, from being seen."""
    found = []
    if thing.hide_render or any(collection.hide_render for collection in thing.users_collection):
        found.append(f"{thing.name} or its collection is hidden from renders")
    if not thing.visible_camera:
        found.append(f"{thing.name} is invisible to camera rays")
    depths, lens = place.depths(scene.camera, frame), scene.camera.data
    if lens.clip_start > max(min(depths), 0) + 0.01 * max(frame.dimensions) or max(depths) > lens.clip_end:
        found.append("the camera's clip range cuts the volume")
    animation = thing.active_material.node_tree.animation_data
    if animation and not all(variable.targets[0].id for curve in animation.drivers for variable in curve.driver.variables):
        found.append("the sun of a light was deleted")
    return found


def names_of(names):
    more = f" and {len(names) - 4} more" if len(names) > 4 else ""
    return ", ".join(names[:4]) + more


def own_sentence(result, reasons):
    """Returns sentences about the file's picture."""
    where = f" (largest {result['max']:.2g} at column {result['column']}, row {result['row']})" if result["rmse"] > LIMIT else ""
    said = f"This file's picture differs from the reference by RMSE {result['rmse']:.2g}{where}."
    if result["rmse"] > LIMIT:
        said += f" Check: {'; '.join(reasons) or 'a step that is too long, changes of the material or the grids'}."
    changes = [f"{one['what']} by {one['rmse']:.2g}" for one in result["settings"] if one["rmse"] >= LEAST_CHANGE]
    changes += [f"{result['view']['what']} by {result['view']['rmse']:.2g} of shown colors"] if result["view"] else []
    if changes:
        said += f" Settings change it: {', '.join(changes)}."
    left_out = ", ".join(result["features"] + ([names_of(result["objects"])] if result["objects"] else []))
    said += f" Left out: {left_out}." if left_out else ""
    return said + (f" The exact material ignores {names_of(result['lamps'])}." if result["lamps"] else "")


def read_own(folder, complaint):
    return read_json(os.path.join(folder, "result.json"), ("rmse", "max", "settings", "view", "objects", "features", "lamps"),
                     complaint)


def scene_at_size(context, frame, longest):
    """Returns the scene in the form isoshade.scene/1 for a picture whose longer side is at most `longest`, and its size.
    The camera is that of the rounded size, whose shape may differ."""
    render = context.scene.render
    kept = render.resolution_x, render.resolution_y, render.resolution_percentage
    whole = [kept[axis] * kept[2] / 100 for axis in (0, 1)]
    size = [max(int(side * min(1, longest / max(whole)) + 0.5), 4) for side in whole]  # as Blender's least
    try:
        render.resolution_x, render.resolution_y, render.resolution_percentage = *size, 100
        return volume.scene_json(context, frame), size
    finally:
        render.resolution_x, render.resolution_y, render.resolution_percentage = kept


class Certificate:
    """The files and commands of a certificate."""

    def __init__(self, context, frame):
        self.scene, self.frame, self.options = context.scene, frame, context.scene.isoshade
        self.folder = report_folder()
        self.own_folder = self.folder + "_of_file"
        self.path = self.folder + ".scene.json"
        self.about, self.size = scene_at_size(context, frame, self.options.size)
        point, direction, _ = volume.place_of(frame, self.scene)
        cuts = cutter.clip_planes(frame, point, direction)
        if cuts:
            self.about["clip_planes"] = self.about.get("clip_planes", []) + cuts
            if len(self.about["clip_planes"]) > MOST_CLIPS:
                raise Refused(f"The reference has at most {MOST_CLIPS} clip planes, this scene has {len(self.about['clip_planes'])}")
        self.source = volume.volume_path(frame, self.scene)
        self.program = isoshade(context)
        self.is_exact = not frame.get("physical", 0) > 0

    def write(self):
        """Writes the scene and a copy of the open file."""
        try:
            pathlib.Path(self.path).write_text(json.dumps(self.about, indent=1) + "\n", encoding="utf-8")
            if not self.is_exact:
                return
            os.makedirs(self.own_folder, exist_ok=True)
            plan = {"scene": self.scene.name, "layer": bpy.context.view_layer.name, "frame": self.frame.name, "image": self.size,
                    "world": volume.background_of(self.scene)[1], "folder": self.own_folder,
                    "reference": os.path.join(self.own_folder, "reference.exr")}
            pathlib.Path(self.own_folder, "plan.json").write_text(json.dumps(plan), encoding="utf-8")
            result = pathlib.Path(self.own_folder, "result.json")
            result.unlink(missing_ok=True)
            bpy.ops.wm.save_as_mainfile(filepath=os.path.join(self.own_folder, "copy.blend"), copy=True, compress=False)
        except (OSError, RuntimeError) as error:
            raise Refused(f"{self.own_folder}: {getattr(error, 'strerror', None) or error}") from None

    def commands(self, renderers):
        size = "x".join(map(str, self.size))
        own = self.own_folder
        asked = ["--scene", self.path, "--size", size]
        levels = max(volume.level_numbers(self.frame)) + 1
        validate = [self.program, "validate", self.source, *asked, "--levels", str(levels), "--with", ",".join(renderers), "-q", "-o",
                    self.folder] + (["--quick"] if self.options.quick else [])
        if not self.is_exact:
            return [validate]
        return [[self.program, "render", self.source, *asked, "--with", "reference", "--level", str(volume.shown_level(self.frame)), "-q",
                 "-o", os.path.join(own, "reference.exr")],
                [bpy.app.binary_path, "-b", "-noaudio", "--disable-autoexec", "--python-exit-code", "9", os.path.join(own, "copy.blend"), "-P",
                 os.path.join(os.path.dirname(__file__), "own_picture.py"), "--", os.path.join(own, "plan.json")],
                validate]


def clean(folder):
    for name in ("copy.blend", "plan.json", "reset.exr"):
        pathlib.Path(folder, name).unlink(missing_ok=True)


class ISOSHADE_OT_certify(Button, bpy.types.Operator):
    """Validate the volume with this scene, and compare this file's own picture of it with the reference"""
    bl_idname, bl_label = "isoshade.certify", "Certify This Scene"

    def work(self, context):
        frame = volume.need_frame(context)
        renderers = [name for name in ("gl", "cycles", "povray") if getattr(context.scene.isoshade, "with_" + name)]
        if not renderers:
            raise Refused("Choose a renderer to compare with the reference")
        context.view_layer.update()
        job_of = Certificate(context, frame)
        job_of.write()
        reasons = suspects(frame, context.scene)
        scene_name, is_exact, folder, own = context.scene.name, job_of.is_exact, job_of.folder, job_of.own_folder

        def finish(job):
            if is_exact:
                clean(own)
            if job.code() not in (0, 1, 7, 9) or job.commands:
                raise Refused(job.complaint())
            verdict, sentence, good = read_report(folder, job.code(), job.complaint())
            if is_exact:
                result = read_own(own, job.complaint())
                is_own_good = result["rmse"] <= LIMIT
                verdict = verdict if is_own_good else "this file differs"
                sentence, good = f"{own_sentence(result, reasons)} {sentence}", good and is_own_good
            else:
                sentence = "The physical material has no reference. Of the exact material: " + sentence
            scene = bpy.data.scenes.get(scene_name)
            if scene:
                scene.isoshade.verdict, scene.isoshade.agrees = sentence, good
                scene.isoshade.report = os.path.join(folder, "index.html")
            return f"Certified: {verdict}" if good else f"Careful: {sentence}"

        context.scene.isoshade.verdict = ""
        return self.run(context, "Certifying", job_of.commands(renderers), finish)


class ISOSHADE_OT_report(Button, bpy.types.Operator):
    """Open the report in the browser"""
    bl_idname, bl_label = "isoshade.open_report", "Open Report"

    def work(self, context):
        path = context.scene.isoshade.report
        if not os.path.isfile(path) or os.path.basename(path) != "index.html":
            raise Refused("There is no report of this scene: certify it")
        if not bpy.app.background:
            bpy.ops.wm.url_open(url=pathlib.Path(path).as_uri())
        return f"The report is {path}"


classes = (ISOSHADE_OT_certify, ISOSHADE_OT_report)

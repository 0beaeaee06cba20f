# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders a copy of an open file as it stands, the volume alone, and compares the picture with the reference. Settings
that differ from the validated ones are reset one after another, and the change of each is measured.

    blender -b COPY.blend --disable-autoexec -P own_picture.py -- PLAN.json
PLAN.json: scene, frame, image (width, height), reference (an .exr), folder. Writes FOLDER/result.json."""
import json
import math
import os
import sys

import bpy
import numpy

# Settings of Cycles: name, validated value, words. They are reset in this order.
SETTINGS = (
    ("film_exposure", 1.0, "film exposure"),
    ("volume_step_rate", 1.0, "step rate of the scene"),
    ("volume_max_steps", 65536, "most steps"),
    ("volume_biased", True, "unbiased volumes"),
    ("use_denoising", False, "denoising"),
    ("sample_clamp_direct", 0.0, "direct clamp"),
    ("use_adaptive_sampling", False, "adaptive sampling"),
    ("filter_width", 0.01, "filter width"),
)
SAMPLES = 16  # average phases of the steps: 4 leave an RMSE of 0.004 in shells thinner than a voxel
# What the reference cannot draw is turned off, and named.
OFF = (("render", "use_motion_blur", "motion blur"), ("render", "use_border", "render region"),
       ("render", "use_compositing", "compositor"), ("render", "use_sequencer", "sequencer"),
       ("render", "use_stamp", "stamp"), ("render", "use_freestyle", "Freestyle lines"), ("render", "use_multiview", "stereo"))
SEEN = ("view_transform", "Standard"), ("look", "None"), ("exposure", 0.0), ("gamma", 1.0), ("use_curve_mapping", False)


def keep_alone(scene, frame):
    """Leaves one volume for the render. Returns the names of the other objects that would be seen."""
    layer = scene.view_layers.new("isoshade")
    for other in scene.view_layers:
        other.use = other == layer
    others = [thing for thing in scene.objects if thing.parent != frame and not thing.hide_render]
    for thing in others:
        thing.driver_remove("hide_render")
        thing.hide_render = True
    return sorted(thing.name for thing in others if "isoshade missing file" not in thing.modifiers and (
        thing.type not in ('CAMERA', 'EMPTY', 'LIGHT') or thing.instance_collection))


def layer_settings(layer, things):
    """Returns settings of the view layer and of objects that change or hide a volume; its picture is without them."""
    def parts(branch):
        yield branch
        for child in branch.children:
            yield from parts(child)

    names = {thing.name for thing in things}
    found = [f"{words} of the collection {part.name}" for part in parts(layer.layer_collection)
             for key, words in (("exclude", "exclusion"), ("holdout", "holdout"), ("indirect_only", "indirect only"))
             if getattr(part, key) and names & set(part.collection.all_objects.keys())]
    found += [f"material override {layer.material_override.name}"] if layer.material_override else []
    for thing in things:
        found += [f"holdout of {thing.name}"] if thing.is_holdout else []
        thing.is_holdout = False
    return found


def idle_lamps(scene):
    """Returns the lamps that are no handles of a light of the exact material, which they do not light."""
    trees = [material.node_tree for material in bpy.data.materials if material.node_tree]
    drivers = [curve for tree in trees if tree.animation_data for curve in tree.animation_data.drivers]
    handles = {target.id for curve in drivers for variable in curve.driver.variables for target in variable.targets}
    return sorted(thing.name for thing in scene.objects
                  if thing.type == 'LIGHT' and thing not in handles and not thing.hide_render)


def turn_off(scene, plan):
    """Turns off what the reference has not. Returns its names."""
    found = []
    for part, key, words in OFF:
        owner = getattr(scene, part)
        is_used = getattr(owner, key) and (key != "use_compositing" or scene.use_nodes) and (
            key != "use_sequencer" or scene.sequence_editor)
        setattr(owner, key, False)
        found += [words] if is_used else []
    if scene.render.engine != 'CYCLES':
        found.append(f"the engine {scene.render.engine}, replaced by Cycles")
        scene.render.engine = 'CYCLES'
    if scene.camera.data.dof.use_dof:
        found.append("depth of field")
        scene.camera.data.dof.use_dof = False
    world = scene.world.node_tree if scene.world else None
    for node in world.nodes if world else ():
        if node.bl_idname == 'ShaderNodeOutputWorld' and node.inputs["Volume"].is_linked:
            found.append("fog of the world")
            world.links.remove(node.inputs["Volume"].links[0])
    if plan["world"]:
        found.append(plan["world"])
        scene.render.film_transparent = True
    return found


def load(path):
    image = bpy.data.images.load(path)
    pixels = numpy.array(image.pixels[:]).reshape(image.size[1], image.size[0], 4)[:, :, :3]
    bpy.data.images.remove(image)
    return pixels


def apart(a, b):
    return math.sqrt(((a - b) ** 2).mean())


def render(scene, path):
    settings = scene.render.image_settings
    settings.file_format, settings.color_mode, settings.color_depth = 'OPEN_EXR', 'RGBA', '32'
    scene.render.filepath = path
    bpy.ops.render.render(scene=scene.name, write_still=True)
    return load(path)


def shown_colors(scene, folder):
    """Returns the last picture as its colors are shown, from 0 to 1."""
    settings = scene.render.image_settings
    settings.file_format, settings.color_mode, settings.color_depth = 'PNG', 'RGB', '16'
    path = os.path.join(folder, "shown.png")
    bpy.data.images["Render Result"].save_render(path, scene=scene)
    image = bpy.data.images.load(path)
    image.colorspace_settings.name = 'Non-Color'
    pixels = numpy.array(image.pixels[:])
    bpy.data.images.remove(image)
    os.remove(path)
    return pixels


def color_management(scene, folder):
    """Returns the change of the shown colors by the scene's color management, with its words; None: there is none."""
    view, display = scene.view_settings, scene.display_settings
    values = [(key, getattr(view, key)) for key, standard in SEEN if getattr(view, key) != standard]
    words = ["curves" if value is True else f"{key.replace('_', ' ')} {value:g}" if isinstance(value, float) else
             f"{key.replace('_', ' ')} {value}" for key, value in values]
    words += [f"display device {display.display_device}"] if display.display_device != 'sRGB' else []
    if not words:
        return None
    have = shown_colors(scene, folder)
    display.display_device = 'sRGB'
    for key, standard in SEEN:
        setattr(view, key, standard)
    return {"what": ", ".join(words), "rmse": apart(have, shown_colors(scene, folder))}


def measure(scene, plan):
    folder = plan["folder"]
    reference = load(plan["reference"])
    path, features = os.path.join(folder, "as-it-stands.exr"), []
    try:
        picture = render(scene, path)
    except RuntimeError:
        if not scene.cycles.use_denoising:
            raise
        scene.cycles.use_denoising, features = False, ["denoising, which this Blender lacks"]
        picture = render(scene, path)
    result = {"as_it_stands": apart(picture, reference), "settings": [], "features": features}
    view = color_management(scene, folder)
    cycles = scene.cycles
    for key, wanted, words in SETTINGS:
        have = getattr(cycles, key, wanted)
        if abs(have - wanted) < 1e-4:
            continue
        setattr(cycles, key, wanted)
        if key == "filter_width":
            cycles.pixel_filter_type, cycles.samples = 'BLACKMAN_HARRIS', min(cycles.samples, SAMPLES)
        changed = render(scene, os.path.join(folder, "reset.exr"))
        words += f" {have:g}" if isinstance(have, float) else "" if isinstance(have, bool) else f" {have}"
        result["settings"].append({"what": words, "rmse": apart(changed, picture)})
        picture = changed
    off = abs(picture - reference).max(axis=2)
    row, column = numpy.unravel_index(off.argmax(), off.shape)
    return {**result, "rmse": apart(picture, reference), "max": float(off.max()), "column": int(column),
            "row": int(off.shape[0] - 1 - row), "view": view}


def main():
    with open(sys.argv[sys.argv.index("--") + 1], encoding="utf-8") as file:
        plan = json.load(file)
    scene = bpy.data.scenes[plan["scene"]]
    scene.render.resolution_x, scene.render.resolution_y = plan["image"]
    scene.render.resolution_percentage = 100
    scene.render.use_overwrite, scene.render.use_file_extension = True, True
    lamps, frame = idle_lamps(scene), bpy.data.objects[plan["frame"]]
    features = layer_settings(scene.view_layers[plan["layer"]], [thing for thing in frame.children if thing.type == 'VOLUME'])
    objects = keep_alone(scene, frame)
    features += turn_off(scene, plan)
    result = {"objects": objects, "lamps": lamps, **measure(scene, plan)}
    result["features"] += features
    with open(os.path.join(plan["folder"], "result.json"), "w", encoding="utf-8") as file:
        json.dump(result, file, indent=1)


main()

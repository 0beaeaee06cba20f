# SPDX-License-Identifier: GPL-3.0-or-later
"""Installs the add-on in this Blender and presses each of its buttons, on a volume of a few voxels; prints a line for each
check, "ok NAME" or "not ok NAME: WHY" (tests/check_addon.sh).

    blender -b --factory-startup -P addon_buttons.py -- ADDON.zip ISOSHADE VOLUME SCENE TF FOLDER"""
import importlib
import json
import math
import os
import sys

import bpy
import numpy
from bpy_extras.object_utils import world_to_camera_view
from mathutils import Vector

zip_path, program_path, source, look, tf_path, folder = sys.argv[sys.argv.index("--") + 1:]


def tell(name, good, why=""):
    print(f"ok {name}" if good else f"not ok {name}: {why}".replace("\n", " "), flush=True)


def press(button, **values):
    """What a button says as an error, or ''."""
    try:
        button(**values)
    except RuntimeError as error:
        return str(error).strip()
    return ""


def refused(name, words, button, **values):
    said = press(button, **values)
    tell(name, words in said and len(said.splitlines()) == 1, f'said "{said}", wanted "{words}"')


def works(name, button, **values):
    said = press(button, **values)
    tell(name, said == "", said)


def install():
    if bpy.app.version >= (4, 2, 0):
        bpy.ops.extensions.package_install_files(filepath=zip_path, repo="user_default", enable_on_install=True)
        return "bl_ext.user_default.isoshade"
    bpy.ops.preferences.addon_install(filepath=zip_path)
    # The Python package, if it is installed, is searched first.
    sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)), "..", "python"))
    bpy.ops.preferences.addon_enable(module="isoshade_addon")
    return "isoshade_addon"


def points_of(path):
    with open(path, encoding="utf-8") as file:
        root = json.load(file)
    return root, numpy.array([[p[k] for k in ("value", "r", "g", "b", "opacity")] for p in root["points"]])


def picture(scene, use_ramp, name):
    press(buttons.show, ramp=bool(use_ramp))
    if volume.look_of(volume.shown_object(frame))[0].inputs["Use Ramp"].default_value != use_ramp:
        raise RuntimeError("isoshade.show does nothing")
    scene.render.filepath = os.path.join(folder, name)
    bpy.ops.render.render(write_still=True, scene=scene.name)
    image = bpy.data.images.load(scene.render.filepath)
    pixels = numpy.array(image.pixels[:]).reshape(-1, 4)[:, :3]
    bpy.data.images.remove(image)
    press(buttons.show, ramp=False)
    return pixels


module = install()
addon = bpy.context.preferences.addons.get(module)
tell("it_is_installed_and_enabled", addon is not None, module)
volume, tables, operators = (importlib.import_module(f"{module}.{part}") for part in ("volume", "tables", "operators"))
buttons = bpy.ops.isoshade
tell("the_panel_is_there", hasattr(bpy.types, "ISOSHADE_PT_volume") and bpy.types.ISOSHADE_PT_volume.bl_category == "isoshade")

# ---- importing -------------------------------------------------------------------------------------------------

refused("nothing_is_certified_without_a_volume", "This scene has no volume of isoshade", buttons.certify)
addon.preferences.program = os.path.join(folder, "nowhere", "isoshade")
refused("a_program_that_is_not_there", "is not a program; set it in the add-on's preferences", buttons.import_volume, filepath=source, folder=folder)
addon.preferences.program = program_path
broken = os.path.join(folder, "$(touch run) `touch run`; broken.nrrd")
with open(broken, "w", encoding="ascii") as file:
    file.write("NRRD0004\ntype: nothing\n")
refused("what_isoshade_says_of_a_broken_file", "broken.nrrd", buttons.import_volume, filepath=broken, folder=folder)
tell("and_no_shell_has_seen_its_name", not os.path.exists("run") and not os.path.exists(os.path.join(folder, "run")))
refused("a_file_that_is_not_there", "does not exist", buttons.import_volume, filepath=os.path.join(folder, "no.nrrd"))
works("a_volume_is_imported", buttons.import_volume, filepath=source, levels=2, adapt=False, look=look, folder=folder, into='SCENE')
scene = bpy.context.window.scene
scene.render.resolution_x = scene.render.resolution_y = 16
frame = volume.find_frame(bpy.context)
tell("with_its_levels", volume.level_numbers(frame) == [0, 1], volume.level_numbers(frame))
tell("in_a_scene_of_its_own_with_a_camera", scene.camera is not None and scene.render.engine == 'CYCLES', scene.name)
works("its_files_are_there", buttons.check_files)
grid = bpy.path.abspath(volume.levels_of(frame)[1].data.filepath)
os.rename(grid, grid + ".away")
refused("a_missing_grid_is_named", os.path.basename(grid), buttons.check_files)
os.rename(grid + ".away", grid)

# ---- the histogram -----------------------------------------------------------------------------------------------

histogram = importlib.import_module(f"{module}.histogram")
with open(source, "rb") as file:
    samples = numpy.frombuffer(file.read()[-2 * 14 ** 3:], "<u2").astype(float)
lowest, highest, counts = histogram.counts_of(frame)
have = numpy.histogram(samples, len(counts), (lowest, highest))[0]
tell("the_import_counts_all_values", (lowest, highest) == (samples.min(), samples.max()) and abs(have - counts).max() <= 1,
     f"{lowest} to {highest}, {list(counts)}, by numpy {list(have)}")
del frame["isoshade_histogram"]
ramp = volume.ramp_of(volume.shown_object(frame))
tell("without_it_there_is_no_picture", histogram.icon(frame, ramp) == 0)
works("a_button_counts_again", buttons.histogram)
pixels = histogram.picture(frame, ramp)
bars = (pixels[histogram.STRIP:, :, 0] > 0.3).sum(axis=0)
place = ramp.lo + (numpy.arange(histogram.WIDTH) + 0.5) / histogram.WIDTH * (ramp.hi - ramp.lo)
bins = ((place - lowest) / (highest - lowest) * len(counts)).clip(0, len(counts) - 1).astype(int)
tall = numpy.log1p(counts)[bins] / numpy.log1p(counts.max()) * (histogram.HEIGHT - histogram.STRIP - 1)
tell("bars_stand_at_their_values", (abs(bars - tall) <= 6).all() and bars.max() > 90, abs(bars - tall).max())
tell("shifted_by_a_bin_they_would_not", abs(numpy.roll(bars, histogram.WIDTH // len(counts)) - tall).max() > 6)
tell("under_them_are_the_ramps_colors", abs(pixels[3, 128, :3] ** 2.2 - numpy.clip(ramp.curve(place[128:129])[0, :3], 0, 1)).max() < 1e-3)

# ---- levels, ramps and tables ----------------------------------------------------------------------------------

ramp = volume.ramp_of(volume.shown_object(frame))
original, wanted = points_of(tf_path)
fit = original["range"] == "fit"
lo, hi = frame["isoshade_value_range"] if fit else original["range"]
wanted[:, 0] = lo + wanted[:, 0] * (hi - lo) if fit else wanted[:, 0]
if original["color_space"] == "srgb":
    wanted[:, 1:4] = numpy.where(wanted[:, 1:4] <= 0.04045, wanted[:, 1:4] / 12.92, ((wanted[:, 1:4] + 0.055) / 1.055) ** 2.4)
tell("the_ramp_has_the_points_as_stops", len(ramp.stops()) == len(wanted), f"{len(ramp.stops())} of {len(wanted)}")
saved = os.path.join(folder, "saved.tf.json")
works("the_transfer_function_is_saved", buttons.save_tf, filepath=saved)
root, have = points_of(saved)
off = abs((have - wanted) / [hi - lo, 1, 1, 1, 1]).max()
tell("its_points_come_back", have.shape == wanted.shape and off <= 1e-6, f"off by {off:.2g} of the range")
works("a_level_is_chosen", buttons.level, level=1)
tell("and_shown", volume.shown_level(frame) == 1 and volume.ramp_of(volume.shown_object(frame)).index == ramp.index)
refused("one_that_is_not_there_is_refused", "has the levels 0, 1", buttons.level, level=5)
works("and_back", buttons.level, level=0)

exported = volume.Table(volume.shown_object(frame)).read().copy()
works("what_was_not_edited_needs_no_baking", buttons.bake)
ramp.tree["isoshade_shown_0"] = [0.0]
works("as_exported_it_bakes_to_what_was_exported", buttons.bake)
baked = volume.Table(volume.shown_object(frame)).read()
off = abs(baked - exported).max() / exported[:, 3].max()
tell("to_single_precision", off <= 2e-6, f"off by {off:.2g} of the largest extinction")

exact = picture(scene, 0, "exact.exr")
for element, color in zip(ramp.node.color_ramp.elements, ((0.9, 0.1, 0.1), (0.1, 0.8, 0.2), (0.3, 0.3, 1.0), (1.0, 0.9, 0.1), (0.5, 0.5, 0.5))):
    element.color = (*color, 0.9 * element.color[3])
refused("an_edited_ramp_is_not_certified_unbaked", "The ramp was edited", buttons.certify)
works("an_edited_ramp_is_baked", buttons.bake)
after, by_ramp = picture(scene, 0, "baked.exr"), picture(scene, 1, "ramp.exr")
tell("the_picture_has_changed", abs(after - exact).max() > 0.05, abs(after - exact).max())
tell("the_exact_material_shows_the_edited_ramp", abs(after - by_ramp).max() < 5e-3, abs(after - by_ramp).max())
table = volume.Table(volume.shown_object(frame))
points = numpy.array(ramp.points())
values = table.lo + numpy.arange(table.count) / (table.count - 1) * (table.hi - table.lo)
want = numpy.stack([numpy.interp(values, points[:, 0], points[:, c]) for c in range(1, 5)], axis=1)
want[:, 3] = -numpy.log1p(-numpy.minimum(want[:, 3], 0.9999)) / ramp.unit
off = abs(table.read() - want).max(axis=0) / [1, 1, 1, want[:, 3].max()]
tell("each_entry_is_the_formula's", off.max() <= 2e-6, off)
frame["isoshade_hidden"] = json.dumps([[-1e30, float(values[3])]])
ramp.node.color_ramp.elements[0].color[3] = 0.5
buttons.bake()
said = bpy.context.window_manager.isoshade.said
tell("values_that_the_grids_lack_are_told", "which the grids leave out" in said, said)
del frame["isoshade_hidden"]
ramp.node.color_ramp.elements[0].color[3] = 0.0
buttons.bake()
works("both_levels_have_it", buttons.level, level=1)
tell("colors_stay_when_the_level_is_switched", (volume.Table(volume.shown_object(frame)).read() == table.read()).all())
edited = os.path.join(folder, "edited.tf.json")
works("it_is_saved_too", buttons.save_tf, filepath=edited)
works("the_range_of_the_ramp_is_widened", buttons.ramp_range, lo=float(ramp.lo) - 8, hi=float(ramp.hi) + 8)
ramp = volume.ramp_of(volume.shown_object(frame))
off = abs(numpy.array(ramp.points())[1:-1, 0] - points[:, 0]).max() if len(ramp.points()) == len(points) + 2 else math.inf
tell("its_stops_keep_their_values", off <= 1e-6 * (hi - lo), ramp.points())

# ---- what Cycles makes of a ramp --------------------------------------------------------------------------------


def strip(ramp, table):
    """The ramp's group on a plane whose pixels are the entries of the table: color and extinction as Cycles has them."""
    about = bpy.data.scenes.new("strip")
    about.render.engine, about.render.resolution_x, about.render.resolution_y = 'CYCLES', table.count, 4
    about.cycles.samples, about.cycles.pixel_filter_type, about.cycles.filter_width, about.cycles.max_bounces = 1, 'BLACKMAN_HARRIS', 0.01, 0
    about.cycles.use_denoising = about.cycles.use_adaptive_sampling = False
    about.view_settings.view_transform = 'Raw'
    about.render.image_settings.file_format, about.render.image_settings.color_depth = 'OPEN_EXR', '32'
    mesh = bpy.data.meshes.new("strip")
    mesh.from_pydata([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], [], [(0, 1, 2, 3)])
    camera = bpy.data.objects.new("strip camera", bpy.data.cameras.new("strip"))
    camera.data.type, camera.data.ortho_scale, camera.data.sensor_fit, camera.location.z = 'ORTHO', 2, 'HORIZONTAL', 1
    about.camera = camera
    plane = bpy.data.objects.new("strip", mesh)
    for thing in (camera, plane):
        about.collection.objects.link(thing)
    look = bpy.data.materials.new("strip")
    look.use_nodes = True
    nodes, links = look.node_tree.nodes, look.node_tree.links
    nodes.clear()
    place, split, value, group, glow, out = (nodes.new(kind) for kind in ('ShaderNodeTexCoord', 'ShaderNodeSeparateXYZ', 'ShaderNodeMath', 'ShaderNodeGroup',
                                                                          'ShaderNodeEmission', 'ShaderNodeOutputMaterial'))
    group.node_tree, value.operation = ramp.tree, 'MULTIPLY_ADD'
    # Pixel i of N is at x = (2 i + 1) / N - 1 and shows entry i: lo + i / (N - 1) (hi - lo).
    n, span = table.count, table.hi - table.lo
    value.inputs[1].default_value, value.inputs[2].default_value = n * span / (2 * (n - 1)), table.lo + (n - 1) * span / (2 * (n - 1))
    links.new(place.outputs["Object"], split.inputs[0])
    links.new(split.outputs["X"], value.inputs[0])
    links.new(value.outputs[0], group.inputs["Scalar"])
    group.inputs["Ramp"].default_value = ramp.index
    links.new(glow.outputs[0], out.inputs["Surface"])
    plane.data.materials.append(look)
    found = []
    for output in ("Color", "Extinction"):
        links.new(group.outputs[output], glow.inputs["Color"])
        about.render.filepath = os.path.join(folder, f"strip-{output}.exr")
        bpy.ops.render.render(write_still=True, scene=about.name)
        image = bpy.data.images.load(about.render.filepath)
        found.append(numpy.array(image.pixels[:]).reshape(4, table.count, 4)[0])
    return numpy.concatenate([found[0][:, :3], found[1][:, :1]], axis=1)


# Stops between the 256 places that Cycles bakes: its effect is predicted entry by entry.
for i, place in enumerate((0.0, 0.3013, 0.4507, 0.6021, 1.0)):
    ramp.node.color_ramp.elements[i].position = place
buttons.bake()
seen = strip(ramp, table)
seen[:, 3] = tables.opacity(seen[:, 3], ramp.unit)
values = tables.values_of(table.lo, table.hi, table.count)


def baked(steps):
    places = numpy.linspace(ramp.lo, ramp.hi, steps + 1)
    rows = ramp.curve(places)
    return numpy.stack([numpy.interp(values, places, rows[:, c]) for c in range(4)], axis=1)


steps, foreseen = min(((steps, baked(steps)) for steps in (255, 256)), key=lambda way: abs(seen - way[1]).max())
exact = tables.look_up(table.read(), table.lo, table.hi, values, ramp.unit)
loss = abs(foreseen - exact).max(axis=0)
tell(f"cycles_bakes_ramps_as_foreseen_at_i_of_{steps}", abs(seen - foreseen).max() < 2e-5, abs(seen - foreseen).max(axis=0))
tell("which_loses_something_here", loss.min() < 0.05 and loss.max() > 1e-3, loss)

# ---- adapting and loading --------------------------------------------------------------------------------------

works("a_file_is_loaded", buttons.load_tf, filepath=tf_path)
off = abs(volume.Table(volume.shown_object(frame)).read()[:len(exported)] - exported).max() / exported[:, 3].max()
tell("it_is_what_was_exported", off <= 2e-6, off)
hostile = os.path.join(folder, "hostile.tf.json")
with open(hostile, "w", encoding="ascii") as file:
    file.write('{"schema": "isoshade.tf/1", "range": [0, 1], "unit_distance_mm": "__import__(\'os\').getcwd()", "color_space": "linear", "points": []}')
refused("a_file_of_code_is_refused", '"points" must be a list', buttons.load_tf, filepath=hostile)
with open(hostile, "w", encoding="ascii") as file:
    file.write('{"schema": "isoshade.tf/1", "points": [{"value": 1}]}')
refused("all_missing_keys_are_named", 'lacks "range", "unit_distance_mm", "color_space"; an example:', buttons.load_tf, filepath=hostile)
works("levels_are_adapted", buttons.adapt, always=True)
numbers = [volume.ramp_of(thing).index for thing in volume.levels_of(frame)]
tell("each_has_a_ramp_of_its_own", numbers == [0, 1], numbers)
tell("level_1_is_still_shown", volume.shown_level(frame) == 1)
coarse = volume.shown_object(frame)
tell("its_ramp_is_its_own", volume.ramp_of(coarse).stops() != volume.ramp_of(volume.levels_of(frame)[0]).stops())
exact, by_ramp = picture(scene, 0, "coarse.exr"), picture(scene, 1, "coarse-ramp.exr")
rmse = math.sqrt(((exact - by_ramp) ** 2).mean())
tell("use_ramp_shows_level_1s", rmse < 0.03, rmse)
coarse["isoshade_ramp"] = 0.0  # planted: level 0's ramp
off = math.sqrt(((exact - picture(scene, 1, "wrong-ramp.exr")) ** 2).mean())
coarse["isoshade_ramp"] = 1.0
tell("level_0s_ramp_would_not", off > 1.5 * rmse, f"{off:.3g}, its own {rmse:.3g}")
works("adapted_again", buttons.adapt, always=True)
tell("needs_no_further_ramps", len(volume.read_notes(ramp.tree)) == 2)

# ---- certifying ------------------------------------------------------------------------------------------------

works("back_at_level_0", buttons.level, level=0)
scene.isoshade.with_cycles, scene.isoshade.size = False, 16
works("the_scene_is_certified", buttons.certify)
tell("the_verdict_is_shown", "renderers agree" in scene.isoshade.verdict and scene.isoshade.agrees, scene.isoshade.verdict)


def own_rmse():
    """Of the file's picture, from the verdict."""
    words = scene.isoshade.verdict.split("by RMSE ")
    return float(words[1].split()[0].rstrip(".")) if len(words) > 1 else math.inf


tell("this_files_picture_is_the_references", own_rmse() < 1 / 255, scene.isoshade.verdict)
tell("its_filter_is_named", "filter width 1.5 by 0.0" in scene.isoshade.verdict, scene.isoshade.verdict)
works("the_report_can_be_opened", buttons.open_report)
# Scaled, with other things in the scene, and seen by another view transform: the certificate is of this scene.
camera = scene.camera
kept = frame.matrix_world.copy(), camera.matrix_world.copy(), camera.data.clip_start, camera.data.ortho_scale
around = bpy.data.objects.new("around", None)
cube = bpy.data.objects.new("my cube", bpy.data.meshes.new("my cube"))
cube.data.from_pydata([(-9, -9, 9), (9, -9, 9), (9, 9, 9)], [], [(0, 1, 2)])
for thing in (around, cube):
    scene.collection.objects.link(thing)
frame.parent = camera.parent = around
around.scale = [0.01] * 3
camera.data.clip_start, camera.data.ortho_scale = 0.01 * camera.data.clip_start, 0.01 * camera.data.ortho_scale
view = scene.view_settings
view.view_transform = 'Filmic' if bpy.app.version < (4, 0, 0) else 'AgX'
view.gamma, view.use_curve_mapping = 1.5, True
works("a_scaled_scene_is_certified", buttons.certify)
said = scene.isoshade.verdict
tell("its_picture_is_the_references", own_rmse() < 1 / 255 and scene.isoshade.agrees, said)
tell("what_is_left_out_is_named", "Left out: my cube." in said, said)
tell("and_the_settings_of_the_view", f"view transform {view.view_transform}, gamma 1.5, curves by 0." in said, said)
tell("no_copy_of_the_file_is_left", not [name for name in os.listdir(scene.isoshade.report.replace("/index.html", "_of_file")) if "blend" in name])
shown = volume.shown_object(frame)
shown.location.x += 2.0
press(buttons.certify)
tell("a_grid_that_was_moved_is_named", f"{shown.name} was moved" in scene.isoshade.verdict and not scene.isoshade.agrees, scene.isoshade.verdict)
shown.location.x -= 2.0
shown.active_material.driver_remove("cycles.volume_step_rate")
shown.active_material.cycles.volume_step_rate = 1
press(buttons.certify)
tell("a_step_that_stays_behind_is_named", "needs its own, with another Step Rate" in scene.isoshade.verdict and not scene.isoshade.agrees, scene.isoshade.verdict)
shown.active_material.cycles.volume_step_rate = 0.01
frame.parent = camera.parent = None
view.view_transform, view.gamma, view.use_curve_mapping = 'Standard', 1.0, False
frame.matrix_world, camera.matrix_world, camera.data.clip_start, camera.data.ortho_scale = kept
shown.active_material.cycles.volume_step_rate = 1


def certified(name, *words, good=True):
    """Certifies, and looks for words in the verdict."""
    press(buttons.certify)
    said = scene.isoshade.verdict
    tell(name, all(word in said for word in words) and (own_rmse() < 1 / 255) == good, said)


# Edited by a person: each edit is named, and none is blamed on another.
scene.view_settings.exposure, scene.cycles.film_exposure = 0.5, 1.5
lamp = bpy.data.objects.new("my lamp", bpy.data.lights.new("my lamp", 'POINT'))
scene.collection.objects.link(lamp)
certified("edits_are_named", "exposure 0.5 by 0.", "film exposure 1.5 by 0.", "The exact material ignores my lamp.")
scene.view_settings.exposure, scene.cycles.film_exposure = 0.0, 1.0
bpy.data.objects.remove(lamp)
scene.render.use_stamp, scene.cycles.use_denoising, layer = True, True, bpy.context.view_layer
scene.display_settings.display_device = 'XYZ' if bpy.app.version < (4, 0, 0) else 'Display P3'
layer.material_override, shown.is_holdout = bpy.data.materials.new("mine"), True
certified("settings_of_the_layer_are_left_out_by_name", f"material override mine, holdout of {shown.name}", "stamp", "display device")
scene.display_settings.display_device, scene.cycles.use_denoising = 'sRGB', False
scene.view_settings.view_transform = 'Standard'
scene.render.use_stamp, layer.material_override, shown.is_holdout = False, None, False
world, size = scene.world, (scene.render.resolution_x, scene.render.resolution_y)
scene.world = bpy.data.worlds.new("plain")
scene.world.color, scene.render.resolution_x, scene.render.resolution_y = (0.2, 0.3, 0.4), 96, 40
camera.data.sensor_fit = 'AUTO'
certified("a_wide_picture_with_a_plain_world")
scene.world.color = (0.2, 0.3, 1.4)
certified("a_bright_world_is_left_out", "Left out: a world brighter than 1")
scene.world, (scene.render.resolution_x, scene.render.resolution_y), camera.data.sensor_fit = world, size, 'VERTICAL'
shown.visible_camera = False
certified("an_invisible_volume_is_named", f"{shown.name} is invisible to camera rays", good=False)
shown.visible_camera = True
for words, owner, key, value in (("lens shift", camera.data, "shift_x", 0.1), ("are not square", scene.render, "pixel_aspect_x", 2),
                                 ("Light 1 has intensity", bpy.data.objects["isoshade light 1"].data, "energy", 9)):
    before = getattr(owner, key)
    setattr(owner, key, value)
    refused(f"{key}_is_refused", words, buttons.certify)
    setattr(owner, key, before)
certified("and_gone_when_undone")
tell("without_a_trace", not any(word in scene.isoshade.verdict for word in ("exposure", "lamp")), scene.isoshade.verdict)
exact = [tuple(element.color) for element in ramp.node.color_ramp.elements]
for element in ramp.node.color_ramp.elements:
    element.color = (0.2, 0.9, 0.4, element.color[3])
press(buttons.show, ramp=True)
certified("an_edited_ramp_that_is_shown_is_certified")
press(buttons.show, ramp=False)
refused("and_not_the_table_of_before", "The ramp was edited", buttons.certify)
press(buttons.bake)
certified("baked_it_is_certified")
for element, color in zip(ramp.node.color_ramp.elements, exact):
    element.color = color
press(buttons.bake)
for thing in scene.objects:
    thing.select_set(thing == frame or thing.parent == frame)
for thing in frame.children:
    thing.hide_select = False
bpy.ops.object.duplicate()
copy = next(thing for thing in scene.objects if thing.select_get() and volume.levels_of(thing))
copy.location.x, camera.location.x = copy.location.x + 300, camera.location.x + 300
bpy.context.view_layer.objects.active = copy
certified("a_copy_is_certified", f"Left out: my cube, {shown.name}.")
volume.shown_object(copy).location.y += 2
certified("a_moved_grid_of_the_copy_is_named", "was moved, turned or scaled inside its box", good=False)
camera.location.x -= 300
for thing in (*copy.children, copy):
    bpy.data.objects.remove(thing)
bpy.context.view_layer.objects.active = frame
tell("it_is_a_page", os.path.isfile(scene.isoshade.report))
about = volume.scene_json(bpy.context, frame)
with open(os.path.join(folder, "scene.scene.json"), "w", encoding="utf-8") as file:
    json.dump(about, file)
frame.matrix_world = frame.matrix_world @ frame.matrix_world.__class__.Diagonal((1, 2, 1, 1))
bpy.context.view_layer.update()
refused("a_stretched_volume_is_not", "is stretched or mirrored", buttons.certify)
ramp.tree["isoshade_ramps"] = "__import__('os').system('true')"
refused("notes_that_cannot_be_read", "cannot be read", buttons.bake)
works("cancelling_nothing_does_nothing", buttons.cancel)
# Into the default scene of Blender, with its cube, camera, lamp and view transform.
bpy.context.window.scene = own = bpy.data.scenes["Scene"]
own.cycles.volume_max_steps = 8
said = press(buttons.import_volume, filepath=source, levels=1, folder=folder, into='HERE')
here = volume.find_frame(bpy.context)
said += bpy.context.window_manager.isoshade.said
tell("it_comes_into_the_default_scene", here.name in own.objects and here.name != frame.name, said)
longest = max(high - low for low, high in zip(here.bound_box[0], here.bound_box[6]))
tell("in_meters", abs(max(here.dimensions) / (0.001 * longest) - 1) < 1e-4, list(here.dimensions))
tell("with_words_on_the_view_transform", f"view transform {own.view_settings.view_transform}" in said, said)
tell("on_the_engine", "only Cycles" in said, said)
tell("and_on_steps", "Max Steps 8 makes" in said, said)
inside = [world_to_camera_view(own, own.camera, here.matrix_world @ Vector(corner)) for corner in here.bound_box]
tell("it_is_in_frame", all(0 <= v.x <= 1 and 0 <= v.y <= 1 and v.z > 0 for v in inside), inside)
own.render.engine, own.cycles.volume_max_steps, own.cycles.samples, own.cycles.use_denoising = 'CYCLES', 1024, 1, False
own.render.resolution_x = own.render.resolution_y = 16
own.render.image_settings.file_format, own.render.image_settings.color_depth = 'OPEN_EXR', '32'
shown = volume.shown_object(here)
seen = picture(own, 0, "here.exr")
shown.hide_render = True
tell("it_is_visible", abs(picture(own, 0, "gone.exr") - seen).max() > 0.1, abs(picture(own, 0, "gone.exr") - seen).max())
for unit, size in (('CM', 0.1 * longest), ('FIT', 1.0)):
    press(buttons.import_volume, filepath=source, levels=1, look=look, folder=folder, into='HERE', unit=unit, frame_it=False)
    got = max(bpy.context.view_layer.objects.active.dimensions)
    tell(f"or_in_{unit}", abs(got / size - 1) < 1e-4, got)
bpy.context.window.scene = scene
collections = len(scene.collection.children)
second = operators.take_over(os.path.join(folder, "s.blend"), 'HERE', bpy.context)
grids = [thing.data.filepath for thing in volume.levels_of(second)]
tell("a_second_one_comes_into_this_scene", second.name in scene.objects and len(scene.collection.children) == collections + 1
     and all(os.path.isfile(bpy.path.abspath(path)) for path in grids), grids)
if bpy.app.version < (4, 2, 0):
    bpy.ops.preferences.addon_disable(module=module)
    tell("it_is_removed_without_a_trace", not hasattr(bpy.types.Scene, "isoshade") and not hasattr(bpy.types, "ISOSHADE_PT_volume"))

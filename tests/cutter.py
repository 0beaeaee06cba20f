# SPDX-License-Identifier: GPL-3.0-or-later
"""Cutters of the add-on (exporters/blender/addon/cutter.py) against the reference, and against chords in closed form.
Run by Blender for check_cutter.sh; a line "ok NAME" or "not ok NAME: why" each.

blender -b NAME.blend -P cutter.py -- ADDON_FOLDER box.exr plane.exr | ADDON_FOLDER SIGMA"""
import math
import os
import sys

import bpy
import numpy
from mathutils import Matrix, Vector

arguments = sys.argv[sys.argv.index("--") + 1:]
sys.path.insert(0, arguments[0])
import addon  # noqa: E402
from addon import cutter, tables, volume  # noqa: E402

addon.register()
path = bpy.data.filepath
LIMIT = 1 / 255  # a step of 8 bits; the step of the ray alone leaves a tenth of it
# The cutter of check_cutter.sh: center, half sizes, and angles in radians about x, y, z.
CENTER, HALF, ANGLES = (2, -1, 1), (7, 8, 5), (0.3, 0.5, -0.4)


def say(case, good, why=""):
    print(f"ok {case}" if good else f"not ok {case}: {why}", flush=True)


def prepared():
    bpy.ops.wm.open_mainfile(filepath=path)
    scene = bpy.context.scene
    exec(bpy.data.texts["isoshade agreement"].as_string(), {})
    scene.render.resolution_x = scene.render.resolution_y = 40
    return scene, volume.find_frame(bpy.context)


def load(name):
    image = bpy.data.images.load(os.path.abspath(name))
    pixels = numpy.array(image.pixels[:]).reshape(*image.size, 4)
    bpy.data.images.remove(image)
    return pixels[:, :, :3]


def picture(scene):
    bpy.context.view_layer.update()
    scene.render.filepath = os.path.abspath("drawn.exr")
    bpy.ops.render.render(write_still=True)
    return load("drawn.exr")


def apart(a, b):
    return math.sqrt(((a - b) ** 2).mean())


def same(case, have, want, limit=LIMIT):
    off = apart(have, want)
    print("ok" if off <= limit else "not ok", f"{case}: RMSE {off:.2g}, limit {limit:.2g}", flush=True)


def shows(case, have, want):
    """A planted fault."""
    off = apart(have, want)
    say(case, off > LIMIT, f"RMSE {off:.3g}")


def placed(thing):
    turn = Matrix.Rotation(ANGLES[2], 4, 'Z') @ Matrix.Rotation(ANGLES[1], 4, 'Y') @ Matrix.Rotation(ANGLES[0], 4, 'X')
    thing.matrix_world = Matrix.Translation(CENTER) @ turn @ Matrix.Diagonal((*HALF, 1))


def empty(kind, name="cutter"):
    thing = bpy.data.objects.new(name, None)
    thing.empty_display_type = kind
    bpy.context.scene.collection.objects.link(thing)
    return thing


def press(keep, thing):
    """Presses the button with an active object. Returns its error, or ''."""
    bpy.context.view_layer.objects.active = thing
    try:
        bpy.ops.isoshade.cut(shape='ACTIVE', keep_inside=keep)
    except RuntimeError as error:
        return str(error).strip()
    return ""


def mesh(make, name="mesh"):
    make()
    thing = bpy.context.view_layer.objects.active
    thing.name = name
    return thing


def under_an_empty(things):
    around = empty('PLAIN_AXES', "around")
    bpy.context.view_layer.update()
    for thing in things:
        place = thing.matrix_world.copy()
        thing.parent = around
        thing.matrix_world = place
    return around


def all_scaled(scene, things):
    """Scales and moves volume, camera and cutter: the picture stays."""
    around = under_an_empty(things)
    around.scale, around.location = [0.01] * 3, (3, -1, 2)
    camera = scene.camera.data
    camera.clip_start, camera.clip_end, camera.ortho_scale = (
        0.01 * value for value in (camera.clip_start, camera.clip_end, camera.ortho_scale))


def moved_to_its_place(thing):
    """Puts a cutter there after it has cut elsewhere: drivers have to follow."""
    thing.matrix_world = Matrix.Translation((-3, 4, 2)) @ Matrix.Scale(3, 4)
    said = press(True, thing)
    say(f"{thing.name}_cuts", said == "", said)
    placed(thing)


def against_the_reference(box, plane):
    scene, frame = prepared()
    whole = picture(scene)
    cube = empty('CUBE')
    moved_to_its_place(cube)
    same("box_keeps_its_inside", picture(scene), box)
    planes = cutter.clip_planes(frame, *volume.place_of(frame, scene)[:2])
    say("its_six_planes_are_the_references", len(planes) == 6, planes)
    cube.empty_display_size = 0.8
    shows("a_smaller_box_is_seen", picture(scene), box)
    cube.empty_display_size = 1.0
    all_scaled(scene, (frame, scene.camera, cube))
    same("scaled_and_moved", picture(scene), box)
    cube.location.x += 4
    shows("a_moved_cutter_is_seen", picture(scene), box)
    cube.location.x -= 4
    cube["keep_inside"] = 0
    cube.update_tag()
    outside = picture(scene)
    shows("removing_the_inside_is_another_picture", outside, box)
    bpy.ops.isoshade.uncut()
    same("uncut_it_is_whole", picture(scene), whole, 5e-5)

    scene, frame = prepared()
    arrow = empty('SINGLE_ARROW', "arrow")
    moved_to_its_place(arrow)
    same("plane_keeps_the_arrows_side", picture(scene), plane)
    all_scaled(scene, (frame, scene.camera, arrow))
    same("plane_scaled_and_moved", picture(scene), plane)
    arrow["keep_inside"] = 0
    arrow.update_tag()
    shows("the_other_side_is_another_picture", picture(scene), plane)

    scene, frame = prepared()
    cube = mesh(bpy.ops.mesh.primitive_cube_add)
    moved_to_its_place(cube)
    same("mesh_keeps_its_inside", picture(scene), box)
    all_scaled(scene, (frame, scene.camera, cube))
    same("mesh_scaled_and_moved", picture(scene), box)
    cube.data.vertices[0].co *= 0.3
    press(True, cube)
    shows("cut_again_after_an_edit", picture(scene), box)
    one = len(cutter.cutters_of(frame))
    say("one_cutter_remains", one == 1 and press(True, frame) != "", one)
    flat = mesh(bpy.ops.mesh.primitive_plane_add, "flat")
    said = press(True, flat)
    say("an_open_mesh_is_refused", "flat: is not closed" in said and len(cutter.cutters_of(frame)) == 1, said)
    try:
        cutter.clip_planes(frame, *volume.place_of(frame, scene)[:2])
        said = ""
    except tables.Refused as error:
        said = str(error)
    say("a_mesh_is_not_certified", "mesh: the reference cuts only by planes" in said, said)
    bpy.ops.isoshade.uncut()
    for shape in ('BOX', 'SPHERE', 'PLANE'):
        before = picture(scene)
        bpy.ops.isoshade.cut(shape=shape)
        shows(f"a_new_{shape}_is_seen", picture(scene), before)


def chord(origin, ray, radius, center):
    away = origin - center
    along = away @ ray
    half = numpy.sqrt(numpy.maximum(radius ** 2 - ((away - along[:, None] * ray) ** 2).sum(axis=1), 0))
    return half, along


def in_closed_form(sigma):
    """A constant volume of white light: brightness 1 - exp(-sigma L), L being the length of the ray in what is kept."""
    scene, frame = prepared()
    center, radius = numpy.array((2.0, -1.0, 1.0)), 7.0
    ball = empty('SPHERE', "ball")
    ball.location, ball.empty_display_size = center, radius
    world = numpy.array(scene.camera.matrix_world)
    n = (numpy.arange(40) + 0.5) / 40 - 0.5
    size = scene.camera.data.ortho_scale
    x, y = numpy.meshgrid(n * size, n * size)
    origin = (world[:3, 3] + x[..., None] * world[:3, 0] + y[..., None] * world[:3, 1]).reshape(-1, 3)
    ray = -world[:3, 2]
    corner = numpy.array(frame.bound_box[6])
    with numpy.errstate(divide='ignore'):
        slabs = numpy.sort(((numpy.array([[-1], [1]]) * corner)[:, None] - origin) / ray, axis=0)
    enter, leave = slabs[0].max(axis=1), slabs[1].min(axis=1)
    whole = numpy.maximum(leave - enter, 0)
    half, along = chord(origin, ray, radius, center)
    inside = numpy.maximum(numpy.minimum(leave, half - along) - numpy.maximum(enter, -half - along), 0)
    for keep, length in ((True, inside), (False, whole - inside)):
        want = numpy.repeat((1 - numpy.exp(-sigma * length)).reshape(40, 40, 1), 3, axis=2)
        press(keep, ball)
        same(f"sphere_{'keeps' if keep else 'removes'}_its_inside", picture(scene), want)
        ball.empty_display_size = 0.9 * radius
        shows(f"a_smaller_one_is_seen_{keep}", picture(scene), want)
        ball.empty_display_size = radius
    bpy.ops.isoshade.uncut()
    round_one = {"segments": 96, "ring_count": 64, "radius": radius, "location": center}
    globe = mesh(lambda: bpy.ops.mesh.primitive_uv_sphere_add(**round_one))
    press(False, globe)
    same("a_mesh_of_the_sphere_removes_it_too", picture(scene), want)


if len(arguments) == 3:
    against_the_reference(load(arguments[1]), load(arguments[2]))
else:
    in_closed_form(float(arguments[1]))

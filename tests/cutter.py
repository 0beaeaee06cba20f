# SPDX-License-Identifier: GPL-3.0-or-later
"""Cutters of the add-on (exporters/blender/addon/cutter.py) against the reference, and against chords in closed form.
Run by Blender for check_cutter.sh; a line "ok NAME" or "not ok NAME: why" each.

blender -b NAME.blend -P cutter.py -- ADDON_FOLDER box.exr plane.exr two.exr | ADDON_FOLDER SIGMA"""
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
EXACT = 2e-5  # of closed forms: single precision
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


def shows(case, have, want, limit=LIMIT):
    """A planted fault."""
    off = apart(have, want)
    say(case, off > limit, f"RMSE {off:.3g}")


def placed(thing):
    turn = Matrix.Rotation(ANGLES[2], 4, 'Z') @ Matrix.Rotation(ANGLES[1], 4, 'Y') @ Matrix.Rotation(ANGLES[0], 4, 'X')
    thing.matrix_world = Matrix.Translation(CENTER) @ turn @ Matrix.Diagonal((*HALF, 1))


def empty(kind, name="cutter"):
    thing = bpy.data.objects.new(name, None)
    thing.empty_display_type = kind
    bpy.context.scene.collection.objects.link(thing)
    return thing


def press(keep, *things):
    """Presses the button with objects selected, the first one active. Returns its error, or ''."""
    bpy.ops.object.select_all(action='DESELECT')
    for thing in things:
        thing.select_set(True)
    bpy.context.view_layer.objects.active = things[0]
    try:
        bpy.ops.isoshade.cut(shape='SELECTED', keep_inside=keep)
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


def against_the_reference(box, plane, two):
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
    arrow, front = empty('SINGLE_ARROW', "arrow"), empty('CUBE', "front")
    placed(arrow)
    arrow.matrix_world = arrow.matrix_world @ Matrix.Rotation(math.pi, 4, 'X')
    placed(front)
    front.matrix_world = front.matrix_world @ Matrix.Translation((50 + 1, 0, 0)) @ Matrix.Diagonal((50, 50, 50, 1))
    press(False, arrow, front)
    same("a_plane_and_a_large_box_remove_their_union", picture(scene), two)
    press(False, front)
    front.location.x += 4
    shows("a_moved_one_of_two_is_seen", picture(scene), two)

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
    rays = Rays(scene, frame, sigma)
    center, radius = numpy.array((2.0, -1.0, 1.0)), 7.0
    ball = empty('SPHERE', "ball")
    ball.location, ball.empty_display_size = center, radius
    inside = rays.in_ball(center, radius)
    for keep, want in ((True, rays.without((), kept=inside)), (False, rays.without([inside]))):
        press(keep, ball)
        same(f"sphere_{'keeps' if keep else 'removes'}_its_inside", picture(scene), want)
        ball.empty_display_size = 0.9 * radius
        shows(f"a_smaller_one_is_seen_{keep}", picture(scene), want)
        ball.empty_display_size = radius
    bpy.ops.isoshade.uncut()
    round_one = {"segments": 96, "ring_count": 64, "radius": radius, "location": center}
    globe = mesh(lambda: bpy.ops.mesh.primitive_uv_sphere_add(**round_one))
    press(False, globe)
    same("a_mesh_of_the_sphere_removes_it_too", picture(scene), rays.without([inside]))
    several(sigma)
    meshes(sigma)
    copies(sigma)


class Rays:
    """The pixels' rays, and intervals on them."""

    def __init__(self, scene, frame, sigma):
        world = numpy.array(scene.camera.matrix_world)
        n = (numpy.arange(40) + 0.5) / 40 - 0.5
        x, y = numpy.meshgrid(n * scene.camera.data.ortho_scale, n * scene.camera.data.ortho_scale)
        self.sigma, self.ray = sigma, -world[:3, 2]
        self.origin = (world[:3, 3] + x[..., None] * world[:3, 0] + y[..., None] * world[:3, 1]).reshape(-1, 3)
        self.whole = self.in_box((0, 0, 0), numpy.array(frame.bound_box[6]))

    def in_box(self, center, half):
        with numpy.errstate(divide='ignore'):
            slabs = numpy.sort((center + numpy.array([[-1], [1]]) * half)[:, None] - self.origin, axis=0) / self.ray
        slabs = numpy.sort(slabs, axis=0)
        return slabs[0].max(axis=1), slabs[1].min(axis=1)

    def in_ball(self, center, radius):
        half, along = chord(self.origin, self.ray, radius, numpy.array(center))
        return -half - along, half - along

    def without(self, removed, kept=None):
        """The picture without the union of intervals."""
        first, last = self.whole
        if kept:
            first, last = numpy.maximum(first, kept[0]), numpy.minimum(last, kept[1])
        length = numpy.maximum(last - first, 0)
        ends = [numpy.clip(end, first, numpy.maximum(first, last))
                for pair in removed for end in (pair[0], numpy.maximum(*pair))]
        for k in range(len(length)):
            reached = first[k]
            for begin, end in sorted((ends[i][k], ends[i + 1][k]) for i in range(0, len(ends), 2)):
                length[k] -= max(end - max(begin, reached), 0)
                reached = max(reached, end)
        return numpy.repeat((1 - numpy.exp(-self.sigma * length)).reshape(40, 40, 1), 3, axis=2)


def box_at(center, half, name="box"):
    thing = empty('CUBE', name)
    thing.location, thing.scale = center, half
    return thing


def ball_at(center, radius, name="ball"):
    thing = empty('SPHERE', name)
    thing.location, thing.empty_display_size = center, radius
    return thing


def several(sigma):
    """The union of cutters, exact also with steps of many voxels: both ends of gaps may lie in one step."""
    scene, frame = prepared()
    rays = Rays(scene, frame, sigma)
    for thing in volume.levels_of(frame):
        thing.data.render.step_size *= 4
    whole = picture(scene)
    same("long_steps_are_exact", whole, rays.without([]), EXACT)
    places = (((2, -1, 1), 7), ((-4, 3, 2), 6), ((0, 0, -3), 5))
    balls = [ball_at(*place) for place in places]
    said = press(False, *balls)
    want = rays.without([rays.in_ball(*place) for place in places])
    same("three_spheres_remove_their_union", picture(scene), want, EXACT)
    say("by_one_press", said == "" and len(cutter.cutters_of(frame)) == 3, said)
    keeper = box_at((1, 1, 0), (8, 9, 6))
    press(True, keeper)
    want = rays.without([rays.in_ball(*place) for place in places], rays.in_box((1, 1, 0), (8, 9, 6)))
    same("of_what_a_box_keeps", picture(scene), want, EXACT)
    bpy.ops.isoshade.uncut()
    same("all_cuts_are_removed", picture(scene), whole, 5e-5)
    boxes = [box_at((x, 0, 0), (3, 40, 40)) for x in (-3, 3)]
    press(False, *boxes)
    joint = [rays.in_box((x, 0, 0), (3, 40, 40)) for x in (-3, 3)]
    same("boxes_that_touch_leave_no_film", picture(scene), rays.without(joint), EXACT)
    join = cutter.join_node(cutter.main_tree(frame)).node_tree
    nodes, sink = cutter.Nodes(join), next(node for node in join.nodes if node.type == 'GROUP_OUTPUT')
    given = next(node for node in join.nodes if node.type == 'GROUP_INPUT').outputs
    product = nodes.math('SUBTRACT', given["Leave"], given["Enter"])
    for node in [node for node in join.nodes if node.type == 'GROUP']:
        part = nodes.math('SUBTRACT', node.outputs["Cuts To"], node.outputs["Cuts From"])
        product = nodes.math('MULTIPLY', product, nodes.math('SUBTRACT', 1.0, part))
    join.links.new(product, sink.inputs["Inside"])  # planted
    shows("a_product_of_parts_is_seen", picture(scene), rays.without(joint), 100 * EXACT)


def meshes(sigma):
    scene, frame = prepared()
    rays = Rays(scene, frame, sigma)
    places = (((2, -1, 1), (5, 6, 4)), ((-3, 2, -1), (6, 5, 5)))
    cubes = []
    for center, half in places:
        cubes.append(mesh(bpy.ops.mesh.primitive_cube_add, "cube"))
        cubes[-1].location, cubes[-1].scale = center, half
    press(False, *cubes)
    same("two_meshes_remove_their_union", picture(scene), rays.without([rays.in_box(*place) for place in places]))
    images = [image for image in bpy.data.images if "isoshade_mesh" in image]
    say("with_one_image", len(images) == 1, images)


def duplicate(*things, linked=False):
    """Shift D or Alt D. Returns the copies by the name of their original."""
    bpy.ops.object.select_all(action='DESELECT')
    before = set(bpy.data.objects)
    for thing in things:
        thing.hide_select = False
        thing.select_set(True)
    bpy.context.view_layer.objects.active = things[0]
    bpy.ops.object.duplicate(linked=linked)
    bpy.context.view_layer.update()
    return {thing.name.rsplit(".", 1)[0]: thing for thing in bpy.data.objects if thing not in before}


def copies(sigma):
    """Copies of cutters cut; copies and instances of volumes are cut like them, and have cutters of their own."""
    scene, frame = prepared()
    rays = Rays(scene, frame, sigma)
    first, second = ((2, -1, 1), 6), ((-4, 3, -2), 6)
    one, both = rays.without([rays.in_ball(*first)]), rays.without([rays.in_ball(*place) for place in (first, second)])
    for linked in (False, True):
        ball = ball_at(*first)
        press(False, ball)
        copy = duplicate(ball, linked=linked)["ball"]
        copy.location = second[0]
        same(f"{'a_linked' if linked else 'a'}_copy_of_a_cutter_cuts", picture(scene), both)
        bpy.ops.object.delete()
        bpy.context.view_layer.update()
        same("which_is_deleted", picture(scene), one)
        bpy.ops.isoshade.uncut()
        bpy.data.objects.remove(ball)

    scene, frame = prepared()
    ball = ball_at(*first)
    ball.parent = frame
    ball_at(second[0], 3, "idle")
    press(False, ball)
    far = Vector((300, -200, 90))
    made = duplicate(frame, *frame.children)
    copy = next(thing for thing in made.values() if volume.levels_of(thing))
    copy.location += far
    scene.camera.location += far
    same("a_copied_volume_is_cut", picture(scene), one)
    own = made["ball"]
    own.location.x += 3
    moved = rays.without([rays.in_ball((5, -1, 1), 6)])
    same("its_cutter_is_its_own", picture(scene), moved)
    scene.camera.location -= far
    same("and_leaves_the_first_one", picture(scene), one)

    scene, frame = prepared()
    ball = ball_at(*first)
    press(False, ball)
    instance = bpy.data.objects.new("instance", None)
    instance.instance_type, instance.instance_collection = 'COLLECTION', frame.users_collection[0]
    scene.collection.objects.link(instance)
    instance.location = far
    scene.camera.location += far
    same("an_instance_is_cut", picture(scene), one)


if len(arguments) == 4:
    against_the_reference(*map(load, arguments[1:]))
else:
    in_closed_form(float(arguments[1]))

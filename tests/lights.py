# SPDX-License-Identifier: GPL-3.0-or-later
"""Run by check_lights.sh in the slab.blend that it exports: a line "ok NAME" or "not ok NAME: why" a case."""
import math

import bpy
import numpy

scene = bpy.context.scene
cycles = scene.cycles
frame = bpy.data.objects["slab"]
look = frame.children[0].active_material.node_tree
inputs = look.nodes["isoshade"].inputs
sun = bpy.data.objects["isoshade light 1"].data
world = scene.world.node_tree.nodes
LEFT = 0.49  # 0.7^2: of the light that goes through
SINGLE = 2e-6  # single precision


def case(name, good, *said):
    print("ok" if good else "not ok", name if good else f"{name}: {said}", flush=True)


def near(a, b, limit):
    return bool(numpy.abs(numpy.asarray(a) - numpy.asarray(b)).max() <= limit)


def choose(physical):
    frame["physical"] = physical
    frame.update_tag()


def picture(samples, bounces):
    """Mean color of the middle, through which all rays go the whole way."""
    cycles.samples, cycles.max_bounces, cycles.volume_bounces = samples, bounces, bounces
    scene.render.filepath = "//lights.exr"
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(scene.render.filepath)
    pixels = numpy.array(image.pixels[:]).reshape(8, 8, 4)
    bpy.data.images.remove(image)
    return pixels[2:6, 2:6, :3].mean((0, 1))


def light_world(color, strength):
    for node in (world["Background"], world["Light"]):
        node.inputs["Color"].default_value = (*color, 1)
        node.inputs["Strength"].default_value = strength


# ---- as an artist finds it
case("it_opens_as_asked_for", frame["physical"] == 1 and frame.children[0]["isoshade_physical"] == 1, frame["physical"])
case("edges_are_filtered", cycles.filter_width == 1.5 and cycles.samples >= 64 and cycles.volume_bounces > 0)
case("a_sun_of_pi_is_as_bright_as_1", near(sun.energy, math.pi / 2, SINGLE), sun.energy)
exec(bpy.data.texts["isoshade agreement"].as_string())
bpy.context.view_layer.update()
case("the_text_sets_what_agreement_needs", frame["physical"] == 0 and frame.children[0]["isoshade_physical"] == 0 and
     (cycles.samples, cycles.max_bounces, cycles.use_adaptive_sampling) == (1, 0, False) and cycles.filter_width < 0.02)
cycles.use_adaptive_sampling = False

# ---- the exact one: ka + I kd |n.l| white, in front of the green background
plain = picture(1, 0)
case("the_exact_one_is_shaded", plain[0] == plain[2] > 0.2 * (1 - LEFT) and near(plain[1] - plain[0], 0.1 * LEFT, SINGLE), plain)
sun.color = (1, 0.5, 0)
colored = picture(1, 0)
diffuse = plain[0] - 0.2 * (1 - LEFT)
case("a_suns_color_colors_it", near(colored, plain - diffuse * numpy.array((0, 0.5, 1)), SINGLE), plain, colored)
sun.energy *= 2
case("and_its_strength_counts", near(picture(1, 0), colored + diffuse * numpy.array((1, 0.5, 0)), SINGLE))
sun.color = (1, 1, 1)

# ---- a white furnace: what scatters all light cannot be seen
sun.energy = 0
light_world((1, 1, 1), 1)
choose(1)
case("a_white_furnace_hides_it", near(picture(16, 1024), 1, SINGLE), picture(16, 1024))
case("too_few_bounces_are_seen", picture(16, 0)[0] < 0.95)
absorption = next(n for n in bpy.data.node_groups["isoshade physical"].nodes if n.bl_idname == 'ShaderNodeVolumeAbsorption')
source = absorption.inputs["Color"].links[0].from_socket
bpy.data.node_groups["isoshade physical"].links.remove(absorption.inputs["Color"].links[0])
absorption.inputs["Color"].default_value = (0.95, 0.95, 0.95, 1)
case("five_percent_of_absorption_are_seen", not near(picture(16, 1024), 1, 0.01))
bpy.data.node_groups["isoshade physical"].links.new(source, absorption.inputs["Color"])

# ---- its shadow on a floor, seen from between, by one sample: exp(-tau), which both materials share
light_world((0, 0, 0), 0)
sun.energy, sun.angle = math.pi, 0
mesh = bpy.data.meshes.new("floor")
mesh.from_pydata([(x, y, -7) for x, y in ((-50, -50), (50, -50), (50, 50), (-50, 50))], [], [(0, 1, 2, 3)])
mesh.materials.append(bpy.data.materials.new("white"))
mesh.materials[0].use_nodes = True
nodes = mesh.materials[0].node_tree.nodes
matt = nodes.new('ShaderNodeBsdfDiffuse')
matt.inputs["Color"].default_value = (1, 1, 1, 1)
mesh.materials[0].node_tree.links.new(matt.outputs[0], nodes["Material Output"].inputs["Surface"])
floor = bpy.data.objects.new("floor", mesh)
scene.collection.objects.link(floor)
above = scene.camera.location.z
scene.camera.location.z = -5
for name in ("Ambient", "Diffuse"):  # the exact one would glow on the floor
    inputs[name].default_value = 0
for physical in (0, 1):
    choose(physical)
    case(f"the_shadow_of_material_{physical}_is_that_of_the_slab", near(picture(1, 0), LEFT, SINGLE), picture(1, 0))
    inputs["Density Scale"].default_value = 1.05
    case(f"five_percent_more_of_material_{physical}_are_seen", not near(picture(1, 0), LEFT, 0.01))
    inputs["Density Scale"].default_value = 1
scene.collection.objects.unlink(floor)
scene.camera.location.z = above

# ---- lamps of each kind and the world: red light makes it red, and none does without the physical material
sun.energy = 0
for kind, strength in (('POINT', 4000), ('AREA', 4000), ('SPOT', 4000), ('SUN', 4), ('WORLD', 1)):
    lamp = bpy.data.lights.new(kind, kind) if kind != 'WORLD' else None
    if lamp:
        lamp.color, lamp.energy = (1, 0, 0), strength
        thing = bpy.data.objects.new(kind, lamp)
        thing.location = (0, 0, 12)
        scene.collection.objects.link(thing)
    else:
        world["Light"].inputs["Color"].default_value = (1, 0, 0, 1)
        world["Light"].inputs["Strength"].default_value = strength
    choose(1)
    lit = picture(16, 2)
    choose(0)
    case(f"a_red_{kind.lower()}_lights_it_red", lit[0] > 0.02 and lit[1] == lit[2] == 0, lit)
    case(f"but_not_the_exact_one_{kind.lower()}", picture(1, 2).max() == 0)
    if lamp:
        bpy.data.objects.remove(thing)

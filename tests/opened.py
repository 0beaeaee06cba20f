# SPDX-License-Identifier: GPL-3.0-or-later
"""What a person finds who opens an exported .blend, a line "name yes|no" each, for check_opened.sh. Run by Blender on it.

blender -b FILE.blend -P opened.py -- a folder in which nothing is beside the file"""
import os
import sys

import bpy


def tell(name, good):
    print(f"opened: {name} {'yes' if good else 'no'}", flush=True)


def sign_vertices():
    """Of the signs that are seen."""
    graph = bpy.context.evaluated_depsgraph_get()
    graph.update()
    return [len(thing.evaluated_get(graph).to_mesh().vertices) for thing in bpy.context.scene.objects
            if thing.name.endswith("is missing") and not thing.evaluated_get(graph).hide_render]


name = sys.argv[-1]
scene, layer = bpy.context.scene, bpy.context.view_layer
frame = bpy.data.objects[name]
volumes = [thing for thing in scene.objects if thing.type == 'VOLUME']
tell("all_is_in_one_collection", len(scene.collection.objects) == 0 and len(scene.collection.children) == 1 and
     set(scene.collection.children[name].objects) == set(scene.objects))
tell("the_box_is_active_and_selected", layer.objects.active == frame and [t for t in scene.objects if t.select_get()] == [frame])
tell("and_so_is_its_collection", layer.active_layer_collection.name == name)
tell("grids_are_read_in_full_precision", all(thing.data.render.precision == 'FULL' for thing in volumes))

# EEVEE's places in a volume are off by about 1e-7 z z / near: less than half a voxel all over the box.
camera = scene.camera
corners = [frame.matrix_world @ vertex.co for vertex in frame.data.vertices]
depths = [-(camera.matrix_world.inverted() @ corner).z for corner in corners]
voxel = scene["isoshade_units_per_mm"]  # of this volume
tell("the_near_plane_suits_single_precision", 1e-7 * max(depths) ** 2 / camera.data.clip_start < 0.5 * voxel)
tell("it_cuts_nothing_off", camera.data.clip_start < min(depths) and camera.data.clip_end > max(depths))
views = [area.spaces.active for screen in bpy.data.screens for area in screen.areas if area.type == 'VIEW_3D']
far = (camera.matrix_world.translation - sum(corners, corners[0] * 0) / 8).length
tell("windows_show_it", len(views) > 0 and all(
    view.shading.type == 'MATERIAL' and view.region_3d.view_perspective == 'CAMERA' and
    1e-7 * max(depths) ** 2 / view.clip_start < voxel and view.clip_end > max(depths) for view in views))
tell("who_leaves_the_camera_turns_round_the_volume", all(abs(view.region_3d.view_distance - far) < 1e-3 * far for view in views))

# Reprojection of Blender 4.2 and later keeps a gray first frame.
tell("eevee_draws_the_volume_anew", not hasattr(scene.eevee, "use_volume_custom_range") or not scene.eevee.use_taa_reprojection)

# Sockets by name: one more before them moves no driver to another.
tree = volumes[0].active_material.node_tree
node = tree.nodes["isoshade"]
group = node.node_tree
modern = hasattr(group, "interface")
if modern:
    group.interface.move(group.interface.new_socket(name="New", in_out='INPUT', socket_type='NodeSocketFloat'), 0)
else:
    group.inputs.new('NodeSocketFloat', "New")
    group.inputs.move(len(group.inputs) - 1, 0)
group.nodes.new('ShaderNodeMath')
sun = next(thing for thing in scene.objects if thing.type == 'LIGHT')
share = node.inputs["Intensity 1"].default_value / sun.data.energy
sun.data.energy = 0.625
layer.update()
evaluated = node.inputs["Intensity 1"].default_value
tell("drivers_survive_a_new_socket", share > 0 and abs(evaluated - 0.625 * share) < 1e-6)

# What Cycles renders on, of preferences that are imitated: two ways to one GPU, and the processor beside them.
class Device:
    def __init__(self, kind, name):
        self.type, self.name, self.use = kind, name, kind == 'CPU'


class Preferences:
    compute_device_type = 'NONE'

    def __init__(self, *kinds):
        self.devices = [Device('CPU', "some processor")] + [Device(kind, "some GPU") for kind in kinds]

    def get_device_types(self, context):
        return [('NONE', "None", "", 0), ('CUDA', "CUDA", "", 1), ('OPTIX', "OptiX", "", 3), ('HIP', "HIP", "", 4)]

    def get_devices_for_type(self, kind):
        return [device for device in self.devices if device.type in (kind, 'CPU')]


def device_for(asked, *kinds):
    preferences = Preferences(*kinds)
    try:
        name = devices["choose_device"](scene.cycles, preferences, asked)
    except SystemExit as refused:
        return f"refused with {refused.code}"
    used = "+".join(device.type for device in preferences.devices if device.use)
    return f"{name}: {scene.cycles.device} {preferences.compute_device_type} {used}"


devices = {}
with open(os.path.join(os.path.dirname(__file__), "../exporters/blender/scene_device.py"), encoding="utf-8") as script:
    exec(script.read(), devices)
tell("it_renders_on_the_processor", scene.cycles.device == 'CPU' and device_for("cpu", 'CUDA') == "CPU: CPU NONE CPU")
tell("a_gpu_is_taken_and_nothing_beside_it", device_for("gpu", 'CUDA', 'OPTIX') == "OPTIX some GPU: GPU OPTIX OPTIX" and
     device_for("cuda", 'CUDA', 'OPTIX') == "CUDA some GPU: GPU CUDA CUDA")
tell("no_other_is_taken_for_it", device_for("hip", 'CUDA') == device_for("gpu") == device_for("metal", 'HIP') == "refused with 8")
scene.cycles.device = 'CPU'

tell("no_sign_where_the_file_is", sign_vertices() == [0] and len(volumes) == 2)
for thing in volumes:
    thing.data.filepath = "//nowhere/" + thing.data.filepath.lstrip("/")
signs = sign_vertices()
tell("a_sign_where_it_is_missing", len(signs) == 1 and signs[0] > 100)
bpy.ops.wm.save_mainfile()

# A user appends this collection.
path = bpy.data.filepath
bpy.ops.wm.read_factory_settings(use_empty=True)
with bpy.data.libraries.load(path, link=False) as (there, taken):
    taken.collections = [name]
scene = bpy.context.scene
scene.collection.children.link(taken.collections[0])
things = list(taken.collections[0].all_objects)
volumes = [thing for thing in things if thing.type == 'VOLUME']
sun = next(thing for thing in things if thing.type == 'LIGHT')
sun.data.energy = 0.375
bpy.context.view_layer.update()
strength = volumes[0].active_material.node_tree.nodes["isoshade"].inputs["Intensity 1"].default_value
tell("it_can_be_appended_whole", len(volumes) == 2 and {'MESH', 'LIGHT', 'CAMERA', 'VOLUME'} <= {thing.type for thing in things} and
     abs(strength - 0.375 * share) < 1e-6)

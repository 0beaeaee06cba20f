# SPDX-License-Identifier: GPL-3.0-or-later
"""An exported scene after the changes that people make: scaled, copied, instanced, moved, mirrored, appended, linked. The picture
has to stay that of the fresh export. Run by Blender on it for check_changed.sh; a line "ok NAME" or "not ok NAME: why" each.

blender -b NAME.blend -P changed.py -- FOLDER"""
import math
import os
import sys

import bpy
import numpy
from mathutils import Euler, Matrix, Vector

folder = sys.argv[-1]
path = bpy.data.filepath
name = os.path.splitext(os.path.basename(path))[0]
NOISE = 5e-5  # single precision in other places: the same rays meet the same steps up to rounding
SEEN = 1 / 255
FAR = Vector((1000, -700, 300))


def say(case, good, why=""):
    print(f"ok {case}" if good else f"not ok {case}: {why}", flush=True)


def opened():
    """The file as exported, with the settings of agreement. Returns scene, frame."""
    bpy.ops.wm.open_mainfile(filepath=path)
    return prepared()


def prepared():
    scene = bpy.context.scene
    exec(bpy.data.texts["isoshade agreement"].as_string(), {})
    scene.render.resolution_x = scene.render.resolution_y = 40
    return scene, bpy.data.objects[name]


def picture(scene):
    bpy.context.view_layer.update()
    scene.render.filepath = os.path.join(folder, "changed.exr")
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(scene.render.filepath)
    pixels = numpy.array(image.pixels[:]).reshape(*image.size, 4)
    bpy.data.images.remove(image)
    os.remove(scene.render.filepath)
    return pixels[:, :, :3]


def apart(a, b):
    return math.sqrt(((a - b) ** 2).mean())


def same(case, have, want, limit=NOISE):
    off = apart(have, want)
    print("ok" if off <= limit else "not ok", f"{case}: RMSE {off:.2g}, limit {limit:.2g}", flush=True)


def shows(case, have, want):
    """A planted fault."""
    off = apart(have, want)
    say(case, off > SEEN, f"RMSE {off:.3g}")


def under_an_empty(scene, things):
    """Gives objects a new parent at the origin; their places stay."""
    empty = bpy.data.objects.new("around", None)
    scene.collection.objects.link(empty)
    for thing in things:
        thing.parent = empty
    return empty


def volumes():
    return [thing for thing in bpy.data.objects if thing.type == 'VOLUME']


def suns():
    return [thing for thing in bpy.data.objects if thing.type == 'LIGHT']


def scaled(factor):
    scene, frame = opened()
    under_an_empty(scene, (frame, scene.camera)).scale = [factor] * 3
    scene.camera.data.clip_start *= factor
    scene.camera.data.clip_end *= factor
    scene.camera.data.ortho_scale *= factor
    return scene, frame


def copied(linked):
    """A copy far away, with the camera; the original stays."""
    scene, frame = opened()
    bpy.ops.object.select_all(action='DESELECT')
    for thing in (frame, *frame.children):
        thing.hide_select = False
        thing.select_set(True)
    before = set(bpy.data.objects)
    bpy.ops.object.duplicate(linked=linked)
    copy = next(thing for thing in bpy.data.objects if thing not in before and "level" in thing)
    copy.location = copy.location + FAR
    scene.camera.location = scene.camera.location + FAR
    return scene, copy


def by_name(frame):
    """Planted: positions from one named object."""
    for tree in bpy.data.node_groups:
        for node in tree.nodes:
            if node.bl_idname == 'ShaderNodeTexCoord':
                node.object = frame
    for thing in volumes():
        thing["isoshade_offset"] = [0.0, 0.0, 0.0]


scene, frame = opened()
fresh = picture(scene)
frame["level"] = 1
frame.update_tag()
coarse = picture(scene)
shows("levels_differ", coarse, fresh)

for factor in (0.001, 0.25, 10):
    scene, frame = scaled(factor)
    same(f"scaled_by_{factor}", picture(scene), fresh)
scene, frame = scaled(10)
look = volumes()[0].active_material
look.driver_remove("cycles.volume_step_rate")
look.cycles.volume_step_rate = 40
shows("a_step_that_stays_behind_is_seen", picture(scene), fresh)

for linked in (False, True):
    scene, copy = copied(linked)
    same("linked_copy" if linked else "copy", picture(scene), fresh)
by_name(bpy.data.objects[name])
shows("positions_of_one_named_object_are_seen", picture(scene), fresh)

scene, frame = opened()
instance = bpy.data.objects.new("instance", None)
instance.instance_type, instance.instance_collection = 'COLLECTION', bpy.data.collections[name]
scene.collection.objects.link(instance)
instance.location = FAR
scene.camera.location = scene.camera.location + FAR
same("instance_of_its_collection", picture(scene), fresh)

scene, frame = opened()
around = under_an_empty(scene, (frame, scene.camera, *suns()))
around.rotation_euler, around.location = (0.3, 1.1, -0.7), (40, 5, -90)
same("parent_turned_and_moved", picture(scene), fresh, 2e-4)

scene, frame = opened()
for thing in volumes():
    thing.data.render.step_size /= 8
fine = picture(scene)
mirror = Matrix.Scale(-1, 4, Vector((1, 0, 0)))
frame.matrix_world = mirror @ frame.matrix_world
place = mirror @ scene.camera.matrix_world @ mirror  # the picture is mirrored, too
scene.camera.matrix_world = place
for sun in suns():
    towards = mirror.to_3x3() @ (sun.matrix_world.to_3x3() @ Vector((0, 0, 1)))
    sun.rotation_mode = 'XYZ'
    sun.rotation_euler = towards.to_track_quat('Z', 'Y').to_euler()
same("mirror", picture(scene)[:, ::-1], fine, 1e-3)  # other pixels have other phases of the steps, which are short here

scene, frame = opened()
around = under_an_empty(scene, (frame, scene.camera))
for number, x in ((0, -30), (1, 0), (2, 30)):
    around.location.x = x
    around.keyframe_insert("location", frame=number)
for curve in around.animation_data.action.fcurves:
    for key in curve.keyframe_points:
        key.interpolation = 'LINEAR'
scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 1.0
scene.frame_set(1)
same("motion_blur_of_box_and_camera", picture(scene), fresh, 1e-3)

scene, frame = opened()
for number, level in ((1, 0), (2, 1)):
    frame["level"] = level
    frame.keyframe_insert('["level"]', frame=number)
scene.frame_set(2)
same("animated_level_in_frame_2", picture(scene), coarse)
scene.frame_set(1)
same("animated_level_in_frame_1", picture(scene), fresh)

# All at once: a copy of twice the size in a collection of its own, of which an empty with a turned parent is an instance.
scene, copy = copied(False)
copy.scale *= 2
own = bpy.data.collections.new("copies")
for thing in (copy, *copy.children):
    for collection in thing.users_collection:
        collection.objects.unlink(thing)
    own.objects.link(thing)
instance = bpy.data.objects.new("instance", None)
instance.instance_type, instance.instance_collection = 'COLLECTION', own
scene.collection.objects.link(instance)
around = under_an_empty(scene, (instance,))
around.rotation_euler, around.location, instance.location = (0.3, 1.1, -0.7), (40, 5, -90), (3, 2, 1)
bpy.context.view_layer.update()
lens, turn = scene.camera.data, instance.matrix_world.to_quaternion()
scene.camera.matrix_world = (instance.matrix_world @ Matrix.Translation(FAR) @ Matrix.Scale(2, 4) @ Matrix.Translation(-FAR)
                             @ scene.camera.matrix_world).normalized()
lens.clip_end, lens.ortho_scale = 2 * lens.clip_end, 2 * lens.ortho_scale
for sun in suns():
    sun.rotation_mode = 'QUATERNION'
    sun.rotation_quaternion = turn @ sun.matrix_world.to_quaternion()
same("turned_instance_of_a_scaled_copy", picture(scene), fine, SEEN)

# A copy in the middle of an edit of the ramp: both show it.
scene, copy = copied(False)
node = volumes()[0].active_material.node_tree.nodes["isoshade"]
tree = next(tree for tree in bpy.data.node_groups if "isoshade_ramps" in tree)
node.inputs["Use Ramp"].default_value = 1
for element in tree.nodes["isoshade ramp 0"].color_ramp.elements:
    element.color = (0.9, 0.2, 0.1, element.color[3])
edited = picture(scene)
scene.camera.location = scene.camera.location - FAR
same("copied_in_an_edit", edited, picture(scene))
shows("which_is_seen", edited, fresh)

# ---- other files -------------------------------------------------------------------------------------------------


def empty_file(link):
    """A new file in another folder that has the collection; it is saved and opened again."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    os.makedirs(os.path.join(folder, "elsewhere"), exist_ok=True)
    bpy.ops.wm.save_as_mainfile(filepath=os.path.join(folder, "elsewhere", "own.blend"))
    with bpy.data.libraries.load(path, link=link, relative=True) as (there, here):
        here.collections, here.texts, here.worlds = [name], ["isoshade agreement"], ["isoshade background"]
    scene.collection.children.link(here.collections[0])
    scene.world = here.worlds[0]
    scene.camera = next(thing for thing in here.collections[0].all_objects if thing.type == 'CAMERA')
    scene.render.engine, scene.view_settings.view_transform = 'CYCLES', 'Standard'
    scene.cycles.use_denoising = False
    scene.cycles.volume_max_steps = 65536
    scene.cycles.pixel_filter_type = 'BLACKMAN_HARRIS'
    if hasattr(scene.cycles, "volume_biased"):
        scene.cycles.volume_biased = True
    scene.render.image_settings.file_format, scene.render.image_settings.color_depth = 'OPEN_EXR', '32'
    return scene, here.collections[0]


scene, collection = empty_file(False)
for thing in collection.all_objects:
    if thing.type == 'VOLUME':
        thing.data.filepath = bpy.path.relpath(os.path.join(os.path.dirname(path), os.path.basename(thing.data.filepath)))
scene, frame = prepared()
same("appended", picture(scene), fresh)

scene, collection = empty_file(True)
scene, frame = prepared()
same("linked", picture(scene), fresh)
bpy.ops.wm.save_mainfile()
bpy.ops.wm.open_mainfile(filepath=bpy.data.filepath)
same("linked_saved_and_opened", picture(bpy.context.scene), fresh)

scene, collection = empty_file(True)
scene, frame = prepared()
override = collection.override_hierarchy_create(scene, bpy.context.view_layer)
scene.collection.children.unlink(collection) if collection.name in scene.collection.children and override != collection else None
own = next(thing for thing in override.all_objects if "level" in thing)
scene.camera = next(thing for thing in override.all_objects if thing.type == 'CAMERA')
own["level"] = 1
own.update_tag()
same("library_override_of_the_level", picture(scene), coarse)
bpy.ops.wm.save_mainfile()
bpy.ops.wm.open_mainfile(filepath=bpy.data.filepath)
own = next(thing for thing in bpy.data.objects if "level" in thing and thing.override_library)
say("which_is_saved", own["level"] == 1, own["level"])
same("and_shown_again", picture(bpy.context.scene), coarse)
own["physical"] = 1
own.update_tag()
shows("the_material_can_be_overridden", picture(bpy.context.scene), coarse)

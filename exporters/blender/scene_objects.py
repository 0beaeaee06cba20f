# SPDX-License-Identifier: GPL-3.0-or-later
"""Volumes, camera, render settings, pictures, and the calibration of grid positions.

Joined with the other scripts of this folder into one (exporters/blender/run.c): build_scene.py is its last part."""
import os
import sys

import bpy
import numpy
from mathutils import Matrix, Vector

# ---- objects ---------------------------------------------------------------------------------------------------


def volume_object(name, path, collection):
    data = bpy.data.volumes.new(name)
    data.filepath = path
    data.render.space = 'WORLD'  # 'OBJECT' uses the smallest component of the rotated step, which may be near 0
    data.render.precision = 'FULL'  # Cycles with NanoVDB would use half floats
    data.render.clipping = 0.0  # otherwise the shader does not see small values
    thing = bpy.data.objects.new(name, data)
    collection.objects.link(thing)
    return thing


def give_material(thing, look):
    """Links a material to the object, not to its data: the material depends on the suns, and a library override of data
    that depend on objects loses the folder of its grids."""
    thing.data.materials.append(None)
    thing.material_slots[0].link = 'OBJECT'
    thing.material_slots[0].material = look


def frame_object(about, collection):
    """Adds a wire box around the volume: it shows the extent and moves everything."""
    mesh = bpy.data.meshes.new(about["name"])
    m = Matrix(about["box_to_world"])
    corners = [m @ Vector((x, y, z, 1)) for z in (0, 1) for y in (0, 1) for x in (0, 1)]
    edges = [(a, a | bit) for a in range(8) for bit in (1, 2, 4) if not a & bit]
    mesh.from_pydata([c[:3] for c in corners], edges, [])
    thing = bpy.data.objects.new(about["name"], mesh)
    thing.display_type = 'WIRE'
    thing.hide_render = True
    collection.objects.link(thing)
    return thing


def camera_object(camera, collection):
    data = bpy.data.cameras.new("isoshade camera")
    data.sensor_fit = 'VERTICAL'
    if camera["orthographic"]:
        data.type = 'ORTHO'
        data.ortho_scale = 2 * camera["half_height"]
    else:
        data.lens = data.sensor_height / 2 / camera["half_height"]
    data.clip_start = camera["clip_start"]
    data.clip_end = camera["clip_end"]
    thing = bpy.data.objects.new("isoshade camera", data)
    right, up, forward, position = (camera[k] for k in ("right", "up", "forward", "position"))
    thing.matrix_world = Matrix([[right[i], up[i], -forward[i], position[i]] for i in range(3)] + [[0, 0, 0, 1]])
    collection.objects.link(thing)
    return thing


def set_samples(cycles, about):
    cycles.samples = about["samples"]
    cycles.seed = about["seed"]
    # One sample passes through the pixel's center, up to the resolution of the filter table, a thousandth of its width.
    cycles.pixel_filter_type = 'BLACKMAN_HARRIS'
    cycles.filter_width = 0.01 if about["samples"] == 1 else 1.5


def configure(scene, about):
    """Configures Cycles as an integrator of emission and absorption without noise."""
    scene.render.engine = 'CYCLES'
    cycles = scene.cycles
    set_device(cycles, about)
    set_samples(cycles, about)
    cycles.use_adaptive_sampling = False
    cycles.use_denoising = False
    cycles.max_bounces = 0
    cycles.volume_bounces = 0
    cycles.transparent_max_bounces = 1024
    cycles.sample_clamp_direct = 0
    cycles.sample_clamp_indirect = 0
    cycles.volume_step_rate = 1
    cycles.volume_preview_step_rate = 1
    cycles.volume_max_steps = about["max_steps"]
    if hasattr(cycles, "volume_biased"):
        cycles.volume_biased = True  # Blender 5: ray marching, not null scattering
    scene.render.resolution_x, scene.render.resolution_y = about["image"]
    scene.render.resolution_percentage = 100
    scene.render.use_compositing = False
    scene.render.use_sequencer = False
    scene.render.film_transparent = about["film_transparent"]
    scene.view_settings.view_transform = 'Standard'
    settings = scene.render.image_settings
    settings.file_format = 'OPEN_EXR'
    settings.color_mode = 'RGBA'
    settings.color_depth = '32'
    settings.exr_codec = 'ZIP'
    world = bpy.data.worlds.new("isoshade background")
    nodes = tree_of(world).nodes
    background = nodes.new('ShaderNodeBackground')
    sink = nodes.new('ShaderNodeOutputWorld')
    sink.location = (240, 0)
    world.node_tree.links.new(background.outputs["Background"], sink.inputs["Surface"])
    background.inputs["Color"].default_value = (*about["background"], 1)
    background.inputs["Strength"].default_value = 1
    scene.world = world


def render(scene, path):
    scene.render.filepath = path
    bpy.ops.render.render(scene=scene.name, write_still=True)
    if not os.path.exists(path):
        raise RuntimeError(f"Blender wrote no picture at {path}")


def report_peak():
    """Returns the peak memory of this process. (getrusage would include the parent's.)"""
    with open("/proc/self/status", encoding="utf-8") as status:
        for line in status:
            if line.startswith("VmHWM:"):
                print("isoshade: peak", 1024 * int(line.split()[1]), flush=True)


def render_frames(scene, frames):
    """Renders pictures that differ only in step, samples and seed; the scene stays."""
    volumes = [thing for thing in scene.objects if "isoshade_step" in thing]
    for number, frame in enumerate(frames):
        set_samples(scene.cycles, frame)
        for thing in volumes:
            thing.data.render.step_size = frame["step"]
            thing.update_tag()
        render(scene, frame["path"])
        print(f"isoshade: progress {0.3 + 0.7 * (number + 1) / len(frames):.3f} Blender", flush=True)


# ---- calibration -----------------------------------------------------------------------------------------------


def refuse(why):
    print("isoshade: calibration failed:", why, flush=True)
    sys.exit(8)


def refuse_black():
    """Reports a black picture of the volume. Blender 5 passes grids to Cycles only by NanoVDB, and no build option
    shows whether it is there: this picture does."""
    if bpy.app.version >= (5, 0, 0):
        version = ".".join(str(number) for number in bpy.app.version[:2])
        print(f"isoshade: shows no volumes: Blender {version} of this system is built without NanoVDB: Cycles shows no volumes",
              flush=True)
        sys.exit(8)
    refuse("Cycles does not render the calibration volume")


def emission_centroid(path):
    """Centroid of the red channel, in fractions of the picture from its center."""
    image = bpy.data.images.load(path)
    width, height = image.size
    pixels = numpy.array(image.pixels[:]).reshape(height, width, 4)[:, :, 0]
    bpy.data.images.remove(image)
    total = pixels.sum()
    if not total > 0:
        refuse_black()
    x = (pixels.sum(0) * (numpy.arange(width) + 0.5)).sum() / total / width - 0.5
    y = (pixels.sum(1) * (numpy.arange(height) + 0.5)).sum() / total / height - 0.5
    return x, y


def calibrate(about):
    """Measures voxel positions of this Blender: 0 if voxel i is centered at index i, 1/2 if at i + 1/2.

    Renders a small volume centered at 0 along z and along x; the measured shift must be one of the two."""
    scene = bpy.data.scenes.new("calibration")
    configure(scene, {"device": about["device"], "samples": 1, "seed": 0, "max_steps": 1024, "image": (24, 24), "film_transparent": True,
                      "background": (0, 0, 0)})
    thing = volume_object("calibration", about["vdb"], scene.collection)
    thing.data.render.step_size = 0.125
    paint = bpy.data.materials.new("calibration")
    tree = tree_of(paint)
    nodes, links = tree.nodes, tree.links
    density = nodes.new('ShaderNodeAttribute')
    density.attribute_name = "density"
    emission = nodes.new('ShaderNodeEmission')
    output = nodes.new('ShaderNodeOutputMaterial')
    links.new(socket(density.outputs, "Fac"), emission.inputs["Strength"])
    links.new(emission.outputs["Emission"], output.inputs["Volume"])
    thing.data.materials.append(paint)
    extent = 2.0 * about["size"]
    found = []
    for right, up, forward in (((1, 0, 0), (0, 1, 0), (0, 0, -1)), ((0, 1, 0), (0, 0, 1), (-1, 0, 0))):
        scene.camera = camera_object({
            "orthographic": True, "half_height": extent / 2, "clip_start": 1e-3, "clip_end": 10 * extent, "right": right,
            "up": up, "forward": forward, "position": [-2 * extent * a for a in forward]}, scene.collection)
        path = os.path.join(about["folder"], "calibration.exr")
        render(scene, path)
        found += [c * extent for c in emission_centroid(path)]
        os.remove(path)
        bpy.data.objects.remove(scene.camera)
    bpy.data.scenes.remove(scene)
    bpy.data.objects.remove(thing)
    shift = 0.5 if found[0] > 0.25 else 0.0
    if max(abs(f - shift) for f in found) > 0.02:
        refuse(f"the offset of voxels is {[round(f, 4) for f in found]}, must be 0 or 1/2")
    return shift

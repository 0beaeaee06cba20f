# SPDX-License-Identifier: GPL-3.0-or-later
"""Cycles' picture of baked grids, by what `export --for blender` says to set: blender -b -P baked_volume.py -- VDB SIDE.

Writes right.exr, and planted.exr of a density that is ten times too large, as of a wrong unit. The camera is that of the
scene in check_baked.sh: orthographic, along +y, 30 mm high, centered on the origin. Blender before 5.0 shows any OpenVDB file half a
voxel too far along each axis; the object stands back by that.
"""
import math
import os
import sys

import bpy

vdb, side = sys.argv[-2], int(sys.argv[-1])
bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene

volume = bpy.data.volumes.new("baked")
volume.filepath = os.path.abspath(vdb)
if hasattr(volume.render, "precision"):
    volume.render.precision = "FULL"
volume.render.clipping = 0
thing = bpy.data.objects.new("baked", volume)
scene.collection.objects.link(thing)
volume.grids.load()
if bpy.app.version < (5, 0, 0):
    thing.location = [-0.5 * h for h in (0.0012, 0.001, 0.0014)]
print("grids:", ",".join(sorted(grid.name for grid in volume.grids)))

material = bpy.data.materials.new("baked")
material.use_nodes = True
nodes, links = material.node_tree.nodes, material.node_tree.links
nodes.clear()
out = nodes.new("ShaderNodeOutputMaterial")
shader = nodes.new("ShaderNodeVolumePrincipled")
emission = nodes.new("ShaderNodeAttribute")
emission.attribute_name = "emission"
shader.inputs["Density Attribute"].default_value = "density"
shader.inputs["Density"].default_value = 1
shader.inputs["Color"].default_value = (0, 0, 0, 1)
shader.inputs["Absorption Color"].default_value = (0, 0, 0, 1)
shader.inputs["Emission Strength"].default_value = 1
links.new(emission.outputs["Color"], shader.inputs["Emission Color"])
links.new(shader.outputs["Volume"], out.inputs["Volume"])
volume.materials.append(material)

camera = bpy.data.cameras.new("camera")
camera.type = "ORTHO"
camera.ortho_scale = 0.030
camera.clip_start, camera.clip_end = 1e-4, 1
eye = bpy.data.objects.new("camera", camera)
eye.location = (0, -0.1, 0)
eye.rotation_euler = (math.pi / 2, 0, 0)
scene.collection.objects.link(eye)
scene.camera = eye

scene.render.engine = "CYCLES"
scene.cycles.device = "CPU"
scene.cycles.samples = 16
scene.cycles.use_adaptive_sampling = False
scene.cycles.use_denoising = False
scene.cycles.pixel_filter_type = "BOX"
scene.cycles.filter_width = 0.01
scene.cycles.volume_step_rate = 0.25
scene.cycles.volume_max_steps = 4096
scene.render.resolution_x = scene.render.resolution_y = side
scene.render.resolution_percentage = 100
scene.render.film_transparent = True
scene.render.threads_mode, scene.render.threads = "FIXED", 2
scene.render.image_settings.file_format = "OPEN_EXR"
scene.render.image_settings.color_depth = "32"
scene.render.image_settings.color_mode = "RGBA"
for name, density in (("right", 1), ("planted", 10)):
    shader.inputs["Density"].default_value = density
    scene.render.filepath = os.path.abspath(f"{name}.exr")
    bpy.ops.render.render(write_still=True)

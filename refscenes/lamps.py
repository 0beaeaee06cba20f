# SPDX-License-Identifier: GPL-3.0-or-later
"""A volume of `isoshade export --material physical` under three lights: its own sun, a blue area lamp from the left, the world."""
import math

import bpy
from mathutils import Vector

scene = bpy.context.scene
frame = next(thing for thing in bpy.data.objects if "physical" in thing)
frame["physical"] = 1
frame.update_tag()

corners = [frame.matrix_world @ vertex.co for vertex in frame.data.vertices]
middle = sum(corners, Vector()) / 8
size = max((corner - middle).length for corner in corners)

sun = bpy.data.objects["isoshade light 1"].data
sun.energy *= 2
sun.angle = math.radians(10)  # soft shadows
scene.world.node_tree.nodes["Light"].inputs["Color"].default_value = (0.6, 0.8, 1, 1)

lamp = bpy.data.lights.new("side", "AREA")
lamp.size = size
lamp.color = (0.3, 0.5, 1)
lamp.energy = 150 * size * size
side = bpy.data.objects.new("side", lamp)
side.location = middle + size * Vector((1.6, 1.2, 0.8))
side.rotation_euler = (side.location - middle).to_track_quat("Z", "Y").to_euler()
scene.collection.objects.link(side)

scene.cycles.samples = 32
scene.render.resolution_x = scene.render.resolution_y = 160
scene.render.image_settings.file_format = "JPEG"
scene.render.image_settings.quality = 92
scene.render.image_settings.color_mode = "RGB"
scene.render.filepath = "//brain_lit.jpg"
bpy.ops.render.render(write_still=True)

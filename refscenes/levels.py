# SPDX-License-Identifier: GPL-3.0-or-later
# Renders each level of a .blend that isoshade exported:  blender -b brain.blend -P levels.py
import bpy

scene = bpy.context.scene
frame = next(thing for thing in bpy.data.objects if "level" in thing)
scene.render.image_settings.file_format = "PNG"
scene.render.image_settings.color_depth = "8"
scene.render.image_settings.color_mode = "RGB"
scene.render.use_stamp_filename = False # a PNG of Blender's carries the path of its .blend
for level in range(3):
    frame["level"] = level
    frame.update_tag()
    scene.render.filepath = f"//brain_level_{level}.png"
    bpy.ops.render.render(write_still=True)

# SPDX-License-Identifier: GPL-3.0-or-later
"""What an exported file shows when it is opened (EEVEE), against Cycles, at its levels. Run by Blender on it for
check_preview.sh; a line "ok NAME" or "not ok NAME: why" each.

blender -b NAME.blend -P preview.py -- PIXELS [SAMPLES]     16 samples: a window that has come to rest"""
import math
import sys

import bpy
import numpy

scene = bpy.context.scene
frame = next(thing for thing in scene.objects if "level" in thing)
levels = sorted(int(thing["isoshade_level"]) for thing in frame.children if "isoshade_level" in thing)
lookups = [node for tree in bpy.data.node_groups for node in tree.nodes
           if node.bl_idname == 'ShaderNodeTexImage' and node.interpolation == 'Closest' and node.image.name.startswith("isoshade transfer")]
LIMIT = 0.04  # EEVEE blurs edges by its grid of 4 x 4 pixels


def picture(engine):
    scene.render.engine = engine
    scene.render.filepath = "//preview.exr"
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(scene.render.filepath)
    pixels = numpy.array(image.pixels[:]).reshape(*image.size, 4)[:, :, :3]
    bpy.data.images.remove(image)
    return pixels


def apart(a, b):
    return math.sqrt(((a - b) ** 2).mean())


exec(bpy.data.texts["isoshade agreement"].as_string(), {})
size, samples = ([int(number) for number in sys.argv[sys.argv.index("--") + 1:]] + [2])[:2]
scene.render.resolution_x = scene.render.resolution_y = size
scene.eevee.taa_render_samples = samples
eevee = 'BLENDER_EEVEE_NEXT' if (4, 2, 0) <= bpy.app.version < (5, 0, 0) else 'BLENDER_EEVEE'
for level in levels:
    frame["level"] = level
    frame.update_tag()
    exact, opened = picture('CYCLES'), picture(eevee)
    off = apart(opened, exact)
    print(f"row {bpy.app.version_string} level {level} {off:.3g}", flush=True)
    print("ok" if off < LIMIT else "not ok", f"level_{level}_opens_as_it_renders: RMSE {off:.3g}, limit {LIMIT}", flush=True)
    if level == levels[1]:
        scene.eevee.volumetric_tile_size = '2'
        finer = apart(picture(eevee), exact)
        scene.eevee.volumetric_tile_size = '4'
        print("ok" if finer < 0.85 * off else "not ok", f"cells_of_EEVEE_are_the_cause: RMSE {finer:.3g} with 2 pixels",
              flush=True)
for node in lookups:  # planted: lookups that EEVEE filters over the whole table
    node.interpolation = 'Linear'
worse = apart(picture(eevee), exact)
print("ok" if len(lookups) == 2 and worse > 1.5 * off else "not ok", f"a_filtered_table_is_seen: RMSE {worse:.3g}", flush=True)

/* SPDX-License-Identifier: MIT */
/* cast_scene.h - the parts of an iso_cast that do not depend on where the voxels are; private to src/render/cpu. */
#ifndef ISO_RENDER_CPU_CAST_SCENE_H
#define ISO_RENDER_CPU_CAST_SCENE_H

#include "render/cpu/cast.h"
#include "render/cpu/caster.h"

void iso_cast_set_camera(iso_cast *c, const iso_geometry *g, const iso_view *view, double step_mm);
void iso_cast_set_light(iso_cast *c, const iso_view *view);
/* unit: what one of the bricks' values is; they begin at min, the level's least one. After the camera. Returns the entries,
 * to be freed, and their bytes; NULL when memory ends. */
float *iso_cast_set_tf(iso_cast *c, const iso_view *view, double min, double unit, size_t *bytes);
/* Are the level's scalars kept as integers of 16 bits? */
bool iso_cast_takes_integers(const iso_level *level);
/* NULL where this machine has not that many rays at once. */
iso_cast_paged_tile *iso_cast_paged_tile_of(iso_cpu_width width);

#endif

/* SPDX-License-Identifier: MIT */
/* cast_scene.h - the parts of an iso_cast that do not depend on where the voxels are; private to src/render/cpu. */
#ifndef ISO_RENDER_CPU_CAST_SCENE_H
#define ISO_RENDER_CPU_CAST_SCENE_H

#include "render/cpu/cast.h"
#include "render/cpu/cast_bricks.h"
#include "render/cpu/caster.h"

void iso_cast_set_camera(iso_cast *c, const iso_geometry *g, const iso_view *view, double step_mm);
void iso_cast_set_light(iso_cast *c, const iso_view *view);
/* unit: what one of the bricks' values is; they begin at min, the level's least one. After the camera. Returns the entries,
 * to be freed, and their bytes; NULL when memory ends. */
float *iso_cast_set_tf(iso_cast *c, const iso_view *view, double min, double unit, size_t *bytes);
/* How the level's scalars are kept, and what one of what is kept is. */
iso_cast_scalars iso_cast_scalars_of(const iso_level *level);
double iso_cast_unit(const iso_cast_scalars *scalars);
/* NULL where this machine has not that many rays at once. */
iso_cast_paged_tile *iso_cast_paged_tile_of(iso_cpu_width width);

#endif

/* SPDX-License-Identifier: MIT */
/* cast_scene.h - the parts of an iso_cast that do not depend on where the voxels are; private to src/render/cpu. */
#pragma once

#include "render/cpu/cast.h"
#include "render/cpu/cast_bricks.h"
#include "render/cpu/caster.h"
#include "render/screen_reach.h"

enum { ISO_CAST_MOST_ARRAYS = 9 };

struct iso_cpu_scene {
    iso_cast cast;
    iso_cast_tile *tile;
    int threads;
    double bytes;
    size_t array_count;
    void *arrays[ISO_CAST_MOST_ARRAYS]; /* what cast points to, to be freed */
    iso_screen_reach reach;
    struct iso_cast_maker *maker; /* or NULL */
};

/* Creates an empty scene for a width and threads. Release it after a failure, too. ISO_E_MEMORY, ISO_E_RANGE. */
iso_status iso_cast_begin(iso_cpu_scene **scene, iso_cpu_width width, int threads, iso_error *err);
/* Passes the array to the scene, which frees it. ISO_E_MEMORY if it is NULL. */
iso_status iso_cast_own(iso_cpu_scene *s, void *array, size_t bytes, iso_error *err);
/* Leaves out empty blocks, and takes the arrays of b. Call it after iso_cast_set_camera(). ISO_E_MEMORY. */
iso_status iso_cast_use_blocks(iso_cpu_scene *s, const iso_geometry *g, const iso_view *view, iso_cast_blocks *b,
                               iso_error *err);
/* Calls iso_cast_set_tf(); the scene owns the entries. */
iso_status iso_cast_own_tf(iso_cpu_scene *s, const iso_view *view, double min, double unit, iso_error *err);

void iso_cast_set_camera(iso_cast *c, const iso_geometry *g, const iso_view *view, double step_mm);
/* Sets normals from codes, or none without light. */
void iso_cast_set_code(iso_cast *c, iso_code code, bool is_lit);
void iso_cast_set_light(iso_cast *c, const iso_view *view);
/* Sets the transfer function; call it after iso_cast_set_camera(). unit: value of one step of the bricks' scalars,
 * which begin at min, the level's least value. Returns the entries, which the caller frees, and their bytes; NULL: out
 * of memory. */
float *iso_cast_set_tf(iso_cast *c, const iso_view *view, double min, double unit, size_t *bytes);
/* Returns the format of the level's scalars in the caster, or the size of one unit. */
iso_cast_scalars iso_cast_scalars_of(const iso_level *level);
double iso_cast_unit(const iso_cast_scalars *scalars);
/* Returns the function of a width; NULL if this machine does not support it. */
iso_cast_paged_tile *iso_cast_paged_tile_of(iso_cpu_width width);

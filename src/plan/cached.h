/* SPDX-License-Identifier: MIT */
/* cached.h - renders a volume in bricks that fit a cache of a given size, as fine as fits with the least predicted
 * error; or in the fewest nodes for a given predicted error. */
#pragma once

#include "render/gl/bricks_gl.h"
#include "plan/plan.h"

typedef struct iso_cached_report {
    double cache_bytes, predicted_rmse; /* bytes used; predicted difference to all bricks at level 0 */
    size_t bricks_by_level[ISO_BRICK_MAX_LEVELS], brick_count, page_count;
    size_t node_count; /* of the bricks drawn */
    double seconds;
    iso_gl_stats draws; /* of the CPU ray caster, too */
} iso_cached_report;

typedef struct iso_cached_options {
    double cache_bytes; /* limit for the textures of scalars and directions; or, when it is 0, */
    double plan_error;  /* the predicted RMSE that bricks may be coarsened for (plan/plan.h) */
    size_t brick_voxels, level_count, page_side; /* page_side 0: what GL takes */
    double step_voxels;                          /* 0: the view's */
    size_t repeats;                              /* draws, and until when, as in iso_gl_options */
    double repeat_seconds;
    bool processor_time; /* of the CPU ray caster; GL has iso_gl_time_processor() */
    int threads;
    iso_cached_report *report; /* filled; or NULL */
} iso_cached_options;

/* Renders with OpenGL, or with the CPU ray caster if gl is NULL, whose bricks need no textures: 8 bytes per node, 2
 * without light. Chooses levels as in plan.h, for the least predicted error that fits; renders nothing to choose them.
 * ISO_E_RANGE with the needed size if the coarsest levels do not fit. */
iso_status iso_cached_render(iso_gl *gl, const iso_level *level0, const iso_view *view, const iso_cached_options *opt,
                             iso_image *image, const iso_progress *progress, iso_error *err);

/* Does the same with the caller's rounded nodes and plan of this view, which replace the options for bricks and
 * levels. */
iso_status iso_cached_render_nodes(iso_gl *gl, const iso_node_levels *nodes, iso_plan_errors *plan,
                                   const iso_view *view, const iso_cached_options *opt, iso_image *image,
                                   iso_error *err);

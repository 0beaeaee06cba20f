/* SPDX-License-Identifier: MIT */
/* scene_levels.h - the scalars of coarse levels that show one scene best.
 *
 * Each coarse level has candidates (fit/level_scalar.h): the pyramid's filter, least squares, and from level
 * ISO_SCENE_FITTED_FROM on the scalar that is fitted to the scene's transfer function. A last candidate is optimized
 * from the best of them (optimize.h), and has to pass level_gate.h, too. They are judged by small
 * pictures with the scene's lights, shading, clip planes and ray step, along the twelve lines of small_views.h,
 * rendered by the reference's midpoint sums. Each candidate is shown under the transfer function of --adapt (adapt.h).
 * The candidate whose pictures are nearest to those of level 0 is taken.
 *
 * Neither the error at the voxels nor pictures without light are enough to choose by. For a shell in steep gradients,
 * the fit reduces the error at the voxels to a quarter. Its pictures, in steps as long as a level's, nevertheless have
 * 1.5 times the error.
 *
 * The choice and its figures are written to p->made_for (doc/reference/files-pyramid.md). */
#ifndef ISO_SCENE_LEVELS_H
#define ISO_SCENE_LEVELS_H

#include "fit/level_scalar.h"
#include "plan/level_gate.h"
#include "plan/optimize.h"
#include "scene/scene.h"
#include "tf/small_views.h"

enum { ISO_SCENE_LEVELS_PIXELS = 64, ISO_SCENE_FITTED_FROM = 2 };

/* How far the pictures of a candidate are from level 0's. */
typedef struct iso_level_candidate {
    bool tried;
    bool adapted;                          /* its transfer function */
    double of_view[ISO_SMALL_VIEWS_COUNT]; /* 1 - SSIM over the visible part */
    double ssim_dissimilarity, rmse;       /* means */
} iso_level_candidate;

typedef struct iso_scene_level {
    iso_level_scalar chosen;
    iso_level_candidate candidates[ISO_LEVEL_SCALAR_COUNT];
    iso_fit_report fit;
    struct iso_scene_level_optimized {
        bool tried;
        size_t views, pixels, steps;
        double error_first, error;
        iso_level_gate gate;
    } optimized;
    double seconds; /* with looking */
} iso_scene_level;

/* A candidate replaces one before it in the enum under three conditions: its 1 - SSIM is less by this part of it, its
 * RMSE is not more by ISO_SCENE_RMSE_LOSS, and no view is farther by ISO_ADAPT_WORST_VIEW. Smaller differences are not
 * significant. */
#define ISO_SCENE_LEVELS_GAIN 0.02
#define ISO_SCENE_RMSE_LOSS 0.15
iso_level_scalar iso_scene_level_choose(const iso_level_candidate candidates[ISO_LEVEL_SCALAR_COUNT]);

/* Renders `level` with the scalars of each candidate (NULL: skipped) and fills the candidate's other fields. */
iso_status iso_scene_level_judge(const iso_pyramid *p, size_t level, const iso_scene *scene,
                                 float *const scalars[ISO_LEVEL_SCALAR_COUNT], int threads,
                                 iso_level_candidate candidates[ISO_LEVEL_SCALAR_COUNT], iso_error *err);

/* Replaces the scalars of levels first to p->level_count - 1 by those chosen, with their ranges, and sets p->made_for.
 * Optimized levels have other directions, too. optimize: NULL: no such candidate; level k takes its seed + k. levels:
 * as many as p has, or NULL. ISO_E_RANGE: the transfer function shows nothing that a fit could improve.
 * ISO_E_MEMORY. */
iso_status iso_scene_levels_make(iso_pyramid *p, size_t first, const iso_scene *scene,
                                 const iso_optimize_options *optimize, int threads, iso_scene_level *levels,
                                 const iso_progress *progress, iso_error *err);

/* Returns the bytes that a build for a scene needs, with the volume of `type` and the pyramid. */
size_t iso_scene_levels_bytes(const iso_geometry *level0, iso_type type, iso_effort effort);

#endif

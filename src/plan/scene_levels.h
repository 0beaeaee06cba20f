/* SPDX-License-Identifier: MIT */
/* scene_levels.h - coarse levels that show one scene best, or several of one study.
 *
 * Each coarse level has candidates (iso_level_ways): scalars (fit/level_scalar.h) under the transfer function of
 * --adapt (tf/adapt.h), or always adapted and with an extinction scale (fit/extinction_scale.h). Pictures with the
 * scene's shading, clip planes and ray step decide (level_gate.h): the nearest one is taken. From there a last
 * candidate is optimized (optimize.h).
 *
 * Neither the error at the voxels nor pictures without light are enough to choose by. For a shell in steep gradients,
 * the fit reduces the error at the voxels to a quarter. Its pictures, in steps as long as a level's, nevertheless have
 * 1.5 times the error.
 *
 * A level for several scenes has one scalar and one extinction scale (the geometric mean of the scenes'), and in each
 * scene a transfer function of its own. Ways are compared in each scene with the best one for that scene alone, and the
 * way of the least largest ratio is taken.
 *
 * The choice, its transfer functions and its figures are written to p->made_for (doc/reference/files-pyramid.md). */
#pragma once

#include "fit/level_scalar.h"
#include "plan/level_gate.h"
#include "plan/optimize.h"
#include "scene/scene.h"

enum { ISO_SCENE_FITTED_FROM = 2 }; /* level */

/* Ways to make and show a level. A scaled one is always adapted, as by --adapt --extinction-scale. */
typedef struct iso_level_way {
    iso_level_scalar scalar;
    bool scaled;
} iso_level_way;
enum { ISO_LEVEL_WAY_BUILT, ISO_LEVEL_WAY_OPTIMIZED = 7, ISO_LEVEL_WAY_COUNT };
extern const iso_level_way iso_level_ways[ISO_LEVEL_WAY_COUNT];

/* How near a way is to level 0. */
typedef struct iso_level_candidate {
    bool tried;
    bool adapted; /* its transfer function */
    iso_level_seen seen;
} iso_level_candidate;

typedef struct iso_scene_level {
    int chosen;                                                           /* of iso_level_ways */
    iso_level_candidate candidates[ISO_SCENES_MOST][ISO_LEVEL_WAY_COUNT]; /* in each scene */
    iso_level_seen best[ISO_SCENES_MOST];                                 /* way but the last, for each scene alone */
    bool judged_edits, edits_are_scaled;                                  /* iso_level.edits_are_scaled */
    /* 1 - SSIM after each edit: as built with --adapt, and the optimized level. */
    double edited_built[ISO_SCENES_MOST][ISO_LEVEL_GATE_EDITS], edited[ISO_SCENES_MOST][ISO_LEVEL_GATE_EDITS],
        edited_rounding[ISO_SCENES_MOST][ISO_LEVEL_GATE_EDITS]; /* iso_level_gate.rounding */
    iso_fit_report fit;
    struct iso_scene_level_optimized {
        bool tried;
        size_t views, pixels, steps;
        double rate, error_first, error;
    } optimized;
    double seconds; /* with looking */
} iso_scene_level;

/* Returns the nearest of the ways but the last that are better than the level as built (level_gate.h), which comes
 * first. */
int iso_scene_level_choose(const iso_level_candidate candidates[ISO_LEVEL_WAY_COUNT]);

/* Returns the 1 - SSIM of the level in a scene, as a part of that of the best way but the last for this scene alone. */
double iso_scene_level_ratio(const iso_scene_level *made, size_t scene);

/* True if after no edit the optimized level is worse than the one as built (iso_level_gate_stands). */
bool iso_scene_level_stands_edits(const iso_scene_level *made, size_t scene_count);

/* Shows `level` with the scalars of each kind (NULL: skipped) in all ways but the last, and fills the candidates. */
iso_status iso_scene_level_judge(const iso_pyramid *p, size_t level, const iso_scene *scene,
                                 float *const scalars[ISO_LEVEL_SCALAR_COUNT], int threads,
                                 iso_level_candidate candidates[ISO_LEVEL_WAY_COUNT], iso_error *err);

/* Replaces levels first to p->level_count - 1 by those chosen for 1 to ISO_SCENES_MOST scenes, with their ranges and
 * extinction scales, and sets p->made_for. Optimized levels have other directions, too. optimize: NULL: no such
 * candidate; its rate and scene_count are not read; level k takes its seed + k. levels: as many as p has, or NULL.
 * ISO_E_USAGE: two scenes have the same transfer function. ISO_E_RANGE: the transfer function shows nothing that a fit
 * could improve. ISO_E_MEMORY. */
iso_status iso_scene_levels_make(iso_pyramid *p, size_t first, const iso_scene *scenes, size_t scene_count,
                                 const iso_optimize_options *optimize, int threads, iso_scene_level *levels,
                                 const iso_progress *progress, iso_error *err);

/* Returns the bytes that a build for scenes needs, with the volume of `type` and the pyramid. */
size_t iso_scene_levels_bytes(const iso_geometry *level0, iso_type type, size_t scene_count, iso_effort effort);

/* SPDX-License-Identifier: MIT */
/* level_gate.h - judges an optimized level (optimize.h) against the best one that filters and fits give.
 *
 * Pictures in directions and lights that were not trained on, with pixels of about a fine voxel; and the same averaged
 * down, so that a pixel is a coarse voxel. The optimized level is accepted if its mean 1 - SSIM is lower by
 * ISO_LEVEL_GATE_GAIN and its RMSE is not higher, in both. */
#ifndef ISO_PLAN_LEVEL_GATE_H
#define ISO_PLAN_LEVEL_GATE_H

#include "pyramid/pyramid.h"
#include "scene/scene.h"

#define ISO_LEVEL_GATE_GAIN 0.02
enum { ISO_LEVEL_GATE_VIEWS = 8 };

typedef struct iso_level_seen {
    double ssim_dissimilarity, rmse, small_ssim_dissimilarity, small_rmse;
} iso_level_seen;

typedef struct iso_level_gate {
    iso_level_seen today, optimized;
    bool accepts;
} iso_level_gate;

/* A level, and the transfer function that shows it. */
typedef struct iso_level_with_tf {
    const iso_level *level;
    const iso_tf_table *tf; /* NULL: the scene's */
} iso_level_with_tf;

/* Draws level 0 and both levels. ISO_E_MEMORY. */
iso_status iso_level_gate_judge(const iso_pyramid *p, size_t level, const iso_scene *scene,
                                const iso_level_with_tf *today, const iso_level *optimized, int threads,
                                iso_level_gate *gate, iso_error *err);

/* True if b is nearer than a by the rule above. */
bool iso_level_gate_is_nearer(const iso_level_seen *a, const iso_level_seen *b);

#endif

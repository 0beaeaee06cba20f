/* SPDX-License-Identifier: MIT */
/* small_views.h - what transfer functions make of a coarse level, seen: a few small pictures of it against level 0.
 *
 * Orthographic views that frame the box, along (2, 2, 1) in all orders of its numbers and with all signs: twelve lines,
 * none along an axis of the world and none of those that benchmarks look along (scene/views.h). Rays take a sample a voxel of level 0 (the smallest
 * spacing) in the middle of each step, classify after filtering as renderers do, and stop where every picture is opaque.
 * No light: what a transfer function changes is color and opacity, and a picture without light shows all of it.
 *
 * Cost: 12 * 64^2 rays at most, each of as many samples as it crosses voxels; so by the voxel of level 0 it falls with
 * the square of the volume's size. Results do not depend on threads. */
#ifndef ISO_TF_SMALL_VIEWS_H
#define ISO_TF_SMALL_VIEWS_H

#include "image/image.h"
#include "pyramid/pyramid.h"
#include "tf/tf.h"
#include "tf/tf_2d.h"

#define ISO_SMALL_VIEWS_MAX_VOXELS ((size_t)1 << 28) /* of a level 0 that is looked at */
enum { ISO_SMALL_VIEWS_COUNT = 12, ISO_SMALL_VIEWS_PIXELS = 64, ISO_SMALL_VIEWS_MAX_TFS = 4 };

typedef struct iso_small_views_error {
    double of_view[ISO_SMALL_VIEWS_COUNT]; /* 1 - SSIM, as compare/ssim.h */
    double ssim_dissimilarity;             /* their mean */
    double rmse;                           /* of linear color, over all views */
    double ghost;                          /* with a mask: what is seen where level 0 shows nothing (tf/ghost.h) */
} iso_small_views_error;

/* What is seen of each entry of a table, over all pixels, in units of ISO_SMALL_VIEWS_UNIT: where level 0 shows nothing,
 * and everywhere. Integers, which come out alike whatever thread adds what. */
#define ISO_SMALL_VIEWS_UNIT 0x1p-32
typedef struct iso_small_views_rows {
    int64_t *ghost, *seen; /* of as many entries as the last of `tfs` has; zeros before */
} iso_small_views_rows;

/* Level 0 as the views show it through the original transfer function: half of the work, and the same for all levels. Begins
 * as {0}; the first comparison draws it. */
typedef struct iso_small_views_fine {
    bool is_drawn;
    iso_image views[ISO_SMALL_VIEWS_COUNT];
    int64_t shown; /* opacity over all pixels, in units of ISO_SMALL_VIEWS_UNIT */
} iso_small_views_fine;
void iso_small_views_fine_destroy(iso_small_views_fine *fine);

/* What is compared: level 0 through `original` is what `coarse` should look like through each of `tfs`. */
typedef struct iso_small_views_input {
    const iso_level *fine, *coarse; /* with their scalars */
    size_t level;                   /* of the coarse one */
    const iso_tf_table *original;
    const iso_tf_table *tfs[ISO_SMALL_VIEWS_MAX_TFS]; /* of the coarse level */
    const iso_tf_2d *tfs_2d[ISO_SMALL_VIEWS_MAX_TFS]; /* instead of the one above, or NULL */
    const float *octaves[ISO_SMALL_VIEWS_MAX_TFS];    /* log2 of what scales the extinction, a coarse voxel each, or NULL */
    size_t tf_count;
    const uint8_t *empty;             /* of the coarse level: whether level 0 shows nothing there (tf/ghost.h), or NULL */
    const iso_small_views_rows *rows; /* of the last of `tfs`, with a mask; or NULL */
    iso_small_views_fine *kept;       /* of this `fine` and `original`; or NULL */
    int threads;
} iso_small_views_input;

/* Along which view i looks, a unit vector of the world. */
iso_vec3 iso_small_views_direction(int view);

/* ISO_E_MEMORY. */
iso_status iso_small_views_compare(const iso_small_views_input *in,
                                   iso_small_views_error errors[ISO_SMALL_VIEWS_MAX_TFS], iso_error *err);

#endif

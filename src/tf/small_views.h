/* SPDX-License-Identifier: MIT */
/* small_views.h - comparison of a coarse level through transfer functions with level 0 by a few small pictures.
 *
 * Orthographic views that frame the box, along (2, 2, 1) in all orders of its numbers and with all signs: twelve lines,
 * none along an axis of the world or along a view of the benchmarks (scene/views.h). Rays take one sample per voxel of
 * level 0 (the smallest spacing) in the middle of each step, classify after filtering like the renderers, and stop when
 * all pictures are opaque. No light: transfer functions change color and opacity, which unlit pictures show best.
 *
 * Cost: at most 12 * 64^2 rays, with one sample per crossed voxel; so the cost per voxel of level 0 falls with the
 * square of the volume's size. Results do not depend on the number of threads. */
#pragma once

#include "image/image.h"
#include "pyramid/pyramid.h"
#include "tf/tf.h"
#include "tf/tf_2d.h"

#define ISO_SMALL_VIEWS_MAX_VOXELS ((size_t)1 << 28) /* largest accepted level 0 */
enum { ISO_SMALL_VIEWS_COUNT = 12, ISO_SMALL_VIEWS_PIXELS = 64, ISO_SMALL_VIEWS_MAX_TFS = 4 };

typedef struct iso_small_views_error {
    double of_view[ISO_SMALL_VIEWS_COUNT]; /* 1 - SSIM, as compare/ssim.h */
    double ssim_dissimilarity;             /* their mean */
    double rmse;                           /* of linear color, over all views */
    double ghost;                          /* with a mask: opacity seen in empty voxels (tf/ghost.h) */
    double lost; /* part of level 0's opacity, over all pixels, that is missing where the level is less opaque */
} iso_small_views_error;

/* Visible opacity due to each entry of a table, summed over all pixels, in units of ISO_SMALL_VIEWS_UNIT: in empty
 * voxels, and in all. Integers, so that the sums do not depend on thread order. */
#define ISO_SMALL_VIEWS_UNIT 0x1p-32
typedef struct iso_small_views_rows {
    int64_t *ghost, *seen; /* one per entry of the last of `tfs`; set to 0 by the caller */
} iso_small_views_rows;

/* Views of level 0 through the original transfer function: half of the work, and the same for all levels. Starts as
 * {0}; the first comparison draws it. */
typedef struct iso_small_views_fine {
    bool is_drawn;
    iso_image views[ISO_SMALL_VIEWS_COUNT];
    int64_t shown; /* sum of opacity over all pixels, in units of ISO_SMALL_VIEWS_UNIT */
} iso_small_views_fine;
void iso_small_views_fine_destroy(iso_small_views_fine *fine);

/* A voxel of a mask: level 0 shows nothing visible there, or nothing at all, so that its samples need no reading. */
enum { ISO_GHOST_EMPTY = 1, ISO_GHOST_CLEAR = 2 };

/* Input: `coarse` through each of `tfs` is compared with level 0 through `original`. */
typedef struct iso_small_views_input {
    const iso_level *fine, *coarse; /* with their scalars */
    size_t level;                   /* number of the coarse level */
    const iso_tf_table *original;
    const iso_tf_table *tfs[ISO_SMALL_VIEWS_MAX_TFS]; /* of the coarse level */
    const iso_tf_2d *tfs_2d[ISO_SMALL_VIEWS_MAX_TFS]; /* instead of the one above, or NULL */
    const float *octaves[ISO_SMALL_VIEWS_MAX_TFS];    /* log2 of each coarse voxel's extinction scale, or NULL */
    size_t tf_count;
    const uint8_t *empty;             /* mask of the coarse voxels (tf/ghost.h), or NULL */
    const iso_small_views_rows *rows; /* output for the last of `tfs`, needs `empty`; or NULL */
    iso_small_views_fine *kept;       /* views of this `fine` and `original`; or NULL */
    int threads;
} iso_small_views_input;

/* Compares; errors[i] belongs to tfs[i]. ISO_E_MEMORY. */
iso_status iso_small_views_compare(const iso_small_views_input *in,
                                   iso_small_views_error errors[ISO_SMALL_VIEWS_MAX_TFS], iso_error *err);

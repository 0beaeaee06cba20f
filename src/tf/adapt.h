/* SPDX-License-Identifier: MIT */
/* adapt.h - transfer functions that adapt to a level.
 *
 * Paper: [diaz-garcia-2016], Eq. 7: entry s of TF_k is the mean of TF_0(z) along
 * row s of the joint histogram (histogram.h), weighted by the counts and by a
 * window about the row's mean:
 *
 *     TF_k(s) = 1/K sum_z TF_0(z) H_k(z, s) w((z - mean_s) / deviation_s)
 *
 * Weights (x in deviations of the row, which are floored at half a bin):
 *     gauss      exp(-x^2 / 2) inside the window             the paper, window 3
 *     flat       1 inside the window                         default, window 1.75
 *     triangle   .4 (1 - .4 |x|)                             sec. 5, window 2.5
 *     mixed      mix_s C + mix_t T + (1 - mix_s - mix_t) G, each of unit area
 *                over [-2.5, 2.5]                            sec. 5, window 2.5
 * Averaged quantity, with sigma the extinction and a = 1 - exp(-sigma length):
 *     rgba          color and a, each by itself             the paper
 *     opacity       a; color weighted by a                  default, length = level-0 spacing
 *     extinction    sigma; color weighted by sigma
 *     transmittance as opacity over the length sqrt(h_0 h_k), h the spacings
 * The result is converted back to an extinction, so it depends on no length. It never exceeds
 * the largest extinction of its row.
 *
 * Rows without fine voxels are interpolated linearly between their filled neighbors on
 * premultiplied entries; beyond the outermost filled row its copy is used. A histogram
 * without entries leaves the TF unchanged. A row with one entry takes TF_0 there. A row
 * without opacity keeps the mean color and extinction 0.
 *
 * An adapted table has one entry per row, so its range is that of the values. If each voxel
 * of a level has a single fine value, the TF is unchanged at these values. */
#pragma once

#include "tf/histogram.h"
#include "tf/small_views.h"
#include "tf/tf.h"
#include "tf/tf_2d.h"

typedef enum iso_adapt_weight {
    ISO_WEIGHT_GAUSS,
    ISO_WEIGHT_FLAT,
    ISO_WEIGHT_TRIANGLE,
    ISO_WEIGHT_MIXED,
    ISO_WEIGHT_COUNT
} iso_adapt_weight;
typedef enum iso_adapt_average {
    ISO_AVERAGE_RGBA,
    ISO_AVERAGE_OPACITY,
    ISO_AVERAGE_EXTINCTION,
    ISO_AVERAGE_TRANSMITTANCE,
    ISO_AVERAGE_COUNT
} iso_adapt_average;

enum { ISO_ADAPT_BITS = 8 }; /* of the joint histogram, by default */
typedef struct iso_adapt_options {
    iso_adapt_weight weight;
    iso_adapt_average average;
    double window;       /* in deviations; 0: the default of the weight */
    double mix_s, mix_t; /* for mixed: each at least 0, their sum at most 1 */
    int bits;            /* of the joint histogram: 8 to 16 */
    bool fall_back;      /* True if the original TF is kept when the judgment favors it */
    int threads;
    const char *folder; /* where iso_adapt_level() and iso_adapt_tf_2d() cache histograms; may be NULL */
    /* Small views of level 0, reused for all levels of one pyramid and TF; NULL: drawn for each level. */
    iso_small_views_fine *level_0;
} iso_adapt_options;
iso_adapt_options iso_adapt_defaults(void);

/* Weights of all rows, computed once per level: an edit of the TF then costs one pass over them. */
typedef struct iso_adapter iso_adapter;

/* Creates an adapter; joint may be destroyed afterwards. ISO_E_RANGE: options outside their limits; ISO_E_MEMORY. */
iso_status iso_adapter_create(const iso_joint *joint, const iso_adapt_options *opt, iso_adapter **adapter,
                              iso_error *err);
void iso_adapter_destroy(iso_adapter *adapter); /* accepts NULL */

/* Creates *table, to be destroyed by iso_tf_table_destroy(). level0: geometry whose spacing is the length; level: the
 * level of the adapter's histogram. ISO_E_MEMORY. */
iso_status iso_adapter_apply(const iso_adapter *adapter, const iso_tf_table *tf, const iso_geometry *level0,
                             size_t level, iso_tf_table *table, iso_error *err);
/* Updates a table that apply() made; allocates nothing but a scratch row. */
iso_status iso_adapter_update(const iso_adapter *adapter, const iso_tf_table *tf, const iso_geometry *level0,
                              size_t level, iso_tf_table *table, iso_error *err);

/* Judgment whether the adapted TF serves the level better than the original one.
 *
 * small_views.h draws the level through both. Distances to level 0 are 1 - SSIM and the RMSE. The adapted TF is taken
 * if one of these holds:
 *   - its 1 - SSIM is smaller by more than twice the standard error of the mean over the views, and its RMSE is not
 *     larger;
 *   - its RMSE is at most ISO_ADAPT_RMSE_GAIN of the original's, and its 1 - SSIM is larger by at most
 *     ISO_ADAPT_SSIM_LOSS, half of the loss allowed for a level.
 * No single view may lose more than ISO_ADAPT_WORST_VIEW. Otherwise, and if the views show nothing, the original is
 * kept. The standard error matters for thin flat objects, which look different from each side: one plate gained .03 in
 * twelve views and lost .03 in ten others.
 *
 * First, if an adapted TF draws more ghost than ISO_GHOST_LIMIT (ghost.h), the entries that cause it are given back. If
 * more than the limit remains, the original is kept.
 *
 * A prediction from H_k is unreliable. The error of Eq. 6 and Figure 7 is the rms, over all pairs of H_k, of the
 * differences of premultiplied color and opacity over the length of a level-0 voxel. It falls while the image gets
 * worse:
 *   - It weighs a voxel in front of black like one inside an opaque wall. But a haze of .003 per voxel before black is
 *     clearly visible and adds up along the ray: rms adds squares, pixels add emission.
 *   - Background rows have the most voxels, few of them at a surface. Their mean is right for the row as a whole, and
 *     wrong for the thousands of voxels that lie together.
 * It is computed all the same, and decides if level 0 has more voxels than ISO_SMALL_VIEWS_MAX_VOXELS or p is an
 * outline.
 *
 * The window already prevents most failures. If a tissue and a thin structure share a value, the tissue is the bulk of
 * the row and the structure is its tail; a tail beyond 1.75 deviations is cut off. A window of 3 deviations would light
 * the tissue up (doc/results/adaptive-tf.md). */
#define ISO_ADAPT_WORST_VIEW 0.02
#define ISO_ADAPT_RMSE_GAIN 0.75
#define ISO_ADAPT_SSIM_LOSS 0.005
typedef struct iso_adapt_judgment {
    double rms_original, rms_adapted; /* error of Eq. 6 at the voxels */
    iso_small_views_error seen_original, seen_adapted;
    bool seen;         /* True if the small views decided; otherwise the two above are empty */
    double ghost;      /* of the adapted TF after Eq. 7, before entries are given back (ghost.h) */
    size_t given_back; /* entries reset to the original extinction; seen_adapted is measured after it */
    bool use_original;
} iso_adapt_judgment;
/* True if the small views favor the adapted TF by the rule above; ghosts are not considered. */
bool iso_adapt_is_nearer(const iso_small_views_error *original, const iso_small_views_error *adapted);
/* Fills *judgment from the error at the voxels alone. */
iso_status iso_adapt_judge(const iso_joint *joint, const iso_tf_table *tf, const iso_tf_table *adapted,
                           const iso_geometry *level0, iso_adapt_judgment *judgment, iso_error *err);

/* Adapts `tf` to one level of a pyramid and judges the result. A level that was made for tf gets its own table
 * (level_look.h); level 0 gets a copy. One with edits_are_scaled is always adapted to another tf. judgment
 * may be NULL. */
iso_status iso_adapt_level(const iso_pyramid *p, size_t level, const iso_tf_table *tf, const iso_adapt_options *opt,
                           iso_tf_table *table, iso_adapt_judgment *judgment, iso_error *err);

/* Adapts the 2D transfer function (tf_2d.h) to `level`, for volumes in which one value stands for two materials. A few
 * voxels give an unreliable mean, so each row is averaged with the 1D transfer function at a weight of
 * ISO_TF_2D_PSEUDO_COUNTS voxels. level: at least 1; opt->bits: at most 12. ISO_E_RANGE, ISO_E_MEMORY. */
#define ISO_TF_2D_PSEUDO_COUNTS 16
#define ISO_TF_2D_WINDOW 3.0 /* of the flat weight, if opt->window is 0 */
iso_status iso_adapt_tf_2d(const iso_pyramid *p, size_t level, iso_second_value second, const iso_tf_table *tf,
                           const iso_adapt_options *opt, iso_tf_2d *out, iso_error *err);

/* Converts a table to a TF: one point per entry and an explicit range, so that tabulating it returns the same entries
 * up to rounding. ISO_E_MEMORY; ISO_E_RANGE beyond ISO_TF_MOST_EXTINCTION. */
iso_status iso_tf_from_table(const iso_tf_table *table, iso_tf *tf, iso_error *err);

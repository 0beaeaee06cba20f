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
 * What is averaged, with sigma the extinction and a = 1 - exp(-sigma length):
 *     rgba          color and a, each by itself             the paper
 *     opacity       a; color weighted by a                  default, length = level-0 spacing
 *     extinction    sigma; color weighted by sigma
 *     transmittance as opacity over the length sqrt(h_0 h_k), h the spacings
 * The result is an extinction again, so it depends on no length; it never exceeds
 * the largest extinction of its row.
 *
 * Rows that no fine voxel falls into are filled linearly between their filled
 * neighbors on premultiplied entries (beyond the outermost: its copy); a
 * histogram without entries leaves the TF as it is. A row of one entry takes
 * TF_0 there. A row without opacity keeps the mean color and extinction 0.
 *
 * An adapted table has an entry a row, so its range is that of the values. A
 * level whose voxels have one fine value each leaves the TF unchanged at them. */
#ifndef ISO_TF_ADAPT_H
#define ISO_TF_ADAPT_H

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

typedef struct iso_adapt_options {
    iso_adapt_weight weight;
    iso_adapt_average average;
    double window;       /* in deviations; 0: the weight's own */
    double mix_s, mix_t; /* of mixed: each at least 0, together at most 1 */
    int bits;            /* of the joint histogram: 8 to 16 */
    bool fall_back;      /* keep the original TF where the judgment says so */
    int threads;
    const char *folder; /* where iso_adapt_level() and iso_adapt_tf_2d() keep histograms (iso_joint_obtain), or NULL */
    /* Level 0's small views, kept from level to level of one pyramid and transfer function; or NULL: drawn for each. */
    iso_small_views_fine *level_0;
} iso_adapt_options;
iso_adapt_options iso_adapt_defaults(void);

/* The rows' weights, made once a level: an edit of the TF then costs one pass over them. */
typedef struct iso_adapter iso_adapter;

/* Copies what it needs of joint. ISO_E_RANGE: options outside their limits; ISO_E_MEMORY. */
iso_status iso_adapter_create(const iso_joint *joint, const iso_adapt_options *opt, iso_adapter **adapter,
                              iso_error *err);
void iso_adapter_destroy(iso_adapter *adapter); /* accepts NULL */

/* Entries of the tables that apply() fills. */
size_t iso_adapter_entry_count(const iso_adapter *adapter);
/* level0: its spacing is the length. level: whose histogram it is. *table is
 * created; destroy it with iso_tf_table_destroy(). ISO_E_MEMORY. */
iso_status iso_adapter_apply(const iso_adapter *adapter, const iso_tf_table *tf, const iso_geometry *level0,
                             size_t level, iso_tf_table *table, iso_error *err);
/* The same into a table that apply() made: nothing is allocated but a scratch row. */
iso_status iso_adapter_update(const iso_adapter *adapter, const iso_tf_table *tf, const iso_geometry *level0,
                              size_t level, iso_tf_table *table, iso_error *err);

/* Whether the adapted TF serves the level better than the original one.
 *
 * It is measured: small_views.h draws the level through both. The adapted TF is taken where it is nearer to level 0 by
 * 1 - SSIM, beyond twice the standard error of the mean over the views, and no farther by RMSE; or where its RMSE is at most
 * ISO_ADAPT_RMSE_GAIN of the original's, and 1 - SSIM is farther by no more than ISO_ADAPT_SSIM_LOSS, half of what a level may
 * lose. In no view may it be farther by more than ISO_ADAPT_WORST_VIEW. Otherwise the original is kept, and so it is where
 * the views show nothing. What is thin and flat looks different from each side: a plate gained .03 in twelve views and
 * lost .03 in ten others, hence the scatter.
 *
 * Before that, an adapted TF that draws more of a ghost than ISO_GHOST_LIMIT (ghost.h) has the entries given back that draw
 * it; where more is left, the original is kept.
 *
 * A prediction from H_k cannot tell. The rms over all pairs of H_k of the differences of premultiplied color and
 * opacity, over the length of a level-0 voxel (the error of Eq. 6 and Figure 7), falls while the image gets worse:
 *   - it weighs a voxel in front of black as one inside an opaque wall, but a haze of .003 a voxel before black is all
 *     that is seen, and adds up along the ray: rms adds squares, pixels add what is emitted;
 *   - rows of background have the most voxels, of which few lie at a surface: their mean is right for the row as a
 *     whole, and wrong for the thousands that lie together.
 * It is computed all the same: where level 0 has more voxels than ISO_SMALL_VIEWS_MAX_VOXELS, or p is an outline, it
 * judges.
 *
 * The window already prevents most failures: where a tissue shares its value with a
 * thin structure, the voxels of the tissue are the bulk of the row and the structure
 * is its tail, and a tail beyond 1.75 deviations is cut off. A window of 3 deviations
 * would light the tissue up (doc/results/adaptive-tf.md). */
#define ISO_ADAPT_WORST_VIEW 0.02
#define ISO_ADAPT_RMSE_GAIN 0.75
#define ISO_ADAPT_SSIM_LOSS 0.005
typedef struct iso_adapt_judgment {
    double rms_original, rms_adapted; /* at the voxels */
    iso_small_views_error seen_original, seen_adapted;
    bool seen;      /* the small views judged; else the two above are empty */
    double ghost;      /* of the adapted TF as Eq. 7 has it, by the small views (ghost.h) */
    size_t given_back; /* entries that have the original's extinction for it; seen_adapted is of what is left then */
    bool use_original;
} iso_adapt_judgment;
/* What small views say: the rule above, without ghosts. */
bool iso_adapt_is_nearer(const iso_small_views_error *original, const iso_small_views_error *adapted);
/* At the voxels alone; *judgment is written anew. */
iso_status iso_adapt_judge(const iso_joint *joint, const iso_tf_table *tf, const iso_tf_table *adapted,
                           const iso_geometry *level0, iso_adapt_judgment *judgment, iso_error *err);

/* The whole adaptation for one level of a pyramid, as renderers and exporters call it. Level 0
 * gets a copy of tf. judgment may be NULL. */
iso_status iso_adapt_level(const iso_pyramid *p, size_t level, const iso_tf_table *tf, const iso_adapt_options *opt,
                           iso_tf_table *table, iso_adapt_judgment *judgment, iso_error *err);

/* The 2D transfer function (tf_2d.h) adapted to `level` alone, for volumes in which one value stands for two things.
 * Few voxels say little: each of its rows is averaged with the 1D transfer function, which has the weight of
 * ISO_TF_2D_PSEUDO_COUNTS voxels. level: at least 1; opt->bits: at most 12. ISO_E_RANGE, ISO_E_MEMORY. */
#define ISO_TF_2D_PSEUDO_COUNTS 16
#define ISO_TF_2D_WINDOW 3.0 /* of the flat weight, where the options leave it open */
iso_status iso_adapt_tf_2d(const iso_pyramid *p, size_t level, iso_second_value second, const iso_tf_table *tf,
                           const iso_adapt_options *opt, iso_tf_2d *out, iso_error *err);

/* A table as a TF file's content: a point an entry, an explicit range, so that
 * tabulating it gives the same entries back within rounding. ISO_E_MEMORY; ISO_E_RANGE beyond ISO_TF_MOST_EXTINCTION. */
iso_status iso_tf_from_table(const iso_tf_table *table, iso_tf *tf, iso_error *err);

#endif

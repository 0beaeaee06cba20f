/* SPDX-License-Identifier: MIT */
/* overview.h - statistics of a volume's values: range, mean, percentiles, histograms.
 *
 * A volume of more than kept_bytes is read slab by slab, twice, and is never whole in memory; a smaller one is read
 * once. The figures are the same except for the last bits of the mean, and do not depend on the number of threads. */
#pragma once

#include "volume/input.h"
#include "volume/value_histogram.h"

enum { ISO_OVERVIEW_PERCENTS = 5, ISO_OVERVIEW_BINS = 64 };
extern const double iso_overview_percents[ISO_OVERVIEW_PERCENTS]; /* 1, 25, 50, 75, 99 */

typedef struct iso_overview {
    iso_volume header; /* owned: geometry, type, notes with the number of labels, segments; data is NULL */
    iso_volume_stats stats;
    double percentile[ISO_OVERVIEW_PERCENTS]; /* good to 1/16384 of the range */
    size_t bins[ISO_OVERVIEW_BINS];           /* over [min, max] */
    size_t rounded;                           /* voxels that rounding to float changes, */
    double most_rounded;                      /* by at most so much */
    iso_value_histogram shown, drawn;         /* of at most ISO_OVERVIEW_BINS and of drawn_bins bins */
} iso_overview;

typedef struct iso_overview_options {
    size_t kept_bytes, slab_bytes; /* 0: 256 and 32 MiB */
    size_t drawn_bins;             /* 0: none are wanted */
    int threads;
} iso_overview_options;

/* Surveys a volume. Statuses as iso_volume_load(); ISO_E_RANGE: NaN or infinite voxels. */
iso_status iso_overview_run(const char *path, const iso_volume_input *input, const iso_overview_options *opt,
                            iso_overview *s, const iso_progress *progress, iso_error *err);
void iso_overview_destroy(iso_overview *s); /* accepts empty */

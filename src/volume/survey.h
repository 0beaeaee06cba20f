/* SPDX-License-Identifier: MIT */
/* survey.h - what the values of a volume are: range, mean, percentiles, histograms.
 *
 * A volume of more than kept_bytes is read slab by slab, twice, and is never whole in memory; a smaller one is read once. The
 * figures are the same but for the last bits of the mean, and do not depend on the number of threads. */
#ifndef ISO_VOLUME_SURVEY_H
#define ISO_VOLUME_SURVEY_H

#include "volume/input.h"
#include "volume/value_histogram.h"

enum { ISO_SURVEY_PERCENTS = 5, ISO_SURVEY_BINS = 64 };
extern const double iso_survey_percents[ISO_SURVEY_PERCENTS]; /* 1, 25, 50, 75, 99 */

typedef struct iso_survey {
    iso_volume header; /* owned: geometry, type, notes with the number of labels, segments; data is NULL */
    iso_volume_stats stats;
    double percentile[ISO_SURVEY_PERCENTS]; /* good to 1/16384 of the range */
    size_t bins[ISO_SURVEY_BINS];           /* over [min, max] */
    size_t rounded;                         /* voxels that rounding to float changes, */
    double most_rounded;                    /* by at most so much */
    iso_value_histogram shown, drawn;       /* of at most ISO_SURVEY_BINS and of drawn_bins bins */
} iso_survey;

typedef struct iso_survey_options {
    size_t kept_bytes, slab_bytes; /* 0: 256 and 32 MiB */
    size_t drawn_bins;             /* 0: none are wanted */
    int threads;
} iso_survey_options;

/* Statuses as iso_volume_load(); ISO_E_RANGE: NaN or infinite voxels. */
iso_status iso_survey_run(const char *path, const iso_volume_input *input, const iso_survey_options *opt, iso_survey *s,
                          const iso_progress *progress, iso_error *err);
void iso_survey_destroy(iso_survey *s); /* accepts empty */

#endif

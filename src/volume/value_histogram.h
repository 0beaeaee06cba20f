/* SPDX-License-Identifier: MIT */
/* value_histogram.h - how many voxels have which value, for people to look at: over a range, in bins that a picture can
 * show. Bins of whole numbers are whole numbers wide and stand around them, so that no bin holds more values than its
 * neighbor: that would draw a comb. */
#pragma once

#include "volume/volume.h"

typedef struct iso_value_histogram {
    double lo, width; /* bin b is [lo + b width, lo + (b + 1) width) */
    size_t count;     /* bins */
    size_t *bins;     /* owned */
    size_t most;      /* voxels of the fullest */
    double range[2];  /* that is counted */
} iso_value_histogram;

/* Counts the values in [lo, hi], both included; if lo is hi there is one bin. ISO_E_MEMORY. */
iso_status iso_value_histogram_count(const iso_volume *v, double lo, double hi, size_t most_bins,
                                     iso_value_histogram *h, iso_error *err);

/* Counts in parts: creates empty bins, a whole number wide if all values are whole numbers; adds values, in any order;
 * adds another histogram's counts of the same bins; finds the fullest bin. */
iso_status iso_value_histogram_begin(bool are_whole, double lo, double hi, size_t most_bins, iso_value_histogram *h,
                                     iso_error *err);
void iso_value_histogram_add(iso_value_histogram *h, const float *values, size_t count);
void iso_value_histogram_add_all(iso_value_histogram *h, const iso_value_histogram *other);
void iso_value_histogram_end(iso_value_histogram *h);
bool iso_volume_is_whole(const iso_volume *v); /* no value has a fraction, as in Hounsfield units stored as floats */

void iso_value_histogram_destroy(iso_value_histogram *h); /* accepts empty */

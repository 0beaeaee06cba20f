/* SPDX-License-Identifier: MIT */
#include "volume/value_histogram.h"

#include <math.h>
#include <stdlib.h>

/* Hounsfield units are whole numbers in floats, too. */
static bool are_whole(const iso_volume *v, float *row)
{
    const size_t *n = v->geometry.size;
    for (size_t r = 0; r < n[1] * n[2]; ++r) {
        iso_volume_row(v, r % n[1], r / n[1], row);
        for (size_t x = 0; x < n[0]; ++x)
            if (row[x] != rintf(row[x]))
                return false;
    }
    return true;
}

static void choose_bins(bool whole, double lo, double hi, size_t most_bins, iso_value_histogram *h)
{
    if (whole) {
        const double first = floor(lo), values = ceil(hi) - first + 1;
        h->width = fmax(ceil(values / (double)most_bins), 1);
        h->lo = first - 0.5;
        h->count = (size_t)ceil(values / h->width);
    } else if (!(hi > lo)) {
        h->lo = lo - 0.5;
        h->count = 1;
        h->width = 1;
    } else {
        h->lo = lo;
        h->count = most_bins;
        h->width = (hi - lo) / (double)most_bins;
    }
}

iso_status iso_value_histogram_count(const iso_volume *v, double lo, double hi, size_t most_bins,
                                     iso_value_histogram *h, iso_error *err)
{
    const size_t *n = v->geometry.size;
    *h = (iso_value_histogram){0};
    float *row = malloc(n[0] * sizeof *row);
    if (row)
        choose_bins(are_whole(v, row), lo, hi, most_bins, h);
    h->bins = calloc(h->count ? h->count : 1, sizeof *h->bins);
    if (!row || !h->bins) {
        free(row);
        iso_value_histogram_destroy(h);
        return iso_fail(err, ISO_E_MEMORY, "histogram: out of memory");
    }
    for (size_t r = 0; r < n[1] * n[2]; ++r) {
        iso_volume_row(v, r % n[1], r / n[1], row);
        for (size_t x = 0; x < n[0]; ++x) {
            const double value = (double)row[x], at = (value - h->lo) / h->width;
            if (value >= lo && value <= hi)
                ++h->bins[at < (double)h->count ? (size_t)fmax(at, 0) : h->count - 1];
        }
    }
    for (size_t b = 0; b < h->count; ++b)
        h->most = h->bins[b] > h->most ? h->bins[b] : h->most;
    free(row);
    return ISO_OK;
}

void iso_value_histogram_destroy(iso_value_histogram *h)
{
    free(h->bins);
    *h = (iso_value_histogram){0};
}

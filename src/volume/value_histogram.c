/* SPDX-License-Identifier: MIT */
#include "volume/value_histogram.h"

#include <math.h>
#include <stdlib.h>

bool iso_volume_is_whole(const iso_volume *v)
{
    const size_t count = iso_geometry_voxel_count(&v->geometry);
    const float *floats = v->data;
    const double *doubles = v->data;
    if (v->type == ISO_F32)
        for (size_t i = 0; i < count; ++i)
            if (floats[i] != rintf(floats[i]))
                return false;
    if (v->type == ISO_F64)
        for (size_t i = 0; i < count; ++i)
            if ((float)doubles[i] != rintf((float)doubles[i]))
                return false;
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

iso_status iso_value_histogram_begin(bool are_whole, double lo, double hi, size_t most_bins, iso_value_histogram *h,
                                     iso_error *err)
{
    *h = (iso_value_histogram){.range = {lo, hi}};
    choose_bins(are_whole, lo, hi, most_bins, h);
    h->bins = calloc(h->count, sizeof *h->bins);
    return h->bins ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "histogram: out of memory");
}

void iso_value_histogram_end(iso_value_histogram *h)
{
    for (size_t b = 0; b < h->count; ++b)
        h->most = h->bins[b] > h->most ? h->bins[b] : h->most;
}

void iso_value_histogram_add(iso_value_histogram *h, const float *values, size_t count)
{
    for (size_t i = 0; i < count; ++i) {
        const double value = (double)values[i], at = (value - h->lo) / h->width;
        if (value >= h->range[0] && value <= h->range[1])
            ++h->bins[at < (double)h->count ? (size_t)fmax(at, 0) : h->count - 1];
    }
}

void iso_value_histogram_add_all(iso_value_histogram *h, const iso_value_histogram *other)
{
    for (size_t b = 0; b < h->count; ++b)
        h->bins[b] += other->bins[b];
}

iso_status iso_value_histogram_count(const iso_volume *v, double lo, double hi, size_t most_bins,
                                     iso_value_histogram *h, iso_error *err)
{
    const size_t *n = v->geometry.size;
    float *row = malloc(n[0] * sizeof *row);
    iso_status status = iso_value_histogram_begin(iso_volume_is_whole(v), lo, hi, most_bins, h, err);
    if (status == ISO_OK && !row)
        status = iso_fail(err, ISO_E_MEMORY, "histogram: out of memory");
    for (size_t r = 0; r < n[1] * n[2] && status == ISO_OK; ++r) {
        iso_volume_row(v, r % n[1], r / n[1], row);
        iso_value_histogram_add(h, row, n[0]);
    }
    iso_value_histogram_end(h);
    free(row);
    if (status != ISO_OK)
        iso_value_histogram_destroy(h);
    return status;
}

void iso_value_histogram_destroy(iso_value_histogram *h)
{
    free(h->bins);
    *h = (iso_value_histogram){0};
}

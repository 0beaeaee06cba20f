/* SPDX-License-Identifier: MIT */
#include "lab/surface.h"

#include <math.h>

enum { BINS = 256 };

typedef struct histogram {
    double all[BINS], border[BINS]; /* voxels */
    double total, border_total;
} histogram;

static histogram count_values(const iso_level *level)
{
    const size_t *n = level->geometry.size;
    const double range = level->max - level->min;
    histogram h = {{0}, {0}, 0, 0};
    for (size_t i = 0; range > 0 && i < iso_geometry_voxel_count(&level->geometry); ++i) {
        const size_t x = i % n[0], y = i / n[0] % n[1], z = i / (n[0] * n[1]);
        const bool border = x == 0 || y == 0 || z == 0 || x + 1 == n[0] || y + 1 == n[1] || z + 1 == n[2];
        const size_t bin = (size_t)fmin(((double)level->scalar[i] - level->min) / range * BINS, BINS - 1);
        h.all[bin] += 1;
        h.border[bin] += border;
        h.total += 1;
        h.border_total += border;
    }
    return h;
}

/* Returns the middle of the thresholds that split the bins best. Counts and sums of bins are exact in double precision,
 * so that thresholds between the same voxels have the same variance, to the last bit. */
static double otsu_fraction(const histogram *h)
{
    double total_sum = 0, below = 0, below_sum = 0, best = -1;
    int first = BINS / 2 - 1, last = first; /* one value: any threshold is as good */
    for (int b = 0; b < BINS; ++b)
        total_sum += b * h->all[b];
    for (int b = 0; b + 1 < BINS; ++b) {
        below += h->all[b];
        below_sum += b * h->all[b];
        if (below == 0 || below == h->total)
            continue;
        const double step = below_sum / below - (total_sum - below_sum) / (h->total - below);
        const double between = below * (h->total - below) * step * step;
        if (between > best) {
            best = between;
            first = b;
        }
        if (between == best)
            last = b;
    }
    return (0.5 * (first + last) + 1) / BINS;
}

typedef struct ramp {
    double low, high;
} ramp;

static ramp ramp_at(double fraction)
{
    return (ramp){fmax(fraction - ISO_SURFACE_HALF_RAMP, 0.001), fmin(fraction + ISO_SURFACE_HALF_RAMP, 0.999)};
}

/* Returns the share of voxels whose bin's middle lies between two fractions of the range. */
static double part_between(const double *bins, double total, double low, double high)
{
    double sum = 0;
    for (int b = 0; b < BINS; ++b)
        if ((b + 0.5) / BINS > low && (b + 0.5) / BINS < high)
            sum += bins[b];
    return total > 0 ? sum / total : 0;
}

static double border_shown(const histogram *h, double fraction, bool below)
{
    const ramp r = ramp_at(fraction);
    return part_between(h->border, h->border_total, below ? -1 : r.low, below ? r.high : 2);
}

static iso_otsu_surface judge(const histogram *h, double fraction, bool below)
{
    const ramp r = ramp_at(fraction);
    iso_otsu_surface s = {.fraction = fraction,
                          .below = below,
                          .border = border_shown(h, fraction, below),
                          .ramp = part_between(h->all, h->total, r.low, r.high)};
    if (h->total == 0)
        s.left_out = "it is constant";
    else if (s.border > ISO_SURFACE_MOST_BORDER)
        s.left_out = "its surface would show the background";
    else if (s.ramp > ISO_SURFACE_MOST_RAMP)
        s.left_out = "its values do not split into two classes";
    return s;
}

iso_otsu_surface iso_surface_find(const iso_level *level)
{
    const histogram h = count_values(level);
    const double fraction = otsu_fraction(&h);
    return judge(&h, fraction, border_shown(&h, fraction, false) > ISO_SURFACE_MOST_BORDER);
}

iso_otsu_surface iso_surface_at(const iso_level *level, double fraction)
{
    const histogram h = count_values(level);
    return judge(&h, fraction, false);
}

iso_tf iso_surface_make_tf(const iso_otsu_surface *surface, iso_surface_tf *storage)
{
    const ramp r = ramp_at(surface->fraction);
    const double low = surface->below ? 0.8 : 0, high = surface->below ? 0 : 0.8;
    const iso_tf_point outside = {0, {0.9, 0.7, 0.4}, 0}, inside = {0, {1, 0.9, 0.8}, 0};
    for (int i = 0; i < 4; ++i) {
        storage->points[i] = (i < 2) != surface->below ? outside : inside;
        storage->points[i].value = (const double[]){0, r.low, r.high, 1}[i];
        storage->points[i].opacity = i < 2 ? low : high;
    }
    return (iso_tf){.point_count = 4,
                    .points = storage->points,
                    .fit_range = true,
                    .unit_distance = 1,
                    .unit_is_voxels = true,
                    .table_size = 256};
}

/* SPDX-License-Identifier: MIT */
#include "fit/curve.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Entries of the curve per entry of the transfer function, and their least and greatest number. */
enum { FINER = 4, LEAST = 4096, MOST = 16384 };

static iso_status create(size_t count, double lo, double step, iso_fit_curve *curve, iso_error *err)
{
    *curve = (iso_fit_curve){.count = count, .lo = lo, .step = step, .entries = malloc(4 * count * sizeof(float))};
    return curve->entries ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "fit: no memory for %zu entries", count);
}

iso_status iso_fit_curve_create(const iso_tf_table *tf, double length_mm, iso_fit_curve *curve, iso_error *err)
{
    const size_t wanted = 2 * FINER * (tf->count - 1) + 1;
    const size_t count = wanted < LEAST ? LEAST : wanted < MOST ? wanted : MOST;
    const double range = tf->hi - tf->lo;
    NEED(create(count, tf->lo - 0.5 * range, 2 * range / (double)(count - 1), curve, err));
    for (size_t i = 0; i < count; ++i) {
        double rgbs[4];
        iso_tf_lookup(tf, curve->lo + (double)i * curve->step, rgbs);
        const double opacity = -expm1(-rgbs[3] * length_mm);
        for (int c = 0; c < 3; ++c)
            curve->entries[4 * i + (size_t)c] = (float)(opacity * rgbs[c]);
        curve->entries[4 * i + 3] = (float)opacity;
    }
    return ISO_OK;
}

void iso_fit_curve_destroy(iso_fit_curve *curve)
{
    if (curve)
        free(curve->entries);
    if (curve)
        *curve = (iso_fit_curve){0};
}

/* Returns the extent of a channel over its largest slope, in values. */
static double channel_width(const iso_fit_curve *curve, size_t c, double *extent)
{
    double lo = INFINITY, hi = -INFINITY, steepest = 0;
    for (size_t i = 0; i < curve->count; ++i) {
        const double at = (double)curve->entries[4 * i + c];
        lo = fmin(lo, at);
        hi = fmax(hi, at);
        if (i > 0)
            steepest = fmax(steepest, fabs(at - (double)curve->entries[4 * (i - 1) + c]));
    }
    *extent = hi - lo;
    return steepest > 0 ? (hi - lo) / steepest * curve->step : 0;
}

double iso_fit_curve_ramp_width(const iso_fit_curve *curve)
{
    double extent, most = 0, width = channel_width(curve, 3, &extent);
    if (extent > 1e-3)
        return width;
    for (size_t c = 0; c < 3; ++c) {
        const double w = channel_width(curve, c, &extent);
        if (extent > most) {
            most = extent;
            width = w;
        }
    }
    return width;
}

/* Integrates a channel from entry 0 to position x in entries; sums: the integral up to each entry. */
static double integral(const iso_fit_curve *curve, const double *sums, size_t c, double x)
{
    const double last = (double)(curve->count - 1);
    const float *e = curve->entries + c;
    if (x <= 0)
        return x * (double)e[0];
    if (x >= last)
        return sums[curve->count - 1] + (x - last) * (double)e[4 * (curve->count - 1)];
    const size_t i = (size_t)x;
    const double f = x - (double)i, a = (double)e[4 * i], b = (double)e[4 * i + 4];
    return sums[i] + f * (a + 0.5 * f * (b - a));
}

void iso_fit_curve_widen(const iso_fit_curve *curve, double width, iso_fit_curve *wide)
{
    const double half = 0.5 * width / curve->step;
    FREED double *sums = half > 1e-6 ? malloc(curve->count * sizeof *sums) : NULL;
    memcpy(wide->entries, curve->entries, 4 * curve->count * sizeof *wide->entries);
    for (size_t c = 0; c < 4 && sums; ++c) {
        sums[0] = 0;
        for (size_t i = 1; i < curve->count; ++i)
            sums[i] = sums[i - 1] + 0.5 * ((double)curve->entries[4 * (i - 1) + c] + (double)curve->entries[4 * i + c]);
        for (size_t i = 0; i < curve->count; ++i)
            wide->entries[4 * i + c] = (float)((integral(curve, sums, c, (double)i + half) -
                                                integral(curve, sums, c, (double)i - half)) /
                                               (2 * half));
    }
}

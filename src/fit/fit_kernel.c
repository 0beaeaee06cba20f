/* SPDX-License-Identifier: MIT */
#include "fit/fit_kernel.h"

static float squared_error(const iso_fit_row *r, size_t x, const iso_fit_curve *curve)
{
    float f, g, sum = 0;
    const float *a = curve->entries + 4 * iso_fit_curve_find(curve, r->shown[x], &f);
    const float *b = curve->entries + 4 * iso_fit_curve_find(curve, r->fine[x], &g);
    for (int c = r->opacity_only ? 3 : 0; c < 4; ++c) {
        const float d = a[c] + f * (a[c + 4] - a[c]) - (b[c] + g * (b[c + 4] - b[c]));
        sum += d * d;
    }
    return sum;
}

void iso_fit_row_errors(const iso_fit_row *r, const iso_fit_curve *wide, const iso_fit_curve *curve, double sums[2])
{
    for (size_t x = 0; x < r->count; ++x) {
        sums[0] += (double)squared_error(r, x, wide);
        sums[1] += (double)squared_error(r, x, curve);
    }
}

double iso_fit_row_linearize(const iso_fit_row *r, const iso_fit_curve *curve)
{
    const float per_value = (float)(1 / curve->step);
    double error = 0;
    for (size_t x = 0; x < r->count; ++x) {
        float f, g, sum = 0, weight = 0, pull = 0;
        const float *a = curve->entries + 4 * iso_fit_curve_find(curve, r->shown[x], &f);
        const float *b = curve->entries + 4 * iso_fit_curve_find(curve, r->fine[x], &g);
        for (int c = r->opacity_only ? 3 : 0; c < 4; ++c) {
            const float slope = a[c + 4] - a[c];
            const float d = a[c] + f * slope - (b[c] + g * (b[c + 4] - b[c]));
            sum += d * d;
            weight += slope * slope;
            pull += slope * d;
        }
        error += (double)sum;
        r->weight[x] = weight * per_value * per_value;
        r->result[x] = pull * per_value;
    }
    return error;
}

void iso_fit_row_weigh(const iso_fit_row *r)
{
    for (size_t x = 0; x < r->count; ++x)
        r->result[x] = r->shown[x] * r->weight[x];
}

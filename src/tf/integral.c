/* SPDX-License-Identifier: MIT */
#include "tf/integral.h"

#include <math.h>
#include <stdlib.h>

/* Computes emission and extinction at entry x in [i, i + 1] of cell i: linear in the table, constant beyond it. */
static void emission_at(const iso_tf_table *tf, double cell, double x, double out[4])
{
    const double last = (double)(tf->count - 1);
    const float *near = tf->entries + 4 * (size_t)fmin(fmax(cell, 0), last);
    const float *far = tf->entries + 4 * (size_t)fmin(fmax(cell + 1, 0), last);
    const double f = cell < 0 || cell >= last ? 0 : x - cell; /* beyond the table near and far are the same entry */
    double sigma = (1 - f) * (double)near[3] + f * (double)far[3];
    for (int c = 0; c < 3; ++c)
        out[c] = sigma * ((1 - f) * (double)near[c] + f * (double)far[c]);
    out[3] = sigma;
}

/* Computes the mean over [a, b] in one cell: a product of two linear functions, for which Simpson's rule is exact. */
static void cell_mean(const iso_tf_table *tf, double cell, double a, double b, double mean[4])
{
    double at_a[4], at_middle[4], at_b[4];
    emission_at(tf, cell, a, at_a);
    emission_at(tf, cell, 0.5 * (a + b), at_middle);
    emission_at(tf, cell, b, at_b);
    for (int c = 0; c < 4; ++c)
        mean[c] = (at_a[c] + 4 * at_middle[c] + at_b[c]) / 6;
}

iso_status iso_tf_integral_create(iso_tf_integral *integral, const iso_tf_table *tf, iso_error *err)
{
    *integral = (iso_tf_integral){.tf = tf, .sums = calloc(4 * tf->count, sizeof *integral->sums)};
    NEED_MEMORY(integral->sums, err, "no memory for the integral of a transfer function of %zu entries", tf->count);
    for (size_t i = 1; i < tf->count; ++i) {
        double mean[4];
        cell_mean(tf, (double)(i - 1), (double)(i - 1), (double)i, mean);
        for (size_t c = 0; c < 4; ++c)
            integral->sums[4 * i + c] = integral->sums[4 * (i - 1) + c] + mean[c];
    }
    return ISO_OK;
}

void iso_tf_integral_destroy(iso_tf_integral *integral)
{
    free(integral->sums);
    *integral = (iso_tf_integral){0};
}

void iso_tf_integral_mean(const iso_tf_integral *integral, double a, double b, double mean[4])
{
    const iso_tf_table *tf = integral->tf;
    const double last = (double)(tf->count - 1), per_value = last / (tf->hi - tf->lo);
    double lo = (fmin(a, b) - tf->lo) * per_value, hi = (fmax(a, b) - tf->lo) * per_value;
    double first_cell = fmin(fmax(floor(lo), -1), last), last_cell = fmin(fmax(floor(hi), -1), last);
    if (first_cell == last_cell) {
        cell_mean(tf, first_cell, lo, hi, mean);
        return;
    }
    double front[4], back[4];
    cell_mean(tf, first_cell, lo, first_cell + 1, front);
    cell_mean(tf, last_cell, last_cell, hi, back);
    const double *from = integral->sums + 4 * (size_t)(first_cell + 1), *to = integral->sums + 4 * (size_t)last_cell;
    for (int c = 0; c < 4; ++c)
        mean[c] = (front[c] * (first_cell + 1 - lo) + (to[c] - from[c]) + back[c] * (hi - last_cell)) / (hi - lo);
}

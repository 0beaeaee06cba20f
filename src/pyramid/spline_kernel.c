/* SPDX-License-Identifier: MIT */
#include "pyramid/spline_kernel.h"

#include <stdbool.h>

#include "base/simd.h"

size_t iso_spline_lookup(const iso_spline_axis *a, size_t i, double *f)
{
    const size_t half = a->ratio / 2, at = i + half; /* u + 1 = (at + 1/2) / r */
    const size_t j = at / a->ratio;
    *f = 0;
    if (j == 0)
        return 0;
    if (j >= a->coarse)
        return a->coarse - 1;
    *f = ((double)(at % a->ratio) + 0.5) / (double)a->ratio;
    return j - 1;
}

size_t iso_spline_first(const iso_spline_axis *a, size_t j)
{
    return j == 0 ? 0 : j * a->ratio - a->ratio / 2;
}

size_t iso_spline_end(const iso_spline_axis *a, size_t j)
{
    const size_t end = (j + 1) * a->ratio + a->ratio / 2;
    return j + 1 < a->coarse && end < a->fine ? end : a->fine;
}

size_t iso_spline_summed(const iso_spline_axis *a, size_t end)
{
    if (end == a->fine)
        return a->coarse;
    return end >= a->ratio / 2 ? (end - a->ratio / 2) / a->ratio : 0;
}

/* ---- the tridiagonal system ---- */

/* Computes the elements (j, j) and (j, j + 1) of A^T A / r. */
static void gram_row(const iso_spline_axis *a, size_t j, double *own, double *next)
{
    *own = *next = 0;
    for (size_t i = iso_spline_first(a, j); i < iso_spline_end(a, j); ++i) {
        double f;
        const bool is_lower = iso_spline_lookup(a, i, &f) == j;
        const double weight = is_lower ? 1 - f : f;
        *own += weight * weight;
        *next += is_lower ? weight * f : 0;
    }
    *own /= (double)a->ratio;
    *next /= (double)a->ratio;
}

void iso_spline_factorize(const iso_spline_axis *a, size_t j0, size_t j1, iso_spline_row *rows)
{
    double below = 0, above = 0, own, next;
    if (j0 > 0)
        gram_row(a, j0 - 1, &own, &below);
    for (size_t j = j0; j < j1; ++j) {
        gram_row(a, j, &own, &next);
        if (j == j0)
            own += below;
        if (j + 1 == j1)
            own += next;
        const double inverse = 1 / (own - (j > j0 ? below * above : 0));
        above = next * inverse;
        rows[j - j0] = (iso_spline_row){(float)(j > j0 ? below : 0), (float)inverse, (float)(j + 1 < j1 ? above : 0)};
        below = next;
    }
}

ISO_SIMD static void eliminate(iso_spline_row row, const float *restrict before, size_t lanes, float *restrict own)
{
    for (size_t l = 0; l < lanes; ++l)
        own[l] = (own[l] - row.below * before[l]) * row.inverse;
}

ISO_SIMD static void substitute(iso_spline_row row, const float *restrict after, size_t lanes, float *restrict own)
{
    for (size_t l = 0; l < lanes; ++l)
        own[l] -= row.above * after[l];
}

ISO_SIMD static void scale(float factor, size_t lanes, float *restrict own)
{
    for (size_t l = 0; l < lanes; ++l)
        own[l] *= factor;
}

void iso_spline_solve(const iso_spline_row *rows, size_t count, float *values, size_t stride, size_t lanes)
{
    scale(rows[0].inverse, lanes, values);
    for (size_t i = 1; i < count; ++i)
        eliminate(rows[i], values + (i - 1) * stride, lanes, values + i * stride);
    for (size_t i = count - 1; i-- > 0;)
        substitute(rows[i], values + (i + 1) * stride, lanes, values + i * stride);
}

/* Solves 16 rows, with the lanes of an element adjacent: calls of iso_spline_solve would cost more than their work. */
ISO_SIMD static void solve_columns(const iso_spline_row *rows, size_t count, float *restrict v)
{
    enum { N = ISO_SPLINE_LANES };
    float last[N];
    for (size_t l = 0; l < N; ++l)
        last[l] = 0;
    for (size_t i = 0; i < count; ++i)
        for (size_t l = 0; l < N; ++l)
            v[i * N + l] = last[l] = (v[i * N + l] - rows[i].below * last[l]) * rows[i].inverse;
    for (size_t i = count; i-- > 0;)
        for (size_t l = 0; l < N; ++l)
            v[i * N + l] = last[l] = v[i * N + l] - rows[i].above * last[l];
}

void iso_spline_solve_rows(const iso_spline_row *rows, size_t count, float *values, size_t stride, size_t row_count,
                           float *scratch)
{
    for (size_t l = 0; l < ISO_SPLINE_LANES; ++l)
        for (size_t i = 0; i < count; ++i)
            scratch[i * ISO_SPLINE_LANES + l] = l < row_count ? values[l * stride + i] : 0;
    solve_columns(rows, count, scratch);
    for (size_t l = 0; l < row_count; ++l)
        for (size_t i = 0; i < count; ++i)
            values[l * stride + i] = scratch[i * ISO_SPLINE_LANES + l];
}

/* ---- along x ---- */

/* Computes T, the mean of an interval's values, and U, the mean of values times t, their place in it from 0 to 1. */
ISO_SIMD static void first_halves(const float *restrict v, size_t n, float *restrict t, float *restrict u)
{
    for (size_t i = 0; i < n; ++i) {
        t[i] = 0.5f * (v[2 * i] + v[2 * i + 1]);
        u[i] = 0.125f * v[2 * i] + 0.375f * v[2 * i + 1];
    }
}

ISO_SIMD static void join_halves(const float *restrict t, const float *restrict u, size_t n, float *restrict to_t,
                                 float *restrict to_u)
{
    for (size_t i = 0; i < n; ++i) {
        to_t[i] = 0.5f * (t[2 * i] + t[2 * i + 1]);
        to_u[i] = 0.25f * ((u[2 * i] + u[2 * i + 1]) + t[2 * i + 1]);
    }
}

ISO_SIMD static void join_intervals(const float *restrict t, const float *restrict u, size_t n, float *restrict out)
{
    for (size_t j = 0; j < n; ++j)
        out[j] = u[j] + (t[j + 1] - u[j + 1]);
}

void iso_spline_moments(const float *restrict row, size_t n, size_t ratio, float *restrict scratch, const float **t,
                        const float **u)
{
    n /= 2;
    float *own_t = scratch, *own_u = own_t + n, *to_t = own_u + n, *to_u = to_t + n / 2 + 1;
    first_halves(row, n, own_t, own_u);
    for (size_t joined = 2; joined < ratio; joined *= 2) {
        n /= 2;
        join_halves(own_t, own_u, n, to_t, to_u);
        float *free_t = own_t, *free_u = own_u;
        own_t = to_t, own_u = to_u, to_t = free_t, to_u = free_u;
    }
    *t = own_t;
    *u = own_u;
}

int iso_spline_cell(const iso_spline_axis *a, size_t s, size_t cell, iso_spline_part parts[2])
{
    const size_t at = cell * s + a->ratio / 2, interval = at / a->ratio;
    const double part = (double)s / (double)a->ratio, start = (double)(at % a->ratio) / (double)a->ratio;
    if (interval == 0 || interval >= a->coarse) { /* outside of the outermost centers a value counts whole */
        parts[0] = (iso_spline_part){interval == 0 ? 0 : a->coarse - 1, (float)part, 0};
        return 1;
    }
    parts[0] = (iso_spline_part){interval - 1, (float)(part * (1 - start)), (float)(-part * part)};
    parts[1] = (iso_spline_part){interval, (float)(part * start), (float)(part * part)};
    return 2;
}

size_t iso_spline_padded(const iso_spline_axis *a)
{
    return (a->coarse + 1) * a->ratio;
}

void iso_spline_reduce_row(const iso_spline_axis *a, const float *restrict padded, float *restrict scratch,
                           float *restrict out)
{
    const float *t, *u;
    iso_spline_moments(padded, iso_spline_padded(a), a->ratio, scratch, &t, &u);
    /* Outside of the outermost centers a value counts whole. */
    const size_t last = a->coarse - 1;
    if (last == 0) {
        out[0] = t[0] + t[1];
        return;
    }
    join_intervals(t, u, a->coarse, out);
    out[0] = t[0] + (t[1] - u[1]);
    out[last] = u[last] + t[last + 1];
}

/* SPDX-License-Identifier: MIT */
/* gradient_bspline.c - the derivative of the cubic B-spline that interpolates the samples: a recursive pre-filter, then
 * central differences of its coefficients [csebfalvi-2009], [unser-1999].
 *
 * On the grid the pre-filters along the other axes cancel with the spline's own (1 4 1) / 6, so each component is a
 * filter along its own axis:
 *     D(z) = 3 (z - 1/z) / (z + 4 + 1/z) = sum over k > 0 of w_k (z^k - z^-k),   w_k = sqrt(3)/2 (1 - p^2) p^(k-1),
 * with the pole p = sqrt(3) - 2. The recursion would reach over the whole axis; its response shrinks to .268 per voxel,
 * so REACH taps per side are the same to float precision, need no more than a halo of slabs, and vectorize along x
 * for every axis. The last two taps take up the rest, so that linear and cubic data are exact.
 *
 * Beyond a border the samples go on as the cubic through the last four, which keeps the border at third order. */
#include <math.h>
#include <string.h>

#include "base/simd.h"
#include "gradient/gradient_kernel.h"

enum { REACH = 12, BLOCK = 64, EDGE = 4 };

static void interior_weights(float w[REACH])
{
    const double pole = sqrt(3) - 2, a = REACH - 1, b = REACH;
    double exact[REACH], slope = 0.5, cubic = 0,
                         power = 1; /* the remainder: sum of k w = 1/2, sum of k^3 w = 0 */
    for (int k = 1; k <= REACH - 2; ++k) {
        exact[k - 1] = sqrt(3) / 2 * (1 - pole * pole) * power;
        slope -= k * exact[k - 1];
        cubic -= (double)k * k * k * exact[k - 1];
        power *= pole;
    }
    exact[REACH - 2] = (b * b * slope - cubic) / (a * (b * b - a * a));
    exact[REACH - 1] = (cubic - a * a * slope) / (b * (b * b - a * a));
    for (int k = 0; k < REACH; ++k)
        w[k] = (float)exact[k];
}

/* Computes Lagrange weights of a sample `beyond` (1, 2 ...) voxels outside, from the first EDGE inside, counted from
 * the border. */
static void outside_weights(size_t beyond, size_t n, double e[EDGE])
{
    const size_t count = n < EDGE ? n : EDGE;
    for (size_t s = 0; s < EDGE; ++s) {
        e[s] = s < count;
        for (size_t t = 0; t < count && s < count; ++t)
            if (t != s)
                e[s] *= ((double)beyond + (double)t) / ((double)t - (double)s);
    }
}

/* Computes weights of the samples i - REACH .. i + REACH for the derivative at sample i of n; 0 for those outside. */
static void folded_weights(size_t i, size_t n, float out[2 * REACH + 1])
{
    float w[REACH];
    double sum[2 * REACH + 1] = {0}, e[EDGE];
    interior_weights(w);
    for (size_t k = 1; k <= REACH; ++k) {
        outside_weights(i + k >= n ? i + k - n + 1 : k - i, n, e);
        if (i + k < n)
            sum[REACH + k] += (double)w[k - 1];
        for (size_t s = 0; i + k >= n && s < EDGE && s < n; ++s)
            sum[REACH + (n - 1 - s) - i] += (double)w[k - 1] * e[s];
        if (i >= k)
            sum[REACH - k] -= (double)w[k - 1];
        outside_weights(k > i ? k - i : 1, n, e);
        for (size_t s = 0; i < k && s < EDGE && s < n; ++s)
            sum[REACH + s - i] -= (double)w[k - 1] * e[s];
    }
    for (size_t j = 0; j <= 2 * REACH; ++j)
        out[j] = (float)sum[j];
}

/* out = sum of w_k (after_k - before_k). Samples of 8 and 16 bits are subtracted as integers, which is exact. */
/* clang-format off */
#define PAIRS(type, suffix, ctype, wide)                                                                               \
    ISO_SIMD static void pairs_##suffix(const void *const before[REACH], const void *const after[REACH],          \
                                        const float w[REACH], size_t n, float *restrict out)                      \
    {                                                                                                             \
        for (size_t x = 0; x < n; x += BLOCK) {                                                                   \
            const size_t m = n - x < BLOCK ? n - x : BLOCK;                                                       \
            float sum[BLOCK] = {0};                                                                               \
            for (int k = 0; k < REACH; ++k) {                                                                     \
                const ctype *a = (const ctype *)after[k] + x, *b = (const ctype *)before[k] + x;                  \
                for (size_t j = 0; j < m; ++j)                                                                    \
                    sum[j] += w[k] * (float)((wide)a[j] - (wide)b[j]);                                            \
            }                                                                                                     \
            memcpy(out + x, sum, m * sizeof *sum);                                                                \
        }                                                                                                         \
    }
/* clang-format on */

ISO_SAMPLE_TYPES(PAIRS)

_Static_assert((int)REACH <= (int)ISO_GRADIENT_MOST_REACH, "scratch rows are too short");

static void inside_across(const iso_planes *p, bool along_z, size_t y, size_t z, float *restrict out)
{
    const void *before[REACH], *after[REACH];
    float w[REACH];
    const size_t n = p->size[0];
    interior_weights(w);
    for (size_t k = 1; k <= REACH; ++k) {
        before[k - 1] = along_z ? iso_planes_row_at(p, y, z - k) : iso_planes_row_at(p, y - k, z);
        after[k - 1] = along_z ? iso_planes_row_at(p, y, z + k) : iso_planes_row_at(p, y + k, z);
    }
    switch (p->type) {
#define PAIRS_OF(type, suffix, ctype, wide) \
    case type: pairs_##suffix(before, after, w, n, out); break;
        ISO_SAMPLE_TYPES(PAIRS_OF)
#undef PAIRS_OF
    }
}

/* Computes the derivative along y or z at the row (y, z). */
static void across(const iso_planes *p, bool along_z, size_t y, size_t z, float *row, float *restrict out)
{
    const size_t i = along_z ? z : y, n = p->size[along_z ? 2 : 1];
    float w[2 * REACH + 1];
    if (i >= REACH && i + REACH < n) {
        inside_across(p, along_z, y, z, out);
        return;
    }
    memset(out, 0, p->size[0] * sizeof *out);
    if (n == 1)
        return;
    folded_weights(i, n, w);
    for (size_t j = 0; j <= 2 * REACH; ++j) {
        if (w[j] == 0 || i + j < REACH || i + j - REACH >= n)
            continue;
        iso_planes_row(p, along_z ? y : i + j - REACH, along_z ? i + j - REACH : z, row);
        iso_add_weighted_row(w[j], row, p->size[0], out);
    }
}

ISO_SIMD static void filter_padded(const float w[REACH], const float *restrict padded, size_t n, float *restrict out)
{
    const float *at = padded + REACH;
    for (size_t x = 0; x < n; ++x) {
        float sum = 0;
        for (int k = 1; k <= REACH; ++k)
            sum += w[k - 1] * (at[(ptrdiff_t)x + k] - at[(ptrdiff_t)x - k]);
        out[x] = sum;
    }
}

static void along(const iso_planes *p, size_t y, size_t z, float *padded, float *restrict out)
{
    const size_t n = p->size[0];
    float w[REACH], *row = padded + REACH;
    double e[EDGE];
    interior_weights(w);
    iso_planes_row(p, y, z, row);
    for (size_t k = 1; k <= REACH; ++k) {
        double left = 0, right = 0;
        outside_weights(k, n, e);
        for (size_t s = 0; s < EDGE && s < n; ++s) {
            left += e[s] * (double)row[s];
            right += e[s] * (double)row[n - 1 - s];
        }
        row[-(ptrdiff_t)k] = (float)left;
        row[n - 1 + k] = (float)right;
    }
    filter_padded(w, padded, n, out);
}

static void bspline_row(const iso_planes *p, iso_gradient_method method, const iso_gradient_matrix *matrix, size_t y,
                        size_t z, float *scratch, float *const g[3])
{
    (void)method;
    along(p, y, z, scratch, g[0]);
    across(p, false, y, z, scratch, g[1]);
    across(p, true, y, z, scratch, g[2]);
    iso_gradient_to_world(matrix, p->size[0], g[0], g[1], g[2]);
}

const iso_gradient_info iso_gradient_bspline = {
    .name = "bspline",
    .summary = "of the interpolating cubic B-spline (recursive pre-filter), 72 samples",
    .samples = 6 * REACH,
    .order = 4,
    .reach = REACH,
    .row = bspline_row,
};

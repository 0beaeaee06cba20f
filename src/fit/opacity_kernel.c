/* SPDX-License-Identifier: MIT */
#include "fit/opacity_kernel.h"

#include <stdint.h>
#include <string.h>

#include "base/simd.h"

/* Returns 2^x for |x| < 126, relative error below 2e-7: the nearest whole power and a polynomial of the rest (Cephes'
 * exp2f). */
static inline __attribute__((always_inline)) float power_of_two(float x)
{
    const int32_t biased = (int32_t)(x + 127.5f);
    const float f = x - (float)(biased - 127);
    const uint32_t bits = (uint32_t)biased << 23;
    float whole;
    memcpy(&whole, &bits, sizeof whole);
    float p = 1.535336188319500e-4f;
    p = p * f + 1.339887440266574e-3f;
    p = p * f + 9.618437357674640e-3f;
    p = p * f + 5.550332471162809e-2f;
    p = p * f + 2.402264791363012e-1f;
    p = p * f + 6.931472028550421e-1f;
    return whole * (p * f + 1);
}

/* A place in the table, and the integral from its entry to there. */
typedef struct place {
    int32_t entry;
    float part;
} place;

static inline __attribute__((always_inline)) place place_of(const iso_depth_table *t, float x)
{
    float inside = x > 0 ? x : 0;
    inside = inside < t->last ? inside : t->last;
    const int32_t i = (int32_t)inside;
    const float f = inside - (float)i, depth = t->depth[i] + f * t->slope[i];
    return (place){i, f * 0.5f * (t->depth[i] + depth) + (x - inside) * depth};
}

/* Returns the mean depth over a range. Narrow ranges are widened a little: their integral would be all rounding. */
static inline __attribute__((always_inline)) float depth_of(const iso_depth_table *t, float value, float width)
{
    const float narrow = 1.0f / 64, wide = width * t->entries_per_value;
    const float range = wide > narrow ? wide : narrow, x = (value - t->lo) * t->entries_per_value;
    const place a = place_of(t, x - 0.5f * range), b = place_of(t, x + 0.5f * range);
    const float whole = (t->sum[b.entry] - t->sum[a.entry]) + (t->rest[b.entry] - t->rest[a.entry]);
    const float depth = (whole + (b.part - a.part)) / range;
    return depth > 0 ? depth : 0;
}

static inline __attribute__((always_inline)) float opacity_of(float depth)
{
    return 1 - power_of_two(depth < 125 ? -depth : -125.0f);
}

ISO_SIMD void iso_opacity_row(const iso_depth_table *table, const float *restrict value, const float *restrict width,
                              size_t n, float *restrict alpha)
{
    const iso_depth_table t = *table;
    for (size_t i = 0; i < n; ++i)
        alpha[i] = opacity_of(depth_of(&t, value[i], width[i]));
}

ISO_SIMD void iso_opacity_row_scaled(const iso_depth_table *table, const float *restrict value,
                                     const float *restrict width, const float *restrict octaves, size_t n,
                                     float *restrict alpha)
{
    const iso_depth_table t = *table;
    for (size_t i = 0; i < n; ++i)
        alpha[i] = opacity_of(depth_of(&t, value[i], width[i]) * power_of_two(octaves[i]));
}

ISO_SIMD static void slope_inside(const iso_stencil_rows *r, size_t first, size_t count, float *restrict slope)
{
    const float *restrict m = r->middle + first;
    const float *restrict y0 = r->y[0] + first, *restrict y1 = r->y[1] + first;
    const float *restrict z0 = r->z[0] + first, *restrict z1 = r->z[1] + first;
    const float sy = r->y_scale, sz = r->z_scale;
    for (size_t i = 0; i < count; ++i) {
        const float x = 0.5f * (m[i + 1] - (m - 1)[i]), y = sy * (y1[i] - y0[i]), z = sz * (z1[i] - z0[i]);
        slope[i] = __builtin_sqrtf(x * x + y * y + z * z);
    }
}

/* Returns the slope at an end of a row; along x it is the difference between the voxels `from` and `to`. */
static float slope_at_end(const iso_stencil_rows *r, size_t at, size_t from, size_t to)
{
    const float x = r->middle[to] - r->middle[from], y = r->y_scale * (r->y[1][at] - r->y[0][at]),
                z = r->z_scale * (r->z[1][at] - r->z[0][at]);
    return __builtin_sqrtf(x * x + y * y + z * z);
}

void iso_slope_row(const iso_stencil_rows *rows, size_t first, size_t count, size_t row_length, float *restrict slope)
{
    const size_t end = first + count, begin_inside = first > 0 ? first : 1;
    const size_t end_inside = end < row_length ? end : row_length - 1;
    if (begin_inside < end_inside)
        slope_inside(rows, begin_inside, end_inside - begin_inside, slope + (begin_inside - first));
    if (first == 0)
        slope[0] = slope_at_end(rows, 0, 0, row_length > 1 ? 1 : 0);
    if (end == row_length)
        slope[count - 1] = slope_at_end(rows, end - 1, row_length > 1 ? end - 2 : 0, end - 1);
}

ISO_SIMD float iso_square_distance(const float *restrict a, const float *restrict b, size_t n)
{
    enum { lanes = 8 };
    float part[lanes] = {0}, sum = 0;
    size_t i = 0;
    for (; i + lanes <= n; i += lanes)
        for (size_t k = 0; k < lanes; ++k)
            part[k] += (a[i + k] - b[i + k]) * (a[i + k] - b[i + k]);
    for (size_t k = 0; i + k < n; ++k)
        part[k] += (a[i + k] - b[i + k]) * (a[i + k] - b[i + k]);
    for (size_t k = 0; k < lanes; ++k)
        sum += part[k];
    return sum;
}

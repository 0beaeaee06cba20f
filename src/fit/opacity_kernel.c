/* SPDX-License-Identifier: MIT */
#include "fit/opacity_kernel.h"

#include <stdint.h>
#include <string.h>

#include "base/simd.h"

/* 2^x for |x| < 126, relative error below 2e-7: the nearest whole power and a polynomial of the rest (Cephes' exp2f). */
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

static inline __attribute__((always_inline)) float depth_of(const iso_depth_table *t, float value)
{
    float x = (value - t->lo) * t->entries_per_value;
    x = x > 0 ? x : 0;
    x = x < t->last ? x : t->last;
    const int32_t i = (int32_t)x;
    return t->depth[i] + (x - (float)i) * t->slope[i];
}

static inline __attribute__((always_inline)) float opacity_of(float depth)
{
    return 1 - power_of_two(depth < 125 ? -depth : -125.0f);
}

ISO_SIMD void iso_opacity_row(const iso_depth_table *table, const float *restrict value, size_t n,
                              float *restrict alpha)
{
    const iso_depth_table t = *table;
    for (size_t i = 0; i < n; ++i)
        alpha[i] = opacity_of(depth_of(&t, value[i]));
}

ISO_SIMD void iso_opacity_row_scaled(const iso_depth_table *table, const float *restrict value,
                                     const float *restrict octaves, size_t n, float *restrict alpha)
{
    const iso_depth_table t = *table;
    for (size_t i = 0; i < n; ++i)
        alpha[i] = opacity_of(depth_of(&t, value[i]) * power_of_two(octaves[i]));
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

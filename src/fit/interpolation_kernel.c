/* SPDX-License-Identifier: MIT */
#include "fit/interpolation_kernel.h"

#include "base/simd.h"

ISO_SIMD void iso_interpolation_blend(const float *restrict a, const float *restrict b, float w, size_t n,
                                      float *restrict out)
{
    for (size_t i = 0; i < n; ++i)
        out[i] = a[i] + w * (b[i] - a[i]);
}

ISO_SIMD void iso_interpolation_add(const float *restrict row, float w, size_t n, float *restrict sum)
{
    for (size_t i = 0; i < n; ++i)
        sum[i] += w * row[i];
}

ISO_SIMD void iso_interpolation_expand(const iso_interpolation_axis *axis, const float *restrict row,
                                       float *restrict fine)
{
    const uint32_t *restrict low = axis->low, *restrict high = axis->high;
    const float *restrict weight = axis->weight;
    for (size_t i = 0; i < axis->fine_size; ++i)
        fine[i] = row[low[i]] + weight[i] * (row[high[i]] - row[low[i]]);
}

void iso_interpolation_contract(const iso_interpolation_axis *axis, const float *restrict fine, float *restrict row)
{
    for (size_t j = 0; j < axis->coarse_size; ++j) {
        const float *tap = axis->tap + axis->tap_start[j], *from = fine + axis->first[j];
        const size_t count = axis->tap_start[j + 1] - axis->tap_start[j];
        float sum = 0;
        for (size_t t = 0; t < count; ++t)
            sum += tap[t] * from[t];
        row[j] += sum;
    }
}

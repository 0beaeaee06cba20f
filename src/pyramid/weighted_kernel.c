/* SPDX-License-Identifier: MIT */
#include "pyramid/weighted_kernel.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "base/simd.h"

ISO_SIMD static void weigh(const float *restrict gx, const float *restrict gy, const float *restrict gz, size_t n,
                           float *restrict w, float *restrict dx, float *restrict dy, float *restrict dz)
{
    for (size_t i = 0; i < n; ++i) {
        const float x = gx[i], y = gy[i], z = gz[i], m2 = x * x + y * y + z * z, m = sqrtf(m2);
        w[i] = m2;
        dx[i] = m * x;
        dy[i] = m * y;
        dz[i] = m * z;
    }
}

void iso_weighted_row(float *const g[3], size_t n, float *restrict w, float *const wd[3])
{
    weigh(g[0], g[1], g[2], n, w, wd[0], wd[1], wd[2]);
}

void iso_weighted_reduce_row(const unsigned *lookup, const float *part, size_t fine, size_t coarse,
                             const float *restrict w, float *const wd[3], float *restrict out)
{
    float *restrict weight = out, *restrict same = out + 4 * coarse, *restrict next = out + 5 * coarse;
    memset(out, 0, ISO_WEIGHTED_REDUCED * coarse * sizeof *out);
    for (size_t i = 0; i < fine; ++i) {
        const size_t j = lookup[i], after = part[i] > 0 ? j + 1 : j;
        const float f = part[i], upper = f * w[i], lower = w[i] - upper;
        weight[j] += lower;
        weight[after] += upper;
        same[j] += lower * (1 - f);
        same[after] += upper * f;
        next[j] += lower * f;
    }
    for (size_t c = 0; c < 3; ++c) {
        const float *restrict d = wd[c];
        float *restrict b = out + (1 + c) * coarse;
        for (size_t i = 0; i < fine; ++i) {
            const size_t j = lookup[i], after = part[i] > 0 ? j + 1 : j;
            const float upper = part[i] * d[i];
            b[j] += d[i] - upper;
            b[after] += upper;
        }
    }
}

ISO_SIMD static void subtract(const float *restrict same, const float *restrict next, const float *restrict value,
                              size_t n, float *restrict residual)
{
    residual[0] -= same[0] * value[0] + (n > 1 ? next[0] * value[1] : 0);
    for (size_t i = 1; i + 1 < n; ++i)
        residual[i] -= same[i] * value[i] + (next[i] * value[i + 1] + next[i - 1] * value[i - 1]);
    if (n > 1)
        residual[n - 1] -= same[n - 1] * value[n - 1] + next[n - 2] * value[n - 2];
}

void iso_weighted_subtract(const float *restrict same, const float *restrict next, const float *restrict values,
                           size_t value_stride, size_t n, float *restrict residual, size_t stride)
{
    for (size_t c = 0; c < 3; ++c)
        subtract(same, next, values + c * value_stride, n, residual + c * stride);
}

ISO_SIMD void iso_weighted_step(float keep, float gain, const float *restrict weight, const float *restrict residual,
                                size_t n, float *restrict step, const float *before, float *after)
{
    for (size_t i = 0; i < n; ++i) {
        float inverse = 1 / weight[i];
        inverse = weight[i] >= FLT_MIN ? inverse : 0;
        const float s = keep * step[i] + gain * (residual[i] * inverse);
        step[i] = s;
        after[i] = before[i] + s;
    }
}

ISO_SIMD static void shorten(float *restrict dx, float *restrict dy, float *restrict dz, size_t n)
{
    for (size_t i = 0; i < n; ++i) {
        const float length = sqrtf(dx[i] * dx[i] + dy[i] * dy[i] + dz[i] * dz[i]);
        const float factor = length > 1 ? 1 / length : length;
        dx[i] *= factor;
        dy[i] *= factor;
        dz[i] *= factor;
    }
}

void iso_weighted_shorten(float *const d[3], size_t n)
{
    shorten(d[0], d[1], d[2], n);
}

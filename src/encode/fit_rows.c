/* SPDX-License-Identifier: MIT */
/* fit_rows.c - the codes "fit" and "snorm" over rows of components, in plain C that the
 * compiler vectorizes for each instruction set, with the same bytes for all. */
#include "encode/code_kernel.h"

#include <math.h>

#include "base/simd.h"
#include "encode/fit.h"

#define INLINE static inline __attribute__((always_inline))

/* Returns the best candidate for the largest component among whole numbers from `first` on. (b, c): the smaller
 * components of the unit vector; (b_step, c_step): those of the ray at largest component 1; step: the length there.
 * With r = candidate - aim u, along = r . u, the cost is |r|^2 - along^2 + mu^2 along^2; the largest component itself
 * is exact. Eight parameters instead of a struct: inlined into the loop over rows, each is one vector register. */
INLINE float best_candidate(float b, float c, float b_step, float c_step, float step, float aim, float weight,
                            float first)
{
    float best = INFINITY, best_at = 0;
    for (int k = 0; k <= ISO_FIT_BELOW + ISO_FIT_ABOVE; ++k) {
        const float at = first + (float)k, eb = at * b_step, ec = at * c_step;
        const float rb = rintf(eb) - eb, rc = rintf(ec) - ec, along = rb * b + rc * c;
        const float radial = (at * step - aim) + along;
        const float cost = (rb * rb + rc * rc) + (weight * (radial * radial) - along * along);
        best_at = cost < best ? at : best_at;
        best = cost < best ? cost : best;
    }
    return best_at;
}

/* Returns the three bytes of one direction in a word. mu grows for shorter vectors, whose directions are less reliable,
 * as neighbors differ (fit.h). */
INLINE uint32_t fit_word(float x, float y, float z)
{
    const float length = sqrtf(x * x + y * y + z * z), ax = fabsf(x), ay = fabsf(y), az = fabsf(z);
    const float xy = ax < ay ? ay : ax, b = ax < ay ? ax : ay; /* b and c: the two smaller ones, in any order */
    const float high = xy < az ? az : xy, c = xy < az ? xy : az;
    const float product = length * high, both = 1 / (product > 1e-30f ? product : 1e-30f);
    const float per_length = both * high, per_high = both * length;
    const float slack = (float)ISO_FIT_MU + (float)ISO_FIT_MU_SHORT * (length < 1 ? 1 - length : 0),
                mu = slack < 1 ? slack : 1;
    const float below = floorf(127 * high), limit = 127 - ISO_FIT_ABOVE;
    const float first = (below < limit ? below : limit) - ISO_FIT_BELOW;
    const float s = per_high * best_candidate(b * per_length, c * per_length, b * per_high, c * per_high,
                                              length * per_high, 127 * length, mu * mu, first);
    return ((uint32_t)(int32_t)rintf(s * x) & 0xFF) | ((uint32_t)(int32_t)rintf(s * y) & 0xFF) << 8 |
           ((uint32_t)(int32_t)rintf(s * z) & 0xFF) << 16;
}

ISO_SIMD void iso_fit_rows(const float *restrict x, const float *restrict y, const float *restrict z, size_t count,
                           uint32_t *restrict words)
{
    for (size_t i = 0; i < count; ++i)
        words[i] = fit_word(x[i], y[i], z[i]);
}

void iso_fit_rows_baseline(const float *restrict x, const float *restrict y, const float *restrict z, size_t count,
                           uint32_t *restrict words)
{
    for (size_t i = 0; i < count; ++i)
        words[i] = fit_word(x[i], y[i], z[i]);
}

/* ---- snorm ---- */

/* Adds 1.5 x 2^23, which leaves the nearest integer (ties to even, as lrintf) in the
 * low bits. Needs no clamp: |d| exceeds 1 by a few roundings at most. */
static inline uint32_t snorm_byte(float d)
{
    union {
        float f;
        uint32_t u;
    } bits = {.f = 127 * d + 12582912.0f};
    return bits.u & 0xFF;
}

ISO_SIMD void iso_snorm_rows(const float *restrict x, const float *restrict y, const float *restrict z, size_t count,
                             uint32_t *restrict words)
{
    for (size_t i = 0; i < count; ++i)
        words[i] = snorm_byte(x[i]) | snorm_byte(y[i]) << 8 | snorm_byte(z[i]) << 16;
}

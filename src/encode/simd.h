/* SPDX-License-Identifier: MIT */
/* simd.h - eight floats at a time by the compiler's vectors: one source for every
 * instruction set. A kernel is an always_inline body, instantiated for AVX2 and for the
 * baseline and chosen at run time (ISO_SIMD_ENCODER). Products and sums are not fused,
 * except in one kernel that states it: both instances give the same bytes. */
#pragma once

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "base/simd.h"

enum { ISO_LANES = 8 };
typedef float v8f __attribute__((vector_size(32)));
typedef int32_t v8i __attribute__((vector_size(32)));

#define ISO_INLINE static inline __attribute__((always_inline))

ISO_INLINE v8f v8_set(float x)
{
    return (v8f){x, x, x, x, x, x, x, x};
}
ISO_INLINE v8f v8_load(const float *p)
{
    v8f v;
    memcpy(&v, p, sizeof v);
    return v;
}
ISO_INLINE void v8_store(float *p, v8f v)
{
    memcpy(p, &v, sizeof v);
}
/* Returns mask ? a : b for each lane; comparisons give masks. */
ISO_INLINE v8f v8_select(v8i mask, v8f a, v8f b)
{
    return (v8f)((mask & (v8i)a) | (~mask & (v8i)b));
}
ISO_INLINE v8f v8_abs(v8f a)
{
    return (v8f)((v8i)a & 0x7fffffff);
}
ISO_INLINE v8f v8_max(v8f a, v8f b)
{
    return v8_select(a < b, b, a);
}
ISO_INLINE v8f v8_min(v8f a, v8f b)
{
    return v8_select(b < a, b, a);
}
/* Rounds to the nearest whole number, ties to even; |a| < 2^22. */
ISO_INLINE v8f v8_round(v8f a)
{
    return (a + 12582912.0f) - 12582912.0f;
}

ISO_INLINE v8f v8_sqrt(v8f a)
{
    for (int i = 0; i < ISO_LANES; ++i)
        a[i] = sqrtf(a[i]);
    return a;
}

/* Directions in planes, one block at a time. */
enum { ISO_BLOCK = 128 };
typedef struct iso_block {
    float x[ISO_BLOCK], y[ISO_BLOCK], z[ISO_BLOCK];
} iso_block;

/* Loads count directions and fills the rest of the block with zeros. */
ISO_INLINE void iso_block_load(iso_block *b, const float *restrict directions, size_t count)
{
    if (count < ISO_BLOCK)
        memset(b, 0, sizeof *b);
    for (size_t i = 0; i < count; ++i) {
        b->x[i] = directions[3 * i];
        b->y[i] = directions[3 * i + 1];
        b->z[i] = directions[3 * i + 2];
    }
}

/* Converts whole numbers, -128 to 255, to bytes. */
ISO_INLINE void iso_block_store(const iso_block *b, uint8_t *restrict bytes, size_t count)
{
    for (size_t i = 0; i < count; ++i) {
        bytes[3 * i] = (uint8_t)(int)b->x[i];
        bytes[3 * i + 1] = (uint8_t)(int)b->y[i];
        bytes[3 * i + 2] = (uint8_t)(int)b->z[i];
    }
}

/* Defines NAME(directions, bytes, count) and NAME_baseline, the same without AVX2.
 * LANES(x, y, z) is an always_inline function that converts eight directions to the
 * values of their bytes, in place. */
#define ISO_SIMD_ENCODER(NAME, LANES) ISO_SIMD_ENCODER_FOR(NAME, LANES, "avx2", "avx2")

/* The same for TARGET, chosen if the machine has FEATURE too. */
/* clang-format off */
#define ISO_SIMD_ENCODER_FOR(NAME, LANES, TARGET, FEATURE)                                                 \
    ISO_FOR(TARGET) static void NAME##_fast(const float *restrict directions, uint8_t *restrict bytes,    \
                                            size_t count)                                                 \
    {                                                                                                     \
        ISO_SIMD_BLOCKS(LANES)                                                                            \
    }                                                                                                     \
    void NAME##_baseline(const float *restrict directions, uint8_t *restrict bytes, size_t count)         \
    {                                                                                                     \
        ISO_SIMD_BLOCKS(LANES)                                                                            \
    }                                                                                                     \
    void NAME(const float *restrict directions, uint8_t *restrict bytes, size_t count)                    \
    {                                                                                                     \
        if (ISO_HAS("avx2") && ISO_HAS(FEATURE))                                                          \
            NAME##_fast(directions, bytes, count);                                                        \
        else                                                                                              \
            NAME##_baseline(directions, bytes, count);                                                    \
    }

#define ISO_SIMD_BLOCKS(LANES)                                                            \
    for (size_t start = 0; start < count; start += ISO_BLOCK) {                           \
        size_t n = count - start < ISO_BLOCK ? count - start : ISO_BLOCK;                 \
        iso_block b;                                                                      \
        iso_block_load(&b, directions + 3 * start, n);                                    \
        for (size_t i = 0; i < n; i += ISO_LANES)                                         \
            LANES(b.x + i, b.y + i, b.z + i);                                             \
        iso_block_store(&b, bytes + 3 * start, n);                                        \
    }
/* clang-format on */

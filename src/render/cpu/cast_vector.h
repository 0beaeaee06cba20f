/* SPDX-License-Identifier: MIT */
/* cast_vector.h - as many floats or integers as the packet has rays (ISO_CAST_WIDTH), and the operations that C
 * lacks for them. Every operation is that of IEEE 754 lane by lane, and none is fused, so that all widths give the
 * same bits. */
#pragma once

#include <math.h>
#include <stdint.h>
#include <string.h>

#if ISO_CAST_WIDTH >= 8
#include <immintrin.h>
#endif

#define CAST static inline __attribute__((always_inline))

typedef float vf __attribute__((vector_size(4 * ISO_CAST_WIDTH)));
typedef int32_t vi __attribute__((vector_size(4 * ISO_CAST_WIDTH)));
typedef uint32_t vu __attribute__((vector_size(4 * ISO_CAST_WIDTH)));

/* Selects `yes` where the mask is -1, `no` where it is 0. */
CAST vi select_int(vi mask, vi yes, vi no)
{
    return (mask & yes) | (~mask & no);
}
CAST vf select_float(vi mask, vf yes, vf no)
{
    return (vf)select_int(mask, (vi)yes, (vi)no);
}

CAST vf all_float(float x)
{
    return x - (vf){0};
}
CAST vi all_int(int32_t x)
{
    return x - (vi){0};
}
CAST vf to_float(vi x)
{
    return __builtin_convertvector(x, vf);
}
CAST vi to_int(vf x) /* towards 0 */
{
    return __builtin_convertvector(x, vi);
}
CAST vf absolute(vf x)
{
    return (vf)((vi)x & 0x7fffffff);
}
CAST vf lerp(vf a, vf b, vf t)
{
    return a + t * (b - a);
}

#if ISO_CAST_WIDTH == 16
CAST bool any(vi mask)
{
    return _mm512_test_epi32_mask((__m512i)mask, (__m512i)mask) != 0;
}
CAST vf least(vf a, vf b)
{
    return (vf)_mm512_min_ps((__m512)a, (__m512)b);
}
CAST vf most(vf a, vf b)
{
    return (vf)_mm512_max_ps((__m512)a, (__m512)b);
}
CAST vf root(vf x)
{
    return (vf)_mm512_sqrt_ps((__m512)x);
}
CAST vf round_down(vf x)
{
    return (vf)_mm512_roundscale_ps((__m512)x, _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC);
}
#define GATHER(base, at, bytes) ((vi)_mm512_i32gather_epi32((__m512i)(at), (base), bytes))
#elif ISO_CAST_WIDTH == 8
CAST bool any(vi mask)
{
    return _mm256_movemask_ps((__m256)mask) != 0;
}
CAST vf least(vf a, vf b)
{
    return (vf)_mm256_min_ps((__m256)a, (__m256)b);
}
CAST vf most(vf a, vf b)
{
    return (vf)_mm256_max_ps((__m256)a, (__m256)b);
}
CAST vf root(vf x)
{
    return (vf)_mm256_sqrt_ps((__m256)x);
}
CAST vf round_down(vf x)
{
    return (vf)_mm256_floor_ps((__m256)x);
}
#define GATHER(base, at, bytes) ((vi)_mm256_i32gather_epi32((const int *)(const void *)(base), (__m256i)(at), bytes))
#else
CAST bool any(vi mask)
{
    int32_t sum = 0;
    for (int i = 0; i < ISO_CAST_WIDTH; ++i)
        sum |= mask[i];
    return sum != 0;
}
CAST vf least(vf a, vf b)
{
    return select_float(a < b, a, b);
}
CAST vf most(vf a, vf b)
{
    return select_float(a > b, a, b);
}
CAST vf root(vf x)
{
    for (int i = 0; i < ISO_CAST_WIDTH; ++i)
        x[i] = sqrtf(x[i]);
    return x;
}
CAST vf round_down(vf x)
{
    for (int i = 0; i < ISO_CAST_WIDTH; ++i)
        x[i] = floorf(x[i]);
    return x;
}
CAST vi gather_words(const void *base, vi at, ptrdiff_t bytes)
{
    vi word;
    for (int i = 0; i < ISO_CAST_WIDTH; ++i) {
        int32_t one;
        memcpy(&one, (const char *)base + bytes * at[i], sizeof one);
        word[i] = one;
    }
    return word;
}
#define GATHER(base, at, bytes) gather_words(base, at, bytes)
#endif

/* ---- lanes that change places ---- */

/* v[from[i]] in lane i. */
#if ISO_CAST_WIDTH == 1
#define PICK(v, from) ((void)(from), (v))
#elif defined(__clang__) /* which has no shuffle by lanes that are known at run time */
#define PICK(v, from) \
    __extension__({ \
        const __typeof__(v) pick_of = (v); \
        __typeof__(+(v)) picked = pick_of; \
        const vi pick_from = (from); \
        for (int pick_i = 0; pick_i < ISO_CAST_WIDTH; ++pick_i) \
            picked[pick_i] = pick_of[pick_from[pick_i]]; \
        picked; \
    })
#else
#define PICK(v, from) __builtin_shuffle(v, from)
#endif

CAST vi lane_numbers(void)
{
    vi numbers;
    for (int i = 0; i < ISO_CAST_WIDTH; ++i)
        numbers[i] = i;
    return numbers;
}

#if ISO_CAST_WIDTH == 16
/* Packs the lanes of the mask to the front, followed by 0; returns their number. */
CAST vi pack_lanes(vi mask, int *count)
{
    const __mmask16 bits = _mm512_test_epi32_mask((__m512i)mask, (__m512i)mask);
    *count = __builtin_popcount(bits);
    return (vi)_mm512_maskz_compress_epi32(bits, (__m512i)lane_numbers());
}
/* Returns the upper halves of the products. */
CAST vu multiply_high(vu a, vu b)
{
    const __m512i x = (__m512i)a, y = (__m512i)b;
    const __m512i even = _mm512_srli_epi64(_mm512_mul_epu32(x, y), 32);
    const __m512i odd = _mm512_mul_epu32(_mm512_srli_epi64(x, 32), _mm512_srli_epi64(y, 32));
    return (vu)_mm512_mask_blend_epi32(0xaaaa, even, odd);
}
#else
CAST vi pack_lanes(vi mask, int *count)
{
    int32_t lanes[ISO_CAST_WIDTH];
    vi packed;
    int n = 0;
    for (int i = 0; i < ISO_CAST_WIDTH; ++i) {
        lanes[n] = i;
        n -= mask[i];
    }
    memcpy(&packed, lanes, sizeof packed);
    *count = n;
    return packed & (lane_numbers() < n);
}
CAST vu multiply_high(vu a, vu b)
{
    vu high;
    for (int i = 0; i < ISO_CAST_WIDTH; ++i)
        high[i] = (uint32_t)((uint64_t)a[i] * b[i] >> 32);
    return high;
}
#endif

/* ---- words and their neighbors ---- */

/* The words base[at] and base[at + 1]: a fetch of 8 bytes takes no longer than one of 4. */
typedef struct word_pair {
    vi first, second;
} word_pair;

CAST word_pair gather_pairs(const void *base, vi at)
{
#if ISO_CAST_WIDTH == 16
    const __m512i even = _mm512_setr_epi32(0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30);
    const __m512i odd = _mm512_setr_epi32(1, 3, 5, 7, 9, 11, 13, 15, 17, 19, 21, 23, 25, 27, 29, 31);
    const __m512i x = _mm512_i32gather_epi64(_mm512_castsi512_si256((__m512i)at), base, 4);
    const __m512i y = _mm512_i32gather_epi64(_mm512_extracti64x4_epi64((__m512i)at, 1), base, 4);
    return (word_pair){(vi)_mm512_permutex2var_epi32(x, even, y), (vi)_mm512_permutex2var_epi32(x, odd, y)};
#elif ISO_CAST_WIDTH == 8
    const __m256i at_8 = (__m256i)at;
    const __m256 x = (__m256)_mm256_i32gather_epi64(base, _mm256_castsi256_si128(at_8), 4);
    const __m256 y = (__m256)_mm256_i32gather_epi64(base, _mm256_extracti128_si256(at_8, 1), 4);
    const __m256i first = (__m256i)_mm256_shuffle_ps(x, y, 0x88), second = (__m256i)_mm256_shuffle_ps(x, y, 0xdd);
    return (word_pair){(vi)_mm256_permute4x64_epi64(first, 0xd8), (vi)_mm256_permute4x64_epi64(second, 0xd8)};
#else
    return (word_pair){GATHER(base, at, 4), GATHER((const char *)base + 4, at, 4)};
#endif
}

/* The words base[n at] to base[n at + 3]. The processor's own instructions fetch at most two at a time, and take a
 * cycle or more for each: four at a time and turned are faster. */
typedef struct word_quad {
    vi word[4];
} word_quad;

#if ISO_CAST_WIDTH == 16
#define INTERLEAVE(half, bits, a, b) ((vi)_mm512_unpack##half##_epi##bits((__m512i)(a), (__m512i)(b)))
/* Those of every fourth lane. */
CAST vi every_fourth(const char *base, ptrdiff_t bytes, const int32_t *at)
{
    __m512i four = _mm512_castsi128_si512(_mm_loadu_si128((const void *)(base + bytes * at[0])));
    four = _mm512_inserti32x4(four, _mm_loadu_si128((const void *)(base + bytes * at[4])), 1);
    four = _mm512_inserti32x4(four, _mm_loadu_si128((const void *)(base + bytes * at[8])), 2);
    return (vi)_mm512_inserti32x4(four, _mm_loadu_si128((const void *)(base + bytes * at[12])), 3);
}
#elif ISO_CAST_WIDTH == 8
#define INTERLEAVE(half, bits, a, b) ((vi)_mm256_unpack##half##_epi##bits((__m256i)(a), (__m256i)(b)))
CAST vi every_fourth(const char *base, ptrdiff_t bytes, const int32_t *at)
{
    const __m256i first = _mm256_castsi128_si256(_mm_loadu_si128((const void *)(base + bytes * at[0])));
    return (vi)_mm256_inserti128_si256(first, _mm_loadu_si128((const void *)(base + bytes * at[4])), 1);
}
#elif ISO_CAST_WIDTH == 4
#define INTERLEAVE(half, bits, a, b) __builtin_shufflevector(a, b, INTERLEAVE_##half##_##bits)
#define INTERLEAVE_lo_32 0, 4, 1, 5
#define INTERLEAVE_hi_32 2, 6, 3, 7
#define INTERLEAVE_lo_64 0, 1, 4, 5
#define INTERLEAVE_hi_64 2, 3, 6, 7
CAST vi every_fourth(const char *base, ptrdiff_t bytes, const int32_t *at)
{
    vi one;
    memcpy(&one, base + bytes * at[0], sizeof one);
    return one;
}
#endif

CAST word_quad gather_quads(const void *base, vi at, int n)
{
    word_quad quad;
#if ISO_CAST_WIDTH >= 4
    int32_t index[ISO_CAST_WIDTH];
    vi lanes[4];
    memcpy(index, &at, sizeof index);
    for (int i = 0; i < 4; ++i)
        lanes[i] = every_fourth(base, 4 * (ptrdiff_t)n, index + i);
    const vi low[2] = {INTERLEAVE(lo, 32, lanes[0], lanes[1]), INTERLEAVE(lo, 32, lanes[2], lanes[3])};
    const vi high[2] = {INTERLEAVE(hi, 32, lanes[0], lanes[1]), INTERLEAVE(hi, 32, lanes[2], lanes[3])};
    quad.word[0] = INTERLEAVE(lo, 64, low[0], low[1]);
    quad.word[1] = INTERLEAVE(hi, 64, low[0], low[1]);
    quad.word[2] = INTERLEAVE(lo, 64, high[0], high[1]);
    quad.word[3] = INTERLEAVE(hi, 64, high[0], high[1]);
#else
    for (int i = 0; i < 4; ++i)
        quad.word[i] = GATHER((const char *)base + 4 * i, at, 4 * n);
#endif
    return quad;
}

CAST vf gather_floats(const float *base, vi at)
{
    return (vf)GATHER(base, at, 4);
}

/* Splits 2^t, t in [-126, 127], into two factors: a power of 2, and the remaining factor less 1, which is returned. */
CAST vf power_less_one(vf t, vf *power)
{
    const vf whole = round_down(t + 0.5f), f = t - whole;
    *power = (vf)((to_int(whole) + 127) << 23);
    /* 2^f - 1 by the Taylor series of exp(f ln 2): the term that is left out is below 2e-8 of the sum for |f| <=
     * 1/2. */
    vf sum = all_float(1.525273380e-5f);
    sum = sum * f + 1.540353039e-4f;
    sum = sum * f + 1.333355815e-3f;
    sum = sum * f + 9.618129108e-3f;
    sum = sum * f + 5.550410866e-2f;
    sum = sum * f + 2.402265070e-1f;
    sum = sum * f + 6.931471806e-1f;
    return sum * f;
}

/* Computes 1 - exp(-x) for x >= 0, with a float's digits for small x, too. */
CAST vf opacity_of(vf x)
{
    vf power;
    const vf rest = power_less_one(most(x * -1.442695041f, all_float(-126)), &power);
    return (1.0f - power) - power * rest;
}

/* Computes x^y for x in [0, 1] and y > 0; 0 below 1e-30. */
CAST vf power_of(vf x, float y)
{
    const vi tiny = x < 1e-30f, bits = (vi)x;
    /* x = m 2^e with m in [sqrt(1/2), sqrt(2)) */
    const vi e = (bits - 0x3f3504f3) >> 23;
    const vf m = (vf)(bits - (e << 23)), s = (m - 1.0f) / (m + 1.0f), z = s * s;
    /* log2 m = 2 / ln 2 (s + s^3 / 3 + s^5 / 5 ...), |s| <= 0.172 */
    vf sum = all_float(2.885390082f / 9);
    sum = sum * z + 2.885390082f / 7;
    sum = sum * z + 2.885390082f / 5;
    sum = sum * z + 2.885390082f / 3;
    sum = sum * z + 2.885390082f;
    const vf t = most(y * to_float(e) + y * (sum * s), all_float(-126));
    vf power;
    const vf rest = power_less_one(t, &power);
    return select_float(tiny, all_float(0), power + power * rest);
}

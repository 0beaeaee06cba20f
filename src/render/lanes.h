/* SPDX-License-Identifier: MIT */
/* lanes.h - eight doubles at a time, for whichever instruction set the function is compiled for. Sums and products
 * stand in one order and are not fused, so all of them give the same bits. */
#pragma once

#include <math.h>
#include <stdint.h>
#include <string.h>

#define ISO_LANES_INLINE static inline __attribute__((always_inline))

enum { LANES = 8 };
typedef double lanes __attribute__((vector_size(64)));
typedef int64_t lane_bits __attribute__((vector_size(64)));
typedef double four __attribute__((vector_size(32)));

ISO_LANES_INLINE lanes lanes_all(double x)
{
    return (lanes){x, x, x, x, x, x, x, x};
}
ISO_LANES_INLINE lanes lanes_abs(lanes x)
{
    return (lanes)((lane_bits)x & INT64_MAX);
}
ISO_LANES_INLINE lanes lanes_sqrt(lanes x)
{
    for (int i = 0; i < LANES; ++i)
        x[i] = sqrt(x[i]);
    return x;
}
/* Selects `yes` where the mask is set, else `no`. */
ISO_LANES_INLINE lanes lanes_select(lane_bits mask, lanes yes, lanes no)
{
    return (lanes)(((lane_bits)yes & mask) | ((lane_bits)no & ~mask));
}
ISO_LANES_INLINE lanes lanes_max(lanes a, lanes b)
{
    return lanes_select(a > b, a, b);
}
ISO_LANES_INLINE double lanes_sum(lanes x)
{
    return ((x[0] + x[1]) + (x[2] + x[3])) + ((x[4] + x[5]) + (x[6] + x[7]));
}
/* Computes x^n, n > 0. */
ISO_LANES_INLINE lanes lanes_power(lanes x, int n)
{
    lanes product = lanes_all(1);
    for (; n > 1; n >>= 1) {
        if (n & 1)
            product *= x;
        x *= x;
    }
    return n > 0 ? product * x : product;
}

/* exp(x) to about 2 units in the last place; x is taken as -700 to 700. x = n ln 2 + r, |r| <= ln 2 / 2, and a Taylor
 * polynomial of degree 13, whose remainder is 4e-18; ln 2 in two parts, of which n times the first is exact. */
#define ISO_LANES_EXP(TYPE, BITS, ALL, SELECT) \
    const TYPE magic = ALL(0x1.8p52), most = ALL(700), least = ALL(-700); \
    x = SELECT(x < most, x, most); \
    x = SELECT(x > least, x, least); \
    const TYPE shifted = x * 0x1.71547652b82fep0 + magic, n = shifted - magic; \
    const TYPE r = (x - n * 0x1.62e42fee00000p-1) - n * 0x1.a39ef35793c76p-33; \
    TYPE p = r * (1.0 / 6227020800.0) + 1.0 / 479001600.0; \
    p = p * r + 1.0 / 39916800.0; \
    p = p * r + 1.0 / 3628800.0; \
    p = p * r + 1.0 / 362880.0; \
    p = p * r + 1.0 / 40320.0; \
    p = p * r + 1.0 / 5040.0; \
    p = p * r + 1.0 / 720.0; \
    p = p * r + 1.0 / 120.0; \
    p = p * r + 1.0 / 24.0; \
    p = p * r + 1.0 / 6.0; \
    p = p * r + 0.5; \
    p = p * r + 1.0; \
    p = p * r + 1.0

ISO_LANES_INLINE lanes lanes_exp(lanes x)
{
    ISO_LANES_EXP(lanes, lane_bits, lanes_all, lanes_select);
    return p * (lanes)(((lane_bits)shifted << 52) + ((int64_t)1023 << 52));
}
#define ISO_LANES_ONE(x) (x)
#define ISO_LANES_PICK(condition, yes, no) ((condition) ? (yes) : (no))
/* The same of one number. */
ISO_LANES_INLINE double lane_exp(double x)
{
    ISO_LANES_EXP(double, int64_t, ISO_LANES_ONE, ISO_LANES_PICK);
    uint64_t bits;
    double power;
    memcpy(&bits, &shifted, sizeof bits);
    bits = (bits << 52) + ((uint64_t)1023 << 52);
    memcpy(&power, &bits, sizeof power);
    return p * power;
}

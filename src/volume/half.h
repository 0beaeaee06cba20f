/* SPDX-License-Identifier: MIT */
/* half.h - half floats of files; private to src/volume, for C and C++. */
#pragma once

#include <math.h>
#include <stdint.h>

static inline float iso_half_to_float(uint16_t half)
{
    const int exponent = half >> 10 & 31, mantissa = half & 1023;
    const float size = exponent == 0   ? ldexpf((float)mantissa, -24)
                       : exponent < 31 ? ldexpf((float)(mantissa + 1024), exponent - 25)
                       : mantissa == 0 ? INFINITY
                                       : NAN;
    return half & 0x8000 ? -size : size;
}

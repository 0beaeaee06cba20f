/* SPDX-License-Identifier: MIT */
/* srgb.h - the transfer curve of IEC 61966-2-1, on values clipped to [0, 1]. */
#pragma once

#include <math.h>

/* Encodes linear light as sRGB; NaN becomes 0. */
static inline double iso_srgb_encode(double linear)
{
    if (!(linear > 0))
        return 0;
    if (linear >= 1)
        return 1;
    return linear <= 0.0031308 ? 12.92 * linear : 1.055 * pow(linear, 1 / 2.4) - 0.055;
}

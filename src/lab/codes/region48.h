/* SPDX-License-Identifier: MIT */
/* region48.h - parts shared by the double-precision encoders of region48. */
#pragma once

#include <math.h>
#include <stdint.h>

#include "base/linalg.h"

/* Applies T of [diaz-garcia-2017]: converts decoded barycentrics, whose sum is 1, to those before the decoder. */
iso_vec3 iso_region48_transform(iso_vec3 barycentric);

/* Sorts the axes by |component|, largest first. */
static inline void iso_rank(const double v[3], int order[3])
{
    order[0] = 0, order[1] = 1, order[2] = 2;
    for (int pass = 0; pass < 2; ++pass)
        for (int i = 0; i < 2 - pass; ++i)
            if (fabs(v[order[i]]) < fabs(v[order[i + 1]])) {
                int swap = order[i];
                order[i] = order[i + 1];
                order[i + 1] = swap;
            }
}

static inline double iso_nearest_odd(double x)
{
    return 2 * floor(0.5 * x) + 1;
}

/* Writes the bytes of the odd (a, b, c) >= 0 for the ranks of v, with v's signs. */
static inline void iso_region48_bytes(const double v[3], const int order[3], iso_vec3 ranked, uint8_t *bytes)
{
    double odd[3] = {ranked.x, ranked.y, ranked.z};
    for (int a = 0; a < 3; ++a)
        bytes[order[a]] = (uint8_t)(int)((v[order[a]] < 0 ? 255 - odd[a] : 255 + odd[a]) / 2);
}

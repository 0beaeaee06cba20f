/* SPDX-License-Identifier: MIT */
#include "bench/growth.h"

#include <math.h>

double iso_growth_slope(const double *voxels, const double *seconds, size_t count, double start, size_t *used)
{
    double n = 0, x = 0, y = 0, xx = 0, xy = 0;
    for (size_t i = 0; i < count; ++i) {
        if (!(seconds[i] > 0) || start > ISO_GROWTH_MOST_START * seconds[i])
            continue;
        const double lx = log(voxels[i]), ly = log(seconds[i] - start);
        ++n, x += lx, y += ly, xx += lx * lx, xy += lx * ly;
    }
    if (used)
        *used = (size_t)n;
    return n >= 2 ? (n * xy - x * y) / (n * xx - x * x) : NAN;
}

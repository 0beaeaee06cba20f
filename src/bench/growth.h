/* SPDX-License-Identifier: MIT */
/* growth.h - exponent of a command's time as a power of the number of voxels. */
#pragma once

#include <stddef.h>

/* Largest start-up share of a point's time; points above it are left out. Start-up time varies between runs by a third:
 * at this share it changes a time by at most a thirtieth. The slope of two sizes, a factor of 8 apart, then changes by
 * at most .016. */
#define ISO_GROWTH_MOST_START 0.1

/* Fits the slope of log(seconds - start) over log(voxels) by least squares, over the points with a small share of
 * start. seconds: processor time; 0 or less if not measured. Returns NAN with fewer than two points. *used (may be
 * NULL): number of points in the fit. */
double iso_growth_slope(const double *voxels, const double *seconds, size_t count, double start, size_t *used);

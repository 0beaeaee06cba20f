/* SPDX-License-Identifier: MIT */
/* growth.h - by which power of the number of voxels a command's time grows. */
#ifndef ISO_BENCH_GROWTH_H
#define ISO_BENCH_GROWTH_H

#include <stddef.h>

/* Points whose time is to more than this part what any process costs are left out: that cost varies from run to run by a
 * third, which would change such a time by more than a thirtieth, and the slope of two sizes, a factor of 8 apart, by more
 * than .016. */
#define ISO_GROWTH_MOST_START 0.1

/* Least squares: the slope of log(seconds - start) by log(voxels), of the points where start is a small part of the time.
 * seconds: of processor time; 0 or less where it was not measured. NAN with fewer than two points. *used (may be NULL):
 * how many points the slope is of. */
double iso_growth_slope(const double *voxels, const double *seconds, size_t count, double start, size_t *used);

#endif

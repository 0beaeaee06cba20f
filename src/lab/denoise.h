/* SPDX-License-Identifier: MIT */
/* denoise.h - how noisy a volume is, and its values without most of the noise: what `isoshade-lab noise` takes for the truth of
 * a volume whose truth nobody knows. */
#ifndef ISO_LAB_DENOISE_H
#define ISO_LAB_DENOISE_H

#include <stddef.h>

#include "base/status.h"

/* The standard deviation of normal noise in the values: the median of the absolute second differences along all three
 * axes at once (1 -2 1 along each, a sum of squares of 216), over its normal .6745. Fields that are quadratic along some
 * axis have none. Constant neighborhoods, in which no noise can be seen, are left out. ISO_E_MEMORY. */
iso_status iso_noise_estimate(const float *values, const size_t size[3], double *deviation, iso_error *err);

/* Non-local means [buades-2005]: each value becomes a mean of those within 2 voxels along each axis, weights
 * exp(-max(d - 2 deviation^2, 0) / (.6 deviation)^2) with d the mean squared difference of the 3 x 3 x 3 voxels round both.
 * Results do not depend on threads. deviation 0: a copy. ISO_E_MEMORY. */
iso_status iso_denoise(const float *values, const size_t size[3], double deviation, float *out, iso_error *err);

#endif

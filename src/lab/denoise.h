/* SPDX-License-Identifier: MIT */
/* denoise.h - estimates and removes a volume's noise: `isoshade-lab noise` needs a ground truth of measured volumes. */
#ifndef ISO_LAB_DENOISE_H
#define ISO_LAB_DENOISE_H

#include <stddef.h>

#include "base/status.h"

/* Estimates the standard deviation of normal noise: the median absolute second difference along all three axes at once
 * (1 -2 1 along each, a sum of squares of 216), divided by .6745 as for a normal distribution. Fields that are
 * quadratic along some axis have none. Constant neighborhoods, which hide noise, are left out. Errors: ISO_E_MEMORY. */
iso_status iso_noise_estimate(const float *values, const size_t size[3], double *deviation, iso_error *err);

/* Denoises by non-local means [buades-2005]: averages values within 2 voxels along each axis with weights exp(-max(d -
 * 2 deviation^2, 0) / (.6 deviation)^2). d is the mean squared difference of the 3 x 3 x 3 voxels around both. Results
 * do not depend on threads. deviation 0: copies. Errors: ISO_E_MEMORY. */
iso_status iso_denoise(const float *values, const size_t size[3], double deviation, float *out, iso_error *err);

#endif

/* SPDX-License-Identifier: MIT */
/* interpolation_kernel.h - the loops over rows of interpolation.h. */
#pragma once

#include "fit/interpolation.h"

/* Computes out = (1 - w) a + w b, n floats. Equal values are kept exactly. */
void iso_interpolation_blend(const float *restrict a, const float *restrict b, float w, size_t n, float *restrict out);
/* Adds w row to sum, n floats. */
void iso_interpolation_add(const float *restrict row, float w, size_t n, float *restrict sum);
/* Interpolates a coarse row at the fine voxels of its axis. */
void iso_interpolation_expand(const iso_interpolation_axis *axis, const float *restrict row, float *restrict fine);
/* Adds fine voxels' sums to a coarse row: the transpose. */
void iso_interpolation_contract(const iso_interpolation_axis *axis, const float *restrict fine, float *restrict row);

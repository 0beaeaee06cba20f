/* SPDX-License-Identifier: MIT */
/* weighted_kernel.h - rows of weighted least squares in three dimensions. Cannot fail or allocate, and is free of
 * threads.
 *
 * Sought are the directions D of a coarse level whose trilinear lookup is nearest to the unit directions d of the
 * fine voxels x, each as heavy as its squared gradient w(x):
 *
 *     sum_x w(x) |sum_j hat_j(x) D_j - d(x)|^2  ->  least,      or M D = b,
 *     M_ij = sum_x w hat_i hat_j,   b_i = sum_x w hat_i d,   W_i = sum_x w hat_i = sum_j M_ij
 *
 * With weights the system is not a product of axes, unlike the scalar's (spline_kernel.h). But hat_i hat_j is a
 * product, and equal for both diagonals of a cell. So 8 of a coarse voxel's 27 entries are kept, at the lower of the
 * two voxels, indexed by whether the two differ along x, y and z. A coarse voxel has W, b (3) and these 8: 12
 * planes. */
#pragma once

#include <stddef.h>

enum { ISO_WEIGHTED_W = 0, ISO_WEIGHTED_B = 1, ISO_WEIGHTED_M = 4, ISO_WEIGHTED_PLANES = 12 };

/* Returns the row of M by whether the two voxels differ along x, y, z (0 or 1 each). */
static inline size_t iso_weighted_m(size_t dx, size_t dy, size_t dz)
{
    return ISO_WEIGHTED_M + 4 * dz + 2 * dy + dx;
}

/* Computes, for a row of n gradients, squares, and gradients times lengths, which are weighted unit directions. */
void iso_weighted_row(float *const g[3], size_t n, float *restrict w, float *const wd[3]);

/* Sums of a fine row, reduced along x: W, b (3), and M without and with a difference along x. */
enum { ISO_WEIGHTED_REDUCED = 6 };
/* Reduces a fine row. lookup, part: for each fine voxel, the coarse voxel below its center and the weight of the next
 * one, 0 if there is none (iso_spline_lookup). out: ISO_WEIGHTED_REDUCED rows, `coarse` floats apart. */
void iso_weighted_reduce_row(const unsigned *lookup, const float *part, size_t fine, size_t coarse,
                             const float *restrict w, float *const wd[3], float *restrict out);

/* Subtracts one neighboring row's part of M D from residual: b - M D of a row of n, 3 rows `stride` apart. same, next:
 * M without and with a difference along x. values: the 3 rows of D, `value_stride` apart. */
void iso_weighted_subtract(const float *restrict same, const float *restrict next, const float *restrict values,
                           size_t value_stride, size_t n, float *restrict residual, size_t stride);

/* Sets step = keep * step + gain * residual / W, and D = before + step. The term with W is 0 if W vanishes. */
void iso_weighted_step(float keep, float gain, const float *restrict weight, const float *restrict residual, size_t n,
                       float *restrict step, const float *before, float *after);
/* Shortens D of length L to the stored D L: at most 1, and shorter if gradients disagree, as with moments. */
void iso_weighted_shorten(float *const d[3], size_t n);

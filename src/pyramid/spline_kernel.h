/* SPDX-License-Identifier: MIT */
/* spline_kernel.h - least-squares fits of linear splines along one axis. Cannot fail or allocate, and is free of
 * threads.
 *
 * A renderer looks up a coarse level between its voxels' centers, linearly, and clamped to the outermost centers. Along
 * an axis, its value at the center of fine voxel i is
 *
 *     s(i) = (1 - f) c[j] + f c[j + 1],   u = (i + 1/2) / r - 1/2 clamped to [0, m - 1],   j + f = u,   r = 2^k,
 *
 * or s = A c with two entries in a row of A. The coefficients nearest to the fine values v are c = (A^T A)^-1 A^T v,
 * and A^T A is tridiagonal [unser-1993]. In three dimensions A and its inverse are Kronecker products of the three
 * axes: solving one axis after the other is exact.
 *
 *     fine      |  0  |  1  |  2  |  3  |  4  |  5  |  6  |  7  |          r = 4
 *     coarse    |           0           |           1           |
 *     interval        0     |           1           |     2                r wide, shifted by half of it
 *
 * Both sides are divided by r, so that neither sums nor matrix grow with the level. */
#pragma once

#include <stddef.h>

typedef struct iso_spline_axis {
    size_t fine, coarse, ratio; /* voxels of level 0, voxels of level k, 2^k */
} iso_spline_axis;

/* Returns the coarse voxel j below the center of fine voxel i; f: weight of the next one, 0 if j is the last. */
size_t iso_spline_lookup(const iso_spline_axis *a, size_t i, double *f);
/* Returns the first fine voxel that the tent of coarse voxel j covers, and the one after the last. */
size_t iso_spline_first(const iso_spline_axis *a, size_t j);
size_t iso_spline_end(const iso_spline_axis *a, size_t j);
/* Returns the number of coarse voxels whose fine ones are all below `end`. */
size_t iso_spline_summed(const iso_spline_axis *a, size_t end);

/* One equation of a tridiagonal system after elimination: c = (b - below * c_before) * inverse, then
 * c -= above * c_after. */
typedef struct iso_spline_row {
    float below, inverse, above;
} iso_spline_row;

/* Eliminates the equations of coarse voxels j0 .. j1 - 1. If the range ends inside the volume, the coefficients beyond
 * are taken to equal the last one. That error decays to a third per voxel or faster. */
void iso_spline_factorize(const iso_spline_axis *a, size_t j0, size_t j1, iso_spline_row *rows);

/* Solves for `lanes` columns at once, in place: equation i of them stands at values + i * stride. */
void iso_spline_solve(const iso_spline_row *rows, size_t count, float *values, size_t stride, size_t lanes);
/* Solves along x for up to ISO_SPLINE_LANES rows, `stride` apart; scratch holds ISO_SPLINE_LANES * count floats. */
enum { ISO_SPLINE_LANES = 16 };
void iso_spline_solve_rows(const iso_spline_row *rows, size_t count, float *values, size_t stride, size_t row_count,
                           float *scratch);

/* Computes mean T and first moment U (places from 0 to 1) of n / ratio intervals of the row; *t, *u point into
 * scratch. */
void iso_spline_moments(const float *restrict row, size_t n, size_t ratio, float *restrict scratch, const float **t,
                        const float **u);

/* Contributions of a cell of s fine voxels, s a power of two up to r / 2, to coarse voxel j: by_t * T + by_u * U.
 * Returns the number of contributions, up to two. */
typedef struct iso_spline_part {
    size_t j;
    float by_t, by_u;
} iso_spline_part;
int iso_spline_cell(const iso_spline_axis *a, size_t s, size_t cell, iso_spline_part parts[2]);

/* Computes A^T v / r along x. padded, scratch: iso_spline_padded() floats; padded: v from ratio / 2 on, else zeros. */
size_t iso_spline_padded(const iso_spline_axis *a);
void iso_spline_reduce_row(const iso_spline_axis *a, const float *restrict padded, float *restrict scratch,
                           float *restrict out);

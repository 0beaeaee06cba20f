/* SPDX-License-Identifier: MIT */
/* opacity_kernel.h - opacities of rows of values, in float. */
#pragma once

#include <stddef.h>

/* A transfer function's optical depth over one length, in powers of two: opacity = 1 - 2^-depth. Linear between
 * entries, constant beyond them. */
typedef struct iso_depth_table {
    float lo, entries_per_value, last; /* the value of entry 0; and the number of the last entry */
    const float *depth, *slope;        /* of an entry; to the next one */
    const float *sum, *rest;           /* the integral up to an entry, and its remainder after rounding to a float */
} iso_depth_table;

/* Computes the opacity of n voxels, each of which holds the values from value - width / 2 to value + width / 2 in equal
 * parts: its depth is the mean over them. */
void iso_opacity_row(const iso_depth_table *table, const float *restrict value, const float *restrict width, size_t n,
                     float *restrict alpha);
/* Computes the same with 2^octaves times the depth. */
void iso_opacity_row_scaled(const iso_depth_table *table, const float *restrict value, const float *restrict width,
                            const float *restrict octaves, size_t n, float *restrict alpha);

/* Computes the length of the gradient, in values per voxel: central differences of the row in the middle and of its
 * four neighbors, low and high along y and z. Rows have n voxels. The first and the last have one-sided differences
 * unless the row goes on there. */
typedef struct iso_stencil_rows {
    const float *middle, *y[2], *z[2];
    float y_scale, z_scale; /* 1 / the distance between both */
} iso_stencil_rows;
void iso_slope_row(const iso_stencil_rows *rows, size_t first, size_t count, size_t row_length, float *restrict slope);

/* Returns sum (a - b)^2. */
float iso_square_distance(const float *restrict a, const float *restrict b, size_t n);

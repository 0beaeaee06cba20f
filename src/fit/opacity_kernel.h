/* SPDX-License-Identifier: MIT */
/* opacity_kernel.h - opacities of rows of values, in float. */
#ifndef ISO_FIT_OPACITY_KERNEL_H
#define ISO_FIT_OPACITY_KERNEL_H

#include <stddef.h>

/* A transfer function's optical depth over one length, in powers of two: opacity = 1 - 2^-depth. Linear between entries. */
typedef struct iso_depth_table {
    float lo, entries_per_value, last; /* the value of entry 0; and the number of the last entry */
    const float *depth, *slope;        /* of an entry; to the next one */
} iso_depth_table;

/* alpha = 1 - 2^(-depth(value)), n of each. */
void iso_opacity_row(const iso_depth_table *table, const float *restrict value, size_t n, float *restrict alpha);
/* alpha = 1 - 2^(-depth(value) 2^octaves). */
void iso_opacity_row_scaled(const iso_depth_table *table, const float *restrict value, const float *restrict octaves,
                            size_t n, float *restrict alpha);
/* sum (a - b)^2 */
float iso_square_distance(const float *restrict a, const float *restrict b, size_t n);

#endif

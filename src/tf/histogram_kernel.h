/* SPDX-License-Identifier: MIT */
/* histogram_kernel.h - rows of level k at the fine voxels; private to src/tf. */
#ifndef ISO_TF_HISTOGRAM_KERNEL_H
#define ISO_TF_HISTOGRAM_KERNEL_H

#include <stddef.h>
#include <stdint.h>

/* Where a fine voxel lies between two coarse ones, along one axis, clamped to the edge. */
typedef struct iso_phase {
    size_t left, right;
    float weight_left, weight_right;
} iso_phase;

iso_phase iso_phase_at(size_t fine, size_t level, size_t coarse_count);

/* A coarse row in bins: ((blend of four rows) - lo) / step + 1/2, inside [1/2, count - 1/2], so that what lies
 * between two of its values still rounds to a bin by truncation. */
typedef struct iso_row_scale {
    float lo, per_step, last; /* last = count - 1 */
} iso_row_scale;
/* out: count + 2 floats; out[0] and out[count + 1] repeat the ends. */
void iso_blend_rows(const float *const rows[4], const float weights[4], iso_row_scale scale, size_t count,
                    float *restrict out);

/* bins[x] = that row looked up at the fine voxels' centers, truncated; row: with its repeated ends. */
void iso_expand_bins(const float *row, size_t level, size_t fine_count, uint32_t *restrict bins);

/* keys[x] = keys[x] z_count + nearest bin of values[x]. */
void iso_join_bins(const float *values, size_t n, iso_row_scale scale, uint32_t z_count, uint32_t *restrict keys);

/* Adds 1 to the count of each key, by turns in two tables: an increment need not wait for the last one
 * (they may be the same table). Eight equal
 * keys are one addition: volumes have large parts of one value. */
void iso_count_keys(const uint32_t *keys, size_t n, uint32_t *even, uint32_t *odd);

#endif

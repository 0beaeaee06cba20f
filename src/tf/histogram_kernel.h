/* SPDX-License-Identifier: MIT */
/* histogram_kernel.h - rows of level k at the fine voxels; private to src/tf. */
#pragma once

#include <stddef.h>
#include <stdint.h>

/* Position of a fine voxel between two coarse ones along one axis, clamped to the edge. */
typedef struct iso_phase {
    size_t left, right;
    float weight_left, weight_right;
} iso_phase;

iso_phase iso_phase_at(size_t fine, size_t level, size_t coarse_count);

/* Scale of a coarse row in bins: ((blend of four rows) - lo) / step + 1/2, inside [1/2, count - 1/2]. Truncation then
 * rounds also values interpolated between two of them. */
typedef struct iso_row_scale {
    float lo, per_step, last; /* last = count - 1 */
} iso_row_scale;
/* Blends four rows into out, count + 2 floats; out[0] and out[count + 1] repeat the ends. */
void iso_blend_rows(const float *const rows[4], const float weights[4], iso_row_scale scale, size_t count,
                    float *restrict out);

/* Sets bins[x] to that row, with its repeated ends, looked up at the fine voxels' centers and truncated. */
void iso_expand_bins(const float *row, size_t level, size_t fine_count, uint32_t *restrict bins);

/* Sets keys[x] to keys[x] z_count + nearest bin of values[x]. */
void iso_join_bins(const float *values, size_t n, iso_row_scale scale, uint32_t z_count, uint32_t *restrict keys);

/* Adds 1 to the count of each key, alternating between two tables (which may be the same one), so that an increment
 * need not wait for the last. Eight equal keys are one addition: volumes have large parts of one value. */
void iso_count_keys(const uint32_t *keys, size_t n, uint32_t *even, uint32_t *odd);

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

/* out[x] = bilinear blend of four coarse rows, x in [0, count). */
void iso_blend_rows(const float *const rows[4], const float weights[4], size_t count, float *restrict out);

/* fine[x] = lookup of a coarse row at the fine voxels' centres. */
void iso_expand_row(const float *coarse, size_t coarse_count, size_t level, size_t fine_count, float *restrict fine);

/* bins[x] = nearest bin, clamped to [0, count). */
void iso_nearest_bins(const float *values, size_t n, float lo, float per_step, uint32_t count, uint32_t *restrict bins);

#endif

/* gradient_kernel.h - gradients of one row. Cannot fail, allocate or know of threads. */
#ifndef ISO_GRADIENT_KERNEL_H
#define ISO_GRADIENT_KERNEL_H

#include <stddef.h>

/* The rows around the row (y, z). At a border the missing neighbour is the row
 * itself and the factor 1 instead of 1/2: the one-sided difference. An axis of
 * one voxel has both neighbours equal, and so no gradient. */
typedef struct iso_gradient_rows {
    const float *here, *y0, *y1, *z0, *z1;
    float y_factor, z_factor;
} iso_gradient_rows;

/* Central differences of n voxels, times the matrix to_world (row-major), to planar rows. */
void iso_gradient_row_central(const iso_gradient_rows *rows, size_t n, const float to_world[9], float *restrict gx,
                              float *restrict gy, float *restrict gz);

#endif

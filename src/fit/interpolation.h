/* SPDX-License-Identifier: MIT */
/* interpolation.h - a coarse level's values at the centers of fine voxels, and the transpose of that map.
 *
 * A coarse grid c is sampled by trilinear interpolation between its voxels' centers, clamped at its edge, as the
 * sampler does (render/sampler.h). At the fine voxels' centers that is a linear map, (A c)(x) = sum_j hat_j(x) c_j.
 * Methods that fit a coarse grid to fine voxels need A (gather) and its transpose A^T (scatter):
 *
 *     fine      | 0 | 1 | 2 | 3 | 4 |        fine i's center lies at (i + 1/2) / 2^level - 1/2 between coarse
 *     coarse    |   0   |   1   |   2   |    centers, clamped to [0, coarse size - 1]; level 1 here: weights
 *                                            1 | 3/4 1/4 | 1/4 3/4 | 3/4 1/4 | 1/4 3/4 | for pairs of neighbors
 *
 * In:  coarse grids of coarse.size = ceil(fine.size / 2^level) floats along each axis, fine rows. x is fastest in both.
 * Out: the same. Sums are taken in float, in an order that does not depend on the number of threads.
 * Weights are a product of one along each axis, and a coarse row is expanded along x once, not once for each fine row.
 * Cost: a gather or a scatter takes about 1 to 2.5 ns per fine voxel and thread (level 3 to 1, 256^3, AVX2).
 * Memory: each thread has a few coarse planes of fine row length; nothing grows with the fine grid. */
#pragma once

#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

/* One axis. Fine voxel i lies between the coarse voxels low[i] and high[i]; they are the same at the edges. */
typedef struct iso_interpolation_axis {
    size_t fine_size, coarse_size;
    uint32_t *low, *high;
    float *weight; /* of high; low has 1 - weight */
    /* The same by coarse voxels: j has the fine voxels from first[j] on, with weights from tap[tap_start[j]]
     * on. */
    uint32_t *first, *tap_start;
    float *tap;
} iso_interpolation_axis;

typedef struct iso_interpolation {
    iso_interpolation_axis axis[3];
    size_t fine_count, coarse_count; /* voxels */
} iso_interpolation;

/* Creates the map. level: number of halvings of the sizes, rounded up, 0 to 31. ISO_E_RANGE if it is more, or a size
 * is 0 or beyond 2^31; ISO_E_MEMORY. */
iso_status iso_interpolation_create(iso_interpolation *map, const size_t fine_size[3], size_t level, iso_error *err);
void iso_interpolation_destroy(iso_interpolation *map); /* accepts empty and NULL */

/* Computes fine = A coarse: fine_count floats from coarse_count. threads: 0 = all cores. ISO_E_MEMORY. */
iso_status iso_interpolation_gather(const iso_interpolation *map, const float *coarse, float *fine, int threads,
                                    iso_error *err);
/* Computes coarse = A^T fine. */
iso_status iso_interpolation_scatter(const iso_interpolation *map, const float *fine, float *coarse, int threads,
                                     iso_error *err);

/* ---- both at once: grids in, a function of fine rows, grids out ----------------------------------------------- */

/* Fine rows are cut into runs of this many voxels, the last one of a row shorter. */
#define ISO_FIT_RUN 16

/* Consecutive runs of a fine row: voxels x to x + count - 1 of the row (y, z). values[i][v] is input i's value at
 * voxel x + v; results[o][v] is to be set, all count of them, for output o. Rows are processed in any order, by
 * several threads at once; thread counts from 0. */
typedef struct iso_fine_row {
    size_t x, y, z, count;
    const float *const *values;
    float *const *results;
    int thread;
} iso_fine_row;
typedef void iso_fine_row_function(void *context, const iso_fine_row *row);

/* outputs[o] = A^T f(A inputs[0], A inputs[1], ...), one pass over the fine voxels without a fine grid in memory. */
typedef struct iso_interpolation_pass {
    size_t input_count, output_count; /* ISO_FIT_GRIDS at most each */
    const float *const *inputs;       /* coarse_count floats each */
    float *const *outputs;            /* coarse_count floats each, overwritten */
    iso_fine_row_function *function;
    void *context;
    /* NULL, or a byte for each run, iso_interpolation_run_count() of them, run x fastest, then y, z. If it is 0 the
     * function is not called and its results count as zero. */
    const uint8_t *wanted;
} iso_interpolation_pass;
#define ISO_FIT_GRIDS 8

size_t iso_interpolation_run_count(const iso_interpolation *map);

/* Runs a pass. ISO_E_RANGE: more grids than ISO_FIT_GRIDS. ISO_E_MEMORY. */
iso_status iso_interpolation_run(const iso_interpolation *map, const iso_interpolation_pass *pass, int threads,
                                 iso_error *err);

/* SPDX-License-Identifier: MIT */
/* df3.h - POV-Ray's density files: three big-endian 16-bit sizes, then unsigned big-endian samples of 8, 16 or 32 bits,
 * x fastest. POV-Ray reads a sample as v = sample / (2^bits - 1).
 *
 * Ours have a rim of one voxel of edge values, because POV-Ray's trilinear lookup puts sample i at i / N and wraps in
 * the last cell. With the rim, and
 *     scale <nx + 2, ny + 2, nz + 2>  translate -1/2
 * the lookup at index coordinates is trilinear between voxel centers (i + 1/2) and clamped to the edge. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

/* sample = round((value - lo) / (hi - lo) (2^bits - 1)); decoded: value = lo + v (hi - lo). */
typedef struct iso_df3_coding {
    unsigned bits; /* 8, 16, 32 */
    double lo, hi; /* values of v = 0 and v = 1 */
} iso_df3_coding;

enum { ISO_DF3_MAX_CHANNELS = 3 };

/* Source of samples, read in any order by several threads at once. */
typedef struct iso_df3_source {
    size_t size[3], channels;
    /* Copies `channels` floats of each of `count` voxels from number `first` on; never beyond a row. */
    void (*read)(const void *user, size_t first, size_t count, float *out);
    /* Returns the length of the next run, 1 to count, and sets *same if its voxels all equal the first, which alone is
     * then read. NULL: one run per row. */
    size_t (*run)(const void *user, size_t first, size_t count, bool *same);
    const void *user;
    /* Called before planes [first, end) are read; no other call runs meanwhile. Planes come in order, at most `planes`
     * per call. NULL: all planes can be read at any time. */
    iso_status (*prepare)(void *user, size_t first, size_t end, iso_error *err);
    void *prepare_user;
    size_t planes;
} iso_df3_source;

/* Writes one file per channel, with a rim, in one pass over the source. Memory besides the source: one plane per
 * channel and thread. Clamps values to [lo, hi]. ISO_E_RANGE: a size above 65533. threads: 0: all cores. */
iso_status iso_df3_write_from(const iso_df3_source *s, const char *const *paths, const iso_df3_coding *coding,
                              int threads, iso_error *err);

/* Writes component `channel` of `values` (stride floats per voxel, x fastest) with a rim. Clamps values to [lo, hi].
 * ISO_E_RANGE: a size above 65533. */
iso_status iso_df3_write(const char *path, const size_t size[3], const float *values, size_t stride, size_t channel,
                         const iso_df3_coding *coding, iso_error *err);

/* Writes a table of size[0] entries in size[1] rows as a density one voxel deep, without a rim: entry i of row r is at
 * x = i / size[0], y = r / size[1]. */
iso_status iso_df3_write_table(const char *path, const size_t size[2], const float *values, size_t stride,
                               size_t channel, const iso_df3_coding *coding, iso_error *err);

/* SPDX-License-Identifier: MIT */
/* histogram.h - the joint histogram H_k(z, s) of a coarse level against level 0.
 *
 * Paper: [diaz-garcia-2016] secs. 3 and 4. For every fine voxel, z is its value
 * and s the value of level k at its center by trilinear lookup, as a renderer
 * samples level k. (With s at the coarse voxels themselves, adapting would be worse
 * than not adapting.) It depends on the volume alone: a change of the TF keeps it.
 *
 * Bins: z has 2^bits of them, s the same number but at most 4096 (a row becomes an
 * entry of a TF). Bin i is at lo + i step and takes the values nearest to it.
 * Integers whose range fits get step 1, so that each value has its own bin.
 *
 * The grid is cell-centered: voxel i of level k covers the fine voxels [i 2^k,
 * (i + 1) 2^k), so trilinear weights take 2^k phases, the same in every voxel:
 *
 *     fine      | 0 | 1 | 2 | 3 |        weights of the two coarse neighbors at
 *     level 1   |   0   |   1   |        k = 1: 1/4 3/4, 3/4 1/4, ...
 *
 * They are multiples of 2^-(k+1), so they are exact in float. s is exact as long as its
 * about 3 (2k + 1) binary places and those of the bin fit 24 bits (8-bit data, k <= 2).
 * Counts are integers, so the result does not depend on threads or slabs.
 *
 * For a 2D transfer function (tf_2d.h) each row of the histogram is divided into
 * ISO_TF_2D_ROWS bins of a second value. A homogeneous tissue and the partial voxels
 * of a thin structure may share a value s: they are counted apart. The bin is
 * (ISO_TF_2D_ROWS - 1) sqrt(q / (range / 2)), looked up like s, then rounded; q is
 *   deviation   standard deviation of the fine values in the coarse voxel, at most half the range
 *   gradient    magnitude of the level's central differences, in value per voxel,
 *               capped at half the range; needs no data of level 0
 * The square root gives more bins to small q.
 *
 * Stored as rows of (z, count), z ascending; files are dense or sparse, whichever is
 * smaller. */
#pragma once

#include <stdint.h>

#include "base/progress.h"
#include "pyramid/pyramid.h"
#include "tf/tf_2d.h"

#define ISO_JOINT_MAX_ROWS 4096

typedef enum iso_second_value {
    ISO_SECOND_VALUE_NONE = 1,
    ISO_SECOND_VALUE_DEVIATION,
    ISO_SECOND_VALUE_GRADIENT
} iso_second_value;

typedef struct iso_bins {
    size_t count;
    double lo, step;
} iso_bins;

typedef struct iso_joint {
    iso_bins z, s;
    iso_second_value second;
    size_t
        second_count; /* bins of the second value: 1 or ISO_TF_2D_ROWS; row c * s.count + i: bin i of s, bin c of it */
    uint64_t voxel_count; /* the sum of all counts */
    size_t entry_count;
    size_t *row_start; /* rows + 1: row i holds the entries [row_start[i], row_start[i + 1]) */
    uint16_t *entry_z; /* bins of z */
    uint64_t *entry_count_of;
} iso_joint;

static inline size_t iso_joint_row_count(const iso_joint *j)
{
    return j->s.count * j->second_count;
}

/* Chooses the bins for values in [min, max] of level 0. bits: 8 to 16. */
void iso_joint_bins(double min, double max, iso_type type, int bits, iso_bins *z, iso_bins *s);

/* Computes H_k of a level (at least 1). bits: 8 to 16, at most 12 with a second value. ISO_E_RANGE, ISO_E_MEMORY. */
iso_status iso_joint_compute(const iso_pyramid *p, size_t level, int bits, iso_second_value second, int threads,
                             iso_joint *joint, iso_error *err);
void iso_joint_destroy(iso_joint *joint); /* accepts empty and NULL */

/* Computes the bin of the second value for all voxels of a level, possibly fractional. ISO_E_MEMORY. */
iso_status iso_joint_second_coordinates(const iso_pyramid *p, size_t level, iso_second_value second, int threads,
                                        float *out, iso_error *err);

/* ---- files in the pyramid's folder ------------------------------------------- */

/* Saves DIR/level_K_jointBITS.nrrd; with deviation level_K_jointBITSxROWS.nrrd, with gradient
 * level_K_jointBITSgROWS.nrrd (ROWS: ISO_TF_2D_ROWS). gzip; dense (z fastest, then s), or sparse with three numbers per
 * entry: z, s, count. The file's geometry holds lo and step of the bins. */
iso_status iso_joint_save(const iso_joint *joint, const char *dir, size_t level, int bits, iso_error *err);
/* Identifies one of a pyramid's histograms. */
typedef struct iso_joint_key {
    size_t level;
    int bits;
    iso_second_value second;
} iso_joint_key;

/* True if the histogram's file exists. */
bool iso_joint_is_stored(const char *dir, const iso_joint_key *key);

/* Loads a histogram. ISO_E_IO: no file; ISO_E_FORMAT: its bins or number of voxels differ from the arguments.
 * voxel_count: 0 for any, since some have no data. */
iso_status iso_joint_load(const char *dir, const iso_joint_key *key, const iso_bins *z, const iso_bins *s,
                          uint64_t voxel_count, iso_joint *joint, iso_error *err);
/* Loads the histogram from `dir`; if it is missing or unfit, computes and stores it. dir may be NULL; a folder that
 * cannot be written is not an error. p may be the outline of the pyramid in `dir`: its samples are read when needed. */
iso_status iso_joint_obtain(const iso_pyramid *p, const char *dir, const iso_joint_key *key, int threads,
                            iso_joint *joint, iso_error *err);

/* Returns the bytes of the smaller form before compression, for Table 1. */
double iso_joint_stored_bytes(const iso_joint *joint);

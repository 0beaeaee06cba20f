/* SPDX-License-Identifier: MIT */
/* filter_kernel.h - filters of rows: from gradients to states, from states to directions. Cannot fail or allocate.
 *
 * A direction's *state* is a few floats per voxel, in planar rows, carried from level to level:
 *   moments  N (3), S      N = mean of m^2 d = m g, S = mean of m^2
 *   naive    G (3)         the mean gradient
 *   eq1      m^p G (3), m^p, m    G the filtered gradient of the level, m its length
 *   tensor   N (3), T (6)  T = mean of g g^T: xx, yy, zz, xy, xz, yz; its trace is S
 *   auto     N (3), S, T (6)   what both moments and tensor need, with the same bits
 * Row c of a state starts at state + c * stride. */
#pragma once

#include "gradient/gradient_kernel.h"
#include "pyramid/pyramid.h"

enum { ISO_FILTER_MAX_TAPS = 32, ISO_STATE_MAX = 10 };

size_t iso_state_count(iso_direction_filter f);

/* ---- Gaussian taps ---- */

/* The weights of the 2 radius fine voxels around a coarse voxel's center,
 * which lies between two of them; their sum is 1. */
typedef struct iso_taps {
    size_t count;
    float weight[ISO_FILTER_MAX_TAPS];
} iso_taps;
iso_taps iso_taps_gauss(size_t radius, double sigma);

/* Returns the fine voxel of tap t of coarse voxel i; the edge voxel is repeated. */
static inline size_t iso_taps_source(const iso_taps *taps, size_t i, size_t t, size_t fine_size)
{
    size_t at = 2 * i + t + 1; /* shifted by the radius, to stay unsigned */
    at = at > taps->count / 2 ? at - taps->count / 2 : 0;
    return at < fine_size ? at : fine_size - 1;
}

/* ---- level 0 ---- */

/* Stores the states of a row of gradients in acc, or adds them to it (not with eq1). */
void iso_state_from_gradients(iso_direction_filter f, size_t eq1_exponent, float *const g[3], size_t n,
                              float *restrict acc, size_t stride, bool add);
/* Computes unit vectors, zero for a gradient of zero, and lengths (NULL: not needed). */
void iso_unit_rows(float *const g[3], size_t n, float *const d[3], float *restrict length);
/* Stores samples as floats in acc, or adds them to it; extends range, lowest and highest, to theirs. */
void iso_scalar_row(const iso_planes *p, size_t y, size_t z, float *restrict row, float *restrict acc, bool add,
                    float range[2]);

/* ---- from level to level ---- */

/* Sets acc to row, or adds row to it. */
void iso_accumulate_row(const float *restrict row, size_t n, float *restrict acc, bool add);
void iso_double_row(float *row, size_t n);
/* Computes the 2x2x2 mean: a and b hold n sums of two rows each, and capacity for one more float. */
void iso_mean_row(float *restrict a, float *restrict b, size_t n, float *restrict out);
/* Gets the majority label of each 2x2x2; ties go to the largest. Four rows of n labels; the last label of an odd n
 * counts twice. */
void iso_majority_row(const float *const rows[4], size_t n, float *restrict out);
/* Computes the mean of those of each 2x2x2 that have data; ISO_NO_DATA if none has. Rows as above. */
void iso_valid_mean_row(const float *const rows[4], size_t n, float *restrict out);
/* Reduces n fine values to (n + 1) / 2 weighted sums; the edge value is repeated. `padded` holds n + 2 radius
 * floats. */
void iso_taps_row(const iso_taps *taps, const float *restrict row, size_t n, float *restrict padded,
                  float *restrict out);
/* Turns Eq. 1's sums of m^p G g and m^p g into the filtered gradient's own state, in place. */
void iso_eq1_finish(float *restrict state, size_t stride, size_t n, size_t exponent);

/* ---- from states to stored values ---- */

/* The components of a row's state, `stride` floats apart, and the filter that they are of. */
typedef struct iso_state_row {
    iso_direction_filter of;
    const float *components;
    size_t stride;
} iso_state_row;


/* Computes directions of a coarse level, and magnitudes (NULL: not needed). f: moments or tensor if the state is that
 * of auto. */
void iso_direction_rows(iso_direction_filter f, const iso_state_row *state, size_t n, float *const d[3],
                        float *restrict magnitude);
void iso_interleave_rows(const float *dx, const float *dy, const float *dz, size_t n, float *restrict out);
/* Packs the low three bytes of each word; `bytes` holds 3 n + 16 bytes. */
void iso_unpack_bytes(const uint32_t *packed, size_t n, uint8_t *restrict bytes);
/* Extends lo and hi to the row's values, without ISO_NO_DATA. */
void iso_row_range(const float *row, size_t n, float *lo, float *hi);
void iso_scale_row(float *row, size_t n, float factor);

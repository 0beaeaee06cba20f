/* SPDX-License-Identifier: MIT */
/* occupancy.h - bricks of a level in which a transfer function shows anything.
 *
 * A brick of n voxels per side spans [n b, n (b + 1)) in index coordinates. Its
 * range is that of every sample in it and half a voxel around, so it covers the
 * voxels n b - 1 to n (b + 1). A position that rounding moves to the wrong side
 * of a brick's face then still has its values in the range.
 *
 *     voxels   |  o  |  o  |  o  |  o  |  o  |  o  |       o  center
 *     brick          [=======================]             n = 4
 *     range       o-----o-----o-----o-----o-----o          n + 2 voxels
 *
 * A brick is empty if the TF's extinction is 0 on its whole range: its samples can
 * be left out without a change. distance[b] is 0 for occupied bricks, otherwise
 * the Chebyshev distance to the nearest one: all bricks around b that are nearer
 * than that are empty, too. */
#pragma once

#include <stdint.h>

#include "tf/tf.h"
#include "volume/geometry.h"

typedef struct iso_brick_ranges {
    size_t brick_voxels; /* n */
    size_t count[3];     /* bricks along x, y, z */
    float *min_max;      /* owned; 2 per brick, x fastest */
} iso_brick_ranges;

/* Computes the ranges. scalar: the voxels of g. ISO_E_RANGE: brick_voxels is 0; ISO_E_MEMORY. */
iso_status iso_brick_ranges_create(iso_brick_ranges *r, const float *scalar, const iso_geometry *g, size_t brick_voxels,
                                   iso_error *err);
void iso_brick_ranges_destroy(iso_brick_ranges *r); /* accepts empty and NULL */

static inline size_t iso_brick_ranges_count(const iso_brick_ranges *r)
{
    return r->count[0] * r->count[1] * r->count[2];
}

/* True if the table's extinction is above 0 anywhere on [min, max]. */
bool iso_tf_shows(const iso_tf_table *tf, double min, double max);
/* Does the same for millions of queries, with all that depends on the table computed beforehand. next: for each entry,
 * the first one from there on with an extinction, or tf->count; owned by the caller, space for tf->count. */
typedef struct iso_tf_shown {
    double lo, scale, last; /* a value's entry is (value - lo) scale, 0 to last */
    uint32_t *next;
} iso_tf_shown;
iso_tf_shown iso_tf_shown_of(const iso_tf_table *tf, uint32_t *next);

/* Computes the entries of values in [min, max], widened by 1/1000 entry, since renderers look values up in float. */
static inline void iso_tf_entries_of(const iso_tf_shown *s, double min, double max, size_t *from, size_t *to)
{
    const double last = s->last;
    double first = (min - s->lo) * s->scale - 1e-3, end = (max - s->lo) * s->scale + 1e-3;
    first = first > 0 ? (first < last ? first : last) : 0;
    end = end > 0 ? (end < last ? end : last) : 0;
    *from = (size_t)first;
    *to = (size_t)end + ((double)(size_t)end < end);
}
static inline bool iso_tf_shown_in(const iso_tf_shown *s, double min, double max)
{
    size_t from, to;
    iso_tf_entries_of(s, min, max, &from, &to);
    return s->next[from] <= to;
}

/* Fills distance (one byte per brick, at most 255) and returns the share of occupied bricks. */
double iso_occupancy_compute(const iso_brick_ranges *r, const iso_tf_table *tf, uint8_t *restrict distance);

/* Converts 0 (occupied) and 255 (empty) to distances, in place. */
void iso_occupancy_distance(const size_t count[3], uint8_t *distance);

/* Computes distances for rays with a known sign along each axis: one map for each of the eight octants of directions.
 * Bit a of an octant's number is 0 if rays go up along axis a. For an empty brick b the map has the side of the largest
 * empty cube with b in the corner where such rays enter it, at most ISO_OCTANT_MOST. Outside the volume all is empty.
 *
 *     . . . # .      a ray up and to the right from b leaves a cube of side 3; bricks behind it and at its sides do not
 *     c c c . .      count, such as one that it has just left, where the chessboard distance is still 1
 *     c c c . #
 *     b c c . .
 *     # # # . .
 *
 * occupied: 0 for occupied bricks; octants: eight bytes per brick, the octant slowest. */
enum { ISO_OCTANTS = 8, ISO_OCTANT_MOST = 63 };
void iso_occupancy_octants(const size_t count[3], const uint8_t *occupied, int threads, uint8_t *restrict octants);

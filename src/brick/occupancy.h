/* SPDX-License-Identifier: MIT */
/* occupancy.h - which bricks of a level a transfer function shows at all.
 *
 * A brick of n voxels a side spans [n b, n (b + 1)) in index coordinates. Its
 * range is that of every sample in it and half a voxel around: the voxels
 * n b - 1 to n (b + 1), so that a position that rounding puts on the wrong side
 * of a brick's face still finds its values in the range.
 *
 *     voxels   |  o  |  o  |  o  |  o  |  o  |  o  |       o  center
 *     brick          [=======================]             n = 4
 *     range       o-----o-----o-----o-----o-----o          n + 2 voxels
 *
 * A brick is empty when the TF's extinction is 0 on its whole range: leaving
 * out its samples changes nothing. distance[b] is 0 for occupied bricks, else
 * the Chebyshev distance to the nearest one: the cube of bricks nearer than
 * that around b is empty too. */
#ifndef ISO_OCCUPANCY_H
#define ISO_OCCUPANCY_H

#include <stdint.h>

#include "tf/tf.h"
#include "volume/geometry.h"

typedef struct iso_brick_ranges {
    size_t brick_voxels; /* n */
    size_t count[3];     /* bricks along x, y, z */
    float *min_max;      /* owned; 2 a brick, x fastest */
} iso_brick_ranges;

/* scalar: the voxels of g. ISO_E_RANGE for bricks of no voxel, ISO_E_MEMORY. */
iso_status iso_brick_ranges_create(iso_brick_ranges *r, const float *scalar, const iso_geometry *g, size_t brick_voxels,
                                   iso_error *err);
void iso_brick_ranges_destroy(iso_brick_ranges *r); /* accepts empty and NULL */

static inline size_t iso_brick_ranges_count(const iso_brick_ranges *r)
{
    return r->count[0] * r->count[1] * r->count[2];
}

/* False when the table's extinction is 0 on all of [min, max]. */
bool iso_tf_shows(const iso_tf_table *tf, double min, double max);
/* The same for those who ask of millions of ranges. next: of each entry, the first from there on that has an extinction,
 * tf->count where there is none; iso_tf_next_shown() fills as many numbers as there are entries. */
void iso_tf_next_shown(const iso_tf_table *tf, uint32_t *next);
bool iso_tf_shows_by(const iso_tf_table *tf, const uint32_t *next, double min, double max);

/* The same with what depends on the table alone worked out beforehand. next: filled, and kept; room for tf->count. */
typedef struct iso_tf_shown {
    double lo, scale, last; /* entry (value - lo) scale, of 0 to last */
    uint32_t *next;
} iso_tf_shown;
iso_tf_shown iso_tf_shown_of(const iso_tf_table *tf, uint32_t *next);

/* The entries that the values of [min, max] are made of: wider by a thousandth of an entry, since renderers look values up
 * in float. */
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

/* Fills distance (one byte a brick, at most 255) and returns the part of the
 * bricks that are occupied. */
double iso_occupancy_compute(const iso_brick_ranges *r, const iso_tf_table *tf, uint8_t *restrict distance);

/* Turns 0 (occupied) and 255 (empty) into distances, in place. */
void iso_occupancy_distance(const size_t count[3], uint8_t *distance);

/* Distances for rays that are known to go up or down along each axis: a map for each of the eight octants of directions,
 * the one of bit a of its number 0 for those that go up along axis a. Of an empty brick b it has the side of the largest empty
 * cube that has b in the corner where such rays enter it, at most ISO_OCTANT_MOST; what is outside the volume is empty.
 *
 *     . . . # .      a ray up and to the right from b leaves a cube of side 3; whatever is behind it or beside it,
 *     c c c . .      as what it has just left, does not count, while it holds the chessboard distance at 1
 *     c c c . #
 *     b c c . .
 *     # # # . .
 *
 * occupied: 0 where a brick is; octants: eight times as many bytes, the octant slowest. */
enum { ISO_OCTANTS = 8, ISO_OCTANT_MOST = 63 };
void iso_occupancy_octants(const size_t count[3], const uint8_t *occupied, int threads, uint8_t *restrict octants);

#endif

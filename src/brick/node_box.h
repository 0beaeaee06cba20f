/* SPDX-License-Identifier: MIT */
/* node_box.h - boxes of nodes on their way from level to level: an array of floats a channel, so that rows are filtered at
 * once. Private to src/brick.
 *
 * A node's direction comes from moments, so that there are five channels: the scalar, N = sum w m^2 d, and S = sum w m^2 of
 * the gradients m d of level 0 (bricks.h). Without directions there is the scalar alone.
 *
 *     fine     o o o o o o o o o      2 m + 3 nodes along each axis, positions beyond the level's ends clamped to them
 *     coarse       O   O   O          m; node i stands at fine node 2 i + 2 */
#ifndef ISO_NODE_BOX_H
#define ISO_NODE_BOX_H

#include <math.h>

#include "brick/bricks.h"
#include "gradient/gradient_kernel.h"

enum { ISO_BOX_SCALAR, ISO_BOX_MOMENTS, ISO_BOX_SUM = 4, ISO_BOX_CHANNELS };

typedef struct iso_node_box {
    size_t size[3], channels;
    float *values; /* a channel after the other, x fastest */
} iso_node_box;

/* Memory for boxes that one thread makes one after the other, {0} at first: pages of new memory cost more than what is
 * written to them. */
typedef enum iso_node_room_part {
    ISO_ROOM_BOX, /* the box that is asked for, and what it is filtered from */
    ISO_ROOM_FINE,
    ISO_ROOM_VOXELS, /* around a box of level 0 */
    ISO_ROOM_ROWS,   /* of the sharp filter */
    ISO_ROOM_CELLS,  /* of a brick, on their way into a lattice */
    ISO_ROOM_CORNERS,
    ISO_ROOM_PARTS
} iso_node_room_part;
typedef struct iso_node_room {
    void *parts[ISO_ROOM_PARTS]; /* owned */
    size_t bytes[ISO_ROOM_PARTS];
} iso_node_room;
/* What was in that part may be gone. NULL: no memory. */
void *iso_node_room_take(iso_node_room *room, iso_node_room_part part, size_t bytes);
void iso_node_room_destroy(iso_node_room *room);

static inline size_t iso_node_box_count(const iso_node_box *b)
{
    return b->size[0] * b->size[1] * b->size[2];
}
static inline float *iso_node_box_row(const iso_node_box *b, size_t channel, size_t y, size_t z)
{
    return b->values + b->size[0] * (y + b->size[1] * (z + b->size[2] * channel));
}

/* A box in that part of the room. False: no memory. */
bool iso_node_box_place(iso_node_box *b, const size_t size[3], bool directed, iso_node_room *room,
                        iso_node_room_part part);

/* Where a box's nodes come from: `count` nodes of the row (y, z) of a level from x on, to a row a channel. */
typedef struct iso_node_rows {
    void (*read)(const void *user, size_t x, size_t y, size_t z, size_t count, float *const rows[ISO_BOX_CHANNELS]);
    const void *user;
    size_t last[3]; /* node of the level along each axis: what lies beyond is like it */
} iso_node_rows;
/* The box that begins at node `first`, which may lie before the level. */
void iso_node_box_fill(const iso_node_box *b, const iso_node_rows *rows, const long first[3]);

/* Level 0 as nodes. Gradients are taken in ranges a voxel, so that their squares neither overflow nor vanish. */
typedef struct iso_node_voxels {
    const iso_level *level;
    float unit;
    iso_gradient_matrix matrix;
    bool directed;
} iso_node_voxels;
iso_node_voxels iso_node_voxels_of(const iso_level *level, bool directed);
/* False: no memory. */
bool iso_node_box_read(const iso_node_box *b, const iso_node_voxels *v, const long first[3], iso_node_room *room);

/* Voxels around a box of level 0, as floats: as many as its gradients reach. */
typedef struct iso_voxel_box {
    const iso_node_voxels *of;
    size_t first[3], size[3];
    float *values, *scratch; /* in the room; scratch: three rows of gradients, and the estimator's */
} iso_voxel_box;
/* Of nodes lo to hi, hi included, which the level has. False: no memory. */
bool iso_voxel_box_read(iso_voxel_box *v, const iso_node_voxels *of, const size_t lo[3], const size_t hi[3],
                        iso_node_room *room);
static inline const float *iso_voxel_box_at(const iso_voxel_box *v, size_t x, size_t y, size_t z)
{
    return v->values + x - v->first[0] + v->size[0] * (y - v->first[1] + v->size[1] * (z - v->first[2]));
}
/* Moments and their sums of nodes of the box, as iso_node_rows.read has them; rows[0] is left as it is. */
void iso_voxel_box_moments(const iso_voxel_box *v, size_t x, size_t y, size_t z, size_t count,
                           float *const rows[ISO_BOX_CHANNELS]);

/* The coarse box of a fine one of 2 m + 3 nodes. False: no memory. */
bool iso_node_box_filter(const iso_node_box *fine, iso_node_filter filter, const iso_node_box *coarse,
                         iso_node_room *room);

/* Moments to a direction, in place: d = N/|N| L^2, L = |N| / S. */
static inline void iso_node_to_direction(float moments[3], float sum)
{
    const double x = (double)moments[0], y = (double)moments[1], z = (double)moments[2];
    const double norm = sqrt(x * x + y * y + z * z), length = sum > 0 ? norm / (double)sum : 0;
    const double scale = norm > 0 ? length * length / norm : 0;
    for (int a = 0; a < 3; ++a)
        moments[a] = (float)((double)moments[a] * scale);
}

/* Nodes of ISO_NODE_CHANNELS: moments become directions. */
void iso_node_box_finish(const iso_node_box *b, float *restrict nodes);

#endif

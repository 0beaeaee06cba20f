/* SPDX-License-Identifier: MIT */
/* node_box.h - boxes of nodes during construction, with one array of floats per channel, so that whole rows are
 * filtered. Private to src/brick.
 *
 * A node's direction comes from moments, so there are five channels: the scalar, N = sum w m^2 d, and S = sum w m^2 of
 * the gradients m d of level 0 (bricks.h). Without directions there is only the scalar.
 *
 *     fine     o o o o o o o o o      2 m + 3 nodes along each axis, positions beyond the level's ends clamped to them
 *     coarse       O   O   O          m; node i stands at fine node 2 i + 2 */
#pragma once

#include <math.h>

#include "brick/bricks.h"
#include "gradient/gradient_kernel.h"

enum { ISO_BOX_SCALAR, ISO_BOX_MOMENTS, ISO_BOX_SUM = 4, ISO_BOX_CHANNELS };

typedef struct iso_node_box {
    size_t size[3], channels;
    float *values; /* channel by channel, x fastest */
} iso_node_box;

/* Buffers of one thread, reused for all boxes, {0} at first: new pages cost more time than the writes into them. */
typedef enum iso_node_buffer {
    ISO_BUFFER_BOX, /* the result; next: its input */
    ISO_BUFFER_FINE,
    ISO_BUFFER_VOXELS, /* voxels around a box of level 0 */
    ISO_BUFFER_ROWS,   /* rows of the sharp filter */
    ISO_BUFFER_CELLS,  /* nodes of a brick for a lattice */
    ISO_BUFFER_CORNERS,
    ISO_BUFFER_PARTS
} iso_node_buffer;
typedef struct iso_node_buffers {
    void *parts[ISO_BUFFER_PARTS]; /* owned */
    size_t bytes[ISO_BUFFER_PARTS];
} iso_node_buffers;
/* Returns a buffer of at least `bytes`; its content is lost. NULL: no memory. */
void *iso_node_buffers_take(iso_node_buffers *buffers, iso_node_buffer part, size_t bytes);
void iso_node_buffers_destroy(iso_node_buffers *buffers);

static inline size_t iso_node_box_count(const iso_node_box *b)
{
    return b->size[0] * b->size[1] * b->size[2];
}
static inline float *iso_node_box_row(const iso_node_box *b, size_t channel, size_t y, size_t z)
{
    return b->values + b->size[0] * (y + b->size[1] * (z + b->size[2] * channel));
}

/* Places a box in one of the buffers. False: no memory. */
bool iso_node_box_place(iso_node_box *b, const size_t size[3], bool directed, iso_node_buffers *buffers,
                        iso_node_buffer part);

/* Source of a box: reads `count` nodes of the row (y, z) of a level from x on, into one row per channel. */
typedef struct iso_node_rows {
    void (*read)(const void *user, size_t x, size_t y, size_t z, size_t count, float *const rows[ISO_BOX_CHANNELS]);
    const void *user;
    size_t last[3]; /* last node of the level along each axis, repeated beyond it */
} iso_node_rows;
/* Fills the box from node `first` on, which may lie before the level. */
void iso_node_box_fill(const iso_node_box *b, const iso_node_rows *rows, const long first[3]);

/* Level 0 as nodes. Gradients are in ranges per voxel, so that their squares neither overflow nor vanish. */
typedef struct iso_node_voxels {
    const iso_level *level;
    float unit;
    iso_gradient_matrix matrix;
    bool directed;
} iso_node_voxels;
iso_node_voxels iso_node_voxels_of(const iso_level *level, bool directed);
/* Fills a box from level 0. False: no memory. */
bool iso_node_box_read(const iso_node_box *b, const iso_node_voxels *v, const long first[3], iso_node_buffers *buffers);

/* Voxels around a box of level 0 as floats, with the margin that gradients need. */
typedef struct iso_voxel_box {
    const iso_node_voxels *of;
    size_t first[3], size[3];
    float *values, *scratch; /* in the buffers; scratch: three rows of gradients, and the estimator's */
} iso_voxel_box;
/* Reads the voxels for nodes lo to hi, hi included, inside the level. False: no memory. */
bool iso_voxel_box_read(iso_voxel_box *v, const iso_node_voxels *of, const size_t lo[3], const size_t hi[3],
                        iso_node_buffers *buffers);
static inline const float *iso_voxel_box_at(const iso_voxel_box *v, size_t x, size_t y, size_t z)
{
    return v->values + x - v->first[0] + v->size[0] * (y - v->first[1] + v->size[1] * (z - v->first[2]));
}
/* Computes moments and their sums for nodes of the box, as in iso_node_rows.read; rows[0] stays unchanged. */
void iso_voxel_box_moments(const iso_voxel_box *v, size_t x, size_t y, size_t z, size_t count,
                           float *const rows[ISO_BOX_CHANNELS]);

/* Filters a fine box of 2 m + 3 nodes per axis to a coarse box. False: no memory. */
bool iso_node_box_filter(const iso_node_box *fine, const iso_node_box *coarse, iso_node_buffers *buffers);

/* Converts moments to a direction, in place: d = N/|N| L^2, L = |N| / S. */
static inline void iso_node_to_direction(float moments[3], float sum)
{
    const double x = (double)moments[0], y = (double)moments[1], z = (double)moments[2];
    const double norm = sqrt(x * x + y * y + z * z), length = sum > 0 ? norm / (double)sum : 0;
    const double scale = norm > 0 ? length * length / norm : 0;
    for (int a = 0; a < 3; ++a)
        moments[a] = (float)((double)moments[a] * scale);
}

/* Writes nodes of ISO_NODE_CHANNELS, with moments converted to directions. */
void iso_node_box_finish(const iso_node_box *b, float *restrict nodes);

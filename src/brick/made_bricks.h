/* SPDX-License-Identifier: MIT */
/* made_bricks.h - nodes of single bricks (iso_node_levels_create_for). Private to src/brick. */
#ifndef ISO_MADE_BRICKS_H
#define ISO_MADE_BRICKS_H

#include "brick/bricks.h"
#include "brick/node_box.h"

/* Everything but nodes. ISO_E_RANGE as of iso_node_levels_create(). */
iso_status iso_node_levels_measure(iso_node_levels *n, const iso_level *level0, size_t brick_voxels, size_t level_count,
                                   iso_error *err);
/* Directions through a code and back. */
void iso_nodes_encode(iso_code code, float *nodes, size_t count);
/* A brick of level 0 that nobody keeps: scalars, and directions of those nodes that are asked for. */
typedef struct iso_passing_brick {
    const iso_node_levels *nodes;
    iso_voxel_box voxels;
    size_t first[3], last[3]; /* node; last: that the volume has. What lies beyond is like it */
} iso_passing_brick;
/* Of nodes that are made; in the room. False: no memory. */
bool iso_passing_brick_open(iso_passing_brick *p, const iso_node_levels *n, size_t brick, iso_node_room *room);
/* Of the brick's row (y, z) all scalars: side of them. */
void iso_passing_brick_scalars(const iso_passing_brick *p, size_t y, size_t z, float *restrict scalars);
/* Of the row's nodes those that are wanted, a byte a node; three floats a node, which are not yet coded. */
void iso_passing_brick_directions(const iso_passing_brick *p, size_t y, size_t z, const uint8_t *wanted,
                                  float *restrict directions);
/* Directions, three floats each, through the code and back. */
void iso_passing_brick_code(const iso_passing_brick *p, float *directions, size_t count);
void iso_made_bricks_destroy(iso_node_levels *n); /* accepts nodes that are made otherwise */

#endif

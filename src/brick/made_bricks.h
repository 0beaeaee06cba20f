/* SPDX-License-Identifier: MIT */
/* made_bricks.h - nodes of single bricks (iso_node_levels_create_for). Private to src/brick. */
#pragma once

#include "brick/bricks.h"
#include "brick/node_box.h"

/* Sets everything but nodes. ISO_E_RANGE as in iso_node_levels_create(). */
iso_status iso_node_levels_measure(iso_node_levels *n, const iso_level *level0, size_t brick_voxels, size_t level_count,
                                   iso_error *err);
/* Begins without bricks. levels: one per brick, or NULL: level 0 alone is made. code: may be NULL. ISO_E_MEMORY. */
iso_status iso_made_bricks_begin(iso_node_levels *n, const iso_level *level0, const uint8_t *levels,
                                 const iso_code *code, iso_error *err);
const iso_node_voxels *iso_made_bricks_voxels(const iso_node_levels *n);
/* Rounds nodes as iso_node_levels_round() does. */
void iso_nodes_round(const iso_node_levels *n, float *nodes, size_t count);
/* Encodes and decodes the directions of nodes. */
void iso_nodes_encode(iso_code code, float *nodes, size_t count);
/* A temporary brick of level 0: scalars, and directions of requested nodes. */
typedef struct iso_passing_brick {
    const iso_node_levels *nodes;
    iso_voxel_box voxels;
    size_t first[3], last[3]; /* nodes; last: clamped to the volume, repeated beyond it */
} iso_passing_brick;
/* Reads the voxels of a brick into `buffers`, for nodes by iso_node_levels_create_for(). False: no memory. */
bool iso_passing_brick_open(iso_passing_brick *p, const iso_node_levels *n, size_t brick, iso_node_buffers *buffers);
/* Reads the scalars of the brick's row (y, z), one per node of its side. */
void iso_passing_brick_scalars(const iso_passing_brick *p, size_t y, size_t z, float *restrict scalars);
/* Computes directions of a row, three floats per node, not encoded. wanted: one byte per node. */
void iso_passing_brick_directions(const iso_passing_brick *p, size_t y, size_t z, const uint8_t *wanted,
                                  float *restrict directions);
/* Encodes and decodes directions, three floats each. */
void iso_passing_brick_code(const iso_passing_brick *p, float *directions, size_t count);
void iso_made_bricks_destroy(iso_node_levels *n); /* accepts all nodes */

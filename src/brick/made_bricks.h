/* SPDX-License-Identifier: MIT */
/* made_bricks.h - nodes of single bricks (iso_node_levels_create_for). Private to src/brick. */
#ifndef ISO_MADE_BRICKS_H
#define ISO_MADE_BRICKS_H

#include "brick/bricks.h"

/* Everything but nodes. ISO_E_RANGE as of iso_node_levels_create(). */
iso_status iso_node_levels_measure(iso_node_levels *n, const iso_level *level0, size_t brick_voxels, size_t level_count,
                                   iso_error *err);
/* Directions through a code and back. */
void iso_nodes_encode(iso_code code, float *nodes, size_t count);
void iso_made_bricks_destroy(iso_node_levels *n); /* accepts nodes that are made otherwise */

#endif

/* SPDX-License-Identifier: MIT */
/* lattice_build.h - construction of a lattice. Private to src/brick.
 *
 *   lattice.c        the box, the background, the final box
 *   lattice_bricks.c the nodes of a brick's cells, and their visibility
 *   lattice_halo.c   cells that would be visible because some of their nodes are background */
#pragma once

#include "brick/lattice.h"
#include "brick/node_box.h"
#include "brick/occupancy.h"

typedef struct iso_lattice_builder {
    const iso_brick_field *field;
    const iso_lattice_options *opt;
    iso_lattice *lattice;
    iso_tf_shown *shown; /* one per transfer function */
    double step;         /* rounding step of sampled scalars */
} iso_lattice_builder;

/* True if any transfer function shows a value of the range. */
static inline bool iso_lattice_shows(const iso_lattice_builder *b, double min, double max)
{
    for (size_t i = 0; i < b->opt->tf_count; ++i)
        if (iso_tf_shown_in(&b->shown[i], min, max))
            return true;
    return false;
}

/* True if the brick belongs to the lattice. */
static inline bool iso_lattice_has(const iso_lattice_builder *b, size_t brick)
{
    return b->opt->drawn[brick] && (b->opt->merged || b->field->levels[brick] == b->lattice->level);
}

/* Converts a node or cell of the lattice's level along an axis to its node of level 0, within the volume's bricks. */
static inline size_t iso_lattice_level0(const iso_lattice_builder *b, int axis, long i)
{
    const iso_node_levels *n = b->field->nodes;
    size_t last = n->count[axis] * n->brick_voxels, q = i > 0 ? (size_t)i << b->lattice->level : 0;
    /* At level 0 positions are clamped to the volume's nodes; coarser cells extend beyond its edge. */
    last = b->lattice->level == 0 ? n->geometry.size[axis] - 1 : last;
    return q < last ? q : last;
}

/* Returns the brick, along an axis, with the cell whose first corner is this node of level 0. */
static inline size_t iso_lattice_brick(const iso_lattice_builder *b, int axis, size_t q)
{
    size_t brick = q / b->field->nodes->brick_voxels, last = b->field->nodes->count[axis] - 1;
    return brick < last ? brick : last;
}

/* Rounds sampled values, whose needless digits do not compress. Scalars become multiples of a power of two, 1/65536 of
 * the range, so that the last bits are 0; directions become multiples of 1/2032, which half floats represent after
 * exporters scale them by 127/128. One grid stays as continuous as before. */
static inline float iso_lattice_round_scalar(const iso_lattice_builder *b, double value)
{
    return (float)(b->opt->merged ? b->step * rint(value / b->step) : value);
}
static inline void iso_lattice_round_direction(const iso_lattice_builder *b, const double value[3], float out[3])
{
    for (int a = 0; a < 3; ++a)
        out[a] = (float)(b->opt->merged ? rint(2032 * value[a]) / 2032 : value[a]);
}

/* Activates a node of the box; for the halo only its scalar is used. ISO_E_MEMORY. */
iso_status iso_lattice_put(iso_lattice *l, const size_t at[3], const float *node, iso_lattice_use use, iso_error *err);

/* Activates the corners of a brick's visible cells. Thread-safe for different bricks with separate buffers. */
iso_status iso_lattice_add_brick(const iso_lattice_builder *b, size_t brick, iso_node_buffers *buffers, iso_error *err);
/* Activates the other corners of cells that would be visible otherwise, until no such cell is left. */
iso_status iso_lattice_add_halo(const iso_lattice_builder *b, iso_error *err);

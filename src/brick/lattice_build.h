/* SPDX-License-Identifier: MIT */
/* lattice_build.h - a lattice on its way. Private to src/brick.
 *
 *   lattice.c        the box, the background, what is left in the end
 *   lattice_bricks.c the nodes of a brick's cells, and which of them the transfer functions show
 *   lattice_halo.c   cells that are seen because some of their nodes are background */
#ifndef ISO_LATTICE_BUILD_H
#define ISO_LATTICE_BUILD_H

#include "brick/lattice.h"

typedef struct iso_lattice_builder {
    const iso_brick_field *field;
    const iso_lattice_options *opt;
    iso_lattice *lattice;
    uint32_t **next; /* of each transfer function (iso_tf_next_shown) */
    double step;     /* that sampled scalars are rounded to */
} iso_lattice_builder;

/* Does any transfer function show a value of the range? */
bool iso_lattice_shows(const iso_lattice_builder *b, double min, double max);

/* Does a brick belong to the lattice? */
static inline bool iso_lattice_has(const iso_lattice_builder *b, size_t brick)
{
    return b->opt->drawn[brick] && (b->opt->merged || b->field->levels[brick] == b->lattice->level);
}

/* Of a node or cell of the lattice's level along an axis: its node of level 0, within the volume's bricks. */
static inline size_t iso_lattice_level0(const iso_lattice_builder *b, int axis, long i)
{
    const iso_node_levels *n = b->field->nodes;
    size_t last = n->count[axis] * n->brick_voxels, q = i > 0 ? (size_t)i << b->lattice->level : 0;
    /* At level 0 positions are clamped to the nodes that the volume has; coarser cells reach over its edge. */
    last = b->lattice->level == 0 ? n->geometry.size[axis] - 1 : last;
    return q < last ? q : last;
}

/* The brick that a node of level 0 is the first corner of a cell of. */
static inline size_t iso_lattice_brick(const iso_lattice_builder *b, int axis, size_t q)
{
    size_t brick = q / b->field->nodes->brick_voxels, last = b->field->nodes->count[axis] - 1;
    return brick < last ? brick : last;
}

/* A value that is sampled in a brick which is coarser than the lattice, to floats: rounded in a merged one. */
void iso_lattice_round(const iso_lattice_builder *b, double value[ISO_NODE_CHANNELS], float *out);

/* Makes a node of the box active; of the halo it takes the scalar alone. ISO_E_MEMORY. */
iso_status iso_lattice_put(iso_lattice *l, const size_t at[3], const float *node, iso_lattice_use use, iso_error *err);

/* Activates the corners of a brick's cells that are shown. Of several bricks by several threads. */
iso_status iso_lattice_add_brick(const iso_lattice_builder *b, size_t brick, iso_error *err);
/* Activates the other corners of cells that would be seen otherwise, and of the cells that they make so. */
iso_status iso_lattice_add_halo(const iso_lattice_builder *b, iso_error *err);

#endif

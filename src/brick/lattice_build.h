/* SPDX-License-Identifier: MIT */
/* lattice_build.h - a lattice on its way. Private to src/brick.
 *
 *   lattice.c        the box, the background, what is left in the end
 *   lattice_bricks.c the nodes of a brick's cells, and which of them the transfer functions show
 *   lattice_halo.c   cells that are seen because some of their nodes are background */
#ifndef ISO_LATTICE_BUILD_H
#define ISO_LATTICE_BUILD_H

#include "brick/lattice.h"
#include "brick/node_box.h"
#include "brick/occupancy.h"

typedef struct iso_lattice_builder {
    const iso_brick_field *field;
    const iso_lattice_options *opt;
    iso_lattice *lattice;
    iso_tf_shown *shown; /* of each transfer function */
    double step;         /* that sampled scalars are rounded to */
} iso_lattice_builder;

/* Does any transfer function show a value of the range? */
static inline bool iso_lattice_shows(const iso_lattice_builder *b, double min, double max)
{
    for (size_t i = 0; i < b->opt->tf_count; ++i)
        if (iso_tf_shown_in(&b->shown[i], min, max))
            return true;
    return false;
}

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

/* Sampled values have more digits than they need, and do not compress: 1/65536 of the range is enough, a power of two, so
 * that the last bits are 0; and of a direction 1/2032, which half floats hold once exporters have scaled it by 127/128.
 * One grid stays as continuous as it was. */
static inline float iso_lattice_round_scalar(const iso_lattice_builder *b, double value)
{
    return (float)(b->opt->merged ? b->step * rint(value / b->step) : value);
}
static inline void iso_lattice_round_direction(const iso_lattice_builder *b, const double value[3], float out[3])
{
    for (int a = 0; a < 3; ++a)
        out[a] = (float)(b->opt->merged ? rint(2032 * value[a]) / 2032 : value[a]);
}

/* Makes a node of the box active; of the halo it takes the scalar alone. ISO_E_MEMORY. */
iso_status iso_lattice_put(iso_lattice *l, const size_t at[3], const float *node, iso_lattice_use use, iso_error *err);

/* Activates the corners of a brick's cells that are shown. Of several bricks by several threads, each with a room. */
iso_status iso_lattice_add_brick(const iso_lattice_builder *b, size_t brick, iso_node_room *room, iso_error *err);
/* Activates the other corners of cells that would be seen otherwise, and of the cells that they make so. */
iso_status iso_lattice_add_halo(const iso_lattice_builder *b, iso_error *err);

#endif

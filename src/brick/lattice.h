/* SPDX-License-Identifier: MIT */
/* lattice.h - the nodes that a scene needs of a field of bricks, as a sparse grid for other programs.
 *
 * A lattice holds every 2^level-th node of level 0. Two kinds:
 *
 *   merged     All drawn bricks at the finest level that any of them has; coarser ones are sampled. The baked field is
 *              multilinear in each cell of its own brick, and these cells are whole numbers of the lattice's, so nothing
 *              is lost. One plain grid that any program reads.
 *   one level  The bricks that are drawn at this level alone. With a lattice for each level and the table of the bricks'
 *              levels, a program has the field as it is, in as many values as it has nodes; C0 because the field is.
 *
 * Active are the corners of every cell that a transfer function shows in a brick that is drawn, so that what is
 * interpolated there is exact. All other nodes are `background`, which the TF does not show. Where a cell has corners
 * of both kinds, values between them occur that are nowhere in the field; where the TF would show one of these,
 * the cell's other corners are active too, though nothing is seen in it and so nothing is lit (halo).
 *
 *     o---o---o---o---o        o active   . background     the TF shows cells marked #
 *     | # | # |   |   |
 *     o---o---o---.---.        Beyond the volume's last nodes the edge is repeated once, as far as the box goes.
 *     | # |   |   |   |
 *     o---o---.---.---.
 *
 * Bricks that no view sees may be left out without a halo: nobody sees their faces either.
 *
 * Nodes are held in blocks, those of active nodes alone, so that memory follows what is left of a volume. Bricks of
 * level 0 whose nodes nobody has made (iso_node_levels_create_for) are read from the voxels, and nothing of them is kept:
 * of their directions those alone are made that are active here. */
#ifndef ISO_LATTICE_H
#define ISO_LATTICE_H

#include "brick/bricks.h"
#include "tf/tf.h"

/* What a node is active for: its scalar and its direction; its scalar alone (halo), and its direction is 0. */
typedef enum iso_lattice_use { ISO_LATTICE_UNUSED, ISO_LATTICE_HALO, ISO_LATTICE_LIT } iso_lattice_use;

/* Nodes of a cube; those that are not active are background. */
enum { ISO_LATTICE_SIDE = 8, ISO_LATTICE_CUBE = ISO_LATTICE_SIDE * ISO_LATTICE_SIDE * ISO_LATTICE_SIDE };
typedef struct iso_lattice_block {
    float nodes[ISO_LATTICE_CUBE][ISO_NODE_CHANNELS]; /* x fastest */
    uint8_t use[ISO_LATTICE_CUBE];
} iso_lattice_block;

typedef struct iso_lattice {
    size_t level;
    long first[3];         /* of its nodes, counted in nodes of the level from node (0, 0, 0); may be -1 */
    size_t size[3];        /* the box of the active nodes */
    iso_geometry geometry; /* its voxels have the nodes as centers; the box is all of them */
    long corner[3];        /* the first node of the first block: multiples of ISO_LATTICE_SIDE */
    size_t block_count[3];
    iso_lattice_block **blocks;       /* owned, x fastest; NULL where no node is active */
    struct iso_lattice_chunk *chunks; /* owned; what the blocks stand in */
    size_t active_count;
    double background;              /* of the scalar; directions are 0 */
    float empty[ISO_NODE_CHANNELS]; /* what a node that is not active holds */
    double min, max;                /* of the scalar, background included */
} iso_lattice;

/* Which block holds node (x, y, z) of the box, and where in it. */
static inline iso_lattice_block **iso_lattice_block_of(const iso_lattice *l, size_t x, size_t y, size_t z, size_t *in)
{
    const size_t at[3] = {x + (size_t)(l->first[0] - l->corner[0]), y + (size_t)(l->first[1] - l->corner[1]),
                          z + (size_t)(l->first[2] - l->corner[2])};
    *in = at[0] % ISO_LATTICE_SIDE +
          ISO_LATTICE_SIDE * (at[1] % ISO_LATTICE_SIDE + ISO_LATTICE_SIDE * (at[2] % ISO_LATTICE_SIDE));
    return &l->blocks[at[0] / ISO_LATTICE_SIDE +
                      l->block_count[0] * (at[1] / ISO_LATTICE_SIDE + l->block_count[1] * (at[2] / ISO_LATTICE_SIDE))];
}
/* The ISO_NODE_CHANNELS values of a node. */
static inline const float *iso_lattice_node(const iso_lattice *l, size_t x, size_t y, size_t z)
{
    size_t in;
    const iso_lattice_block *block = *iso_lattice_block_of(l, x, y, z, &in);
    return block ? block->nodes[in] : l->empty;
}
static inline iso_lattice_use iso_lattice_use_of(const iso_lattice *l, size_t x, size_t y, size_t z)
{
    size_t in;
    const iso_lattice_block *block = *iso_lattice_block_of(l, x, y, z, &in);
    return block ? (iso_lattice_use)block->use[in] : ISO_LATTICE_UNUSED;
}

typedef struct iso_lattice_options {
    const uint8_t *drawn;    /* one byte a brick: what pack.h's cull and the plan leave */
    const uint8_t *seen;     /* one byte a brick, 0: in no view, may be left out without a halo; NULL: all are seen */
    const iso_tf_table *tfs; /* a node is needed when one of them shows a cell round it */
    size_t tf_count;
    size_t level; /* one level: which; merged: ignored */
    bool merged;
    bool whole_box; /* the box of the bricks instead of that of the active nodes: its corners are made active */
    int threads;
} iso_lattice_options;

/* The result does not depend on the number of threads. ISO_E_RANGE when nothing would be left, or the field's faces are not
 * baked; ISO_E_MEMORY. */
iso_status iso_lattice_create(iso_lattice *l, const iso_brick_field *f, const iso_lattice_options *opt, iso_error *err);
void iso_lattice_destroy(iso_lattice *l); /* accepts empty and NULL */

/* What sampled scalars are rounded to: 1/65536 of the next power of two above the range. */
double iso_lattice_step(const iso_node_levels *n);

/* A value in [min, max] that no TF shows, in the range that most of the field's level 0 lies in; min when they show
 * all. */
double iso_lattice_background(const iso_node_levels *n, const iso_tf_table *tfs, size_t tf_count);

#endif

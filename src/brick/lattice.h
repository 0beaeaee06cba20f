/* SPDX-License-Identifier: MIT */
/* lattice.h - the nodes of a field of bricks that a scene needs, as a sparse grid for other programs.
 *
 * A lattice contains every 2^level-th node of level 0. Two kinds:
 *
 *   merged     All drawn bricks at the finest level among them; coarser ones are sampled. This is exact: the baked
 *              field is multilinear in each cell of its brick, and these cells consist of whole cells of the lattice.
 *              One plain grid that any program reads.
 *   one level  Only the bricks drawn at this level. With one lattice per level and the table of the bricks' levels, a
 *              program has the whole field in as many values as it has nodes; C0 because the field is.
 *
 * Active nodes are the corners of every cell that a transfer function shows in a drawn brick, so that interpolation
 * there is exact. All other nodes are `background`, which the TF does not show. In cells with corners of both kinds
 * interpolation gives values that are nowhere in the field. If the TF would show one of these, the cell's other corners
 * become active too (halo); nothing is visible in such a cell, so they need no direction.
 *
 *     o---o---o---o---o        o active   . background     the TF shows cells marked #
 *     | # | # |   |   |
 *     o---o---o---.---.        Beyond the volume's last nodes the edge is repeated once, as far as the box goes.
 *     | # |   |   |   |
 *     o---o---.---.---.
 *
 * Bricks outside all views may be left out without a halo: their faces are invisible, too.
 *
 * Only blocks with active nodes are allocated, so that memory depends on the visible part of a volume. Bricks of level
 * 0 that have not been made (iso_node_levels_create_for) are read from the voxels and not kept; directions are computed
 * for active nodes only. */
#pragma once

#include "brick/bricks.h"
#include "tf/tf.h"

/* Use of a node: none; its scalar alone (halo), with direction 0; or scalar and direction. */
typedef enum iso_lattice_use { ISO_LATTICE_UNUSED, ISO_LATTICE_HALO, ISO_LATTICE_LIT } iso_lattice_use;

/* A cube of nodes; inactive ones are background. */
enum { ISO_LATTICE_SIDE = 8, ISO_LATTICE_CUBE = ISO_LATTICE_SIDE * ISO_LATTICE_SIDE * ISO_LATTICE_SIDE };
typedef struct iso_lattice_block {
    float nodes[ISO_LATTICE_CUBE][ISO_NODE_CHANNELS]; /* x fastest */
    uint8_t use[ISO_LATTICE_CUBE];
} iso_lattice_block;

typedef struct iso_lattice {
    size_t level;
    long first[3];         /* first node, in nodes of the level from node (0, 0, 0); may be -1 */
    size_t size[3];        /* of the box of active nodes */
    iso_geometry geometry; /* of the box; the nodes are voxel centers */
    long corner[3];        /* first node of the first block: multiples of ISO_LATTICE_SIDE */
    size_t block_count[3];
    iso_lattice_block **blocks;       /* owned, x fastest; NULL without active nodes */
    struct iso_lattice_chunk *chunks; /* owned; memory of the blocks */
    size_t active_count;
    double background;              /* scalar; directions are 0 */
    float empty[ISO_NODE_CHANNELS]; /* values of an inactive node */
    double min, max;                /* of the scalar, background included */
} iso_lattice;

/* Finds the block with node (x, y, z) of the box; *in is the node's index in it. */
static inline iso_lattice_block **iso_lattice_block_of(const iso_lattice *l, size_t x, size_t y, size_t z, size_t *in)
{
    const size_t at[3] = {x + (size_t)(l->first[0] - l->corner[0]), y + (size_t)(l->first[1] - l->corner[1]),
                          z + (size_t)(l->first[2] - l->corner[2])};
    *in = at[0] % ISO_LATTICE_SIDE +
          ISO_LATTICE_SIDE * (at[1] % ISO_LATTICE_SIDE + ISO_LATTICE_SIDE * (at[2] % ISO_LATTICE_SIDE));
    return &l->blocks[at[0] / ISO_LATTICE_SIDE +
                      l->block_count[0] * (at[1] / ISO_LATTICE_SIDE + l->block_count[1] * (at[2] / ISO_LATTICE_SIDE))];
}
/* Returns the ISO_NODE_CHANNELS values of a node. */
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
    const uint8_t *drawn;    /* one byte per brick: 1 if left by pack.h's cull and the plan */
    const uint8_t *seen;     /* one byte per brick, 0: outside all views, may go without a halo; NULL: all are seen */
    const iso_tf_table *tfs; /* a node is active if one of them shows a cell around it */
    size_t tf_count;
    size_t level; /* the one level; ignored if merged */
    bool merged;
    bool whole_box; /* True to keep the box of all bricks: its corners become active */
    int threads;
} iso_lattice_options;

/* Creates a lattice, the same for any number of threads. ISO_E_RANGE: empty, or faces are not baked; ISO_E_MEMORY. */
iso_status iso_lattice_create(iso_lattice *l, const iso_brick_field *f, const iso_lattice_options *opt, iso_error *err);
void iso_lattice_destroy(iso_lattice *l); /* accepts empty and NULL */

/* Returns the rounding step of sampled scalars: 1/65536 of the next power of two above the range. */
double iso_lattice_step(const iso_node_levels *n);

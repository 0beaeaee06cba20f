/* SPDX-License-Identifier: MIT */
/* bricks.h - mixed resolution without seams: bricks whose faces pass through samples.
 *
 * Nodes are the voxel centers of level 0: node q is at index q + 1/2. Brick b with n
 * voxels per side spans the nodes n b .. n (b + 1); neighbors share those of their
 * faces. Level l has its nodes at every 2^l-th node of level 0, made by a filter from
 * level to level, so that a brick has (n / 2^l + 1)^3 nodes:
 *
 *     level 0   o-o-o-o-o-o-o-o-o       n = 8: 9 nodes
 *     level 1   o---o---o---o---o              5
 *     level 2   o-------o-------o              3
 *               face            face
 *
 * Every brick is drawn at its own level, by one trilinear fetch among its own nodes.
 * The rule that makes this continuous concerns the nodes alone: a node in the closed
 * box of a coarser brick takes the value of the coarsest such brick at its place (baked
 * face nodes). Then two bricks that share a face, an edge or a corner have the same
 * values on it: the finer one samples a function that is (bi)linear in the coarser
 * one's cells at subdivisions of these cells, and linear interpolation reproduces it.
 * Interior nodes keep their values. This replaces the warped coordinates of
 * [beyer-2008], whose samples lie inside the bricks, and costs the shader nothing.
 *
 * The edge of the volume is repeated to fill whole bricks; positions are clamped to
 * the volume's nodes. Four channels per node: the scalar, and the direction d
 * (world axes) of the moments N = sum w m^2 d, S = sum w m^2 of the gradients
 * m d of level 0: d = N/|N| L^2, L = |N| / S, as in pyramid.h with the weights w
 * of their filter, [1 2 1]^3 / 64. The scalar's filter is [-1 2 6 2 -1] / 8 along
 * each axis, clamped to the nodes around: on sparse TFs it is nearer to level 0 than
 * cells are (doc/results/mixed-resolution.md). Directions are baked like the scalar, and not normalized before
 * they are interpolated. */
#pragma once

#include <math.h>

#include "pyramid/pyramid.h"

#define ISO_BRICK_MAX_LEVELS 7
#define ISO_NODE_CHANNELS 4

typedef struct iso_node_levels {
    iso_geometry geometry; /* of level 0 */
    double min, max;       /* of its scalar */
    size_t brick_voxels;   /* n, a power of two */
    size_t count[3];       /* bricks along x, y, z */
    size_t level_count;
    /* Owned; ISO_NODE_CHANNELS per node, x fastest. NULL if `bricks` has the nodes. */
    float *nodes[ISO_BRICK_MAX_LEVELS];
    float **bricks;                /* owned; NULL, or each brick's nodes at its level, NULL if not made */
    struct iso_brick_maker *maker; /* owned; makes the nodes of `bricks` */
    bool is_rounded;
    struct iso_node_range *ranges[ISO_BRICK_MAX_LEVELS]; /* owned; NULL, or one per brick if it had this level */
} iso_node_levels;

/* Range of a brick's scalars, without nodes of coarser neighbors. inner: without the faces; least above most if nothing
 * is left. */
typedef struct iso_node_range {
    float inner[2], whole[2];
} iso_node_range;

enum { ISO_BRICK_MOST_VOXELS = 64 }; /* per side */

/* Creates nodes. ISO_E_RANGE: brick_voxels is not a power of two from 2 to 64, or too many levels for it; ISO_E_MEMORY.
 * with_directions: False leaves directions 0. */
iso_status iso_node_levels_create(iso_node_levels *n, const iso_level *level0, size_t brick_voxels, size_t level_count,
                                  bool with_directions, int threads, iso_error *err);
/* Begins rounded nodes for plans. Level 0, whose samples are borrowed, is not kept: iso_brick_make() makes its bricks.
 * The coarser levels are missing until iso_node_levels_complete(), so that a picture of level 0 comes before they take
 * memory. */
iso_status iso_node_levels_begin(iso_node_levels *n, const iso_level *level0, size_t brick_voxels, size_t level_count,
                                 int threads, iso_error *err);
/* Makes the missing levels, if there are any. ISO_E_MEMORY. */
iso_status iso_node_levels_complete(iso_node_levels *n, int threads, iso_error *err);
/* Creates the nodes for bricks of given levels, separately for each brick. Those of bricks coarser than level 0 are
 * made at once, since finer ones take their face nodes from them; the others by iso_brick_make(). Level 0 may be narrow
 * (pyramid/narrow.h). code: directions are encoded and decoded; NULL: they are not. The samples of level 0 and
 * `levels`, one number per brick, are borrowed; fields of these nodes have the same levels. They are not for
 * iso_node_levels_round(). */
iso_status iso_node_levels_create_for(iso_node_levels *n, const iso_level *level0, size_t brick_voxels,
                                      size_t level_count, const uint8_t *levels, const iso_code *code, int threads,
                                      iso_error *err);
/* Content of a brick of level 0; directions take most of the work. */
typedef enum iso_brick_content {
    ISO_BRICK_SCALARS, /* directions are 0 */
    ISO_BRICK_WHOLE
} iso_brick_content;
/* Makes a brick's nodes if there are none. Thread-safe for different bricks. A brick made with scalars alone must be
 * forgotten before it is made as a whole. ISO_E_MEMORY. */
iso_status iso_brick_make(const iso_node_levels *n, size_t brick, iso_brick_content content, iso_error *err);
/* Frees nodes that iso_brick_make() can make again. */
void iso_brick_forget(const iso_node_levels *n, size_t brick);

/* Reads `count` voxels of the row (y, z) of level 0 from x on. */
void iso_node_levels_voxels(const iso_node_levels *n, size_t x, size_t y, size_t z, size_t count, float *restrict row);
/* Reads a box of nodes of level 0, which may lie beyond the level: its outermost nodes are repeated. ISO_E_MEMORY. */
iso_status iso_node_levels_read(const iso_node_levels *n, const long first[3], const size_t size[3],
                                float *restrict nodes, iso_error *err);

/* Measures the ranges of level 0 and of all levels whose nodes are there. ISO_E_MEMORY. */
iso_status iso_node_levels_measure_ranges(iso_node_levels *n, int threads, iso_error *err);

/* Rounds the nodes of all levels to the values of a 16-bit cache: scalars to 65535 steps of the range, directions to
 * 1/32767. Call it before faces are baked: fine face nodes are interpolated from rounded coarse ones. Then measures the
 * ranges, which are asked for many times. ISO_E_MEMORY. */
iso_status iso_node_levels_round(iso_node_levels *n, int threads, iso_error *err);
/* Converts to the values of such a cache: the scalar's part of the range; a component of the direction. */
static inline double iso_node_part(const iso_node_levels *n, float scalar)
{
    return n->max > n->min ? ((double)scalar - n->min) * (1 / (n->max - n->min)) : 0;
}
static inline double iso_node_step(const iso_node_levels *n)
{
    return n->max > n->min ? (n->max - n->min) / 65535 : 1;
}
/* Returns the scalar that a rounded node has. */
static inline float iso_node_round(const iso_node_levels *n, float scalar)
{
    return (float)(n->min + iso_node_step(n) * rint(((double)scalar - n->min) / iso_node_step(n)));
}
static inline uint16_t iso_node_scalar16(const iso_node_levels *n, float scalar)
{
    return (uint16_t)lrint(65535 * fmin(fmax(iso_node_part(n, scalar), 0), 1));
}
static inline int16_t iso_node_direction16(float component)
{
    return (int16_t)lrintf(32767 * fminf(fmaxf(component, -1), 1));
}
void iso_node_levels_destroy(iso_node_levels *n); /* accepts empty and NULL */

static inline size_t iso_brick_count(const iso_node_levels *n)
{
    return n->count[0] * n->count[1] * n->count[2];
}
static inline size_t iso_brick_index(const iso_node_levels *n, const size_t brick[3])
{
    return brick[0] + n->count[0] * (brick[1] + n->count[1] * brick[2]);
}
/* Returns the number of nodes of a level along an axis: bricks share their faces. */
static inline size_t iso_node_count(const iso_node_levels *n, size_t level, int axis)
{
    return n->count[axis] * (n->brick_voxels >> level) + 1;
}
/* Returns the number of nodes along a side of a brick at a level. */
static inline size_t iso_brick_side(const iso_node_levels *n, size_t level)
{
    return (n->brick_voxels >> level) + 1;
}

/* Nodes on the faces of bricks. */
typedef enum iso_brick_faces {
    ISO_FACES_BAKED, /* the rule above */
    ISO_FACES_OWN    /* those of the brick's own level: discontinuous, for comparison */
} iso_brick_faces;

/* A field of bricks: the level of each brick, indexed by iso_brick_index(). */
typedef struct iso_brick_field {
    const iso_node_levels *nodes;
    const uint8_t *levels;
    iso_brick_faces faces;
} iso_brick_field;

/* Computes a brick's node (0 .. n / 2^l along each axis, l the brick's level). */
void iso_brick_node(const iso_brick_field *f, const size_t brick[3], const size_t node[3],
                    double out[ISO_NODE_CHANNELS]);

/* A brick's nodes of its own level, ignoring coarser bricks: the first, and strides in floats of rows and planes. */
typedef struct iso_own_nodes {
    const float *first;
    size_t row, plane;
} iso_own_nodes;
iso_own_nodes iso_brick_own_nodes(const iso_brick_field *f, const size_t brick[3]);
iso_node_range iso_own_nodes_range(iso_own_nodes own, size_t side);

/* Returns a row of nodes along x at the brick's own level: iso_brick_side() nodes of ISO_NODE_CHANNELS. */
const float *iso_brick_own_row(const iso_brick_field *f, const size_t brick[3], size_t y, size_t z);

/* True if nodes on the brick's faces take values of a coarser brick; otherwise iso_brick_own_row() gives all nodes. */
bool iso_brick_has_foreign_nodes(const iso_brick_field *f, const size_t brick[3]);
/* The same per part of the brick: corners, edges, faces and the inside (13, never), numbered as by iso_brick_part(). */
enum { ISO_BRICK_PARTS = 27 };
void iso_brick_foreign_parts(const iso_brick_field *f, const size_t brick[3], bool parts[ISO_BRICK_PARTS]);
static inline size_t iso_brick_part(size_t side, size_t x, size_t y, size_t z)
{
    return (x > 0) + (x + 1 == side) + 3 * ((size_t)(y > 0) + (y + 1 == side)) +
           9 * ((size_t)(z > 0) + (z + 1 == side));
}

/* Finds the coarsest brick whose closed box contains node p of level 0. False: none is coarser than `level`. */
bool iso_brick_coarsest_at(const iso_brick_field *f, const size_t p[3], size_t level, size_t brick[3]);

/* Samples the function of one brick at node coordinates q in its closed box: on a face, the limit from inside. */
void iso_brick_sample_in(const iso_brick_field *f, const size_t brick[3], const double q[3],
                         double out[ISO_NODE_CHANNELS]);

/* Samples the field at index coordinates (index = q + 1/2), clamped to the volume's nodes. */
void iso_brick_sample(const iso_brick_field *f, iso_vec3 index, double out[ISO_NODE_CHANNELS]);

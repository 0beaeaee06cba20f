/* SPDX-License-Identifier: MIT */
/* bricks.h - mixed resolution without seams: bricks whose faces pass through samples.
 *
 * Nodes are the voxel centers of level 0: node q stands at index q + 1/2. Brick b
 * of n voxels a side spans the nodes n b .. n (b + 1), the faces' shared by its
 * neighbors. Level l has its nodes at every 2^l-th node of level 0, made by the
 * filter of iso_node_filter from level to level, so that a brick holds (n / 2^l + 1)^3:
 *
 *     level 0   o-o-o-o-o-o-o-o-o       n = 8: 9 nodes
 *     level 1   o---o---o---o---o              5
 *     level 2   o-------o-------o              3
 *               face            face
 *
 * Every brick is drawn at a level of its own, by one trilinear fetch among its
 * own nodes. The rule that makes this continuous is a rule for nodes alone: a node
 * that lies in the closed box of a coarser brick takes the value that the coarsest
 * such brick has there (baked face nodes). Then two bricks that share a face, an
 * edge or a corner hold the same values on it: the finer one samples a function
 * that is (bi)linear in the coarser one's cells at subdivisions of these cells, and
 * linear interpolation reproduces it. Interior nodes keep their values. This is in
 * place of the warped coordinates of [beyer-2008], whose samples lie
 * inside the bricks, and costs the shader nothing.
 *
 * The edge of the volume is repeated to fill whole bricks; positions are clamped to
 * the nodes that the volume has. Four channels a node: the scalar, and the direction d
 * (world axes) of the moments N = sum w m^2 d, S = sum w m^2 of the gradients
 * m d of level 0: d = N/|N| L^2, L = |N| / S, as in pyramid.h with the weights w
 * of the filter. Directions are baked like the scalar, and not normalized before
 * they are interpolated. */
#ifndef ISO_BRICKS_H
#define ISO_BRICKS_H

#include <math.h>

#include "pyramid/pyramid.h"

#define ISO_BRICK_MAX_LEVELS 7
#define ISO_NODE_CHANNELS 4

/* How coarse nodes are made. Directions come from moments by [1 2 1]^3 / 64 with both. */
typedef enum iso_node_filter {
    ISO_NODES_SHARP, /* the scalar by [-1 2 6 2 -1] / 8 along each axis, within the range of the nodes around: what linear
                      * interpolation shows is nearer to level 0 than with cells, on sparse TFs
                      * (doc/results/mixed-resolution.md) */
    ISO_NODES_SMOOTH /* by [1 2 1] / 4 */
} iso_node_filter;

typedef struct iso_node_levels {
    iso_geometry geometry; /* of level 0 */
    double min, max;       /* of its scalar */
    size_t brick_voxels;   /* n, a power of two */
    size_t count[3];       /* bricks along x, y, z */
    size_t level_count;
    iso_node_filter filter;
    /* Owned; ISO_NODE_CHANNELS a node, x fastest. NULL where bricks have their own. */
    float *nodes[ISO_BRICK_MAX_LEVELS];
    float **bricks;                /* owned; NULL, or a brick's nodes of its level, NULL where none have been made */
    struct iso_brick_maker *maker; /* owned; of bricks */
} iso_node_levels;

enum { ISO_BRICK_MOST_VOXELS = 64 }; /* a side */

/* ISO_E_RANGE: brick_voxels that is no power of two from 2 to 64, or more levels
 * than it has; ISO_E_MEMORY. with_directions: else they are zero. */
iso_status iso_node_levels_create(iso_node_levels *n, const iso_level *level0, size_t brick_voxels, size_t level_count,
                                  bool with_directions, int threads, iso_error *err);
typedef struct iso_node_options {
    size_t brick_voxels, level_count;
    iso_node_filter filter;
    bool with_directions;
    int threads;
} iso_node_options;
iso_status iso_node_levels_create_by(iso_node_levels *n, const iso_level *level0, const iso_node_options *opt,
                                     iso_error *err);
/* The same nodes, but only those that bricks of given levels are drawn by, a brick's by itself: of each brick that is coarser
 * than level 0 at once, since finer ones take the nodes of their faces from it; of the others when iso_brick_make() is asked.
 * Level 0 may be narrow (pyramid/narrow.h). code: directions are taken through it and back; NULL: they are not. The level's
 * samples and `levels`, a number a brick, are kept, not copied; fields of these nodes have the same levels.
 * iso_node_levels_round() and iso_node_levels_encode() are not for them. */
iso_status iso_node_levels_create_for(iso_node_levels *n, const iso_level *level0, const uint8_t *levels,
                                      const iso_code *code, const iso_node_options *opt, iso_error *err);
/* How much of a brick of level 0 is made: most of it are the directions. */
typedef enum iso_brick_content {
    ISO_BRICK_SCALARS, /* directions are 0 */
    ISO_BRICK_WHOLE
} iso_brick_content;
/* Makes a brick's nodes where there are none. Of several bricks by several threads. Who makes less than the whole forgets it
 * before somebody else wants more. ISO_E_MEMORY. */
iso_status iso_brick_make(const iso_node_levels *n, size_t brick, iso_brick_content content, iso_error *err);
/* Forgets nodes that iso_brick_make() would make again. */
void iso_brick_forget(const iso_node_levels *n, size_t brick);

/* `count` voxels of the row (y, z) of level 0 from x on, in whichever way the nodes were made of it. */
void iso_node_levels_voxels(const iso_node_levels *n, size_t x, size_t y, size_t z, size_t count, float *restrict row);

/* From the levels of a pyramid instead of its level 0: a node of level l is interpolated among that level's voxels,
 * cubic in the scalar (kept within the range of the eight voxels around) and linear in the decoded directions. Bricks
 * are as continuous and as fast to draw as with the filters above, but more blurred, because the voxels are means
 * already. ISO_E_RANGE, ISO_E_MEMORY. */
iso_status iso_node_levels_create_from_cells(iso_node_levels *n, const iso_pyramid *p, size_t brick_voxels,
                                             size_t level_count, int threads, iso_error *err);
/* Rounds the nodes of all levels to what a cache of 16 bits holds: scalars to 65535
 * steps of the range, directions to 1/32767. To be called before faces are baked: fine
 * face nodes are interpolated from rounded coarse ones. */
void iso_node_levels_round(iso_node_levels *n);
/* What such a cache holds of a node: the scalar's part of the range, and a component of the direction. */
static inline double iso_node_part(const iso_node_levels *n, float scalar)
{
    return n->max > n->min ? ((double)scalar - n->min) * (1 / (n->max - n->min)) : 0;
}
static inline uint16_t iso_node_scalar16(const iso_node_levels *n, float scalar)
{
    return (uint16_t)lrint(65535 * fmin(fmax(iso_node_part(n, scalar), 0), 1));
}
static inline int16_t iso_node_direction16(float component)
{
    return (int16_t)lrintf(32767 * fminf(fmaxf(component, -1), 1));
}
/* Takes the directions of all levels through a code and back, so that files that store decoded codes hold no more
 * values than those of a pyramid do. Codes that drop the length leave unit directions. */
void iso_node_levels_encode(iso_node_levels *n, iso_code code);
void iso_node_levels_destroy(iso_node_levels *n); /* accepts empty and NULL */

static inline size_t iso_brick_count(const iso_node_levels *n)
{
    return n->count[0] * n->count[1] * n->count[2];
}
static inline size_t iso_brick_index(const iso_node_levels *n, const size_t brick[3])
{
    return brick[0] + n->count[0] * (brick[1] + n->count[1] * brick[2]);
}
/* Nodes of a level along an axis: bricks share their faces. */
static inline size_t iso_node_count(const iso_node_levels *n, size_t level, int axis)
{
    return n->count[axis] * (n->brick_voxels >> level) + 1;
}
/* Nodes along a side of a brick at a level. */
static inline size_t iso_brick_side(const iso_node_levels *n, size_t level)
{
    return (n->brick_voxels >> level) + 1;
}

/* Which nodes the bricks hold. */
typedef enum iso_brick_faces {
    ISO_FACES_BAKED, /* the rule above */
    ISO_FACES_OWN    /* each brick its own level's: discontinuous, for comparison */
} iso_brick_faces;

/* A field of bricks: the level of each, by iso_brick_index(). */
typedef struct iso_brick_field {
    const iso_node_levels *nodes;
    const uint8_t *levels;
    iso_brick_faces faces;
} iso_brick_field;

/* The value of a brick's node (0 .. n / 2^l along each axis, l the brick's level). */
void iso_brick_node(const iso_brick_field *f, const size_t brick[3], const size_t node[3],
                    double out[ISO_NODE_CHANNELS]);

/* A brick's nodes of its own level, whatever its faces take from others: the first, and how many floats lie between rows and
 * between planes. */
typedef struct iso_own_nodes {
    const float *first;
    size_t row, plane;
} iso_own_nodes;
iso_own_nodes iso_brick_own_nodes(const iso_brick_field *f, const size_t brick[3]);

/* The first of a row of nodes along x, by the brick's own level: iso_brick_side() of them, ISO_NODE_CHANNELS a node. */
const float *iso_brick_own_row(const iso_brick_field *f, const size_t brick[3], size_t y, size_t z);

/* Do nodes on the brick's faces take values of a coarser brick? Else all are those of iso_brick_own_row(). */
bool iso_brick_has_foreign_nodes(const iso_brick_field *f, const size_t brick[3]);
/* The same of each part of the brick: corners, edges, faces and the inside (13, never), as iso_brick_part() numbers them. */
enum { ISO_BRICK_PARTS = 27 };
void iso_brick_foreign_parts(const iso_brick_field *f, const size_t brick[3], bool parts[ISO_BRICK_PARTS]);
static inline size_t iso_brick_part(size_t side, size_t x, size_t y, size_t z)
{
    return (x > 0) + (x + 1 == side) + 3 * ((size_t)(y > 0) + (y + 1 == side)) +
           9 * ((size_t)(z > 0) + (z + 1 == side));
}

/* The coarsest brick whose closed box holds node p of level 0. False: none is coarser than `level`. */
bool iso_brick_coarsest_at(const iso_brick_field *f, const size_t p[3], size_t level, size_t brick[3]);

/* The function of one brick at node coordinates q in its closed box: on a face this
 * is the limit from that brick's side. */
void iso_brick_sample_in(const iso_brick_field *f, const size_t brick[3], const double q[3],
                         double out[ISO_NODE_CHANNELS]);

/* The field at index coordinates (index = q + 1/2), clamped to the volume's nodes. */
void iso_brick_sample(const iso_brick_field *f, iso_vec3 index, double out[ISO_NODE_CHANNELS]);

#endif

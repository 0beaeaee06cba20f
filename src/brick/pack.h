/* SPDX-License-Identifier: MIT */
/* pack.h - bricks of several levels in one cache texture.
 *
 * After [beyer-2008], sections 3.1 to 3.3. The cache is a grid of cubic
 * slots; one holds a brick of level 0, or eight of level 1, or 64 of level 2 ...:
 * with L the coarsest level in use a slot has n + 2^L texels a side, so that every
 * halving still holds the n / 2^l + 1 nodes of a brick.
 *
 *     n = 32, L = 1      34        17   17
 *                     +-------+   +---+---+      layout texel of brick b:
 *                     |   0   |   | 1 | 1 |        x y z  texel of its node (0, 0, 0)
 *                     |       |   +---+---+        w      2^-l, or 0: the brick is left out
 *                     +-------+   | 1 | 1 |
 *                                 +---+---+
 *
 * Address translation (Eq. 1-5 with the level's scale kept beside the offset, so
 * that no large numbers cancel in float): u = q - n b, clamped to the brick, is at
 * texel  xyz + 1/2 + u w.
 *
 * What does not fit into one texture goes to further pages of the same size, stacked along z: a z above size[2] lies in
 * the next page.
 *
 * Placement depends on the levels and the visible bricks alone: fine bricks first,
 * then by index. */
#ifndef ISO_PACK_H
#define ISO_PACK_H

#include "brick/bricks.h"
#include "tf/tf.h"

#define ISO_BRICK_MAX_PAGES 4 /* textures that one program reads */

typedef struct iso_brick_pack {
    size_t slot_side;  /* texels */
    size_t slot_count; /* used */
    size_t slots[3];   /* of a page, along x, y, z */
    size_t size[3];    /* texels of a page */
    size_t page_count;
    size_t brick_count; /* in the cache */
    size_t node_count;  /* that these bricks hold */
    float *layout;      /* owned; 4 a brick */
} iso_brick_pack;

/* visible: one byte a brick, 0 leaves it out; NULL keeps all. A page has at most
 * max_side texels along an axis. ISO_E_RANGE when there would be more than ISO_BRICK_MAX_PAGES,
 * or more than max_slots slots (0: no limit), with both numbers; ISO_E_MEMORY. */
iso_status iso_brick_pack_create(iso_brick_pack *pack, const iso_node_levels *n, const uint8_t *levels,
                                 const uint8_t *visible, size_t max_side, size_t max_slots, iso_error *err);
void iso_brick_pack_destroy(iso_brick_pack *pack); /* accepts empty and NULL */

/* How many slots these levels need: what a cache of a given size is compared with. */
size_t iso_brick_pack_slots(const iso_node_levels *n, const uint8_t *levels, const uint8_t *visible, size_t *slot_side);

/* Texels of all pages of the cache that these levels need. */
size_t iso_brick_pack_texels(const iso_node_levels *n, const uint8_t *levels, const uint8_t *visible, size_t max_side);

/* All nodes of a brick as the field has them, x fastest, ISO_NODE_CHANNELS a node:
 * iso_brick_side()^3 of them. */
void iso_brick_bake(const iso_brick_field *f, const size_t brick[3], float *restrict out);

/* Whether the TF shows anything in the range of a brick's own baked values. */
bool iso_brick_shows(const iso_brick_field *f, const iso_tf_table *tf, const size_t brick[3]);
/* Which bricks the TF shows: marks visible[b] by the range of the brick's own baked
 * values, and returns the part that it shows. */
double iso_brick_cull(const iso_brick_field *f, const iso_tf_table *tf, int threads, uint8_t *restrict visible);

#endif

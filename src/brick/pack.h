/* SPDX-License-Identifier: MIT */
/* pack.h - bricks of several levels in one cache texture.
 *
 * After [beyer-2008], sections 3.1 to 3.3. The cache is a grid of cubic slots. A slot
 * has one brick of level 0, eight of level 1, 64 of level 2, and so on. With L the
 * coarsest level in use a slot has n + 2^L texels per side, so that each halving still
 * has space for the n / 2^l + 1 nodes of a brick.
 *
 *     n = 32, L = 1      34        17   17
 *                     +-------+   +---+---+      layout texel of brick b:
 *                     |   0   |   | 1 | 1 |        x y z  texel of its node (0, 0, 0)
 *                     |       |   +---+---+        w      2^-l, or 0: the brick is left out
 *                     +-------+   | 1 | 1 |
 *                                 +---+---+
 *
 * Address translation (Eq. 1-5 with the level's scale kept next to the offset, so
 * that no large numbers cancel in float): u = q - n b, clamped to the brick, is at
 * texel  xyz + 1/2 + u w.
 *
 * Bricks beyond the size of one texture go to further pages of the same size, stacked along z: a z above size[2] is in
 * the next page.
 *
 * Placement depends only on the levels and the visible bricks: fine bricks first,
 * then by index. */
#pragma once

#include "brick/bricks.h"
#include "tf/tf.h"

#define ISO_BRICK_MAX_PAGES 4 /* textures per shader program */

typedef struct iso_brick_pack {
    size_t slot_side;  /* texels */
    size_t slot_count; /* in use */
    size_t slots[3];   /* per page, along x, y, z */
    size_t size[3];    /* texels per page */
    size_t page_count;
    size_t brick_count; /* in the cache */
    size_t node_count;  /* in these bricks */
    float *layout;      /* owned; 4 per brick */
} iso_brick_pack;

/* Arranges the visible bricks. visible: one byte per brick, 0 leaves it out; NULL keeps all. A page has at most
 * max_side texels along an axis. ISO_E_RANGE, with both numbers: more than ISO_BRICK_MAX_PAGES pages, or more than
 * max_slots slots (0: no limit); ISO_E_MEMORY. */
iso_status iso_brick_pack_create(iso_brick_pack *pack, const iso_node_levels *n, const uint8_t *levels,
                                 const uint8_t *visible, size_t max_side, size_t max_slots, iso_error *err);
void iso_brick_pack_destroy(iso_brick_pack *pack); /* accepts empty and NULL */

/* Returns the number of slots that these levels need, to compare with a cache of fixed size. */
size_t iso_brick_pack_slots(const iso_node_levels *n, const uint8_t *levels, const uint8_t *visible, size_t *slot_side);

/* Returns the texels of all pages of the cache that these levels need. */
size_t iso_brick_pack_texels(const iso_node_levels *n, const uint8_t *levels, const uint8_t *visible, size_t max_side);

/* Computes all nodes of a brick in the field: iso_brick_side()^3 nodes of ISO_NODE_CHANNELS, x fastest. Makes missing
 * own nodes. ISO_E_MEMORY. */
iso_status iso_brick_bake(const iso_brick_field *f, const size_t brick[3], float *restrict out, iso_error *err);

/* True if the TF shows anything in the range of a brick's baked values. */
bool iso_brick_shows(const iso_brick_field *f, const iso_tf_table *tf, const size_t brick[3]);
/* Sets visible[b] for all bricks by the range of their baked values. wanted: one byte per brick, 0 leaves it out; or
 * NULL. */
void iso_brick_cull(const iso_brick_field *f, const iso_tf_table *tf, const uint8_t *wanted, int threads,
                    uint8_t *restrict visible);

/* SPDX-License-Identifier: MIT */
/* store.h - the baked nodes of all drawn bricks, kept from one plan to the next.
 *
 * A brick's values depend on its own level and, on its faces, on the levels of its up to 26 neighbors that are or
 * were coarser. A face node takes the value of the coarsest brick that it touches, which interpolates among nodes of
 * the same face, edge or corner; nothing further away matters. So an update bakes bricks that are new or have
 * another level, and those next to a brick whose level changed. The result is the same, byte for byte, as that of a
 * full bake. */
#pragma once

#include "brick/bricks.h"

typedef struct iso_brick_store {
    size_t brick_count;
    float **bricks;  /* owned; iso_brick_side()^3 nodes of ISO_NODE_CHANNELS, or NULL: not drawn */
    uint8_t *levels; /* owned */
} iso_brick_store;

/* Bakes the bricks that changed since the last update, or all bricks into an empty store. drawn: one byte per brick.
 * *baked: number of baked bricks; may be NULL. On failure the store is empty. ISO_E_MEMORY; ISO_E_RANGE: the store is
 * of another volume. */
iso_status iso_brick_store_update(iso_brick_store *store, const iso_brick_field *field, const uint8_t *drawn,
                                  int threads, size_t *baked, iso_error *err);
void iso_brick_store_destroy(iso_brick_store *store); /* accepts empty and NULL */

/* True if both stores have the same bricks with the same bytes. */
bool iso_brick_store_equal(const iso_brick_store *a, const iso_brick_store *b, const iso_node_levels *n);

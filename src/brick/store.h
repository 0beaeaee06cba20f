/* SPDX-License-Identifier: MIT */
/* store.h - the baked nodes of the bricks that are drawn, kept from one plan to the next.
 *
 * What a brick holds depends on its own level and, on its faces, on those of its up to 26 neighbors that are or were
 * coarser than it: a face node takes values of the coarsest brick that it touches, which interpolates them among nodes
 * of the same face, edge or corner, so that nothing further away matters. An update therefore bakes the bricks that are
 * new or of another level and those beside a brick whose level changed, and leaves the others as they are: the store is
 * the same, byte for byte, as one that is baked from nothing. */
#ifndef ISO_STORE_H
#define ISO_STORE_H

#include "brick/bricks.h"

typedef struct iso_brick_store {
    size_t brick_count;
    float **bricks;  /* owned; iso_brick_side()^3 nodes of ISO_NODE_CHANNELS, or NULL: not drawn */
    uint8_t *levels; /* owned */
} iso_brick_store;

/* Bakes what has changed since the last update, or all bricks into an empty store. drawn: one byte a brick. *baked
 * (may be NULL) is how many bricks were baked. On failure the store is empty. ISO_E_MEMORY, ISO_E_RANGE for a store of
 * another volume. */
iso_status iso_brick_store_update(iso_brick_store *store, const iso_brick_field *field, const uint8_t *drawn,
                                  int threads, size_t *baked, iso_error *err);
void iso_brick_store_destroy(iso_brick_store *store); /* accepts empty and NULL */

/* Same bricks, same bytes. */
bool iso_brick_store_equal(const iso_brick_store *a, const iso_brick_store *b, const iso_node_levels *n);

#endif

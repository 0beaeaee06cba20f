/* SPDX-License-Identifier: MIT */
/* nearest_table.h - the nearest of all directions that three unsigned bytes
 * decode to, by a table: exact, at tens of millions a second.
 *
 * For decoders that treat the 48 regions alike (the order and the signs of the
 * components) and not the length. In one region a direction is a point of the
 * plane (y, z) / x, 0 <= z <= y <= 1, cut into square cells. A cell lists every
 * code that is the nearest one somewhere in it: the border between two codes is
 * a great circle, a straight line of that plane, so a code is left out when
 * another one is nearer at all four corners. */
#ifndef ISO_ENCODE_NEAREST_TABLE_H
#define ISO_ENCODE_NEAREST_TABLE_H

#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

/* Eight codes, a line of the cache. */
typedef struct iso_nearest_block {
    int16_t y[8], z[8]; /* of the decoded (y, z) / x, from the cell's center, in small steps */
    uint8_t size[3][8]; /* the code's |components|, largest first: odd, in 255ths */
    uint8_t none[8];
} iso_nearest_block;

typedef struct iso_nearest_table {
    uint32_t *first; /* of each cell's blocks, and behind the last */
    iso_nearest_block *blocks;
} iso_nearest_table;

/* decoder: of code_decode.h. ISO_E_MEMORY. Takes half a second and 15 MB. ISO_E_RANGE for a decoder with
 * holes of several cells. */
iso_status iso_nearest_table_create(int decoder, iso_nearest_table *table, iso_error *err);
void iso_nearest_table_destroy(iso_nearest_table *table);

/* The zero vector becomes (128, 128, 128). */
void iso_nearest_encode(const iso_nearest_table *table, const float *restrict directions, uint8_t *restrict bytes,
                        size_t count);

#endif

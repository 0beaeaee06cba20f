/* SPDX-License-Identifier: MIT */
/* empty_space.h - where a level shows nothing under a transfer function, so that rays pass over it: exactly.
 *
 * Between the centers of eight voxels the scalar is trilinear (or one of theirs), so it stays between the least and the
 * largest of the eight. Where the transfer function's extinction is zero over that interval, nothing is emitted and
 * nothing absorbed: what skips such places changes no bit of a picture.
 *
 *     cell c of an axis: between the centers of the voxels c - 1 and c, clamped at the edge; size + 1 of them
 *
 *        voxels      | o | o | o | o |
 *        cells       |0| 1 | 2 | 3 |4|
 *
 * Blocks of 4, 16 and 64 cells a side say whether any of their cells shows something (a tree as in [levoy-1990], with
 * intervals as in [wilhelms-1992]). Intervals are widened by more than what sums of eight products are rounded by. */
#pragma once

#include "brick/bricks.h"
#include "tf/tf_2d.h"

/* Intervals of values that a transfer function shows. */
typedef struct iso_shown {
    const iso_tf_table *tf;
    double per_entry; /* entries per value */
    size_t *before;   /* owned; before[i]: how many of the entries below i have an extinction above zero */
} iso_shown;

/* Counts the visible entries; with tf_2d (or NULL), entries that any row shows. ISO_E_MEMORY. */
iso_status iso_shown_create(iso_shown *s, const iso_tf_table *tf, const iso_tf_2d *tf_2d, iso_error *err);
void iso_shown_destroy(iso_shown *s); /* accepts empty */

/* True if any entry from x0 to x1 is visible. Places on the table, in entries; they may lie outside of it. */
static inline bool iso_shown_entries(const iso_shown *s, double x0, double x1)
{
    const double last = (double)(s->tf->count - 1);
    const double lo = x0 > 0 ? (x0 < last ? x0 : last) : 0, hi = x1 > 0 ? (x1 < last ? x1 : last) : 0;
    const size_t first = (size_t)lo, end = (size_t)hi;
    return s->before[end + ((double)end < hi ? 2 : 1)] > s->before[first];
}

/* True if any value from lo to hi is visible. */
static inline bool iso_shown_values(const iso_shown *s, double lo, double hi)
{
    const double widen = 0x1p-49 * ((lo < 0 ? -lo : lo) + (hi < 0 ? -hi : hi));
    return iso_shown_entries(s, (lo - widen - s->tf->lo) * s->per_entry, (hi + widen - s->tf->lo) * s->per_entry);
}

enum { ISO_EMPTY_LEVELS = 3 };
static const int iso_empty_shift[ISO_EMPTY_LEVELS] = {2, 4, 6}; /* log2 of the cells along a block's edge */

typedef struct iso_empty_space {
    size_t cells[3];
    size_t blocks[ISO_EMPTY_LEVELS][3];
    uint8_t *seen[ISO_EMPTY_LEVELS]; /* owned; 0: the block shows nothing. NULL: not known, nothing is skipped */
} iso_empty_space;

/* Builds the tree of a level in memory. keep_lo, keep_hi: a box of index coordinates that counts as seen, or NULL.
 * ISO_E_MEMORY. */
iso_status iso_empty_space_create(iso_empty_space *e, const iso_level *level, const iso_shown *shown,
                                  const double keep_lo[3], const double keep_hi[3], int threads, iso_error *err);
void iso_empty_space_destroy(iso_empty_space *e); /* accepts empty */

/* Finds the largest empty block around a cell: cells lo to hi - 1. False: there is none. */
static inline bool iso_empty_space_at(const iso_empty_space *e, const int cell[3], int lo[3], int hi[3])
{
    if (!e->seen[0])
        return false;
    for (int l = ISO_EMPTY_LEVELS; l-- > 0;) {
        const int shift = iso_empty_shift[l];
        const size_t x = (size_t)(cell[0] >> shift), y = (size_t)(cell[1] >> shift), z = (size_t)(cell[2] >> shift);
        if (e->seen[l][(z * e->blocks[l][1] + y) * e->blocks[l][0] + x])
            continue;
        for (int a = 0; a < 3; ++a) {
            lo[a] = cell[a] >> shift << shift;
            hi[a] = lo[a] + (1 << shift);
        }
        return true;
    }
    return false;
}

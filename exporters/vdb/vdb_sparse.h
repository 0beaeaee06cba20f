/* SPDX-License-Identifier: MIT */
/* vdb_sparse.h - which voxels of a level a file has to hold, when it is known what the level is shown by.
 *
 * A cell is the cube between eight voxels' centers; within it the scalar is interpolated, so that it takes every value
 * between the least and the greatest of the eight. A cell is seen where a transfer function has an extinction above 0
 * for any of these; beyond the outermost voxels the edge is repeated. Every reader that interpolates finds in a file of the
 * kept voxels, with the background elsewhere, what it would find in a file of all:
 *
 *   lit    the corners of the cells that are seen. Directions, and what else is looked up there, are kept for these.
 *   kept   these, for the scalar, and each voxel that the transfer functions do not join to the background: they show
 *          something between its value and the background's.
 *
 *     o---o---o---.---.---O     o lit   O kept because of its value   . background
 *     | # | # |   |   | x |     cells marked # are seen
 *     o---o---o---.---.---O
 *
 * In a cell that is seen all eight values stay. In one that is not, voxels may be replaced by the background b: say that v
 * is replaced and w is not. The cell shows nothing between v and w, and the functions nothing between v and b (else v were
 * kept), so nothing between w and b either: w is lit for another cell's sake, and what lies between stays unseen (so the
 * cell marked x above cannot be). So b has to be a value that they do not show, and any such value will do. It is taken from
 * the range of values not shown in which most voxels lie, as far as can be from what shows, so that most are left out.
 *
 * This holds for the transfer functions that were given. One that is edited later can show what is no longer there.
 *
 * Without transfer functions: lit and kept are the corners of the cells whose eight values are not all the background's.
 * Then nothing is lost for any transfer function, but directions within a plain of that value, which are 0. */
#ifndef ISO_VDB_SPARSE_H
#define ISO_VDB_SPARSE_H

#include "pyramid/pyramid.h"
#include "vdb/vdb.h"

/* Of a level with its rim, or with one of a voxel where the file has none: cells reach beyond the outermost voxels. */
typedef struct iso_vdb_activity {
    size_t size[3];
    size_t skip;         /* voxels at each end that the file does not have */
    size_t row_bytes;    /* of bits; a row begins at a byte */
    uint8_t *kept, *lit; /* owned; size[1] * size[2] rows each, x in the lowest bit first */
    size_t kept_count, lit_count;
    float background;
} iso_vdb_activity;

/* pad: voxels of the rim; volume: of the scalars where the level has none (pyramid/narrow.h), or NULL. ISO_E_RANGE when the background that was asked for is shown, ISO_E_MEMORY. */
iso_status iso_vdb_activity_create(iso_vdb_activity *a, const iso_level *level, const iso_volume *volume,
                                   const iso_vdb_shown *shown, size_t pad, int threads, iso_error *err);
void iso_vdb_activity_destroy(iso_vdb_activity *a); /* accepts empty and NULL */

static inline bool iso_vdb_activity_bit(const iso_vdb_activity *a, const uint8_t *bits, const size_t at[3])
{
    return bits[(at[2] * a->size[1] + at[1]) * a->row_bytes + at[0] / 8] >> (at[0] & 7) & 1;
}

#endif

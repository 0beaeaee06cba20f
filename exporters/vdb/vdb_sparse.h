/* SPDX-License-Identifier: MIT */
/* vdb_sparse.h - selects the voxels of a level that a file must hold for given transfer functions.
 *
 * A cell is the cube between eight voxel centers. Its interpolated scalar takes every value between the least and the
 * greatest of the eight. A cell is seen if a transfer function has an extinction above 0 for any of these values.
 * Beyond the outermost voxels the edge is repeated. The kept voxels, with the background elsewhere, give every
 * interpolating reader the same picture as all voxels:
 *
 *   lit    the corners of the cells that are seen. Directions and other attributes are kept for these.
 *   kept   these, for the scalar, and each voxel not joined to the background: the transfer functions show a value
 *          between its own and the background's.
 *
 *     o---o---o---.---.---O     o lit   O kept because of its value   . background
 *     | # | # |   |   | x |     cells marked # are seen
 *     o---o---o---.---.---O
 *
 * A seen cell keeps all eight values. In another cell, voxels may be replaced by the background b. Suppose that v is
 * replaced and w is not. Nothing between v and w shows, since the cell is not seen. Nothing between v and b shows,
 * since v was not kept. So nothing between w and b shows either: w is lit because of another cell, and this cell stays
 * unseen (so the cell marked x above cannot occur). Hence b must be a hidden value, and any hidden value is correct. It
 * is taken from the hidden range that holds most voxels, as far as possible from visible values, so that most voxels
 * are left out.
 *
 * This holds for the given transfer functions. After a later edit, voxels that it shows may be missing.
 *
 * Without transfer functions, lit and kept are the corners of the cells whose eight values are not all the
 * background's. Then no transfer function loses anything, except directions inside a region of that value, which are
 * 0. */
#ifndef ISO_VDB_SPARSE_H
#define ISO_VDB_SPARSE_H

#include "pyramid/pyramid.h"
#include "vdb/vdb.h"

/* Marks of a level with its rim, or with a rim of one voxel if the file has none: cells reach beyond the outermost
 * voxels. */
typedef struct iso_vdb_activity {
    size_t size[3];
    size_t skip;         /* voxels at each end that the file does not have */
    size_t row_bytes;    /* bytes of a row of bits */
    uint8_t *kept, *lit; /* owned; size[1] * size[2] rows each, x in the lowest bit first */
    size_t kept_count, lit_count;
    float background;
} iso_vdb_activity;

/* Marks the voxels. pad: voxels of the rim; volume: scalars if the level has none (pyramid/narrow.h), or NULL.
 * ISO_E_RANGE: the requested background is visible. ISO_E_MEMORY. */
iso_status iso_vdb_activity_create(iso_vdb_activity *a, const iso_level *level, const iso_volume *volume,
                                   const iso_vdb_shown *shown, size_t pad, int threads, iso_error *err);
void iso_vdb_activity_destroy(iso_vdb_activity *a); /* accepts empty and NULL */

static inline bool iso_vdb_activity_bit(const iso_vdb_activity *a, const uint8_t *bits, const size_t at[3])
{
    return bits[(at[2] * a->size[1] + at[1]) * a->row_bytes + at[0] / 8] >> (at[0] & 7) & 1;
}

#endif

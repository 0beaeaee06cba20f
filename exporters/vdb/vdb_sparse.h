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
 * A seen cell keeps all eight values. Another cell may lose voxels to the background b, but must stay unseen. Proof,
 * for a lost voxel v and a kept voxel w of the cell: values between v and w are hidden, because the cell is not seen.
 * Values between v and b are hidden, because v is not kept. So values between w and b are hidden, too: w is kept for
 * another cell, and a cell like x above cannot occur. Any hidden value is a correct b. We take the hidden range that
 * holds most voxels, and in it the value farthest from visible ones, so that most voxels are left out.
 *
 * This holds for the given transfer functions. If they are edited later, visible voxels may be missing.
 *
 * Without transfer functions, lit and kept are the corners of all cells that are not pure background. Then every
 * transfer function gives the same picture, except that directions inside a region of the background's value are 0. */
#pragma once

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

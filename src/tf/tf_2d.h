/* SPDX-License-Identifier: MIT */
/* tf_2d.h - 2D transfer functions: over the scalar and a second value.
 *
 * A 1D transfer function cannot separate a homogeneous tissue from the partial voxels
 * of a thin structure with the same mean. A second value of the coarse voxel can: the
 * deviation of the fine values in it, or the gradient magnitude of the level
 * (histogram.h: iso_second_value). The 2D transfer function has ISO_TF_2D_ROWS rows;
 * each is a table over the scalar, all with the same range and number of entries:
 *
 *     row  ISO_TF_2D_ROWS - 1  |  o o o o o o o o      o  an entry
 *                              |  o o o o o o o o
 *                           0  |  o o o o o o o o
 *                                 lo  scalar   hi
 *
 * The second value is stored as one byte per voxel of the level and interpolated
 * trilinearly between voxel centers, like the scalar. Its row is
 *
 *     byte / 255 (ISO_TF_2D_ROWS - 1).
 *
 * Lookup is bilinear between entries, each component by itself, and clamped to the
 * outermost rows and entries. All renderers follow this definition; the reference
 * calls iso_tf_2d_lookup(). */
#pragma once

#include <stdint.h>

#include "tf/tf.h"

#define ISO_TF_2D_ROWS 8

typedef struct iso_tf_2d {
    iso_tf_table rows[ISO_TF_2D_ROWS]; /* owned; all with the same range and count */
    uint8_t *bytes;                    /* owned; the second value of each voxel of the level, x fastest */
} iso_tf_2d;
void iso_tf_2d_destroy(iso_tf_2d *t); /* accepts empty and NULL */

static inline double iso_tf_2d_row_of(double byte)
{
    return byte * ((ISO_TF_2D_ROWS - 1) / 255.0);
}

/* Looks up r, g, b, extinction at a value and a row, which may be fractional. */
static inline void iso_tf_2d_lookup(const iso_tf_2d *t, double value, double row, double rgbs[4])
{
    double r = row > 0 ? (row < ISO_TF_2D_ROWS - 1 ? row : ISO_TF_2D_ROWS - 1) : 0, above[4];
    int i = (int)r < ISO_TF_2D_ROWS - 2 ? (int)r : ISO_TF_2D_ROWS - 2;
    iso_tf_lookup(&t->rows[i], value, rgbs);
    iso_tf_lookup(&t->rows[i + 1], value, above);
    for (int k = 0; k < 4; ++k)
        rgbs[k] += (r - i) * (above[k] - rgbs[k]);
}

/* Creates *envelope, a 1D transfer function that bounds t: each entry has the largest extinction and the largest color
 * components over all rows, so that it is transparent only if all rows are. ISO_E_MEMORY. */
iso_status iso_tf_2d_envelope(const iso_tf_2d *t, iso_tf_table *envelope, iso_error *err);

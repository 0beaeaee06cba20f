/* SPDX-License-Identifier: MIT */
/* tf_2d.h - a transfer function over two values: the scalar and a class.
 *
 * One table over the scalar cannot tell a homogeneous tissue from the partial
 * voxels of a thin structure that share a mean. A second value of the coarse
 * voxel can: the deviation of the fine values inside it, or the magnitude of the
 * level's own gradient (histogram.h: iso_second_value). Either is a class
 * coordinate in [0, ISO_TF_2D_ROWS - 1], kept as a byte a voxel of the level,
 *
 *     coordinate = byte / 255 (ISO_TF_2D_ROWS - 1),
 *
 * trilinear between voxel centres as the scalar is. There is a table a class, all
 * of one range and count:
 *
 *     class   ISO_TF_2D_ROWS - 1 |  o o o o o o o o      o  an entry
 *                             |  o o o o o o o o
 *                           0 |  o o o o o o o o
 *                                lo  scalar   hi
 *
 * bilinear between entries, each component by itself, clamped to the outermost.
 * Every renderer looks up this definition; iso_tf_2d_lookup() is the arbiter's. */
#ifndef ISO_TF_2D_H
#define ISO_TF_2D_H

#include <stdint.h>

#include "tf/tf.h"

#define ISO_TF_2D_ROWS 8

typedef struct iso_tf_2d {
    iso_tf_table tables[ISO_TF_2D_ROWS]; /* owned; of one range and count */
    uint8_t *bytes;                   /* owned; one a voxel of the level, x fastest */
} iso_tf_2d;
void iso_tf_2d_destroy(iso_tf_2d *t); /* accepts empty and NULL */

static inline double iso_tf_2d_coordinate(double byte)
{
    return byte * ((ISO_TF_2D_ROWS - 1) / 255.0);
}

/* r, g, b, extinction at a value and a class coordinate. */
static inline void iso_tf_2d_lookup(const iso_tf_2d *t, double value, double coordinate, double rgbs[4])
{
    double c = coordinate > 0 ? (coordinate < ISO_TF_2D_ROWS - 1 ? coordinate : ISO_TF_2D_ROWS - 1) : 0, above[4];
    int i = (int)c < ISO_TF_2D_ROWS - 2 ? (int)c : ISO_TF_2D_ROWS - 2;
    iso_tf_lookup(&t->tables[i], value, rgbs);
    iso_tf_lookup(&t->tables[i + 1], value, above);
    for (int k = 0; k < 4; ++k)
        rgbs[k] += (c - i) * (above[k] - rgbs[k]);
}

/* Of each entry the largest extinction and the largest colour components of any
 * class: what bounds the table, and is transparent only where all classes are.
 * *envelope is created. ISO_E_MEMORY. */
iso_status iso_tf_2d_envelope(const iso_tf_2d *t, iso_tf_table *envelope, iso_error *err);

#endif

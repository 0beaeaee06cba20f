/* SPDX-License-Identifier: MIT */
/* class_tables.h - a transfer function over two values: the scalar and a class.
 *
 * One table over the scalar cannot tell a homogeneous tissue from the partial
 * voxels of a thin structure that share a mean. A second value of the coarse
 * voxel can: the deviation of the fine values inside it, or the magnitude of the
 * level's own gradient (histogram.h: iso_joint_split). Either is a class
 * coordinate in [0, ISO_CLASSES - 1], kept as a byte a voxel of the level,
 *
 *     coordinate = byte / 255 (ISO_CLASSES - 1),
 *
 * trilinear between voxel centres as the scalar is. There is a table a class, all
 * of one range and count:
 *
 *     class   ISO_CLASSES - 1 |  o o o o o o o o      o  an entry
 *                             |  o o o o o o o o
 *                           0 |  o o o o o o o o
 *                                lo  scalar   hi
 *
 * bilinear between entries, each component by itself, clamped to the outermost.
 * Every renderer looks up this definition; iso_class_lookup() is the arbiter's. */
#ifndef ISO_TF_CLASS_TABLES_H
#define ISO_TF_CLASS_TABLES_H

#include <stdint.h>

#include "tf/tf.h"

#define ISO_CLASSES 8

typedef struct iso_class_tables {
    iso_tf_table tables[ISO_CLASSES]; /* owned; of one range and count */
    uint8_t *bytes;                   /* owned; one a voxel of the level, x fastest */
} iso_class_tables;
void iso_class_tables_destroy(iso_class_tables *t); /* accepts empty and NULL */

static inline double iso_class_coordinate(double byte)
{
    return byte * ((ISO_CLASSES - 1) / 255.0);
}

/* r, g, b, extinction at a value and a class coordinate. */
static inline void iso_class_lookup(const iso_class_tables *t, double value, double coordinate, double rgbs[4])
{
    double c = coordinate > 0 ? (coordinate < ISO_CLASSES - 1 ? coordinate : ISO_CLASSES - 1) : 0, above[4];
    int i = (int)c < ISO_CLASSES - 2 ? (int)c : ISO_CLASSES - 2;
    iso_tf_lookup(&t->tables[i], value, rgbs);
    iso_tf_lookup(&t->tables[i + 1], value, above);
    for (int k = 0; k < 4; ++k)
        rgbs[k] += (c - i) * (above[k] - rgbs[k]);
}

/* Of each entry the largest extinction and the largest colour components of any
 * class: what bounds the table, and is transparent only where all classes are.
 * *envelope is created. ISO_E_MEMORY. */
iso_status iso_class_envelope(const iso_class_tables *t, iso_tf_table *envelope, iso_error *err);

#endif

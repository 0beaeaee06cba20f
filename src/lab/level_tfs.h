/* SPDX-License-Identifier: MIT */
/* level_tfs.h - the four transfer functions that levels are judged by: fixed as fractions of a volume's range, the same for
 * every volume. */
#ifndef ISO_LEVEL_TFS_H
#define ISO_LEVEL_TFS_H

#include "tf/tf.h"

typedef struct iso_level_tf {
    const char *name;
    size_t point_count;
    iso_tf_point points[9];
} iso_level_tf;

enum { ISO_LEVEL_TF_COUNT = 4 };
extern const iso_level_tf iso_level_tfs[ISO_LEVEL_TF_COUNT];

/* Five colors in a row that is no ramp of brightness, and two humps of opacity: what a mean of values takes for another
 * material has another color. */
extern const iso_level_tf iso_level_tf_colored;

/* Its points are borrowed: it is not to be destroyed. */
iso_tf iso_level_tf_of(const iso_level_tf *tf);

#endif

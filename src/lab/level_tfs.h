/* SPDX-License-Identifier: MIT */
/* level_tfs.h - the four transfer functions of level benchmarks: fixed as fractions of a volume's range, the same for
 * all volumes. */
#pragma once

#include "tf/tf.h"

typedef struct iso_level_tf {
    const char *name;
    size_t point_count;
    iso_tf_point points[9];
} iso_level_tf;

enum { ISO_LEVEL_TF_COUNT = 4 };
extern const iso_level_tf iso_level_tfs[ISO_LEVEL_TF_COUNT];

/* Five unordered colors and two humps of opacity: averages that hit another material's value get another color. */
extern const iso_level_tf iso_level_tf_colored;

/* Returns it as a TF. Its points are borrowed: do not destroy it. */
iso_tf iso_level_tf_of(const iso_level_tf *tf);

/* SPDX-License-Identifier: MIT */
/* levels_across.h - the designs of coarse levels measured for one volume and one transfer function: what `chart
 * --across-levels` draws. The designs are methods of `bench levels` (level_methods.h), the errors are its errors. */
#ifndef ISO_BENCH_LEVELS_ACROSS_H
#define ISO_BENCH_LEVELS_ACROSS_H

#include "bench/level_error.h"
#include "options/cli.h"
#include "options/input.h"
#include "tf/tf.h"

typedef struct iso_levels_across {
    const iso_cli *cli;
    const iso_volume_input *input;
    const char *volume, *methods; /* names with commas between them; level_methods.h */
    const iso_tf *tf;
    int levels, views, size;
} iso_levels_across;

/* A design at a level. */
typedef struct iso_levels_across_row {
    const char *design, *summary;
    size_t level;
    double bytes; /* of the level: two a voxel for the scalar, and what the design has beside it */
    double seconds; /* of the fastest frame of the views */
    iso_level_error full, minified;
    const char *scalar, *treatment, *directions; /* what the design is made of, by name */
    int chosen_within; /* the bytes of the budget within which build --auto chooses it, or 0 */
} iso_levels_across_row;

/* Rows, design by design, to be freed. ISO_E_USAGE: an unknown name; what building and rendering return. */
iso_status iso_levels_across_measure(const iso_levels_across *in, iso_levels_across_row **rows, size_t *count,
                                     iso_error *err);

#endif

/* SPDX-License-Identifier: MIT */
/* tf.h - the actions of `isoshade tf`, one file each: tf_NAME.c. */
#pragma once

#include "options/adapted.h"
#include "options/cli.h"
#include "options/input.h"
#include "options/look.h"

typedef struct iso_tf_arguments {
    iso_volume_input input;
    iso_cli_adapted adapted;
    iso_cli_look look;
    char *output, *volume;
    int level, level_count, optimize; /* level: 0 for all coarse levels; level_count: for a volume */
    const iso_cli *cli;               /* arguments[0]: the action */
} iso_tf_arguments;

/* Adapts a transfer function to each coarse level, and decides whether to use it. */
iso_status iso_cli_tf_adapt(const iso_tf_arguments *a, iso_error *err);
/* Bounds the error of images of coarse levels. */
iso_status iso_cli_tf_bound(const iso_tf_arguments *a, iso_error *err);
/* Reads and writes transfer functions of other programs. */
iso_status iso_cli_tf_convert(const iso_tf_arguments *a, iso_error *err);
iso_status iso_cli_tf_names(const iso_tf_arguments *a, iso_error *err);
/* Draws transfer functions over the histogram of a volume. */
iso_status iso_cli_tf_show(const iso_tf_arguments *a, iso_error *err);
/* Writes a transfer function for a volume, to edit. */
iso_status iso_cli_tf_suggest(const iso_tf_arguments *a, iso_error *err);

/* Stage of the work on levels, and its part of the time: a pyramid may have to be built first. */
#define ISO_TF_LEVELS_STAGE "levels"
void iso_cli_tf_expect_levels(const iso_cli *cli);
/* A TF file and its table, for the volume of --volume, or for the range [0, 1] and voxels of 1 mm. */
typedef struct iso_cli_tf_table {
    iso_tf tf;
    iso_tf_table table;
    double unit_mm, voxel_mm; /* voxel_mm: cube root of a voxel's volume */
} iso_cli_tf_table;
/* Loads the volume of --volume, or returns an empty one. ISO_E_USAGE for a pyramid. */
iso_status iso_cli_tf_load_volume(const iso_tf_arguments *a, iso_volume *v, iso_error *err);
iso_status iso_cli_tf_load_table(const iso_tf_arguments *a, const char *path, iso_cli_tf_table *t, iso_error *err);
void iso_cli_tf_table_destroy(iso_cli_tf_table *t);

/* SPDX-License-Identifier: MIT */
/* tf_convert.h - `isoshade tf convert` and `tf names`: read and write transfer functions of other programs. */
#pragma once

#include "cli/tf_adapt.h"

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

iso_status iso_cli_tf_convert(const iso_tf_arguments *a, iso_error *err);
iso_status iso_cli_tf_names(const iso_tf_arguments *a, iso_error *err);

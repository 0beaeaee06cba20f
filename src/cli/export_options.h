/* SPDX-License-Identifier: MIT */
/* export_options.h - checks the options of `isoshade export` with each other and with the target. */
#pragma once

#include "cli/cycles_options.h"
#include "options/adapted.h"
#include "options/cli.h"
#include "options/input.h"
#include "options/look.h"
#include "options/roi.h"
#include "targets/targets.h"

/* Options as given; 0 and NULL: not given. */
typedef struct iso_export_arguments {
    iso_volume_input input;
    iso_cli_adapted adapted;
    iso_cli_roi roi;
    iso_cli_look look;
    iso_cli_cycles cycles;
    iso_bake_words bake_words;
    iso_bake_request bake;
    char *to, *output, *isosurface, *plan, *grids, *frames, *channels, *material, *background_text;
    char **added;
    int level, level_count, half, dense, force;
    size_t material_row;
    double step, background;
    bool has_background;
    const iso_cli *cli;
} iso_export_arguments;

/* True if a plan is written as one grid, instead of one per level. */
bool iso_export_wants_merged(const iso_export_arguments *a);

/* True if a transfer function is given that decides which voxels the grids hold; grids themselves need none. */
bool iso_export_is_shown(const iso_export_arguments *a, const iso_export_target *target);

/* Finds the target, and checks the options before the work. ISO_E_USAGE, ISO_E_RANGE: options that exclude each other
 * or have no effect; ISO_E_IO: a file was changed by hand. */
iso_status iso_export_check(iso_export_arguments *a, const iso_export_target **target, iso_error *err);

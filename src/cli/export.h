/* SPDX-License-Identifier: MIT */
/* export.h - arguments of `isoshade export`, and the export of several volumes in one scene. */
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

/* Exports the channels of a file, or the file and the volumes of --add. Options for the input apply to the first
 * volume. look: of the scene. ISO_E_USAGE: the target takes a single volume. */
iso_status iso_export_several_volumes(const iso_export_arguments *a, const iso_export_target *target,
                                      const iso_subject_look *look, iso_error *err);

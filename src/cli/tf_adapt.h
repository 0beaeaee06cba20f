/* SPDX-License-Identifier: MIT */
/* tf_adapt.h - `isoshade tf adapt`: adapts a transfer function to each coarse level, and decides whether to use it. */
#pragma once

#include "options/adapted.h"
#include "options/cli.h"
#include "options/input.h"
#include "options/look.h"

/* Arguments of the actions of `isoshade tf`. */
typedef struct iso_tf_arguments {
    iso_volume_input input;
    iso_cli_adapted adapted;
    iso_cli_look look;
    char *output, *volume;
    int level, level_count, optimize;
    const iso_cli *cli;
} iso_tf_arguments;

/* Stage of the work on levels, and its part of the time: a pyramid may have to be built first. */
#define ISO_TF_LEVELS_STAGE "levels"
void iso_cli_tf_expect_levels(const iso_cli *cli);

iso_status iso_cli_tf_adapt(const iso_tf_arguments *a, iso_error *err);

/* Loads the pyramid arguments[1], or builds it from a volume. A stored pyramid, which keeps its histograms, is read
 * with samples only for small views, for transfer functions made from values, and if a histogram is missing. */
iso_status iso_cli_tf_load_subject(const iso_tf_arguments *a, const iso_subject_look *look, bool small_views,
                                   const iso_pyramid_options *build, iso_pyramid *p, iso_error *err);
/* Makes the table of the look's transfer function. */
iso_status iso_cli_tf_tabulate(const iso_subject_look *look, const iso_pyramid *p, iso_tf_table *table, iso_error *err);

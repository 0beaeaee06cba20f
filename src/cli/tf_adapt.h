/* SPDX-License-Identifier: MIT */
/* tf_adapt.h - `isoshade tf adapt`: the transfer function of each coarse level, and whether it is used. */
#ifndef ISO_CLI_TF_ADAPT_H
#define ISO_CLI_TF_ADAPT_H

#include "options/adapted.h"
#include "options/cli.h"
#include "options/input.h"
#include "options/look.h"

/* What the actions of `isoshade tf` are given. */
typedef struct iso_tf_arguments {
    iso_volume_input input;
    iso_cli_adapted adapted;
    iso_cli_look look;
    char *output, *volume;
    int level, level_count;
    const iso_cli *cli;
} iso_tf_arguments;

/* The stage of work on one level after the other, and its part in the time: a pyramid may have to be built first. */
#define ISO_TF_LEVELS_STAGE "levels"
void iso_cli_tf_expect_levels(const iso_cli *cli);

iso_status iso_cli_tf_adapt(const iso_tf_arguments *a, iso_error *err);

/* The pyramid that arguments[1] is, or is built into. Of a stored one, which keeps its histograms, the samples are read
 * for small views and for a transfer function that is made from values, and where a histogram is missing. */
iso_status iso_cli_tf_load_subject(const iso_tf_arguments *a, const iso_subject_look *look, bool small_views,
                                   const iso_pyramid_options *build, iso_pyramid *p, iso_error *err);
/* The transfer function of what is looked at. */
iso_status iso_cli_tf_tabulate(const iso_subject_look *look, const iso_pyramid *p, iso_tf_table *table, iso_error *err);

#endif

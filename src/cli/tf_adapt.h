/* SPDX-License-Identifier: MIT */
/* tf_adapt.h - `isoshade tf adapt`: the transfer function of each coarse level, and whether it is used. */
#ifndef ISO_CLI_TF_ADAPT_H
#define ISO_CLI_TF_ADAPT_H

#include "options/adapted.h"
#include "options/cli.h"
#include "options/input.h"
#include "options/transfer.h"

/* What the actions of `isoshade tf` are given. */
typedef struct iso_tf_arguments {
    iso_volume_input input;
    iso_cli_adapted adapted;
    iso_cli_transfer transfer;
    char *tf, *output, *volume, *scene, *size;
    int level, level_count;
    int automatic, budget_bytes; /* --auto, --budget */
    const iso_cli *cli;
} iso_tf_arguments;

/* The stage of work on one level after the other, and its part in the time: a pyramid may have to be built first. */
#define ISO_TF_LEVELS_STAGE "levels"
void iso_cli_tf_expect_levels(const iso_cli *cli);

iso_status iso_cli_tf_adapt(const iso_tf_arguments *a, iso_error *err);

/* The pyramid that arguments[1] is, or is built into. Of a stored one, which keeps its histograms, the samples are read
 * for small views alone, and where a histogram is missing. */
iso_status iso_cli_tf_load_subject(const iso_tf_arguments *a, bool small_views, const iso_pyramid_options *build,
                                   iso_pyramid *p, iso_error *err);

#endif

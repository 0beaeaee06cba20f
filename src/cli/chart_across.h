/* SPDX-License-Identifier: MIT */
/* chart_across.h - `isoshade chart --across-levels`: the designs of coarse levels on their front. */
#ifndef ISO_CLI_CHART_ACROSS_H
#define ISO_CLI_CHART_ACROSS_H

#include "chart/result.h"
#include "options/cli.h"
#include "options/input.h"
#include "options/look.h"

typedef struct iso_chart_across {
    const iso_cli *cli;
    const iso_volume_input *input;
    const iso_cli_look *look;             /* its transfer function, and pixels along an edge */
    const char *output, *style, *designs; /* designs: names of `bench levels --help`; NULL: all */
    iso_chart_metric metric;
    int level_count, views;
} iso_chart_across;

iso_status iso_cli_chart_across(const iso_chart_across *a, iso_error *err);

#endif

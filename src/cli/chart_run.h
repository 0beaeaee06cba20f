/* SPDX-License-Identifier: MIT */
/* chart_run.h - `isoshade chart`: measures settings of one or several scenes within a budget, and writes the chart. */
#pragma once

#include "chart/result.h"
#include "options/cli.h"
#include "options/input.h"
#include "options/look.h"

typedef struct iso_chart_arguments {
    iso_volume_input input;
    iso_cli_look look;
    char *output, *renderers, *want_text, *style, *metric_text, *bytes_text;
    iso_chart_words words;
    int level_count, processor_time, resume, viewer;
    double budget_seconds; /* 0: unlimited, the whole grid is measured */
    double want;           /* 0: none */
    iso_chart_metric metric;
    iso_chart_bytes bytes;
} iso_chart_arguments;

/* Runs `isoshade chart`. ISO_E_DIFFERS: no measured setting has the wanted error. */
iso_status iso_cli_chart(const iso_chart_arguments *a, const iso_cli *cli, iso_error *err);

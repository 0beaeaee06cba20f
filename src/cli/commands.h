/* SPDX-License-Identifier: MIT */
/* commands.h - the list of commands, in the order of --help. src/cli/cmd_NAME.c defines iso_command_NAME. */
#pragma once

#include "options/cli.h"

#define ISO_COMMAND_LIST(X) \
    X(info) \
    X(list) \
    X(make) \
    X(validate) \
    X(build) \
    X(palette) \
    X(tf) \
    X(render) \
    X(view) \
    X(scenes) \
    X(plan) \
    X(export) \
    X(compare) \
    X(chart) \
    X(figure) \
    X(report) \
    X(certificate) \
    X(atlas) \
    X(bench)

/* Commands "bench NAME" (src/bench/bench.h). */
extern const iso_command *const iso_benchmarks[]; /* ends with NULL */
/* Finds a benchmark by the word after "bench". NULL if there is none. */
const iso_command *iso_benchmark_find(const char *name);

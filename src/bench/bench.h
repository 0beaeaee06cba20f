/* SPDX-License-Identifier: MIT */
/* bench.h - the one list of benchmarks; `isoshade bench NAME` and its help
 * expand from it. src/bench/NAME.c defines iso_bench_NAME, an iso_command
 * whose name is "bench NAME"; it is called and parses as a command does. */
#ifndef ISO_BENCH_H
#define ISO_BENCH_H

#include "options/cli.h"

/* clang-format off */
#define ISO_BENCH_LIST(X) \
    X(all) \
    X(bound) \
    X(build) \
    X(cast) \
    X(compare) \
    X(gradient)       \
    X(levels) \
    X(noise) \
    X(consistency) \
    X(convergence) \
    X(encode) \
    X(extinction_scale) \
    X(fit) \
    X(ghosts) \
    X(job) \
    X(palette) \
    X(power) \
    X(plan) \
    X(seams) \
    X(reference) \
    X(render) \
    X(roi) \
    X(scale) \
    X(tf)
/* clang-format on */

#endif

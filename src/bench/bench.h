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
    X(build) \
    X(cast) \
    X(compare) \
    X(render) \
    X(scale)
/* clang-format on */

#endif

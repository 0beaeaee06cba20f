/* SPDX-License-Identifier: MIT */
/* bench.h - the list of benchmarks, from which `isoshade bench NAME` and its help expand. src/bench/NAME.c defines
 * iso_bench_NAME, an iso_command named "bench NAME". */
#pragma once

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

/* bench_shading.h - bench consistency --shading: directions across levels. */
#ifndef ISO_CLI_BENCH_SHADING_H
#define ISO_CLI_BENCH_SHADING_H

#include "cli/cli.h"

iso_status iso_bench_shading(int argc, const char **argv, iso_error *err);

#endif

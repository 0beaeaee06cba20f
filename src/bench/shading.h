/* SPDX-License-Identifier: MIT */
/* shading.h - bench consistency --shading: directions across levels; --filters, --holes: where they fail. */
#ifndef ISO_BENCH_SHADING_H
#define ISO_BENCH_SHADING_H

#include "options/cli.h"

iso_status iso_bench_shading(int argc, const char **argv, iso_error *err);
iso_status iso_bench_filters(int argc, const char **argv, iso_error *err);

#endif

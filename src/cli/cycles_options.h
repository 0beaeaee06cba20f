/* SPDX-License-Identifier: MIT */
/* cycles_options.h - which Blender, and what its Cycles renders on: options of the commands that run it. */
#ifndef ISO_CLI_CYCLES_OPTIONS_H
#define ISO_CLI_CYCLES_OPTIONS_H

#include <popt.h>

#include "base/json.h"
#include "base/status.h"

typedef struct iso_cli_cycles {
    char *blender, *device;
} iso_cli_cycles;

/* clang-format off */
#define ISO_CLI_CYCLES_OPTIONS(a, what, argument)                                                                  \
    {"blender", 0, POPT_ARG_STRING, &(a)->blender, 0, what, argument},                                            \
    {"cycles-device", 0, POPT_ARG_STRING, &(a)->device, 0,                                                        \
     "what Cycles renders on: cpu, gpu, or one of optix, cuda, hip, oneapi, metal (cpu)", "DEVICE"}
/* clang-format on */

/* with: the renderers that are asked for, or NULL for all: Cycles has to be one of them, for options of it to mean anything.
 * What iso_renderers_take_blenders() and iso_cycles_set_device() return. */
iso_status iso_cli_take_cycles(const iso_cli_cycles *a, const char *with, iso_error *err);

/* A line for each two Blenders that a report compares: what changed most between them, and whether that is beyond chance. */
void iso_cli_print_versions(const json_t *report);

#endif

/* SPDX-License-Identifier: MIT */
/* cycles_options.h - options for the Blender program and the device of its Cycles. */
#pragma once

#include "base/json.h"
#include "base/status.h"
#include "options/option.h"

typedef struct iso_cli_cycles {
    char *blender, *device;
} iso_cli_cycles;

/* clang-format off */
#define ISO_CLI_CYCLES_OPTIONS(type, member, what, argument) \
    {"blender", 0, what, argument, ISO_IN(type, member.blender)}, \
    {"cycles-device", 0, "device of Cycles: cpu, gpu, optix, cuda, hip, oneapi or metal (cpu)", "DEVICE", ISO_IN(type, member.device)}
/* clang-format on */

/* Applies the options. with: requested renderers, or NULL for all; they must include Cycles if options for it are
 * given. Errors as of iso_renderers_take_blenders() and iso_cycles_set_device(). */
iso_status iso_cli_take_cycles(const iso_cli_cycles *a, const char *with, iso_error *err);

/* Prints a line for each pair of Blenders in a report: the largest change, and whether it exceeds the noise. */
void iso_cli_print_versions(const json_t *report);

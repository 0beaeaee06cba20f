/* SPDX-License-Identifier: MIT */
/* overwrite.h - refuses outputs that would replace an input: a mistyped name would lose a volume. */
#pragma once

#include <popt.h>

#include "base/status.h"

/* Compares output options of a parsed table (-o, --png, ...) with the arguments, with all other options and with each
 * other, and announces the outputs (base/inputs.h). arguments ends with NULL, or is NULL. ISO_E_USAGE: an output is a
 * regular file that is also read, under any name or link, or two outputs are the same. */
iso_status iso_cli_refuse_overwriting(const struct poptOption *options, const char *const *arguments, iso_error *err);

/* Fails with ISO_E_USAGE if both are the same regular file. Either may be NULL. */
iso_status iso_cli_refuse_same_file(const char *output, const char *input, iso_error *err);

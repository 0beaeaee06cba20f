/* SPDX-License-Identifier: MIT */
/* overwrite.h - an output never replaces what it is made of: a mistyped name would lose a volume. */
#ifndef ISO_OPTIONS_OVERWRITE_H
#define ISO_OPTIONS_OVERWRITE_H

#include <popt.h>

#include "base/status.h"

/* Compares the options of a parsed table that name outputs (-o, --png, ...) with the arguments, with what the other
 * options name and with each other, and announces them (base/inputs.h). arguments ends with NULL, or is NULL.
 * ISO_E_USAGE: an output is a regular file that is read, too, by whatever name or link, or two outputs are one. */
iso_status iso_cli_refuse_overwriting(const struct poptOption *options, const char *const *arguments, iso_error *err);

/* ISO_E_USAGE where both are one regular file. Either may be NULL. */
iso_status iso_cli_refuse_same_file(const char *output, const char *input, iso_error *err);

#endif

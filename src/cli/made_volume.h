/* SPDX-License-Identifier: MIT */
/* made_volume.h - makes the volumes of a suite's scenes by the words that they give for `isoshade make`. */
#pragma once

#include "base/status.h"

/* Runs `isoshade make WORDS -o path -q`. The words come from a file, so only options of make itself are allowed,
 * without -o and without common options such as --no-sandbox, which would affect the whole process. ISO_E_FORMAT
 * otherwise. */
iso_status iso_cli_make_volume(const char *words, const char *path, iso_error *err);

/* SPDX-License-Identifier: MIT */
/* made_volume.h - the volumes of a suite's scenes, which say how `isoshade make` makes them. */
#ifndef ISO_CLI_MADE_VOLUME_H
#define ISO_CLI_MADE_VOLUME_H

#include "base/status.h"

/* `isoshade make WORDS -o path -q`, by the command itself. The words are a file's, so they may name options that are
 * make's alone: not -o, nor one of all commands, such as --no-sandbox, which is of this whole process. ISO_E_FORMAT
 * otherwise. */
iso_status iso_cli_make_volume(const char *words, const char *path, iso_error *err);

#endif

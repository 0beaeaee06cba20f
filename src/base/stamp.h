/* SPDX-License-Identifier: MIT */
/* stamp.h - detects changes to a file after isoshade wrote it.
 *
 * Files that people edit, such as scenes, end in a line with the checksum of all before it. Copies, renamed and
 * moved files keep it. A program that rewrites the file drops it, and an editor that changes a byte makes it wrong.
 * So only an unchanged file is overwritten without a question. */
#pragma once

#include <stdbool.h>

#include "base/status.h"

/* Appends the line to a finished file, after `comment`, which makes the file's reader skip it: "// ". ISO_E_IO. */
iso_status iso_stamp_append(const char *path, const char *comment, iso_error *err);

/* Guards a file that work will overwrite. ISO_OK: it is missing or stamped. Else ISO_E_IO, which names the file and the
 * remedy; with force the file stays as PATH1, as Blender names a backup, or as PATH2, PATH3 ... if that is taken. */
iso_status iso_stamp_guard(const char *path, bool force, iso_error *err);
/* Guards a file that cannot hold a stamp: the caller decides if it is ours. */
iso_status iso_stamp_guard_other(const char *path, bool is_ours, bool force, iso_error *err);
/* Guards a file of a command without --force, named after another output. */
iso_status iso_stamp_guard_adjacent(const char *path, bool is_ours, iso_error *err);

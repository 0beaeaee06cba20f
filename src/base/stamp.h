/* SPDX-License-Identifier: MIT */
/* stamp.h - was a file changed since isoshade wrote it?
 *
 * Files that people edit, as scenes are, end in a line with the checksum of all before it. Copies, renamed and moved files
 * keep it; a program that saves the file anew drops it, and an editor that changes a byte makes it wrong. So a file is
 * overwritten without a question only while it is what was written. */
#ifndef ISO_STAMP_H
#define ISO_STAMP_H

#include <stdbool.h>

#include "base/status.h"

/* Appends the line to a finished file, behind `comment`, which makes it one that the file's reader skips: "// ". ISO_E_IO. */
iso_status iso_stamp_append(const char *path, const char *comment, iso_error *err);

/* There is a line with the checksum of what stands before it. */
bool iso_stamp_fits(const char *path);

/* Before work that will overwrite path: ISO_OK where nothing stands there, or what was stamped; else ISO_E_IO, which names
 * the file and the way round. With force a file that would be refused stays as "path1", as Blender names a backup. */
iso_status iso_stamp_guard(const char *path, bool force, iso_error *err);
/* The same for a file that has no room for a stamp, and tells by something else whether it is ours. */
iso_status iso_stamp_guard_other(const char *path, bool is_ours, bool force, iso_error *err);
/* The same where a command has no --force: for a file that gets its name from another output's. */
iso_status iso_stamp_guard_beside(const char *path, bool is_ours, iso_error *err);

#endif

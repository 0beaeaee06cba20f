/* SPDX-License-Identifier: MIT */
/* manifest.h - the list of the files that isoshade put into a folder, so that nothing else in it is ever removed.
 *
 * The file .isoshade-files in the folder has one line for each entry: kind (f: file, d: folder), size in bytes,
 * checksum, and the path in the folder. The checksum is XXH3 with 64 bits, for files of at most a mebibyte and for
 * those added later; "-" for others. Newlines in paths are refused.
 * A file without a checksum counts as changed if its size differs, or if its last change is later than the list's.
 * So a folder copied without its times is not replaced. */
#pragma once

#include <stdbool.h>

#include "base/status.h"

#define ISO_MANIFEST_NAME ".isoshade-files"

/* Lists the folder's entries, and writes the list into it: all, or those with a name of `own`
 * (iso_output_resume_dir()). */
iso_status iso_manifest_write(const char *folder, const char *const *own, iso_error *err);

/* Adds a file that was put into a folder later, if the folder has a list. Several processes may do so at once. false:
 * it is not listed, and should go. */
bool iso_manifest_add(const char *folder, const char *name);

/* Does the same for another output of the command that wrote the folder, if its path leads into the folder.
 * ISO_E_IO: it is not listed. */
iso_status iso_manifest_add_output(const char *folder, const char *path, iso_error *err);

/* Checks a folder against its list. ISO_E_IO, with the first entry that isoshade did not put there or that has
 * changed, or if there is no list. Missing entries are allowed. shown: the folder's name in the message. */
iso_status iso_manifest_check(const char *folder, const char *shown, iso_error *err);

/* SPDX-License-Identifier: MIT */
/* manifest.h - the list of what isoshade put into a folder, so that nothing else in it is ever removed.
 *
 * The file .isoshade-files in the folder has a line an entry: kind (f: file, d: folder), size in bytes, checksum (XXH3,
 * 64 bits, of files of at most a mebibyte and of those that were added later; else "-"), and the path in the folder;
 * newlines in paths are refused. A file without a checksum counts as changed where its size differs, or the time of its
 * last change is after the list's: so does one that was copied without its time, which is not replaced then. */
#ifndef ISO_MANIFEST_H
#define ISO_MANIFEST_H

#include <stdbool.h>

#include "base/status.h"

#define ISO_MANIFEST_NAME ".isoshade-files"

/* Lists what is in folder, and writes the list into it: all, or what has a name of `own` (iso_output_resume_dir()). */
iso_status iso_manifest_write(const char *folder, const char *const *own, iso_error *err);

/* Adds a file that was put into a folder later, if the folder has a list. Several processes may do so at once. false: it is
 * not listed, and should go. */
bool iso_manifest_add(const char *folder, const char *name);

/* The same for another output of the command that wrote the folder, where its path leads into that. ISO_E_IO: it is not
 * listed. */
iso_status iso_manifest_add_output(const char *folder, const char *path, iso_error *err);

/* ISO_E_IO, with the first entry that isoshade did not put there or that was changed since, or when there is no list.
 * Entries that are gone are no loss. shown: the folder's name in the message. */
iso_status iso_manifest_check(const char *folder, const char *shown, iso_error *err);

#endif

/* SPDX-License-Identifier: MIT */
/* nrrd_files.h - the data files that an NRRD header names, looked at before teem opens them; private to src/volume. */
#ifndef ISO_VOLUME_NRRD_FILES_H
#define ISO_VOLUME_NRRD_FILES_H

#include <stdio.h>

#include "base/status.h"

/* teem prints a name's pattern by sprintf() into a buffer that is 10 bytes longer than it, whatever it holds; it opens pipes,
 * takes "-" for its input, and counts to any number of files; a message of more than 1024 bytes, and a last line without
 * its end, are too much for it; of an empty name it takes the byte behind, of a comment without a character that can be read
 * the byte before. So patterns have one place for a number, of at most two digits' width, files are regular
 * ones, and at most ISO_NRRD_MOST_FILES, and lines are short and whole. *bytes: of all of them together; below 0 where the
 * header names none. ISO_E_FORMAT, ISO_E_IO, ISO_E_MEMORY. */
enum { ISO_NRRD_MOST_FILES = 65536 };
iso_status iso_nrrd_look_at_files(const char *path, double *bytes, iso_error *err);

/* Of samples as text, which teem reads by words into a small buffer: are they short enough in the rest of a file, which
 * stays where it is read, and in the files that a header names? file may be NULL. ISO_E_FORMAT where they are not. */
iso_status iso_nrrd_check_words(const char *path, FILE *file, iso_error *err);

#endif

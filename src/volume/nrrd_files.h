/* SPDX-License-Identifier: MIT */
/* nrrd_files.h - the data files that an NRRD header names, looked at before teem opens them; private to src/volume. */
#pragma once

#include <stdio.h>

#include "base/status.h"

/* Finds the header's files, and refuses those that are unsafe in teem:
 *  - it prints a name's pattern by sprintf() into a buffer 10 bytes longer than the pattern;
 *  - it opens pipes, takes "-" for its input, and counts to any number of files;
 *  - messages of more than 1024 bytes, and a last line without its end, overflow it;
 *  - it reads the byte after an empty name, and the byte before a comment without a readable character.
 * So patterns have one place for a number, of a width of at most two digits. Files are regular ones, at most
 * ISO_NRRD_MOST_FILES. Lines are short and whole. *bytes: the files' total size; below 0 if the header names none.
 * ISO_E_FORMAT, ISO_E_IO, ISO_E_MEMORY. */
enum { ISO_NRRD_MOST_FILES = 65536 };
iso_status iso_nrrd_look_at_files(const char *path, double *bytes, iso_error *err);

/* Checks samples as text, which teem reads by words into a small buffer. The words have to be short enough in the
 * rest of a file, which keeps its position, and in the files of a header. file may be NULL. ISO_E_FORMAT if they are
 * not. */
iso_status iso_nrrd_check_words(const char *path, FILE *file, iso_error *err);

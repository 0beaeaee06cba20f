/* SPDX-License-Identifier: MIT */
/* nrrd_files.h - the files that a NRRD header names for its samples. */
#ifndef ISO_NRRD_FILES_H
#define ISO_NRRD_FILES_H

#include "base/status.h"

/* Looks at them before teem does, which makes all names of a pattern at once and opens whatever they name: ISO_E_RANGE where
 * they are too many, ISO_E_IO where one is there and no regular file, such as a pipe, which would be waited for. */
iso_status iso_nrrd_check_files(const char *path, iso_error *err);

#endif

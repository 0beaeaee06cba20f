/* SPDX-License-Identifier: MIT */
/* unpack.h - files that a general program packed: gzip, bzip2, xz, zstd, lz4 or compress, through libarchive.
 *
 * In:  a file.   Out: an unpacked copy in a private temporary folder, for readers that take plain files. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

#include "base/status.h"

/* True if a file of these first bytes looks packed; samples may begin like that by chance. */
bool iso_looks_packed(const unsigned char *head, size_t size);

/* An unpacked file. Its name is that of the packed one, without the packer's ending. */
typedef struct iso_unpacked {
    char *folder; /* temporary; iso_unpacked_remove() removes it. NULL: nothing is unpacked */
    char *path;
} iso_unpacked;

/* Unpacks a whole file. ISO_E_FORMAT: it is damaged or cut. ISO_E_RANGE: it would fill more than half of the free space
 * of the temporary folder ($TMPDIR), or is packed more than 1,032 times, which no volume is. */
iso_status iso_unpack(const char *path, iso_unpacked *file, iso_error *err);
/* Unpacks one file of a zip archive: the one of that name, or of that name and `ending`; NULL: the only one that ends with
 * it. ISO_E_USAGE lists the names if there are others. */
iso_status iso_unpack_member(const char *path, const char *name, const char *ending, iso_unpacked *file, iso_error *err);
/* Accepts an empty struct. */
void iso_unpacked_remove(iso_unpacked *file);

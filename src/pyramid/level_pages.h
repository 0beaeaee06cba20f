/* SPDX-License-Identifier: MIT */
/* level_pages.h - boxes of a level's samples, read from its files when they are needed.
 *
 * For levels that are larger than memory: nothing is kept. Sizes and headers of the files are checked, their checksums
 * are not, since that would mean to read all of them (`isoshade info NAME.iso --verify` does). Any thread may read. */
#pragma once

#include "pyramid/pyramid.h"

typedef struct iso_level_pages iso_level_pages;

/* Opens a level's files. outline: of the same folder; it stays the caller's. ISO_E_RANGE: no such level; ISO_E_IO,
 * ISO_E_FORMAT, ISO_E_MEMORY. */
iso_status iso_level_pages_open(const char *dir, const iso_pyramid *outline, size_t level, bool with_codes,
                                iso_level_pages **pages, iso_error *err);
void iso_level_pages_close(iso_level_pages *pages); /* accepts NULL */

/* Reads voxels first .. first + count - 1 along each axis, x fastest: scalars as floats, or 3 bytes of code each. */
iso_status iso_level_pages_scalars(const iso_level_pages *pages, const size_t first[3], const size_t count[3],
                                   float *out, iso_error *err);
iso_status iso_level_pages_codes(const iso_level_pages *pages, const size_t first[3], const size_t count[3],
                                 uint8_t *out, iso_error *err);
/* Returns the bytes read so far. */
double iso_level_pages_bytes_read(const iso_level_pages *pages);

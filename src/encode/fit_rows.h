/* SPDX-License-Identifier: MIT */
/* fit_rows.h - the codes "fit" and "snorm" over rows of components, as the build of a
 * pyramid has them: what iso_encode_fit and iso_encode_snorm do to triples. */
#ifndef ISO_ENCODE_FIT_ROWS_H
#define ISO_ENCODE_FIT_ROWS_H

#include <stddef.h>
#include <stdint.h>

/* count directions, |d| <= 1; the bytes of each in the low three of a word. The
 * same bytes on every machine. */
void iso_fit_rows(const float *restrict x, const float *restrict y, const float *restrict z, size_t count,
                  uint32_t *restrict words);
/* Each to round(127 d), as the code "snorm" does. */
void iso_snorm_rows(const float *restrict x, const float *restrict y, const float *restrict z, size_t count,
                    uint32_t *restrict words);
/* iso_fit_rows without the instructions of newer machines. */
void iso_fit_rows_baseline(const float *restrict x, const float *restrict y, const float *restrict z, size_t count,
                           uint32_t *restrict words);

#endif

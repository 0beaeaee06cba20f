/* SPDX-License-Identifier: MIT */
/* fit_rows.h - the codes "fit" and "snorm" over rows of components, for the build of a
 * pyramid; equal to iso_encode_fit and iso_encode_snorm for triples. */
#pragma once

#include <stddef.h>
#include <stdint.h>

/* Encodes count directions, |d| <= 1, into the low three bytes of a word each, the same on every machine. */
void iso_fit_rows(const float *restrict x, const float *restrict y, const float *restrict z, size_t count,
                  uint32_t *restrict words);
/* Rounds each to 127 d, like the code "snorm". */
void iso_snorm_rows(const float *restrict x, const float *restrict y, const float *restrict z, size_t count,
                    uint32_t *restrict words);
/* Does the work of iso_fit_rows() without the instructions of newer machines. */
void iso_fit_rows_baseline(const float *restrict x, const float *restrict y, const float *restrict z, size_t count,
                           uint32_t *restrict words);

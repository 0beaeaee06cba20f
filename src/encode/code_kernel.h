/* SPDX-License-Identifier: MIT */
/* code_kernel.h - the rows of the table of codes, and what they have in common. Private to src/encode. */
#pragma once

#include "encode/code.h"
#include "encode/decode_double.h"

#define ISO_CODE_DECLARE(code, row) extern const iso_code_info iso_code_##row;
ISO_CODE_LIST(ISO_CODE_DECLARE)
#undef ISO_CODE_DECLARE

/* The codes "fit" and "snorm" over rows of components, for the build of a pyramid; equal to iso_encode_fit and
 * iso_encode_snorm for triples. |d| <= 1; the codes fill the low three bytes of a word each, the same on every machine.
 * The baseline uses no instructions of newer machines. */
void iso_fit_rows(const float *restrict x, const float *restrict y, const float *restrict z, size_t count,
                  uint32_t *restrict words);
void iso_fit_rows_baseline(const float *restrict x, const float *restrict y, const float *restrict z, size_t count,
                           uint32_t *restrict words);
void iso_snorm_rows(const float *restrict x, const float *restrict y, const float *restrict z, size_t count,
                    uint32_t *restrict words);

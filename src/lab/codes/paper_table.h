/* SPDX-License-Identifier: MIT */
/* paper_table.h - the encoder of code region48 as in [diaz-garcia-2017] section 4.3:
 * the transform T from a table, then a linear search along the transformed direction.
 * Kept to reproduce the paper's tables 3 and 4; the code's own encoder
 * (encode_region48.c) needs no table and finds the same codes. */
#pragma once

#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

/* T at the barycentric points (i, j, size-1-i-j) / (size-1): the diagonal plane of
 * a cube of size^3 entries, as in the paper's Figure 13. */
typedef struct iso_paper_table {
    size_t size;
    double (*entries)[3]; /* size * size; row i, column j; those with i + j >= size stay unused */
} iso_paper_table;

/* Creates the table; size: 2 to 1024. ISO_E_RANGE, ISO_E_MEMORY. */
iso_status iso_paper_table_create(size_t size, iso_paper_table *table, iso_error *err);
void iso_paper_table_destroy(iso_paper_table *table);

void iso_paper_encode(const iso_paper_table *table, const float *restrict directions, uint8_t *restrict bytes,
                      size_t count);

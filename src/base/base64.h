/* SPDX-License-Identifier: MIT */
/* base64.h - bytes as text, for pages that carry their data. */
#pragma once

#include <stddef.h>
#include <stdio.h>

/* Writes the bytes with their padding; errors are the stream's (ferror). */
void iso_base64_put(FILE *f, const unsigned char *bytes, size_t size);

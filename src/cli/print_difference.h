/* SPDX-License-Identifier: MIT */
/* print_difference.h - what changed between two reports, as text for people: facts, rows, pictures, and the sentence. */
#ifndef ISO_CLI_PRINT_DIFFERENCE_H
#define ISO_CLI_PRINT_DIFFERENCE_H

#include <jansson.h>

/* Prints a difference that is concluded (report/difference.h). */
void iso_print_difference(const json_t *difference);

#endif

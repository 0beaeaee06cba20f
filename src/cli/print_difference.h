/* SPDX-License-Identifier: MIT */
/* print_difference.h - prints the difference of two reports as text: facts, rows, pictures and a summary. */
#pragma once

#include <jansson.h>

/* Prints a concluded difference (report/difference.h). */
void iso_print_difference(const json_t *difference);

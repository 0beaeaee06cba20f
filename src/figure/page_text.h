/* SPDX-License-Identifier: MIT */
/* page_text.h - widths of texts, and texts in gnuplot's and LaTeX's syntax. */
#pragma once

#include <stddef.h>
#include <stdio.h>

/* Returns the width of `bytes` bytes of UTF-8 in DejaVu Sans, rather too wide; most papers have narrower fonts. */
double iso_page_text_width_mm(const char *text, size_t bytes, double pt);
/* Writes a number for readers, with a minus sign, and with powers of ten from 10^5 on and below a thousandth. It has
 * the digits that tell it from numbers `apart` from it: 1, 2 or 5 times a power of ten. */
void iso_page_number(double value, double apart, char text[64]);
/* Writes a power of ten. */
void iso_page_power_of_ten(int exponent, char text[24]);
/* Writes "say(note_pt, 'plain', 'for LaTeX')", an expression of page.gp. role_pt: "note_pt". */
void iso_page_text_put(FILE *gp, const char *role_pt, const char *text);

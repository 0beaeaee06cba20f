/* SPDX-License-Identifier: MIT */
/* page_text.h - how wide texts are, and how they are written for gnuplot and for LaTeX. */
#ifndef ISO_FIGURE_PAGE_TEXT_H
#define ISO_FIGURE_PAGE_TEXT_H

#include <stddef.h>
#include <stdio.h>

/* Of so many bytes of UTF-8 in DejaVu Sans, rather too wide; the fonts of most papers are narrower. */
double iso_page_text_width_mm(const char *text, size_t bytes, double pt);
/* "say(note_pt, 'plain', 'for LaTeX')", an expression of page.gp. role_pt: "note_pt". */
void iso_page_text_put(FILE *gp, const char *role_pt, const char *text);

#endif

/* SPDX-License-Identifier: MIT */
/* markup.h - texts in HTML, SVG and XML, between tags or within an attribute's quotes of either kind. */
#ifndef ISO_MARKUP_H
#define ISO_MARKUP_H

#include <jansson.h>
#include <stdio.h>

/* Writes the text with & < > " ' as entities. Control characters that XML lacks, all but line feeds and tabs, become
 * spaces. NULL writes nothing. */
void iso_markup_put(FILE *f, const char *text);

/* Writes JSON inside <script>: "<" becomes an escape, so that no text ends the element. Numbers are those of files. */
void iso_markup_put_json(FILE *f, const json_t *value);

#endif

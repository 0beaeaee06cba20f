/* SPDX-License-Identifier: MIT */
/* markup.h - texts in HTML, SVG and XML, between tags or within an attribute's quotes of either kind. */
#ifndef ISO_MARKUP_H
#define ISO_MARKUP_H

#include <jansson.h>
#include <stdio.h>

/* The text with & < > " ' as entities, and spaces for control characters other than line feeds and tabs, which XML has
 * not. NULL writes nothing. */
void iso_markup_put(FILE *f, const char *text);

/* Writes JSON inside <script>: "<" becomes an escape, so that no text ends the element. Numbers are those of files. */
void iso_markup_put_json(FILE *f, const json_t *value);

#endif

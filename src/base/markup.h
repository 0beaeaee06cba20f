/* SPDX-License-Identifier: MIT */
/* markup.h - writes texts to HTML, SVG and XML, between tags or within quotes of an attribute. */
#pragma once

#include <jansson.h>
#include <stdio.h>

/* Writes a text with & < > " ' as entities. Control characters other than line feeds and tabs, which XML forbids,
 * become spaces. NULL writes nothing. */
void iso_markup_put(FILE *f, const char *text);

/* Writes JSON inside <script>: "<" becomes an escape, so that no text ends the element. Numbers are those of
 * iso_json_text(). */
void iso_markup_put_json(FILE *f, const json_t *value);

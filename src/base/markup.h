/* SPDX-License-Identifier: MIT */
/* markup.h - writes texts to HTML, SVG and XML, between tags or within quotes of an attribute. */
#pragma once

#include <jansson.h>
#include <stdio.h>

/* Writes a text with & < > " ' as entities. Control characters other than line feeds and tabs, which XML forbids,
 * become spaces. NULL writes nothing. */
void iso_markup_put(FILE *f, const char *text);

/* Writes a form, and a text by `put` in place of each "%": iso_markup_fill(f, iso_markup_put, "<b>%</b>", name) */
void iso_markup_fill(FILE *f, void (*put)(FILE *f, const char *text), const char *form, ...);

/* Writes a template, which has no other @ than those of its marks @NAME@, and `put` in place of each mark. */
typedef void (*iso_markup_putter)(FILE *f, const char *name, const void *user);
void iso_markup_fill_marks(FILE *f, const char *form, iso_markup_putter put, const void *user);

/* Writes JSON inside <script>: "<" becomes an escape, so that no text ends the element. Numbers are those of
 * iso_json_text(). */
void iso_markup_put_json(FILE *f, const json_t *value);

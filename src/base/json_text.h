/* SPDX-License-Identifier: MIT */
/* json_text.h - the text of a JSON value, with numbers of as few digits as come back: files and pages have the same ones. */
#ifndef ISO_JSON_TEXT_H
#define ISO_JSON_TEXT_H

#include <jansson.h>

/* Returns the text, to be freed; NULL: out of memory. flags: of json_dumps(), JSON_INDENT() or JSON_COMPACT. */
char *iso_json_text(const json_t *root, size_t flags);

#endif

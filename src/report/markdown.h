/* SPDX-License-Identifier: MIT */
/* markdown.h - a summary of a report, and of what changed between two, for the page on which continuous integration shows
 * its runs: GitHub's flavor of Markdown. Names of scenes and renderers stand as they are, whatever is in them. */
#ifndef ISO_REPORT_MARKDOWN_H
#define ISO_REPORT_MARKDOWN_H

#include <stdio.h>

#include "base/json.h"

/* Of a finished report.json: sentences, rows that failed, refused renderers with the reason, versions. link: to the page,
 * or NULL. Written whole or not at all. */
iso_status iso_markdown_of_report(const char *path, const json_t *root, const char *link, iso_error *err);

/* Of a concluded difference (difference.h). */
iso_status iso_markdown_of_difference(const char *path, const json_t *difference, const char *link, iso_error *err);

/* What a link says of a folder: a relative path as it was given, else what may be told of it (base/provenance.h). */
const char *iso_markdown_target(const char *dir);

/* Text that Markdown and HTML leave as it is, also in a cell of a table. */
void iso_markdown_put_text(FILE *f, const char *text);

#endif

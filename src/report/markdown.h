/* SPDX-License-Identifier: MIT */
/* markdown.h - summary of a report, or of the difference of two, in GitHub's flavor of Markdown, for the pages of
 * continuous integration. Names of scenes and renderers are escaped. */
#pragma once

#include <stdio.h>

#include "base/json.h"

/* Writes the summary of a finished report.json: sentences, failed rows, refused renderers with the reason, versions.
 * link: to the page, or NULL. The file is written as a whole or not at all. */
iso_status iso_markdown_of_report(const char *path, const json_t *root, const char *link, iso_error *err);

/* Writes the summary of a concluded difference (difference.h). */
iso_status iso_markdown_of_difference(const char *path, const json_t *difference, const char *link, iso_error *err);

/* Returns the target of a link to a folder: a relative path unchanged, of others the part that may be shown
 * (base/provenance.h). */
const char *iso_markdown_target(const char *dir);

/* Writes a text that Markdown and HTML do not interpret, not even in a table. */
void iso_markdown_put_text(FILE *f, const char *text);

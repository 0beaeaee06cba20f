/* SPDX-License-Identifier: MIT */
/* sections.h - the lists of rows in report.json: one table for all code that reads reports.
 *
 * A consumer makes its own table from ISO_SECTION_LIST, with a handler per section whose name is pasted from the
 * section's: compare_levels, put_case_levels. A new section does not compile in a consumer without a handler for it
 * (tests/check_sections.sh adds one). A consumer that skips a section on purpose defines its handler as NULL. */
#pragma once

#include <stdbool.h>

#include "base/json.h"
#include "report/rows.h"

#ifndef ISO_SECTION_MORE
#define ISO_SECTION_MORE(X) /* for a test */
#endif

#define ISO_IS(verdict) (1u << ISO_VERDICT_##verdict)
/* Name in report.json, and the verdicts that its rows may have; 0: rows without a verdict. */
/* clang-format off */
#define ISO_SECTION_LIST(X)                                                                              \
    X(calibration, ISO_IS(PASS) | ISO_IS(FAIL) | ISO_IS(NOT_COMPARED))                                   \
    X(agreement, ISO_IS(AGREE) | ISO_IS(DIFFER) | ISO_IS(REFUSED) | ISO_IS(NOT_COMPARED))                       \
    X(levels, ISO_IS(AGREE) | ISO_IS(DIFFER) | ISO_IS(NOT_COMPARED))                                     \
    X(consistency, 0)                                                                                    \
    ISO_SECTION_MORE(X)
/* clang-format on */

#define ISO_REPORT_SCHEMA "isoshade.validate/1"

/* True if no row of any section differs, failed or was refused. */
bool iso_sections_hold(const json_t *report);

/* Loads a report.json, or the one in a folder. ISO_E_FORMAT: another schema, an unknown list with verdicts, a
 * verdict that its section does not have. path: in messages. */
iso_status iso_report_load(const char *path, json_t **report, iso_error *err);
iso_status iso_report_check(const json_t *report, const char *path, iso_error *err);

/* A loaded report and its folder. Release with iso_report_source_close() in every case. */
typedef struct iso_report_source {
    const char *path; /* path that the user gave, borrowed */
    char *dir;        /* folder of the pictures; or NULL */
    json_t *root;     /* report.json */
} iso_report_source;
iso_status iso_report_source_open(iso_report_source *source, const char *path, iso_error *err);
void iso_report_source_close(iso_report_source *source);

/* False if only its report.json was kept. */
bool iso_report_source_has_pictures(const iso_report_source *source);
/* Returns the path of a picture of the report, to be freed; NULL: out of memory. suffix: "exr" or "png". */
char *iso_report_source_picture(const iso_report_source *source, const char *name, const char *suffix);
/* True if a picture's name is a plain word. Reports of others may contain paths here. */
bool iso_report_is_picture_name(const char *name);

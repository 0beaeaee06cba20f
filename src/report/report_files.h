/* SPDX-License-Identifier: MIT */
/* report_files.h - the files of a report: pictures, charts, the page. Private to the report. */
#pragma once

#include "base/json.h"
#include "image/image.h"
#include "report/rows.h"

/* Creates images/ and charts/. */
iso_status iso_report_files_begin(const char *dir, iso_error *err);

/* Writes NAME.exr and NAME.png; *uri is the PNG as a data URI, to be freed. */
iso_status iso_report_files_image(const char *dir, const char *name, const iso_image *image,
                                  char **uri, iso_error *err);

/* Encodes the difference of two images of the report as a picture (page.h), to be freed. */
iso_status iso_report_files_difference(const char *dir, const char *a, const char *b, char **uri, iso_error *err);

/* Writes .csv, .gp and .svg into charts/, and adds name: data URI to inlined. ISO_E_MISSING: no gnuplot. */
iso_status iso_report_files_charts(const char *dir, const json_t *root, json_t *inlined, iso_error *err);

/* Writes report.json and index.html. */
iso_status iso_report_files_page(const char *dir, const json_t *root, const json_t *inlined, iso_error *err);

/* SPDX-License-Identifier: MIT */
/* page.h - self-contained pages of reports and charts, made of a template, scripts and data, with pictures as text. */
#pragma once

#include <stdio.h>

#include "base/json.h"
#include "image/image.h"

enum { ISO_PAGE_MOST_SCRIPTS = 8 };
typedef struct iso_page {
    const char *kind; /* end of the window's title */
    const char *html; /* after a first line of comment: the body, with the marks @TITLE@ and @SENTENCE@ */
    const char *scripts[ISO_PAGE_MOST_SCRIPTS + 1]; /* one after the other; ends with NULL */
    const char *style;                              /* after the report's; or NULL */
} iso_page;
extern const iso_page iso_page_of_report, iso_page_of_difference, iso_page_of_certificates;
extern const char iso_report_js[]; /* base of the scripts of all pages */

/* Writes the page. data has "title" and "sentence"; its texts are escaped. */
iso_status iso_page_write(const char *path, const iso_page *page, const json_t *data, const json_t *inlined,
                          iso_error *err);

/* Reads a file as a data URI, to be freed. type: "image/png". */
iso_status iso_page_file_uri(const char *path, const char *type, char **uri, iso_error *err);
/* Encodes bytes of sRGB as a data URI of a PNG, to be freed; NULL: no memory. */
char *iso_page_png_uri(const unsigned char *rgb, size_t width, size_t height);

/* Encodes the largest channel difference of each pixel of two images of one size: 16 bits on a log scale in a PNG's
 * red and green. code = 1 + 65533 log10(d / 1e-9) / 11, 0 for no difference, 65535 for non-finite. Coarse: a multiple
 * of 256, a tenth of the difference, in a third of the bytes. */
typedef enum iso_page_precision { ISO_PAGE_FINE, ISO_PAGE_COARSE } iso_page_precision;
iso_status iso_page_difference_uri(const iso_image *a, const iso_image *b, iso_page_precision precision, char **uri,
                                   iso_error *err);

/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "report/page.h"

#include <math.h>
#include <png.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/base64.h"
#include "base/embed.h"
#include "base/file.h"
#include "base/markup.h"
#include "report/rows.h"

ISO_EMBED(iso_page_html, "src/report/page.html");
ISO_EMBED(iso_report_html, "src/report/report.html");
ISO_EMBED(iso_difference_html, "src/report/difference.html");
ISO_EMBED(iso_report_css, "src/report/report.css");
ISO_EMBED(iso_report_js, "src/report/report.js"); /* declared in page.h too */
ISO_EMBED(iso_report_difference_js, "src/report/report_difference.js");
ISO_EMBED(iso_report_tables_js, "src/report/report_tables.js");
ISO_EMBED(iso_report_inspector_js, "src/report/report_inspector.js");
ISO_EMBED(iso_report_levels_js, "src/report/report_levels.js");
ISO_EMBED(iso_report_page_js, "src/report/report_page.js");
ISO_EMBED(iso_difference_page_js, "src/report/difference_page.js");
ISO_EMBED(iso_certificate_html, "src/report/certificate.html");
ISO_EMBED(iso_certificate_css, "src/report/certificate.css");
ISO_EMBED(iso_certificate_page_js, "src/report/certificate_page.js");

/* The scripts of a page form one script, and depend on the ones before. */
const iso_page iso_page_of_report = {"isoshade validation",
                                     iso_report_html,
                                     {iso_report_js, iso_report_difference_js, iso_report_tables_js,
                                      iso_report_inspector_js, iso_report_levels_js, iso_report_page_js},
                                     NULL};
const iso_page iso_page_of_difference = {"isoshade report diff",
                                         iso_difference_html,
                                         {iso_report_js, iso_report_difference_js, iso_report_inspector_js,
                                          iso_difference_page_js},
                                         NULL};
const iso_page iso_page_of_certificates = {"isoshade",
                                           iso_certificate_html,
                                           {iso_report_js, iso_report_difference_js, iso_report_tables_js,
                                            iso_report_inspector_js, iso_certificate_page_js},
                                           iso_certificate_css};

/* ---- pictures as text ---- */

static char *data_uri(const char *type, const unsigned char *bytes, size_t size)
{
    char *text = NULL;
    size_t length = 0;
    FILE *f = open_memstream(&text, &length);
    if (!f)
        return NULL;
    fprintf(f, "data:%s;base64,", type);
    iso_base64_put(f, bytes, size);
    if (fclose(f) == 0)
        return text;
    free(text);
    return NULL;
}

iso_status iso_page_file_uri(const char *path, const char *type, char **uri, iso_error *err)
{
    FREED char *bytes = NULL;
    size_t size;
    NEED(iso_file_read(path, &bytes, &size, err));
    *uri = data_uri(type, (unsigned char *)bytes, size);
    return *uri ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "%s: no memory", path);
}

char *iso_page_png_uri(const unsigned char *rgb, size_t width, size_t height)
{
    png_image info = {.version = PNG_IMAGE_VERSION, .format = PNG_FORMAT_RGB};
    info.width = (png_uint_32)width;
    info.height = (png_uint_32)height;
    png_alloc_size_t size = 0;
    FREED unsigned char *png = NULL;
    char *uri = NULL;
    if (png_image_write_to_memory(&info, NULL, &size, 0, rgb, 0, NULL))
        png = malloc(size);
    if (png && png_image_write_to_memory(&info, png, &size, 0, rgb, 0, NULL))
        uri = data_uri("image/png", png, size);
    png_image_free(&info);
    return uri;
}

static unsigned difference_code(const float *a, const float *b)
{
    double d = 0;
    for (int c = 0; c < 4; ++c) {
        if (!isfinite(a[c]) || !isfinite(b[c]))
            return 65535;
        d = fmax(d, fabs((double)a[c] - (double)b[c]));
    }
    if (d == 0)
        return 0;
    double code = round(1 + 65533 * log10(d / 1e-9) / 11);
    return (unsigned)fmin(fmax(code, 1), 65534);
}

iso_status iso_page_difference_uri(const iso_image *a, const iso_image *b, iso_page_precision precision, char **uri,
                                   iso_error *err)
{
    size_t count = a->width * a->height;
    FREED unsigned char *rgb = calloc(count, 3);
    for (size_t i = 0; rgb && i < count; ++i) {
        unsigned code = difference_code(a->rgba + 4 * i, b->rgba + 4 * i);
        if (precision == ISO_PAGE_COARSE && code > 0 && code < 65535)
            code = code < 512 ? 256 : code & ~255u;
        rgb[3 * i] = (unsigned char)(code >> 8);
        rgb[3 * i + 1] = (unsigned char)(code & 255);
    }
    *uri = rgb ? iso_page_png_uri(rgb, a->width, a->height) : NULL;
    return *uri ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "report: no memory for a picture of %zu pixels", count);
}

/* ---- the page ---- */

/* The parts of a page. */
typedef struct parts {
    const iso_page *page;
    const json_t *data, *inlined;
} parts;

static void put_mark(FILE *f, const char *mark, const void *user)
{
    const parts *p = user;
    if (strcmp(mark, "STYLE") == 0) {
        fputs(iso_report_css, f);
        fputs(p->page->style ? p->page->style : "", f);
    } else if (strcmp(mark, "SCRIPT") == 0)
        for (size_t i = 0; p->page->scripts[i]; ++i)
            fputs(p->page->scripts[i], f);
    else if (strcmp(mark, "DATA") == 0)
        iso_markup_put_json(f, p->data);
    else if (strcmp(mark, "INLINED") == 0)
        iso_markup_put_json(f, p->inlined);
    else if (strcmp(mark, "SENTENCE") == 0)
        iso_markup_put(f, iso_row_text(p->data, "sentence"));
    else if (strcmp(mark, "TITLE") == 0)
        iso_markup_put(f, iso_row_text(p->data, "title"));
    else if (strcmp(mark, "KIND") == 0)
        fputs(p->page->kind, f);
    else if (strcmp(mark, "BODY") == 0)
        iso_markup_fill_marks(f, strchr(p->page->html, '\n') + 1, put_mark, p);
}

iso_status iso_page_write(const char *path, const iso_page *page, const json_t *data, const json_t *inlined,
                          iso_error *err)
{
    FREED char *html = NULL;
    size_t size = 0;
    FILE *f = open_memstream(&html, &size);
    if (f)
        iso_markup_fill_marks(f, iso_page_html, put_mark, &(parts){page, data, inlined});
    return f && fclose(f) == 0 ? iso_file_write(path, html, size, err)
                               : iso_fail(err, ISO_E_MEMORY, "%s: no memory", path);
}

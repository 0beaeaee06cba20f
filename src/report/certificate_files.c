/* SPDX-License-Identifier: MIT */
/* certificate_files.c - writes the page of certificates and the badges. */
#define _GNU_SOURCE
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/file.h"
#include "base/markup.h"
#include "report/certificate.h"
#include "report/page.h"

/* ---- pictures ---- */

/* Finds the report of a picture "2/NAME", and its name. NULL: no such picture. */
static const iso_report_source *find_picture(const iso_report_source *reports, const json_t *certificate,
                                             const char *key, const char **name)
{
    const char *text = iso_row_text(certificate, key), *slash = strchr(text, '/');
    if (!slash)
        return NULL;
    *name = slash + 1;
    return &reports[strtoul(text, NULL, 10)];
}

static iso_status inline_picture(const iso_report_source *of, const char *name, const char *key, iso_image *image,
                                 json_t *inlined, iso_error *err)
{
    FREED char *exr = iso_report_source_picture(of, name, "exr"), *png = iso_report_source_picture(of, name, "png"),
               *uri = NULL;
    NEED_MEMORY(exr && png, err, "certificate: out of memory");
    if (!iso_report_is_picture_name(name))
        return iso_fail(err, ISO_E_FORMAT, "%s: invalid name of a picture; the report is damaged", of->path);
    NEED(iso_image_load_exr(exr, image, err));
    if (!json_object_get(inlined, key)) {
        NEED(iso_page_file_uri(png, "image/png", &uri, err));
        json_object_set_new(inlined, key, json_string(uri));
    }
    return ISO_OK;
}

/* Adds both pictures of a certificate and their difference, and those of its mistake. Without its folder of pictures a
 * report has none. */
static iso_status inline_certificate(const iso_report_source *reports, const json_t *certificate, json_t *inlined,
                                     iso_error *err)
{
    static const char *const keys[] = {"image_a", "image_b", "mistake_wanted", "mistake_got"};
    OWNED(iso_image) a = {0}, b = {0}, wanted = {0}, got = {0};
    iso_image *const images[] = {&a, &b, &wanted, &got};
    FREED char *uri = NULL;
    char number[32];
    int found = 0;
    for (int i = 0; i < 4; ++i) {
        const char *name = NULL;
        const iso_report_source *of = find_picture(reports, certificate, keys[i], &name);
        if (!of || !iso_report_source_has_pictures(of))
            continue;
        found += i < 2;
        NEED(inline_picture(of, name, iso_row_text(certificate, keys[i]), images[i], json_object_get(inlined, "images"),
                            err));
    }
    if (found != 2)
        return ISO_OK;
    if (a.width != b.width || a.height != b.height)
        return iso_fail(err, ISO_E_FORMAT, "%s and %s have pictures of other sizes; the report is damaged",
                        iso_row_text(certificate, keys[0]), iso_row_text(certificate, keys[1]));
    NEED(iso_page_difference_uri(&a, &b, ISO_PAGE_COARSE, &uri, err));
    snprintf(number, sizeof number, "%lld", json_integer_value(json_object_get(certificate, "number")));
    json_object_set_new(json_object_get(inlined, "differences"), number, json_string(uri));
    return ISO_OK;
}

/* ---- badges ---- */

/* Writes a badge of two fields. Texts get their widths by textLength, so that they fit in all fonts. */
static void put_badge(FILE *f, const json_t *renderer)
{
    enum { LETTER_TENTHS = 64, PAD = 12, LEFT = 8 * LETTER_TENTHS / 10 + PAD }; /* "isoshade" */
    const char *words = iso_row_text(renderer, "words");
    const iso_verdict verdict = iso_row_verdict(renderer);
    const bool away = strcmp(words, "not available") == 0;
    const char *color = verdict == ISO_VERDICT_AGREE                  ? "#15714b"
                        : verdict == ISO_VERDICT_NOT_COMPARED || away ? "#5b626d"
                                                                      : "#b93a08";
    const int text = LETTER_TENTHS * (int)strlen(words) / 10, right = text + PAD;
    fprintf(f, "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%d\" height=\"20\" role=\"img\"", LEFT + right);
    iso_markup_fill(f, iso_markup_put, " aria-label=\"isoshade: %\">\n<title>%, %", words,
                    iso_row_text(renderer, "title"), iso_row_text(renderer, "version"));
    fprintf(f, ": %lld of %lld scenes agree, ", json_integer_value(json_object_get(renderer, "agreed")),
            json_integer_value(json_object_get(renderer, "scenes")));
    iso_markup_put(f, iso_row_text(renderer, "made"));
    fprintf(f, "</title>\n<clipPath id=\"c\"><rect width=\"%d\" height=\"20\" rx=\"3\"/></clipPath>\n", LEFT + right);
    fprintf(f, "<g clip-path=\"url(#c)\"><path fill=\"#3d4148\" d=\"M0 0h%dv20H0z\"/>", LEFT);
    fprintf(f, "<path fill=\"%s\" d=\"M%d 0h%dv20h-%dz\"/></g>\n", color, LEFT, right, right);
    fputs("<g fill=\"#fff\" font-family=\"Verdana, DejaVu Sans, sans-serif\" font-size=\"11\">", f);
    fprintf(f, "<text x=\"%d\" y=\"14\" textLength=\"%d\">isoshade</text>", PAD / 2, LEFT - PAD);
    fprintf(f, "<text x=\"%d\" y=\"14\" textLength=\"%d\">", LEFT + PAD / 2, text);
    iso_markup_fill(f, iso_markup_put, "%</text></g>\n</svg>\n", words);
}

/* Writes a badge, and adds it to the page. */
static iso_status write_badge(const char *dir, const json_t *renderer, json_t *inlined, iso_error *err)
{
    FREED char *svg = NULL, *uri = NULL, *path = iso_path_join(dir, iso_row_text(renderer, "badge"));
    size_t size = 0;
    FILE *f = open_memstream(&svg, &size);
    if (f)
        put_badge(f, renderer);
    if (!path || !f || iso_memory_close(f) != 0)
        return iso_fail(err, ISO_E_MEMORY, "certificate: out of memory");
    NEED(iso_file_write(path, svg, size, err));
    NEED(iso_page_file_uri(path, "image/svg+xml", &uri, err));
    json_object_set_new(json_object_get(inlined, "images"), iso_row_text(renderer, "badge"), json_string(uri));
    return ISO_OK;
}

static iso_status write_badges(const char *dir, const json_t *renderers, json_t *inlined, iso_error *err)
{
    FREED char *folder = iso_path_join(dir, "badges");
    json_t *one;
    size_t i;
    NEED_MEMORY(folder, err, "certificate: out of memory");
    if (mkdir(folder, 0777) != 0)
        return iso_fail(err, iso_errno_status(), "%s: cannot be created: %s", folder, strerror(errno));
    json_array_foreach (renderers, i, one) {
        NEED(write_badge(dir, one, inlined, err));
    }
    return ISO_OK;
}

/* ---- the site ---- */

static iso_status write_site(const char *dir, const json_t *site, json_t *inlined, iso_error *err)
{
    FREED char *data = iso_path_join(dir, "certificates.json"), *page = iso_path_join(dir, "index.html");
    NEED_MEMORY(data && page, err, "certificate: out of memory");
    NEED(write_badges(dir, json_object_get(site, "renderers"), inlined, err));
    NEED(iso_json_save(data, site, err));
    return iso_page_write(page, &iso_page_of_certificates, site, inlined, err);
}

iso_status iso_certificates_write(const char *dir, const json_t *site, const iso_report_source *reports, iso_error *err)
{
    ENDED_BY(iso_output_abandon) iso_output out = {0};
    json_auto_t *inlined = json_pack("{s:{}, s:{}}", "images", "differences");
    json_t *one;
    size_t i;
    NEED(iso_output_begin_dir(&out, dir, "certificates.json", err));
    json_array_foreach (json_object_get(site, "certificates"), i, one) {
        NEED(inline_certificate(reports, one, inlined, err));
    }
    NEED(write_site(out.temp_path, site, inlined, err));
    return iso_output_commit(&out, err);
}

/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "report/report_files.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/embed.h"
#include "base/file.h"
#include "report/gnuplot.h"
#include "report/page.h"
#include "report/report.h"

ISO_EMBED(iso_report_agreement_gp, "src/report/agreement.gp");
ISO_EMBED(iso_report_consistency_gp, "src/report/consistency.gp");

iso_status iso_report_files_begin(const char *dir, iso_error *err)
{
    const char *const names[] = {"images", "charts"};
    for (int i = 0; i < 2; ++i) {
        FREED char *path = iso_path_join(dir, names[i]);
        bool good = path && mkdir(path, 0777) == 0;
        if (!good)
            return iso_fail(err, iso_errno_status(), "%s/%s: cannot be created: %s", dir, names[i], strerror(errno));
    }
    return ISO_OK;
}

iso_status iso_report_files_image(const char *dir, const char *name, const iso_image *image,
                                  char **uri, iso_error *err)
{
    FREED char *exr = NULL, *png = NULL;
    if (asprintf(&exr, "%s/images/%s.exr", dir, name) < 0 || asprintf(&png, "%s/images/%s.png", dir, name) < 0)
        return iso_fail(err, ISO_E_MEMORY, "report: out of memory");
    NEED(iso_image_save_exr(image, exr, NULL, err));
    NEED(iso_image_save_png(image, png, 1, err));
    return iso_page_file_uri(png, "image/png", uri, err);
}

iso_status iso_report_files_difference(const char *dir, const char *a, const char *b, char **uri, iso_error *err)
{
    OWNED(iso_image) image_a = {0}, image_b = {0};
    FREED char *path_a = NULL, *path_b = NULL;
    if (asprintf(&path_a, "%s/images/%s.exr", dir, a) < 0 || asprintf(&path_b, "%s/images/%s.exr", dir, b) < 0)
        return iso_fail(err, ISO_E_MEMORY, "report: out of memory");
    NEED(iso_image_load_exr(path_a, &image_a, err));
    NEED(iso_image_load_exr(path_b, &image_b, err));
    if (image_a.width != image_b.width || image_a.height != image_b.height)
        return iso_fail(err, ISO_E_RANGE, "report: the images %s and %s have %zux%zu and %zux%zu pixels", a, b,
                        image_a.width, image_a.height, image_b.width, image_b.height);
    return iso_page_difference_uri(&image_a, &image_b, ISO_PAGE_FINE, uri, err);
}

/* Writes a CSV field: comma becomes semicolon, quote apostrophe, since gnuplot's strcol() reads no quoted commas. */
static void put_field(FILE *f, const char *s)
{
    for (; *s; ++s)
        fputc(*s == ',' ? ';' : *s == '"' ? '\'' : *s, f);
}

static void put_agreement_csv(FILE *f, const json_t *rows)
{
    size_t i;
    json_t *row;
    fputs("case,rmse,rmse_limit,max_abs,max_abs_limit,error_bar,verdict\n", f);
    json_array_foreach (rows, i, row) {
        const json_t *limits = json_object_get(row, "limits");
        char label[400], name[ISO_ROW_NAME_BYTES];
        iso_row_name_of(row, name);
        snprintf(label, sizeof label, "%s, level %lld: %s – %s", iso_row_text(row, "scene"), iso_row_level(row),
                 iso_row_text(row, "a"), name);
        put_field(f, label);
        fprintf(f, ",%.9g,%.9g,%.9g,%.9g,%.9g,%s\n", iso_row_number(row, "rmse"), iso_row_number(limits, "rmse"),
                iso_row_number(row, "max_abs"), iso_row_number(limits, "max_abs"), iso_row_number(row, "error_bar"),
                iso_row_text(row, "verdict"));
    }
}

static void put_consistency_line(FILE *f, const json_t *row)
{
    const bool adapted = strcmp(iso_row_text(row, "tf"), "adapted") == 0;
    put_field(f, iso_row_text(row, "method"));
    fprintf(f, ",%lld,%lld,%.9g,%.9g,%.9g,%.9g,%s,%d,%.9g\n", iso_row_level(row),
            (long long)json_integer_value(json_object_get(row, "views")),
            iso_row_number(row, "ssim_dissimilarity_mean"), iso_row_number(row, "flip_mean"),
            iso_row_number(row, "gradient_angle_mean_deg"), iso_row_number(row, "gradient_angle_p95_deg"),
            adapted ? "adapted" : "original", iso_row_text(row, "original_kept")[0] != 0,
            iso_row_number(row, "rmse_mean"));
}

/* Writes one block per method and TF, two blank lines apart, for gnuplot's "index"; levels ascend. */
static void put_consistency_csv(FILE *f, const json_t *rows)
{
    json_t *seen = json_object(), *row, *other;
    size_t i, j;
    char name[ISO_CONSISTENCY_NAME_BYTES], other_name[ISO_CONSISTENCY_NAME_BYTES];
    fputs(
        "method,level,views,ssim_dissimilarity_mean,flip_mean,gradient_angle_mean_deg,gradient_angle_p95_deg,tf,original_kept,rmse_mean\n",
        f);
    json_array_foreach (rows, i, row) {
        iso_report_consistency_name(row, name);
        if (json_object_get(seen, name))
            continue;
        if (json_object_size(seen) > 0)
            fputs("\n\n", f);
        json_object_set_new(seen, name, json_true());
        json_array_foreach (rows, j, other) {
            iso_report_consistency_name(other, other_name);
            if (strcmp(name, other_name) == 0)
                put_consistency_line(f, other);
        }
    }
    json_decref(seen);
}

typedef struct chart_kind {
    const char *name, *rows, *script;
    void (*put_csv)(FILE *f, const json_t *rows);
} chart_kind;

static iso_status make_chart(const char *charts, const chart_kind *kind, const json_t *rows, json_t *inlined,
                             iso_error *err)
{
    FREED char *csv = NULL, *svg = NULL, *uri = NULL;
    size_t size = 0;
    FILE *f = open_memstream(&csv, &size);
    NEED_MEMORY(f, err, "report: out of memory");
    kind->put_csv(f, rows);
    fclose(f);
    NEED(iso_gnuplot_draw(charts, kind->name, csv, kind->script, "svg", err));
    if (asprintf(&svg, "%s/%s.svg", charts, kind->name) < 0)
        return iso_fail(err, ISO_E_MEMORY, "report: out of memory");
    NEED(iso_page_file_uri(svg, "image/svg+xml", &uri, err));
    json_object_set_new(inlined, kind->name, json_string(uri));
    return ISO_OK;
}

iso_status iso_report_files_charts(const char *dir, const json_t *root, json_t *inlined, iso_error *err)
{
    const chart_kind kinds[] = {
        {"agreement", "agreement", iso_report_agreement_gp, put_agreement_csv},
        {"consistency", "consistency", iso_report_consistency_gp, put_consistency_csv},
    };
    FREED char *charts = iso_path_join(dir, "charts");
    NEED_MEMORY(charts, err, "report: out of memory");
    for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; ++i) {
        const json_t *rows = json_object_get(root, kinds[i].rows);
        if (json_array_size(rows) > 0)
            NEED(make_chart(charts, &kinds[i], rows, inlined, err));
    }
    return ISO_OK;
}

iso_status iso_report_files_page(const char *dir, const json_t *root, const json_t *inlined, iso_error *err)
{
    FREED char *data = iso_path_join(dir, "report.json"), *page = iso_path_join(dir, "index.html");
    NEED_MEMORY(data && page, err, "report: out of memory");
    NEED(iso_json_save(data, root, err));
    return iso_page_write(page, &iso_page_of_report, root, inlined, err);
}

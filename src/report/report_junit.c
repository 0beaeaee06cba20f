/* SPDX-License-Identifier: MIT */
/* report_junit.c - the rows as JUnit's XML, in a form that the schemas of both Apache Ant and Jenkins accept: the
 * root has no totals, which a reader adds up. Everything that gives `isoshade validate` another exit code than 0 is
 * a failure or an error here. */
#define _GNU_SOURCE
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/markup.h"
#include "report/report.h"
#include "report/report_files.h"
#include "report/sections.h"

#define FILL(f, ...) iso_markup_fill(f, iso_markup_put, __VA_ARGS__)

static bool has_verdict(const json_t *row, iso_verdict verdict)
{
    return iso_row_verdict(row) == verdict;
}

/* Writes name="..." and time="..."; the element stays open. */
static void put_case(FILE *f, const char *class, const char *of, const json_t *row)
{
    double seconds = iso_row_number(row, "seconds");
    FILL(f, "    <testcase classname=\"%.%\"", class, of);
    fprintf(f, " time=\"%.3f\" name=\"", seconds > 0 ? seconds : 0);
}

/* Writes `NAME 0.02, at most 0.01; ` if a limit is exceeded, or the value is NaN. */
static void put_unheld(FILE *f, const char *name, double value, double limit)
{
    if (value <= limit)
        return;
    iso_markup_put(f, name);
    if (isnan(value))
        fprintf(f, " is not a number, at most %.4g; ", limit);
    else
        fprintf(f, " %.4g, at most %.4g; ", value, limit);
}

static void put_why_it_differs(FILE *f, const json_t *row)
{
    const json_t *limits = json_object_get(row, "limits"), *gates = json_object_get(row, "gates");
    const char *key;
    json_t *limit, *gate;
    size_t i;
    if (json_integer_value(json_object_get(row, "nonfinite_count")) > 0)
        fprintf(f, "%lld pixels are not finite; ",
                (long long)json_integer_value(json_object_get(row, "nonfinite_count")));
    json_object_foreach ((json_t *)limits, key, limit)
        put_unheld(f, key, iso_row_metric(row, key), json_number_value(limit));
    json_array_foreach (gates, i, gate)
        put_unheld(f, iso_row_text(gate, "name"), iso_row_number(gate, "value"), iso_row_number(gate, "limit"));
    if (json_object_size(limits) == 0 && json_array_size(gates) == 0)
        fprintf(f, "max_abs %.4g, without limits only equal images agree; ", iso_row_number(row, "max_abs"));
    iso_markup_put(f, iso_row_text(row, "why"));
}

static void put_case_agreement(FILE *f, const json_t *root, const json_t *row)
{
    (void)root;
    char name[ISO_ROW_NAME_BYTES];
    const char *tier = iso_row_text(row, "tier");
    iso_row_name_of(row, name);
    put_case(f, "agreement", iso_row_text(row, "scene"), row);
    fprintf(f, "level %lld: ", iso_row_level(row));
    FILL(f, "% against %%%", iso_row_text(row, "a"), name, tier[0] ? ", " : "", tier);
    if (has_verdict(row, ISO_VERDICT_AGREE)) {
        fputs("\"/>\n", f);
    } else if (has_verdict(row, ISO_VERDICT_DIFFER)) {
        fputs("\">\n      <failure type=\"differ\" message=\"", f);
        put_why_it_differs(f, row);
        FILL(f, "\">%</failure>\n    </testcase>\n", iso_row_text(row, "command"));
    } else {
        FILL(f, "\">\n      <skipped message=\"%: %\"/>\n    </testcase>\n", iso_row_text(row, "verdict"),
             iso_row_text(row, "why"));
    }
}

/* Writes a calibration, with the mistake that explains a failure. A missing renderer is an error; its rows are
 * skipped. */
static void put_case_calibration(FILE *f, const json_t *root, const json_t *row)
{
    const char *mistake = iso_row_text(json_object_get(root, "mistakes"), iso_row_text(row, "renderer")),
               *detail = iso_row_text(row, "detail");
    const bool measured = json_is_number(json_object_get(row, "value"));
    put_case(f, "calibration", iso_row_text(row, "renderer"), row);
    iso_markup_put(f, iso_row_text(row, "check"));
    if (has_verdict(row, ISO_VERDICT_PASS)) {
        fputs("\"/>\n", f);
        return;
    }
    if (has_verdict(row, ISO_VERDICT_NOT_COMPARED)) {
        FILL(f, "\">\n      <skipped message=\"%\"/>\n    </testcase>\n", detail);
        return;
    }
    if (measured)
        fprintf(f, "\">\n      <failure type=\"calibration\" message=\"value %.6g %s, limit %.6g\">",
                iso_row_number(row, "value"), iso_row_text(row, "unit"), iso_row_number(row, "limit"));
    else
        fputs("\">\n      <error type=\"calibration\" message=\"nothing was measured\">", f);
    FILL(f, "%%%%", mistake[0] ? "The renderer draws " : "", mistake, mistake[0] ? ". " : "", detail);
    fprintf(f, "</%s>\n    </testcase>\n", measured ? "failure" : "error");
}

static void put_property(FILE *f, const char *name, const char *value)
{
    if (name[0] && value)
        FILL(f, "      <property name=\"%\" value=\"%\"/>\n", name, value);
}

/* Writes the distance of a level from level 0 as facts: it has no limits. */
static void put_facts_consistency(FILE *f, const json_t *row)
{
    static const char *const keys[] = {"ssim_dissimilarity_mean", "flip_mean", "gradient_angle_mean_deg",
                                       "original_kept"};
    char of[ISO_CONSISTENCY_NAME_BYTES], name[ISO_CONSISTENCY_NAME_BYTES + 64], figure[32];
    iso_report_consistency_name(row, of);
    for (size_t i = 0; i < sizeof keys / sizeof *keys; ++i) {
        const json_t *value = json_object_get(row, keys[i]);
        snprintf(name, sizeof name, "level %lld: %s: %s", iso_row_level(row), of, keys[i]);
        snprintf(figure, sizeof figure, "%.6g", json_number_value(value));
        put_property(f, name, json_is_number(value) ? figure : json_string_value(value));
    }
}

/* Writes the figures in which gradients on the fly are better. */
static void put_simple(FILE *f, const json_t *simple)
{
    json_t *figure;
    size_t i;
    json_array_foreach (json_object_get(simple, "figures"), i, figure) {
        if (!json_is_true(json_object_get(figure, "better")))
            continue;
        iso_markup_put(f, iso_row_text(figure, "name"));
        fprintf(f, " %.3g worse than gradients on the fly under the original TF; ",
                iso_row_number(figure, "difference"));
    }
}

/* Writes a level that does not hold as a failure; better figures of other methods are facts. */
static void put_case_levels(FILE *f, const json_t *root, const json_t *row)
{
    (void)root;
    const json_t *stored = json_object_get(row, "stored");
    json_t *figure;
    size_t i;
    put_case(f, "levels", iso_row_text(row, "method"), row);
    fprintf(f, "level %lld against level 0", iso_row_level(row));
    if (has_verdict(row, ISO_VERDICT_AGREE)) {
        fputs("\"/>\n", f);
        return;
    }
    if (has_verdict(row, ISO_VERDICT_NOT_COMPARED)) {
        fputs("\">\n      <skipped message=\"level 0 shows nothing in any view\"/>\n    </testcase>\n", f);
        return;
    }
    fputs("\">\n      <failure type=\"level\" message=\"", f);
    put_unheld(f, "values against level 0's", iso_row_number(stored, "scalar"), iso_row_number(stored, "scalar_limit"));
    put_unheld(f, "directions against level 0's, degrees", iso_row_number(stored, "direction_deg"),
               iso_row_number(stored, "direction_limit_deg"));
    const json_t *bound = json_object_get(row, "bound");
    if (bound && !json_is_true(json_object_get(bound, "held")))
        put_unheld(f, "RMSE above its bound", iso_row_number(bound, "above"), iso_row_number(row, "margin"));
    const json_t *scale = json_object_get(row, "extinction_scale");
    if (scale)
        put_unheld(f, "voxels whose extinction scale differs from one made of level 0",
                   iso_row_number(scale, "differing_voxels"), 0);
    if (scale && !json_is_true(json_object_get(scale, "has_effect")))
        fputs("the extinction scale changes no picture; ", f);
    json_array_foreach (json_object_get(row, "figures"), i, figure)
        if (!json_is_true(json_object_get(figure, "held")))
            put_unheld(f, iso_row_text(figure, "name"), iso_row_number(figure, "value"),
                       iso_row_number(figure, "asked"));
    if (!json_is_true(json_object_get(row, "simple_held")))
        put_simple(f, json_object_get(row, "simple"));
    fputs("\"/>\n    </testcase>\n", f);
}

typedef struct suite {
    const char *name;                                                 /* also of the rows */
    void (*put_case)(FILE *f, const json_t *root, const json_t *row), /* one of the two */
        (*put_facts)(FILE *f, const json_t *row);
} suite;

/* Sections without cases, or without facts. */
#define put_facts_calibration NULL
#define put_facts_agreement NULL
#define put_facts_levels NULL
#define put_case_consistency NULL

static const suite suites[] = {
#define ISO_SECTION_ROW(name, verdicts) {#name, put_case_##name, put_facts_##name},
    ISO_SECTION_LIST(ISO_SECTION_ROW)
#undef ISO_SECTION_ROW
};
enum { SUITES = sizeof suites / sizeof *suites, ALWAYS = 2 }; /* readers expect the first suites, even if empty */

static void put_open_case(FILE *f, const char *scene, const char *renderer)
{
    FILL(f,
         "    <testcase classname=\"agreement.%\" time=\"0.000\" name=\"something is compared%%\">\n"
         "      <failure type=\"not compared\" message=\"nothing was compared, so nothing is shown to agree\"/>\n"
         "    </testcase>\n",
         scene, renderer ? " of " : "", renderer);
}

/* Writes the unanswered comparisons (iso_rows_unanswered()), and counts them. f: NULL to count only. */
static size_t put_open_cases(FILE *f, json_t *unanswered)
{
    const char *scene;
    json_t *renderers, *renderer;
    size_t i, count = 0;
    json_object_foreach (unanswered, scene, renderers) {
        if (json_array_size(renderers) == 0) {
            ++count;
            if (f)
                put_open_case(f, scene, NULL);
        }
        json_array_foreach (renderers, i, renderer) {
            ++count;
            if (f)
                put_open_case(f, scene, json_string_value(renderer));
        }
    }
    return count;
}

static void put_suite(FILE *f, const iso_report *r, int id, const suite *s)
{
    const json_t *root = iso_report_json(r), *rows = json_object_get(root, s->name);
    size_t i, failures = 0, errors = 0, skipped = 0;
    double seconds = 0;
    const char *key;
    json_t *row, *version, *open = s->put_case == put_case_agreement ? iso_rows_unanswered(rows) : NULL;
    const size_t open_count = put_open_cases(NULL, open);
    failures = open_count;
    json_array_foreach (rows, i, row) {
        const bool failed = has_verdict(row, ISO_VERDICT_DIFFER) || has_verdict(row, ISO_VERDICT_FAIL),
                   nothing = json_is_null(json_object_get(row, "value"));
        failures += failed && !nothing;
        errors += failed && nothing;
        skipped += has_verdict(row, ISO_VERDICT_REFUSED) || has_verdict(row, ISO_VERDICT_NOT_COMPARED);
        seconds += fmax(iso_row_number(row, "seconds"), 0); /* fmax() ignores NaN */
    }
    /* the schema requires a host; a report does not contain the machine's name */
    fprintf(f, "  <testsuite id=\"%d\" package=\"isoshade\" name=\"%s\" timestamp=\"%.19s\" hostname=\"localhost\"", id,
            s->name, iso_row_text(root, "made"));
    fprintf(f, " tests=\"%zu\" failures=\"%zu\" errors=\"%zu\" skipped=\"%zu\" time=\"%.3f\">\n    <properties>\n",
            s->put_case ? json_array_size(rows) + open_count : 0, failures, errors, skipped, seconds);
    put_property(f, "command", json_string_value(json_object_get(root, "command")));
    json_object_foreach (json_object_get(root, "versions"), key, version)
        put_property(f, key, json_string_value(version));
    json_array_foreach (rows, i, row)
        if (s->put_facts)
            s->put_facts(f, row);
    fputs("    </properties>\n", f);
    json_array_foreach (rows, i, row)
        if (s->put_case)
            s->put_case(f, root, row);
    put_open_cases(f, open);
    json_decref(open);
    fputs("    <system-out/>\n    <system-err/>\n  </testsuite>\n", f);
}

iso_status iso_report_write_junit(const iso_report *r, const char *path, iso_error *err)
{
    FREED char *xml = NULL;
    size_t size = 0;
    FILE *f = open_memstream(&xml, &size);
    NEED_MEMORY(f, err, "report: out of memory");
    fputs("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites>\n", f);
    for (int i = 0; i < SUITES; ++i)
        if (i < ALWAYS || json_array_size(json_object_get(iso_report_json(r), suites[i].name)) > 0)
            put_suite(f, r, i, &suites[i]);
    fputs("</testsuites>\n", f);
    return fclose(f) == 0 ? iso_file_write(path, xml, size, err) : iso_fail(err, ISO_E_MEMORY, "report: out of memory");
}

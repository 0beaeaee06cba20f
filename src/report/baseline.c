/* SPDX-License-Identifier: MIT */
#include "report/baseline.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "report/report.h"
#include "report/sections.h"

static const char schema[] = ISO_BASELINE_SCHEMA;

/* Ends the key of a gate's value, which is kept in parts of its limit: what counts pixels and what counts standard errors
 * then have one measure, and one floor below which a change says nothing. */
static const char part_suffix[] = ", part of its limit";
#define PART_FLOOR 0.1

static const char *string_of(const json_t *object, const char *key)
{
    const char *s = json_string_value(json_object_get(object, key));
    return s ? s : "";
}

/* Four digits say more than a figure repeats. */
static json_t *rounded(double value)
{
    char text[32];
    snprintf(text, sizeof text, "%.4g", value);
    return json_real(strtod(text, NULL));
}

static void keep(json_t *kept, const char *key, double value, size_t *figures)
{
    json_object_set_new(kept, key, rounded(value));
    ++*figures;
}

/* How closely the row was held: the limits of its metrics, and of each gate its limit and how much of it is used up. */
static void keep_what_was_asked(json_t *kept, const json_t *row, size_t *figures)
{
    const char *metric;
    json_t *limit, *gate;
    size_t i;
    char key[200];
    json_object_foreach(json_object_get(row, "limits"), metric, limit)
    {
        snprintf(key, sizeof key, "limit of %s", metric);
        if (json_is_number(limit))
            keep(kept, key, json_number_value(limit), figures);
    }
    json_array_foreach(json_object_get(row, "gates"), i, gate)
    {
        const double value = json_number_value(json_object_get(gate, "value")),
                     most = json_number_value(json_object_get(gate, "limit"));
        snprintf(key, sizeof key, "limit of %.100s", string_of(gate, "name"));
        keep(kept, key, most, figures);
        snprintf(key, sizeof key, "%.100s%s", string_of(gate, "name"), part_suffix);
        if (json_is_number(json_object_get(gate, "value")) && most > 0)
            keep(kept, key, fabs(value) / most, figures);
    }
    json_array_foreach(json_object_get(row, "figures"), i, gate)
    {
        const json_t *asked = json_object_get(gate, "asked"), *value = json_object_get(gate, "value");
        if (json_is_number(value))
            keep(kept, string_of(gate, "figure"), json_number_value(value), figures);
        snprintf(key, sizeof key, "limit of %.100s", string_of(gate, "figure"));
        if (json_is_number(asked))
            keep(kept, key, json_number_value(asked), figures);
    }
}

/* The verdict, and what was measured: a refused row has nulls, which are left out, and miss later. */
static iso_status take_row(json_t *rows, const json_t *row, const char *name, const char *const keys[], size_t *figures,
                           iso_error *err)
{
    if (json_object_get(rows, name))
        return iso_fail(err, ISO_E_RANGE, "baseline: the report has two rows \"%s\"", name);
    const json_t *ssim = json_object_get(row, "ssim");
    if (json_is_number(ssim) &&
        !(fabs(json_number_value(ssim)) <= 1 + 1e-6)) /* rounding; beyond it worse looks better */
        return iso_fail(err, ISO_E_FORMAT, "baseline: row \"%s\": ssim is %g, at most 1", name,
                        json_number_value(ssim));
    json_t *kept = json_object();
    if (string_of(row, "verdict")[0])
        json_object_set_new(kept, "verdict", json_string(string_of(row, "verdict")));
    for (int i = 0; keys[i]; ++i) {
        const json_t *value = json_object_get(row, keys[i]);
        if (json_is_number(value))
            keep(kept, keys[i], fabs(json_number_value(value)), figures);
    }
    if (json_is_number(ssim))
        keep(kept, "ssim_dissimilarity", 1 - json_number_value(ssim), figures);
    keep_what_was_asked(kept, row, figures);
    json_object_set_new(rows, name, kept);
    return ISO_OK;
}

static int by_name(const void *a, const void *b)
{
    return strcmp(*(const char *const *)a, *(const char *const *)b);
}

/* The same rows in the order of their names; takes the reference. NULL when memory ends. */
static json_t *sorted(json_t *rows)
{
    const char **names = calloc(json_object_size(rows) + 1, sizeof *names), *name;
    json_t *out = json_object(), *row;
    size_t count = 0;
    json_object_foreach(rows, name, row) if (names) names[count++] = name;
    if (names)
        qsort(names, count, sizeof *names, by_name);
    for (size_t i = 0; i < count; ++i)
        json_object_set(out, names[i], json_object_get(rows, names[i]));
    json_decref(rows);
    free(names);
    if (names)
        return out;
    json_decref(out);
    return NULL;
}

/* ---- sections: names of rows, and the figures that are kept ---- */

enum { NAME_BYTES = 700 };

static long long level_of(const json_t *row)
{
    return (long long)json_integer_value(json_object_get(row, "level"));
}

static void name_agreement(const json_t *row, char name[NAME_BYTES])
{
    char of[ISO_ROW_NAME_BYTES];
    iso_row_name_of(row, of);
    snprintf(name, NAME_BYTES, "agreement/%s/level %lld/%s/%s/%s", string_of(row, "scene"), level_of(row),
             string_of(row, "a"), of, string_of(row, "tier"));
}

static void name_calibration(const json_t *row, char name[NAME_BYTES])
{
    snprintf(name, NAME_BYTES, "calibration/%s/%s", string_of(row, "renderer"), string_of(row, "check"));
}

static void name_consistency(const json_t *row, char name[NAME_BYTES])
{
    char method[ISO_CONSISTENCY_NAME_BYTES];
    iso_report_consistency_name(row, method);
    snprintf(name, NAME_BYTES, "consistency/%s/level %lld", method, level_of(row));
}

static void name_levels(const json_t *row, char name[NAME_BYTES])
{
    snprintf(name, NAME_BYTES, "levels/level %lld", level_of(row));
}

static const char *const keys_agreement[] = {"rmse", "max_abs", "p99_abs", "flip_mean", "error_bar", NULL};
static const char *const keys_calibration[] = {"value", "limit", NULL};
static const char *const keys_consistency[] = {"ssim_dissimilarity_mean", "flip_mean", "rmse_mean",
                                               "gradient_angle_mean_deg", NULL};
static const char *const keys_levels[] = {NULL}; /* its figures are a list */

static const struct {
    const char *list;
    void (*name)(const json_t *row, char name[NAME_BYTES]);
    const char *const *keys;
} sections[] = {
#define ISO_SECTION_ROW(name, verdicts) {#name, name_##name, keys_##name},
    ISO_SECTION_LIST(ISO_SECTION_ROW)
#undef ISO_SECTION_ROW
};

iso_status iso_baseline_from_report(const json_t *report, json_t **baseline, iso_error *err)
{
    json_t *rows = json_object(), *row;
    size_t i, k, figures = 0;
    char name[NAME_BYTES];
    *baseline = NULL;
    iso_status status = iso_report_check(report, "baseline: the report", err);
    for (k = 0; k < sizeof sections / sizeof *sections; ++k)
        json_array_foreach(json_object_get(report, sections[k].list), i, row)
        {
            sections[k].name(row, name);
            if (status == ISO_OK)
                status = take_row(rows, row, name, sections[k].keys, &figures, err);
        }
    if (status == ISO_OK && figures == 0)
        status = iso_fail(err, ISO_E_RANGE, "baseline: the report holds no figure");
    if (status == ISO_OK && !(rows = sorted(rows)))
        status = iso_fail(err, ISO_E_MEMORY, "baseline: out of memory");
    if (status != ISO_OK) {
        json_decref(rows);
        return status;
    }
    *baseline = json_pack("{s:s, s:s, s:O*, s:O*, s:o}", "schema", schema, "command", string_of(report, "command"),
                          "options", json_object_get(report, "options"), "versions",
                          json_object_get(report, "versions"), "rows", rows);
    return ISO_OK;
}

static void note(iso_baseline_result *r, const char *row, const char *key, const json_t *accepted, const json_t *now,
                 const char *change)
{
    char figure[800];
    snprintf(figure, sizeof figure, "%s/%s", row, key);
    json_t *o = json_pack("{s:s, s:O, s:O, s:s}", "figure", figure, "accepted", accepted ? accepted : json_null(),
                          "now", now ? now : json_null(), "change", change);
    if (strcmp(change, "worse") == 0 || strcmp(change, "missing") == 0)
        json_array_insert_new(r->changes, 0, o);
    else
        json_array_append_new(r->changes, o);
}

static bool ends_with(const char *text, const char *end)
{
    const size_t length = strlen(text), tail = strlen(end);
    return length >= tail && strcmp(text + length - tail, end) == 0;
}

static void compare_figure(const char *row, const char *key, const json_t *before, const json_t *after, double factor,
                           double floor, iso_baseline_result *r)
{
    int step; /* above 0: worse */
    if (json_is_string(before)) {
        /* How little it says: less certain is worse, also where nothing is known to be wrong. */
        step = iso_verdict_doubt(iso_verdict_from(after)) - iso_verdict_doubt(iso_verdict_from(before));
    } else {
        double old = json_number_value(before), new = json_number_value(after);
        if (ends_with(key, part_suffix))
            floor = fmax(floor, PART_FLOOR);
        const double more = old < 0 ? 1 / factor : factor; /* a damaged file may say a figure below 0 */
        step = !(new <= more *old + floor) ? 1 : new < old / more - floor ? -1 : 0;
    }
    if (!after || json_typeof(before) != json_typeof(after)) {
        ++r->missing;
        note(r, row, key, before, NULL, "missing");
    } else if (step > 0) {
        ++r->worse;
        note(r, row, key, before, after, "worse");
    } else if (step < 0) {
        ++r->better;
        note(r, row, key, before, after, "better");
    } else {
        ++r->same;
    }
}

/* Of a row that was accepted: a word that nobody knows would be the weakest, so that nothing could be worse. */
static iso_status check_verdicts(const json_t *accepted, iso_error *err)
{
    const char *name;
    json_t *row;
    json_object_foreach(json_object_get(accepted, "rows"), name, row)
        if (json_object_get(row, "verdict") && iso_row_verdict(row) == ISO_VERDICT_UNKNOWN)
            return iso_fail(err, ISO_E_FORMAT, "baseline: row \"%.200s\": verdict \"%.60s\" is not known", name,
                            string_of(row, "verdict"));
    return ISO_OK;
}

static void compare_rows(const json_t *now, const json_t *accepted, double factor, double floor, iso_baseline_result *r)
{
    const char *name, *key;
    json_t *row, *value;
    json_object_foreach((json_t *)now, name, row)
        json_object_foreach(row, key, value) if (!json_object_get(json_object_get(accepted, name), key))
    {
        ++r->added;
        note(r, name, key, NULL, value, "new");
    }
    json_object_foreach((json_t *)accepted, name, row) json_object_foreach(row, key, value)
        compare_figure(name, key, value, json_object_get(json_object_get(now, name), key), factor, floor, r);
}

static void compare_facts(const json_t *now, const json_t *accepted, const char *section, iso_baseline_result *r)
{
    const json_t *new = json_object_get(now, section), *old = json_object_get(accepted, section);
    json_t *both = json_object(), *unused;
    const char *key;
    if (old)
        json_object_update(both, (json_t *)old);
    if (new)
        json_object_update(both, (json_t *)new);
    json_object_foreach(both, key, unused)
    {
        json_t *before = json_object_get(old, key), *after = json_object_get(new, key);
        char fact[300];
        if (before && after && json_equal(before, after))
            continue;
        snprintf(fact, sizeof fact, "%s/%s", section, key);
        json_array_append_new(r->facts, json_pack("{s:s, s:O, s:O}", "fact", fact, "accepted",
                                                  before ? before : json_null(), "now", after ? after : json_null()));
    }
    json_decref(both);
}

size_t iso_baseline_figure_count(const json_t *baseline)
{
    const char *name;
    json_t *row;
    size_t count = 0;
    json_object_foreach(json_object_get(baseline, "rows"), name, row) count += json_object_size(row);
    return count;
}

iso_status iso_baseline_compare(const json_t *now, const json_t *accepted, double factor, double floor,
                                iso_baseline_result *result, iso_error *err)
{
    *result = (iso_baseline_result){0};
    if (strcmp(string_of(accepted, "schema"), schema) != 0)
        return iso_fail(err, ISO_E_FORMAT, "baseline: schema is \"%s\", wanted %s", string_of(accepted, "schema"),
                        schema);
    if (!(factor >= 1 && factor <= 1e6) || !(floor >= 0 && floor <= 1))
        return iso_fail(err, ISO_E_RANGE, "baseline: factor %g, must be 1 to 1e6; floor %g, must be 0 to 1", factor,
                        floor);
    const iso_status status = check_verdicts(accepted, err);
    if (status != ISO_OK)
        return status;
    result->changes = json_array();
    result->facts = json_array();
    compare_rows(json_object_get(now, "rows"), json_object_get(accepted, "rows"), factor, floor, result);
    compare_facts(now, accepted, "versions", result);
    compare_facts(now, accepted, "options", result);
    return ISO_OK;
}

void iso_baseline_result_destroy(iso_baseline_result *r)
{
    json_decref(r->changes);
    json_decref(r->facts);
    *r = (iso_baseline_result){0};
}

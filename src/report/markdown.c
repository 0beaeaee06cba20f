/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "report/markdown.h"

#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/markup.h"
#include "base/provenance.h"
#include "base/words.h"
#include "report/report.h"
#include "report/sections.h"

const char *iso_markdown_target(const char *dir)
{
    return dir[0] == '/' ? iso_provenance_name(dir) : dir;
}

enum { MOST_ROWS = 40 }; /* of a table: CI pages are limited to a megabyte */

/* Keeps only punctuation without a meaning in the middle of a line. A character reference is always text: it ends no
 * cell and begins no element, emphasis, link or mention. */
void iso_markdown_put_text(FILE *f, const char *text)
{
    for (size_t control; *text; text += control ? control : 1) {
        const unsigned char c = (unsigned char)*text;
        control = iso_words_control(text);
        if (control)
            fputc(' ', f);
        else if (c < 0x80 && ispunct(c) && !strchr(",.;:/()-+=%'?", c))
            fprintf(f, "&#%u;", c);
        else
            fputc(c, f);
    }
}

#define FILL(f, ...) iso_markup_fill(f, iso_markdown_put_text, __VA_ARGS__)

/* Writes the target of a link, escaped as in URLs. */
static void put_target(FILE *f, const char *path)
{
    for (; *path; ++path) {
        const unsigned char c = (unsigned char)*path;
        if (isalnum(c) || strchr("/._-~:", c))
            fputc(c, f);
        else
            fprintf(f, "%%%02X", c);
    }
}

static void put_link(FILE *f, const char *link)
{
    if (!link)
        return;
    FILL(f, "[%](", link);
    put_target(f, link);
    fputs(")\n", f);
}

static void put_number(FILE *f, double value)
{
    if (isnan(value))
        fputs("no number", f);
    else
        fprintf(f, "%.4g", value);
}

/* Writes the number of rows that are not shown. */
static void put_more(FILE *f, size_t all)
{
    if (all > MOST_ROWS)
        fprintf(f, "\nand %zu more in the report.\n", all - MOST_ROWS);
}

/* ---- a report ---- */

/* The largest excess over a limit of a row that differs. */
typedef struct excess {
    char name[64];
    double value, limit, ratio;
} excess;

static void consider(excess *worst, const char *name, double value, double limit)
{
    const double ratio = isnan(value) ? INFINITY : limit > 0 ? value / limit : value <= 0 ? 0 : INFINITY;
    if (worst->name[0] && !(ratio > worst->ratio))
        return;
    snprintf(worst->name, sizeof worst->name, "%.60s", name);
    worst->value = value, worst->limit = limit, worst->ratio = ratio;
}

static excess worst_of(const json_t *row)
{
    excess worst = {.name = ""};
    const char *metric;
    json_t *limit, *gate;
    size_t i;
    json_object_foreach (json_object_get(row, "limits"), metric, limit)
        consider(&worst, metric, iso_row_metric(row, metric), json_number_value(limit));
    json_array_foreach (json_object_get(row, "gates"), i, gate)
        consider(&worst, iso_row_text(gate, "name"), iso_row_number(gate, "value"), iso_row_number(gate, "limit"));
    return worst;
}

static void put_failed_agreement(FILE *f, const json_t *row)
{
    char name[ISO_ROW_NAME_BYTES], level[32];
    const excess worst = worst_of(row);
    iso_row_name_of(row, name);
    snprintf(level, sizeof level, "%lld", iso_row_level(row));
    FILL(f, "| % | % | % | % | ", iso_row_text(row, "scene"), level, name, worst.name);
    put_number(f, worst.value);
    fputs(" | ", f);
    put_number(f, worst.limit);
    fputs(" |\n", f);
}

static void put_failed_calibration(FILE *f, const json_t *row)
{
    FILL(f, "| calibration | | % | % | ", iso_row_text(row, "renderer"), iso_row_text(row, "check"));
    put_number(f, iso_row_number(row, "value"));
    fputs(" | ", f);
    put_number(f, iso_row_number(row, "limit"));
    fputs(" |\n", f);
}

/* Writes a row of a failed level; the sentence of the levels has the reasons. */
static void put_failed_levels(FILE *f, const json_t *row)
{
    fprintf(f, "| levels | %lld | ", iso_row_level(row));
    FILL(f, "% | does not hold | | |\n", iso_row_text(row, "method"));
}

#define put_failed_consistency NULL /* it has no limits */

static const struct {
    const char *list;
    void (*put)(FILE *f, const json_t *row);
} sections[] = {
#define ISO_SECTION_ROW(name, verdicts) {#name, put_failed_##name},
    ISO_SECTION_LIST(ISO_SECTION_ROW)
#undef ISO_SECTION_ROW
};

static void put_failures(FILE *f, const json_t *root)
{
    json_t *row;
    size_t i, k, count = 0;
    for (k = 0; k < sizeof sections / sizeof *sections; ++k)
        json_array_foreach (json_object_get(root, sections[k].list), i, row) {
            const iso_verdict verdict = iso_row_verdict(row);
            if (!sections[k].put || (verdict != ISO_VERDICT_DIFFER && verdict != ISO_VERDICT_FAIL))
                continue;
            if (count++ == 0)
                fputs("\n| scene | level | renderer | what | value | at most |\n|---|---|---|---|---|---|\n", f);
            if (count <= MOST_ROWS)
                sections[k].put(f, row);
        }
    put_more(f, count);
}

/* Writes each reason once, with its renderer and the number of refused rows. */
static void put_refusals(FILE *f, const json_t *agreement)
{
    json_t *row, *rows;
    json_auto_t *reasons = json_object();
    const char *key;
    size_t i;
    json_array_foreach ((json_t *)agreement, i, row)
        if (iso_row_verdict(row) == ISO_VERDICT_REFUSED) {
            const iso_row_identity id = iso_row_identify(row);
            FREED char *name = NULL;
            if (asprintf(&name, "%s: %s", id.renderer, iso_row_text(row, "why")) < 0)
                continue;
            json_object_set_new(reasons, name, json_integer(1 + json_integer_value(json_object_get(reasons, name))));
        }
    if (json_object_size(reasons) > 0)
        fputs("\n**Refused**\n\n", f);
    json_object_foreach (reasons, key, rows) {
        fputs("- ", f);
        iso_markdown_put_text(f, key);
        fprintf(f, " (%lld row%s)\n", (long long)json_integer_value(rows),
                iso_words_plural((size_t)json_integer_value(rows)));
    }
}

/* Writes the renderers that are not installed, and that nobody named. */
static void put_left_out(FILE *f, json_t *left_out)
{
    const char *name;
    json_t *why;
    json_object_foreach (left_out, name, why) {
        fprintf(f, "\nLeft out: %s: ", name);
        FILL(f, "%\n", json_string_value(why));
    }
}

/* Writes the checks that were not made, by renderer. */
static void put_not_calibrated(FILE *f, const json_t *calibration)
{
    size_t i, count = 0;
    json_t *row;
    json_array_foreach ((json_t *)calibration, i, row)
        if (iso_row_verdict(row) == ISO_VERDICT_NOT_COMPARED) {
            if (count++ == 0)
                fputs("\n**Not calibrated**\n\n", f);
            FILL(f, "- %, %: %\n", iso_row_text(row, "renderer"), iso_row_text(row, "check"),
                 iso_row_text(row, "detail"));
        }
}

static void put_versions(FILE *f, const json_t *versions)
{
    const char *what;
    json_t *version;
    if (json_object_size(versions) == 0)
        return;
    fputs("\n| | version |\n|---|---|\n", f);
    json_object_foreach ((json_t *)versions, what, version)
        FILL(f, "| % | % |\n", what, json_is_string(version) ? json_string_value(version) : "");
}

static void put_head(FILE *f, const char *kind, const json_t *root)
{
    const bool good = iso_row_verdict(root) == ISO_VERDICT_AGREE;
    fprintf(f, "### %s %s", good ? "✅" : "❌", kind);
    FILL(f, "%\n\n%\n\n", iso_row_text(root, "title"), iso_row_text(root, "sentence"));
}

static void put_report(FILE *f, const json_t *root)
{
    put_head(f, "isoshade validate: ", root);
    if (iso_row_text(root, "levels_sentence")[0])
        FILL(f, "%\n", iso_row_text(root, "levels_sentence"));
    put_failures(f, root);
    put_refusals(f, json_object_get(root, "agreement"));
    put_left_out(f, json_object_get(root, "left_out"));
    put_not_calibrated(f, json_object_get(root, "calibration"));
    put_versions(f, json_object_get(root, "versions"));
}

/* ---- two reports ---- */

/* Writes a number with four digits, or a text. */
static void put_value(FILE *f, const json_t *value)
{
    if (json_is_real(value)) {
        put_number(f, json_real_value(value));
    } else if (json_is_string(value)) {
        iso_markdown_put_text(f, json_string_value(value));
    } else {
        FREED char *text = value && !json_is_null(value) ? json_dumps(value, JSON_ENCODE_ANY | JSON_COMPACT) : NULL;
        iso_markdown_put_text(f, text ? text : "-");
    }
    fputs(" | ", f);
}

/* Writes a line of a change: row, what, A, B. */
static void put_change(FILE *f, const json_t *row, const char *what, const json_t *a, const json_t *b)
{
    FILL(f, "| % | % | ", iso_row_text(row, "name"), what);
    put_value(f, a);
    put_value(f, b);
    fputs("\n", f);
}

static void put_changed_row(FILE *f, const json_t *row)
{
    const json_t *what = json_object_get(row, "what"), *one;
    size_t i;
    if (json_array_size(what) == 0)
        put_change(f, row, iso_row_text(row, "change"), json_object_get(row, "verdict_a"),
                   json_object_get(row, "verdict_b"));
    json_array_foreach (what, i, one)
        put_change(f, row, iso_row_text(one, "what"), json_object_get(one, "a"), json_object_get(one, "b"));
}

static void put_facts(FILE *f, const json_t *facts)
{
    size_t i;
    json_t *fact;
    if (json_array_size(facts) == 0)
        return;
    fputs("\n| made with | A | B |\n|---|---|---|\n", f);
    json_array_foreach ((json_t *)facts, i, fact) {
        FILL(f, "| % | ", iso_row_text(fact, "fact"));
        put_value(f, json_object_get(fact, "a"));
        put_value(f, json_object_get(fact, "b"));
        fputs("\n", f);
    }
}

static void put_difference(FILE *f, const json_t *difference)
{
    const json_t *rows = json_object_get(difference, "rows"), *row;
    size_t i;
    put_head(f, "isoshade report diff: ", difference);
    if (json_array_size(rows) > 0)
        fputs("| row | what | A | B |\n|---|---|---|---|\n", f);
    json_array_foreach (rows, i, row)
        if (i < MOST_ROWS)
            put_changed_row(f, row);
    put_more(f, json_array_size(rows));
    put_facts(f, json_object_get(difference, "facts"));
}

/* ---- files ---- */

static iso_status save(const char *path, void (*put)(FILE *f, const json_t *root), const json_t *root, const char *link,
                       iso_error *err)
{
    FREED char *text = NULL;
    size_t size = 0;
    FILE *f = open_memstream(&text, &size);
    NEED_MEMORY(f, err, "%s: no memory", path);
    put(f, root);
    fputs("\n", f);
    put_link(f, link);
    return fclose(f) == 0 ? iso_file_write(path, text, size, err) : iso_fail(err, ISO_E_MEMORY, "%s: no memory", path);
}

iso_status iso_markdown_of_report(const char *path, const json_t *root, const char *link, iso_error *err)
{
    return save(path, put_report, root, link, err);
}

iso_status iso_markdown_of_difference(const char *path, const json_t *difference, const char *link, iso_error *err)
{
    return save(path, put_difference, difference, link, err);
}

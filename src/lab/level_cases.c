/* SPDX-License-Identifier: MIT */
/* level_cases.c - the cases of `isoshade-lab levels` and the table that stores them, so that a run can be continued. */
#define _GNU_SOURCE
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "lab/levels_report.h"

const char *const iso_level_figure_keys[ISO_LEVEL_CASE_FIGURES] = {
    "dssim", "rmse", "flip", "dssim_minified", "rmse_minified", "flip_minified"};

static double *figure_at(struct iso_level_result *r, int figure)
{
    iso_level_error *e = figure < 3 ? &r->full : &r->minified;
    return figure % 3 == 0 ? &e->dssim : figure % 3 == 1 ? &e->rmse : &e->flip;
}

double iso_level_result_figure(const struct iso_level_result *r, int figure)
{
    struct iso_level_result copy = *r;
    return *figure_at(&copy, figure);
}

iso_level_case *iso_level_cases_add(iso_level_cases *c)
{
    if (c->count == c->room) {
        const size_t room = c->room ? 2 * c->room : 16;
        iso_level_case *more = realloc(c->cases, room * sizeof *more);
        if (!more)
            return NULL;
        c->cases = more;
        c->room = room;
    }
    c->cases[c->count] = (iso_level_case){0};
    return &c->cases[c->count++];
}

void iso_level_cases_destroy(iso_level_cases *c)
{
    for (size_t i = 0; i < c->text_count; ++i)
        free(c->texts[i]);
    free(c->texts);
    free(c->cases);
    *c = (iso_level_cases){0};
}

const char *iso_level_cases_keep_text(iso_level_cases *c, const char *text)
{
    for (size_t i = 0; i < c->text_count; ++i)
        if (strcmp(c->texts[i], text) == 0)
            return c->texts[i];
    char **more = realloc(c->texts, (c->text_count + 1) * sizeof *more), *copy = strdup(text);
    if (more)
        c->texts = more;
    if (!more || !copy) {
        free(copy);
        return NULL;
    }
    return c->texts[c->text_count++] = copy;
}

iso_level_case *iso_level_cases_find(const iso_level_cases *c, const iso_level_case *like)
{
    for (size_t i = 0; i < c->count; ++i) {
        iso_level_case *one = &c->cases[i];
        if (one->held == like->held && one->level == like->level && strcmp(one->tf, like->tf) == 0 &&
            strcmp(one->volume, like->volume) == 0)
            return one;
    }
    return NULL;
}

/* ---- the table ---- */

/* These columns first, then the figures, then LAST. */
static const char first_columns[] = "held,volume,tf,level,method,left_out",
                  last_columns[] = "finest_alpha,alpha,box_pixels,kept_original,voxels,settings";
enum { FIRST = 6, LAST = 6, COLUMNS = FIRST + ISO_LEVEL_CASE_FIGURES + LAST };

static void write_heading(FILE *out)
{
    fputs(first_columns, out);
    for (int f = 0; f < ISO_LEVEL_CASE_FIGURES; ++f)
        fprintf(out, ",%s", iso_level_figure_keys[f]);
    fprintf(out, ",%s\n", last_columns);
}

/* Writes one row; 17 digits keep numbers exact when read again. */
static void write_row(const iso_level_cases *c, const iso_level_case *one, size_t method, FILE *out)
{
    const struct iso_level_result *r = &one->results[method];
    const char *why = iso_level_case_left_out(c, one);
    fprintf(out, "%d,%s,%s,%zu,%s,%s", one->held, one->volume, one->tf, one->level, iso_level_method_at(method)->name,
            why ? why : "");
    for (int f = 0; f < ISO_LEVEL_CASE_FIGURES; ++f)
        fprintf(out, ",%.17g", iso_level_result_figure(r, f));
    fprintf(out, ",%.17g,%.17g,%zu,%d,%zux%zux%zu,%s\n", one->finest_alpha, r->alpha, one->box, r->kept_original,
            one->size[0], one->size[1], one->size[2], c->settings);
}

iso_status iso_level_cases_write_csv(const iso_level_cases *c, const char *path, iso_error *err)
{
    FREED char *text = NULL;
    size_t size = 0;
    FILE *memory = open_memstream(&text, &size);
    NEED_MEMORY(memory, err, "no memory for a table of %zu cases", c->count);
    write_heading(memory);
    for (size_t i = 0; i < c->count; ++i)
        for (size_t m = 0; m < iso_level_method_count(); ++m)
            if (c->cases[i].results[m].measured)
                write_row(c, &c->cases[i], m, memory);
    fclose(memory);
    return iso_file_write(path, text, size, err);
}

/* ---- reading ---- */

static bool read_number(const char *text, double *number)
{
    char *end;
    *number = strtod(text, &end);
    return *text && !*end && isfinite(*number);
}

/* Finds the row's case or adds one. NULL: out of memory. */
static iso_level_case *case_of_row(iso_level_cases *c, const iso_level_case *like)
{
    iso_level_case *one = iso_level_cases_find(c, like);
    if (one)
        return one;
    one = iso_level_cases_add(c);
    if (!one)
        return NULL;
    *one = *like;
    one->volume = iso_level_cases_keep_text(c, like->volume);
    one->tf = iso_level_cases_keep_text(c, like->tf);
    return one->volume && one->tf ? one : NULL;
}

/* Parses a row's case and result; texts are borrowed. Returns false if a number is missing. */
static bool read_columns(char *const at[COLUMNS], iso_level_case *one, struct iso_level_result *r)
{
    char *const *last = at + FIRST + ISO_LEVEL_CASE_FIGURES;
    double level = 0, box = 0, number = 0;
    bool good = read_number(at[3], &level) && read_number(last[0], &one->finest_alpha) &&
                read_number(last[1], &r->alpha) && read_number(last[2], &box) && level >= 1 && box >= 0 &&
                sscanf(last[4], "%zux%zux%zu", &one->size[0], &one->size[1], &one->size[2]) == 3;
    for (int f = 0; f < ISO_LEVEL_CASE_FIGURES; ++f) {
        good = good && read_number(at[FIRST + f], &number);
        *figure_at(r, f) = number;
    }
    one->held = at[0][0] == '1';
    one->volume = at[1];
    one->tf = at[2];
    one->level = (size_t)level;
    one->box = (size_t)box;
    r->kept_original = last[3][0] == '1';
    r->measured = true;
    return good;
}

/* Parses a line (without line end). */
static iso_status read_row(iso_level_cases *c, char *line, iso_error *err)
{
    char *at[COLUMNS + 1] = {NULL}, *rest = line;
    size_t count = 0, method;
    iso_level_case like = {0};
    struct iso_level_result result = {0};
    while (count <= COLUMNS && (at[count] = strsep(&rest, ",")))
        ++count;
    if (count != COLUMNS)
        return iso_fail(err, ISO_E_FORMAT, "wrong number of columns, must be as in the heading");
    if (!read_columns(at, &like, &result))
        return iso_fail(err, ISO_E_FORMAT, "a number is missing");
    if (iso_names_find(&iso_level_method_names, at[4], &method, err) != ISO_OK)
        return ISO_E_FORMAT;
    const char *settings = at[COLUMNS - 1];
    if (!c->settings[0])
        snprintf(c->settings, sizeof c->settings, "%s", settings);
    if (strcmp(c->settings, settings) != 0)
        return iso_fail(err, ISO_E_FORMAT, "measured with \"%s\", not \"%s\"", settings, c->settings);
    iso_level_case *one = case_of_row(c, &like);
    NEED_MEMORY(one, err, "no memory for a case");
    if (memcmp(one->size, like.size, sizeof like.size) != 0)
        return iso_fail(err, ISO_E_FORMAT, "%s: size differs from an earlier line", like.volume);
    if (one->results[method].measured)
        return iso_fail(err, ISO_E_FORMAT, "repeats an earlier line's case and method");
    one->results[method] = result;
    return ISO_OK;
}

static bool is_heading(const char *line)
{
    FREED char *text = NULL;
    size_t size = 0;
    FILE *memory = open_memstream(&text, &size);
    if (!memory)
        return false;
    write_heading(memory);
    fclose(memory);
    const bool same = size > 0 && strncmp(text, line, size - 1) == 0 && strlen(line) == size - 1;
    return same;
}

iso_status iso_level_cases_read_csv(iso_level_cases *c, const char *path, iso_error *err)
{
    char *text = NULL;
    size_t size = 0, number = 1;
    iso_status status = iso_file_read(path, &text, &size, err);
    if (status != ISO_OK)
        return status;
    char *rest = text, *line = strsep(&rest, "\n");
    if (!is_heading(line))
        status = iso_fail(err, ISO_E_FORMAT, "%s: not a table of this version's `isoshade-lab levels --csv`", path);
    while (status == ISO_OK && (line = strsep(&rest, "\n"))) {
        ++number;
        status = *line ? read_row(c, line, err) : ISO_OK;
        if (status != ISO_OK)
            status = iso_fail_in(err, ISO_E_FORMAT, "%s: line %zu", path, number);
    }
    free(text);
    return status;
}

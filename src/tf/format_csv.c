/* SPDX-License-Identifier: MIT */
/* format_csv.c - tables of text. Writes one line per entry in our own units. Reads these, and tables of display colors
 * as matplotlib and many other programs write them. */
#define _GNU_SOURCE
#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "tf/adapt.h"
#include "tf/format.h"

/* ---- reading ----------------------------------------------------------------------------------------------------- */

enum { VALUE, RED, GREEN, BLUE, OPACITY, EXTINCTION, IGNORED, ROLES, MOST_COLUMNS = 8, MOST_ROWS = 65536 };

/* Column names by role. The field `own` marks our own files, whose colors are linear. */
static const struct {
    const char *name;
    int role;
} column_names[] = {{"value", VALUE},
                    {"x", VALUE},
                    {"scalar", VALUE},
                    {"position", VALUE},
                    {"r", RED},
                    {"red", RED},
                    {"g", GREEN},
                    {"green", GREEN},
                    {"b", BLUE},
                    {"blue", BLUE},
                    {"a", OPACITY},
                    {"alpha", OPACITY},
                    {"opacity", OPACITY},
                    {"r_linear", RED},
                    {"g_linear", GREEN},
                    {"b_linear", BLUE},
                    {"extinction_per_mm", EXTINCTION}};

typedef struct csv {
    const iso_tf_file *file;
    bool own, has_header;
    size_t columns, rows;
    int role[MOST_COLUMNS];
    bool has[ROLES];
    double (*row)[ROLES];
} csv;

static bool is_separator(char c)
{
    return c == ',' || c == ';' || c == ' ' || c == '\t' || c == '\r';
}

/* Returns the length of the next field before `end`; 0 after the last. */
static size_t next_field(const char **at, const char *end, const char **field)
{
    while (*at < end && is_separator(**at))
        ++*at;
    *field = *at;
    while (*at < end && !is_separator(**at))
        ++*at;
    return (size_t)(*at - *field);
}

static void set_role(csv *c, size_t column, int role)
{
    c->role[column] = role;
    c->has[role] = true;
}

static iso_status read_header(csv *c, const char *line, const char *end, iso_error *err)
{
    const char *field;
    c->has_header = true;
    for (size_t length; (length = next_field(&line, end, &field)) > 0; ++c->columns) {
        char name[64];
        int role = -1;
        snprintf(name, sizeof name, "%.*s", (int)length, field);
        for (char *p = name; *p; ++p)
            *p = (char)tolower((unsigned char)*p);
        for (size_t i = 0; i < sizeof column_names / sizeof *column_names; ++i)
            if (strcmp(name, column_names[i].name) == 0)
                role = column_names[i].role;
        if (strncmp(name, "opacity_of_", 11) == 0)
            role = IGNORED; /* the extinction replaces it */
        c->own = c->own || role == EXTINCTION;
        if (role < 0 || c->columns == MOST_COLUMNS)
            return iso_fail(err, ISO_E_FORMAT,
                            "%s: unknown column \"%s\", must be one of: value, r, g, b, opacity (or alpha)",
                            c->file->path, name);
        set_role(c, c->columns, role);
    }
    return ISO_OK;
}

/* Assigns roles without a header: r g b; r g b a (as in matplotlib); or value r g b opacity. */
static iso_status guess_roles(csv *c, size_t columns, iso_error *err)
{
    static const int roles[] = {VALUE, RED, GREEN, BLUE, OPACITY};
    if (columns < 3 || columns > 5)
        return iso_fail(
            err, ISO_E_FORMAT,
            "%s: has %zu columns and no header, must have 3 (r, g, b), 4 (r, g, b, opacity) or 5 (value first)",
            c->file->path, columns);
    c->columns = columns;
    for (size_t i = 0; i < columns; ++i)
        set_role(c, i, roles[i + (columns < 5)]);
    return ISO_OK;
}

static iso_status read_row(csv *c, size_t number, const char *line, const char *end, iso_error *err)
{
    double values[MOST_COLUMNS + 1];
    const char *field;
    size_t count = 0;
    for (size_t length; count <= MOST_COLUMNS && (length = next_field(&line, end, &field)) > 0; ++count) {
        char *after;
        values[count] = strtod(field, &after);
        if (after != field + length)
            return iso_fail(err, ISO_E_FORMAT, "%s:%zu: \"%.*s\" is not a number", c->file->path, number,
                            (int)(length < 40 ? length : 40), field);
    }
    if (c->columns == 0) {
        NEED(guess_roles(c, count, err));
    }
    if (count != c->columns)
        return iso_fail(err, ISO_E_FORMAT, "%s:%zu: has %zu columns, the first line has %zu", c->file->path, number,
                        count, c->columns);
    if (c->rows == MOST_ROWS)
        return iso_fail(err, ISO_E_RANGE, "%s: has more than %d lines", c->file->path, (int)MOST_ROWS);
    for (size_t i = 0; i < count; ++i)
        c->row[c->rows][c->role[i]] = values[i];
    ++c->rows;
    return ISO_OK;
}

static iso_status read_lines(csv *c, iso_error *err)
{
    const char *line = c->file->text, *end = line + c->file->size;
    if (memchr(line, '\0', c->file->size))
        return iso_fail(err, ISO_E_FORMAT, "%s: is not text", c->file->path);
    for (size_t number = 1; line < end; ++number) {
        const char *stop = memchr(line, '\n', (size_t)(end - line));
        const char *field, *at = line;
        stop = stop ? stop : end;
        if (next_field(&at, stop, &field) > 0 && *field != '#')
            NEED(isalpha((unsigned char)*field) && c->rows == 0 && !c->has_header
                     ? read_header(c, line, stop, err)
                     : read_row(c, number, line, stop, err));
        line = stop + 1;
    }
    if (c->rows < 2)
        return iso_fail(err, ISO_E_FORMAT, "%s: has %zu lines of numbers, must have at least 2", c->file->path,
                        c->rows);
    if (!(c->has[RED] && c->has[GREEN] && c->has[BLUE]))
        return iso_fail(err, ISO_E_FORMAT, "%s: has no column \"%s\"", c->file->path,
                        !c->has[RED]     ? "r"
                        : !c->has[GREEN] ? "g"
                                         : "b");
    return ISO_OK;
}

/* Reads our own format: linear color and extinction at even distances. */
static iso_status take_own(const csv *c, iso_tf *tf, iso_error *err)
{
    OWNED(iso_tf_table) t = {.count = c->rows,
                             .lo = c->row[0][VALUE],
                             .hi = c->row[c->rows - 1][VALUE],
                             .entries = malloc(4 * c->rows * sizeof(float))};
    NEED_MEMORY(t.entries, err, "%s: out of memory", c->file->path);
    if (!c->has[VALUE] || !(t.hi > t.lo) || t.count > 4096)
        return iso_fail(err, ISO_E_RANGE, "%s: values must rise over at most 4096 lines", c->file->path);
    if (!(t.lo >= -ISO_TF_MOST_VALUE && t.hi <= ISO_TF_MOST_VALUE))
        return iso_fail(err, ISO_E_RANGE, "%s: values are %g to %g, must be %g to %g", c->file->path, t.lo, t.hi,
                        -ISO_TF_MOST_VALUE, ISO_TF_MOST_VALUE);
    for (size_t i = 0; i < t.count; ++i) {
        const double *v = c->row[i];
        const double even = t.lo + (t.hi - t.lo) * (double)i / (double)(t.count - 1);
        if (!(fabs(v[VALUE] - even) <= 1e-6 * (t.hi - t.lo)) ||
            !(v[EXTINCTION] >= 0 && v[EXTINCTION] <= ISO_TF_MOST_EXTINCTION))
            return iso_fail(err, ISO_E_RANGE,
                            "%s: line %zu of numbers: values must be evenly spaced, the extinction 0 to %g per mm",
                            c->file->path, i + 1, ISO_TF_MOST_EXTINCTION);
        for (int k = 0; k < 3; ++k)
            t.entries[4 * i + (size_t)k] = (float)fmin(fmax(v[RED + k], 0), 1);
        t.entries[4 * i + 3] = (float)v[EXTINCTION];
    }
    return iso_tf_from_table(&t, tf, err);
}

/* Returns 1/255 for whole numbers of which one exceeds 1: these are bytes. */
static double scale_of(const csv *c, int first, int last)
{
    double most = 0;
    bool whole = true;
    for (size_t i = 0; i < c->rows; ++i)
        for (int k = first; k <= last; ++k) {
            most = fmax(most, c->row[i][k]);
            whole = whole && c->row[i][k] == floor(c->row[i][k]);
        }
    return whole && most > 1 ? 255 : 1;
}

static iso_status take_display_colors(const csv *c, iso_tf *tf, iso_error *err)
{
    const double color_scale = scale_of(c, RED, BLUE), opacity_scale = scale_of(c, OPACITY, OPACITY);
    const double first = c->row[0][VALUE], last = c->row[c->rows - 1][VALUE];
    OWNED(iso_tf_curves) curves = {.are_fractions = !c->has[VALUE] || (first == 0 && last == 1)};
    for (size_t i = 0; i < c->rows; ++i) {
        const double *v = c->row[i], x = c->has[VALUE] ? v[VALUE] : (double)i / (double)(c->rows - 1);
        const double rgb[3] = {v[RED] / color_scale, v[GREEN] / color_scale, v[BLUE] / color_scale};
        NEED(iso_tf_curve_add_color(&curves.color, x, rgb, c->file->path, err));
        if (c->has[OPACITY])
            NEED(iso_tf_curve_add_opacity(&curves.opacity, x, v[OPACITY] / opacity_scale, c->file->path, err));
    }
    return iso_tf_take_curves(c->file, &curves, tf, err);
}

static iso_status load_csv(const iso_tf_file *file, iso_tf *tf, iso_error *err)
{
    FREED double(*rows)[ROLES] = calloc(MOST_ROWS, sizeof *rows);
    csv c = {.file = file, .row = rows};
    NEED_MEMORY(rows, err, "%s: out of memory", file->path);
    NEED(read_lines(&c, err));
    return c.own ? take_own(&c, tf, err) : take_display_colors(&c, tf, err);
}

/* ---- writing ----------------------------------------------------------------------------------------------------- */

static void write_rows(FILE *file, const iso_tf_table *t, double unit_mm)
{
    for (size_t i = 0; i < t->count; ++i) {
        const float *e = t->entries + 4 * i;
        const double values[] = {t->lo + (t->hi - t->lo) * (double)i / (double)(t->count - 1),
                                 e[0],
                                 e[1],
                                 e[2],
                                 e[3],
                                 -expm1(-(double)e[3] * unit_mm)};
        for (int c = 0; c < 6; ++c)
            fprintf(file, "%s%.9g", c ? "," : "", values[c]);
        fputc('\n', file);
    }
}

static iso_status save_csv(const iso_tf_output *output, const char *path, iso_error *err)
{
    const iso_tf_table *table = output->table;
    const double unit_mm = output->unit_mm;
    FREED char *text = NULL;
    size_t size = 0;
    FILE *memory = open_memstream(&text, &size);
    NEED_MEMORY(memory, err, "out of memory");
    fprintf(memory, "value,r_linear,g_linear,b_linear,extinction_per_mm,opacity_of_%.9g_mm\n", unit_mm);
    write_rows(memory, table, unit_mm);
    fclose(memory);
    return iso_file_write(path, text, size, err);
}

const iso_tf_format iso_tf_format_csv = {
    .name = "csv",
    .summary = "one line per entry: value, linear color, extinction, opacity; also reads display colors",
    .suffix = ".csv",
    .load = load_csv,
    .save = save_csv,
};

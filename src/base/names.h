/* SPDX-License-Identifier: MIT */
/* names.h - tables whose rows have a name: one lookup, and one way to list them.
 *
 * A table is an array of rows, of any type, with the members `name` and, if
 * people should read a description, `summary`; or an array of pointers to such
 * rows; or of the names alone.
 *
 *     static const struct { const char *name, *summary; } filters[] = {{"mean", "means of 2x2x2 voxels"}, ...};
 *     const iso_names iso_scalar_filter_names = ISO_NAMES_OF_ROWS("scalar filter", filters);
 *
 * Messages, --help, `isoshade list` and doc/reference/names.md are made from the table, so
 * that a row is written once. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

#include "base/status.h"

typedef struct iso_names {
    const char *what;   /* name of a row, in messages: "direction code" */
    const char *plural; /* the same for headings: "direction codes" */
    const void *rows;
    size_t count, stride;       /* bytes from one row to the next */
    size_t name_at, summary_at; /* offsets of both in a row; ISO_NAMES_NO_SUMMARY */
    bool by_pointer;            /* the array holds pointers to the rows */
} iso_names;

#define ISO_NAMES_NO_SUMMARY ((size_t)-1)
#define ISO_NAMES_COUNT(array) (sizeof(array) / sizeof((array)[0]))
/* clang-format off */
#define ISO_NAMES_OF_ROWS(what, array) ISO_NAMES_OF_ROWS_CALLED(what, what "s", array)
/* Describes a table whose plural is not the name with an s. */
#define ISO_NAMES_OF_ROWS_CALLED(what, plural, array)                                       \
    {what, plural, array, ISO_NAMES_COUNT(array), sizeof((array)[0]), offsetof(__typeof__((array)[0]), name), \
     offsetof(__typeof__((array)[0]), summary), false}
/* clang-format on */
/* Describes a table of rows without a summary. */
/* clang-format off */
#define ISO_NAMES_OF_NAMES(what, array)                                                     \
    {what, what "s", array, ISO_NAMES_COUNT(array), sizeof((array)[0]), offsetof(__typeof__((array)[0]), name), ISO_NAMES_NO_SUMMARY, false}
#define ISO_NAMES_OF_POINTERS(what, array)                                                  \
    {what, what "s", array, ISO_NAMES_COUNT(array), sizeof((array)[0]), offsetof(__typeof__(*(array)[0]), name), \
     offsetof(__typeof__(*(array)[0]), summary), true}
/* clang-format on */
#define ISO_NAMES_OF_STRINGS(what, array) \
    { \
        what, what "s", array, ISO_NAMES_COUNT(array), sizeof((array)[0]), 0, ISO_NAMES_NO_SUMMARY, false \
    }

const char *iso_names_name(const iso_names *names, size_t row);
/* Returns a row's summary. NULL if the table has none. */
const char *iso_names_summary(const iso_names *names, size_t row);

/* Finds the row that is called `name`. ISO_E_USAGE: unknown WHAT "NAME", must be one of: all names. */
iso_status iso_names_find(const iso_names *names, const char *name, size_t *row, iso_error *err);

/* Writes "a, b or c" into text, which it returns, cut if it does not fit. last: "or"; NULL for "a, b, c". */
char *iso_names_join(const iso_names *names, const char *last, char *text, size_t size);

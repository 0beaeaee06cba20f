/* SPDX-License-Identifier: MIT */
/* json.h - reads and writes JSON files with jansson. Errors name the file and the
 * key; files are written completely or not at all.
 *
 * An iso_json_reader remembers the first error, so that a file is read key by key
 * with a single test at the end. */
#pragma once

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>

#include "base/status.h"

/* Parses a text that is an object. path: name for messages. ISO_E_FORMAT with line and column. */
iso_status iso_json_parse(const char *path, const char *text, size_t size, json_t **root, iso_error *err);
/* Loads an object. ISO_E_IO, or ISO_E_FORMAT with line and column. */
iso_status iso_json_load(const char *path, json_t **root, iso_error *err);

/* Returns the text of a value, to be freed; NULL: out of memory. Each real has as few of 9 to 17 digits as give the
 * double within 4 epsilon, or the same float if it is one. flags: of json_dumps(), JSON_INDENT() or JSON_COMPACT. */
char *iso_json_text(const json_t *root, size_t flags);

/* Writes iso_json_text() with an indent of 2 and a newline, keys in order of insertion. */
iso_status iso_json_save(const char *path, const json_t *root, iso_error *err);

typedef struct iso_json_reader {
    const char *path;
    iso_status status; /* the first failure */
    iso_error *err;
} iso_json_reader;

/* Reads a number. required: a missing key is an error; otherwise *value stays unchanged. The number must be finite
 * and lie in [lo, hi]; the message names file, key, value and limit. */
void iso_json_get_number(iso_json_reader *r, const json_t *object, const char *key, bool required, double lo, double hi,
                         double *value);
void iso_json_get_size(iso_json_reader *r, const json_t *object, const char *key, bool required, size_t lo, size_t hi,
                       size_t *value);
/* An array of `count` numbers, each in [lo, hi]. */
typedef struct iso_json_list {
    double *values;
    size_t count;
    double lo, hi;
} iso_json_list;
void iso_json_get_numbers(iso_json_reader *r, const json_t *object, const char *key, bool required,
                          const iso_json_list *list);
void iso_json_get_bool(iso_json_reader *r, const json_t *object, const char *key, bool required, bool *value);
/* Reads a string, borrowed from the object. */
void iso_json_get_string(iso_json_reader *r, const json_t *object, const char *key, bool required, const char **value);
/* Reads a word of a NULL-terminated list; *index: its position. */
void iso_json_get_word(iso_json_reader *r, const json_t *object, const char *key, bool required,
                       const char *const words[], int *index);
/* Return an object or array, borrowed; NULL if absent and not required. */
json_t *iso_json_get_object(iso_json_reader *r, const json_t *object, const char *key, bool required);
json_t *iso_json_get_array(iso_json_reader *r, const json_t *object, const char *key, bool required);
/* Refuses control characters in all texts of a value, at any depth: some texts reach scripts and terminals. key: the
 * name of the value. */
void iso_json_check_texts(iso_json_reader *r, const char *key, const json_t *value);
/* Refuses keys that are not in the NULL-terminated list: a misspelt option must not be ignored. */
void iso_json_only_keys(iso_json_reader *r, const json_t *object, const char *where, const char *const keys[]);
/* Refuses an object without one of the keys: the message has all that are missing, and the example. */
void iso_json_need_keys(iso_json_reader *r, const json_t *object, const char *where, const char *const keys[],
                        const char *example);

/* Returns a number, or null for NaN and infinities, which JSON lacks. */
json_t *iso_json_number(double value);
/* Returns the array [a, b, c ...]. */
json_t *iso_json_numbers(const double *values, size_t count);

/* SPDX-License-Identifier: MIT */
#include "base/json.h"

#include <ctype.h>
#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/names.h"
#include "base/words.h"

iso_status iso_json_parse(const char *path, const char *text, size_t size, json_t **root, iso_error *err)
{
    json_error_t where;
    const size_t mark = size >= 3 && memcmp(text, "\xef\xbb\xbf", 3) == 0 ? 3 : 0; /* the byte order mark of editors */
    *root = json_loadb(text + mark, size - mark, JSON_REJECT_DUPLICATES, &where);
    if (!*root)
        return iso_fail(err, ISO_E_FORMAT, "%s:%d:%d: not JSON: %s", path, where.line, where.column, where.text);
    if (!json_is_object(*root)) {
        json_decref(*root);
        *root = NULL;
        return iso_fail(err, ISO_E_FORMAT, "%s: holds no JSON object", path);
    }
    return ISO_OK;
}

iso_status iso_json_load(const char *path, json_t **root, iso_error *err)
{
    FREED char *text = NULL;
    size_t size;
    *root = NULL;
    NEED(iso_file_read(path, &text, &size, err));
    return iso_json_parse(path, text, size, root, err);
}

/* True if a number reads back as the value. Computed values are off by some last places: 6.5 stands for
 * 6.500000000000001. For values that are floats a float is enough: 0.1f stays short. */
static bool comes_back(const char *number, double value)
{
    return fabs(strtod(number, NULL) - value) <= 4 * DBL_EPSILON * fabs(value) ||
           ((float)value == value && strtof(number, NULL) == (float)value);
}

/* Writes a number of `length` characters by the fewest digits with which it comes back, in its place. Returns the new
 * length. */
static size_t shorten_number(char *number, size_t length)
{
    enum { LEAST_DIGITS = 9, MOST_DIGITS = 17 };
    char shorter[40];
    const double value = strtod(number, NULL);
    for (int digits = LEAST_DIGITS; digits < MOST_DIGITS; ++digits) {
        int n = snprintf(shorter, sizeof shorter, "%.*g", digits, value);
        if (!comes_back(shorter, value))
            continue;
        if (!strpbrk(shorter, ".e"))
            n += snprintf(shorter + n, sizeof shorter - (size_t)n, ".0"); /* else it would be read as an integer */
        if ((size_t)n >= length)
            break;
        memcpy(number, shorter, (size_t)n);
        return (size_t)n;
    }
    return length;
}

/* Returns the length of a string with its quotes. */
static size_t string_length(const char *text)
{
    size_t n = 1;
    while (text[n] != '"')
        n += text[n] == '\\' ? 2 : 1;
    return n + 1;
}

/* Shortens the real numbers of a JSON text in place. */
static void shorten_numbers(char *text)
{
    char *to = text;
    while (*text) {
        const size_t number = strspn(text, "+-.0123456789eE");
        const size_t n = *text == '"'                                    ? string_length(text)
                         : isdigit((unsigned char)*text) || *text == '-' ? number
                                                                         : 1;
        memmove(to, text, n);
        const bool is_real = n > 1 && *to != '"' && memchr(to, '.', n);
        text += n;
        char after = to[n];
        to[n] = 0;
        const size_t length = is_real ? shorten_number(to, n) : n;
        to[n] = after;
        to += length;
    }
    *to = 0;
}

char *iso_json_text(const json_t *root, size_t flags)
{
    char *text = json_dumps(root, flags | JSON_REAL_PRECISION(17));
    if (text)
        shorten_numbers(text);
    return text;
}

iso_status iso_json_save(const char *path, const json_t *root, iso_error *err)
{
    FREED char *text = iso_json_text(root, JSON_INDENT(2));
    NEED_MEMORY(text, err, "%s: no memory for its JSON text", path);
    size_t size = strlen(text);
    text[size] = '\n'; /* the file ends with a newline; the terminating 0 is not written */
    return iso_file_write(path, text, size + 1, err);
}

static void fail(iso_json_reader *r, const char *key, const char *what)
{
    r->status = iso_fail(r->err, ISO_E_FORMAT, "%s: \"%s\": %s", r->path, key, what);
}

static json_t *find(iso_json_reader *r, const json_t *object, const char *key, bool required)
{
    if (r->status != ISO_OK)
        return NULL;
    json_t *value = json_object_get(object, key);
    if (!value && required)
        fail(r, key, "is missing");
    return value;
}

static void take_number(iso_json_reader *r, const char *key, const json_t *item, double lo, double hi, double *value)
{
    if (!json_is_number(item)) {
        fail(r, key, "is not a number");
        return;
    }
    double number = json_number_value(item);
    if (!(number >= lo && number <= hi))
        r->status = iso_fail(r->err, ISO_E_RANGE, "%s: \"%s\" is %g, must be %g to %g", r->path, key, number, lo, hi);
    else
        *value = number;
}

void iso_json_get_number(iso_json_reader *r, const json_t *object, const char *key, bool required, double lo, double hi,
                         double *value)
{
    json_t *item = find(r, object, key, required);
    if (item)
        take_number(r, key, item, lo, hi, value);
}

void iso_json_get_size(iso_json_reader *r, const json_t *object, const char *key, bool required, size_t lo, size_t hi,
                       size_t *value)
{
    json_t *item = find(r, object, key, required);
    if (!item)
        return;
    double number = 0;
    if (!json_is_integer(item))
        fail(r, key, "is not a whole number");
    else
        take_number(r, key, item, (double)lo, (double)hi, &number);
    if (r->status == ISO_OK)
        *value = (size_t)number;
}

void iso_json_get_numbers(iso_json_reader *r, const json_t *object, const char *key, bool required,
                          const iso_json_list *list)
{
    json_t *item = find(r, object, key, required);
    if (!item)
        return;
    if (!json_is_array(item) || json_array_size(item) != list->count) {
        r->status = iso_fail(r->err, ISO_E_FORMAT, "%s: \"%s\": is not a list of %zu numbers", r->path, key,
                             list->count);
        return;
    }
    for (size_t i = 0; i < list->count && r->status == ISO_OK; ++i)
        take_number(r, key, json_array_get(item, i), list->lo, list->hi, &list->values[i]);
}

void iso_json_get_bool(iso_json_reader *r, const json_t *object, const char *key, bool required, bool *value)
{
    json_t *item = find(r, object, key, required);
    if (!item)
        return;
    if (!json_is_boolean(item))
        fail(r, key, "is neither true nor false");
    else
        *value = json_is_true(item);
}

void iso_json_get_string(iso_json_reader *r, const json_t *object, const char *key, bool required, const char **value)
{
    json_t *item = find(r, object, key, required);
    if (!item)
        return;
    if (!json_is_string(item))
        fail(r, key, "is not a string");
    else
        iso_json_check_texts(r, key, item);
    if (r->status == ISO_OK)
        *value = json_string_value(item);
}

void iso_json_get_word(iso_json_reader *r, const json_t *object, const char *key, bool required,
                       const char *const words[], int *index)
{
    const char *word = NULL;
    iso_json_get_string(r, object, key, required, &word);
    if (!word)
        return;
    iso_names names = {"word", "words", words, 0, sizeof words[0], 0, ISO_NAMES_NO_SUMMARY, false};
    for (; words[names.count]; ++names.count)
        if (strcmp(words[names.count], word) == 0) {
            *index = (int)names.count;
            return;
        }
    char list[256];
    r->status = iso_fail(r->err, ISO_E_FORMAT, "%s: \"%s\" is \"%s\", must be one of: %s", r->path, key, word,
                         iso_names_join(&names, NULL, list, sizeof list));
}

json_t *iso_json_get_object(iso_json_reader *r, const json_t *object, const char *key, bool required)
{
    json_t *item = find(r, object, key, required);
    if (item && !json_is_object(item)) {
        fail(r, key, "is not an object");
        return NULL;
    }
    return item;
}

json_t *iso_json_get_array(iso_json_reader *r, const json_t *object, const char *key, bool required)
{
    json_t *item = find(r, object, key, required);
    if (item && !json_is_array(item)) {
        fail(r, key, "is not a list");
        return NULL;
    }
    return item;
}

void iso_json_check_texts(iso_json_reader *r, const char *key, const json_t *value)
{
    const char *inner;
    json_t *item;
    size_t i;
    if (json_is_string(value) && iso_words_has_control(json_string_value(value)))
        fail(r, key, "holds a control character, such as a line feed");
    json_object_foreach ((json_t *)value, inner, item)
        if (r->status == ISO_OK)
            iso_json_check_texts(r, inner, item);
    json_array_foreach (value, i, item)
        if (r->status == ISO_OK)
            iso_json_check_texts(r, key, item);
}

void iso_json_only_keys(iso_json_reader *r, const json_t *object, const char *where, const char *const keys[])
{
    const char *key;
    json_t *value;
    if (r->status != ISO_OK)
        return;
    json_object_foreach ((json_t *)object, key, value) {
        bool known = false;
        for (int i = 0; keys[i] && !known; ++i)
            known = strcmp(keys[i], key) == 0;
        if (!known) {
            iso_names names = {"key", "keys", keys, 0, sizeof keys[0], 0, ISO_NAMES_NO_SUMMARY, false};
            while (keys[names.count])
                ++names.count;
            char list[512];
            r->status = iso_fail(r->err, ISO_E_FORMAT, "%s: unknown key \"%s\" in %s, must be one of: %s", r->path, key,
                                 where, iso_names_join(&names, NULL, list, sizeof list));
            return;
        }
    }
}

void iso_json_need_keys(iso_json_reader *r, const json_t *object, const char *where, const char *const keys[],
                        const char *example)
{
    char list[256] = "";
    size_t used = 0;
    for (int i = 0; keys[i] && r->status == ISO_OK; ++i)
        if (!json_object_get(object, keys[i]) && used < sizeof list)
            used += (size_t)snprintf(list + used, sizeof list - used, "%s\"%s\"", used ? ", " : "", keys[i]);
    if (used)
        r->status = iso_fail(r->err, ISO_E_FORMAT, "%s: %s lacks %s; an example: %s", r->path, where, list, example);
}

json_t *iso_json_number(double value)
{
    return isfinite(value) ? json_real(value) : json_null();
}

json_t *iso_json_numbers(const double *values, size_t count)
{
    json_t *list = json_array();
    for (size_t i = 0; i < count; ++i)
        json_array_append_new(list, iso_json_number(values[i]));
    return list;
}

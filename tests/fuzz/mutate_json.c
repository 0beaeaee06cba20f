/* SPDX-License-Identifier: MIT */
/* mutate_json.c - changes of values, members and elements of a JSON text, in the text itself: to make a tree of it for
 * each change, and a text of that again, took three quarters of the time of a reader of scenes. */
#define _GNU_SOURCE
#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/fuzz/mutate.h"

enum { MOST_NODES = 4096, MOST_DEPTH = 100, MOST_TEXT = 1 << 13 };

/* A value that hangs in an object or an array, by its place in the text. */
typedef struct node {
    size_t member, key_size; /* where its key begins, with its quotes; in an array where itself begins, and 0 */
    size_t from, to;
} node;

typedef struct scan {
    const uint8_t *data;
    size_t end;
    node nodes[MOST_NODES];
    size_t count;
} scan;

static size_t behind_space(const scan *s, size_t at)
{
    while (at < s->end && isspace(s->data[at]))
        ++at;
    return at;
}

/* Behind the quote that ends it; 0: none does. */
static size_t behind_string(const scan *s, size_t at)
{
    for (++at; at < s->end && s->data[at] != '"'; ++at)
        at += s->data[at] == '\\';
    return at < s->end ? at + 1 : 0;
}

static size_t behind_value(scan *s, size_t at, int depth);

/* A member or an element, from its first byte. */
static size_t behind_child(scan *s, size_t at, bool in_object, int depth)
{
    node n = {.member = at};
    if (in_object) {
        if (at >= s->end || s->data[at] != '"' || (at = behind_string(s, at)) == 0)
            return 0;
        n.key_size = at - n.member;
        at = behind_space(s, at);
        if (at >= s->end || s->data[at] != ':')
            return 0;
        at = behind_space(s, at + 1);
    }
    const size_t place = s->count;
    n.from = at;
    s->count += place < MOST_NODES;
    n.to = behind_value(s, at, depth);
    if (place < MOST_NODES)
        s->nodes[place] = n;
    return n.to;
}

static size_t behind_children(scan *s, size_t at, int depth)
{
    const bool in_object = s->data[at] == '{';
    const uint8_t close = in_object ? '}' : ']';
    at = behind_space(s, at + 1);
    if (at < s->end && s->data[at] == close)
        return at + 1;
    while (at < s->end) {
        if ((at = behind_child(s, at, in_object, depth + 1)) == 0)
            return 0;
        at = behind_space(s, at);
        if (at < s->end && s->data[at] == close)
            return at + 1;
        if (at >= s->end || s->data[at] != ',')
            return 0;
        at = behind_space(s, at + 1);
    }
    return 0;
}

/* Behind the value that begins at `at`, whose parts are listed; 0: it is none. */
static size_t behind_value(scan *s, size_t at, int depth)
{
    if (at >= s->end || depth > MOST_DEPTH)
        return 0;
    if (s->data[at] == '"')
        return behind_string(s, at);
    if (s->data[at] == '{' || s->data[at] == '[')
        return behind_children(s, at, depth);
    const size_t from = at;
    while (at < s->end && (isalnum(s->data[at]) || (s->data[at] && strchr("+-.", s->data[at]))))
        ++at;
    return at > from ? at : 0;
}

/* ---- values ---- */

typedef struct text {
    char bytes[MOST_TEXT];
    size_t size;
} text;

static void put(text *t, const void *bytes, size_t size)
{
    if (size > sizeof t->bytes - t->size)
        return;
    memcpy(t->bytes + t->size, bytes, size);
    t->size += size;
}

static void put_word(text *t, const char *word)
{
    put(t, word, strlen(word));
}

static void put_string(text *t, const uint8_t *bytes, size_t size)
{
    put_word(t, "\"");
    for (size_t i = 0; i < size; ++i) {
        char escaped[8];
        const bool as_is = bytes[i] >= ' ' && bytes[i] != '"' && bytes[i] != '\\';
        const int n = snprintf(escaped, sizeof escaped, as_is ? "%c" : "\\u%04x", bytes[i]);
        put(t, escaped, (size_t)n);
    }
    put_word(t, "\"");
}

static void put_some_string(fuzz_random *random, text *t)
{
    static const char *const strings[] = {"",          "fit", "../x", "/etc/passwd", "a\nb",       "%s%n",
                                          "</script>", "nan", "=1+1", "\xC3\xA9",    "a'b\"c`$(d)"};
    size_t size;
    const uint8_t *word = fuzz_below(random, 2) ? fuzz_some_word(random, &size) : NULL;
    if (!word) {
        word = (const uint8_t *)strings[fuzz_below(random, sizeof strings / sizeof *strings)];
        size = strlen((const char *)word);
    }
    put_string(t, word, size);
}

/* With a point or an exponent, so that it is no integer; what JSON cannot say is a number that is too large. */
static void put_real(text *t, double value)
{
    char digits[40];
    snprintf(digits, sizeof digits, isfinite(value) ? "%.17g" : "1e999", value);
    put_word(t, digits);
    if (!strpbrk(digits, ".e"))
        put_word(t, ".0");
}

static void put_integer(text *t, long long value)
{
    char digits[40];
    snprintf(digits, sizeof digits, "%lld", value);
    put_word(t, digits);
}

static void put_some_number(fuzz_random *random, text *t, double old)
{
    static const double reals[] = {0,     -0.0,  1,     -1,  0.5,       1e-300,    5e-324, 1e308, -1e308, 1e30,
                                   1e-30, 255.5, 65536, 1e9, 0.9999999, 1.0000001, 3,      16384, 16385};
    switch (fuzz_below(random, 5)) {
    case 0: put_integer(t, (long long)fuzz_some_edge(random)); break;
    case 1: put_integer(t, (long long)fuzz_below(random, 64) - 8); break;
    case 2: put_real(t, old * 2); break;
    case 3: put_real(t, -old); break;
    default: put_real(t, reals[fuzz_below(random, sizeof reals / sizeof *reals)]);
    }
}

static void put_copy(const scan *s, const node *of, text *t)
{
    put(t, s->data + of->from, of->to - of->from);
}

static double number_of(const scan *s, const node *n)
{
    char digits[40];
    snprintf(digits, sizeof digits, "%.*s", (int)(n->to - n->from < 39 ? n->to - n->from : 39),
             (const char *)s->data + n->from);
    return strtod(digits, NULL);
}

/* A value in place of another: mostly of the same kind. */
static void put_some_value(fuzz_random *random, const scan *s, const node *at, text *t)
{
    const uint8_t first = s->data[at->from];
    const bool is_number = first == '-' || isdigit(first);
    const node *other = &s->nodes[fuzz_below(random, s->count)];
    switch (fuzz_below(random, 12)) {
    case 6: put_word(t, "null"); break;
    case 7: put_word(t, "[]"); break;
    case 8: put_word(t, "{}"); break;
    case 9: put_some_string(random, t); break;
    case 10: put_some_number(random, t, is_number ? number_of(s, at) : 0); break;
    case 11: put_copy(s, other, t); break;
    default:
        if (is_number)
            put_some_number(random, t, number_of(s, at));
        else if (first == 't' || first == 'f')
            put_word(t, first == 't' ? "false" : "true");
        else if (first == '"')
            put_some_string(random, t);
        else
            put_copy(s, other, t);
    }
}

/* ---- changes ---- */

/* With the comma behind it, or before it where it is the last. */
static size_t take_out(const scan *s, const node *n, uint8_t *data, size_t size, size_t most)
{
    size_t from = n->member, to = behind_space(s, n->to);
    if (to < s->end && data[to] == ',') {
        to = behind_space(s, to + 1);
    } else {
        to = n->to;
        while (from > 0 && isspace(data[from - 1]))
            --from;
        from -= from > 0 && data[from - 1] == ',';
    }
    return fuzz_replace(data, size, most, from, to - from, "", 0);
}

static size_t change_node(fuzz_random *random, const scan *s, uint8_t *data, size_t size, size_t most)
{
    static text t;
    const node *n = &s->nodes[fuzz_below(random, s->count)];
    t.size = 0;
    switch (fuzz_below(random, 10)) {
    case 0: return take_out(s, n, data, size, most);
    case 1: /* twice, in an object by another name */
        if (n->key_size > 0) {
            put_some_string(random, &t);
            put_word(&t, ": ");
        }
        put_copy(s, n, &t);
        put_word(&t, ", ");
        return fuzz_replace(data, size, most, n->member, 0, t.bytes, t.size);
    default:
        put_some_value(random, s, n, &t);
        return fuzz_replace(data, size, most, n->from, n->to - n->from, t.bytes, t.size);
    }
}

/* Where the text begins and ends; false: there is none. */
static bool find_text(scan *s, const uint8_t *data, size_t size, size_t *begin)
{
    const uint8_t *first = data, *next = NULL;
    if (size >= 5 && memcmp(data, "==== ", 5) == 0 && (first = memchr(data, '{', size)))
        next = memmem(first, size - (size_t)(first - data), "\n==== ", 6);
    s->data = data;
    s->end = next ? (size_t)(next - data) : size;
    s->count = 0;
    *begin = first ? behind_space(s, (size_t)(first - data)) : 0;
    return first != NULL;
}

size_t fuzz_mutate_json(fuzz_random *random, uint8_t *data, size_t size, size_t most)
{
    static scan s;
    size_t begin, changed = 0;
    const size_t changes = fuzz_below(random, 4) ? 1 : 2 + fuzz_below(random, 3);
    for (size_t i = 0; i < changes; ++i) {
        if (!find_text(&s, data, size, &begin) || behind_value(&s, begin, 0) == 0 || s.count == 0)
            return changed;
        changed = size = change_node(random, &s, data, size, most);
    }
    return changed;
}

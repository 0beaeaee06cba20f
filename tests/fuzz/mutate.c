/* SPDX-License-Identifier: MIT */
/* mutate.c - one change of an input: of its bytes, its numbers and lines, or the values of its JSON text. */
#define _GNU_SOURCE
#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/fuzz/mutate.h"

uint64_t fuzz_next(fuzz_random *random) /* splitmix64 */
{
    uint64_t z = random->state += 0x9E3779B97F4A7C15u;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return z ^ (z >> 31);
}

size_t fuzz_below(fuzz_random *random, size_t count)
{
    return count ? (size_t)(fuzz_next(random) % count) : 0;
}

/* ---- words of dictionaries ---- */

enum { MOST_WORDS = 512 };
static struct {
    uint8_t *bytes;
    size_t size;
} words[MOST_WORDS];
static size_t word_count;

static int digit(char c)
{
    return isdigit((unsigned char)c) ? c - '0' : tolower((unsigned char)c) - 'a' + 10;
}

/* The text between the quotes, \xNN, \\ and \" in it. */
static size_t unescape(const char *text, uint8_t *out)
{
    size_t n = 0;
    for (; *text && *text != '"'; ++text) {
        if (text[0] == '\\' && text[1] == 'x' && isxdigit((unsigned char)text[2]) && isxdigit((unsigned char)text[3])) {
            out[n++] = (uint8_t)(16 * digit(text[2]) + digit(text[3]));
            text += 3;
        } else {
            text += *text == '\\' && text[1];
            out[n++] = (uint8_t)*text;
        }
    }
    return n;
}

void fuzz_read_words(const char *path)
{
    char line[1024];
    FILE *f = fopen(path, "r");
    while (f && fgets(line, sizeof line, f) && word_count < MOST_WORDS) {
        const char *quote = strchr(line, '"');
        if (line[0] == '#' || !quote)
            continue;
        words[word_count].bytes = malloc(strlen(quote) + 1);
        words[word_count].size = unescape(quote + 1, words[word_count].bytes);
        ++word_count;
    }
    if (f)
        fclose(f);
}

const uint8_t *fuzz_some_word(fuzz_random *random, size_t *size)
{
    if (word_count == 0)
        return NULL;
    const size_t w = fuzz_below(random, word_count);
    *size = words[w].size;
    return words[w].bytes;
}

/* ---- bytes ---- */

size_t fuzz_replace(uint8_t *data, size_t size, size_t most, size_t at, size_t count, const void *with, size_t length)
{
    if (size - count + length > most)
        return size;
    memmove(data + at + length, data + at + count, size - at - count);
    memcpy(data + at, with, length);
    return size - count + length;
}

static size_t change_block(fuzz_random *random, uint8_t *data, size_t size, size_t most)
{
    uint8_t block[256];
    const size_t from = fuzz_below(random, size), length = fuzz_below(random, 64) + 1,
                 n = length < size - from ? length : size - from, to = fuzz_below(random, size + 1);
    memcpy(block, data + from, n);
    switch (fuzz_below(random, 3)) {
    case 0: return fuzz_replace(data, size, most, from, n, "", 0);
    case 1: return fuzz_replace(data, size, most, to, 0, block, n);
    default: return fuzz_replace(data, size, most, to, n < size - to ? n : size - to, block, n);
    }
}

static const uint64_t edges[] = {0,
                                 1,
                                 2,
                                 3,
                                 7,
                                 8,
                                 16,
                                 31,
                                 32,
                                 63,
                                 64,
                                 127,
                                 128,
                                 255,
                                 256,
                                 1023,
                                 1024,
                                 4095,
                                 4096,
                                 32767,
                                 32768,
                                 65535,
                                 65536,
                                 1u << 24,
                                 0x7FFFFFFF,
                                 0x80000000,
                                 0xFFFFFFFF,
                                 (uint64_t)1 << 32,
                                 0x7F800000,
                                 0x7FC00000,
                                 0x7FF0000000000000,
                                 0x7FFFFFFFFFFFFFFF,
                                 0x8000000000000000,
                                 UINT64_MAX};

uint64_t fuzz_some_edge(fuzz_random *random)
{
    return edges[fuzz_below(random, sizeof edges / sizeof *edges)];
}

/* A number of 1 to 8 bytes, in either order: an edge, or a little more or less than it was. */
static size_t change_number(fuzz_random *random, uint8_t *data, size_t size)
{
    const size_t width = (size_t)1 << fuzz_below(random, 4);
    if (size < width)
        return size;
    const bool big = fuzz_below(random, 2);
    uint8_t *at = data + fuzz_below(random, size - width + 1);
    uint64_t value = 0;
    for (size_t i = 0; i < width; ++i)
        value |= (uint64_t)at[big ? width - 1 - i : i] << (8 * i);
    if (fuzz_below(random, 2))
        value = fuzz_some_edge(random);
    else
        value += fuzz_below(random, 33) - 16;
    for (size_t i = 0; i < width; ++i)
        at[big ? width - 1 - i : i] = (uint8_t)(value >> (8 * i));
    return size;
}

static size_t change_bytes(fuzz_random *random, uint8_t *data, size_t size, size_t most)
{
    if (size == 0)
        return fuzz_replace(data, 0, most, 0, 0, "0", 1);
    switch (fuzz_below(random, 8)) {
    case 0: data[fuzz_below(random, size)] ^= (uint8_t)(1u << fuzz_below(random, 8)); return size;
    case 1: data[fuzz_below(random, size)] = (uint8_t)fuzz_next(random); return size;
    case 2:
    case 3:
    case 4: return change_number(random, data, size);
    case 5: return fuzz_below(random, 8) ? change_block(random, data, size, most) : fuzz_below(random, size);
    case 6:
        if (word_count > 0) {
            const size_t w = fuzz_below(random, word_count), at = fuzz_below(random, size + 1), n = words[w].size,
                         over = fuzz_below(random, 2) ? 0
                                : n < size - at       ? n
                                                      : size - at;
            return fuzz_replace(data, size, most, at, over, words[w].bytes, n);
        }
        return change_block(random, data, size, most);
    default: return change_block(random, data, size, most);
    }
}

/* ---- numbers and lines ---- */

static const char *const numbers[] = {"0",
                                      "1",
                                      "-1",
                                      "2",
                                      "0.5",
                                      "1e-300",
                                      "1e308",
                                      "-1e308",
                                      "1e999",
                                      "nan",
                                      "inf",
                                      "-inf",
                                      "255",
                                      "256",
                                      "65535",
                                      "65536",
                                      "16777217",
                                      "2147483647",
                                      "2147483648",
                                      "4294967295",
                                      "4294967296",
                                      "9223372036854775807",
                                      "9223372036854775808",
                                      "18446744073709551616",
                                      "99999999999999999999999",
                                      "1e-45",
                                      "0x10",
                                      "007",
                                      "+3",
                                      "1e5",
                                      "3.0000000000000001"};

static const char *some_number(fuzz_random *random)
{
    return numbers[fuzz_below(random, sizeof numbers / sizeof *numbers)];
}

/* The digits around a place, or the next ones. */
static bool find_digits(fuzz_random *random, const uint8_t *data, size_t size, size_t *at, size_t *count)
{
    size_t from = fuzz_below(random, size);
    while (from < size && !isdigit(data[from]))
        ++from;
    if (from == size)
        return false;
    size_t to = from;
    while (to < size && (isalnum(data[to]) || data[to] == '.' || data[to] == '+' || data[to] == '-'))
        ++to;
    while (from > 0 && (isalnum(data[from - 1]) || data[from - 1] == '.' || data[from - 1] == '-'))
        --from;
    *at = from, *count = to - from;
    return true;
}

static size_t change_digits(fuzz_random *random, uint8_t *data, size_t size, size_t most)
{
    size_t at, count;
    char text[40];
    if (size == 0 || !find_digits(random, data, size, &at, &count))
        return change_bytes(random, data, size, most);
    if (fuzz_below(random, 2)) {
        const char *number = some_number(random);
        return fuzz_replace(data, size, most, at, count, number, strlen(number));
    }
    snprintf(text, sizeof text, "%.*s", count < 30 ? (int)count : 30, (const char *)data + at);
    const long long value = strtoll(text, NULL, 10) & 0xFFFFFFFFFFFF;
    const int n = snprintf(text, sizeof text, "%lld", value + (long long)fuzz_below(random, 5) - 2);
    return fuzz_replace(data, size, most, at, count, text, (size_t)n);
}

static size_t change_line(fuzz_random *random, uint8_t *data, size_t size, size_t most)
{
    if (size == 0)
        return size;
    size_t from = fuzz_below(random, size);
    while (from > 0 && data[from - 1] != '\n')
        --from;
    const uint8_t *end = memchr(data + from, '\n', size - from);
    const size_t length = end ? (size_t)(end - (data + from)) + 1 : size - from;
    uint8_t line[1024];
    if (length > sizeof line)
        return change_bytes(random, data, size, most);
    memcpy(line, data + from, length);
    switch (fuzz_below(random, 4)) {
    case 0: return fuzz_replace(data, size, most, from, length, "", 0);
    case 1: return fuzz_replace(data, size, most, from, 0, line, length);
    case 2: { /* behind the next one */
        const size_t smaller = fuzz_replace(data, size, most, from, length, "", 0);
        const uint8_t *next = smaller > from ? memchr(data + from, '\n', smaller - from) : NULL;
        return fuzz_replace(data, smaller, most, next ? (size_t)(next - data) + 1 : smaller, 0, line, length);
    }
    default:
        if (word_count == 0)
            return fuzz_replace(data, size, most, from, length - 1, "", 0);
        const size_t w = fuzz_below(random, word_count);
        return fuzz_replace(data, size, most, from + fuzz_below(random, length), 0, words[w].bytes, words[w].size);
    }
}

/* ---- all ---- */

size_t fuzz_mutate_shape(const fuzz_target *target, fuzz_random *random, uint8_t *data, size_t size, size_t most)
{
    if (target->shape == FUZZ_BYTES || size == 0)
        return 0;
    if (target->shape == FUZZ_JSON && fuzz_below(random, 8)) {
        const size_t changed = fuzz_mutate_json(random, data, size, most);
        if (changed > 0)
            return changed;
    }
    return fuzz_below(random, 3) ? change_digits(random, data, size, most) : change_line(random, data, size, most);
}

size_t fuzz_mutate(const fuzz_target *target, fuzz_random *random, uint8_t *data, size_t size, size_t most)
{
    size_t changed = fuzz_below(random, 4) ? fuzz_mutate_shape(target, random, data, size, most) : 0;
    if (changed == 0)
        changed = change_bytes(random, data, size, most);
    /* Damage that checksums find is tried too, but seldom. */
    if (target->repair && fuzz_below(random, 16))
        target->repair(data, changed);
    return changed;
}

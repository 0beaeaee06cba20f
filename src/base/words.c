/* SPDX-License-Identifier: MIT */
/* words.c - words of command lines and files. */
#include "base/words.h"

#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

void iso_words_append(char *text, size_t size, const char *format, ...)
{
    const size_t used = strlen(text);
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text + used, size - used, format, arguments);
    va_end(arguments);
}

static bool is_plain(const char *word)
{
    return *word &&
           strspn(word, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+=./,:@%") == strlen(word);
}

void iso_words_put_quoted(FILE *f, const char *word)
{
    if (is_plain(word)) {
        fputs(word, f);
        return;
    }
    fputc('\'', f);
    for (const char *c = word; *c; ++c)
        *c == '\'' ? fputs("'\\''", f) : fputc(*c, f);
    fputc('\'', f);
}

/* Reads one or three values separated by x. Returns 0, or -1 if the text is neither. */
static int split_three(const char *text, double out[3])
{
    int count = 0;
    for (const char *at = text; count < 3; ++count) {
        char *end;
        errno = 0;
        out[count] = strtod(at, &end);
        if (end == at || errno || (*end && *end != 'x'))
            return -1;
        if (!*end) {
            ++count;
            break;
        }
        at = end + 1;
        if (count == 2)
            return -1;
    }
    if (count == 1)
        out[1] = out[2] = out[0];
    return count == 1 || count == 3 ? 0 : -1;
}

iso_status iso_words_parse_numbers(const char *text, const char *option, double out[3], iso_error *err)
{
    if (split_three(text, out) != 0 || !isfinite(out[0]) || !isfinite(out[1]) || !isfinite(out[2]))
        return iso_fail(err, ISO_E_USAGE, "%s is \"%s\", must be one number or three such as 1x1x2.5", option, text);
    return ISO_OK;
}

iso_status iso_words_parse_sizes(const char *text, const char *option, size_t out[3], iso_error *err)
{
    double values[3];
    if (split_three(text, values) != 0)
        return iso_fail(err, ISO_E_USAGE, "%s is \"%s\", must be one size or three such as 40x56x33", option, text);
    for (int a = 0; a < 3; ++a) {
        if (!(values[a] >= 1 && values[a] <= 1048576) || values[a] != floor(values[a]))
            return iso_fail(err, ISO_E_USAGE, "%s is \"%s\", each size must be a whole number, 1 to 1048576", option,
                            text);
        out[a] = (size_t)values[a];
    }
    return ISO_OK;
}

double iso_words_read_quotient(const char *text, char **end)
{
    double above = strtod(text, end);
    if (*end == text || **end != '/')
        return above;
    const char *rest = *end + 1;
    char *rest_end;
    double below = strtod(rest, &rest_end);
    *end = rest_end == rest ? (char *)text : rest_end;
    return above / below;
}

iso_status iso_words_parse_error(const char *option, const char *text, double *error, iso_error *err)
{
    char *end;
    *error = iso_words_read_quotient(text, &end);
    if (end == text || *end || !(*error > 0 && *error <= 1))
        return iso_fail(err, ISO_E_USAGE, "%s is \"%s\", must be an error above 0 and at most 1, such as 1/255", option,
                        text);
    return ISO_OK;
}

iso_status iso_words_check_range(const char *option, double value, double lo, double hi, iso_error *err)
{
    if (!(value >= lo && value <= hi))
        return iso_fail(err, ISO_E_USAGE, "%s is %g, must be %g to %g", option, value, lo, hi);
    return ISO_OK;
}

/* Returns the number of letters to change, add, drop or swap: restricted Damerau-Levenshtein. */
static size_t count_edits(const char *a, const char *b)
{
    enum { LONGEST = 40 };
    const size_t m = strlen(a), n = strlen(b);
    size_t rows[LONGEST + 1][LONGEST + 1];
    if (m > LONGEST || n > LONGEST)
        return LONGEST;
    for (size_t i = 0; i <= m; ++i)
        for (size_t j = 0; j <= n; ++j) {
            if (i == 0 || j == 0) {
                rows[i][j] = i + j;
                continue;
            }
            const size_t one_side = 1 + (rows[i - 1][j] < rows[i][j - 1] ? rows[i - 1][j] : rows[i][j - 1]);
            const size_t both = rows[i - 1][j - 1] + (a[i - 1] != b[j - 1]);
            rows[i][j] = one_side < both ? one_side : both;
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] && rows[i - 2][j - 2] + 1 < rows[i][j])
                rows[i][j] = rows[i - 2][j - 2] + 1;
        }
    return rows[m][n];
}

void iso_guess_try(iso_guess *guess, const char *word, const char *name)
{
    const size_t edits = count_edits(word, name);
    if (edits <= 1 + strlen(word) / 4 && edits < strlen(name) && (!guess->name || edits < guess->edits))
        *guess = (iso_guess){name, edits};
}

const char *iso_guess_text(const iso_guess *guess, const char *prefix, char text[80])
{
    text[0] = '\0';
    if (guess->name)
        snprintf(text, 80, " (did you mean %s%s?)", prefix, guess->name);
    return text;
}

const char *iso_words_plural(size_t count)
{
    return count == 1 ? "" : "s";
}

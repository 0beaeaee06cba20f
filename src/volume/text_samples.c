/* SPDX-License-Identifier: MIT */
/* text_samples.c - samples that are written as decimals, all at once. */
#define _GNU_SOURCE
#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "volume/stream_kernel.h"

enum { WORD_BYTES = 64 };

/* Inserts the letter that Fortran omits before an exponent of three digits: 1.5-101. Returns the number of letters. */
static size_t put_exponent_letter(char *word)
{
    char *sign = strchr(word, '.');
    sign += sign ? 1 + strspn(sign + 1, "0123456789") : 0;
    if (!sign || (*sign != '-' && *sign != '+') || strspn(sign + 1, "0123456789") != 3 || sign[4])
        return 0;
    memmove(sign + 1, sign, strlen(sign) + 1);
    *sign = 'e';
    return 1;
}

/* Reads a word up to a space, or up to a sign that begins the next number: Fortran's columns of fixed width run
 * together, as in -1.5E-101-2.5E-101, 1.5-101-2.5-101 and 1.5-2.5. Returns the character after it. */
static int read_word(FILE *f, int c, char *word, size_t *length)
{
    size_t n = 0, sign = 0; /* of an exponent, or of the next number */
    bool has_letter = false;
    for (; c != EOF && !isspace(c) && n + 1 < WORD_BYTES; c = getc_unlocked(f)) {
        const bool is_inner_sign = (c == '-' || c == '+') && n > 0 && (isdigit(word[n - 1]) || word[n - 1] == '.');
        if (is_inner_sign && (has_letter || sign > 0))
            break;
        if (c == '.' && sign > 0 && !has_letter) {
            fseeko(f, -(off_t)(n + 1 - sign), SEEK_CUR);
            n = sign, c = getc_unlocked(f);
            break;
        }
        sign = is_inner_sign ? n : sign;
        has_letter = has_letter || tolower(c) == 'e' || tolower(c) == 'd';
        word[n++] = (char)(tolower(c) == 'd' ? 'e' : c);
    }
    word[n] = 0;
    *length = n;
    return c;
}

/* Reads the next number. Returns NULL, or the fault in it. Fortran writes 1.0D-3, too. */
static const char *next_number(FILE *f, double *value)
{
    char word[WORD_BYTES + 1], *end;
    size_t n;
    int c;
    while (isspace(c = getc_unlocked(f)))
        ;
    c = read_word(f, c, word, &n);
    const bool runs_on = c == '-' || c == '+';
    if (runs_on)
        ungetc(c, f);
    n += put_exponent_letter(word);
    *value = strtod(word, &end);
    const bool is_number = n > 0 && end == word + n;
    return c != EOF && !isspace(c) && !runs_on ? "a word of more than 63 letters"
           : is_number             ? NULL
           : c == EOF              ? "truncated"
                                   : "no number";
}

/* Refuses more values than the sizes need: then the sizes are wrong. The file keeps its position. */
static iso_status check_end(const iso_volume_source *source, FILE *f, size_t count, bool words_follow, iso_error *err)
{
    const off_t at = ftello(f);
    int c;
    while (isspace(c = getc_unlocked(f)))
        ;
    if (c != EOF)
        ungetc(c, f);
    double value;
    if (c == EOF || (words_follow && next_number(f, &value)))
        return fseeko(f, at, SEEK_SET) == 0 ? ISO_OK : iso_fail(err, ISO_E_IO, "%s: cannot be read", source->path);
    return iso_fail(err, ISO_E_FORMAT, "%s: too long: more follows the %zu numbers that the sizes need", source->path,
                    count);
}

/* Stores a value, cut to an integer for an integer type; false if it is beyond the type, as C does not define that
 * conversion. */
static bool store(char *data, iso_type type, size_t at, double value)
{
/* clang-format off */
#define ISO_STORE_CASE(name, text, ctype)                                                                        \
    case name: {                                                                                                 \
        const bool is_integer = (ctype)0.5 == 0, is_signed = (ctype)-1 < (ctype)1;                                      \
        const double room = ldexp(1, 8 * (int)sizeof(ctype) - is_signed), lowest = is_signed ? -room : 0;        \
        if (is_integer && !(value > lowest - 1 && value < room))                                                 \
            return false;                                                                                        \
        ((ctype *)(void *)data)[at] = (ctype)value;                                                              \
        return true;                                                                                             \
    }
    switch (type) {
        ISO_TYPE_LIST(ISO_STORE_CASE)
    }
#undef ISO_STORE_CASE
    /* clang-format on */
    return false;
}

iso_status iso_source_take_text(iso_volume_source *source, FILE *f, iso_text_layout layout, iso_error *err)
{
    const size_t *n = source->header.geometry.size, sample = iso_type_bytes(source->header.type),
                 count = iso_source_bytes(source) / sample, inside = source->choice.inside_count;
    source->form = source->form ? ISO_FORM_WHOLE : ISO_FORM_TYPE; /* integers of 64 bits, too, are stored as doubles */
    const off_t at = ftello(f);
    const bool sized = at >= 0 && fseeko(f, 0, SEEK_END) == 0;
    const double bytes = sized ? (double)(ftello(f) - at) : 0;
    /* The shortest number is a digit and a space: refuse before the memory is taken. */
    if (!sized || fseeko(f, at, SEEK_SET) != 0 || 2.0 * (double)count > bytes + 2)
        return iso_fail(err, ISO_E_FORMAT, "%s: truncated: %.0f bytes of text cannot hold %zu numbers", source->path,
                        bytes, count);
    source->preloaded = malloc(iso_source_bytes(source));
    NEED_MEMORY(source->preloaded, err, "%s: no memory for %zu samples", source->path, count);
    for (size_t i = 0; i < count; ++i) {
        double value;
        const char *wrong = next_number(f, &value);
        if (wrong)
            return iso_fail(err, ISO_E_FORMAT, "%s: %s after %zu of %zu numbers", source->path, wrong, i, count);
        const size_t v = i / inside, z = v % n[2], y = v / n[2] % n[1], x = v / n[2] / n[1],
                     turned = ((z * n[1] + y) * n[0] + x) * inside + i % inside;
        if (!store(source->preloaded, source->header.type, layout.z_fastest ? turned : i, value))
            return iso_fail(err, ISO_E_FORMAT, "%s: sample %zu is %g, which no %s can be", source->path, i, value,
                            iso_type_name(source->header.type));
    }
    return layout.anything_follows ? ISO_OK : check_end(source, f, count, layout.words_follow, err);
}

/* SPDX-License-Identifier: MIT */
#include "base/control.h"

size_t iso_words_control(const char *text)
{
    const unsigned char first = (unsigned char)text[0];
    if (first == 0xC2)
        return (unsigned char)text[1] >= 0x80 && (unsigned char)text[1] <= 0x9F ? 2 : 0;
    return first && (first < ' ' || first == 127) ? 1 : 0;
}

bool iso_words_has_control(const char *text)
{
    while (*text && iso_words_control(text) == 0)
        ++text;
    return *text != 0;
}

void iso_words_copy_line(const char *text, char *line, size_t size)
{
    size_t n = 0;
    while (*text && n + 1 < size) {
        const size_t control = iso_words_control(text);
        line[n++] = control ? ' ' : *text;
        text += control ? control : 1;
    }
    line[n] = 0;
}

void iso_words_put_line(FILE *f, const char *text)
{
    while (*text) {
        const size_t control = iso_words_control(text);
        fputc(control ? ' ' : *text, f);
        text += control ? control : 1;
    }
}

void iso_words_make_printable(char *text)
{
    for (; *text; ++text)
        if (*text < ' ' || *text > '~')
            *text = *text == '\t' ? ' ' : '?';
}

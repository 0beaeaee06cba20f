/* SPDX-License-Identifier: MIT */
#include "base/markup.h"

#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "base/json.h"
#include "base/words.h"

/* Returns how many bytes of the text were taken. */
static size_t put_other(FILE *f, const char *c)
{
    const size_t control = *c == '\n' || *c == '\t' ? 0 : iso_words_control(c);
    fputc(control ? ' ' : *c, f);
    return control ? control : 1;
}

void iso_markup_put(FILE *f, const char *text)
{
    for (const char *c = text; c && *c; ++c)
        switch (*c) {
        case '&': fputs("&amp;", f); break;
        case '<': fputs("&lt;", f); break;
        case '>': fputs("&gt;", f); break;
        case '"': fputs("&quot;", f); break;
        case '\'': fputs("&#39;", f); break;
        default: c += put_other(f, c) - 1;
        }
}

void iso_markup_fill(FILE *f, void (*put)(FILE *f, const char *text), const char *form, ...)
{
    va_list texts;
    va_start(texts, form);
    for (; *form; ++form)
        if (*form == '%')
            put(f, va_arg(texts, const char *));
        else
            fputc(*form, f);
    va_end(texts);
}

void iso_markup_fill_marks(FILE *f, const char *form, iso_markup_putter put, const void *user)
{
    const char *at = form;
    for (const char *mark; (mark = strchr(at, '@'));) {
        char name[16];
        const int length = (int)strcspn(mark + 1, "@");
        snprintf(name, sizeof name, "%.*s", length, mark + 1);
        fwrite(at, 1, (size_t)(mark - at), f);
        put(f, name, user);
        at = mark + 1 + length + 1;
    }
    fputs(at, f);
}

void iso_markup_put_json(FILE *f, const json_t *value)
{
    FREED char *s = iso_json_text(value, JSON_COMPACT);
    for (const char *c = s; c && *c; ++c)
        *c == '<' ? fputs("\\u003c", f) : fputc(*c, f);
}

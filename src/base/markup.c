/* SPDX-License-Identifier: MIT */
#include "base/markup.h"

#include <stdlib.h>

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

void iso_markup_put_json(FILE *f, const json_t *value)
{
    FREED char *s = iso_json_text(value, JSON_COMPACT);
    for (const char *c = s; c && *c; ++c)
        *c == '<' ? fputs("\\u003c", f) : fputc(*c, f);
}

/* SPDX-License-Identifier: MIT */
#include "base/markup.h"

void iso_markup_put(FILE *f, const char *text)
{
    for (const char *c = text; c && *c; ++c)
        switch (*c) {
        case '&': fputs("&amp;", f); break;
        case '<': fputs("&lt;", f); break;
        case '>': fputs("&gt;", f); break;
        case '"': fputs("&quot;", f); break;
        case '\'': fputs("&#39;", f); break;
        default: fputc((unsigned char)*c < ' ' && *c != '\n' && *c != '\t' ? ' ' : *c, f);
        }
}

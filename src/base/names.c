/* SPDX-License-Identifier: MIT */
#include "base/names.h"

#include <stdio.h>
#include <string.h>

#include "base/words.h"

static const char *text_at(const iso_names *names, size_t row, size_t at)
{
    const char *entry = (const char *)names->rows + row * names->stride;
    if (names->by_pointer)
        entry = *(const char *const *)(const void *)entry;
    return *(const char *const *)(const void *)(entry + at);
}

const char *iso_names_name(const iso_names *names, size_t row)
{
    return text_at(names, row, names->name_at);
}

const char *iso_names_summary(const iso_names *names, size_t row)
{
    return names->summary_at == ISO_NAMES_NO_SUMMARY ? NULL : text_at(names, row, names->summary_at);
}

iso_status iso_names_find(const iso_names *names, const char *name, size_t *row, iso_error *err)
{
    char known[512], text[80];
    iso_guess guess = {0};
    for (size_t i = 0; i < names->count; ++i)
        if (strcmp(iso_names_name(names, i), name) == 0) {
            *row = i;
            return ISO_OK;
        }
    for (size_t i = 0; err && i < names->count; ++i)
        iso_guess_try(&guess, name, iso_names_name(names, i));
    return iso_fail(err, ISO_E_USAGE, "unknown %s \"%s\"%s, must be one of: %s", names->what, name,
                    iso_guess_text(&guess, "", text), iso_names_join(names, NULL, known, sizeof known));
}

char *iso_names_join(const iso_names *names, const char *last, char *text, size_t size)
{
    size_t length = 0;
    text[0] = '\0';
    for (size_t i = 0; i < names->count && length < size; ++i) {
        const bool ends = last && i > 0 && i + 1 == names->count;
        const int added = snprintf(text + length, size - length, "%s%s%s%s",
                                   ends ? " "
                                   : i  ? ", "
                                        : "",
                                   ends ? last : "", ends ? " " : "", iso_names_name(names, i));
        length += added > 0 ? (size_t)added : 0;
    }
    return text;
}

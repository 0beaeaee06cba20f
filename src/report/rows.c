/* SPDX-License-Identifier: MIT */
#include "report/rows.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

static const struct {
    const char *word;
    int doubt;
} verdicts[] = {
#define ISO_VERDICT_ROW(name, word, doubt) [name] = {word, doubt},
    ISO_VERDICT_LIST(ISO_VERDICT_ROW)
#undef ISO_VERDICT_ROW
};

static const struct {
    const char *word, *said;
} comparisons[ISO_COMPARISON_COUNT] = {
#define ISO_COMPARISON_ROW(name, word, said) [name] = {word, said},
    ISO_COMPARISON_LIST(ISO_COMPARISON_ROW)
#undef ISO_COMPARISON_ROW
};

const char *iso_verdict_word(iso_verdict verdict)
{
    return verdicts[verdict].word;
}

int iso_verdict_doubt(iso_verdict verdict)
{
    return verdicts[verdict].doubt;
}

iso_verdict iso_verdict_from(const json_t *word)
{
    const char *text = json_string_value(word);
    for (int i = 0; text && i < ISO_VERDICT_UNKNOWN; ++i)
        if (strcmp(text, verdicts[i].word) == 0)
            return (iso_verdict)i;
    return ISO_VERDICT_UNKNOWN;
}

iso_verdict iso_row_verdict(const json_t *row)
{
    return iso_verdict_from(json_object_get(row, "verdict"));
}

const char *iso_comparison_word(iso_comparison comparison)
{
    return comparisons[comparison].word;
}

const char *iso_row_text(const json_t *row, const char *key)
{
    const char *s = json_string_value(json_object_get(row, key));
    return s ? s : "";
}

double iso_row_number(const json_t *row, const char *key)
{
    const json_t *value = json_object_get(row, key);
    return json_is_number(value) ? json_number_value(value) : NAN;
}

static iso_comparison comparison_from(const char *word, iso_comparison otherwise)
{
    for (int i = 0; i < ISO_COMPARISON_COUNT; ++i)
        if (strcmp(word, comparisons[i].word) == 0)
            return (iso_comparison)i;
    return otherwise;
}

/* The next part of a name, up to ", "; *at goes behind it, NULL at the end. */
static void take_part(const char **at, char *part, size_t size)
{
    const char *end = *at ? strstr(*at, ", ") : NULL;
    snprintf(part, size, "%.*s", *at ? (int)(end ? end - *at : (long)strlen(*at)) : 0, *at ? *at : "");
    *at = end ? end + 2 : NULL;
}

/* Rows of older reports have a name alone: "gl", "gl, limit", "gl, exact lookups", "gl, naive, adapted TF". */
static iso_row_identity take_name_apart(const json_t *row)
{
    iso_row_identity id;
    const char *at = iso_row_text(row, "b"), *rest;
    char part[sizeof id.variant];
    take_part(&at, id.renderer, sizeof id.renderer);
    rest = at;
    take_part(&at, part, sizeof part);
    /* Rows that are not named after how they were compared have it as their tier. */
    id.comparison = comparison_from(iso_row_text(row, "tier"), ISO_COMPARISON_LOCK_STEP);
    for (int i = 0; i < ISO_COMPARISON_COUNT; ++i)
        if (comparisons[i].said[0] && strcmp(part, comparisons[i].said) == 0) {
            id.comparison = (iso_comparison)i;
            rest = at;
        }
    snprintf(id.variant, sizeof id.variant, "%s", rest ? rest : "");
    return id;
}

iso_row_identity iso_row_identify(const json_t *row)
{
    iso_row_identity id;
    if (!json_is_string(json_object_get(row, "renderer")))
        return take_name_apart(row);
    snprintf(id.renderer, sizeof id.renderer, "%s", iso_row_text(row, "renderer"));
    snprintf(id.variant, sizeof id.variant, "%s", iso_row_text(row, "variant"));
    id.comparison = comparison_from(iso_row_text(row, "comparison"), ISO_COMPARISON_LOCK_STEP);
    return id;
}

void iso_row_name(const char *renderer, iso_comparison comparison, const char *variant, char name[ISO_ROW_NAME_BYTES])
{
    const char *said = comparisons[comparison].said;
    snprintf(name, ISO_ROW_NAME_BYTES, "%s%s%s%s%s", renderer, said[0] ? ", " : "", said, variant[0] ? ", " : "",
             variant);
}

void iso_row_name_of(const json_t *row, char name[ISO_ROW_NAME_BYTES])
{
    const iso_row_identity id = iso_row_identify(row);
    iso_row_name(id.renderer, id.comparison, id.variant, name);
}

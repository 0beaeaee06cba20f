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

static const struct {
    const char *word, *one, *several;
} reasons[ISO_UNCOMPARED_COUNT] = {
#define ISO_UNCOMPARED_ROW(name, word, one, several) [name] = {word, one, several},
    ISO_UNCOMPARED_LIST(ISO_UNCOMPARED_ROW)
#undef ISO_UNCOMPARED_ROW
};

const char *iso_uncompared_word(iso_uncompared reason)
{
    return reasons[reason].word;
}

const char *iso_uncompared_text(iso_uncompared reason, size_t count)
{
    return count == 1 ? reasons[reason].one : reasons[reason].several;
}

iso_uncompared iso_row_uncompared(const json_t *row)
{
    const char *word = iso_row_text(row, "not_compared");
    for (int i = 0; i < ISO_UNCOMPARED_COUNT; ++i)
        if (strcmp(word, reasons[i].word) == 0)
            return (iso_uncompared)i;
    return ISO_UNCOMPARED_NOT;
}

/* The scenes so far, by their names: whether anything was compared or could have been, and of each renderer whether
 * a row was compared (true) or all were too faint or too late (false). */
typedef struct scenes_seen {
    json_t *compared, *asked, *renderers;
} scenes_seen;

static void note_row(scenes_seen *seen, const json_t *row)
{
    const char *scene = iso_row_text(row, "scene");
    const iso_verdict verdict = iso_row_verdict(row);
    const iso_row_identity id = iso_row_identify(row);
    const bool compared = verdict == ISO_VERDICT_AGREE || verdict == ISO_VERDICT_DIFFER,
               faint = verdict == ISO_VERDICT_NOT_COMPARED &&
                       (iso_row_uncompared(row) == ISO_UNCOMPARED_FAINT ||
                        (iso_row_uncompared(row) == ISO_UNCOMPARED_BUDGET && *iso_row_text(row, "renderer")));
    json_t *renderers = json_object_get(seen->renderers, scene);
    if (!renderers) {
        renderers = json_object();
        json_object_set_new(seen->renderers, scene, renderers);
    }
    if (compared)
        json_object_set_new(seen->compared, scene, json_true());
    if (compared || faint || verdict == ISO_VERDICT_REFUSED)
        json_object_set_new(seen->asked, scene, json_true());
    if (compared || (faint && !json_object_get(renderers, id.renderer)))
        json_object_set_new(renderers, id.renderer, json_boolean(compared));
}

json_t *iso_rows_unanswered(const json_t *rows)
{
    scenes_seen seen = {json_object(), json_object(), json_object()};
    json_t *open = json_object(), *row, *asked, *answered;
    const char *scene, *renderer;
    size_t i;
    json_array_foreach ((json_t *)rows, i, row)
        note_row(&seen, row);
    json_object_foreach (seen.asked, scene, asked) {
        json_auto_t *list = json_array();
        const bool compared = json_object_get(seen.compared, scene);
        json_object_foreach (json_object_get(seen.renderers, scene), renderer, answered)
            if (compared && json_is_false(answered))
                json_array_append_new(list, json_string(renderer));
        if (json_array_size(list) > 0 || !compared)
            json_object_set(open, scene, list);
    }
    if (json_object_size(seen.compared) == 0 && json_object_size(open) == 0)
        json_object_set_new(open, "", json_array());
    json_decref(seen.compared);
    json_decref(seen.asked);
    json_decref(seen.renderers);
    return open;
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

long long iso_row_level(const json_t *row)
{
    return (long long)json_integer_value(json_object_get(row, "level"));
}

double iso_row_number(const json_t *row, const char *key)
{
    const json_t *value = json_object_get(row, key);
    return json_is_number(value) ? json_number_value(value) : NAN;
}

double iso_row_metric(const json_t *row, const char *limit)
{
    return strcmp(limit, "ssim_dissimilarity") == 0 ? 1 - iso_row_number(row, "ssim") : iso_row_number(row, limit);
}

json_t *iso_tolerances_to_json(const iso_tolerances *l)
{
    const struct {
        const char *key;
        double value;
    } all[] = {
        {"rmse", l->rmse},           {"max_abs", l->max_abs},
        {"p99_abs", l->p99_abs},     {"ssim_dissimilarity", l->ssim_dissimilarity},
        {"flip_mean", l->flip_mean},
    };
    json_t *object = json_object();
    for (size_t i = 0; i < sizeof all / sizeof *all; ++i)
        if (all[i].value > 0)
            json_object_set_new(object, all[i].key, json_real(all[i].value));
    return object;
}

static iso_comparison comparison_from(const char *word)
{
    for (int i = 0; i < ISO_COMPARISON_COUNT; ++i)
        if (strcmp(word, comparisons[i].word) == 0)
            return (iso_comparison)i;
    return ISO_COMPARISON_LOCK_STEP;
}

iso_row_identity iso_row_identify(const json_t *row)
{
    iso_row_identity id;
    snprintf(id.renderer, sizeof id.renderer, "%s", iso_row_text(row, "renderer"));
    snprintf(id.variant, sizeof id.variant, "%s", iso_row_text(row, "variant"));
    id.comparison = comparison_from(iso_row_text(row, "comparison"));
    return id;
}

void iso_row_name(const char *renderer, iso_comparison comparison, const char *variant, char name[ISO_ROW_NAME_BYTES])
{
    const char *said = comparisons[comparison].said;
    snprintf(name, ISO_ROW_NAME_BYTES, "%s%s%s%s%s", renderer, renderer[0] && said[0] ? ", " : "", said,
             variant[0] ? ", " : "", variant);
}

void iso_row_name_of(const json_t *row, char name[ISO_ROW_NAME_BYTES])
{
    const iso_row_identity id = iso_row_identify(row);
    iso_row_name(id.renderer, id.comparison, id.variant, name);
}

const char *iso_row_comparison_words(const json_t *row)
{
    const iso_comparison comparison = iso_row_identify(row).comparison;
    if (comparison == ISO_COMPARISON_LIMIT)
        return iso_row_number(json_object_get(row, "statistics"), "seeds") > 1 ? "mean over seeds"
                                                                               : "limit of halved steps";
    if (comparison == ISO_COMPARISON_LOCK_STEP)
        return strstr(iso_row_text(row, "a"), "same samples") ? "same samples" : "";
    return iso_comparison_word(comparison);
}

void iso_row_words_of(const json_t *row, char words[ISO_ROW_NAME_BYTES])
{
    const iso_row_identity id = iso_row_identify(row);
    const char *how = iso_row_comparison_words(row);
    snprintf(words, ISO_ROW_NAME_BYTES, "%s%s%s%s%s", id.renderer, id.renderer[0] && how[0] ? ", " : "", how,
             id.variant[0] ? ", " : "", id.variant);
}

/* SPDX-License-Identifier: MIT */
/* summary.c - the summary of a report: numbers of requested and compared rows, and the sentence. */

#include "base/words.h"
#include "report/report.h"
#include "report/report_files.h"
#include "report/sections.h"

static size_t count_verdicts(const iso_report *r, const char *list, iso_verdict verdict)
{
    size_t i, count = 0;
    json_t *row;
    json_array_foreach (json_object_get(iso_report_json(r), list), i, row)
        count += iso_row_verdict(row) == verdict;
    return count;
}

/* Appends "; not compared: 3 cases that show too little for their limits, 1 stage that did not run". */
static void add_not_compared(iso_report_summary *s)
{
    const char *before = "; not compared: ";
    for (int i = 0; i < ISO_UNCOMPARED_COUNT; ++i)
        if (s->by_reason[i] > 0) {
            iso_words_append(s->sentence, sizeof s->sentence, "%s%zu %s", before, s->by_reason[i],
                             iso_uncompared_text((iso_uncompared)i, s->by_reason[i]));
            before = ", ";
        }
}

/* Adds the first unanswered comparison, and the number of others. */
static void add_unanswered(iso_report_summary *s, json_t *unanswered)
{
    const char *scene, *first_scene = NULL, *first = NULL;
    json_t *renderers;
    json_object_foreach (unanswered, scene, renderers)
        if (!first_scene) {
            first_scene = scene;
            first = json_string_value(json_array_get(renderers, 0));
        }
    iso_words_append(s->sentence, sizeof s->sentence, "nothing was compared%s%s in the scene %s", first ? " of " : "",
                     first ? first : "", first_scene ? first_scene : "");
    if (s->unanswered > 1)
        iso_words_append(s->sentence, sizeof s->sentence, " (and in %zu more case%s)", s->unanswered - 1,
                         iso_words_plural(s->unanswered - 1));
}

/* Begins with the mistakes that explain failed calibrations. */
static void add_mistakes(iso_report_summary *s, json_t *mistakes)
{
    const char *renderer;
    json_t *text;
    json_object_foreach (mistakes, renderer, text)
        iso_words_append(s->sentence, sizeof s->sentence, "%s draws %s. ", renderer, json_string_value(text));
}

/* Adds the reason of the first refused row; others are in the tables. */
static void add_refused(iso_report_summary *s, const json_t *rows)
{
    size_t i;
    json_t *row;
    json_array_foreach (rows, i, row) {
        const char *name = json_string_value(json_object_get(row, "renderer")),
                   *why = json_string_value(json_object_get(row, "why"));
        if (iso_row_verdict(row) != ISO_VERDICT_REFUSED || !name || !why)
            continue;
        iso_words_append(s->sentence, sizeof s->sentence, "%s: %s", name, why);
        return;
    }
    iso_words_append(s->sentence, sizeof s->sentence, "a renderer is missing, failed, or did not pass its calibration");
}

static void write_sentence(iso_report_summary *s, const json_t *rows, json_t *unanswered)
{
    const size_t judged = s->agreed + s->differed + s->refused, asked = judged + s->not_compared;
    if (judged == 0)
        iso_words_append(s->sentence, sizeof s->sentence, "Nothing was compared, so nothing is shown to agree");
    else if (s->good && s->not_compared == 0)
        iso_words_append(s->sentence, sizeof s->sentence, "The renderers agree: %s %zu comparison%s within %s limits",
                         judged == 1 ? "the" : "all", judged, judged == 1 ? " is" : "s are",
                         judged == 1 ? "its" : "their");
    else if (s->good)
        iso_words_append(s->sentence, sizeof s->sentence,
                         "The renderers agree: %zu of %zu requested comparisons %s within %s limits", judged, asked,
                         judged == 1 ? "is" : "are", judged == 1 ? "its" : "their");
    else if (s->differed == 0 && s->refused > 0) {
        iso_words_append(s->sentence, sizeof s->sentence,
                         "%zu comparison%s agree%s; %zu could not be made: ", s->agreed, iso_words_plural(s->agreed),
                         s->agreed == 1 ? "s" : "", s->refused);
        add_refused(s, rows);
    } else if (s->differed == 0 && s->unanswered > 0) {
        iso_words_append(s->sentence, sizeof s->sentence, "%zu comparison%s agree%s, but ", s->agreed,
                         iso_words_plural(s->agreed), s->agreed == 1 ? "s" : "");
        add_unanswered(s, unanswered);
    } else if (s->differed == 0)
        iso_words_append(s->sentence, sizeof s->sentence,
                         "%zu of %zu calibrations failed, though all %zu comparisons agree", s->calibrations_failed,
                         s->calibrations_failed + s->calibrations_passed, judged);
    else {
        iso_words_append(s->sentence, sizeof s->sentence,
                         "The renderers do not all agree: %zu of %zu comparison%s differ%s", s->differed, judged,
                         iso_words_plural(judged), s->differed == 1 ? "s" : "");
        if (s->refused > 0)
            iso_words_append(s->sentence, sizeof s->sentence, ", %zu %s refused", s->refused,
                             s->refused == 1 ? "was" : "were");
    }
    add_not_compared(s);
    iso_words_append(s->sentence, sizeof s->sentence, ".");
}

iso_report_summary iso_report_summarize(const iso_report *r)
{
    iso_report_summary s = {
        .agreed = count_verdicts(r, "agreement", ISO_VERDICT_AGREE),
        .differed = count_verdicts(r, "agreement", ISO_VERDICT_DIFFER),
        .refused = count_verdicts(r, "agreement", ISO_VERDICT_REFUSED),
        .not_compared = count_verdicts(r, "agreement", ISO_VERDICT_NOT_COMPARED),
        .calibrations_passed = count_verdicts(r, "calibration", ISO_VERDICT_PASS),
        .calibrations_failed = count_verdicts(r, "calibration", ISO_VERDICT_FAIL),
    };
    const json_t *rows = json_object_get(iso_report_json(r), "agreement");
    json_t *row, *renderers, *unanswered = iso_rows_unanswered(rows);
    const char *scene;
    size_t i;
    json_array_foreach (rows, i, row)
        if (iso_row_verdict(row) == ISO_VERDICT_NOT_COMPARED)
            ++s.by_reason[iso_row_uncompared(row)];
    json_object_foreach (unanswered, scene, renderers)
        s.unanswered += json_array_size(renderers) > 0 ? json_array_size(renderers) : 1;
    /* If nothing agreed, something differs, was refused, or is unanswered. */
    s.good = s.differed == 0 && s.refused == 0 && s.calibrations_failed == 0 && s.unanswered == 0;
    s.holds = s.good && iso_sections_hold(iso_report_json(r));
    add_mistakes(&s, json_object_get(iso_report_json(r), "mistakes"));
    write_sentence(&s, rows, unanswered);
    json_decref(unanswered);
    return s;
}

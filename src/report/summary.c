/* SPDX-License-Identifier: MIT */
/* summary.c - the summary of a report: numbers of requested and compared rows, and the sentence. */
#include <math.h>
#include <string.h>

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

/* Begins with the refused renderers whose mistake is known: cause and size in one sentence. Returns true if there are
 * any. */
static bool add_mistakes(iso_report_summary *s, const json_t *rows, json_t *mistakes)
{
    static const char calibration[] = "failed its calibration: ";
    const char *renderer;
    json_t *text, *row;
    size_t i;
    json_object_foreach (mistakes, renderer, text) {
        const char *why = "";
        json_array_foreach (rows, i, row)
            if (iso_row_verdict(row) == ISO_VERDICT_REFUSED && strcmp(iso_row_text(row, "renderer"), renderer) == 0 && !*why)
                why = iso_row_text(row, "why");
        why += strncmp(why, calibration, sizeof calibration - 1) == 0 ? sizeof calibration - 1 : 0;
        iso_words_append(s->sentence, sizeof s->sentence, "%s draws %s%s%s. ", renderer, json_string_value(text),
                         *why ? ": " : "", why);
    }
    return json_object_size(mistakes) > 0;
}

/* Begins with the first refused renderer and the reason; others are in the tables. */
static void add_refused(iso_report_summary *s, const json_t *rows)
{
    size_t i;
    json_t *row;
    json_array_foreach (rows, i, row)
        if (iso_row_verdict(row) == ISO_VERDICT_REFUSED && *iso_row_text(row, "renderer") && *iso_row_text(row, "why")) {
            iso_words_append(s->sentence, sizeof s->sentence, "%s: %s. ", iso_row_text(row, "renderer"), iso_row_text(row, "why"));
            return;
        }
    iso_words_append(s->sentence, sizeof s->sentence, "A renderer is missing, failed, or did not pass its calibration. ");
}

static bool is_of_same_picture(const json_t *a, const json_t *b)
{
    static const char *const keys[] = {"renderer", "scene", "level", "variant"};
    for (size_t i = 0; i < sizeof keys / sizeof *keys; ++i) {
        const json_t *x = json_object_get(a, keys[i]), *y = json_object_get(b, keys[i]);
        if ((x || y) && !json_equal(x, y))
            return false;
    }
    return true;
}

/* Returns the verdict of a renderer's other comparison of the same scene and level. */
static iso_verdict verdict_of(const json_t *rows, const json_t *of, const char *comparison)
{
    size_t i;
    json_t *row;
    json_array_foreach (rows, i, row)
        if (is_of_same_picture(row, of) && strcmp(iso_row_text(row, "comparison"), comparison) == 0)
            return iso_row_verdict(row);
    return ISO_VERDICT_NOT_COMPARED;
}

/* Returns the cause that the comparisons of a differing row's renderer show together. */
static const char *cause_of(const json_t *rows, const json_t *row)
{
    const iso_verdict same = verdict_of(rows, row, "lock-step"), limit = verdict_of(rows, row, "limit");
    if (same == ISO_VERDICT_DIFFER && limit == ISO_VERDICT_AGREE)
        return "; with small steps it agrees, so its samples stand elsewhere";
    if (same == ISO_VERDICT_AGREE && limit == ISO_VERDICT_DIFFER)
        return "; with the same samples it agrees, so small steps are the cause";
    if (same == ISO_VERDICT_DIFFER && limit == ISO_VERDICT_DIFFER)
        return "; with small steps it differs, too, so steps are not the cause";
    return "";
}

/* Returns a row's severity; null stands for infinity. */
static double severity_of(const json_t *row)
{
    const json_t *value = json_object_get(row, "severity");
    return json_is_number(value) ? json_number_value(value) : INFINITY;
}

/* Begins with the worst differing row: renderer, size, cause. */
static void add_worst(iso_report_summary *s, const json_t *rows)
{
    const json_t *worst = NULL;
    json_t *row;
    size_t i;
    json_array_foreach (rows, i, row)
        if (iso_row_verdict(row) == ISO_VERDICT_DIFFER && *iso_row_text(row, "renderer") &&
            (!worst || severity_of(row) > severity_of(worst)))
            worst = row;
    if (!worst)
        return;
    const double severity = severity_of(worst), rmse = iso_row_number(worst, "rmse");
    iso_words_append(s->sentence, sizeof s->sentence, "%s differs in %s, level %d: RMSE %.2g", iso_row_text(worst, "renderer"),
                     iso_row_text(worst, "scene"), (int)json_integer_value(json_object_get(worst, "level")), rmse);
    if (isfinite(severity))
        iso_words_append(s->sentence, sizeof s->sentence, ", %.2g times the limit", severity);
    iso_words_append(s->sentence, sizeof s->sentence, "%s. ", cause_of(rows, worst));
}

static void write_sentence(iso_report_summary *s, json_t *unanswered)
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
        iso_words_append(s->sentence, sizeof s->sentence, "%zu comparison%s agree%s; %zu could not be made", s->agreed,
                         iso_words_plural(s->agreed), s->agreed == 1 ? "s" : "", s->refused);
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
    if (!add_mistakes(&s, rows, json_object_get(iso_report_json(r), "mistakes")) && s.refused > 0 && s.differed == 0)
        add_refused(&s, rows);
    add_worst(&s, rows);
    write_sentence(&s, unanswered);
    json_decref(unanswered);
    return s;
}

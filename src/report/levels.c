/* SPDX-License-Identifier: MIT */
#include "report/levels.h"

#include <math.h>
#include <string.h>

#include "base/words.h"

static const struct {
    const char *key, *name;
} figures[ISO_LEVEL_FIGURE_COUNT] = {
#define ISO_LEVEL_FIGURE_ROW(name, key, text) [name] = {key, text},
    ISO_LEVEL_FIGURE_LIST(ISO_LEVEL_FIGURE_ROW)
#undef ISO_LEVEL_FIGURE_ROW
};

/* ---- one level ---- */

static bool within_what_is_asked(const iso_report_level *row, int k)
{
    return isnan(row->asked[k]) || row->value[k] <= row->asked[k];
}

static bool is_larger(const iso_report_level *row, iso_paired p)
{
    return iso_paired_is_larger(p, row->margin);
}

static bool is_smaller(const iso_report_level *row, iso_paired p)
{
    return iso_paired_is_larger((iso_paired){-p.difference, p.half_width}, row->margin);
}

/* True if the pictures are worse in a figure and better in none: figures that contradict each other decide nothing. */
static bool is_worse(const iso_report_level *row, const iso_paired deficit[ISO_LEVEL_FIGURE_COUNT])
{
    bool larger = false, smaller = false;
    for (int k = 0; k < ISO_LEVEL_FIGURE_COUNT; ++k) {
        larger = larger || is_larger(row, deficit[k]);
        smaller = smaller || is_smaller(row, deficit[k]);
    }
    return larger && !smaller;
}

static bool is_as_made(const iso_report_level *row)
{
    return row->scalar_off <= row->scalar_limit && row->direction_off_deg <= row->direction_limit_deg;
}

static bool is_within_bound(const iso_report_level *row)
{
    return row->bound.views == 0 || row->bound.above <= row->margin;
}

static bool is_scaled_right(const iso_report_level *row)
{
    return !row->scale.judged || (row->scale.differing == 0 && row->scale.has_effect);
}

iso_verdict iso_report_level_verdict(const iso_report_level *row)
{
    bool good = is_as_made(row) && !is_worse(row, row->simple.deficit) && is_within_bound(row) && is_scaled_right(row);
    if (!row->shown && is_as_made(row) && is_scaled_right(row))
        return ISO_VERDICT_NOT_COMPARED;
    for (int k = 0; k < ISO_LEVEL_FIGURE_COUNT; ++k)
        good = good && within_what_is_asked(row, k);
    return good ? ISO_VERDICT_AGREE : ISO_VERDICT_DIFFER;
}

static const char *tf_word(bool adapted, bool scaled)
{
    return scaled ? "scaled" : adapted ? "adapted" : "original";
}

static json_t *rival_json(const iso_report_level *row, const iso_report_rival *rival)
{
    json_t *list = json_array();
    for (int k = 0; k < ISO_LEVEL_FIGURE_COUNT; ++k)
        json_array_append_new(list, json_pack("{s:s, s:s, s:o, s:o, s:o, s:b, s:b}", "figure", figures[k].key, "name",
                                              figures[k].name, "value", iso_json_number(rival->value[k]), "difference",
                                              iso_json_number(rival->deficit[k].difference), "half_width",
                                              iso_json_number(rival->deficit[k].half_width), "better",
                                              is_larger(row, rival->deficit[k]), "worse",
                                              is_smaller(row, rival->deficit[k])));
    return json_pack("{s:s, s:s, s:s, s:b, s:o}", "method", rival->method, "tf", tf_word(rival->adapted, false),
                     "option", rival->option, "better", is_worse(row, rival->deficit), "figures", list);
}

static json_t *figures_json(const iso_report_level *row)
{
    json_t *list = json_array();
    for (int k = 0; k < ISO_LEVEL_FIGURE_COUNT; ++k)
        json_array_append_new(list, json_pack("{s:s, s:s, s:o, s:o, s:b}", "figure", figures[k].key, "name",
                                              figures[k].name, "value", iso_json_number(row->value[k]), "asked",
                                              iso_json_number(row->asked[k]), "held", within_what_is_asked(row, k)));
    return list;
}

iso_status iso_report_add_level(iso_report *r, const iso_report_level *row, iso_error *err)
{
    json_t *rivals = json_array(), *rows = json_object_get(iso_report_json(r), "levels");
    for (size_t i = 0; i < row->rival_count; ++i)
        json_array_append_new(rivals, rival_json(row, &row->rivals[i]));
    json_t *o = json_pack("{s:I, s:I, s:s, s:s, s:s, s:f, s:f, s:o, s:o, s:o}", "level", (json_int_t)row->level,
                          "views", (json_int_t)row->views, "method", row->method, "tf",
                          tf_word(row->adapted, row->scaled), "verdict",
                          iso_verdict_word(iso_report_level_verdict(row)), "confidence", row->confidence, "margin",
                          row->margin, "figures", figures_json(row), "simple", rival_json(row, &row->simple), "rivals",
                          rivals);
    json_object_set_new(o, "views_before", json_integer((json_int_t)row->views_before));
    if (row->bound.views > 0)
        json_object_set_new(o, "bound",
                            json_pack("{s:I, s:o, s:o, s:o, s:b}", "views", (json_int_t)row->bound.views, "rmse",
                                      iso_json_number(row->bound.rmse), "bound", iso_json_number(row->bound.bound),
                                      "above", iso_json_number(row->bound.above), "held", is_within_bound(row)));
    if (row->scale.judged)
        json_object_set_new(o, "extinction_scale",
                            json_pack("{s:I, s:I, s:b, s:b}", "scaled_voxels", (json_int_t)row->scale.scaled,
                                      "differing_voxels", (json_int_t)row->scale.differing, "has_effect",
                                      row->scale.has_effect, "held", is_scaled_right(row)));
    if (row->chosen)
        json_object_set_new(o, "chosen_filter", json_string(row->chosen));
    json_object_set_new(o, "simple_held", json_boolean(!is_worse(row, row->simple.deficit)));
    json_object_set_new(o, "directions",
                        json_pack("{s:o, s:o, s:o, s:o}", "angle_deg", iso_json_number(row->angle_deg), "simple_deg",
                                  iso_json_number(row->simple_angle_deg), "difference_deg",
                                  iso_json_number(row->angle_deficit.difference), "half_width_deg",
                                  iso_json_number(row->angle_deficit.half_width)));
    json_object_set_new(o, "stored",
                        json_pack("{s:o, s:f, s:o, s:f, s:b}", "scalar", iso_json_number(row->scalar_off),
                                  "scalar_limit", row->scalar_limit, "direction_deg",
                                  iso_json_number(row->direction_off_deg), "direction_limit_deg",
                                  row->direction_limit_deg, "held", is_as_made(row)));
    return json_array_append_new(rows, o) == 0 ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "report: out of memory");
}

/* ---- all levels ---- */

static bool is_true(const json_t *row, const char *key)
{
    return json_is_true(json_object_get(row, key));
}

/* Appends "naive directions under the adapted TF". */
static void add_way(iso_levels_summary *s, const json_t *way)
{
    const char *method = iso_row_text(way, "method");
    const bool fly = strcmp(method, "on-the-fly") == 0;
    iso_words_append(s->sentence, sizeof s->sentence, "%s%s under the %s TF", fly ? "gradients on the fly" : method,
                     fly ? "" : " directions", iso_row_text(way, "tf"));
}

/* Adds "1-SSIM 0.067 against 0.071, 0.004 +- 0.003 less" for each figure by which the rival is better. */
static void add_better_figures(iso_levels_summary *s, const json_t *rival)
{
    const char *before = "";
    json_t *f;
    size_t i;
    json_array_foreach (json_object_get(rival, "figures"), i, f) {
        const double value = iso_row_number(f, "value"), difference = iso_row_number(f, "difference");
        if (!is_true(f, "better"))
            continue;
        iso_words_append(s->sentence, sizeof s->sentence, "%s%s %.3g against %.3g, %.2g +- %.2g less", before,
                         iso_row_text(f, "name"), value, value + difference, difference,
                         iso_row_number(f, "half_width"));
        before = "; ";
    }
}

/* True if the rival has other stored directions under the same TF, so that the choice of the filter was wrong. */
static bool is_choice_wrong(const json_t *row, const json_t *rival)
{
    return json_object_get(row, "chosen_filter") && strcmp(iso_row_text(rival, "method"), "on-the-fly") != 0 &&
           strcmp(iso_row_text(rival, "tf"), iso_row_text(row, "tf")) == 0;
}

static void add_rival(iso_levels_summary *s, const json_t *row, const json_t *rival)
{
    iso_words_append(s->sentence, sizeof s->sentence, " Level %lld: ", iso_row_level(row));
    if (is_choice_wrong(row, rival))
        iso_words_append(s->sentence, sizeof s->sentence, "auto chose %s, but ", iso_row_text(row, "chosen_filter"));
    add_way(s, rival);
    iso_words_append(s->sentence, sizeof s->sentence, " look more like level 0 (");
    add_better_figures(s, rival);
    iso_words_append(s->sentence, sizeof s->sentence, "): %s.", iso_row_text(rival, "option"));
}

/* Adds the reasons for which a level does not hold. */
static void add_failures(iso_levels_summary *s, const json_t *row)
{
    const long long level = iso_row_level(row);
    const json_t *stored = json_object_get(row, "stored");
    json_t *f;
    size_t i;
    if (!is_true(stored, "held"))
        iso_words_append(
            s->sentence, sizeof s->sentence,
            " Level %lld differs from one made of level 0: values by up to %.2g of their range, directions by %.3g degrees on average.",
            level, iso_row_number(stored, "scalar"), iso_row_number(stored, "direction_deg"));
    json_array_foreach (json_object_get(row, "figures"), i, f)
        if (!is_true(f, "held"))
            iso_words_append(s->sentence, sizeof s->sentence, " Level %lld: %s is %.3g, the limit is %.3g.", level,
                             iso_row_text(f, "name"), iso_row_number(f, "value"), iso_row_number(f, "asked"));
    const json_t *bound = json_object_get(row, "bound");
    if (bound && !is_true(bound, "held"))
        iso_words_append(s->sentence, sizeof s->sentence,
                         " Level %lld: RMSE is above its bound by %.3g in a view: one of the two is wrong.", level,
                         iso_row_number(bound, "above"));
    const json_t *scale = json_object_get(row, "extinction_scale");
    if (scale && iso_row_number(scale, "differing_voxels") > 0)
        iso_words_append(s->sentence, sizeof s->sentence,
                         " Level %lld: its extinction scale differs from one made of level 0, at %.0f voxels.", level,
                         iso_row_number(scale, "differing_voxels"));
    if (scale && !is_true(scale, "has_effect"))
        iso_words_append(s->sentence, sizeof s->sentence,
                         " Level %lld: its extinction scale changes no picture, so it is not used.", level);
    if (!is_true(row, "simple_held"))
        add_rival(s, row, json_object_get(row, "simple"));
}

/* Appends "RMSE, and its bound: 0.039 of 0.21 at level 1, 0.055 of 0.3 at level 2." */
static void add_bounds(iso_levels_summary *s, const json_t *rows)
{
    const char *before = " RMSE, and its bound: ";
    json_t *row;
    size_t i;
    json_array_foreach (rows, i, row) {
        const json_t *bound = json_object_get(row, "bound");
        if (!bound)
            continue;
        iso_words_append(s->sentence, sizeof s->sentence, "%s%.2g of %.2g at level %lld", before,
                         iso_row_number(bound, "rmse"), iso_row_number(bound, "bound"), iso_row_level(row));
        before = ", ";
    }
    if (before[0] == ',')
        iso_words_append(s->sentence, sizeof s->sentence, ".");
}

/* Returns the largest relative improvement of a rival's figures; 0 if it is not better. */
static double advantage(const json_t *rival)
{
    double most = 0;
    json_t *f;
    size_t i;
    if (!is_true(rival, "better"))
        return 0;
    json_array_foreach (json_object_get(rival, "figures"), i, f) {
        const double value = iso_row_number(f, "value"), difference = iso_row_number(f, "difference");
        if (is_true(f, "better"))
            most = fmax(most, difference / fmax(value + difference, 1e-9));
    }
    return most;
}

/* Returns the best rival, or NULL. choices: only filters that auto could have chosen. */
static const json_t *best_rival(const json_t *row, bool choices)
{
    const json_t *best = NULL;
    json_t *rival;
    size_t i;
    json_array_foreach (json_object_get(row, "rivals"), i, rival) {
        if (advantage(rival) > (best ? advantage(best) : 0) && (!choices || is_choice_wrong(row, rival)))
            best = rival;
    }
    return best;
}

/* Counts figures in which another method has the smaller mean, but the interval does not exclude chance. */
static void add_near_ones(iso_levels_summary *s, const json_t *rows)
{
    size_t i, k, r, all = 0, smaller = 0;
    json_t *row, *f, *rival;
    json_array_foreach (rows, i, row)
        json_array_foreach (json_object_get(row, "figures"), k, f) {
            bool is_smaller_there = false;
            json_array_foreach (json_object_get(row, "rivals"), r, rival) {
                const json_t *its = json_array_get(json_object_get(rival, "figures"), k);
                is_smaller_there = is_smaller_there ||
                                   (iso_row_number(its, "difference") > 0 && !is_true(its, "better"));
            }
            ++all;
            smaller += is_smaller_there;
        }
    if (smaller > 0)
        iso_words_append(
            s->sentence, sizeof s->sentence,
            " In %zu of %zu figures another method has the smaller mean, within the scatter over the views.", smaller,
            all);
}

/* Appends "Level 2 was undecided after 6 views: 20 were used." */
static void add_added_views(iso_levels_summary *s, const json_t *rows)
{
    json_t *row;
    size_t i;
    json_array_foreach (rows, i, row) {
        const double views = iso_row_number(row, "views"), before = iso_row_number(row, "views_before");
        if (views > before)
            iso_words_append(s->sentence, sizeof s->sentence,
                             " Level %lld was undecided after %.0f views: %.0f were used.", iso_row_level(row), before,
                             views);
    }
}

static bool is_anything_asked(const json_t *rows)
{
    size_t i, k;
    json_t *row, *f;
    json_array_foreach (rows, i, row)
        json_array_foreach (json_object_get(row, "figures"), k, f)
            if (json_is_number(json_object_get(f, "asked")))
                return true;
    return false;
}

static void write_sentence(iso_levels_summary *s, const json_t *rows)
{
    const json_t *first = json_array_get(rows, 0);
    const size_t count = json_array_size(rows);
    const double views = iso_row_number(first, "views");
    if (s->differed == 0)
        iso_words_append(s->sentence, sizeof s->sentence,
                         "The levels hold: %snone is worse than gradients on the fly under the original TF%s.",
                         is_anything_asked(rows) ? "all are within the scene's limits, and " : "",
                         is_anything_asked(rows) ? "" : " (the scene sets no limits)");
    else
        iso_words_append(s->sentence, sizeof s->sentence, "The levels do not hold: %zu of %zu fail%s.", s->differed,
                         count, s->differed == 1 ? "s" : "");
    size_t i;
    json_t *row;
    json_array_foreach (rows, i, row)
        add_failures(s, row);
    json_array_foreach (rows, i, row) {
        const json_t *best = best_rival(row, false), *choice = best_rival(row, true);
        if (best)
            add_rival(s, row, best);
        if (choice && choice != best)
            add_rival(s, row, choice);
    }
    add_added_views(s, rows);
    add_near_ones(s, rows);
    add_bounds(s, rows);
    if (views < 6)
        iso_words_append(s->sentence, sizeof s->sentence, " Only %.0f views: the confidence intervals are wide.",
                         views);
}

/* Adds the reason for which the stage that judges the levels did not run to its end. */
static void add_stage_reason(iso_levels_summary *s, const json_t *agreement)
{
    const json_t *row;
    size_t i;
    json_array_foreach (agreement, i, row)
        if (iso_row_identify(row).comparison == ISO_COMPARISON_STAGE &&
            strcmp(iso_row_text(row, "variant"), "consistency") == 0)
            iso_words_append(s->sentence, sizeof s->sentence, "The levels were not judged: %s.",
                             iso_row_text(row, "why"));
}

iso_levels_summary iso_levels_summarize(const json_t *report)
{
    const json_t *rows = json_object_get(report, "levels");
    iso_levels_summary s = {0};
    json_t *row;
    size_t i;
    json_array_foreach (rows, i, row) {
        const iso_verdict verdict = iso_row_verdict(row);
        s.agreed += verdict == ISO_VERDICT_AGREE;
        s.not_compared += verdict == ISO_VERDICT_NOT_COMPARED;
        s.differed += verdict != ISO_VERDICT_AGREE && verdict != ISO_VERDICT_NOT_COMPARED;
    }
    if (s.agreed + s.differed > 0)
        write_sentence(&s, rows);
    else if (s.not_compared > 0)
        iso_words_append(s.sentence, sizeof s.sentence,
                         "The levels are not compared: level 0 shows nothing in any view.");
    else
        add_stage_reason(&s, json_object_get(report, "agreement"));
    return s;
}

/* SPDX-License-Identifier: MIT */
/* difference.c - compares rows and facts of two reports. */
#include "report/difference.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/file.h"
#include "report/report.h"
#include "report/sections.h"

/* Two pictures with noise n differ by n sqrt(2) on average over many pixels; few pixels scatter. */
static const double noise_factor = 1.5;
static const double part_of_limit = 0.01, part_of_gate = 0.1, part_of_noisy_gate = 0.5;
static const double rounding = 1e-7;     /* of colors around 1 in float */
static const double level_margin = 1e-3; /* of 1-SSIM, FLIP and RMSE: smaller ones are invisible */
static const double angle_tolerance_deg = 0.1;

static iso_tolerance at_least(iso_tolerance t, double value, const char *why)
{
    return value > t.value ? (iso_tolerance){value, why} : t;
}

/* Returns the smaller of two limits; NaN if there is none. */
static double smaller(double a, double b)
{
    return isnan(a) ? b : isnan(b) ? a : fmin(a, b);
}

/* Returns the noise of a mean over seeds, as RMSE; 0 if there is none. */
static double noise_of(const json_t *row)
{
    const double noise = iso_row_number(json_object_get(row, "statistics"), "noise_bar");
    return noise > 0 ? noise : 0;
}

static double both_noises(const json_t *a, const json_t *b)
{
    return noise_factor * hypot(noise_of(a), noise_of(b));
}

/* Returns the part of a metric that noise explains: all of the RMSE; the largest pixel tolerance for the largest
 * difference; for the others the ratio of noise to RMSE. */
static double noise_in(const json_t *a, const json_t *b, const char *metric)
{
    const double noise = both_noises(a, b), rmse = fmax(iso_row_number(a, "rmse"), iso_row_number(b, "rmse"));
    if (noise == 0 || strcmp(metric, "rmse") == 0)
        return noise;
    if (strcmp(metric, "max_abs") == 0)
        return hypot(iso_row_number(json_object_get(a, "statistics"), "pixel_tolerance_largest"),
                     iso_row_number(json_object_get(b, "statistics"), "pixel_tolerance_largest"));
    return fmin(rmse > 0 ? noise / rmse : 1, 1) * fmax(iso_row_metric(a, metric), iso_row_metric(b, metric));
}

iso_tolerance iso_difference_tolerance(const json_t *a, const json_t *b, const char *metric)
{
    iso_tolerance t = {rounding, "rounding of floats"};
    const double limit = smaller(iso_row_number(json_object_get(a, "limits"), metric),
                                 iso_row_number(json_object_get(b, "limits"), metric));
    t = at_least(t, part_of_limit * limit, "a hundredth of its limit");
    return at_least(t, noise_in(a, b, metric), "the noise of both");
}

/* ---- changes of a row ---- */

/* Two rows of one name, and their changes. */
typedef struct pair {
    const json_t *a, *b;
    json_t *what;
    double factor; /* scales tolerances */
} pair;

static void add_change(const pair *p, const char *what, json_t *a, json_t *b, iso_tolerance t, bool worse)
{
    json_array_append_new(p->what, json_pack("{s:s, s:o, s:o, s:o, s:o, s:b}", "what", what, "a", a, "b", b,
                                             "tolerance", t.why ? json_real(t.value) : json_null(), "why",
                                             t.why ? json_string(t.why) : json_null(), "worse", worse));
}

/* Adds a change of a number. NaN (not measured) equals only itself. The larger magnitude is worse. */
static void compare_numbers(const pair *p, const char *what, double a, double b, iso_tolerance t)
{
    t.value *= p->factor;
    if (!(fabs(a - b) <= t.value) && !(isnan(a) && isnan(b)))
        add_change(p, what, iso_json_number(a), iso_json_number(b), t, !(fabs(b) < fabs(a)) && !isnan(a));
}

/* Adds a change of words, which is neither better nor worse. */
static void compare_texts(const pair *p, const char *what, const char *a, const char *b)
{
    if (strcmp(a, b) != 0)
        add_change(p, what, json_string(a), json_string(b), (iso_tolerance){0}, false);
}

/* Adds a change of verdict. A less certain verdict is worse, even if no error is known. */
static void compare_verdicts(const pair *p)
{
    const char *a = iso_row_text(p->a, "verdict"), *b = iso_row_text(p->b, "verdict");
    const bool worse = iso_verdict_doubt(iso_row_verdict(p->b)) > iso_verdict_doubt(iso_row_verdict(p->a));
    if (strcmp(a, b) != 0)
        add_change(p, "verdict", json_string(a), json_string(b), (iso_tolerance){0}, worse);
}

/* Adds a change of a limit. Stated limits have tolerance 0. */
static void compare_limit(const pair *p, const char *of, double a, double b, double tolerance)
{
    char what[128];
    snprintf(what, sizeof what, "limit of %.100s", of);
    compare_numbers(p, what, a, b, (iso_tolerance){tolerance, tolerance > 0 ? "a tenth of it" : "stated"});
}

/* True unless the limit is the row's own error bar, a measured value, as for the RMSE of extrapolated limits. */
static bool limit_is_stated(const json_t *row, const char *metric)
{
    const iso_comparison how = iso_row_identify(row).comparison;
    return strcmp(metric, "rmse") != 0 || (how != ISO_COMPARISON_LIMIT && how != ISO_COMPARISON_VERSIONS);
}

static void compare_metrics(const pair *p)
{
    static const char *const metrics[] = {"rmse", "max_abs", "p99_abs", "ssim_dissimilarity", "flip_mean"};
    const json_t *a = json_object_get(p->a, "limits"), *b = json_object_get(p->b, "limits");
    for (size_t i = 0; i < sizeof metrics / sizeof *metrics; ++i) {
        const char *metric = metrics[i];
        if (!json_object_get(a, metric) && !json_object_get(b, metric))
            continue;
        compare_numbers(p, metric, iso_row_metric(p->a, metric), iso_row_metric(p->b, metric),
                        iso_difference_tolerance(p->a, p->b, metric));
        if (limit_is_stated(p->b, metric))
            compare_limit(p, metric, iso_row_number(a, metric), iso_row_number(b, metric), 0);
    }
    compare_numbers(p, "nonfinite_count", iso_row_number(p->a, "nonfinite_count"),
                    iso_row_number(p->b, "nonfinite_count"), (iso_tolerance){0, "a count"});
}

static const json_t *gate_of(const json_t *row, const char *key)
{
    size_t i;
    json_t *gate;
    json_array_foreach (json_object_get(row, "gates"), i, gate)
        if (strcmp(iso_row_text(gate, "gate"), key) == 0)
            return gate;
    return NULL;
}

static void compare_gate(const pair *p, const char *key)
{
    const json_t *a = gate_of(p->a, key), *b = gate_of(p->b, key);
    const double limit_a = iso_row_number(a, "limit"), limit_b = iso_row_number(b, "limit"),
                 limit = fabs(smaller(limit_a, limit_b)); /* a damaged file may have a negative one */
    const bool noisy = both_noises(p->a, p->b) > 0;
    compare_numbers(p, iso_row_text(a ? a : b, "name"), iso_row_number(a, "value"), iso_row_number(b, "value"),
                    (iso_tolerance){(noisy ? part_of_noisy_gate : part_of_gate) * limit,
                                    noisy ? "half of its limit, of a row with noise" : "a tenth of its limit"});
    compare_limit(p, iso_row_text(a ? a : b, "name"), limit_a, limit_b, part_of_gate * limit);
}

static void compare_gates(const pair *p)
{
    size_t i;
    json_t *gate;
    json_array_foreach (json_object_get(p->a, "gates"), i, gate)
        compare_gate(p, iso_row_text(gate, "gate"));
    json_array_foreach (json_object_get(p->b, "gates"), i, gate)
        if (!gate_of(p->a, iso_row_text(gate, "gate")))
            compare_gate(p, iso_row_text(gate, "gate"));
}

/* Compares why rows were refused, up to the colon: "missing", "failed its calibration". Figures and paths follow it. */
static void compare_refusals(const pair *p)
{
    char why[2][256] = {"", ""};
    const json_t *const rows[2] = {p->a, p->b};
    for (int i = 0; i < 2; ++i)
        if (iso_row_verdict(rows[i]) == ISO_VERDICT_REFUSED) {
            const char *text = iso_row_text(rows[i], "why");
            snprintf(why[i], sizeof why[i], "%.*s", (int)strcspn(text, ":"), text);
        }
    if (why[0][0] && why[1][0])
        compare_texts(p, "refused", why[0], why[1]);
}

static void compare_agreement(const pair *p)
{
    compare_texts(p, "not compared for", iso_row_text(p->a, "not_compared"), iso_row_text(p->b, "not_compared"));
    compare_texts(p, "tier", iso_row_text(p->a, "tier"), iso_row_text(p->b, "tier"));
    compare_refusals(p);
    compare_metrics(p);
    compare_gates(p);
}

static void compare_calibration(const pair *p)
{
    const double limit_a = iso_row_number(p->a, "limit"), limit_b = iso_row_number(p->b, "limit");
    const double part = part_of_gate * smaller(limit_a, limit_b);
    compare_numbers(p, "value", iso_row_number(p->a, "value"), iso_row_number(p->b, "value"),
                    (iso_tolerance){fmax(part, 0), "a tenth of its limit"});
    compare_limit(p, "value", limit_a, limit_b, 0);
}

/* Compares "held" of a part of a level's row. A part that only one of them has is also a change. */
static void compare_held(const pair *p, const char *part)
{
    static const char *const words[] = {"not judged", "held", "not held"};
    const json_t *const of[2] = {json_object_get(p->a, part), json_object_get(p->b, part)};
    int state[2];
    for (int i = 0; i < 2; ++i) {
        const json_t *held = json_is_object(of[i]) ? json_object_get(of[i], "held") : of[i];
        state[i] = !held || json_is_null(held) ? 0 : json_is_true(held) ? 1 : 2;
    }
    if (state[0] != state[1])
        add_change(p, part, json_string(words[state[0]]), json_string(words[state[1]]), (iso_tolerance){0},
                   state[0] == 1 || state[1] == 2);
}

static void compare_levels(const pair *p)
{
    static const char *const texts[] = {"method", "tf", "chosen_filter"}, *const parts[] = {"simple_held", "stored",
                                                                                            "bound",
                                                                                            "extinction_scale"};
    const json_t *others = json_object_get(p->b, "figures"), *figure, *other;
    size_t i;
    for (i = 0; i < sizeof texts / sizeof *texts; ++i)
        compare_texts(p, texts[i], iso_row_text(p->a, texts[i]), iso_row_text(p->b, texts[i]));
    for (i = 0; i < sizeof parts / sizeof *parts; ++i)
        compare_held(p, parts[i]);
    json_array_foreach (json_object_get(p->a, "figures"), i, figure) {
        other = json_array_get(others, i);
        compare_numbers(p, iso_row_text(figure, "name"), iso_row_number(figure, "value"),
                        iso_row_number(other, "value"), (iso_tolerance){level_margin, "smaller ones are invisible"});
        compare_limit(p, iso_row_text(figure, "name"), iso_row_number(figure, "asked"), iso_row_number(other, "asked"),
                      0);
    }
}

static void compare_consistency(const pair *p)
{
    static const struct {
        const char *key, *name;
        bool is_angle;
    } figures[] = {{"ssim_dissimilarity_mean", "1-SSIM", false},
                   {"flip_mean", "FLIP", false},
                   {"rmse_mean", "RMSE", false},
                   {"gradient_angle_mean_deg", "direction, mean degrees", true},
                   {"gradient_angle_p95_deg", "direction, 95 % degrees", true}};
    for (size_t i = 0; i < sizeof figures / sizeof *figures; ++i)
        compare_numbers(p, figures[i].name, iso_row_number(p->a, figures[i].key), iso_row_number(p->b, figures[i].key),
                        figures[i].is_angle ? (iso_tolerance){angle_tolerance_deg, "a tenth of a degree"}
                                            : (iso_tolerance){level_margin, "smaller ones are invisible"});
    compare_texts(p, "adapting", iso_row_text(p->a, "original_kept")[0] ? "refused" : "not refused",
                  iso_row_text(p->b, "original_kept")[0] ? "refused" : "not refused");
}

/* ---- rows by their names ---- */

enum { NAME_BYTES = 700 };

static void name_agreement(const json_t *row, char name[NAME_BYTES])
{
    char of[ISO_ROW_NAME_BYTES];
    iso_row_name_of(row, of);
    snprintf(name, NAME_BYTES, "%.300s, level %lld: %.180s against %.100s", iso_row_text(row, "scene"),
             iso_row_level(row), of, iso_row_text(row, "a"));
}

static void name_levels(const json_t *row, char name[NAME_BYTES])
{
    snprintf(name, NAME_BYTES, "level %lld", iso_row_level(row));
}

static void name_consistency(const json_t *row, char name[NAME_BYTES])
{
    char method[ISO_CONSISTENCY_NAME_BYTES];
    iso_report_consistency_name(row, method);
    snprintf(name, NAME_BYTES, "level %lld against level 0, %.120s", iso_row_level(row), method);
}

static void name_calibration(const json_t *row, char name[NAME_BYTES])
{
    snprintf(name, NAME_BYTES, "calibration of %.200s: %.300s", iso_row_text(row, "renderer"),
             iso_row_text(row, "check"));
}

static const struct kind {
    const char *list; /* in report.json */
    void (*name)(const json_t *row, char name[NAME_BYTES]);
    void (*compare)(const pair *p);
} kinds[] = {
#define ISO_SECTION_ROW(name, verdicts) {#name, name_##name, compare_##name},
    ISO_SECTION_LIST(ISO_SECTION_ROW)
#undef ISO_SECTION_ROW
};

/* Returns a new object: the rows of a list by their names; the second of a name is called "NAME (2)". */
static json_t *rows_by_name(const json_t *report, const struct kind *kind)
{
    json_t *rows = json_object(), *row;
    size_t i;
    json_array_foreach (json_object_get(report, kind->list), i, row) {
        char name[NAME_BYTES], numbered[NAME_BYTES + 16];
        kind->name(row, name);
        snprintf(numbered, sizeof numbered, "%s", name);
        for (int n = 2; json_object_get(rows, numbered); ++n)
            snprintf(numbered, sizeof numbered, "%s (%d)", name, n);
        json_object_set(rows, numbered, row);
    }
    return rows;
}

static json_t *text_or_null(const json_t *row, const char *key)
{
    const char *text = iso_row_text(row, key);
    return text[0] ? json_string(text) : json_null();
}

/* Keeps the row if it changed. Takes the reference to p->what. */
static bool keep_row(json_t *rows, const struct kind *kind, const char *name, const pair *p)
{
    const json_t *one = p->b ? p->b : p->a;
    const bool changed = !p->a || !p->b || json_array_size(p->what) > 0;
    if (changed)
        json_array_append_new(rows,
                              json_pack("{s:s, s:s, s:s, s:o, s:o, s:o, s:o, s:O, s:o, s:o}", "kind", kind->list,
                                        "name", name, "change",
                                        !p->a   ? "appeared"
                                        : !p->b ? "disappeared"
                                                : "changed",
                                        "verdict_a", text_or_null(p->a, "verdict"), "verdict_b",
                                        text_or_null(p->b, "verdict"), "renderer", text_or_null(one, "renderer"),
                                        "picture", text_or_null(one, "image_b"), "what", p->what, "command_a",
                                        text_or_null(p->a, "command"), "command_b", text_or_null(p->b, "command")));
    json_decref(p->what);
    return changed;
}

/* Compares the rows of one list; returns the number of names in either report. */
static size_t compare_kind(json_t *rows, const struct kind *kind, const json_t *a, const json_t *b, double factor)
{
    json_t *row;
    json_auto_t *in_a = rows_by_name(a, kind), *in_b = rows_by_name(b, kind);
    const char *name;
    size_t count = 0;
    json_object_foreach (in_a, name, row) {
        const pair p = {row, json_object_get(in_b, name), json_array(), factor};
        if (p.b) {
            compare_verdicts(&p);
            kind->compare(&p);
        }
        keep_row(rows, kind, name, &p);
        ++count;
    }
    json_object_foreach (in_b, name, row)
        if (!json_object_get(in_a, name)) {
            const pair p = {NULL, row, json_array(), factor};
            keep_row(rows, kind, name, &p);
            ++count;
        }
    return count;
}

/* Returns the sort key: changed verdicts first, those that became less certain before the others; then rows that
 * disappeared, appeared, and changed figures. */
static int rank_of(const json_t *row)
{
    const char *change = iso_row_text(row, "change");
    if (strcmp(change, "changed") != 0)
        return strcmp(change, "disappeared") == 0 ? 10 : 11;
    const int before = iso_verdict_doubt(iso_verdict_from(json_object_get(row, "verdict_a"))),
              after = iso_verdict_doubt(iso_verdict_from(json_object_get(row, "verdict_b")));
    return before == after ? 12 : 5 + before - after;
}

static void sort_rows(json_t *difference, json_t *rows)
{
    json_t *sorted = json_array(), *row;
    size_t i;
    for (int rank = 0; rank <= 12; ++rank)
        json_array_foreach (rows, i, row)
            if (rank_of(row) == rank)
                json_array_append(sorted, row);
    json_object_set_new(difference, "rows", sorted);
    json_decref(rows);
}

/* ---- facts ---- */

static void add_fact(json_t *facts, const char *fact, json_t *a, json_t *b, bool counts)
{
    if (!(a && b && json_equal(a, b)))
        json_array_append_new(facts, json_pack("{s:s, s:O, s:O, s:b}", "fact", fact, "a", a ? a : json_null(), "b",
                                               b ? b : json_null(), "counts", counts));
}

static void compare_section(json_t *facts, const char *section, const json_t *a, const json_t *b, bool counts)
{
    json_t *both = json_object(), *unused;
    const char *key;
    if (json_is_object(a))
        json_object_update(both, (json_t *)a);
    if (json_is_object(b))
        json_object_update(both, (json_t *)b);
    json_object_foreach (both, key, unused) {
        char fact[400];
        snprintf(fact, sizeof fact, "%.150s: %.200s", section, key);
        add_fact(facts, fact, json_object_get(a, key), json_object_get(b, key), counts);
    }
    json_decref(both);
}

/* Compares the last part of two paths: the folder of a file does not count. */
static void compare_file(json_t *facts, const char *key, const json_t *a, const json_t *b, bool counts)
{
    json_t *names[2] = {json_string(iso_path_base(iso_row_text(a, key))),
                        json_string(iso_path_base(iso_row_text(b, key)))};
    add_fact(facts, key, names[0], names[1], counts);
    json_decref(names[0]);
    json_decref(names[1]);
}

/* Compares the limits of each scene. */
static void compare_asked(json_t *facts, const json_t *a, const json_t *b, bool counts)
{
    const char *scene;
    json_t *asked;
    json_object_foreach ((json_t *)a, scene, asked) {
        char section[200];
        snprintf(section, sizeof section, "asked by %.150s", scene);
        if (json_object_get(b, scene))
            compare_section(facts, section, asked, json_object_get(b, scene), counts);
    }
}

static json_t *facts_of(const json_t *a, const json_t *b, bool counts)
{
    json_t *facts = json_array();
    compare_section(facts, "versions", json_object_get(a, "versions"), json_object_get(b, "versions"), counts);
    compare_section(facts, "options", json_object_get(a, "options"), json_object_get(b, "options"), counts);
    compare_file(facts, "volume", a, b, counts);
    compare_file(facts, "scene", a, b, counts);
    compare_asked(facts, json_object_get(a, "asked"), json_object_get(b, "asked"), counts);
    compare_section(facts, "machine", json_object_get(a, "machine"), json_object_get(b, "machine"), false);
    return facts;
}

static json_t *about(const json_t *report)
{
    json_t *o = json_object();
    static const char *const keys[] = {"title", "made", "command", "verdict", "sentence", "levels_sentence"};
    for (size_t i = 0; i < sizeof keys / sizeof *keys; ++i)
        json_object_set_new(o, keys[i], text_or_null(report, keys[i]));
    return o;
}

iso_status iso_difference_of(const json_t *a, const json_t *b, bool results_only, double factor, json_t **difference,
                             iso_error *err)
{
    const json_t *const reports[2] = {a, b};
    *difference = NULL;
    for (int i = 0; i < 2; ++i) {
        NEED(iso_report_check(reports[i], i ? "report diff: B" : "report diff: A", err));
    }
    json_t *d = json_pack("{s:s, s:o, s:o}", "schema", "isoshade.difference/1", "a", about(a), "b", about(b));
    json_t *rows = json_array();
    size_t count = 0;
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; ++i)
        count += compare_kind(rows, &kinds[i], a, b, factor);
    NEED_MEMORY(d && rows, err, "report diff: out of memory");
    sort_rows(d, rows);
    json_object_set_new(d, "row_count", json_integer((json_int_t)count));
    json_object_set_new(d, "facts", facts_of(a, b, !results_only));
    *difference = d;
    return ISO_OK;
}

size_t iso_difference_count_worse(const json_t *difference)
{
    size_t i, j, count = 0;
    json_t *row, *what;
    json_array_foreach (json_object_get(difference, "rows"), i, row) {
        count += strcmp(iso_row_text(row, "change"), "disappeared") == 0;
        json_array_foreach (json_object_get(row, "what"), j, what)
            count += json_is_true(json_object_get(what, "worse"));
    }
    return count;
}

iso_status iso_difference_accept(const json_t *report, json_t **accepted, iso_error *err)
{
    static const char *const about[] = {"schema", "command", "options", "versions", "volume", "scene", "asked"};
    size_t rows = 0, k;
    json_t *row;
    *accepted = json_object();
    for (size_t i = 0; i < sizeof about / sizeof *about; ++i)
        json_object_set(*accepted, about[i], json_object_get(report, about[i]));
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; ++i) {
        json_t *list = json_deep_copy(json_object_get(report, kinds[i].list));
        json_array_foreach (list, k, row)
            json_object_del(row, "seconds");
        rows += json_array_size(list);
        json_object_set_new(*accepted, kinds[i].list, list);
    }
    if (rows > 0)
        return ISO_OK;
    json_decref(*accepted);
    *accepted = NULL;
    return iso_fail(err, ISO_E_FORMAT, "the report has no rows to compare");
}

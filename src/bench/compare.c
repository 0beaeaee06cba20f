/* SPDX-License-Identifier: MIT */
/* compare.c - two answers of `bench all`: what became slower, beyond the scatter of the runs. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/json.h"
#include "bench/bench.h"
#include "compare/paired.h"

enum { MOST_RUNS = 99 };
static const double CONFIDENCE = 0.95;

typedef enum change { CHANGE_NONE, CHANGE_WORSE, CHANGE_BETTER, CHANGE_UNKNOWN } change;
static const char *const change_words[] = {"", "worse", "better", "not compared"};

/* How many times worse b is than a: above 1 where it is slower or larger. lower, upper: the interval that holds the mean
 * of its logarithm with CONFIDENCE. */
typedef struct row_change {
    double factor, lower, upper;
    change is;
} row_change;

/* Logarithms of the values, so that differences are ratios; turned where more is better. false: one cannot be taken. */
static bool take_logs(const json_t *row, double logs[MOST_RUNS], size_t *count)
{
    const json_t *values = json_object_get(row, "values");
    const double sign = json_is_true(json_object_get(row, "lower_is_better")) ? 1 : -1;
    *count = json_array_size(values);
    if (*count == 0 || *count > MOST_RUNS)
        return false;
    for (size_t i = 0; i < *count; ++i) {
        const json_t *value = json_array_get(values, i);
        if (!json_is_number(value) || !(json_number_value(value) > 0))
            return false;
        logs[i] = sign * log(json_number_value(value));
    }
    return true;
}

static double mean_of(const double *x, size_t count, double *variance)
{
    double mean = 0, squares = 0;
    for (size_t i = 0; i < count; ++i)
        mean += x[i] / (double)count;
    for (size_t i = 0; i < count; ++i)
        squares += (x[i] - mean) * (x[i] - mean);
    *variance = count > 1 ? squares / (double)(count - 1) : INFINITY;
    return mean;
}

/* Of runs that were not taken in turn: Welch's interval, which lets both scatter by themselves. */
static iso_paired compare_apart(const double *b, size_t b_count, const double *a, size_t a_count)
{
    double b_variance, a_variance;
    const double difference = mean_of(b, b_count, &b_variance) - mean_of(a, a_count, &a_variance);
    const double bb = b_variance / (double)b_count, aa = a_variance / (double)a_count, both = aa + bb;
    if (!isfinite(both))
        return (iso_paired){difference, INFINITY};
    if (both == 0)
        return (iso_paired){difference, 0};
    const double freedom = both * both / (aa * aa / (double)(a_count - 1) + bb * bb / (double)(b_count - 1));
    return (iso_paired){difference, iso_student_quantile(CONFIDENCE, freedom) * sqrt(both)};
}

static row_change compare_rows(const json_t *a, const json_t *b, bool in_turn, double slack)
{
    double before[MOST_RUNS], after[MOST_RUNS];
    size_t before_count, after_count;
    if (!take_logs(a, before, &before_count) || !take_logs(b, after, &after_count))
        return (row_change){NAN, NAN, NAN, CHANGE_UNKNOWN};
    iso_paired p = in_turn && before_count == after_count ? iso_paired_compare(after, before, after_count, CONFIDENCE)
                                                          : compare_apart(after, after_count, before, before_count);
    row_change c = {exp(p.difference), exp(p.difference - p.half_width), exp(p.difference + p.half_width), CHANGE_NONE};
    if (isinf(p.half_width))
        c.is = CHANGE_UNKNOWN;
    else if (iso_paired_is_larger(p, log1p(slack)))
        c.is = CHANGE_WORSE;
    p.difference = -p.difference;
    if (c.is == CHANGE_NONE && iso_paired_is_larger(p, log1p(slack)))
        c.is = CHANGE_BETTER;
    return c;
}

static iso_status load_answer(const char *path, json_t **root, iso_error *err)
{
    const char *schema = "";
    iso_status status = iso_json_load(path, root, err);
    if (status != ISO_OK)
        return status;
    iso_json_reader r = {path, ISO_OK, err};
    iso_json_get_string(&r, *root, "schema", true, &schema);
    const json_t *rows = iso_json_get_array(&r, *root, "headlines", false);
    if (r.status == ISO_OK && (strcmp(schema, "isoshade.bench.all/1") != 0 || json_array_size(rows) == 0))
        return iso_fail(err, ISO_E_FORMAT, "%s: not an answer of bench all with figures (schema \"%s\")", path, schema);
    return r.status;
}

static const json_t *find_row(const json_t *root, const char *name)
{
    size_t i;
    const json_t *row;
    json_array_foreach(json_object_get(root, "headlines"), i, row)
    {
        const char *its = json_string_value(json_object_get(row, "name"));
        if (its && strcmp(its, name) == 0)
            return row;
    }
    return NULL;
}

static bool have_equal(const json_t *a, const json_t *b, const char *key)
{
    return json_equal(json_object_get(a, key), json_object_get(b, key));
}

static void report_row(const iso_cli *cli, const char *name, const row_change *c, json_t *rows)
{
    if (!cli->json)
        printf("%-14s %8.3f  %8.3f to %-8.3f %s\n", name, c->factor, c->lower, c->upper, change_words[c->is]);
    json_t *row = json_pack("{s:s, s:s}", "name", name, "change", c->is == CHANGE_NONE ? "none" : change_words[c->is]);
    json_object_set_new(row, "times_worse", iso_json_number(c->factor));
    json_object_set_new(row, "lower", iso_json_number(c->lower));
    json_object_set_new(row, "upper", iso_json_number(c->upper));
    json_array_append_new(rows, row);
}

static iso_status compare_answers(const iso_cli *cli, const json_t *a, const json_t *b, double slack, iso_error *err)
{
    const bool in_turn = have_equal(a, b, "session"), same_machine = have_equal(a, b, "machine");
    size_t i, worse = 0, unknown = 0, compared = 0;
    const json_t *row;
    json_t *rows = json_array();
    if (!cli->json)
        printf("%-14s %8s  %s; %s%s\n", "figure", "factor", "95 % interval",
               in_turn ? "measured in turn" : "measured apart", same_machine ? "" : ", on different machines");
    json_array_foreach(json_object_get(b, "headlines"), i, row)
    {
        const char *name = json_string_value(json_object_get(row, "name"));
        const json_t *before = name ? find_row(a, name) : NULL;
        if (!before || !have_equal(before, row, "command"))
            continue;
        const row_change c = compare_rows(before, row, in_turn, slack);
        report_row(cli, name, &c, rows);
        worse += c.is == CHANGE_WORSE;
        unknown += c.is == CHANGE_UNKNOWN;
        ++compared;
    }
    if (cli->json) {
        json_t *root = iso_cli_json(cli);
        json_object_set_new(root, "measured_in_turn", json_boolean(in_turn));
        json_object_set_new(root, "same_machine", json_boolean(same_machine));
        json_object_set_new(root, "rows", rows);
        iso_cli_print_json(root);
    } else {
        json_decref(rows);
    }
    if (compared == 0 || compared == unknown)
        return iso_fail(err, ISO_E_DIFFERS, "nothing could be compared: no figure of one command, measured twice or more, in both");
    return worse ? iso_fail(err, ISO_E_DIFFERS, "%zu of %zu figures became worse", worse, compared) : ISO_OK;
}

static iso_status run(const iso_command *self, int argc, const char **argv, iso_error *err)
{
    double slack = 0.03;
    struct poptOption options[] = {
        {"slack", 0, POPT_ARG_DOUBLE | POPT_ARGFLAG_SHOW_DEFAULT, &slack, 0, "a change of this part is no matter", "PART"},
        POPT_TABLEEND,
    };
    iso_cli cli;
    iso_cli_next next;
    json_t *a = NULL, *b = NULL;
    iso_status status = iso_cli_parse(&cli, self, argc, argv, options, &next, err);
    const bool goes_on = status == ISO_OK && next == ISO_CLI_RUN;
    if (goes_on)
        status = iso_words_check_range("--slack", slack, 0, 10, err);
    if (goes_on && status == ISO_OK)
        status = load_answer(cli.arguments[0], &a, err);
    if (goes_on && status == ISO_OK)
        status = load_answer(cli.arguments[1], &b, err);
    if (goes_on && status == ISO_OK)
        status = compare_answers(&cli, a, b, slack, err);
    json_decref(a);
    json_decref(b);
    iso_cli_end(&cli);
    return status;
}

const iso_command iso_bench_compare = {
    .name = "bench compare",
    .summary = "two answers of bench all: what became slower, beyond the scatter of the runs; exit 1 then",
    .min_arguments = 2,
    .max_arguments = 2,
    .usage = "BEFORE.json AFTER.json [options]",
    .details =
        "A figure became worse where the interval that holds its mean change at 95 % lies on that side, and the change is more\n"
        "than --slack. Files of one run with --beside are compared run by run, others by Welch's interval. One of forty figures\n"
        "that did not change is flagged so by chance.",
    .examples = "  isoshade bench all --quick --only build-memory --repeat 2 -o a.json\n"
                "  isoshade bench compare a.json a.json\n",
    .run = run,
};

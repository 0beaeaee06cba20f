/* SPDX-License-Identifier: MIT */
/* compare.c - compares two answers of `bench all`: which figures became worse beyond scatter, which are gone. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/json.h"
#include "bench/bench.h"
#include "compare/paired.h"

enum { MOST_RUNS = 99 };
static const double CONFIDENCE = 0.95;

typedef enum change {
    CHANGE_NONE,
    CHANGE_WORSE,
    CHANGE_BETTER,
    CHANGE_UNKNOWN, /* too few runs, or no value before */
    CHANGE_COMMAND, /* another command measured it, so the figures differ in meaning */
    CHANGE_GONE,    /* it had a value before and has none after */
    CHANGE_COUNT
} change;
static const char *const change_words[CHANGE_COUNT] = {"",    "worse", "better", "not compared", "another command",
                                                       "gone"};

/* How many times worse b is than a: above 1 if it is slower or larger. lower, upper: confidence interval of the mean of
 * its logarithm. */
typedef struct row_change {
    double factor, lower, upper;
    change is;
    const char *cause; /* why there is no factor, or NULL */
} row_change;

/* Takes logarithms, so that differences are ratios; negated if higher is better. Returns false if a value has none. */
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

/* Compares runs that were not taken in turn: Welch's interval, with a variance for each. */
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

static row_change compare_values(const json_t *a, const json_t *b, bool in_turn, double slack)
{
    double before[MOST_RUNS], after[MOST_RUNS];
    size_t before_count, after_count;
    if (!take_logs(a, before, &before_count) || !take_logs(b, after, &after_count))
        return (row_change){NAN, NAN, NAN, CHANGE_UNKNOWN, "a value is 0 or less, or there are too many runs"};
    iso_paired p = in_turn && before_count == after_count ? iso_paired_compare(after, before, after_count, CONFIDENCE)
                                                          : compare_apart(after, after_count, before, before_count);
    row_change c = {exp(p.difference), exp(p.difference - p.half_width), exp(p.difference + p.half_width), CHANGE_NONE,
                    NULL};
    if (isinf(p.half_width))
        c.is = CHANGE_UNKNOWN;
    else if (iso_paired_is_larger(p, log1p(slack)))
        c.is = CHANGE_WORSE;
    p.difference = -p.difference;
    if (c.is == CHANGE_NONE && iso_paired_is_larger(p, log1p(slack)))
        c.is = CHANGE_BETTER;
    return c;
}

static bool have_equal(const json_t *a, const json_t *b, const char *key)
{
    const json_t *of_a = json_object_get(a, key), *of_b = json_object_get(b, key);
    return (!of_a && !of_b) || json_equal(of_a, of_b);
}

static bool has_value(const json_t *row)
{
    size_t i;
    const json_t *value, *values = json_object_get(row, "values");
    json_array_foreach (values, i, value)
        if (!json_is_number(value))
            return false;
    return json_array_size(values) > 0;
}

/* Compares two rows. b: NULL if AFTER lacks the figure. */
static row_change compare_rows(const json_t *a, const json_t *b, bool in_turn, double slack)
{
    const bool had = has_value(a), has = has_value(b);
    if (had && has && have_equal(a, b, "command"))
        return compare_values(a, b, in_turn, slack);
    const char *cause = json_string_value(json_object_get(has ? a : b, "cause"));
    row_change c = {NAN, NAN, NAN, had ? CHANGE_GONE : CHANGE_UNKNOWN, cause ? cause : "no value"};
    if (!b)
        c.cause = "missing in AFTER";
    if (had && has) {
        c.is = CHANGE_COMMAND;
        c.cause = json_string_value(json_object_get(b, "command"));
    }
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
    json_array_foreach (json_object_get(root, "headlines"), i, row) {
        const char *its = json_string_value(json_object_get(row, "name"));
        if (its && strcmp(its, name) == 0)
            return row;
    }
    return NULL;
}

/* Writes a factor, at most "100": intervals of few runs have such ends, and larger values mean no more. */
static void write_times(char text[16], double times)
{
    snprintf(text, 16, times <= 100 ? "%.3f" : "-", times);
}

static void print_row(const char *name, const row_change *c)
{
    char factor[16], lower[16], upper[16];
    write_times(factor, c->factor);
    write_times(lower, c->lower);
    write_times(upper, c->upper);
    printf("%-14s %8s  %8s to %-8s %s\n", name, factor, lower, upper, change_words[c->is]);
    if (c->cause)
        printf("%-14s %s\n", "", c->cause);
}

static void report_row(const iso_cli *cli, const char *name, const row_change *c, json_t *rows)
{
    if (!cli->json)
        print_row(name, c);
    json_t *row = json_pack("{s:s, s:s}", "name", name, "change", c->is == CHANGE_NONE ? "none" : change_words[c->is]);
    json_object_set_new(row, "times_worse", iso_json_number(c->factor));
    json_object_set_new(row, "lower", iso_json_number(c->lower));
    json_object_set_new(row, "upper", iso_json_number(c->upper));
    if (c->cause)
        json_object_set_new(row, "cause", json_string(c->cause));
    json_array_append_new(rows, row);
}

/* Settings that are equal in both answers. */
typedef struct shared_settings {
    bool in_turn, machine, threads;
} shared_settings;

static void print_head(const shared_settings *are)
{
    printf("%-14s %8s  %s; %s%s%s\n", "figure", "factor", "95 % interval",
           are->in_turn ? "measured in turn" : "measured apart", are->machine ? "" : ", on different machines",
           are->threads ? "" : ", with other threads");
}

static void print_json(const iso_cli *cli, const shared_settings *are, json_t *rows)
{
    json_t *root = iso_cli_json(cli);
    json_object_set_new(root, "measured_in_turn", json_boolean(are->in_turn));
    json_object_set_new(root, "same_machine", json_boolean(are->machine));
    json_object_set_new(root, "same_threads", json_boolean(are->threads));
    json_object_set_new(root, "rows", rows);
    iso_cli_print_json(root);
}

/* Turns the number of rows per change into a status. */
static iso_status judge(const size_t count[CHANGE_COUNT], iso_error *err)
{
    const size_t compared = count[CHANGE_NONE] + count[CHANGE_WORSE] + count[CHANGE_BETTER];
    char gone[96] = "";
    if (count[CHANGE_GONE] > 0)
        snprintf(gone, sizeof gone, "figures without a value in AFTER: %zu", count[CHANGE_GONE]);
    if (compared == 0)
        return iso_fail(err, ISO_E_DIFFERS,
                        "nothing to compare: no figure has two runs of one command in both files; use --repeat%s%s",
                        gone[0] ? "; " : "", gone);
    if (count[CHANGE_WORSE] > 0)
        return iso_fail(err, ISO_E_DIFFERS, "%zu of %zu figures became worse%s%s", count[CHANGE_WORSE], compared,
                        gone[0] ? "; " : "", gone);
    return gone[0] ? iso_fail(err, ISO_E_DIFFERS, "%s", gone) : ISO_OK;
}

static iso_status compare_answers(const iso_cli *cli, const json_t *a, const json_t *b, double slack, iso_error *err)
{
    const shared_settings are = {have_equal(a, b, "session"), have_equal(a, b, "machine"), have_equal(a, b, "threads")};
    size_t i, count[CHANGE_COUNT] = {0};
    const json_t *row;
    json_t *rows = json_array();
    if (!cli->json)
        print_head(&are);
    json_array_foreach (json_object_get(a, "headlines"), i, row) {
        const char *name = json_string_value(json_object_get(row, "name"));
        if (!name)
            continue;
        const row_change c = compare_rows(row, find_row(b, name), are.in_turn, slack);
        report_row(cli, name, &c, rows);
        ++count[c.is];
    }
    if (cli->json)
        print_json(cli, &are, rows);
    else
        json_decref(rows);
    return judge(count, err);
}

typedef struct compare_options {
    double slack;
} compare_options;

static const iso_option options[] = {
    {"slack", 0, "ignore smaller changes, as a fraction", "PART", ISO_IN(compare_options, slack), .flags = ISO_SHOWN,
     .most = 10},
    ISO_OPTIONS_END,
};

static iso_status run(const iso_cli *cli, void *values, iso_error *err)
{
    const compare_options *o = values;
    json_auto_t *a = NULL, *b = NULL;
    NEED(load_answer(cli->arguments[0], &a, err));
    NEED(load_answer(cli->arguments[1], &b, err));
    return compare_answers(cli, a, b, o->slack, err);
}

const iso_command iso_bench_compare = {
    .name = "bench compare",
    .summary = "two answers of bench all: exit 1 if a figure became worse, beyond the scatter of the runs",
    .min_arguments = 2,
    .max_arguments = 2,
    .usage = "BEFORE.json AFTER.json [options]",
    .details =
        "A figure became worse if the 95 % interval of its mean change is above 1, and the change exceeds --slack.\n"
        "Files of one run with --beside are compared run by run, others by Welch's interval. By chance one of forty\n"
        "unchanged figures is reported as worse. A figure of BEFORE that AFTER lacks, or could not measure, is\n"
        "listed with the cause; exit code 1 then, too. Results of different commands are not compared.",
    .examples = "  isoshade bench all --quick --only build-memory --repeat 2 -o a.json\n"
                "  isoshade bench compare a.json a.json\n",
    ISO_COMMAND_OPTIONS(compare_options, options, .slack = 0.03),
    .run = run,
};

/* SPDX-License-Identifier: MIT */
/* Tables of options: types, limits, defaults, nested tables, and the tables of all commands. */
#define _GNU_SOURCE
#include "options/cli.h"
#include "test.h"

typedef struct inner_options {
    char *name;
    int count;
} inner_options;

typedef struct outer_options {
    const char *format;
    char *output, **added;
    int flag, runs, seeds;
    long skip;
    long long seed;
    double step;
    inner_options inner;
} outer_options;

static char *describe(const iso_option *option)
{
    return strdup(option->about == 7 ? "made" : "wrong");
}

static const iso_option inner_rows[] = {
    {"name", 0, "a name", "NAME", ISO_IN(inner_options, name)},
    {"count", 0, "a count", "N", ISO_IN(inner_options, count), .least = 2, .most = 9},
    ISO_OPTIONS_END,
};
static const iso_option rows[] = {
    {"output", 'o', "a file", "FILE", ISO_IN(outer_options, output)},
    {"add", 0, "a text each time", "TEXT", ISO_IN(outer_options, added)},
    {"format", 0, "one of three", "svg|pdf|png", ISO_IN(outer_options, format), .flags = ISO_SHOWN | ISO_ONE_OF},
    {"flag", 0, "a flag", NULL, ISO_IN(outer_options, flag)},
    ISO_OPTIONS_OF(outer_options, inner, inner_rows),
    {"runs", 0, NULL, "N", ISO_IN(outer_options, runs), .flags = ISO_NOT_ZERO, .describe = describe, .about = 7},
    {"seeds", 0, "two at least", "N", ISO_IN(outer_options, seeds), .flags = ISO_NOT_ZERO, .least = 2, .most = 32},
    {"skip", 0, "bytes", "N", ISO_IN(outer_options, skip)},
    {"seed", 0, "a seed", "N", ISO_IN(outer_options, seed), .flags = ISO_SHOWN},
    {"step", 0, "a step", "X", ISO_IN(outer_options, step), .least = 0.5, .most = 4},
    ISO_OPTIONS_END,
};
#define DEFAULTS .format = "svg", .seed = 5, .step = -1, .inner = {.count = 1}

static outer_options seen; /* copies of numbers, and texts by value */
static char seen_texts[5][32];

static iso_status run(const iso_cli *cli, void *values, iso_error *err)
{
    outer_options *o = values;
    (void)err;
    seen = *o;
    const char *const texts[] = {o->output, o->added ? o->added[0] : NULL, o->added ? o->added[1] : NULL, o->format,
                                 o->inner.name};
    for (size_t i = 0; i < 5; ++i)
        snprintf(seen_texts[i], sizeof seen_texts[i], "%s", texts[i] ? texts[i] : "");
    assert_int_equal(cli->threads, 3);
    /* A command may replace its texts: only those that parsing made are freed. */
    static char own[] = "own";
    o->output = own;
    return ISO_OK;
}

static const iso_command command = {
    .name = "test",
    .summary = "a test",
    .usage = "[options]",
    .max_arguments = 1,
    ISO_COMMAND_OPTIONS(outer_options, rows, DEFAULTS),
    .run = run,
};

static iso_status call(int argc, const char *const *words, iso_error *err)
{
    const char *argv[24] = {"test", "--threads", "3", "-q"};
    memcpy(argv + 4, words, (size_t)argc * sizeof *words);
    return iso_command_run(&command, argc + 4, argv, err);
}
#define CALL(...) \
    call((int)(sizeof((const char *[]){__VA_ARGS__}) / sizeof(char *)), (const char *[]){__VA_ARGS__}, &err)

TEST(members_get_values_by_their_types)
{
    assert_ok(CALL("-o", "a.png", "--add", "x", "--add=y", "--flag", "--count", "9", "--name=n", "--runs", "2",
                   "--skip", "5000000000", "--seed=-6000000000", "--step", "0.5", "--format", "pdf"));
    assert_string_equal(seen_texts[0], "a.png");
    assert_string_equal(seen_texts[1], "x");
    assert_string_equal(seen_texts[2], "y");
    assert_string_equal(seen_texts[3], "pdf");
    assert_string_equal(seen_texts[4], "n");
    assert_int_equal(seen.flag, 1);
    assert_int_equal(seen.inner.count, 9);
    assert_int_equal(seen.runs, 2);
    assert_true(seen.skip == 5000000000);
    assert_true(seen.seed == -6000000000);
    assert_true(seen.step == 0.5);
}

TEST(defaults_stay_even_outside_of_limits)
{
    assert_ok(CALL("--flag"));
    assert_string_equal(seen_texts[3], "svg");
    assert_true(seen.step == -1 && seen.seed == 5 && seen.inner.count == 1 && seen.runs == 0);
}

TEST(wrong_values_are_refused_with_their_limits)
{
    static const struct {
        const char *words[2], *message;
    } cases[] = {
        {{"--count", "10"}, "--count is 10, must be 2 to 9"},
        {{"--count", "0"}, "--count is 0, must be 2 to 9"},
        {{"--step", "4.01"}, "--step is 4.01, must be 0.5 to 4"},
        {{"--step", "nan"}, "--step is nan, must be 0.5 to 4"},
        {{"--step", "inf"}, "--step is inf, must be a finite number"},
        {{"--runs", "0"}, "--runs is 0, must be at least 1"},
        {{"--seeds", "0"}, "--seeds is 0, must be 2 to 32"},
        {{"--seed", ""}, "--seed is empty, must be a number"},
        {{"--format", "sv"}, "--format is \"sv\", must be svg, pdf or png"},
        {{"--format", "svg|pdf"}, "--format is \"svg|pdf\", must be svg, pdf or png"},
        {{"--coumt", "3"}, "--coumt: unknown option"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        iso_error err = {""};
        assert_int_equal(CALL(cases[i].words[0], cases[i].words[1]), ISO_E_USAGE);
        assert_non_null(strstr(err.text, cases[i].message));
    }
}

static void count_option(void *user, const struct poptOption *option, bool is_common)
{
    size_t *count = user;
    count[is_common]++;
    if (strcmp(option->longName, "runs") == 0)
        assert_string_equal(option->descrip, "made");
}

TEST(nested_tables_are_spelled_out)
{
    size_t count[2] = {0};
    iso_cli_visit_options(&command, count_option, count);
    assert_int_equal(count[0], 11);
    assert_int_equal(count[1], 8);
}

TEST_MAIN(NULL, NULL)

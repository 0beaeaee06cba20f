/* SPDX-License-Identifier: MIT */
/* cmd_report.c - compares two reports, or a report with an accepted one. */
#define _GNU_SOURCE
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/manifest.h"
#include "base/provenance.h"
#include "options/cli.h"
#include "report/difference.h"
#include "report/markdown.h"
#include "report/rows.h"
#include "report/sections.h"

typedef struct report_arguments {
    char *output, *summary_md;
    double factor;
    int results_only, worse, accept;
} report_arguments;

/* Adds command, options and paths for the page and --json; the heading has the names in the reports. */
static void describe(const iso_cli *cli, const report_arguments *a, const iso_report_source of[2], json_t *d)
{
    FREED char *line = iso_cli_command_line(cli);
    for (int i = 0; i < 2; ++i)
        json_object_set_new(json_object_get(d, i ? "b" : "a"), "path", json_string(iso_provenance_name(of[i].path)));
    json_object_set_new(d, "command", json_string(line ? line : ""));
    json_object_set_new(d, "options",
                        json_pack("{s:b, s:b, s:b, s:f}", "results_only", a->results_only, "worse", a->worse, "accept",
                                  a->accept, "factor", a->factor));
    const char *names[2] = {iso_provenance_name(of[0].path), iso_provenance_name(of[1].path)};
    json_object_set_new(d, "title",
                        names[0][0] ? json_sprintf("%s and %s", names[0], names[1]) : json_string("two reports"));
}

static iso_status write_files(const report_arguments *a, const json_t *d, const json_t *inlined, iso_error *err)
{
    if (a->output)
        NEED(iso_difference_write(a->output, d, inlined, err));
    if (!a->summary_md)
        return ISO_OK;
    FREED char *link = a->output ? iso_path_join(iso_markdown_target(a->output), "index.html") : NULL;
    NEED(iso_markdown_of_difference(a->summary_md, d, link, err));
    /* a file in the page's folder is saved with the page */
    return a->output ? iso_manifest_add_output(a->output, a->summary_md, err) : ISO_OK;
}

/* ---- text ---- */

static char *text_of(const json_t *value)
{
    char *text = NULL;
    if (json_is_real(value))
        return asprintf(&text, "%.4g", json_real_value(value)) < 0 ? NULL : text;
    return json_is_string(value) ? strdup(json_string_value(value)) : json_dumps(value, JSON_ENCODE_ANY);
}

/* Prints "    rmse: 0.001 -> 0.002". */
static void print_values(const char *before, const json_t *a, const json_t *b)
{
    FREED char *from = text_of(a), *to = text_of(b);
    printf("%s: %s -> %s\n", before, from ? from : "", to ? to : "");
}

static void print_text(const json_t *d)
{
    size_t i, j;
    json_t *one, *what;
    json_array_foreach (json_object_get(d, "facts"), i, one)
        print_values(iso_row_text(one, "fact"), json_object_get(one, "a"), json_object_get(one, "b"));
    json_array_foreach (json_object_get(d, "rows"), i, one) {
        printf("%s: %s\n", iso_row_text(one, "change"), iso_row_text(one, "name"));
        json_array_foreach (json_object_get(one, "what"), j, what) {
            char line[160];
            snprintf(line, sizeof line, "    %s%.130s", json_is_true(json_object_get(what, "worse")) ? "worse: " : "",
                     iso_row_text(what, "what"));
            print_values(line, json_object_get(what, "a"), json_object_get(what, "b"));
        }
    }
    json_array_foreach (json_object_get(d, "pictures"), i, one) {
        if (json_is_true(json_object_get(one, "counts")) && json_object_get(one, "problem"))
            printf("picture: %s: %s\n", iso_row_text(one, "name"), iso_row_text(one, "problem"));
        else if (json_is_true(json_object_get(one, "counts")))
            printf("picture: %s: RMSE %.4g, tolerance %.4g (%s)\n", iso_row_text(one, "name"),
                   iso_row_number(one, "rmse"), iso_row_number(one, "tolerance"), iso_row_text(one, "why"));
    }
    puts(iso_row_text(d, "sentence"));
}

/* ---- comparing ---- */

/* Sets verdict and sentence. --worse: only worse results in B count. */
static iso_status conclude(const report_arguments *a, json_t *d, iso_error *err)
{
    const size_t worse = iso_difference_count_worse(d);
    iso_difference_conclude(d);
    json_object_set_new(d, "worse_count", json_integer((json_int_t)worse));
    if (a->worse) {
        json_object_set_new(d, "verdict",
                            json_string(iso_verdict_word(worse ? ISO_VERDICT_DIFFER : ISO_VERDICT_AGREE)));
        json_object_set_new(d, "sentence",
                            worse
                                ? json_sprintf("Figures, verdicts or rows that are worse than accepted, or gone: %zu; "
                                               "accept them with --accept",
                                               worse)
                                : json_string("Nothing is worse than accepted."));
    }
    if (a->accept || iso_row_verdict(d) == ISO_VERDICT_AGREE)
        return ISO_OK;
    return iso_fail(err, ISO_E_DIFFERS, "%s", iso_row_text(d, "sentence"));
}

static void print(const iso_cli *cli, const report_arguments *a, json_t *d)
{
    if (cli->json)
        iso_cli_print_json(json_incref(d));
    else
        print_text(d);
    if (!cli->json && a->output)
        printf("page: %s/index.html\n", a->output);
}

static iso_status diff(const iso_cli *cli, const report_arguments *a, const iso_report_source of[2], iso_error *err)
{
    json_auto_t *d = NULL, *inlined = json_pack("{s:{}, s:{}}", "images", "differences");
    NEED(iso_difference_of(of[0].root, of[1].root, a->results_only || a->worse, a->factor, &d, err));
    describe(cli, a, of, d);
    NEED(iso_difference_add_pictures(d, &of[0], &of[1], a->output ? inlined : NULL, err));
    const iso_status verdict = conclude(a, d, err);
    NEED(write_files(a, d, inlined, err));
    print(cli, a, d);
    return verdict;
}

/* Writes the rows of report B to the file A. */
static iso_status accept(const iso_cli *cli, const char *path, const json_t *rows, iso_error *err)
{
    const iso_status status = iso_json_save(path, rows, err);
    if (status == ISO_OK && !cli->quiet)
        fprintf(stderr, "%s: accepted%s\n", path,
                iso_sections_hold(rows) ? "" : ", although some of its rows do not agree");
    return status;
}

static iso_status compare(const iso_cli *cli, const report_arguments *a, const iso_report_source *b, iso_error *err)
{
    const char *path = cli->arguments[1];
    const bool is_there = iso_path_exists(path);
    json_auto_t *rows = NULL; /* A without any cannot get worse */
    ENDED_BY(iso_report_source_close) iso_report_source standing = {0};
    if (!is_there && a->worse && !a->accept)
        return iso_fail(err, ISO_E_IO, "%s: no accepted report; make it of %s with --accept", path, cli->arguments[2]);
    if (!is_there && a->accept)
        return ISO_OK;
    NEED(iso_report_source_open(&standing, path, err));
    if (a->worse)
        NEED(iso_difference_accept(standing.root, &rows, err));
    return diff(cli, a, (iso_report_source[]){standing, *b}, err);
}

static iso_status run(const iso_cli *cli, void *values, iso_error *err)
{
    const report_arguments *a = values;
    ENDED_BY(iso_report_source_close) iso_report_source b = {0};
    json_auto_t *rows = NULL;
    if (strcmp(cli->arguments[0], "diff") != 0)
        return iso_fail(err, ISO_E_USAGE, "unknown subcommand \"%s\"; try: report diff A B", cli->arguments[0]);
    if (cli->argument_count != 3)
        return iso_fail(err, ISO_E_USAGE, "diff needs two reports, A and B");
    if (a->accept && !iso_path_ends_with(cli->arguments[1], ".json"))
        return iso_fail(err, ISO_E_USAGE, "%s: --accept writes a file; its name must end in .json", cli->arguments[1]);
    NEED(iso_report_source_open(&b, cli->arguments[2], err));
    if (a->worse || a->accept)
        NEED(iso_difference_accept(b.root, &rows, err));
    NEED(compare(cli, a, &b, err));
    return a->accept ? accept(cli, cli->arguments[1], rows, err) : ISO_OK;
}

static const iso_option options[] = {
    {"output", 'o', "folder for a page of the differences", "DIR", ISO_IN(report_arguments, output)},
    {"summary-md", 0, "write the changes as Markdown, for a CI summary", "FILE.md",
     ISO_IN(report_arguments, summary_md)},
    {"results-only", 0, "list other versions and options, without counting them as differences", NULL,
     ISO_IN(report_arguments, results_only)},
    {"worse", 0, "only worse results in B are differences; for checks against an accepted report", NULL,
     ISO_IN(report_arguments, worse)},
    {"factor", 0, "factor of all tolerances", "X", ISO_IN(report_arguments, factor), .flags = ISO_SHOWN, .least = 1,
     .most = 1e6},
    {"accept", 0, "write the rows of B to A.json, after the changes are printed", NULL,
     ISO_IN(report_arguments, accept)},
    ISO_OPTIONS_END,
};

const iso_command iso_command_report = {
    .name = "report",
    .summary = "compare two reports, or check that a report is as good as the accepted one",
    .min_arguments = 1,
    .max_arguments = 3,
    .usage = "diff A B [-o DIR] [--worse] [--accept] [options]",
    .details =
        "A and B are folders that `isoshade validate` wrote, or only their report.json, without pictures. A row changed if\n"
        "its verdict or a limit changed, if it appeared or disappeared, or if a figure with a limit\n"
        "moved by more than its tolerance: a hundredth of its limit, or 1.5 times the noise of both rows, and at least 1e-7; of\n"
        "gates and calibrations a tenth of their limit (half of it in rows with noise), of levels .001. A picture differs by\n"
        "the same tolerance. Times, dates, commands, folders and the machine do not count. DIR/index.html shows both\n"
        "pictures in turn, split by a slider, and their difference; DIR/difference.json has all as data.\n"
        "--worse: a verdict is weaker (such as refused instead of agree), a figure or a limit grew, or a row is gone.\n"
        "A.json, which --accept writes, is a text file with rows, to keep with the code.\n"
        "Exit code 0: no difference; 1: a difference, such as a missing picture; 3 or 4: an existing file cannot be\n"
        "read.",
    .examples =
        "  isoshade make shells --size 40x44x37 -o shells.nrrd\n"
        "  isoshade validate shells.nrrd --scene refscenes/shells.scene.json --quick --levels 2 --with gl --size 32 -o report-then\n"
        "  isoshade validate shells.nrrd --scene refscenes/shells.scene.json --quick --levels 2 --with gl --size 32 -o report-now --summary-md now.md\n"
        "  isoshade report diff report-then report-now -o report-diff --summary-md diff.md\n"
        "  isoshade report diff accepted.json report-then --accept\n"
        "  isoshade report diff accepted.json report-now --worse\n",
    ISO_COMMAND_OPTIONS(report_arguments, options, .factor = 1),
    .run = run,
};

/* SPDX-License-Identifier: MIT */
/* cmd_baseline.c - a report against the accepted one. */
#define _GNU_SOURCE
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "options/cli.h"
#include "report/baseline.h"
#include "report/rows.h"
#include "report/sections.h"

typedef struct baseline_arguments {
    double factor, floor;
    int update;
} baseline_arguments;

static char *text_of(const json_t *value)
{
    char *text = NULL;
    if (json_is_number(value))
        return asprintf(&text, "%.4g", json_number_value(value)) < 0 ? NULL : text;
    return json_is_string(value) ? strdup(json_string_value(value)) : json_dumps(value, JSON_ENCODE_ANY);
}

/* "KIND NAME: accepted X, now Y", without what is null. */
static void print_change(const char *kind, const char *name, const json_t *accepted, const json_t *now)
{
    char *before = text_of(accepted), *after = text_of(now);
    printf("%-8s %s:", kind, name);
    if (!json_is_null(accepted))
        printf(" accepted %s", before ? before : "");
    if (!json_is_null(now))
        printf("%s now %s", json_is_null(accepted) ? "" : ",", after ? after : "");
    putchar('\n');
    free(before);
    free(after);
}

static void print_changes(const iso_baseline_result *r)
{
    size_t i;
    json_t *row;
    json_array_foreach(r->facts, i, row) print_change("other", json_string_value(json_object_get(row, "fact")),
                                                      json_object_get(row, "accepted"), json_object_get(row, "now"));
    json_array_foreach(r->changes, i, row) print_change(json_string_value(json_object_get(row, "change")),
                                                        json_string_value(json_object_get(row, "figure")),
                                                        json_object_get(row, "accepted"), json_object_get(row, "now"));
    printf("%zu as accepted, %zu better, %zu worse, %zu missing, %zu new\n", r->same, r->better, r->worse, r->missing,
           r->added);
}

static void print_json(const iso_cli *cli, const baseline_arguments *a, const iso_baseline_result *r)
{
    json_t *root = iso_cli_json(cli);
    bool good = a->update || r->worse + r->missing == 0;
    json_object_set_new(root, "options",
                        json_pack("{s:f, s:f, s:b}", "factor", a->factor, "floor", a->floor, "update", a->update));
    json_object_update_new(root,
                           json_pack("{s:I, s:I, s:I, s:I, s:I, s:O, s:O, s:s}", "same_count", (json_int_t)r->same,
                                     "better_count", (json_int_t)r->better, "worse_count", (json_int_t)r->worse,
                                     "missing_count", (json_int_t)r->missing, "new_count", (json_int_t)r->added,
                                     "changes", r->changes, "facts", r->facts, "verdict", good ? "agree" : "differ"));
    iso_cli_print_json(root);
}

/* A scene has no figures either, but is no empty baseline. */
static iso_status check_schema(const char *path, const json_t *root, iso_error *err)
{
    const char *schema = iso_row_text(root, "schema");
    if (strcmp(schema, ISO_BASELINE_SCHEMA) == 0)
        return ISO_OK;
    return iso_fail(err, ISO_E_FORMAT, "%s: its schema is \"%s\", wanted a baseline, as baseline --update writes it (%s)",
                    path, schema, ISO_BASELINE_SCHEMA);
}

/* What was accepted before; nothing where --update makes the first baseline. */
static iso_status load_accepted(const baseline_arguments *a, const char *path, json_t **accepted, iso_error *err)
{
    if (iso_path_exists(path)) {
        const iso_status status = iso_json_load(path, accepted, err);
        return status == ISO_OK ? check_schema(path, *accepted, err) : status;
    }
    if (!a->update)
        return iso_fail(err, ISO_E_IO, "%s: there is no baseline; --update makes one of this report", path);
    *accepted = json_pack("{s:s}", "schema", ISO_BASELINE_SCHEMA);
    return *accepted ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "out of memory");
}

static iso_status accept(const iso_cli *cli, const char *path, const json_t *now, iso_error *err)
{
    const char *name;
    json_t *row;
    size_t bad = 0;
    iso_status status = iso_json_save(path, now, err);
    json_object_foreach(json_object_get(now, "rows"), name, row)
    {
        const iso_verdict verdict = iso_row_verdict(row);
        bad += verdict == ISO_VERDICT_DIFFER || verdict == ISO_VERDICT_REFUSED;
    }
    if (status == ISO_OK && !cli->quiet)
        fprintf(stderr, "%s: %zu rows accepted, %zu of which do not agree\n", path,
                json_object_size(json_object_get(now, "rows")), bad);
    return status;
}

static iso_status compare(const iso_cli *cli, const baseline_arguments *a, const json_t *now, iso_error *err)
{
    const char *path = cli->arguments[1];
    json_t *accepted = NULL;
    iso_baseline_result r = {0};
    iso_status status = load_accepted(a, path, &accepted, err);
    if (status == ISO_OK && !a->update && iso_baseline_figure_count(accepted) == 0)
        status = iso_fail(err, ISO_E_FORMAT, "%s: holds no figures, so that nothing would be compared", path);
    if (status == ISO_OK)
        status = iso_baseline_compare(now, accepted, a->factor, a->floor, &r, err);
    if (status == ISO_OK && a->update)
        status = accept(cli, path, now, err);
    if (status == ISO_OK && cli->json)
        print_json(cli, a, &r);
    else if (status == ISO_OK && !(a->update && iso_baseline_figure_count(accepted) == 0))
        print_changes(&r); /* that all is new needs no list */
    if (status == ISO_OK && !a->update && r.worse + r.missing > 0)
        status =
            iso_fail(err, ISO_E_DIFFERS,
                     "%zu figures are worse than accepted and %zu are missing; if that is right, --update accepts them",
                     r.worse, r.missing);
    iso_baseline_result_destroy(&r);
    json_decref(accepted);
    return status;
}

static iso_status baseline(const iso_cli *cli, const baseline_arguments *a, iso_error *err)
{
    json_t *report = NULL, *now = NULL;
    iso_status status = iso_report_load(cli->arguments[0], &report, err);
    if (status == ISO_OK)
        status = iso_baseline_from_report(report, &now, err);
    if (status == ISO_OK)
        status = compare(cli, a, now, err);
    json_decref(report);
    json_decref(now);
    return status;
}

static iso_status run(const iso_command *self, int argc, const char **argv, iso_error *err)
{
    baseline_arguments a = {.factor = 1.25, .floor = 1e-7};
    struct poptOption options[] = {
        {"factor", 0, POPT_ARG_DOUBLE | POPT_ARGFLAG_SHOW_DEFAULT, &a.factor, 0,
         "worse: above this many times the accepted figure", "X"},
        {"floor", 0, POPT_ARG_DOUBLE | POPT_ARGFLAG_SHOW_DEFAULT, &a.floor, 0, "and by more than this", "X"},
        {"update", 0, POPT_ARG_NONE, &a.update, 0,
         "accept this report as the new baseline, and print what that changes", NULL},
        POPT_TABLEEND,
    };
    iso_cli cli;
    iso_cli_next next;
    iso_status status = iso_cli_parse(&cli, self, argc, argv, options, &next, err);
    if (status == ISO_OK && next == ISO_CLI_RUN)
        status = iso_words_check_range("--factor", a.factor, 1, 1e6, err);
    if (status == ISO_OK && next == ISO_CLI_RUN)
        status = iso_words_check_range("--floor", a.floor, 0, 1, err);
    if (status == ISO_OK && next == ISO_CLI_RUN)
        status = baseline(&cli, &a, err);
    iso_cli_end(&cli);
    return status;
}

const iso_command iso_command_baseline = {
    .name = "baseline",
    .summary = "is a report still as good as the accepted one? Changes of the baseline are explicit",
    .min_arguments = 2,
    .max_arguments = 2,
    .usage = "REPORT BASELINE.json [--update] [options]",
    .details =
        "REPORT is a folder that `isoshade validate` wrote. The verdict, the figures, limits and gates of each row of\n"
        "calibration, agreement, levels and consistency are compared with the accepted ones; changed versions and options are\n"
        "listed.\n"
        "Exit code 1: a verdict is weaker than accepted (reported or refused where it agreed), a figure is worse or missing,\n"
        "or a limit is wider; 0: all is as accepted, better or new. Only --update writes the baseline, a text file with one\n"
        "line for each figure, sorted by name, to be kept beside the code.",
    .examples =
        "  isoshade make shells --size 40x44x37 -o shells.nrrd\n"
        "  isoshade validate shells.nrrd --scene refscenes/shells.scene.json --quick --with gl --size 32 -o report-base\n"
        "  isoshade baseline report-base accepted.json --update\n"
        "  isoshade baseline report-base accepted.json --factor 1.1\n",
    .run = run,
};

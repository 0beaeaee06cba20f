/* SPDX-License-Identifier: MIT */
/* cmd_baseline.c - compares a report with the accepted one. */
#include <stdio.h>

#include "base/file.h"
#include "base/words.h"
#include "cli/print_difference.h"
#include "options/cli.h"
#include "report/difference.h"
#include "report/rows.h"
#include "report/sections.h"

typedef struct baseline_arguments {
    double factor;
    int update;
} baseline_arguments;

static iso_status accept(const iso_cli *cli, const char *path, const json_t *now, iso_error *err)
{
    const iso_status status = iso_json_save(path, now, err);
    if (status == ISO_OK && !cli->quiet)
        fprintf(stderr, "%s: accepted%s\n", path,
                iso_sections_hold(now) ? "" : ", although some of its rows do not agree");
    return status;
}

static void print(const iso_cli *cli, const baseline_arguments *a, json_t *difference)
{
    if (!cli->json) {
        iso_print_difference(difference);
        return;
    }
    json_t *root = iso_cli_json(cli);
    json_object_set_new(root, "options", json_pack("{s:f, s:b}", "factor", a->factor, "update", a->update));
    json_object_del(difference, "schema");
    json_object_update(root, difference);
    iso_cli_print_json(root);
}

/* Compares the report with the accepted one. Only worse results count, such as "differ" instead of "agree". */
static iso_status compare(const iso_cli *cli, const baseline_arguments *a, const json_t *now, iso_error *err)
{
    json_t *then = NULL, *checked = NULL, *d = NULL;
    iso_status status = iso_report_load(cli->arguments[1], &then, err);
    TRY(status, iso_difference_accept(then, &checked, err));
    TRY(status, iso_difference_of(then, now, true, a->factor, &d, err));
    const size_t worse = iso_difference_count_worse(d);
    if (status == ISO_OK) {
        iso_difference_conclude(d);
        json_object_set_new(d, "worse_count", json_integer((json_int_t)worse));
        json_object_set_new(d, "verdict",
                            json_string(
                                iso_verdict_word(worse && !a->update ? ISO_VERDICT_DIFFER : ISO_VERDICT_AGREE)));
        print(cli, a, d);
    }
    if (status == ISO_OK && worse && !a->update)
        status = iso_fail(err, ISO_E_DIFFERS,
                          "figures, verdicts or rows that are worse than accepted, or gone: %zu; accept them "
                          "with --update",
                          worse);
    json_decref(then);
    json_decref(checked);
    json_decref(d);
    return status;
}

static iso_status run(const iso_cli *cli, void *values, iso_error *err)
{
    const baseline_arguments *a = values;
    const char *path = cli->arguments[1];
    json_t *report = NULL, *now = NULL;
    const bool is_there = iso_path_exists(path);
    iso_status status = iso_report_load(cli->arguments[0], &report, err);
    TRY(status, iso_difference_accept(report, &now, err));
    if (status == ISO_OK && !is_there && !a->update)
        status = iso_fail(err, ISO_E_IO, "%s: no baseline; make one of this report with --update", path);
    if (status == ISO_OK && is_there)
        status = compare(cli, a, now, err);
    if (status == ISO_OK && a->update)
        status = accept(cli, path, now, err);
    json_decref(report);
    json_decref(now);
    return status;
}

static const iso_option options[] = {
    {"factor", 0, "tolerance for worse, as a multiple of report diff's", "X", ISO_IN(baseline_arguments, factor),
     .flags = ISO_SHOWN, .least = 1, .most = 1e6},
    {"update", 0, "accept this report as the new baseline, and print the changes", NULL,
     ISO_IN(baseline_arguments, update)},
    ISO_OPTIONS_END,
};

const iso_command iso_command_baseline = {
    .name = "baseline",
    .summary = "check that a report is as good as the accepted one, or accept it",
    .min_arguments = 2,
    .max_arguments = 2,
    .usage = "REPORT BASELINE.json [--update] [options]",
    .details =
        "REPORT is a folder that `isoshade validate` wrote. Its rows of calibration, agreement, levels and consistency are\n"
        "compared with the accepted ones, with the tolerances of `report diff`; changed versions and options are listed.\n"
        "Exit code 1: a verdict is weaker than accepted (such as refused instead of agree), a figure or a limit grew, or a\n"
        "row is gone; 0: all is as accepted, better or new. Only --update writes the baseline, a text file with the rows of the\n"
        "report, to keep with the code. Any report.json is a baseline, too.",
    .examples =
        "  isoshade make shells --size 40x44x37 -o shells.nrrd\n"
        "  isoshade validate shells.nrrd --scene refscenes/shells.scene.json --quick --with gl --size 32 -o report-base\n"
        "  isoshade baseline report-base accepted.json --update\n"
        "  isoshade baseline report-base accepted.json --factor 10\n",
    ISO_COMMAND_OPTIONS(baseline_arguments, options, .factor = 1),
    .run = run,
};

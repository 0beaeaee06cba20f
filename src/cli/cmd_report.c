/* SPDX-License-Identifier: MIT */
/* cmd_report.c - compares two reports. */
#define _GNU_SOURCE
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/manifest.h"
#include "base/provenance.h"
#include "cli/print_difference.h"
#include "options/cli.h"
#include "report/difference.h"
#include "report/markdown.h"
#include "report/rows.h"
#include "report/sections.h"

typedef struct report_arguments {
    char *output, *summary_md;
    int results_only;
} report_arguments;

/* Adds command, options and paths for the page and --json; the heading has the names in the reports. */
static void describe(const iso_cli *cli, const report_arguments *a, const iso_report_source of[2], json_t *d)
{
    char *line = iso_cli_command_line(cli);
    for (int i = 0; i < 2; ++i)
        json_object_set_new(json_object_get(d, i ? "b" : "a"), "path", json_string(iso_provenance_name(of[i].path)));
    json_object_set_new(d, "command", json_string(line ? line : ""));
    json_object_set_new(d, "options", json_pack("{s:b}", "results_only", a->results_only));
    const char *names[2] = {iso_provenance_name(of[0].path), iso_provenance_name(of[1].path)};
    json_object_set_new(d, "title",
                        names[0][0] ? json_sprintf("%s and %s", names[0], names[1]) : json_string("two reports"));
    free(line);
}

static iso_status write_files(const report_arguments *a, const json_t *d, const json_t *inlined, iso_error *err)
{
    iso_status status = a->output ? iso_difference_write(a->output, d, inlined, err) : ISO_OK;
    if (status == ISO_OK && a->summary_md) {
        char *link = a->output ? iso_path_join(iso_markdown_target(a->output), "index.html") : NULL;
        status = iso_markdown_of_difference(a->summary_md, d, link, err);
        free(link);
        if (status == ISO_OK && a->output) /* a file in the page's folder is saved with the page */
            status = iso_manifest_add_output(a->output, a->summary_md, err);
    }
    return status;
}

static iso_status diff(const iso_cli *cli, const report_arguments *a, const iso_report_source of[2], iso_error *err)
{
    json_t *d = NULL, *inlined = json_pack("{s:{}, s:{}}", "images", "differences");
    iso_status status = iso_difference_of(of[0].root, of[1].root, a->results_only, 1, &d, err);
    if (status == ISO_OK) {
        describe(cli, a, of, d);
        status = iso_difference_add_pictures(d, &of[0], &of[1], a->output ? inlined : NULL, err);
    }
    if (status == ISO_OK) {
        iso_difference_conclude(d);
        status = write_files(a, d, inlined, err);
    }
    if (status == ISO_OK && cli->json)
        iso_cli_print_json(json_incref(d));
    else if (status == ISO_OK)
        iso_print_difference(d);
    if (status == ISO_OK && !cli->json && a->output)
        printf("page: %s/index.html\n", a->output);
    if (status == ISO_OK && iso_row_verdict(d) != ISO_VERDICT_AGREE)
        status = iso_fail(err, ISO_E_DIFFERS, "%s", iso_row_text(d, "sentence"));
    json_decref(d);
    json_decref(inlined);
    return status;
}

static iso_status run(const iso_cli *cli, void *values, iso_error *err)
{
    const report_arguments *a = values;
    iso_report_source of[2] = {{0}};
    if (strcmp(cli->arguments[0], "diff") != 0)
        return iso_fail(err, ISO_E_USAGE, "unknown subcommand \"%s\"; try: report diff A B", cli->arguments[0]);
    if (cli->argument_count != 3)
        return iso_fail(err, ISO_E_USAGE, "diff needs two reports, A and B");
    iso_status status = iso_report_source_open(&of[0], cli->arguments[1], err);
    TRY(status, iso_report_source_open(&of[1], cli->arguments[2], err));
    TRY(status, diff(cli, a, of, err));
    iso_report_source_close(&of[0]);
    iso_report_source_close(&of[1]);
    return status;
}

static const iso_option options[] = {
    {"output", 'o', "folder for a page of the differences", "DIR", ISO_IN(report_arguments, output)},
    {"summary-md", 0, "write the changes as Markdown, for a CI summary", "FILE.md",
     ISO_IN(report_arguments, summary_md)},
    {"results-only", 0, "list other versions and options, without counting them as differences", NULL,
     ISO_IN(report_arguments, results_only)},
    ISO_OPTIONS_END,
};

const iso_command iso_command_report = {
    .name = "report",
    .summary = "compare two reports: verdicts, figures, versions and pictures",
    .min_arguments = 1,
    .max_arguments = 3,
    .usage = "diff A B [-o DIR] [--summary-md FILE] [options]",
    .details =
        "A and B are folders that `isoshade validate` wrote, or only their report.json, without pictures. A row changed if\n"
        "its verdict or a limit changed, if it appeared or disappeared, or if a figure with a limit\n"
        "moved by more than its tolerance: a hundredth of its limit, or 1.5 times the noise of both rows, and at least 1e-7; of\n"
        "gates and calibrations a tenth of their limit (half of it in rows with noise), of levels .001. A picture differs by\n"
        "the same tolerance. Times, dates, commands, folders and the machine do not count. DIR/index.html shows both\n"
        "pictures in turn, split by a slider, and their difference; DIR/difference.json has all as data.\n"
        "Exit code 0: no difference; 1: a difference, such as a missing picture; 3 or 4: an existing file cannot be\n"
        "read.",
    .examples =
        "  isoshade make shells --size 40x44x37 -o shells.nrrd\n"
        "  isoshade validate shells.nrrd --scene refscenes/shells.scene.json --quick --levels 2 --with gl --size 32 -o report-then\n"
        "  isoshade validate shells.nrrd --scene refscenes/shells.scene.json --quick --levels 2 --with gl --size 32 -o report-now --summary-md now.md\n"
        "  isoshade report diff report-then report-now -o report-diff --summary-md diff.md\n",
    .options = options,
    .options_size = sizeof(report_arguments),
    .run = run,
};

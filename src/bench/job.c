/* SPDX-License-Identifier: MIT */
/* job.c - what the main job draws, starts and takes, beside the same job with whole pictures, one a start.
 *
 * Both are runs of this program's own `validate`, one after the other, which count their work (base/work.h). Their verdicts,
 * row by row, have to be the same. */
#define _GNU_SOURCE
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/json.h"
#include "base/parallel.h"
#include "base/process.h"
#include "bench/bench.h"
#include "renderers/renderers.h"

typedef struct job_options {
    char *scene, *size, *with;
    int levels, whole;
} job_options;

/* What a run came to. */
typedef struct job_run {
    json_t *report;
    double seconds;
} job_run;

enum { BEFORE, AFTER, RUNS };
static const char *const run_names[RUNS] = {"before", "after"};

static const struct {
    const char *key, *name;
} figures[] = {
    {"program_starts", "program starts"},
    {"pictures", "pictures"},
    {"pixels", "pixels"},
    {"pixel_steps", "pixels x steps"},
    {"processor_seconds", "processor time (s)"},
};
enum { FIGURES = sizeof figures / sizeof *figures };

static double figure(const job_run *run, size_t i)
{
    return json_number_value(json_object_get(json_object_get(run->report, "work"), figures[i].key));
}

/* Its verdict may be any. */
static iso_status run_validate(const job_options *o, const iso_cli *cli, int which, const char *folder, job_run *run,
                               iso_error *err)
{
    char *report = iso_path_join(folder, run_names[which]), *json = report ? iso_path_join(report, "report.json") : NULL;
    char levels[32], threads[32];
    const char *argv[32];
    size_t n = 0;
    argv[n++] = "/proc/self/exe", argv[n++] = "validate", argv[n++] = cli->arguments[0], argv[n++] = "--quiet";
    argv[n++] = "-o", argv[n++] = report;
    if (!o->whole)
        argv[n++] = "--quick";
    if (o->scene)
        argv[n++] = "--scene", argv[n++] = o->scene;
    if (o->size)
        argv[n++] = "--size", argv[n++] = o->size;
    if (o->with)
        argv[n++] = "--with", argv[n++] = o->with;
    if (o->levels) {
        snprintf(levels, sizeof levels, "%d", o->levels);
        argv[n++] = "--levels", argv[n++] = levels;
    }
    if (cli->threads) {
        snprintf(threads, sizeof threads, "%d", cli->threads);
        argv[n++] = "--threads", argv[n++] = threads;
    }
    if (which == BEFORE)
        argv[n++] = "--limit-size", argv[n++] = "65536";
    argv[n] = NULL;
    iso_process_outcome outcome = {.exit_code = -1};
    iso_error why = {""};
    iso_status status = report && json ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "bench job: out of memory");
    if (status == ISO_OK && which == BEFORE)
        setenv(ISO_RENDERERS_APART, "1", 1);
    if (status == ISO_OK)
        status = iso_process_run(argv, &(iso_process_options){.sandbox = {.kind = ISO_SANDBOX_NONE}, .outcome = &outcome}, &why);
    unsetenv(ISO_RENDERERS_APART);
    if (status != ISO_OK && (outcome.exit_code != ISO_E_DIFFERS || !iso_path_exists(json)))
        status = iso_fail(err, status, "bench job: %s: %s", run_names[which], why.text);
    else if (report && json)
        status = iso_json_load(json, &run->report, err);
    run->seconds = outcome.seconds;
    free(json);
    free(report);
    return status;
}

/* Rows of one run whose verdict is another one in the other, or that it lacks. */
static size_t count_changed(const job_run runs[RUNS])
{
    json_t *seen = json_object(), *row;
    size_t i, changed = 0;
    char key[320];
    for (int which = BEFORE; which < RUNS; ++which)
        json_array_foreach(json_object_get(runs[which].report, "agreement"), i, row)
        {
            const json_t *b = json_object_get(row, "b"), *verdict = json_object_get(row, "verdict");
            snprintf(key, sizeof key, "%lld %.250s", (long long)json_integer_value(json_object_get(row, "level")),
                     b ? json_string_value(b) : "");
            if (which == BEFORE)
                json_object_set(seen, key, (json_t *)verdict);
            else if (!json_equal(json_object_get(seen, key), verdict))
                ++changed;
            else
                json_object_del(seen, key);
        }
    changed += json_object_size(seen);
    json_decref(seen);
    return changed;
}

static void print_table(const job_run runs[RUNS], size_t changed)
{
    printf("%-22s %14s %14s %8s\n", "", run_names[BEFORE], run_names[AFTER], "ratio");
    for (size_t i = 0; i < FIGURES; ++i) {
        const double before = figure(&runs[BEFORE], i), after = figure(&runs[AFTER], i);
        printf("%-22s %14.4g %14.4g %8.2f\n", figures[i].name, before, after, after > 0 ? before / after : 0);
    }
    printf("%-22s %14.1f %14.1f %8.2f\n", "clock (s)", runs[BEFORE].seconds, runs[AFTER].seconds,
           runs[BEFORE].seconds / runs[AFTER].seconds);
    for (int which = BEFORE; which < RUNS; ++which)
        printf("%s: %s\n", run_names[which], json_string_value(json_object_get(runs[which].report, "sentence")));
    printf("comparisons with another verdict: %zu\n", changed);
}

static void print_json(const iso_cli *cli, const job_run runs[RUNS], size_t changed)
{
    json_t *root = iso_cli_json(cli), *ratios = json_object();
    for (int which = BEFORE; which < RUNS; ++which) {
        json_t *one = json_deep_copy(json_object_get(runs[which].report, "work"));
        json_object_set_new(one, "seconds", json_real(runs[which].seconds));
        json_object_set(one, "verdict", json_object_get(runs[which].report, "verdict"));
        json_object_set_new(root, run_names[which], one);
    }
    for (size_t i = 0; i < FIGURES; ++i)
        json_object_set_new(ratios, figures[i].key,
                            iso_json_number(figure(&runs[BEFORE], i) / figure(&runs[AFTER], i)));
    json_object_set_new(root, "ratios", ratios);
    json_object_set_new(root, "changed_count", json_integer((json_int_t)changed));
    iso_cli_print_json(root);
}

static iso_status bench(const job_options *o, const iso_cli *cli, iso_error *err)
{
    job_run runs[RUNS] = {{NULL, 0}};
    const iso_progress progress = iso_cli_progress(cli);
    char *folder = iso_make_temp_dir();
    iso_status status = folder ? ISO_OK : iso_temp_dir_fail(err);
    for (int which = BEFORE; which < RUNS && status == ISO_OK; ++which) {
        iso_progress_report(&progress, run_names[which], 0.5 * which);
        status = run_validate(o, cli, which, folder, &runs[which], err);
    }
    const size_t changed = status == ISO_OK ? count_changed(runs) : 0;
    if (status == ISO_OK && cli->json)
        print_json(cli, runs, changed);
    else if (status == ISO_OK)
        print_table(runs, changed);
    for (int which = BEFORE; which < RUNS; ++which)
        json_decref(runs[which].report);
    if (folder)
        iso_remove_tree(folder);
    free(folder);
    return status != ISO_OK || changed == 0
               ? status
               : iso_fail(err, ISO_E_DIFFERS, "bench job: %zu comparisons have another verdict", changed);
}

static iso_status run(const iso_command *self, int argc, const char **argv, iso_error *err)
{
    job_options o = {.scene = NULL};
    struct poptOption options[] = {
        {"scene", 0, POPT_ARG_STRING, &o.scene, 0, "scene file (*.scene.json)", "FILE"},
        {"size", 0, POPT_ARG_STRING, &o.size, 0, "pixels of the pictures, as in validate", "N|WxH"},
        {"with", 0, POPT_ARG_STRING, &o.with, 0, "renderers, as in validate", "LIST"},
        {"levels", 0, POPT_ARG_INT, &o.levels, 0, "levels, as in validate", "N"},
        {"whole", 0, POPT_ARG_NONE, &o.whole, 0, "the whole job instead of the quick one", NULL},
        POPT_TABLEEND,
    };
    iso_cli cli;
    iso_cli_next next;
    iso_status status = iso_cli_parse(&cli, self, argc, argv, options, &next, err);
    if (status == ISO_OK && next == ISO_CLI_RUN && cli.argument_count != 1)
        status = iso_fail(err, ISO_E_USAGE, "wanted a volume or a pyramid");
    else if (status == ISO_OK && next == ISO_CLI_RUN)
        status = bench(&o, &cli, err);
    iso_cli_end(&cli);
    return status;
}

const iso_command iso_bench_job = {
    .name = "bench job",
    .summary = "what the main job starts, draws and takes, beside the same job with whole pictures, one a start",
    .max_arguments = 1,
    .usage = "VOLUME|PYRAMID.iso [options]",
    .details =
        "Two runs of validate --quick, one after the other: before, in which limits are drawn with all pixels of the scene and\n"
        "each pass of each picture by a start or request of its own; and after, as validate does it. Their program starts,\n"
        "pictures, pixels, pixels times steps and processor time over all cores, programs included, with the ratios. Exit code\n"
        "1: a comparison has another verdict.",
    .examples = "  isoshade make shells --size 24x22x20 -o small.nrrd\n"
                "  isoshade bench job small.nrrd --with gl --size 96 --levels 1\n",
    .run = run,
};

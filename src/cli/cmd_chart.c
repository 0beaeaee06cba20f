/* SPDX-License-Identifier: MIT */
/* cmd_chart.c - charts speed against accuracy: measures a grid of settings, and finds the front and the cheapest
 * one. */
#define _GNU_SOURCE
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/parallel.h"
#include "base/provenance.h"
#include "chart/kept.h"
#include "chart/order.h"
#include "chart/result.h"
#include "cli/renderer_help.h"
#include "options/cli.h"
#include "options/input.h"
#include "options/look.h"
#include "options/visible.h"
#include "renderers/external.h"
#include "scene/viewpoint.h"
#include "tf/presets.h"
#include "view/viewer.h"

typedef struct chart_arguments {
    iso_volume_input input;
    iso_cli_look look;
    char *output, *renderers, *want_text, *style, *metric_text, *bytes_text;
    iso_chart_words words;
    int level_count, processor_time, resume, viewer;
    double budget_seconds; /* 0: unlimited, the whole grid is measured */
    double want;           /* 0: none */
    iso_chart_metric metric;
    iso_chart_bytes bytes;
} chart_arguments;

typedef struct chart_run {
    const chart_arguments *arguments;
    const iso_cli *cli;
    iso_chart_grid grid;
    iso_chart_bench bench;
    iso_chart_result result;
    iso_chart_kept_file kept;
    iso_subject_look looks[ISO_CHART_MAX_SCENES];
    char *paths[ISO_CHART_MAX_SCENES],
        *lines[ISO_CHART_MAX_SCENES]; /* for each scene of --scene A,B: its path, and its options as a command line */
    size_t look_count;
    double start_seconds, end_seconds, measure_until; /* end: deadline of all frames */
} chart_run;

/* Largest part of the remaining time for starting a picture of another program. */
static const double MOST_PART_OF_A_PROGRAM = 1.0 / 3;

/* Reserves time for two pictures by gnuplot and for the files. */
static double seconds_for_drawing(double budget_seconds)
{
    return fmin(3, 0.2 * budget_seconds);
}

/* Returns the deadline of the last setting. */
static double end_of_measuring(const chart_run *run)
{
    const double budget_seconds = run->arguments->budget_seconds;
    return budget_seconds > 0 ? run->start_seconds + budget_seconds - seconds_for_drawing(budget_seconds) : INFINITY;
}

/* True if a program's first picture, which takes seconds, would not fit into the budget. */
static bool is_too_slow_to_begin(const chart_run *run, const iso_renderer_info *renderer)
{
    const iso_chart_case first = {.renderer = renderer,
                                  .voxel_count = iso_geometry_voxel_count(&run->bench.first.levels[0].geometry),
                                  .second = ISO_SECOND_VALUE_NONE,
                                  .estimator = run->bench.first.options.gradient.method,
                                  .filter = run->bench.first.options.direction_filter};
    return iso_renderer_has(renderer, ISO_IS_PROGRAM) &&
           MOST_PART_OF_A_PROGRAM * (run->end_seconds - iso_clock_seconds()) <
               iso_chart_bench_estimate(&run->bench, &first);
}

/* Asks a renderer for its version. One that does not answer is left out, unless --with names it. */
static iso_status find_renderer(chart_run *run, size_t r, iso_error *err)
{
    iso_chart_result *result = &run->result;
    const iso_renderer_info *renderer = iso_renderer_at(r);
    char *left_out = result->left_out[r];
    iso_error why = {""};
    run->grid.with[r] = false;
    if (run->grid.optional[r] && is_too_slow_to_begin(run, renderer))
        snprintf(left_out, sizeof result->left_out[r], "its first picture would take most of the %g s",
                 run->arguments->budget_seconds);
    else {
        const iso_status status = renderer->version(renderer, &run->bench.renderers, result->versions[r],
                                                    sizeof result->versions[r], &why);
        if (status != ISO_OK && !run->grid.optional[r])
            return iso_fail(err, status, "%s", why.text);
        if (status != ISO_OK)
            snprintf(left_out, sizeof result->left_out[r], "%.300s", why.text);
        else if (!iso_renderer_has(renderer, ISO_HAS_PROCESSOR_TIME) && run->bench.processor_time) {
            if (!run->grid.optional[r])
                return iso_fail(err, ISO_E_USAGE, "--processor-time: %s does not report it per frame", renderer->title);
            snprintf(left_out, sizeof result->left_out[r], "%s does not report processor time per frame",
                     renderer->title);
        } else
            run->grid.with[r] = true;
    }
    return ISO_OK;
}

/* Leaves out renderers that do not answer; one that --with names must answer. If none is left, the CPU ray caster takes
 * their place. */
static iso_status find_renderers(chart_run *run, iso_error *err)
{
    iso_chart_result *result = &run->result;
    const size_t usual = iso_renderer_index(iso_renderers_usual()),
                 instead = iso_renderer_index(iso_renderers_instead());
    bool any = false;
    for (size_t r = 0; r < iso_renderer_count(); ++r) {
        if (run->grid.with[r])
            NEED(find_renderer(run, r, err));
        any = any || run->grid.with[r];
    }
    if (!any && run->grid.optional[usual]) {
        any = run->grid.with[instead] = true;
        NEED(iso_renderers_instead()->version(iso_renderers_instead(), &run->bench.renderers, result->versions[instead],
                                              sizeof result->versions[instead], err));
    }
    return any ? ISO_OK : iso_fail(err, ISO_E_MISSING, "no renderer answers: %s", result->left_out[usual]);
}

/* Handles a setting that fails. Its renderer is left out if --with does not name it. A setting beyond a limit, such as
 * the size of a texture, is skipped. All other errors end the chart. */
static iso_status take_failure(chart_run *run, const iso_chart_case *c, iso_status status, const iso_error *why,
                               iso_error *err)
{
    iso_chart_result *result = &run->result;
    const size_t r = iso_renderer_index(c->renderer);
    if (run->grid.optional[r] && iso_renderer_has(c->renderer, ISO_IS_PROGRAM)) {
        snprintf(result->left_out[r], sizeof result->left_out[r], "%.300s", why->text);
        run->grid.with[r] = false;
        return ISO_OK;
    }
    if (status != ISO_E_RANGE && status != ISO_E_USAGE && status != ISO_E_MEMORY)
        return iso_fail(err, status, "%s", why->text);
    if (result->refused_count++ == 0)
        snprintf(result->refusal, sizeof result->refusal, "%.300s", why->text);
    return ISO_OK;
}

/* Part of the time for timing the best settings again. */
static const double AGAIN_PART = 0.15;
/* Settings that would be on the front if they were this many times faster are timed again: other work on the machine
 * may have slowed them down. */
static const double AGAIN_FACTOR = 2.5;

static bool is_worth_timing_again(const iso_chart_result *r, const iso_chart_case *c)
{
    const double error = iso_chart_error(c, r->metric);
    if (!c->done || iso_renderer_has(c->renderer, ISO_IS_PROGRAM) || !isfinite(error))
        return false;
    for (size_t j = 0; j < r->count; ++j)
        if (r->cases[j].done && r->cases[j].scene == c->scene &&
            AGAIN_FACTOR * r->cases[j].took.seconds < c->took.seconds &&
            iso_chart_error(&r->cases[j], r->metric) <= error)
            return false;
    return true;
}

/* True if the budget is long enough to time settings again. */
static bool has_time_for_rounds(double budget_seconds)
{
    return !(budget_seconds > 0) || budget_seconds > 1;
}

/* Times the best settings again in rounds, so that a busy moment affects each setting only once. */
static iso_status time_again(chart_run *run, iso_error *err)
{
    enum { rounds = 2 };
    iso_progress progress = iso_cli_progress(run->cli);
    iso_chart_result *result = &run->result;
    for (size_t k = 0; k < rounds * result->count && has_time_for_rounds(run->arguments->budget_seconds); ++k) {
        iso_chart_case *c = &result->cases[k % result->count];
        iso_progress_report(&progress, "the best again", (double)k / (double)(rounds * result->count));
        if (iso_clock_seconds() + iso_chart_bench_estimate(&run->bench, c) < run->end_seconds &&
            is_worth_timing_again(result, c)) {
            NEED(iso_chart_bench_time_again(&run->bench, c, err));
            NEED(iso_chart_kept_put(&run->kept, &run->bench, c, err));
        }
    }
    iso_progress_report(&progress, "the best again", 1);
    return ISO_OK;
}

/* Returns the part of the work that is done, by the estimate for the remaining settings or by the budget. */
static double part_done(const chart_run *run, double start_seconds, double end_seconds)
{
    const double now = iso_clock_seconds(), spent = now - start_seconds;
    double left = 0;
    for (size_t i = 0; i < run->result.count && left < end_seconds - now; ++i)
        left += !run->result.cases[i].done && run->grid.with[iso_renderer_index(run->result.cases[i].renderer)]
                    ? iso_chart_bench_estimate(&run->bench, &run->result.cases[i])
                    : 0;
    left = fmin(left, fmax(end_seconds - now, 0));
    return spent + left > 0 ? spent / (spent + left) : 1;
}

/* ---- the order ---- */

static double error_of(const void *user, const iso_chart_case *c)
{
    const chart_run *run = user;
    return iso_chart_error(c, run->result.metric);
}

static double frame_seconds_of(const void *user, const iso_chart_case *c)
{
    const chart_run *run = user;
    return iso_chart_bench_estimate_frame(&run->bench, c);
}

/* True if a setting may still be measured: not refused before, and within the budget. The first setting always may. */
static bool is_open(const void *user, const iso_chart_case *c)
{
    const chart_run *run = user;
    const double left = run->measure_until - iso_clock_seconds(), takes = iso_chart_bench_estimate(&run->bench, c);
    if (!run->grid.with[iso_renderer_index(c->renderer)] || c->refused)
        return false;
    if (run->result.done_count == 0)
        return true;
    return takes <= (iso_renderer_has(c->renderer, ISO_IS_PROGRAM) ? MOST_PART_OF_A_PROGRAM * left : left);
}

/* Measures the settings that fit into the budget, in the order of chart/order.h; the first one always. */
static iso_status measure_all(chart_run *run, iso_error *err)
{
    iso_progress progress = iso_cli_progress(run->cli);
    iso_chart_result *result = &run->result;
    const iso_chart_outlook outlook = {error_of, frame_seconds_of, is_open, run};
    const double start_seconds = iso_clock_seconds();
    for (size_t i; (i = iso_chart_next(result->cases, result->count, &outlook)) < result->count;) {
        iso_chart_case *c = &result->cases[i];
        iso_error why = {""};
        iso_progress_report(&progress, "settings", part_done(run, start_seconds, run->measure_until));
        const iso_status one = iso_chart_bench_measure(&run->bench, c, &why);
        result->done_count += c->done;
        c->refused = !c->done;
        NEED(one != ISO_OK ? take_failure(run, c, one, &why, err)
                           : iso_chart_kept_put(&run->kept, &run->bench, c, err));
    }
    iso_progress_report(&progress, "settings", 1);
    return result->done_count > 0 ? ISO_OK
                                  : iso_fail(err, ISO_E_RANGE, "no setting could be rendered: %s", result->refusal);
}

/* Writes DIR/viewer-SCENE.html, to which the page's settings link. */
static iso_status save_viewers(chart_run *run, iso_error *err)
{
    iso_chart_result *result = &run->result;
    const iso_pyramid *p = &run->bench.first;
    FREED char *typed = iso_volume_input_line(&run->arguments->input),
               *input = typed ? iso_provenance_line(typed) : NULL;
    for (size_t i = 0; i < run->bench.scene_count && run->arguments->viewer; ++i) {
        iso_viewer_size size;
        const iso_viewer page = {.pyramid = p,
                                 .scene = &run->bench.scenes[i].scene,
                                 .title = iso_provenance_title(run->bench.path),
                                 .input = input,
                                 .folder = run->bench.is_volume ? NULL : run->bench.path,
                                 .first = iso_viewer_finest_level(p, ISO_VIEWER_MOST_VOXELS),
                                 .last = p->level_count - 1,
                                 .code_count = 1,
                                 .codes = {p->options.code},
                                 .threads = run->cli->threads};
        snprintf(result->viewers[i], sizeof result->viewers[i], "viewer-%s.html", run->bench.scenes[i].name);
        FREED char *path = iso_path_join(run->kept.output.temp_path, result->viewers[i]);
        NEED(path ? iso_viewer_save(&page, path, NULL, &size, err)
                  : iso_fail(err, ISO_E_MEMORY, "chart: out of memory"));
    }
    return ISO_OK;
}

static iso_status finish(chart_run *run, iso_error *err)
{
    iso_chart_result *result = &run->result;
    NEED(iso_chart_result_sort(result, err));
    NEED(save_viewers(run, err));
    result->spent_seconds = iso_clock_seconds() - run->start_seconds;
    const iso_progress progress = iso_cli_progress(run->cli);
    iso_progress_report(&progress, "drawing", 0);
    json_auto_t *json = iso_chart_result_json(result);
    NEED(iso_chart_result_write(result, run->kept.output.temp_path, json, err));
    NEED(iso_chart_kept_commit(&run->kept, err));
    result->spent_seconds = iso_clock_seconds() - run->start_seconds;
    iso_progress_line_hide(run->cli->progress);
    if (run->cli->json)
        iso_cli_print_json(json_incref(json));
    else
        iso_chart_result_print(result);
    if (result->want > 0 && result->fastest == result->done_count)
        return iso_fail(err, ISO_E_DIFFERS, "no measured setting has %s of %.4g or less; the least is %.4g",
                        iso_chart_metric_name(result->metric), result->want,
                        result->best < result->done_count ? iso_chart_worst_error(result, &result->cases[result->best])
                                                          : NAN);
    return ISO_OK;
}

/* ---- scenes ---- */

/* Makes a look for each scene of --scene A,B. */
static iso_status check_looks(chart_run *run, iso_error *err)
{
    iso_cli_look look = run->arguments->look;
    FREED char *list = strdup(look.scene ? look.scene : "");
    NEED_MEMORY(list, err, "chart: out of memory");
    for (char *path, *rest = list; (path = strsep(&rest, ",")); ++run->look_count) {
        const size_t n = run->look_count;
        if (n == ISO_CHART_MAX_SCENES)
            return iso_fail(err, ISO_E_USAGE, "--scene: more than %d scenes", ISO_CHART_MAX_SCENES);
        look.scene = look.scene ? run->paths[n] = strdup(path) : NULL;
        NEED(iso_cli_look_check(&look, run->cli->threads, &run->looks[n], err));
        run->lines[n] = iso_cli_look_line(&look);
        run->result.looks[n] = run->lines[n] ? run->lines[n] : "";
    }
    return ISO_OK;
}

static iso_status make_references(chart_run *run, iso_error *err)
{
    iso_chart_bench *b = &run->bench;
    for (size_t i = 0; i < b->scene_count; ++i) {
        if (b->scenes[i].reference.rgba)
            continue;
        NEED(iso_chart_bench_reference(b, i, b->hasty ? ISO_CHART_HASTY_TOLERANCE : ISO_CHART_TOLERANCE, err));
        NEED(iso_chart_kept_put_reference(&run->kept, b, i, err));
    }
    return ISO_OK;
}

static iso_status identify_renderers(chart_run *run, iso_error *err)
{
    for (size_t r = 0; r < iso_renderer_count(); ++r)
        if (run->grid.with[r])
            NEED(iso_renderer_identify(iso_renderer_at(r), run->result.versions[r], run->kept.renderers[r], err));
    return ISO_OK;
}

/* Loads the measurements and references of an earlier run. */
static iso_status take_kept(chart_run *run, iso_error *err)
{
    /* Options that do not change a setting's result: each stored line names its own values on the axes, others select
     * or draw lines. Times depend on --threads. */
    static const char *const without[] = {"with",  "steps",  "quadratures", "estimators", "levels", "filters",
                                          "codes", "tfs",    "plans",       "budget",     "want",   "metric",
                                          "bytes", "viewer", "style",       NULL};
    iso_chart_result *result = &run->result;
    iso_key *key = iso_cli_key(run->cli, without);
    const iso_status status = key ? iso_chart_kept_open(&run->kept, run->arguments->output, run->arguments->resume, key,
                                                        &run->bench, err)
                                  : iso_fail(err, ISO_E_MEMORY, "chart: out of memory");
    iso_key_destroy(key);
    NEED(status);
    NEED(identify_renderers(run, err));
    NEED(iso_chart_kept_take(&run->kept, &run->bench, result->cases, result->count, err));
    for (size_t i = 0; i < result->count; ++i)
        result->kept_count += result->cases[i].kept;
    result->done_count = result->kept_count;
    return ISO_OK;
}

/* Plans the deadline of the settings. Part of the time is for timing the best again, except frames of other programs,
 * which take too long. */
static void plan_time(chart_run *run)
{
    bool some_again = false;
    for (size_t r = 0; r < iso_renderer_count(); ++r)
        some_again = some_again || (run->grid.with[r] && !iso_renderer_has(iso_renderer_at(r), ISO_IS_PROGRAM));
    run->measure_until = run->end_seconds;
    if (isfinite(run->end_seconds) && some_again)
        run->measure_until -= AGAIN_PART * fmax(run->end_seconds - iso_clock_seconds(), 0);
}

static iso_status open_bench(chart_run *run, iso_error *err)
{
    const chart_arguments *a = run->arguments;
    const iso_progress progress = iso_cli_progress(run->cli);
    const iso_chart_subject subject = {run->cli->arguments[0], &a->input, run->looks, run->look_count,
                                       (size_t)a->level_count};
    NEED(iso_chart_bench_open(&run->bench, &subject, &run->grid, run->cli->threads, &progress, err));
    run->bench.processor_time = a->processor_time;
    run->bench.hasty = a->budget_seconds > 0 && a->budget_seconds < ISO_CHART_HASTY_SECONDS;
    run->bench.needs_visual = a->metric != ISO_CHART_RMSE;
    for (size_t i = 0; i < run->bench.scene_count; ++i)
        iso_cli_warn_view(run->cli, &run->bench.first, &run->bench.scenes[i].view, NULL, &(bool){false});
    return find_renderers(run, err);
}

static void end(chart_run **owned)
{
    chart_run *run = *owned;
    if (!run)
        return;
    iso_chart_cases_free(run->result.cases, run->result.count);
    iso_chart_kept_close(&run->kept);
    iso_chart_bench_close(&run->bench);
    for (size_t i = 0; i < ISO_CHART_MAX_SCENES; ++i) {
        free(run->paths[i]);
        free(run->lines[i]);
    }
    free(run);
}

/* Runs `isoshade chart`. ISO_E_DIFFERS: no measured setting has the wanted error. */
static iso_status chart(const chart_arguments *a, const iso_cli *cli, iso_error *err)
{
    ENDED_BY(end) chart_run *run = calloc(1, sizeof *run);
    NEED_MEMORY(run, err, "chart: out of memory");
    run->arguments = a;
    run->cli = cli;
    run->start_seconds = iso_clock_seconds();
    run->end_seconds = end_of_measuring(run);
    iso_chart_result *result = &run->result;
    FREED char *line = iso_cli_command_line(cli);
    *result = (iso_chart_result){.command_line = line ? line : "",
                                 .bench = &run->bench,
                                 .metric = a->metric,
                                 .bytes = a->bytes,
                                 .want = a->want,
                                 .budget_seconds = a->budget_seconds,
                                 .output = a->output,
                                 .style = a->style};
    const iso_cli_stage stages[] = {{"pyramid", 1},
                                    {"reference", 4},
                                    {"settings", a->budget_seconds > 0 ? a->budget_seconds : 60},
                                    {"the best again", 5},
                                    {"drawing", 2}};
    iso_cli_expect(cli, stages, sizeof stages / sizeof *stages);
    NEED(iso_chart_grid_parse(&a->words, &run->grid, err));
    NEED(check_looks(run, err));
    NEED(open_bench(run, err));
    NEED(iso_chart_grid_cases(&run->grid, &run->bench.first, run->bench.is_volume, run->bench.scene_count,
                              &result->cases, &result->count, err));
    NEED(take_kept(run, err));
    NEED(make_references(run, err));
    plan_time(run);
    NEED(measure_all(run, err));
    NEED(time_again(run, err));
    return finish(run, err);
}

static iso_status check(chart_arguments *a, iso_error *err)
{
    if (!a->output)
        return iso_fail(err, ISO_E_USAGE, "-o is missing: folder for the chart");
    NEED(iso_renderers_load(a->renderers, err));
    if (a->want_text)
        NEED(iso_words_parse_error("--want", a->want_text, &a->want, err));
    if (a->metric_text)
        NEED(iso_chart_metric_from_name(a->metric_text, &a->metric, err));
    a->bytes = a->bytes_text && strcmp(a->bytes_text, "stored") == 0 ? ISO_CHART_STORED : ISO_CHART_DEVICE;
    return ISO_OK;
}

/* Add the default to the text for --help; to be freed. */
static char *describe_with(const iso_option *option)
{
    char names[256], *text;
    iso_chart_default_renderers(names, sizeof names);
    return asprintf(&text, "%s (default: %s)", option->help, names) < 0 ? NULL : text;
}

static char *describe_codes(const iso_option *option)
{
    char names[256], *text;
    iso_chart_default_codes(names, sizeof names);
    return asprintf(&text, "%s (default: %s)", option->help, names) < 0 ? NULL : text;
}

static const iso_option options[] = {
    {"output", 'o', "folder for the chart", "DIR", ISO_IN(chart_arguments, output)},
    ISO_OPTIONS_OF(chart_arguments, look, iso_look_rows),
    {"want", 0, "print commands of the fastest and smallest setting within this error", "1/255",
     ISO_IN(chart_arguments, want_text)},
    {"metric", 0, "error measure: rmse (default), flip (mean), or ssim (1 - SSIM)", "METRIC",
     ISO_IN(chart_arguments, metric_text)},
    {"bytes", 0, "device (default): memory of the renderer; or stored: size of the files", "device|stored",
     ISO_IN(chart_arguments, bytes_text), .flags = ISO_ONE_OF},
    {"budget", 0, "time limit of the whole run; 0: none, measures the whole grid", "SECONDS",
     ISO_IN(chart_arguments, budget_seconds), .flags = ISO_SHOWN, .most = 1e6},
    {"with", 0, "renderers, or reference; missing default ones are left out", "LIST",
     ISO_IN(chart_arguments, words.with), .describe = describe_with},
    ISO_CLI_RENDERERS_OPTION(chart_arguments, renderers),
    {"steps", 0, "ray steps in voxels of the level", "LIST", ISO_IN(chart_arguments, words.steps), .flags = ISO_SHOWN},
    {"quadratures", 0, "of %s", "LIST", ISO_IN(chart_arguments, words.quadratures), .flags = ISO_SHOWN,
     ISO_NAMES_RENDERERS(ISO_READS_QUADRATURE)},
    {"estimators", 0, "gradient estimators for a volume; the reference uses the first", "LIST",
     ISO_IN(chart_arguments, words.estimators), .flags = ISO_SHOWN},
    {"levels", 0, "number of levels of a volume, including the finest", "N", ISO_IN(chart_arguments, level_count),
     .flags = ISO_SHOWN, .least = 1, .most = ISO_CHART_MAX_LEVELS},
    {"filters", 0, "direction filters for a volume's coarse levels", "LIST", ISO_IN(chart_arguments, words.filters),
     .flags = ISO_SHOWN},
    {"codes", 0, "direction codes", "LIST", ISO_IN(chart_arguments, words.codes), .describe = describe_codes},
    {"tfs", 0, "transfer functions of coarse levels: the scene's, adapted, or adapted 2D ones", "LIST",
     ISO_IN(chart_arguments, words.tfs), .flags = ISO_SHOWN},
    {"plans", 0, "%s: bricks of mixed resolution for these predicted errors; or none", "LIST",
     ISO_IN(chart_arguments, words.plans), .flags = ISO_SHOWN, ISO_NAMES_RENDERERS(ISO_HAS_BRICKS)},
    {"processor-time", 0, "measure processor time over all cores: for software GL on a busy machine", NULL,
     ISO_IN(chart_arguments, processor_time)},
    {"resume", 0, "continue from the measurements of an earlier chart of the same scenes", NULL,
     ISO_IN(chart_arguments, resume)},
    {"viewer", 0, "write a viewer page per scene, to which settings link", NULL, ISO_IN(chart_arguments, viewer)},
    {"style", 0, "gnuplot settings to use instead of the built-in style.gp", "STYLE.gp",
     ISO_IN(chart_arguments, style)},
    ISO_OPTIONS_OF(chart_arguments, input, iso_input_rows),
    ISO_OPTIONS_END,
};

static iso_status run(const iso_cli *cli, void *values, iso_error *err)
{
    NEED(check(values, err));
    return chart(values, cli, err);
}

const iso_command iso_command_chart = {
    .name = "chart",
    .summary = "chart speed against accuracy, and find the setting that is good enough for a scene",
    .min_arguments = 1,
    .max_arguments = 1,
    .usage = "VOLUME|PYRAMID.iso -o DIR [--scene SCENE.scene.json] [--want 1/255] [options]",
    .details =
        "Renders the scene with every renderer, step, quadrature, estimator, level, direction filter, code, other source of\n"
        "directions (floats, flipped, palettes, on the fly), transfer function and plan of mixed resolution. Errors are measured\n"
        "against one reference: level 0, converged, under the scene's own transfer function, with the directions of\n"
        "the first estimator as floats. The usual choices come first at every level and step, then settings that differ in one\n"
        "axis, in two, and so on; skipped ones are listed, and --budget 0 measures all. A setting is on the\n"
        "front if no other is both as fast (or as small) and as exact; finer steps than the level's error needs come last.\n"
        "--scene A,B measures each setting in each scene, and --want applies to all of them.\n"
        "\n"
        "Times are of one frame, the fastest of up to 5 after a warm-up; settings near the front are timed again at the\n"
        "end, in rounds. The median and the slowest are listed, too, as is the time before the frame (textures; start,\n"
        "export and reading of Blender and POV-Ray). Device bytes are the textures' sizes (gl), Blender's own\n"
        "count, POV-Ray's DF3 files, or the reference's arrays.\n"
        "\n"
        "DIR holds index.html (the chart as a page, with a picture of each setting), pareto.svg, pareto.pdf, pareto.csv,\n"
        "chart.json and reference.exr; edit style.gp there and run \"gnuplot pareto.gp\" to restyle. Exit code 1: no measured\n"
        "setting has the wanted error; the nearest is named.",
    .common =
        "output scene tf view size want metric budget with steps levels filters codes resume viewer spacing threads",
    .examples =
        "  isoshade make marschner-lobb --size 40x56x33 -o ml.nrrd\n"
        "  isoshade chart ml.nrrd --scene refscenes/marschner-lobb.scene.json --size 32 --levels 2 --with gl --codes fit,cube --steps 1,0.5 --budget 0 -o chart\n"
        "  isoshade chart ml.nrrd --scene refscenes/marschner-lobb.scene.json --size 32 --with gl --levels 2 --steps 1,0.5 --metric flip --budget 10 --json -o chart2\n",
    .lists = (const iso_names *const[]){&iso_code_names, &iso_direction_filter_names, &iso_gradient_names,
                                        &iso_tf_preset_names, &iso_viewpoint_names, NULL},
    ISO_COMMAND_OPTIONS(chart_arguments, options, .words = ISO_CHART_DEFAULT_WORDS, .level_count = 3,
                        .budget_seconds = 120),
    .run = run,
};

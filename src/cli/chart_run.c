/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "cli/chart_run.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/parallel.h"
#include "base/provenance.h"
#include "chart/kept.h"
#include "chart/order.h"
#include "options/visible.h"
#include "view/viewer.h"

typedef struct chart_run {
    const iso_chart_arguments *arguments;
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

/* Leaves out renderers that do not answer; one that --with names must answer. If none is left, the CPU ray caster takes
 * their place. */
static iso_status find_renderers(chart_run *run, iso_error *err)
{
    iso_chart_result *result = &run->result;
    const size_t usual = iso_renderer_index(iso_renderers_usual()),
                 instead = iso_renderer_index(iso_renderers_instead());
    bool any = false;
    iso_status status = ISO_OK;
    for (size_t r = 0; r < iso_renderer_count() && status == ISO_OK; ++r) {
        iso_error why = {""};
        if (!run->grid.with[r])
            continue;
        if (run->grid.optional[r] && is_too_slow_to_begin(run, iso_renderer_at(r))) {
            snprintf(result->left_out[r], sizeof result->left_out[r], "its first picture would take most of the %g s",
                     run->arguments->budget_seconds);
            run->grid.with[r] = false;
            continue;
        }
        status = iso_renderer_at(r)->version(iso_renderer_at(r), &run->bench.renderers, result->versions[r],
                                             sizeof result->versions[r], &why);
        if (status != ISO_OK && run->grid.optional[r]) {
            snprintf(result->left_out[r], sizeof result->left_out[r], "%.300s", why.text);
            run->grid.with[r] = false;
            status = ISO_OK;
        } else if (status != ISO_OK) {
            status = iso_fail(err, status, "%s", why.text);
        }
        const iso_renderer_info *renderer = iso_renderer_at(r);
        if (status == ISO_OK && !iso_renderer_has(renderer, ISO_HAS_PROCESSOR_TIME) && run->grid.with[r] &&
            run->bench.processor_time) {
            status = run->grid.optional[r]
                         ? ISO_OK
                         : iso_fail(err, ISO_E_USAGE, "--processor-time: %s does not report it per frame",
                                    renderer->title);
            snprintf(result->left_out[r], sizeof result->left_out[r], "%s does not report processor time per frame",
                     renderer->title);
            run->grid.with[r] = false;
        }
        any = any || run->grid.with[r];
    }
    if (status == ISO_OK && !any && run->grid.optional[usual]) {
        any = run->grid.with[instead] = true;
        status = iso_renderers_instead()->version(iso_renderers_instead(), &run->bench.renderers,
                                                  result->versions[instead], sizeof result->versions[instead], err);
    }
    if (status == ISO_OK && !any)
        return iso_fail(err, ISO_E_MISSING, "no renderer answers: %s",
                        result->left_out[usual]);
    return status;
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
        if (r->cases[j].done && r->cases[j].scene == c->scene && AGAIN_FACTOR * r->cases[j].took.seconds < c->took.seconds &&
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
    iso_status status = ISO_OK;
    for (size_t k = 0;
         k < rounds * result->count && status == ISO_OK && has_time_for_rounds(run->arguments->budget_seconds); ++k) {
        iso_chart_case *c = &result->cases[k % result->count];
        iso_progress_report(&progress, "the best again", (double)k / (double)(rounds * result->count));
        if (iso_clock_seconds() + iso_chart_bench_estimate(&run->bench, c) < run->end_seconds &&
            is_worth_timing_again(result, c)) {
            status = iso_chart_bench_time_again(&run->bench, c, err);
            TRY(status, iso_chart_kept_put(&run->kept, &run->bench, c, err));
        }
    }
    iso_progress_report(&progress, "the best again", 1);
    return status;
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
    iso_status status = ISO_OK;
    for (size_t i; status == ISO_OK && (i = iso_chart_next(result->cases, result->count, &outlook)) < result->count;) {
        iso_chart_case *c = &result->cases[i];
        iso_error why = {""};
        iso_progress_report(&progress, "settings", part_done(run, start_seconds, run->measure_until));
        const iso_status one = iso_chart_bench_measure(&run->bench, c, &why);
        result->done_count += c->done;
        c->refused = !c->done;
        if (one != ISO_OK)
            status = take_failure(run, c, one, &why, err);
        else
            status = iso_chart_kept_put(&run->kept, &run->bench, c, err);
    }
    iso_progress_report(&progress, "settings", 1);
    if (status == ISO_OK && result->done_count == 0)
        return iso_fail(err, ISO_E_RANGE, "no setting could be rendered: %s", result->refusal);
    return status;
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
    json_t *json = iso_chart_result_json(result);
    iso_status status = iso_chart_result_write(result, run->kept.output.temp_path, json, err);
    TRY(status, iso_chart_kept_commit(&run->kept, err));
    result->spent_seconds = iso_clock_seconds() - run->start_seconds;
    iso_progress_line_hide(run->cli->progress);
    if (status == ISO_OK && !run->cli->json)
        iso_chart_result_print(result);
    if (status == ISO_OK && run->cli->json)
        iso_cli_print_json(json);
    else
        json_decref(json);
    if (status == ISO_OK && result->want > 0 && result->fastest == result->done_count)
        return iso_fail(err, ISO_E_DIFFERS, "no measured setting has %s of %.4g or less; the least is %.4g",
                        iso_chart_metric_name(result->metric), result->want,
                        result->best < result->done_count ? iso_chart_worst_error(result, &result->cases[result->best])
                                                          : NAN);
    return status;
}

/* ---- scenes ---- */

/* Makes a look for each scene of --scene A,B. */
static iso_status check_looks(chart_run *run, iso_error *err)
{
    iso_cli_look look = run->arguments->look;
    char *list = strdup(look.scene ? look.scene : ""), *rest = list;
    iso_status status = list ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "chart: out of memory");
    for (char *path; status == ISO_OK && (path = strsep(&rest, ","));) {
        const size_t n = run->look_count;
        if (n == ISO_CHART_MAX_SCENES) {
            status = iso_fail(err, ISO_E_USAGE, "--scene: more than %d scenes", ISO_CHART_MAX_SCENES);
            break;
        }
        look.scene = look.scene ? run->paths[n] = strdup(path) : NULL;
        status = iso_cli_look_check(&look, run->cli->threads, &run->looks[n], err);
        run->lines[n] = iso_cli_look_line(&look);
        run->result.looks[n] = run->lines[n] ? run->lines[n] : "";
        ++run->look_count;
    }
    free(list);
    return status;
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
    iso_status status = key ? iso_chart_kept_open(&run->kept, run->arguments->output, run->arguments->resume, key,
                                                  &run->bench, err)
                            : iso_fail(err, ISO_E_MEMORY, "chart: out of memory");
    iso_key_destroy(key);
    TRY(status, identify_renderers(run, err));
    TRY(status, iso_chart_kept_take(&run->kept, &run->bench, result->cases, result->count, err));
    for (size_t i = 0; i < result->count && status == ISO_OK; ++i)
        result->kept_count += result->cases[i].kept;
    result->done_count = result->kept_count;
    return status;
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
    const iso_chart_arguments *a = run->arguments;
    const iso_progress progress = iso_cli_progress(run->cli);
    const iso_chart_subject subject = {run->cli->arguments[0], &a->input, run->looks, run->look_count,
                                       (size_t)a->level_count};
    iso_status status = iso_chart_bench_open(&run->bench, &subject, &run->grid, run->cli->threads, &progress, err);
    run->bench.processor_time = a->processor_time;
    run->bench.hasty = a->budget_seconds > 0 && a->budget_seconds < ISO_CHART_HASTY_SECONDS;
    run->bench.needs_visual = a->metric != ISO_CHART_RMSE;
    for (size_t i = 0; i < run->bench.scene_count && status == ISO_OK; ++i)
        iso_cli_warn_view(run->cli, &run->bench.first, &run->bench.scenes[i].view, NULL, &(bool){false});
    TRY(status, find_renderers(run, err));
    return status;
}

static void end(chart_run *run)
{
    iso_chart_cases_free(run->result.cases, run->result.count);
    iso_chart_kept_close(&run->kept);
    iso_chart_bench_close(&run->bench);
    for (size_t i = 0; i < ISO_CHART_MAX_SCENES; ++i) {
        free(run->paths[i]);
        free(run->lines[i]);
    }
    free(run);
}

iso_status iso_cli_chart(const iso_chart_arguments *a, const iso_cli *cli, iso_error *err)
{
    chart_run *run = calloc(1, sizeof *run);
    if (!run)
        return iso_fail(err, ISO_E_MEMORY, "chart: out of memory");
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
    iso_status status = iso_chart_grid_parse(&a->words, &run->grid, err);
    TRY(status, check_looks(run, err));
    TRY(status, open_bench(run, err));
    TRY(status, iso_chart_grid_cases(&run->grid, &run->bench.first, run->bench.is_volume, run->bench.scene_count,
                                     &result->cases, &result->count, err));
    TRY(status, take_kept(run, err));
    TRY(status, make_references(run, err));
    plan_time(run);
    TRY(status, measure_all(run, err));
    TRY(status, time_again(run, err));
    TRY(status, finish(run, err));
    end(run);
    return status;
}

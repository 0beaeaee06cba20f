/* SPDX-License-Identifier: MIT */
/* cmd_chart.c - speed against accuracy: a grid of settings on one scene, its front, and the setting that is good enough. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "chart/bench.h"
#include "cli/chart_across.h"
#include "chart/grid.h"
#include "chart/result.h"
#include "options/cli.h"
#include "options/input.h"
#include "options/look.h"
#include "options/visible.h"
#include "scene/subject.h"
#include "scene/viewpoint.h"
#include "tf/presets.h"
#include "renderers/external.h"

typedef struct chart_arguments {
    iso_volume_input input;
    iso_cli_look look;
    char *output, *renderers, *want_text, *style, *metric_text, *bytes_text;
    iso_chart_words words;
    char *designs;
    int level_count, processor_time, across_levels, views;
    double budget_seconds; /* 0: none, the whole grid is tried */
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
    double start_seconds;
} chart_run;

/* Two pictures by gnuplot, and the files. */
static double seconds_for_drawing(double budget_seconds)
{
    return fmin(3, 0.2 * budget_seconds);
}

/* When the last setting has to be done. */
static double end_of_measuring(const chart_run *run)
{
    const double budget_seconds = run->arguments->budget_seconds;
    return budget_seconds > 0 ? run->start_seconds + budget_seconds - seconds_for_drawing(budget_seconds) : INFINITY;
}

/* A renderer that nobody asked for by name is left out where it does not answer; one that was asked for has to be there. */
static iso_status find_renderers(chart_run *run, iso_error *err)
{
    iso_chart_result *result = &run->result;
    bool any = false;
    iso_status status = ISO_OK;
    for (size_t r = 0; r < iso_renderer_count() && status == ISO_OK; ++r) {
        iso_error why = {""};
        if (!run->grid.with[r])
            continue;
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
                         : iso_fail(err, ISO_E_USAGE, "--processor-time: %s does not say that of a frame",
                                    renderer->title);
            snprintf(result->left_out[r], sizeof result->left_out[r], "%s does not say the processor time of a frame",
                     renderer->title);
            run->grid.with[r] = false;
        }
        any = any || run->grid.with[r];
    }
    if (status == ISO_OK && !any)
        return iso_fail(err, ISO_E_MISSING, "none of the renderers answers: %s",
                        result->left_out[iso_renderer_index(iso_renderers_usual())]);
    return status;
}

/* What happens to a setting that fails: its renderer is left out when nobody asked for it; a setting beyond a limit, such as
 * the size of a texture, is one less; all else ends the chart. */
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

/* Part of the time for settings in which the best are timed again. */
static const double AGAIN_PART = 0.15;
/* Settings are timed again that would be on the front were they so many times as fast: what else the machine did may have
 * kept them off it. */
static const double AGAIN_FACTOR = 2.5;

static bool is_worth_timing_again(const iso_chart_result *r, const iso_chart_case *c)
{
    const double error = iso_chart_error(c, r->metric);
    if (!c->done || iso_renderer_has(c->renderer, ISO_IS_PROGRAM) || !isfinite(error))
        return false;
    for (size_t j = 0; j < r->count; ++j)
        if (r->cases[j].done && AGAIN_FACTOR * r->cases[j].took.seconds < c->took.seconds &&
            iso_chart_error(&r->cases[j], r->metric) <= error)
            return false;
    return true;
}

/* Budgets too short for it leave each setting with its first frames. */
static bool has_time_for_rounds(double budget_seconds)
{
    return !(budget_seconds > 0) || budget_seconds > 1;
}

/* In rounds, so that a moment in which the machine was busy meets each setting once. */
static iso_status time_again(chart_run *run, double end_seconds, iso_error *err)
{
    enum { rounds = 2 };
    iso_progress progress = iso_cli_progress(run->cli);
    iso_chart_result *result = &run->result;
    iso_status status = ISO_OK;
    for (size_t k = 0;
         k < rounds * result->count && status == ISO_OK && has_time_for_rounds(run->arguments->budget_seconds); ++k) {
        iso_chart_case *c = &result->cases[k % result->count];
        iso_progress_report(&progress, "the best again", (double)k / (double)(rounds * result->count));
        if (iso_clock_seconds() + iso_chart_bench_foresee(&run->bench, c) < end_seconds &&
            is_worth_timing_again(result, c))
            status = iso_chart_bench_time_again(&run->bench, c, err);
    }
    iso_progress_report(&progress, "the best again", 1);
    return status;
}

/* Of the time for settings, with those from `first` on as they are foreseen, or what the budget leaves. */
static double part_done(const chart_run *run, size_t first, double start_seconds, double end_seconds)
{
    const double now = iso_clock_seconds(), spent = now - start_seconds;
    double left = 0;
    for (size_t i = first; i < run->result.count; ++i)
        left += run->grid.with[iso_renderer_index(run->result.cases[i].renderer)]
                    ? iso_chart_bench_foresee(&run->bench, &run->result.cases[i])
                    : 0;
    left = fmin(left, fmax(end_seconds - now, 0));
    return spent + left > 0 ? spent / (spent + left) : 1;
}

/* In their order, those that fit into what is left of the budget; the first in any case. */
static iso_status measure_all(chart_run *run, double end_seconds, iso_error *err)
{
    iso_progress progress = iso_cli_progress(run->cli);
    iso_chart_result *result = &run->result;
    const double start_seconds = iso_clock_seconds();
    iso_status status = ISO_OK;
    for (size_t i = 0; i < result->count && status == ISO_OK; ++i) {
        iso_chart_case *c = &result->cases[i];
        iso_error why = {""};
        const double left_seconds = end_seconds - iso_clock_seconds();
        iso_progress_report(&progress, "settings", part_done(run, i, start_seconds, end_seconds));
        if (!run->grid.with[iso_renderer_index(c->renderer)] ||
            (result->done_count > 0 && iso_chart_bench_foresee(&run->bench, c) > left_seconds))
            continue;
        const iso_status one = iso_chart_bench_measure(&run->bench, c, &why);
        result->done_count += c->done;
        if (one != ISO_OK)
            status = take_failure(run, c, one, &why, err);
    }
    iso_progress_report(&progress, "settings", 1);
    if (status == ISO_OK && result->done_count == 0)
        return iso_fail(err, ISO_E_RANGE, "no setting could be rendered: %s", result->refusal);
    return status;
}

static iso_status finish(chart_run *run, iso_error *err)
{
    iso_chart_result *result = &run->result;
    iso_status status = iso_chart_result_sort(result, err);
    if (status != ISO_OK)
        return status;
    result->spent_seconds = iso_clock_seconds() - run->start_seconds;
    const iso_progress progress = iso_cli_progress(run->cli);
    iso_progress_report(&progress, "drawing", 0);
    json_t *json = iso_chart_result_json(result);
    status = iso_chart_result_write(result, json, err);
    result->spent_seconds = iso_clock_seconds() - run->start_seconds;
    iso_progress_line_hide(run->cli->progress);
    if (status == ISO_OK && !run->cli->json)
        iso_chart_result_print(result);
    if (status == ISO_OK && run->cli->json)
        iso_cli_print_json(json);
    else
        json_decref(json);
    if (status == ISO_OK && result->want > 0 && result->fastest == result->done_count)
        return iso_fail(err, ISO_E_DIFFERS, "no setting that was tried has %s of %.4g or less; the least is %.4g",
                        iso_chart_metric_name(result->metric), result->want,
                        result->best < result->done_count
                            ? iso_chart_error(&result->cases[result->best], result->metric)
                            : NAN);
    return status;
}

static iso_status chart(const chart_arguments *a, const iso_cli *cli, iso_error *err)
{
    const iso_progress progress = iso_cli_progress(cli);
    chart_run *run = calloc(1, sizeof *run);
    if (!run)
        return iso_fail(err, ISO_E_MEMORY, "chart: out of memory");
    run->arguments = a;
    run->cli = cli;
    run->start_seconds = iso_clock_seconds();
    iso_chart_result *result = &run->result;
    iso_subject_look look;
    char *line = iso_cli_command_line(cli), *shown = iso_cli_look_line(&a->look);
    *result = (iso_chart_result){.command_line = line ? line : "",
                                 .bench = &run->bench,
                                 .metric = a->metric,
                                 .bytes = a->bytes,
                                 .want = a->want,
                                 .budget_seconds = a->budget_seconds,
                                 .scene = a->look.scene ? a->look.scene : "first picture",
                                 .look = shown ? shown : "",
                                 .output = a->output,
                                 .style = a->style};
    const iso_cli_stage stages[] = {{"pyramid", 1},
                                    {"reference", 4},
                                    {"settings", a->budget_seconds > 0 ? a->budget_seconds : 60},
                                    {"the best again", 5},
                                    {"drawing", 2}};
    iso_cli_expect(cli, stages, sizeof stages / sizeof *stages);
    iso_status status = iso_chart_grid_parse(&a->words, &run->grid, err);
    if (status == ISO_OK)
        status = iso_cli_look_check(&a->look, cli->threads, &look, err);
    if (status == ISO_OK)
        status = iso_chart_bench_open(&run->bench,
                                      &(iso_chart_subject){cli->arguments[0], &a->input, &look, (size_t)a->level_count},
                                      &run->grid, cli->threads, &progress, err);
    run->bench.processor_time = a->processor_time;
    if (status == ISO_OK)
        iso_cli_warn_of_view(cli, &run->bench.first, &run->bench.view, NULL, &(bool){false});
    if (status == ISO_OK)
        status = find_renderers(run, err);
    if (status == ISO_OK)
        status = iso_chart_grid_cases(&run->grid, &run->bench.first, run->bench.is_volume, &result->cases,
                                      &result->count, err);
    if (status == ISO_OK)
        status = iso_chart_bench_reference(&run->bench, err);
    const double end_seconds = end_of_measuring(run);
    bool some_again = false; /* frames of programs take too long to be timed again */
    for (size_t r = 0; r < iso_renderer_count(); ++r)
        some_again = some_again || (run->grid.with[r] && !iso_renderer_has(iso_renderer_at(r), ISO_IS_PROGRAM));
    double again_seconds = 0;
    if (isfinite(end_seconds) && some_again)
        again_seconds = AGAIN_PART * fmax(end_seconds - iso_clock_seconds(), 0);
    if (status == ISO_OK)
        status = measure_all(run, end_seconds - again_seconds, err);
    if (status == ISO_OK)
        status = time_again(run, end_seconds, err);
    if (status == ISO_OK)
        status = finish(run, err);
    free(result->cases);
    iso_chart_bench_close(&run->bench);
    free(line);
    free(shown);
    free(run);
    return status;
}

static iso_status check(chart_arguments *a, iso_error *err)
{
    if (!a->output)
        return iso_fail(err, ISO_E_USAGE, "-o is missing: the folder for the chart");
    iso_status status = iso_renderers_load(a->renderers, err);
    if (status == ISO_OK)
        status = iso_words_check_range("--levels", a->level_count, 1, ISO_CHART_MAX_LEVELS, err);
    if (status == ISO_OK)
        status = iso_words_check_range("--budget", a->budget_seconds, 0, 1e6, err);
    if (status == ISO_OK && a->want_text)
        status = iso_words_parse_error("--want", a->want_text, &a->want, err);
    if (status == ISO_OK && a->metric_text)
        status = iso_chart_metric_from_name(a->metric_text, &a->metric, err);
    if (status == ISO_OK && a->bytes_text) {
        a->bytes = strcmp(a->bytes_text, "stored") == 0 ? ISO_CHART_STORED : ISO_CHART_DEVICE;
        if (a->bytes == ISO_CHART_DEVICE && strcmp(a->bytes_text, "device") != 0)
            status = iso_fail(err, ISO_E_USAGE, "--bytes is \"%s\", wanted device or stored", a->bytes_text);
    }
    return status;
}

/* "words (default: LIST)" for --help. */
static const char *with_default(char *text, size_t size, const char *words, const char *list)
{
    snprintf(text, size, "%s (default: %s)", words, list);
    return text;
}

static iso_status run(const iso_command *self, int argc, const char **argv, iso_error *err)
{
    chart_arguments a = {.level_count = 3, .budget_seconds = 120, .views = 6};
    const iso_chart_words *usual = &iso_chart_default_words;
    char help[8][256], codes[200], renderers[256], quadratures[128], plans[200], names[100];
    snprintf(quadratures, sizeof quadratures, "of %s",
             iso_renderers_with(ISO_READS_QUADRATURE, ", ", " and ", names, sizeof names));
    snprintf(plans, sizeof plans, "%s: bricks of mixed resolution, planned for these predicted errors; or none",
             iso_renderers_with(ISO_HAS_BRICKS, ", ", " and ", names, sizeof names));
    iso_volume_input_defaults(&a.input);
    struct poptOption options[] = {
        {"output", 'o', POPT_ARG_STRING, &a.output, 0, "the folder for the chart", "DIR"},
        ISO_CLI_LOOK_OPTIONS(&a.look),
        {"want", 0, POPT_ARG_STRING, &a.want_text, 0,
         "name the fastest and the smallest setting with this error or less, as command lines", "1/255"},
        {"metric", 0, POPT_ARG_STRING, &a.metric_text, 0, "the error: rmse (default), flip (mean), or ssim (1 - SSIM)",
         "METRIC"},
        {"bytes", 0, POPT_ARG_STRING, &a.bytes_text, 0,
         "device (default): what the renderer holds; or stored: the level in files", "WHICH"},
        {"budget", 0, POPT_ARG_DOUBLE | POPT_ARGFLAG_SHOW_DEFAULT, &a.budget_seconds, 0,
         "for everything, from reading to drawing; the reference and one setting are made in any case; 0: no limit, the whole grid is tried",
         "SECONDS"},
        {"with", 0, POPT_ARG_STRING, &a.words.with, 0,
         with_default(help[0], sizeof *help,
                      "renderers; also reference. Those of the default are left out where missing",
                      iso_chart_default_renderers(renderers, sizeof renderers)),
         "LIST"},
        ISO_CLI_RENDERERS_OPTION(&a.renderers),
        {"steps", 0, POPT_ARG_STRING, &a.words.steps, 0,
         with_default(help[1], sizeof *help, "ray steps in voxels of the level", usual->steps), "LIST"},
        {"quadratures", 0, POPT_ARG_STRING, &a.words.quadratures, 0,
         with_default(help[2], sizeof *help, quadratures, usual->quadratures), "LIST"},
        {"estimators", 0, POPT_ARG_STRING, &a.words.estimators, 0,
         with_default(help[3], sizeof *help, "of a volume's gradients; the first makes the reference's",
                      usual->estimators),
         "LIST"},
        {"levels", 0, POPT_ARG_INT | POPT_ARGFLAG_SHOW_DEFAULT, &a.level_count, 0,
         "levels of a volume, the finest included", "N"},
        {"filters", 0, POPT_ARG_STRING, &a.words.filters, 0,
         with_default(help[4], sizeof *help, "of directions of a volume's coarse levels", usual->filters), "LIST"},
        {"codes", 0, POPT_ARG_STRING, &a.words.codes, 0,
         with_default(help[5], sizeof *help, "of directions", iso_chart_default_codes(codes, sizeof codes)), "LIST"},
        {"tfs", 0, POPT_ARG_STRING, &a.words.tfs, 0,
         with_default(help[6], sizeof *help,
                      "transfer functions of coarse levels: the scene's, the level's own, 2D ones of the level",
                      usual->tfs),
         "LIST"},
        {"plans", 0, POPT_ARG_STRING, &a.words.plans, 0, with_default(help[7], sizeof *help, plans, usual->plans),
         "LIST"},
        {"processor-time", 0, POPT_ARG_NONE, &a.processor_time, 0,
         "of frames, over all cores, instead of the clock's: software GL on a busy machine", NULL},
        {"across-levels", 0, POPT_ARG_NONE, &a.across_levels, 0,
         "designs of coarse levels instead: scalar and direction filters, transfer functions, extinction scales", NULL},
        {"designs", 0, POPT_ARG_STRING, &a.designs, 0,
         "--across-levels: names with commas between them, of bench levels --help; the first is what others are divided by",
         "LIST"},
        {"views", 0, POPT_ARG_INT | POPT_ARGFLAG_SHOW_DEFAULT, &a.views, 0,
         "--across-levels: of an icosahedron's faces, at most 20", "N"},
        {"style", 0, POPT_ARG_STRING, &a.style, 0, "gnuplot settings instead of the built-in style.gp", "STYLE.gp"},
        ISO_CLI_INPUT_OPTIONS(&a.input),
        POPT_TABLEEND,
    };
    iso_cli cli;
    iso_cli_next next;
    iso_status status = iso_cli_parse(&cli, self, argc, argv, options, &next, err);
    if (status == ISO_OK && next == ISO_CLI_RUN)
        status = check(&a, err);
    const iso_chart_across across = {.cli = &cli,
                                     .input = &a.input,
                                     .look = &a.look,
                                     .output = a.output,
                                     .style = a.style,
                                     .designs = a.designs,
                                     .metric = a.metric_text ? a.metric : ISO_CHART_SSIM,
                                     .level_count = a.level_count,
                                     .views = a.views};
    if (status == ISO_OK && next == ISO_CLI_RUN)
        status = a.across_levels ? iso_cli_chart_across(&across, err) : chart(&a, &cli, err);
    iso_cli_end(&cli);
    return status;
}

const iso_command iso_command_chart = {
    .name = "chart",
    .summary = "speed against accuracy: which setting is good enough for a scene",
    .min_arguments = 1,
    .max_arguments = 1,
    .usage = "VOLUME|PYRAMID.iso -o DIR [--scene SCENE.scene.json] [--want 1/255] [options]",
    .details =
        "Renders the scene with every renderer, step, quadrature, estimator, level, direction filter, code, other source of\n"
        "directions (floats, flipped, palettes, on the fly), transfer function and plan of mixed resolution. The error is\n"
        "against one truth: the converged reference of level 0 under the scene's own transfer function, with the directions of\n"
        "the first estimator as floats. First the usual choices at every level and step, then what departs from them in one\n"
        "axis, then in two ...; what does not fit into the budget is named, and --budget 0 tries everything. A setting is on the\n"
        "front when no other is both as fast (or as small) and as exact.\n"
        "\n"
        "Times are of the frame alone: the fastest of up to 5, after a warm-up; those near the front are timed again at the\n"
        "end, in rounds. The median and the slowest stand beside it, as does what came before the frame (textures; start,\n"
        "export and reading of Blender and POV-Ray). Device bytes are all textures by their formats (gl), Blender's own\n"
        "account, POV-Ray's DF3 files, the reference's arrays.\n"
        "\n"
        "--across-levels is about coarse levels alone: each design of what they store and how they are shown, from --views\n"
        "against level 0, as rendered and minified, so that a pixel is about a voxel of the level. It draws across.svg:\n"
        "bytes and time against that error, and the designs one beside the other; what --auto would choose is ringed.\n"
        "\n"
        "DIR holds pareto.svg, pareto.pdf, pareto.csv, chart.json and reference.exr; edit style.gp there and run\n"
        "\"gnuplot pareto.gp\" to restyle. Exit code 1: no setting that was tried has the wanted error; the nearest is named.",
    .examples =
        "  isoshade make marschner-lobb --size 40x56x33 -o ml.nrrd\n"
        "  isoshade chart ml.nrrd --scene refscenes/marschner-lobb.scene.json --size 32 --levels 2 --with gl --codes fit,cube --steps 1,0.5 --budget 0 --want 1/255 -o chart\n"
        "  isoshade chart ml.nrrd --scene refscenes/marschner-lobb.scene.json --size 32 --with gl --levels 2 --steps 1,0.5 --metric flip --budget 10 --json -o chart2\n"
        "  isoshade chart ml.nrrd --across-levels --scene refscenes/marschner-lobb.scene.json --size 48 --views 1 --designs default,damped,scaled -o chart3\n",
    .lists = (const iso_names *const[]){&iso_code_names, &iso_direction_filter_names, &iso_gradient_names,
                                        &iso_tf_preset_names, &iso_viewpoint_names, NULL},
    .run = run,
};

/* cmd_chart.c - speed against accuracy: a grid of settings on one scene, its front, and the setting that is good enough. */
#define _GNU_SOURCE
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/embed.h"
#include "base/file.h"
#include "base/parallel.h"
#include "cli/chart_grid.h"
#include "cli/cli.h"
#include "cli/palette_level.h"
#include "cli/renderers.h"
#include "cli/subject.h"
#include "compare/chart.h"
#include "compare/metrics.h"
#include "compare/pareto.h"
#include "render/bricks_gl.h"
#include "render/plan.h"
#include "tf/adapt.h"

ISO_EMBED(pareto_gp, "src/compare/pareto.gp");

typedef struct chart_arguments {
    iso_cli_input input;
    char *scene, *output, *size, *want_text, *style;
    iso_chart_words words;
    int level_count;
    double budget_seconds;
    double want; /* 0: none */
} chart_arguments;

typedef struct chart_run {
    iso_chart_pyramids pyramids; /* by estimator and filter; empty where not asked for */
    iso_gradient_method first_estimator;
    iso_direction_filter first_filter; /* of the pyramids that are there */
    iso_view view;
    iso_tf_table adapted[64]; /* one a level, from 1 on */
    iso_class_tables tables[64][2]; /* the same over deviation and over gradient */
    iso_palette palettes[ISO_CHART_PALETTES];
    iso_node_levels nodes;       /* bricks, where the grid has plans */
    iso_plan plan;
    iso_renderers renderers;
    iso_image reference;
    iso_chart_case *cases;
    size_t count, done_count;
    double start_seconds, reference_seconds; /* the settings start after the reference */
} chart_run;

/* Fits those palettes that the grid asks for, with few swaps: a chart has no time for the last per cent. */
static iso_status fit_palettes(chart_run *run, int threads, iso_error *err)
{
    iso_status status = ISO_OK;
    for (size_t i = 0; i < run->count && status == ISO_OK; ++i) {
        const iso_chart_case *c = &run->cases[i];
        const iso_pyramid *p = &run->pyramids[c->estimator][c->filter];
        iso_palette *palette = &run->palettes[c->palette];
        if (c->source == ISO_FROM_PALETTE && !palette->xyz)
            status = iso_cli_fit_palette(&p->levels[0], p->options.code, iso_chart_palettes[c->palette], 2, threads, palette, err);
    }
    return status;
}

/* The pyramid with one level's directions in the wanted code or palette; `codes` is to be freed, and is NULL where nothing changed. */
static iso_status with_code(const iso_pyramid *p, const iso_chart_case *c, const iso_palette *palettes, iso_level *levels,
                            iso_pyramid *out, uint8_t **codes, iso_error *err)
{
    *out = *p;
    *codes = NULL;
    if (c->source == ISO_FROM_PALETTE) {
        memcpy(levels, p->levels, p->level_count * sizeof *levels);
        out->levels = levels;
        return iso_cli_attach_palette(&levels[c->level], p->options.code, &palettes[c->palette], err);
    }
    if (c->source != ISO_FROM_CODES || c->code == p->options.code)
        return ISO_OK;
    size_t count = iso_geometry_voxel_count(&p->levels[c->level].geometry);
    *codes = malloc(3 * count);
    if (!*codes)
        return iso_fail(err, ISO_E_MEMORY, "chart: no memory for %zu directions", count);
    memcpy(levels, p->levels, p->level_count * sizeof *levels);
    iso_code_encode(c->code, p->levels[c->level].directions, *codes, count);
    levels[c->level].codes = *codes;
    out->levels = levels;
    out->options.code = c->code;
    return ISO_OK;
}

/* Bricks of 16 voxels and three levels suit volumes from a chart's small ones on. */
static iso_status make_plan(chart_run *run, const iso_chart_grid *g, const iso_cli *cli, iso_error *err)
{
    enum { brick_voxels = 16, levels = 3 };
    iso_progress progress = iso_cli_progress(cli);
    if (g->plan_count == 0 || !g->with[ISO_WITH_GL])
        return ISO_OK;
    const iso_level *level0 = &run->pyramids[run->first_estimator][run->first_filter].levels[0];
    iso_status status = iso_node_levels_create(&run->nodes, level0, brick_voxels, levels, true, cli->threads, err);
    if (status != ISO_OK)
        return status;
    iso_node_levels_round(&run->nodes);
    return iso_plan_create(&run->plan, &run->nodes, &run->view, 1, cli->threads, &progress, err);
}

/* Bricks by the plan for the setting's error, as `isoshade plan` first tries them. */
static iso_status render_plan(chart_run *run, iso_chart_case *c, iso_image *image, double *seconds, iso_error *err)
{
    enum { bytes_a_node = 10 }; /* 16 bits of the scalar, and of a direction in four channels */
    iso_status status = iso_renderers_need_gl(&run->renderers, err);
    if (status != ISO_OK)
        return status;
    iso_plan_choose(&run->plan, &run->nodes, c->plan_error);
    uint8_t *wanted = malloc(run->plan.brick_count);
    if (!wanted)
        return iso_fail(err, ISO_E_MEMORY, "chart: no memory for %zu bricks", run->plan.brick_count);
    for (size_t i = 0; i < run->plan.brick_count; ++i)
        wanted[i] = run->plan.footprints[i] > 0;
    const iso_brick_field field = {.nodes = &run->nodes, .levels = run->plan.levels, .faces = ISO_FACES_BAKED};
    iso_gl_brick_options opt = iso_gl_brick_defaults();
    iso_gl_brick_stats stats;
    opt.wanted = wanted;
    opt.step_voxels = c->step_voxels;
    status = iso_gl_render_bricks(run->renderers.gl, &field, &run->view, &opt, image, &stats, err);
    c->bytes = bytes_a_node * (double)stats.node_count;
    *seconds = stats.seconds;
    free(wanted);
    return status;
}

/* Renders once, and again while that is short: the time is that of the fastest. */
static iso_status measure(chart_run *run, iso_chart_case *c, int threads, iso_error *err)
{
    const iso_pyramid *base = &run->pyramids[c->estimator][c->filter];
    iso_render_options opt = iso_render_defaults(c->renderer);
    opt.source = c->source;
    opt.quadrature = c->preintegrated ? ISO_QUADRATURE_PREINTEGRATED : ISO_QUADRATURE_MIDPOINT;
    opt.step_voxels = c->step_voxels;
    opt.threads = threads;
    iso_level levels[64];
    iso_pyramid p;
    iso_view view = run->view; /* borrowed, but for an adapted transfer function */
    uint8_t *codes = NULL;
    if (c->adapted)
        view.tf = run->adapted[c->level];
    if (c->table != ISO_SPLIT_NONE)
        view.classes = &run->tables[c->level][c->table - ISO_SPLIT_DEVIATION];
    iso_status status = c->plan_error > 0 ? ISO_OK : with_code(base, c, run->palettes, levels, &p, &codes, err);
    c->seconds = INFINITY;
    for (int k = 0; k < 3 && status == ISO_OK && (k == 0 || c->seconds < 0.2); ++k) {
        iso_image image;
        double seconds;
        if (c->plan_error > 0)
            status = render_plan(run, c, &image, &seconds, err);
        else
            status = iso_render_with(&run->renderers, &p, c->level, &view, &opt, &image, &seconds, NULL, err);
        if (status == ISO_OK && k == 0)
            status = iso_metrics_measure(&run->reference, &image, &c->metrics, err);
        if (status == ISO_OK)
            c->seconds = fmin(c->seconds, seconds);
        iso_image_destroy(&image);
    }
    free(codes);
    if (c->source == ISO_FROM_PALETTE)
        iso_cli_detach_palette(&levels[c->level]);
    c->done = status == ISO_OK;
    return status;
}

/* The cheapest one, and the next while they fit: the time of one is foreseen by the slowest rate seen of its renderer. */
static iso_status measure_all(chart_run *run, const chart_arguments *a, const iso_cli *cli, iso_error *err)
{
    iso_progress progress = iso_cli_progress(cli);
    double rate[ISO_RENDERER_COUNT] = {0};
    iso_status status = ISO_OK;
    for (size_t i = 0; i < run->count && status == ISO_OK; ++i) {
        iso_chart_case *c = &run->cases[i];
        double start = iso_clock_seconds(), spent = start - run->start_seconds;
        iso_progress_report(&progress, "settings", fmax((double)i / (double)run->count, spent / a->budget_seconds));
        if (run->done_count > 0 && spent + rate[c->renderer] * c->relative_cost > a->budget_seconds)
            continue;
        status = measure(run, c, cli->threads, err);
        run->done_count += c->done;
        rate[c->renderer] = fmax(0.5 * rate[c->renderer], (iso_clock_seconds() - start) / c->relative_cost);
    }
    iso_progress_report(&progress, "settings", 1);
    return status;
}

/* Keeps the settings that were measured, and marks the fronts. chosen[0] is the fastest, chosen[1] the smallest. */
static iso_status find_fronts(chart_run *run, double want, size_t chosen[2], iso_error *err)
{
    size_t n = 0;
    for (size_t i = 0; i < run->count; ++i)
        if (run->cases[i].done)
            run->cases[n++] = run->cases[i];
    double *seconds = calloc(3 * n + 1, sizeof *seconds), *bytes = seconds + n, *error = bytes + n;
    bool *front = calloc(n + 1, sizeof *front);
    chosen[0] = chosen[1] = n;
    if (!seconds || !front) {
        free(seconds);
        free(front);
        return iso_fail(err, ISO_E_MEMORY, "chart: no memory for %zu settings", n);
    }
    for (size_t i = 0; i < n; ++i) {
        seconds[i] = run->cases[i].seconds;
        bytes[i] = run->cases[i].bytes;
        error[i] = run->cases[i].metrics.rmse;
    }
    iso_pareto_front(seconds, error, n, front);
    for (size_t i = 0; i < n; ++i)
        run->cases[i].on_time_front = front[i];
    iso_pareto_front(bytes, error, n, front);
    for (size_t i = 0; i < n; ++i)
        run->cases[i].on_bytes_front = front[i];
    if (want > 0) {
        chosen[0] = iso_pareto_choose(seconds, error, error, n, want);
        chosen[1] = iso_pareto_choose(bytes, seconds, error, n, want);
    }
    free(seconds);
    free(front);
    return ISO_OK;
}

static json_t *case_json(const iso_chart_case *c)
{
    char name[160], gradients[64];
    iso_chart_describe(c, name, sizeof name);
    iso_chart_name_gradients(c, gradients, sizeof gradients);
    json_t *o = json_pack("{s:s, s:s, s:I, s:s, s:o, s:o, s:f, s:f, s:f}", "setting", name, "renderer",
                          iso_renderer_name(c->renderer), "level", (json_int_t)c->level, "gradients",
                          iso_direction_source_name(c->source), "code",
                          c->source == ISO_FROM_CODES || c->source == ISO_FROM_PALETTE ? json_string(gradients) : json_null(),
                          "direction_filter",
                          c->source == ISO_FROM_ON_THE_FLY ? json_null() : json_string(iso_direction_filter_name(c->filter)),
                          "step_voxels", c->step_voxels, "milliseconds", 1e3 * c->seconds, "bytes", c->bytes);
    json_object_set_new(o, "estimator", c->source == ISO_FROM_ON_THE_FLY ? json_null() : json_string(iso_gradient_name(c->estimator)));
    json_object_set_new(o, "quadrature", json_string(c->preintegrated ? "preintegrated" : "midpoint"));
    json_object_set_new(o, "plan_error", c->plan_error > 0 ? json_real(c->plan_error) : json_null());
    json_object_set_new(o, "tf", json_string(!c->adapted                       ? "original"
                                              : c->table == ISO_SPLIT_DEVIATION ? "deviation"
                                              : c->table == ISO_SPLIT_GRADIENT  ? "gradient"
                                                                                : "adapted"));
    json_object_update_new(o, iso_metrics_to_json(&c->metrics));
    json_object_set_new(o, "on_time_front", json_boolean(c->on_time_front));
    json_object_set_new(o, "on_bytes_front", json_boolean(c->on_bytes_front));
    return o;
}

static json_t *result_json(const chart_run *run, const chart_arguments *a, const iso_cli *cli, const size_t chosen[2])
{
    json_t *root = iso_cli_json(cli), *cases = json_array();
    json_object_set_new(root, "options", json_pack("{s:f, s:[I,I]}", "budget_seconds", a->budget_seconds, "image",
                                                   (json_int_t)run->view.width, (json_int_t)run->view.height));
    for (size_t i = 0; i < run->done_count; ++i)
        json_array_append_new(cases, case_json(&run->cases[i]));
    json_object_set_new(root, "reference_seconds", json_real(run->reference_seconds));
    json_object_set_new(root, "skipped_count", json_integer((json_int_t)(run->count - run->done_count)));
    if (a->want > 0) {
        json_t *want = json_pack("{s:f}", "rmse", a->want);
        const char *const keys[] = {"fastest", "smallest"};
        for (int k = 0; k < 2; ++k)
            json_object_set_new(want, keys[k], chosen[k] < run->done_count ? case_json(&run->cases[chosen[k]]) : json_null());
        json_object_set_new(root, "want", want);
    }
    json_object_set_new(root, "cases", cases);
    return root;
}

/* Columns are named in pareto.gp by their number. */
static char *result_csv(const chart_run *run, double want, const size_t chosen[2])
{
    char *text = NULL;
    size_t size = 0;
    FILE *f = open_memstream(&text, &size);
    if (!f)
        return NULL;
    fputs("series,setting,renderer,level,step_voxels,milliseconds,bytes,rmse,flip_mean,time_front,bytes_front,want,chosen,preintegrated\n", f);
    for (size_t i = 0; i < run->done_count; ++i) {
        const iso_chart_case *c = &run->cases[i];
        char series[160], setting[160];
        iso_chart_describe_series(c, series, sizeof series);
        iso_chart_describe(c, setting, sizeof setting);
        fprintf(f, "%s,%s,%s,%zu,%g,%.6g,%.9g,%.6g,%.6g,%d,%d,%.6g,%d,%d\n", series, setting,
                iso_renderer_name(c->renderer), c->level, c->step_voxels, 1e3 * c->seconds, c->bytes, c->metrics.rmse,
                c->metrics.flip_mean, c->on_time_front, c->on_bytes_front, want,
                (i == chosen[0] ? 1 : 0) | (i == chosen[1] ? 2 : 0),
                c->preintegrated);
    }
    return fclose(f) == 0 ? text : NULL;
}

static iso_status write_files(const chart_run *run, const chart_arguments *a, const size_t chosen[2], const json_t *result,
                              iso_error *err)
{
    iso_output out;
    iso_status status = iso_output_begin_dir(&out, a->output, "chart.json", err);
    if (status != ISO_OK)
        return status;
    char *csv = result_csv(run, a->want, chosen), *json = iso_path_join(out.temp_path, "chart.json"),
         *style = iso_path_join(out.temp_path, "style.gp"), *content = NULL;
    size_t size = 0;
    if (!csv || !json || !style)
        status = iso_fail(err, ISO_E_MEMORY, "chart: out of memory");
    if (status == ISO_OK)
        status = iso_json_save(json, result, err);
    if (status == ISO_OK && a->style)
        status = iso_file_read(a->style, &content, &size, err);
    if (status == ISO_OK && a->style)
        status = iso_file_write(style, content, size, err);
    if (status == ISO_OK)
        status = iso_chart_draw(out.temp_path, "pareto", csv, pareto_gp, "svg", err);
    if (status == ISO_OK)
        status = iso_chart_draw(out.temp_path, "pareto", csv, pareto_gp, "pdf", err);
    if (status == ISO_OK)
        status = iso_output_commit(&out, err);
    iso_output_abandon(&out);
    free(csv);
    free(json);
    free(style);
    free(content);
    return status;
}

static void print_front(const chart_run *run, const chart_arguments *a, const size_t chosen[2])
{
    printf("on the front of time (t) or bytes (b)%-31s %10s %12s %10s %10s\n", "", "ms", "bytes", "rmse", "flip_mean");
    for (size_t i = 0; i < run->done_count; ++i) {
        const iso_chart_case *c = &run->cases[i];
        char name[160];
        iso_chart_describe(c, name, sizeof name);
        if (c->on_time_front || c->on_bytes_front)
            printf("  %s%s %-63s %10.4g %12.0f %10.3g %10.3g\n", c->on_time_front ? "t" : " ", c->on_bytes_front ? "b" : " ",
                   name, 1e3 * c->seconds, c->bytes, c->metrics.rmse, c->metrics.flip_mean);
    }
    if (run->done_count < run->count)
        printf("%zu of %zu settings did not fit into %g s\n", run->count - run->done_count, run->count, a->budget_seconds);
    const char *const kinds[] = {"fastest", "smallest"};
    for (int k = 0; k < 2 && a->want > 0 && chosen[k] < run->done_count; ++k) {
        const iso_chart_case *c = &run->cases[chosen[k]];
        char name[160];
        iso_chart_describe(c, name, sizeof name);
        printf("%s with rmse <= %.4g: %s (%.4g ms, %.0f bytes, rmse %.3g)\n", kinds[k], a->want, name, 1e3 * c->seconds,
               c->bytes, c->metrics.rmse);
    }
    printf("chart: %s/pareto.svg\n", a->output);
}

/* A volume gives a pyramid for each estimator and filter; a pyramid on disk is what it is. */
static iso_status load_pyramids(chart_run *run, const chart_arguments *a, const iso_chart_grid *g, const iso_cli *cli,
                                iso_error *err)
{
    iso_progress progress = iso_cli_progress(cli);
    iso_status status = ISO_OK;
    bool on_disk = iso_pyramid_is_one(cli->arguments[0]), any = false;
    for (size_t i = 0; i < (size_t)ISO_GRADIENT_COUNT * ISO_DIRECTION_COUNT && status == ISO_OK; ++i) {
        iso_pyramid_options opt = iso_pyramid_defaults();
        iso_pyramid p = {0};
        opt.gradient.method = (iso_gradient_method)(i / ISO_DIRECTION_COUNT);
        opt.direction_filter = (iso_direction_filter)(i % ISO_DIRECTION_COUNT);
        if (on_disk ? any : !g->estimators[opt.gradient.method] || !g->filters[opt.direction_filter])
            continue;
        opt.level_count = (size_t)a->level_count;
        opt.keep_float = true;
        opt.threads = opt.gradient.threads = cli->threads;
        status = iso_cli_load_pyramid(cli->arguments[0], &a->input, &opt, &progress, &p, err);
        if (status != ISO_OK)
            continue;
        run->pyramids[p.options.gradient.method][p.options.direction_filter] = p;
        if (!any) {
            run->first_estimator = p.options.gradient.method;
            run->first_filter = p.options.direction_filter;
        }
        any = true;
    }
    return status;
}

static const iso_pyramid *first_pyramid(const chart_run *run)
{
    return &run->pyramids[run->first_estimator][run->first_filter];
}

static iso_status adapt_levels(chart_run *run, const iso_cli *cli, iso_error *err)
{
    const iso_pyramid *p = first_pyramid(run);
    iso_adapt_options opt = iso_adapt_defaults();
    opt.threads = cli->threads;
    iso_status status = ISO_OK;
    for (size_t k = 1; k < p->level_count && status == ISO_OK; ++k)
        status = iso_adapt_level(p, NULL, k, &run->view.tf, &opt, &run->adapted[k], NULL, err);
    for (size_t k = 1; k < p->level_count && status == ISO_OK; ++k)
        for (int i = 0; i < 2 && status == ISO_OK; ++i)
            status = iso_adapt_classes(p, NULL, k, (iso_joint_split)(ISO_SPLIT_DEVIATION + i), &run->view.tf, &opt, &run->tables[k][i], err);
    return status;
}

/* The arbiter: level 0, no step left, directions as floats where the pyramid has them. A tolerance of 1e-3 a pixel
 * costs a quarter of the default and leaves an RMSE of 1e-6, a hundredth of what a chart shows. */
static iso_status make_reference(chart_run *run, const iso_cli *cli, iso_error *err)
{
    iso_progress progress = iso_cli_progress(cli);
    const iso_pyramid *p = first_pyramid(run);
    iso_reference_options opt = iso_reference_defaults();
    opt.source = p->levels[0].directions ? ISO_FROM_FLOAT : ISO_FROM_CODES;
    opt.tolerance = 1e-3;
    opt.threads = cli->threads;
    double start = iso_clock_seconds();
    iso_status status = iso_reference_render(&p->levels[0], p->options.code, &run->view, &opt, &run->reference, &progress, err);
    run->start_seconds = iso_clock_seconds();
    run->reference_seconds = run->start_seconds - start;
    return status;
}

static iso_status finish(chart_run *run, const chart_arguments *a, const iso_cli *cli, iso_error *err)
{
    size_t chosen[2];
    iso_status status = find_fronts(run, a->want, chosen, err);
    if (status != ISO_OK)
        return status;
    json_t *result = result_json(run, a, cli, chosen);
    status = write_files(run, a, chosen, result, err);
    if (status == ISO_OK && !cli->json)
        print_front(run, a, chosen);
    if (status == ISO_OK && cli->json)
        iso_cli_print_json(result);
    else
        json_decref(result);
    if (status == ISO_OK && a->want > 0 && chosen[0] == run->done_count)
        return iso_fail(err, ISO_E_DIFFERS, "no setting that was tried has an RMSE of %.4g or less", a->want);
    return status;
}

static iso_status chart(const chart_arguments *a, const iso_cli *cli, iso_error *err)
{
    chart_run run = {.count = 0};
    iso_chart_grid grid;
    iso_status status = iso_chart_grid_parse(&a->words, &grid, err);
    if (status == ISO_OK)
        status = load_pyramids(&run, a, &grid, cli, err);
    if (status == ISO_OK)
        status = iso_cli_load_view(a->scene, first_pyramid(&run), a->size, &run.view, err);
    if (status == ISO_OK)
        status = adapt_levels(&run, cli, err);
    if (status == ISO_OK)
        status = iso_chart_grid_cases(&grid, run.pyramids, run.first_estimator, run.first_filter, &run.cases, &run.count, err);
    if (status == ISO_OK)
        status = fit_palettes(&run, cli->threads, err);
    if (status == ISO_OK)
        status = make_plan(&run, &grid, cli, err);
    if (status == ISO_OK)
        status = make_reference(&run, cli, err);
    if (status == ISO_OK)
        status = measure_all(&run, a, cli, err);
    if (status == ISO_OK)
        status = finish(&run, a, cli, err);
    free(run.cases);
    for (size_t k = 0; k < sizeof run.adapted / sizeof *run.adapted; ++k)
        iso_tf_table_destroy(&run.adapted[k]);
    for (size_t k = 0; k < 2 * sizeof run.adapted / sizeof *run.adapted; ++k)
        iso_class_tables_destroy(&run.tables[k / 2][k % 2]);
    for (size_t i = 0; i < ISO_CHART_PALETTES; ++i)
        iso_palette_destroy(&run.palettes[i]);
    iso_plan_destroy(&run.plan);
    iso_node_levels_destroy(&run.nodes);
    iso_image_destroy(&run.reference);
    iso_view_destroy(&run.view);
    for (size_t i = 0; i < (size_t)ISO_GRADIENT_COUNT * ISO_DIRECTION_COUNT; ++i)
        iso_pyramid_destroy(&run.pyramids[i / ISO_DIRECTION_COUNT][i % ISO_DIRECTION_COUNT]);
    iso_renderers_end(&run.renderers);
    return status;
}

static iso_status check(chart_arguments *a, iso_error *err)
{
    if (!a->output)
        return iso_fail(err, ISO_E_USAGE, "-o is missing: the folder for the chart");
    iso_status status = iso_cli_check_range("--levels", a->level_count, 1, 32, err);
    if (status == ISO_OK)
        status = iso_cli_check_range("--budget", a->budget_seconds, 0.001, 1e6, err);
    if (status == ISO_OK && a->want_text)
        status = iso_chart_parse_error("--want", a->want_text, &a->want, err);
    return status;
}

static iso_status run(const iso_command *self, int argc, const char **argv, iso_error *err)
{
    chart_arguments a = {.level_count = 3, .budget_seconds = 120};
    iso_cli_input_defaults(&a.input);
    struct poptOption options[] = {
        {"output", 'o', POPT_ARG_STRING, &a.output, 0, "the folder for the chart", "DIR"},
        {"scene", 0, POPT_ARG_STRING, &a.scene, 0, "camera, lights, shading and transfer function", "SCENE.scene.json"},
        {"want", 0, POPT_ARG_STRING, &a.want_text, 0, "name the fastest and the smallest setting with this RMSE or less", "1/255"},
        {"budget", 0, POPT_ARG_DOUBLE | POPT_ARGFLAG_SHOW_DEFAULT, &a.budget_seconds, 0, "cheap settings first, while they fit; the reference comes on top", "SECONDS"},
        {"with", 0, POPT_ARG_STRING, &a.words.with, 0, "of gl (default), reference, cycles, povray", "LIST"},
        {"steps", 0, POPT_ARG_STRING, &a.words.steps, 0, "ray steps in voxels of the level (2,1,0.5,0.25,0.125)", "LIST"},
        {"quadratures", 0, POPT_ARG_STRING, &a.words.quadratures, 0, "of gl and the reference: midpoint, preintegrated (both)", "LIST"},
        {"plans", 0, POPT_ARG_STRING, &a.words.plans, 0, "gl: bricks of mixed resolution, planned for these errors (4/255,1/255), or none", "LIST"},
        {"codes", 0, POPT_ARG_STRING, &a.words.codes, 0, "direction codes (all that textures filter)", "LIST"},
        {"filters", 0, POPT_ARG_STRING, &a.words.filters, 0, "direction filters of coarse levels (moments)", "LIST"},
        {"estimators", 0, POPT_ARG_STRING, &a.words.estimators, 0, "of gradients (central); the first makes the reference's", "LIST"},
        {"levels", 0, POPT_ARG_INT | POPT_ARGFLAG_SHOW_DEFAULT, &a.level_count, 0, "levels of a volume, the finest included", "N"},
        {"size", 0, POPT_ARG_STRING, &a.size, 0, "image size instead of the scene's", "WxH"},
        {"style", 0, POPT_ARG_STRING, &a.style, 0, "gnuplot settings instead of the built-in style.gp", "STYLE.gp"},
        ISO_CLI_INPUT_OPTIONS(&a.input),
        POPT_TABLEEND,
    };
    iso_cli cli;
    iso_cli_next next;
    iso_status status = iso_cli_parse(&cli, self, argc, argv, options, 1, 1, &next, err);
    if (status == ISO_OK && next == ISO_CLI_RUN)
        status = check(&a, err);
    if (status == ISO_OK && next == ISO_CLI_RUN)
        status = chart(&a, &cli, err);
    iso_cli_end(&cli);
    return status;
}

const iso_command iso_command_chart = {
    .name = "chart",
    .summary = "speed against accuracy: which setting is good enough for a scene",
    .usage = "VOLUME|PYRAMID.iso --scene SCENE.scene.json -o DIR [--want 1/255] [options]",
    .details = "Renders the scene with every renderer, level, transfer function (the scene's, and the level's own), direction\n"
               "filter, kind of gradients, code, quadrature and step, and with planned bricks, the cheap ones first, within the\n"
               "budget, and compares each with the converged reference of level 0. A setting is on the front when no other is as fast (or as small) and as exact.\n"
               "DIR holds pareto.svg, pareto.pdf, pareto.csv and chart.json; edit style.gp or pareto.gp and run gnuplot there to\n"
               "restyle. Exit code 1: no setting has the wanted error.",
    .examples = "  isoshade make marschner-lobb --size 40x56x33 -o ml.nrrd\n"
                "  isoshade chart ml.nrrd --scene refscenes/marschner-lobb.scene.json --size 96 --want 1/255 -o chart\n"
                "  isoshade chart ml.nrrd --scene refscenes/marschner-lobb.scene.json --size 48 --levels 2 --steps 1,0.5 --budget 20 --json -o chart2\n",
    .run = run,
};

/* SPDX-License-Identifier: MIT */
/* convergence.c - tests that each renderer's error falls as its quadrature promises, and that its limit is the
 * reference.
 *
 * Each renderer draws the scene at steps that halve. The error of midpoint rules is quadratic in the step: against the
 * converged reference it falls by a factor of 4. The limit extrapolated from the two finest steps (Richardson) must lie
 * within two error bars of the reference. */
#define _GNU_SOURCE
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/embed.h"
#include "base/file.h"
#include "base/json.h"
#include "lab/lab.h"
#include "options/input.h"
#include "renderers/renderers.h"
#include "options/look.h"
#include "report/gnuplot.h"
#include "compare/metrics.h"
#include "compare/extrapolation.h"
#include "renderers/external.h"
#include "cli/renderer_help.h"

ISO_EMBED(iso_convergence_gp, "src/lab/convergence.gp");

enum { most_steps = 8 };

typedef struct convergence_options {
    iso_volume_input input;
    iso_cli_look look;
    char *with, *renderers, *output, *format;
    int level, steps;
    double finest;
} convergence_options;

/* Results of one renderer over all steps. */
typedef struct descent {
    const iso_renderer_info *renderer;
    double step[most_steps], rmse[most_steps], max_abs[most_steps], order[most_steps], seconds[most_steps];
    size_t intervals[most_steps], pieces[most_steps]; /* per ray; 0 intervals: it has steps */
    double limit_rmse, error_bar;                     /* of the extrapolated limit */
    bool agrees;
} descent;

/* Images of 16 bits have steps of 1.5e-5, which extrapolation amplifies; floats have smaller ones. */
static const double rounding = 1e-5;
static const double expected_order = 2; /* of all renderers with a limit */
/* The TF's bends and the cells' borders lie at random positions between the samples, so part of the error has a random
 * phase. Independent errors e and 4 e of the two finest steps leave 1.9 e in the limit, at a bar of 1.4 e. */
static const double bars_allowed = 2;

/* Renders at all steps. q: without renderer options; this function sets them. */
static iso_status descend(const iso_render_request *q, const convergence_options *o, const iso_image *reference,
                          int threads, descent *d, iso_error *err)
{
    const iso_level *level = &q->pyramid->levels[q->level];
    iso_image image = {0}, coarser = {0}, limit = {0};
    iso_metrics m = {0};
    iso_extrapolation extrapolation = {0};
    iso_status status = ISO_OK;
    iso_render_options frames[most_steps];
    for (int i = 0; i < o->steps; ++i) {
        frames[i] = iso_render_defaults(d->renderer);
        frames[i].threads = threads;
    }
    iso_render_ask_steps(d->renderer, level, o->finest, (size_t)o->steps, 1, frames);
    for (int i = 0; i < o->steps && status == ISO_OK; ++i) {
        d->step[i] = iso_render_step_voxels(level, &frames[i]);
        iso_image_destroy(&coarser);
        coarser = image;
        image = (iso_image){0};
        double seconds = 0;
        status = iso_render_with(&(iso_render_request){q->renderers, q->pyramid, q->level, q->view, &frames[i],
                                                       q->progress},
                                 &image, &seconds, err);
        d->seconds[i] = seconds;
        d->intervals[i] = frames[i].intervals;
        d->pieces[i] = frames[i].planes + 1;
        TRY(status, iso_metrics_measure(&image, reference, &m, err));
        d->rmse[i] = m.rmse;
        d->max_abs[i] = m.max_abs;
        d->order[i] = i > 0 ? log2(d->rmse[i - 1] / d->rmse[i]) / log2(d->step[i - 1] / d->step[i]) : NAN;
    }
    TRY(status, iso_richardson(&coarser, &image, d->step[o->steps - 2] / d->step[o->steps - 1], expected_order, &limit,
                               &extrapolation, err));
    TRY(status, iso_metrics_measure(&limit, reference, &m, err));
    d->limit_rmse = m.rmse;
    d->error_bar = extrapolation.error_bar;
    d->agrees = status == ISO_OK && m.rmse <= bars_allowed * d->error_bar + rounding;
    iso_image_destroy(&image);
    iso_image_destroy(&coarser);
    iso_image_destroy(&limit);
    return status;
}

static json_t *to_json(const descent *d, int steps)
{
    json_t *list = json_array();
    for (int i = 0; i < steps; ++i)
        json_array_append_new(list,
                              json_pack("{s:f, s:o, s:o, s:o, s:o, s:I, s:I}", "step_voxels", d->step[i], "rmse",
                                        iso_json_number(d->rmse[i]), "max_abs", iso_json_number(d->max_abs[i]), "order",
                                        iso_json_number(d->order[i]), "seconds", iso_json_number(d->seconds[i]),
                                        "intervals", (json_int_t)d->intervals[i], "pieces", (json_int_t)d->pieces[i]));
    return json_pack("{s:s, s:o, s:{s:o, s:o, s:b}}", "renderer", d->renderer->name, "steps", list, "limit", "rmse",
                     iso_json_number(d->limit_rmse), "error_bar", iso_json_number(d->error_bar), "agrees", d->agrees);
}

static void print_table(const descent *d, int steps)
{
    const bool intervals = d->intervals[0] > 0;
    printf("%s\n  %12s %12s %12s %8s %8s%s\n", d->renderer->title, "step, voxels", "rmse", "max_abs", "order",
           "seconds", intervals ? "  intervals" : "");
    for (int i = 0; i < steps; ++i) {
        char order[16] = "";
        if (i > 0)
            snprintf(order, sizeof order, "%.2f", d->order[i]);
        printf("  %12.5g %12.3g %12.3g %8s %8.2f", d->step[i], d->rmse[i], d->max_abs[i], order, d->seconds[i]);
        if (intervals && d->pieces[i] > 1)
            printf("  %zu in %zu pieces", d->intervals[i], d->pieces[i]);
        else if (intervals)
            printf("  %zu", d->intervals[i]);
        printf("\n");
    }
    printf("  %12s %12.3g, error bar %.3g: %s\n", "limit", d->limit_rmse, d->error_bar,
           d->agrees ? "agrees" : "differs");
}

/* Writes columns renderer, kind, step, rmse, error bar. The limit is at half the finest step. */
static iso_status draw(const convergence_options *o, const descent *d, size_t count, iso_error *err)
{
    FREED char *csv = NULL;
    size_t size = 0;
    FILE *f = open_memstream(&csv, &size);
    NEED_MEMORY(f, err, "isoshade-lab convergence: no memory for the chart's data");
    fprintf(f, "renderer,kind,step_voxels,rmse,error_bar\n");
    for (size_t r = 0; r < count; ++r) {
        for (int i = 0; i < o->steps; ++i)
            fprintf(f, "%s,step,%.9g,%.9g,NaN\n", d[r].renderer->name, d[r].step[i], d[r].rmse[i]);
        fprintf(f, "%s,limit,%.9g,%.9g,%.9g\n", d[r].renderer->name, 0.75 * d[r].step[o->steps - 1], d[r].limit_rmse,
                d[r].error_bar);
    }
    fclose(f);
    iso_output out = {0};
    iso_status status = iso_output_begin_dir(&out, o->output, "convergence.csv", err);
    TRY(status, iso_gnuplot_draw(out.temp_path, "convergence", csv, iso_convergence_gp, o->format, err));
    TRY(status, iso_output_commit(&out, err));
    iso_output_abandon(&out);
    return status;
}

/* Parses "gl,povray": only renderers with a limit. */
static iso_status parse_renderers(const char *text, descent d[ISO_MAX_RENDERERS], size_t *count, iso_error *err)
{
    char *copy = strdup(text), *rest = copy;
    iso_status status = copy ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "isoshade-lab convergence: no memory");
    *count = 0;
    for (char *word; status == ISO_OK && (word = strsep(&rest, ","));) {
        const iso_renderer_info *r;
        char names[256];
        status = iso_renderer_from_name(word, &r, err);
        if (status == ISO_OK && (!iso_renderer_has(r, ISO_HAS_LIMIT) || *count == ISO_MAX_RENDERERS))
            status = iso_fail(err, ISO_E_USAGE, "--with is \"%s\", must be a list of %s", text,
                              iso_renderers_with(ISO_HAS_LIMIT, ", ", " and ", names, sizeof names));
        if (status == ISO_OK)
            d[(*count)++] = (descent){.renderer = r};
    }
    free(copy);
    return status;
}

static iso_status run(const iso_cli *cli, void *values, iso_error *err)
{
    const convergence_options *o = values;
    iso_progress progress = iso_cli_progress(cli);
    iso_pyramid_options build = iso_pyramid_defaults();
    iso_renderers renderers = {0};
    iso_render_options exact = iso_render_defaults(iso_renderers_reference());
    iso_pyramid p = {0};
    iso_view view = {0};
    iso_subject_look look;
    iso_image reference = {0};
    descent d[ISO_MAX_RENDERERS];
    size_t count = 0;
    iso_status status = iso_renderers_load(o->renderers, err);
    TRY(status, parse_renderers(o->with, d, &count, err));
    TRY(status, iso_cli_look_check(&o->look, cli->threads, &look, err));
    build.threads = exact.threads = cli->threads;
    build.level_count = (size_t)o->level + 1;
    TRY(status, iso_subject_load_pyramid(cli->arguments[0], &o->input, &build, &progress, &p, err));
    TRY(status, iso_subject_make_view(&look, &p, &view, err));
    if (status == ISO_OK)
        status = iso_render_with(&(iso_render_request){&renderers, &p, (size_t)o->level, &view, &exact, &progress},
                                 &reference, NULL, err);
    for (size_t r = 0; r < count && status == ISO_OK; ++r) {
        status = descend(&(iso_render_request){&renderers, &p, (size_t)o->level, &view, NULL, &progress}, o, &reference,
                         cli->threads, &d[r], err);
        if (status == ISO_OK && !cli->json)
            print_table(&d[r], o->steps);
    }
    if (status == ISO_OK && o->output)
        status = draw(o, d, count, err);
    if (status == ISO_OK && cli->json) {
        json_t *root = iso_cli_json(cli), *cases = json_array();
        for (size_t r = 0; r < count; ++r)
            json_array_append_new(cases, to_json(&d[r], o->steps));
        json_object_set_new(root, "cases", cases);
        iso_cli_print_json(root);
    }
    iso_image_destroy(&reference);
    iso_view_destroy(&view);
    iso_pyramid_destroy(&p);
    iso_renderers_end(&renderers);
    return status;
}

static const iso_option options[] = {
    ISO_OPTIONS_OF(convergence_options, look, iso_look_rows),
    {"with", 0, "%s", "LIST", ISO_IN(convergence_options, with), .flags = ISO_SHOWN,
     ISO_NAMES_RENDERERS(ISO_HAS_LIMIT)},
    ISO_CLI_RENDERERS_OPTION(convergence_options, renderers),
    {"steps", 0, "render with N steps, each half of the previous one", "N", ISO_IN(convergence_options, steps),
     .flags = ISO_SHOWN, .least = 2, .most = 6},
    {"finest", 0, "set the last step, in voxels of the level", "VOXELS", ISO_IN(convergence_options, finest),
     .flags = ISO_SHOWN, .least = 1e-3, .most = 10},
    {"level", 0, "use this level of the pyramid, 0 is the finest", "K", ISO_IN(convergence_options, level),
     .flags = ISO_SHOWN, .most = 63},
    {"output", 'o', "write the chart and its data", "DIR", ISO_IN(convergence_options, output)},
    {"format", 0, "write the chart as svg or pdf", "svg|pdf", ISO_IN(convergence_options, format),
     .flags = ISO_SHOWN | ISO_ONE_OF},
    ISO_OPTIONS_OF(convergence_options, input, iso_input_rows),
    ISO_OPTIONS_END,
};

const iso_command iso_lab_convergence = {
    .name = "convergence",
    .summary = "error of each renderer by ray step, its order and its limit",
    .min_arguments = 1,
    .max_arguments = 1,
    .usage = "VOLUME|PYRAMID.iso [--scene SCENE.scene.json] [options]",
    .details =
        "The error is the RMSE against the converged reference. order: 2 if halving the step quarters the error.\n"
        "limit: extrapolated from the two finest steps; it agrees if it lies within two error bars of the reference.\n"
        "seconds: of the frame only.",
    .examples =
        "  isoshade make marschner-lobb --size 40x56x33 -o ml.nrrd\n"
        "  isoshade-lab convergence ml.nrrd --scene refscenes/marschner-lobb.scene.json --size 48 -o convergence\n",
    ISO_COMMAND_OPTIONS(convergence_options, options, .with = "gl,povray", .format = "svg", .steps = 4,
                        .finest = 0.125),
    .run = run,
};

/* SPDX-License-Identifier: MIT */
/* filters.c - isoshade-lab consistency --filters: cases in which each direction filter holds or fails. --holes: the
 * artifact of undefined directions on the coarse surface.
 *
 * Paper: [diaz-garcia-2017] sec. 3, Figure 3 and Eq. 1. Scenes are analytic fields, some with noise. Errors are against
 * the field itself: angles to its gradients, images of its level 0 without noise. */
#define _GNU_SOURCE
#include "lab/shading.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/embed.h"
#include "base/file.h"
#include "base/json.h"
#include "lab/shading_error.h"
#include "lab/shading_method.h"
#include "report/gnuplot.h"

ISO_EMBED(iso_filters_gp, "src/lab/filters.gp");
ISO_EMBED(iso_holes_gp, "src/lab/holes.gp");

enum { LEVELS = 4, VIEWS = 2 };

static const iso_shading_method methods[] = {
    {.name = "on-the-fly", .filter = ISO_DIRECTION_MOMENTS, .source = ISO_FROM_ON_THE_FLY},
    {.name = "naive", .filter = ISO_DIRECTION_NAIVE, .source = ISO_FROM_CODES},
    {.name = "eq1", .filter = ISO_DIRECTION_EQ1, .source = ISO_FROM_CODES},
    {.name = "eq1 r=1", .filter = ISO_DIRECTION_EQ1, .source = ISO_FROM_CODES, .radius = 1},
    {.name = "eq1 r=2 s=.6", .filter = ISO_DIRECTION_EQ1, .source = ISO_FROM_CODES, .radius = 2, .sigma = 0.6},
    {.name = "eq1 r=4 s=2", .filter = ISO_DIRECTION_EQ1, .source = ISO_FROM_CODES, .radius = 4, .sigma = 2},
    {.name = "eq1 m^0", .filter = ISO_DIRECTION_EQ1, .source = ISO_FROM_CODES, .plain = true},
    {.name = "eq1 m^3", .filter = ISO_DIRECTION_EQ1, .source = ISO_FROM_CODES, .exponent = 3},
    {.name = "moments", .filter = ISO_DIRECTION_MOMENTS, .source = ISO_FROM_CODES},
    {.name = "flipped", .filter = ISO_DIRECTION_MOMENTS, .source = ISO_FROM_FLIPPED},
    {.name = "tensor", .filter = ISO_DIRECTION_TENSOR, .source = ISO_FROM_CODES},
    {.name = "tensor flipped", .filter = ISO_DIRECTION_TENSOR, .source = ISO_FROM_FLIPPED},
};
enum { METHOD_COUNT = sizeof methods / sizeof *methods };

/* The thin plate gets a third of these. With fewer voxels, its surface would lie entirely at the border. */
enum { MIN_VOXELS = 18 };

typedef struct scene {
    const char *name;
    iso_field_kind kind;
    double noise;
    int coarser; /* factor of fewer voxels along an edge, which makes structures thin */
} scene;

static const scene scenes[] = {
    {"smooth", ISO_FIELD_NOISE, 0, 1},        {"noise 1 %", ISO_FIELD_SPHERE, 0.01, 1},
    {"noise 3 %", ISO_FIELD_SPHERE, 0.03, 1}, {"plate", ISO_FIELD_PLATE, 0, 1},
    {"noisy plate", ISO_FIELD_PLATE, 0.1, 1}, {"thin plate", ISO_FIELD_PLATE, 0, 3},
    {"shells", ISO_FIELD_SHELLS, 0, 1},       {"two surfaces", ISO_FIELD_BALLS, 0, 1},
    {"vessels", ISO_FIELD_VESSELS, 0, 1},
};
enum { SCENE_COUNT = sizeof scenes / sizeof *scenes };

typedef struct filters_run {
    const iso_cli *cli;
    int size, voxels, filters, holes;
    char *output, *format;
    iso_gl *gl;
    iso_shading_error error[SCENE_COUNT][METHOD_COUNT][LEVELS];
} filters_run;

static size_t scene_voxels(const filters_run *run, const scene *s)
{
    return (size_t)run->voxels / (size_t)s->coarser;
}

/* Renders level 0 of the field without noise, the reference of all comparisons. */
static iso_status begin_scene(const filters_run *run, const scene *s, int size, iso_shading_subject *subject,
                              iso_error *err)
{
    const iso_shading_look look = {.view_count = VIEWS, .image_size = (size_t)size, .any_surface = true};
    iso_field field;
    iso_volume v = {0};
    iso_pyramid p = {0};
    iso_status status = iso_shading_sample(s->kind, scene_voxels(run, s), 0, &field, &v, err);
    TRY(status, iso_shading_build(&methods[0], &v, s->name, 1, run->cli->threads, &p, err));
    TRY(status, iso_shading_begin(subject, run->gl, &p.levels[0], p.options.code, &field, &look, err));
    iso_pyramid_destroy(&p);
    iso_volume_destroy(&v);
    return status;
}

static iso_status run_scene(filters_run *run, size_t at, iso_error *err)
{
    const scene *s = &scenes[at];
    for (size_t m = 0; m < METHOD_COUNT; ++m)
        for (size_t k = 0; k < LEVELS; ++k) /* levels missing in small volumes */
            run->error[at][m][k] = (iso_shading_error){.dssim_mean = NAN, .truth_mean_deg = NAN};
    iso_field field;
    iso_volume v = {0};
    iso_shading_subject subject = {0};
    iso_progress progress = iso_cli_progress(run->cli);
    iso_status status = begin_scene(run, s, run->size, &subject, err);
    TRY(status, iso_shading_sample(s->kind, scene_voxels(run, s), s->noise, &field, &v, err));
    for (size_t m = 0; m < METHOD_COUNT && status == ISO_OK; ++m) {
        iso_pyramid p = {0};
        iso_progress_report(&progress, s->name, (double)m / METHOD_COUNT);
        status = iso_shading_build(&methods[m], &v, s->name, LEVELS, run->cli->threads, &p, err);
        for (size_t k = 1; k < p.level_count && status == ISO_OK; ++k)
            status = iso_shading_measure(&subject,
                                         &(iso_shading_shown){&p.levels[k], k, p.options.code, methods[m].source, NULL,
                                                              0},
                                         &run->error[at][m][k], err);
        iso_pyramid_destroy(&p);
    }
    iso_progress_report(&progress, s->name, 1);
    iso_shading_end(&subject);
    iso_volume_destroy(&v);
    return status;
}

/* ---- the table ---- */

static double figure_of(const filters_run *run, size_t at, size_t m, size_t k, bool angle)
{
    return angle ? run->error[at][m][k].truth_mean_deg : run->error[at][m][k].dssim_mean;
}

static bool is_best(const filters_run *run, size_t at, size_t m, size_t k, bool angle)
{
    const double own = figure_of(run, at, m, k, angle);
    for (size_t other = 0; other < METHOD_COUNT; ++other)
        if (figure_of(run, at, other, k, angle) < own)
            return false;
    return isfinite(own);
}

static void print_scene(const filters_run *run, size_t at)
{
    printf("\n%s\n", scenes[at].name);
    for (size_t m = 0; m < METHOD_COUNT; ++m) {
        printf("  %-15s", methods[m].name);
        for (size_t k = 1; k < LEVELS; ++k)
            printf(" %6.2f%c", figure_of(run, at, m, k, true), is_best(run, at, m, k, true) ? '*' : ' ');
        printf("  ");
        for (size_t k = 1; k < LEVELS; ++k)
            printf(" %7.4f%c", figure_of(run, at, m, k, false), is_best(run, at, m, k, false) ? '*' : ' ');
        printf("\n");
    }
    fflush(stdout);
}

static json_t *cases_to_json(const filters_run *run)
{
    json_t *cases = json_array();
    for (size_t at = 0; at < SCENE_COUNT; ++at)
        for (size_t m = 0; m < METHOD_COUNT; ++m)
            for (size_t k = 1; k < LEVELS; ++k)
                json_array_append_new(cases,
                                      json_pack("{s:s, s:s, s:i, s:o, s:o, s:b, s:b}", "scene", scenes[at].name,
                                                "filter", methods[m].name, "level", (int)k, "truth_angle_mean_deg",
                                                iso_json_number(figure_of(run, at, m, k, true)), "dssim_mean",
                                                iso_json_number(figure_of(run, at, m, k, false)), "best_angle",
                                                is_best(run, at, m, k, true), "best_image",
                                                is_best(run, at, m, k, false)));
    return cases;
}

static iso_status draw_filters(const filters_run *run, const char *dir, iso_error *err)
{
    char *text = NULL;
    size_t size = 0;
    FILE *memory = open_memstream(&text, &size);
    if (!memory)
        return iso_fail(err, ISO_E_MEMORY, "no memory for the chart's data");
    fprintf(memory, "scene,filter,level,truth_angle_mean_deg,dssim_mean\n");
    for (size_t at = 0; at < SCENE_COUNT; ++at)
        for (size_t m = 0; m < METHOD_COUNT; ++m)
            for (size_t k = 1; k < LEVELS; ++k)
                fprintf(memory, "%s,%s,%zu,%.4f,%.6f\n", scenes[at].name, methods[m].name, k,
                        figure_of(run, at, m, k, true), figure_of(run, at, m, k, false));
    fclose(memory);
    iso_status status = iso_gnuplot_draw(dir, "filters", text, iso_filters_gp, run->format, err);
    free(text);
    return status;
}

static iso_status run_filters(filters_run *run, const char *dir, json_t *root, iso_error *err)
{
    iso_status status = ISO_OK;
    if (!run->cli->json)
        printf("angle to the field's gradients at its surface, degrees, at levels 1 to %d; DSSIM; * the least\n",
               LEVELS - 1);
    for (size_t at = 0; at < SCENE_COUNT && status == ISO_OK; ++at) {
        status = run_scene(run, at, err);
        if (status == ISO_OK && !run->cli->json)
            print_scene(run, at);
    }
    if (status == ISO_OK)
        json_object_set_new(root, "filters", cases_to_json(run));
    return status == ISO_OK && dir ? draw_filters(run, dir, err) : status;
}

/* ---- holes ---- */

/* Thin shells with a little noise: on the coarse surface, voxels hold both faces of a shell, or only noise. */
static const scene holes_scene = {"grainy shells", ISO_FIELD_SHELLS, 0.02, 1};
static const size_t holes_methods[] = {0, 1, 2, 8, 9}; /* on the fly, naive, Eq. 1, default, flipped */
enum { HOLES_METHODS = sizeof holes_methods / sizeof *holes_methods, HOLES_LEVEL = 2 };
static const double hole_depth = 0.8;

typedef struct holes {
    double fraction; /* of the pixels visible in both images, those darker than hole_depth times level 0 */
    double dssim;
} holes;

static double brightness(const iso_image *image, size_t pixel)
{
    const float *p = image->rgba + 4 * pixel;
    return (double)p[0] + (double)p[1] + (double)p[2];
}

static double hole_fraction(const iso_image *finest, const iso_image *image)
{
    size_t shown = 0, dark = 0;
    for (size_t i = 0; i < image->width * image->height; ++i) {
        if (finest->rgba[4 * i + 3] < 0.95f || image->rgba[4 * i + 3] < 0.95f)
            continue; /* silhouettes move and do not count */
        ++shown;
        dark += brightness(image, i) < hole_depth * brightness(finest, i);
    }
    return shown > 0 ? (double)dark / (double)shown : NAN;
}

static iso_status write_panel(const iso_image *image, const char *dir, const char *name, iso_error *err)
{
    char file[64];
    snprintf(file, sizeof file, "%s.png", name);
    char *path = iso_path_join(dir, file);
    if (!path)
        return iso_fail(err, ISO_E_MEMORY, "no memory for a path");
    iso_status status = iso_image_save_png(image, path, 1, err);
    free(path);
    return status;
}

static iso_status measure_holes(const filters_run *run, const iso_shading_subject *s, const iso_volume *v, size_t at,
                                const char *dir, holes *h, iso_error *err)
{
    const iso_shading_method *m = &methods[holes_methods[at]];
    iso_pyramid p = {0};
    iso_image image = {0};
    iso_shading_error e;
    iso_status status = iso_shading_build(m, v, holes_scene.name, HOLES_LEVEL + 1, run->cli->threads, &p, err);
    const iso_level *l = status == ISO_OK ? &p.levels[HOLES_LEVEL] : NULL;
    if (status == ISO_OK)
        status = iso_shading_measure(s, &(iso_shading_shown){l, HOLES_LEVEL, p.options.code, m->source, NULL, 0}, &e,
                                     err);
    if (status == ISO_OK)
        status = iso_shading_render(s, 0, &(iso_shading_shown){l, 0, p.options.code, m->source, NULL, 0}, &image, err);
    if (status == ISO_OK) {
        *h = (holes){.fraction = hole_fraction(&s->finest[0], &image), .dssim = e.dssim_mean};
        if (dir)
            status = write_panel(&image, dir, m->name, err);
    }
    iso_image_destroy(&image);
    iso_pyramid_destroy(&p);
    return status;
}

static iso_status draw_holes(const filters_run *run, const iso_shading_subject *s, const holes h[HOLES_METHODS],
                             const char *dir, iso_error *err)
{
    char *text = NULL;
    size_t size = 0;
    FILE *memory = open_memstream(&text, &size);
    if (!memory)
        return iso_fail(err, ISO_E_MEMORY, "no memory for the figure's data");
    fprintf(memory, "picture,title,holes,dssim,pixels\nfinest.png,level 0,0,0,%zu\n", s->finest[0].width);
    for (size_t i = 0; i < HOLES_METHODS; ++i)
        fprintf(memory, "%s.png,%s,%.5f,%.5f,%zu\n", methods[holes_methods[i]].name, methods[holes_methods[i]].name,
                h[i].fraction, h[i].dssim, s->finest[0].width);
    fclose(memory);
    iso_status status = write_panel(&s->finest[0], dir, "finest", err);
    TRY(status, iso_gnuplot_draw(dir, "holes", text, iso_holes_gp, run->format, err));
    free(text);
    return status;
}

static iso_status run_holes(const filters_run *run, const char *dir, json_t *root, iso_error *err)
{
    iso_field field;
    iso_volume v = {0};
    iso_shading_subject s = {0};
    holes h[HOLES_METHODS] = {{0}};
    json_t *rows = json_array();
    iso_status status = begin_scene(run, &holes_scene, 2 * run->size, &s, err);
    TRY(status, iso_shading_sample(holes_scene.kind, (size_t)run->voxels, holes_scene.noise, &field, &v, err));
    if (status == ISO_OK && !run->cli->json)
        printf("\nholes: pixels darker than %g of level 0, of those visible in both; %s, level %d\n", hole_depth,
               holes_scene.name, HOLES_LEVEL);
    for (size_t i = 0; i < HOLES_METHODS && status == ISO_OK; ++i) {
        status = measure_holes(run, &s, &v, i, dir, &h[i], err);
        if (status == ISO_OK && !run->cli->json)
            printf("  %-15s %6.2f %%   DSSIM %.4f\n", methods[holes_methods[i]].name, 100 * h[i].fraction, h[i].dssim);
        json_array_append_new(rows,
                              json_pack("{s:s, s:o, s:f}", "filter", methods[holes_methods[i]].name, "hole_fraction",
                                        iso_json_number(h[i].fraction), "dssim_mean", h[i].dssim));
    }
    json_object_set_new(root, "holes", rows);
    if (status == ISO_OK && dir)
        status = draw_holes(run, &s, h, dir, err);
    iso_shading_end(&s);
    iso_volume_destroy(&v);
    return status;
}

/* ---- the command ---- */

static iso_status run_all(filters_run *run, iso_error *err)
{
    iso_output out = {0};
    iso_status status = ISO_OK;
    if (run->output)
        status = iso_output_begin_dir(&out, run->output, "style.gp", err);
    TRY(status, iso_gl_create(&run->gl, NULL, err));
    json_t *root = iso_cli_json(run->cli);
    json_object_set_new(root, "options", json_pack("{s:i, s:i}", "size", run->size, "voxels", run->voxels));
    if (status == ISO_OK && run->filters)
        status = run_filters(run, out.temp_path, root, err);
    if (status == ISO_OK && run->holes)
        status = run_holes(run, out.temp_path, root, err);
    if (status == ISO_OK && run->output)
        status = iso_output_commit(&out, err);
    iso_output_abandon(&out);
    if (status == ISO_OK && run->cli->json)
        iso_cli_print_json(root);
    else
        json_decref(root);
    iso_gl_destroy(run->gl);
    return status;
}

static const iso_option options[] = {
    {"filters", 0, "measure all filters on all scenes", NULL, ISO_IN(filters_run, filters)},
    {"holes", 0, "measure and draw the artifact of holes", NULL, ISO_IN(filters_run, holes)},
    {"output", 'o', "write the charts", "DIR", ISO_IN(filters_run, output)},
    {"format", 0, "write the charts as svg or pdf (svg)", "svg|pdf", ISO_IN(filters_run, format), .flags = ISO_ONE_OF},
    {"size", 0, "render N x N pixels; --holes renders 2N x 2N", "N", ISO_IN(filters_run, size), .flags = ISO_SHOWN,
     .least = 16, .most = 2048},
    {"voxels", 0, "use N voxels along an edge", "N", ISO_IN(filters_run, voxels), .flags = ISO_SHOWN,
     .least = MIN_VOXELS, .most = 512},
    ISO_OPTIONS_END,
};

static iso_status run(const iso_cli *cli, void *values, iso_error *err)
{
    filters_run *r = values;
    r->cli = cli;
    return run_all(r, err);
}

const iso_command iso_lab_filters = {
    .name = "consistency",
    .summary = "cases in which each direction filter holds or fails, and holes of undefined directions",
    .usage = "--filters and/or --holes [-o DIR] [options]",
    .details =
        "Analytic scenes, some with normal noise (relative to their range): smooth, noisy spheres, plates, shells,\n"
        "two balls that nearly touch, vessels. Errors are against the field without noise. DIR gets a chart of each,\n"
        "with its data and script.",
    .examples = "  isoshade-lab consistency --holes --size 48 --voxels 32\n",
    ISO_COMMAND_OPTIONS(filters_run, options, .size = 96, .voxels = 96, .format = "svg"),
    .run = run,
};

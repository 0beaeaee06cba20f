/* SPDX-License-Identifier: MIT */
/* shading.c - compares the shading of coarse levels with the finest one's, by each method for directions, over volumes
 * and views.
 *
 * Paper: [diaz-garcia-2017] sec. 3 and 5, Figures 3 and 15. Every figure is printed with that of on-the-fly gradients
 * of the level's own scalar. */
#define _GNU_SOURCE
#include "lab/shading.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "options/input.h"
#include "lab/shading_run.h"
#include "lab/volumes.h"
#include "scene/subject.h"
#include "tf/adapt.h"

/* ---- methods for directions ---- */

const iso_shading_method iso_shading_methods[ISO_SHADING_METHODS] = {
    {.name = "on-the-fly", .filter = ISO_DIRECTION_MOMENTS, .source = ISO_FROM_ON_THE_FLY},
    {.name = "naive", .filter = ISO_DIRECTION_NAIVE, .source = ISO_FROM_CODES},
    {.name = "eq1", .filter = ISO_DIRECTION_EQ1, .source = ISO_FROM_CODES},
    {.name = "eq1-own", .filter = ISO_DIRECTION_EQ1, .source = ISO_FROM_CODES, .radius = 1},
    {.name = "unit", .filter = ISO_DIRECTION_MOMENTS, .source = ISO_FROM_CODES, .unit = true},
    {.name = "default", .filter = ISO_DIRECTION_MOMENTS, .source = ISO_FROM_CODES},
    {.name = "flipped", .filter = ISO_DIRECTION_MOMENTS, .source = ISO_FROM_FLIPPED},
    {.name = "tensor", .filter = ISO_DIRECTION_TENSOR, .source = ISO_FROM_CODES},
    {.name = "tensor-flip", .filter = ISO_DIRECTION_TENSOR, .source = ISO_FROM_FLIPPED},
    {.name = "auto", .filter = ISO_DIRECTION_AUTO, .source = ISO_FROM_CODES},
    {.name = "fly-adapted", .filter = ISO_DIRECTION_MOMENTS, .source = ISO_FROM_ON_THE_FLY, .adapted = true},
    {.name = "def-adapted", .filter = ISO_DIRECTION_MOMENTS, .source = ISO_FROM_CODES, .adapted = true},
};
/* ---- volumes ---- */

static const iso_shading_volume analytic[] = {
    {ISO_SHADING_ANALYTIC, "sphere", NULL, ISO_FIELD_SPHERE, 0},
    {ISO_SHADING_ANALYTIC, "noisy-sphere", NULL, ISO_FIELD_SPHERE, 0.01},
    {ISO_SHADING_ANALYTIC, "marschner-lobb", NULL, ISO_FIELD_MARSCHNER_LOBB, 0},
    {ISO_SHADING_ANALYTIC, "plate", NULL, ISO_FIELD_PLATE, 0},
    {ISO_SHADING_ANALYTIC, "shells", NULL, ISO_FIELD_SHELLS, 0},
    {ISO_SHADING_ANALYTIC, "tubes", NULL, ISO_FIELD_TUBES, 0},
    {ISO_SHADING_HELD, "noisy-shells", NULL, ISO_FIELD_SHELLS, 0.05},
    {ISO_SHADING_HELD, "vessels", NULL, ISO_FIELD_VESSELS, 0},
    {ISO_SHADING_HELD, "balls", NULL, ISO_FIELD_BALLS, 0},
};

static iso_status load_subject(const iso_shading_run *run, const iso_shading_volume *s, iso_volume *v, iso_field *field,
                               iso_error *err)
{
    if (s->path)
        return iso_volume_input_load(s->path, &run->input, v, err);
    return iso_shading_sample(s->kind, (size_t)run->analytic_size, s->noise, field, v, err);
}

/* ---- measuring ---- */

static iso_status measure_level(const iso_shading_run *run, const iso_shading_subject *s, const iso_pyramid *p,
                                size_t k, int m, iso_shading_result *r, iso_error *err)
{
    OWNED(iso_tf_table) table = {0};
    iso_adapt_options opt = iso_adapt_defaults();
    opt.threads = run->cli->threads;
    if (iso_shading_methods[m].adapted)
        NEED(iso_adapt_level(p, k, &s->views[0].tf, &opt, &table, NULL, err));
    return iso_shading_measure(s,
                               &(iso_shading_shown){&p->levels[k], k, p->options.code, iso_shading_methods[m].source,
                                                    iso_shading_methods[m].adapted ? &table : NULL, 0},
                               &r->error[m], err);
}

static iso_status measure_method(const iso_shading_run *run, const iso_shading_subject *s, const iso_volume *v,
                                 size_t at, int m, iso_error *err)
{
    OWNED(iso_pyramid) p = {0};
    NEED(iso_shading_build(&iso_shading_methods[m], v, run->subjects[at].name, (size_t)run->levels, run->cli->threads,
                           &p, err));
    for (size_t k = 1; k < p.level_count; ++k)
        NEED(measure_level(run, s, &p, k, m, iso_shading_result_of(run, at, k), err));
    return ISO_OK;
}

/* Measures level 0's own directions on the level: everywhere with --floor, otherwise where the default lost. */
static iso_status measure_floors(const iso_shading_run *run, const iso_shading_subject *s, const iso_pyramid *p,
                                 size_t at, iso_error *err)
{
    iso_status status = ISO_OK;
    for (size_t k = 1; k < p->level_count && status == ISO_OK; ++k) {
        iso_shading_result *r = iso_shading_result_of(run, at, k);
        r->done = true;
        r->has_floor = run->floor || iso_shading_wins(run, r, ISO_SHADING_DEFAULT) < run->views;
        if (r->has_floor)
            status = iso_shading_floor(s, &p->levels[0], &p->levels[k], k, p->options.code, &r->floor, err);
        r->left_out = iso_shading_why_left_out(run, r);
    }
    return status;
}

static void print_subject(const iso_shading_run *run, size_t at)
{
    const iso_otsu_surface *surface = &run->surfaces[at];
    if (surface->left_out && !run->cli->json)
        printf("%-26s   left out: %s (threshold %.2f, shows %.2f of the border)\n", run->subjects[at].name,
               surface->left_out, surface->fraction, surface->border);
    for (size_t k = 1; k < ISO_SHADING_LEVELS && !run->cli->json; ++k) {
        const iso_shading_result *r = iso_shading_result_of(run, at, k);
        if (!r->done)
            continue;
        printf("%-26s %zu", run->subjects[at].name, k);
        for (int m = 0; m < iso_shading_method_end(run); ++m)
            printf(" %11.4f", r->error[m].dssim_mean);
        printf("  surface %.2f%s", surface->fraction, surface->below ? " and below" : "");
        if (r->has_floor)
            printf("  floor %.4f", r->floor.dssim_mean);
        printf("\n%-26s  ", "");
        for (int m = 0; m < iso_shading_method_end(run); ++m)
            printf(isfinite(r->error[m].truth_mean_deg) ? " %6.1f/%4.1f" : " %6.1f     ", r->error[m].angle_mean_deg,
                   r->error[m].truth_mean_deg);
        printf("  better: %d of %d%s%s\n", iso_shading_wins(run, r, ISO_SHADING_DEFAULT), run->views,
               r->left_out ? "; left out: " : "", r->left_out ? r->left_out : "");
    }
    fflush(stdout);
}

static iso_status run_subject(iso_shading_run *run, size_t at, iso_error *err)
{
    const iso_shading_volume *u = &run->subjects[at];
    OWNED(iso_volume) v = {0};
    iso_field field;
    iso_pyramid_options build = iso_pyramid_defaults();
    OWNED(iso_pyramid) p = {0};
    iso_shading_subject s = {0};
    const iso_shading_look look = {.view_count = run->views, .image_size = (size_t)run->size, .surface = run->surface};
    iso_progress progress = iso_cli_progress(run->cli);
    char stage[64];
    snprintf(stage, sizeof stage, "%zu of %zu: %s", at + 1, run->subject_count, u->name);
    iso_progress_report(&progress, stage, 0);
    build.level_count = (size_t)run->levels;
    build.threads = run->cli->threads;
    iso_status status = load_subject(run, u, &v, &field, err);
    TRY(status, iso_pyramid_build(&v, u->name, &build, &p, NULL, err));
    TRY(status, iso_shading_begin(&s, run->gl, &p.levels[0], build.code, u->path ? NULL : &field, &look, err));
    const bool has_surface = status == ISO_OK && !s.surface.left_out;
    for (int m = 0; m < iso_shading_method_end(run) && has_surface && status == ISO_OK; ++m) {
        status = measure_method(run, &s, &v, at, m, err);
        iso_progress_report(&progress, stage, (m + 1.0) / (iso_shading_method_end(run) + 1));
    }
    if (has_surface && status == ISO_OK)
        status = measure_floors(run, &s, &p, at, err);
    run->surfaces[at] = s.surface;
    if (status == ISO_OK)
        print_subject(run, at);
    iso_progress_report(&progress, stage, 1);
    iso_shading_end(&s);
    return status;
}

/* ---- the command ---- */

static void add_file(iso_shading_run *run, iso_shading_block b, const char *path)
{
    if (run->subject_count < ISO_SHADING_SUBJECTS)
        run->subjects[run->subject_count++] = (iso_shading_volume){.block = b,
                                                                   .name = iso_path_base(path),
                                                                   .path = path};
}

/* Lists given files, files held back (separated by commas, cut here), and analytic fields. */
static void list_subjects(iso_shading_run *run)
{
    for (size_t i = 0; i < run->cli->argument_count; ++i)
        add_file(run, ISO_SHADING_REAL, run->cli->arguments[i]);
    for (size_t i = 0; i < sizeof analytic / sizeof *analytic; ++i)
        run->subjects[run->subject_count++] = analytic[i];
    for (char *at = run->held; at && *at;) {
        char *comma = strchr(at, ',');
        if (comma)
            *comma = 0;
        if (*at)
            add_file(run, ISO_SHADING_HELD, at);
        at = comma ? comma + 1 : NULL;
    }
}

static iso_status run_all(iso_shading_run *run, iso_error *err)
{
    if (run->quick) {
        run->views = run->views < 2 ? run->views : 2;
        run->size = run->size < 96 ? run->size : 96;
        run->analytic_size = run->analytic_size < 48 ? run->analytic_size : 48;
    }
    iso_status status = iso_lab_check_pictures(&(iso_lab_pictures){run->views, ISO_DIAGONAL_VIEWS, run->size,
                                                                   run->levels, ISO_SHADING_LEVELS},
                                               err);
    list_subjects(run);
    run->results = calloc(run->subject_count * ISO_SHADING_LEVELS, sizeof *run->results);
    if (status == ISO_OK && !run->results)
        status = iso_fail(err, ISO_E_MEMORY, "no memory for %zu volumes' results", run->subject_count);
    TRY(status, iso_gl_create(&run->gl, NULL, err));
    if (status == ISO_OK && !run->cli->json) {
        printf(
            "DSSIM; below it angles to G0 and to exact gradients, degrees; images in which the default beats on the fly\n%-26s k",
            "volume");
        for (int m = 0; m < iso_shading_method_end(run); ++m)
            printf(" %11s", iso_shading_methods[m].name);
        printf("\n");
    }
    for (size_t at = 0; at < run->subject_count && status == ISO_OK; ++at)
        status = run_subject(run, at, err);
    if (status == ISO_OK && run->csv)
        status = iso_shading_write_csv(run, err);
    if (status == ISO_OK)
        iso_shading_report(run);
    free(run->results);
    iso_gl_destroy(run->gl);
    return status;
}

static const iso_option options[] = {
    {"shading", 0, "measure directions (default without a volume)", NULL, ISO_IN(iso_shading_run, shading)},
    {"held", 0, "report these volumes in a separate block", "FILE,FILE", ISO_IN(iso_shading_run, held)},
    {"views", 0, "use N views along an icosahedron's diagonals, at most 6", "N", ISO_IN(iso_shading_run, views),
     .flags = ISO_SHOWN},
    {"size", 0, "render N x N pixels", "N", ISO_IN(iso_shading_run, size), .flags = ISO_SHOWN},
    {"levels", 0, "use N levels, counting level 0", "N", ISO_IN(iso_shading_run, levels), .flags = ISO_SHOWN},
    {"surface", 0, "set the surface, a fraction of the range (by [otsu-1979])", "FRACTION",
     ISO_IN(iso_shading_run, surface), .most = 1},
    {"analytic", 0, "use analytic volumes of N^3 voxels", "N", ISO_IN(iso_shading_run, analytic_size),
     .flags = ISO_SHOWN, .least = 16, .most = 512},
    {"adapted", 0, "also use each level's own transfer function", NULL, ISO_IN(iso_shading_run, adapted)},
    {"floor", 0, "use level 0's directions at every level (only if the default lost)", NULL,
     ISO_IN(iso_shading_run, floor)},
    {"quick", 0, "use two views of 96 pixels, analytic volumes of 48^3", NULL, ISO_IN(iso_shading_run, quick)},
    {"csv", 0, "write all figures as a table", "FILE", ISO_IN(iso_shading_run, csv)},
    ISO_OPTIONS_OF(iso_shading_run, input, iso_input_rows),
    ISO_OPTIONS_END,
};

static iso_status run(const iso_cli *cli, void *values, iso_error *err)
{
    iso_shading_run *r = values;
    r->cli = cli;
    return run_all(r, err);
}

const iso_command iso_lab_shading = {
    .name = "consistency",
    .summary = "shading at coarse levels compared with level 0, by each kind of directions",
    .max_arguments = 64,
    .usage = "--shading [VOLUME...] [options]",
    .details =
        "One surface-like transfer function, the same at all levels and for all volumes. Errors are DSSIM over\n"
        "visible pixels, against level 0 with its own directions. Six analytic volumes are measured with the given\n"
        "ones. Three more, and those of --held, are held back: no choice was made by them. Left out of means and\n"
        "medians, and counted: volumes whose surface would show the background, or whose values do not split into\n"
        "two classes; levels that show nothing, or without an error.",
    .examples = "  isoshade make shells --size 48 --type uint8 -o shells.nrrd\n"
                "  isoshade-lab consistency --shading shells.nrrd --quick --levels 3\n",
    ISO_COMMAND_OPTIONS(iso_shading_run, options, .views = ISO_DIAGONAL_VIEWS, .size = 160, .levels = 4,
                        .analytic_size = 96, .shading = 1),
    .run = run,
};

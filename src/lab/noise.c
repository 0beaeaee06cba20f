/* SPDX-License-Identifier: MIT */
/* noise.c - measures how much of a coarse level's error is noise of level 0 that no level can show.
 *
 * Analytic volumes get normal noise; their ground truth is the volume without it. For measured volumes a denoised one
 * stands in. Levels are compared with pictures of level 0: its own, its values with true directions, ground truth. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/file.h"
#include "lab/lab.h"
#include "lab/denoise.h"
#include "lab/level_error.h"
#include "lab/look.h"
#include "lab/shading_method.h"
#include "lab/surface.h"
#include "lab/volumes.h"
#include "encode/code.h"
#include "options/input.h"
#include "renderers/renderers.h"
#include "scene/views.h"

enum { MAX_LEVELS = 8, ESTIMATORS = 3, TRUTH = ESTIMATORS, ROWS = ESTIMATORS + 1 };
static const iso_gradient_method estimators[ESTIMATORS] = {ISO_GRADIENT_CENTRAL, ISO_GRADIENT_SOBEL,
                                                           ISO_GRADIENT_SMOOTH};

typedef struct noise_run {
    const iso_cli *cli;
    iso_volume_input input;
    int views, size, levels, analytic_size, quick;
    double noise, deviation; /* deviation: of given volumes; below 0: estimated */
    const char *scalar_filter;
    iso_scalar_filter filter;
    iso_renderers renderers;
    json_t *cases;
} noise_run;

/* A volume and its ground truth, both as pyramids; the volume has a pyramid per estimator. */
typedef struct noise_subject {
    const char *name;
    double deviation; /* of the noise, as a fraction of the range */
    iso_volume noisy, clean;
    iso_field field; /* only for analytic volumes */
    bool analytic;
    iso_pyramid truth, of[ESTIMATORS];
} noise_subject;

/* ---- pictures ---- */

/* Combines a level's scalar with the directions of another pyramid's same level. */
static iso_level mixed(const iso_pyramid *scalar, const iso_pyramid *directions, size_t level)
{
    iso_level l = scalar->levels[level];
    l.codes = directions->levels[level].codes;
    return l;
}

static iso_status render(noise_run *run, const noise_subject *s, const iso_level *shown, const iso_view *view,
                         iso_image *image, iso_error *err)
{
    iso_level one = *shown;
    const iso_pyramid p = {.options = s->truth.options, .level_count = 1, .levels = &one};
    iso_render_options opt = iso_render_defaults(iso_renderers_usual());
    const iso_progress silent = {0};
    opt.threads = run->cli->threads;
    return iso_render_with(&(iso_render_request){&run->renderers, &p, 0, view, &opt, &silent}, image, NULL, err);
}

/* Adds the weighted DSSIM of b against a to *sum. */
static iso_status add_error(const iso_image *a, const iso_image *b, double weight, double *sum, iso_error *err)
{
    iso_level_error e;
    const iso_status status = iso_level_error_measure(a, b, &e, err);
    *sum += weight * e.dssim;
    return status;
}

/* Results for the directions of one estimator, or for true directions. */
typedef struct noise_row {
    double angle_deg;       /* level 0's directions to true ones, at the surface */
    double finest_to_truth; /* level 0's image against ground truth */
    double to_own[MAX_LEVELS], to_true_directions[MAX_LEVELS], to_truth[MAX_LEVELS];
    double clean_to_truth[MAX_LEVELS]; /* levels of the noise-free volume: the error of coarse voxels without noise */
} noise_row;

static iso_status measure_row(noise_run *run, const noise_subject *s, int row, const iso_view *view,
                              const iso_image references[2], noise_row *out, iso_error *err)
{
    const iso_pyramid *p = &s->of[row == TRUTH ? 0 : row], *directions = row == TRUTH ? &s->truth : p;
    const double weight = 1.0 / run->views;
    iso_image own = {0};
    iso_level level = mixed(p, directions, 0);
    iso_status status = render(run, s, &level, view, &own, err);
    TRY(status, add_error(&references[1], &own, weight, &out->finest_to_truth, err));
    for (size_t k = 1; k < p->level_count && status == ISO_OK; ++k) {
        iso_image image = {0}, clean = {0};
        level = mixed(p, directions, k);
        status = render(run, s, &level, view, &image, err);
        TRY(status, add_error(&own, &image, weight, &out->to_own[k], err));
        TRY(status, add_error(&references[0], &image, weight, &out->to_true_directions[k], err));
        TRY(status, add_error(&references[1], &image, weight, &out->to_truth[k], err));
        if (status == ISO_OK && row == TRUTH)
            status = render(run, s, &s->truth.levels[k], view, &clean, err);
        if (status == ISO_OK && row == TRUTH)
            status = add_error(&references[1], &clean, weight, &out->clean_to_truth[k], err);
        iso_image_destroy(&clean);
        iso_image_destroy(&image);
    }
    iso_image_destroy(&own);
    return status;
}

static iso_status measure_view(noise_run *run, const noise_subject *s, int number, noise_row rows[ROWS],
                               const iso_tf *tf, iso_error *err)
{
    const iso_lab_look look = {(size_t)run->size, true, 0.5};
    iso_image references[2] = {{0}}; /* true directions on noisy values; ground truth */
    iso_view view;
    iso_status status = iso_lab_view(&look, &s->truth.levels[0], tf, iso_view_of_faces(number, run->views), &view, err);
    if (status != ISO_OK)
        return status;
    const iso_level level = mixed(&s->of[0], &s->truth, 0);
    status = render(run, s, &level, &view, &references[0], err);
    TRY(status, render(run, s, &s->truth.levels[0], &view, &references[1], err));
    for (int r = 0; r < ROWS && status == ISO_OK; ++r)
        status = measure_row(run, s, r, &view, references, &rows[r], err);
    iso_image_destroy(&references[0]);
    iso_image_destroy(&references[1]);
    iso_view_destroy(&view);
    return status;
}

/* ---- angles ---- */

static iso_vec3 direction_at(const iso_pyramid *p, size_t voxel)
{
    double e[3], d[3];
    iso_code_lattice(p->options.code, p->levels[0].codes + 3 * voxel, e);
    iso_code_decode(p->options.code, e, d);
    return iso_normalize(iso_v3(d[0], d[1], d[2]));
}

/* Averages angles over voxels whose true value lies on the TF's ramp; light is two-sided, and so are angles. */
static double mean_angle_deg(const noise_subject *s, const iso_pyramid *p, const iso_otsu_surface *surface)
{
    const iso_level *l = &s->truth.levels[0];
    const size_t *n = l->geometry.size;
    double sum = 0, count = 0;
    for (size_t i = 0; i < iso_geometry_voxel_count(&l->geometry); ++i) {
        const double part = ((double)l->scalar[i] - l->min) / (l->max - l->min);
        if (fabs(part - surface->fraction) > ISO_SURFACE_HALF_RAMP)
            continue;
        iso_vec3 truth = direction_at(&s->truth, i);
        if (s->analytic) {
            const iso_vec3 at = {(double)(i % n[0]) + 0.5, (double)(i / n[0] % n[1]) + 0.5,
                                 (double)(i / (n[0] * n[1])) + 0.5};
            iso_field_value(&s->field, iso_geometry_to_world(&l->geometry, at), &truth);
            truth = iso_normalize(truth);
        }
        if (iso_norm(truth) < 0.5)
            continue;
        sum += acos(fmin(fabs(iso_dot(truth, direction_at(p, i))), 1)) * (180 / 3.14159265358979323846);
        count += 1;
    }
    return count > 0 ? sum / count : NAN;
}

/* ---- subjects ---- */

static iso_status build_pyramids(const noise_run *run, noise_subject *s, iso_error *err)
{
    iso_pyramid_options build = iso_pyramid_defaults();
    build.level_count = (size_t)run->levels;
    build.scalar_filter = run->filter;
    build.threads = run->cli->threads;
    iso_status status = iso_pyramid_build(&s->clean, s->name, &build, &s->truth, NULL, err);
    for (int e = 0; e < ESTIMATORS && status == ISO_OK; ++e) {
        build.gradient.method = estimators[e];
        status = iso_pyramid_build(&s->noisy, s->name, &build, &s->of[e], NULL, err);
    }
    return status;
}

static void note_row(noise_run *run, const noise_subject *s, int row, const noise_row *r)
{
    const char *name = row == TRUTH ? "truth" : iso_gradient_name(estimators[row]);
    const double angle = r->angle_deg;
    json_t *levels = json_array();
    for (size_t k = 1; k < s->truth.level_count; ++k) {
        json_t *o = json_pack("{s:i, s:f, s:f, s:f}", "level", (int)k, "dssim_to_own", r->to_own[k],
                              "dssim_to_true_directions", r->to_true_directions[k], "dssim_to_truth", r->to_truth[k]);
        if (row == TRUTH)
            json_object_set_new(o, "dssim_of_clean_level", json_real(r->clean_to_truth[k]));
        json_array_append_new(levels, o);
    }
    json_array_append_new(run->cases,
                          json_pack("{s:s, s:f, s:s, s:o, s:f, s:o}", "volume", s->name, "noise", s->deviation,
                                    "directions", name, "angle_mean_deg", iso_json_number(angle), "dssim_of_finest",
                                    r->finest_to_truth, "levels", levels));
    if (run->cli->json)
        return;
    printf("%-22s %.4f %-8s %6.2f %8.4f ", s->name, s->deviation, name, angle, r->finest_to_truth);
    for (size_t k = 1; k < s->truth.level_count; ++k)
        printf("  %.4f %.4f %.4f", r->to_own[k], r->to_true_directions[k], r->to_truth[k]);
    if (row == TRUTH) {
        printf("   clean:");
        for (size_t k = 1; k < s->truth.level_count; ++k)
            printf(" %.4f", r->clean_to_truth[k]);
    }
    printf("\n");
    fflush(stdout);
}

/* Measures a subject whose volumes exist, then clears it. */
static iso_status run_subject(noise_run *run, noise_subject *s, iso_error *err)
{
    noise_row rows[ROWS] = {{0}};
    iso_status status = build_pyramids(run, s, err);
    iso_otsu_surface surface = {0};
    if (status == ISO_OK)
        surface = iso_surface_find(&s->truth.levels[0]);
    if (status == ISO_OK && surface.left_out && !run->cli->json)
        printf("%-22s left out: %s\n", s->name, surface.left_out);
    if (status == ISO_OK && !surface.left_out) {
        iso_surface_tf points;
        const iso_tf tf = iso_surface_make_tf(&surface, &points);
        for (int i = 0; i < run->views && status == ISO_OK; ++i)
            status = measure_view(run, s, i, rows, &tf, err);
        for (int r = 0; r < ROWS && status == ISO_OK; ++r) {
            rows[r].angle_deg = mean_angle_deg(s, r == TRUTH ? &s->truth : &s->of[r], &surface);
            note_row(run, s, r, &rows[r]);
        }
    }
    for (int e = 0; e < ESTIMATORS; ++e)
        iso_pyramid_destroy(&s->of[e]);
    iso_pyramid_destroy(&s->truth);
    iso_volume_destroy(&s->noisy);
    iso_volume_destroy(&s->clean);
    return status;
}

static iso_status run_analytic(noise_run *run, iso_field_kind kind, double noise, iso_error *err)
{
    noise_subject s = {.name = iso_field_name(kind), .deviation = noise, .analytic = true};
    const size_t n = (size_t)run->analytic_size;
    iso_status status = iso_shading_sample(kind, n, 0, &s.field, &s.clean, err);
    TRY(status, iso_shading_sample(kind, n, noise, &s.field, &s.noisy, err));
    if (status == ISO_OK)
        return run_subject(run, &s, err);
    iso_volume_destroy(&s.clean);
    return status;
}

/* Converts the volume to floats and denoises it. */
static iso_status denoise_volume(const noise_run *run, noise_subject *s, iso_error *err)
{
    const size_t *n = s->noisy.geometry.size, count = iso_geometry_voxel_count(&s->noisy.geometry);
    float *values = malloc(count * sizeof *values);
    double deviation = 0, low = INFINITY, high = -INFINITY;
    iso_status status = values ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "no memory for %zu voxels", count);
    TRY(status, iso_volume_create(&s->clean, &s->noisy.geometry, ISO_F32, s->name, err));
    if (status == ISO_OK)
        iso_volume_floats(&s->noisy, values);
    for (size_t i = 0; i < count && status == ISO_OK; ++i) {
        low = fmin(low, (double)values[i]);
        high = fmax(high, (double)values[i]);
    }
    TRY(status, iso_noise_estimate(values, n, &deviation, err));
    if (run->deviation >= 0)
        deviation = run->deviation * (high - low);
    TRY(status, iso_denoise(values, n, deviation, s->clean.data, err));
    s->deviation = high > low ? deviation / (high - low) : 0;
    free(values);
    return status;
}

static iso_status run_file(noise_run *run, const char *path, iso_error *err)
{
    noise_subject s = {.name = iso_path_base(path)};
    iso_status status = iso_volume_input_load(path, &run->input, &s.noisy, err);
    TRY(status, denoise_volume(run, &s, err));
    if (status == ISO_OK)
        return run_subject(run, &s, err);
    iso_volume_destroy(&s.noisy);
    iso_volume_destroy(&s.clean);
    return status;
}

/* ---- the command ---- */

static iso_status run_all(noise_run *run, iso_error *err)
{
    static const iso_field_kind kinds[] = {ISO_FIELD_SPHERE, ISO_FIELD_SHELLS, ISO_FIELD_MARSCHNER_LOBB,
                                           ISO_FIELD_TUBES};
    enum { KINDS = sizeof kinds / sizeof *kinds };
    if (run->quick)
        run->views = 1, run->size = 64, run->analytic_size = run->analytic_size < 32 ? run->analytic_size : 32;
    const iso_progress progress = iso_cli_progress(run->cli);
    const double parts = 2 * KINDS + (double)run->cli->argument_count;
    double done = 0;
    iso_cli_expect(run->cli, &(iso_cli_stage){"noise", 1}, 1);
    if (!run->cli->json)
        printf(
            "DSSIM of each level against: its own level 0, true directions on its values, ground truth\n%-22s %6s %-8s "
            "%6s %8s   levels 1, 2 ...\n",
            "volume", "noise", "by", "angle", "level 0");
    iso_status status = ISO_OK;
    for (int noisy = 0; noisy < 2; ++noisy)
        for (int i = 0; i < KINDS && status == ISO_OK && run->analytic_size > 0; ++i) {
            status = run_analytic(run, kinds[i], noisy ? run->noise : 0, err);
            iso_progress_report(&progress, "noise", ++done / parts);
        }
    for (size_t i = 0; i < run->cli->argument_count && status == ISO_OK; ++i) {
        status = run_file(run, run->cli->arguments[i], err);
        iso_progress_report(&progress, "noise", ++done / parts);
    }
    return status;
}

static iso_status check_options(noise_run *run, iso_error *err)
{
    iso_status status = iso_lab_check_pictures(&(iso_lab_pictures){run->views, ISO_FACE_VIEWS, run->size, run->levels,
                                                                   MAX_LEVELS},
                                               err);
    if (status == ISO_OK && run->analytic_size != 0)
        status = iso_words_check_range("--analytic", run->analytic_size, 16, 512, err);
    if (status == ISO_OK && iso_scalar_filter_from_name(run->scalar_filter, &run->filter, err) != ISO_OK)
        status = iso_fail_in(err, ISO_E_USAGE, "--scalar-filter");
    return status;
}

static const iso_option options[] = {
    {"noise", 0, "set the noise's standard deviation (range of values is 1)", "PART", ISO_IN(noise_run, noise),
     .flags = ISO_SHOWN, .most = 1},
    {"analytic", 0, "use analytic volumes of N^3 voxels; 0: none", "N", ISO_IN(noise_run, analytic_size),
     .flags = ISO_SHOWN},
    {"deviation", 0, "set the noise of given volumes, a fraction of their range (estimated)", "PART",
     ISO_IN(noise_run, deviation), .most = 1},
    {"scalar-filter", 0, "set the scalar filter of all levels", "NAME", ISO_IN(noise_run, scalar_filter),
     .flags = ISO_SHOWN},
    {"views", 0, "use N views from an icosahedron's faces, at most 20", "N", ISO_IN(noise_run, views),
     .flags = ISO_SHOWN},
    {"size", 0, "render N x N pixels", "N", ISO_IN(noise_run, size), .flags = ISO_SHOWN},
    {"levels", 0, "use N levels, counting level 0", "N", ISO_IN(noise_run, levels), .flags = ISO_SHOWN},
    {"quick", 0, "use one view of 64 pixels, analytic volumes of 32^3", NULL, ISO_IN(noise_run, quick)},
    ISO_OPTIONS_OF(noise_run, input, iso_input_rows),
    ISO_OPTIONS_END,
};

static iso_status run(const iso_cli *cli, void *values, iso_error *err)
{
    noise_run *r = values;
    r->cli = cli;
    r->cases = json_array();
    iso_status status = check_options(r, err);
    TRY(status, run_all(r, err));
    if (status == ISO_OK && cli->json) {
        json_t *root = iso_cli_json(cli);
        json_object_set(root, "cases", r->cases);
        iso_cli_print_json(root);
    }
    json_decref(r->cases);
    iso_renderers_end(&r->renderers);
    return status;
}

const iso_command iso_lab_noise = {
    .name = "noise",
    .summary = "how much of a coarse level's error is noise of level 0",
    .max_arguments = 64,
    .usage = "[VOLUME...] [options]",
    .details =
        "Sphere, shells, Marschner-Lobb and tubes, without and with noise; the ground truth is the volume without\n"
        "noise. Given volumes are compared with themselves, denoised by non-local means [buades-2005]. The transfer\n"
        "function is an opaque ramp at the true surface. Rows are estimators of level 0's gradients, and the true\n"
        "directions at all levels; angles are of level 0 at the surface.",
    .examples = "  isoshade-lab noise --quick --levels 2\n",
    ISO_COMMAND_OPTIONS(noise_run, options, .views = 6, .size = 160, .levels = 4, .analytic_size = 96, .noise = 0.05,
                        .deviation = -1, .scalar_filter = "least-squares"),
    .run = run,
};

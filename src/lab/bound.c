/* SPDX-License-Identifier: MIT */
/* bound.c - the bound of a level's image (render/image_bound.h) against the measured RMSE, over volumes, transfer
 * functions, levels and views, with the original and the adapted transfer function (--adapt). It counts cases above
 * their bound and does not fail on them. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/file.h"
#include "lab/image_bound_rays.h"
#include "lab/lab.h"
#include "lab/volumes.h"
#include "compare/metrics.h"
#include "lab/quartiles.h"
#include "render/image_bound.h"
#include "renderers/renderers.h"
#include "scene/views.h"
#include "tf/adapt.h"

/* Images below this RMSE have no error worth a factor. */
#define LEAST_RMSE 1e-4

typedef struct bound_bench {
    const iso_cli *cli;
    iso_volume_input input;
    int views, size, levels, shaded, perspective, points, causes;
    iso_renderers renderers;
    double *factors, *signs, *regions; /* bound / RMSE, and the two parts of that product */
    size_t factor_count, case_count, above_count;
    json_t *cases;
} bound_bench;

/* A volume under one transfer function and in one view. */
typedef struct bound_case {
    const char *volume;
    const iso_pyramid *pyramid;
    const iso_level_tf *tf;
    int number; /* the view's number */
    iso_view view;
    iso_image finest;
} bound_case;

static iso_status make_view(const bound_bench *b, bound_case *c, iso_error *err)
{
    const iso_vec3 direction = iso_view_of_faces(c->number, b->views);
    const iso_level *level0 = &c->pyramid->levels[0];
    const iso_scene scene = {.path = "bench",
                             .width = (size_t)b->size,
                             .height = (size_t)b->size,
                             .camera_fit = true,
                             .orthographic = !b->perspective,
                             .fov_y_deg = 40,
                             .camera_direction = direction,
                             .camera_up = iso_view_up(direction),
                             .margin = 1,
                             .light_count = 1,
                             .lights = {{.direction = {0.3, 0.5, 0.8}, .in_camera_space = true, .intensity = 1}},
                             .shading = {.ambient = b->shaded ? 0.3 : 1,
                                         .diffuse = b->shaded ? 0.5 : 0,
                                         .specular = b->shaded ? 0.2 : 0,
                                         .power = 16},
                             .step_voxels = 0.25,
                             .tf = iso_level_tf_of(c->tf)};
    return iso_scene_resolve(&scene, &level0->geometry, level0->min, level0->max, &c->view, err);
}

static iso_status draw(bound_bench *b, bound_case *c, size_t level, const iso_tf_table *tf, iso_image *image,
                       iso_error *err)
{
    const iso_renderer_info *renderer = iso_renderers_usual();
    iso_render_options opt = iso_render_defaults(renderer);
    const iso_tf_table own = c->view.tf;
    iso_progress progress = {0};
    opt.step_voxels = c->view.step_voxels / ldexp(1, (int)level); /* the same length at every level */
    opt.threads = b->cli->threads;
    c->view.tf = *tf;
    const iso_render_request frame = {&b->renderers, c->pyramid, level, &c->view, &opt, &progress};
    const iso_status status = iso_render_with(&frame, image, NULL, err);
    c->view.tf = own;
    return status;
}

/* RMSE and bound of a case, and with --causes the integral of absolute values along the rays. */
typedef struct bound_figures {
    double measured, bound, unsigned_rays;
} bound_figures;

static void note(bound_bench *b, const bound_case *c, size_t level, bool adapted, const bound_figures *f)
{
    const double measured = f->measured, bound = f->bound;
    const bool above = !(measured <= bound);
    const double factor = measured > LEAST_RMSE ? bound / measured : NAN, signs = f->unsigned_rays / measured;
    ++b->case_count;
    b->above_count += above;
    if (isfinite(factor)) {
        b->signs[b->factor_count] = signs;
        b->regions[b->factor_count] = bound / f->unsigned_rays;
        b->factors[b->factor_count++] = factor;
    }
    json_array_append_new(b->cases,
                          json_pack("{s:s, s:s, s:i, s:i, s:b, s:f, s:f, s:o, s:o, s:b}", "volume", c->volume, "tf",
                                    c->tf->name, "view", c->number, "level", (int)level, "adapted", adapted, "rmse",
                                    measured, "bound", bound, "factor", iso_json_number(factor), "signs",
                                    iso_json_number(signs), "above", above));
    if (!b->cli->json)
        printf("%-22s %-13s %4d %zu %-8s  %.5f  %.5f  %6.2f", c->volume, c->tf->name, c->number, level,
               adapted ? "adapted" : "original", measured, bound, factor);
    if (!b->cli->json && b->causes)
        printf("  %6.2f  %6.2f", signs, factor / signs);
    if (!b->cli->json)
        puts(above ? "  ABOVE" : "");
    fflush(stdout);
}

static iso_status run_level(bound_bench *b, bound_case *c, size_t level, bool adapted, iso_error *err)
{
    iso_adapt_options opt = iso_adapt_defaults();
    OWNED(iso_tf_table) table = {0};
    OWNED(iso_image) image = {0};
    iso_metrics m = {0};
    bound_figures f = {NAN, NAN, NAN};
    opt.threads = b->cli->threads;
    NEED(iso_adapt_level(c->pyramid, adapted ? level : 0, &c->view.tf, &opt, &table, NULL, err));
    NEED(draw(b, c, level, &table, &image, err));
    NEED(iso_metrics_measure(&c->finest, &image, &m, err));
    const iso_image_bound_input in = {.fine = &c->pyramid->levels[0],
                                      .coarse = &c->pyramid->levels[level],
                                      .level = level,
                                      .code = c->pyramid->options.code,
                                      .source = ISO_FROM_CODES,
                                      .view = &c->view,
                                      .coarse_tf = &table,
                                      .points = b->points,
                                      .threads = b->cli->threads};
    NEED(iso_image_bound_rmse(&in, &f.bound, err));
    if (b->causes)
        NEED(iso_image_bound_without_signs(&in, &f.unsigned_rays, err));
    f.measured = m.rmse;
    note(b, c, level, adapted, &f);
    return ISO_OK;
}

static iso_status run_case(bound_bench *b, bound_case *c, iso_error *err)
{
    iso_status status = make_view(b, c, err);
    TRY(status, draw(b, c, 0, &c->view.tf, &c->finest, err));
    for (size_t level = 1; level < c->pyramid->level_count && status == ISO_OK; ++level)
        for (int adapted = 0; adapted < 2 && status == ISO_OK; ++adapted)
            status = run_level(b, c, level, adapted, err);
    iso_image_destroy(&c->finest);
    iso_view_destroy(&c->view);
    return status;
}

static iso_status run_tf(void *user, const iso_lab_visited *v, iso_error *err)
{
    bound_bench *b = user;
    const iso_progress progress = iso_cli_progress(b->cli);
    for (int view = 0; view < b->views; ++view) {
        const double done = ((double)v->number + (double)view / b->views) / (double)v->count;
        iso_progress_report(&progress, "cases", done);
        NEED(run_case(b, &(bound_case){.volume = v->volume, .pyramid = v->pyramid, .tf = v->tf, .number = view}, err));
    }
    return ISO_OK;
}

/* Returns the median of one cause's factor (their product is the bound's factor); NaN without --causes. */
static double median_of(const bound_bench *b, double *values)
{
    return b->causes ? iso_ratios_summarize(values, b->factor_count).median : NAN;
}

static void report(bound_bench *b)
{
    const double signs = median_of(b, b->signs), regions = median_of(b, b->regions);
    const iso_ratios factors = iso_ratios_summarize(b->factors, b->factor_count);
    if (b->cli->json) {
        json_t *root = iso_cli_json(b->cli);
        json_object_set(root, "cases", b->cases);
        json_object_update_new(root, json_pack("{s:I, s:I, s:I, s:o, s:o, s:o, s:o, s:o}", "case_count",
                                               (json_int_t)b->case_count, "above_count", (json_int_t)b->above_count,
                                               "factor_count", (json_int_t)b->factor_count, "factor_quartile_1",
                                               iso_json_number(factors.lower), "factor_median",
                                               iso_json_number(factors.median), "factor_quartile_3",
                                               iso_json_number(factors.upper), "signs_median", iso_json_number(signs),
                                               "regions_median", iso_json_number(regions)));
        iso_cli_print_json(root);
    } else {
        printf("%zu cases, %zu above their bound; bound / RMSE of the %zu cases with an RMSE above %g: median %.2f, "
               "quartiles %.2f and %.2f\n",
               b->case_count, b->above_count, b->factor_count, LEAST_RMSE, factors.median, factors.lower,
               factors.upper);
        if (b->causes)
            printf("parts of it: absolute values along rays: median %.2f; regions in place of rays: median %.2f\n",
                   signs, regions);
    }
}

static iso_status run_all(bound_bench *b, iso_error *err)
{
    const size_t most = b->cli->argument_count * ISO_LEVEL_TF_COUNT * (size_t)b->views * (size_t)b->levels * 2;
    iso_status status = ISO_OK;
    b->cases = json_array();
    b->factors = malloc(3 * (most + 1) * sizeof *b->factors);
    b->signs = b->factors ? b->factors + most + 1 : NULL;
    b->regions = b->factors ? b->signs + most + 1 : NULL;
    if (!b->factors)
        status = iso_fail(err, ISO_E_MEMORY, "out of memory");
    if (status == ISO_OK && !b->cli->json)
        printf("%-22s %-13s view k %-8s  %-7s  %-7s  factor%s\n", "volume", "tf", "tf", "RMSE", "bound",
               b->causes ? "   signs regions" : "");
    iso_cli_expect(b->cli, &(iso_cli_stage){"cases", 1}, 1);
    if (status == ISO_OK)
        status = iso_lab_visit_volumes(&(iso_lab_volumes){b->cli, &b->input, b->levels, NULL}, run_tf, b, err);
    if (status == ISO_OK)
        report(b);
    json_decref(b->cases);
    free(b->factors);
    iso_renderers_end(&b->renderers);
    return status;
}

static const iso_option options[] = {
    {"views", 0, "use N views from an icosahedron's faces", "N", ISO_IN(bound_bench, views), .flags = ISO_SHOWN},
    {"size", 0, "render N x N pixels", "N", ISO_IN(bound_bench, size), .flags = ISO_SHOWN},
    {"levels", 0, "use N levels, counting level 0", "N", ISO_IN(bound_bench, levels), .flags = ISO_SHOWN},
    {"shaded", 0, "shade with a light", NULL, ISO_IN(bound_bench, shaded)},
    {"points", 0, "set the bound's points per voxel axis (2; 1 in large volumes)", "N", ISO_IN(bound_bench, points),
     .most = 8},
    {"causes", 0, "split each factor into signs and regions", NULL, ISO_IN(bound_bench, causes)},
    {"perspective", 0, "use a perspective camera instead of an orthographic one", NULL,
     ISO_IN(bound_bench, perspective)},
    ISO_OPTIONS_OF(bound_bench, input, iso_input_rows),
    ISO_OPTIONS_END,
};

static iso_status run(const iso_cli *cli, void *values, iso_error *err)
{
    bound_bench *b = values;
    b->cli = cli;
    NEED(iso_lab_check_pictures(&(iso_lab_pictures){b->views, ISO_FACE_VIEWS, b->size, b->levels, 8}, err));
    return run_all(b, err);
}

const iso_command iso_lab_bound = {
    .name = "bound",
    .summary = "the bound of a level's RMSE by `tf bound`, compared with the measured RMSE",
    .min_arguments = 1,
    .max_arguments = 64,
    .usage = "VOLUME... [options]",
    .details =
        "Four transfer functions (surface, soft, two-material, shell), original and adapted, at all coarse levels. A\n"
        "factor is bound / RMSE; cases above their bound are counted. --causes splits it in two: the integral of\n"
        "absolute values along the rays / RMSE, and the bound / that integral.",
    .examples = "  isoshade make shells --size 40 --type uint8 -o shells.nrrd\n"
                "  isoshade-lab bound shells.nrrd --views 1 --size 48 --levels 2\n",
    ISO_COMMAND_OPTIONS(bound_bench, options, .views = 3, .size = 96, .levels = 4),
    .run = run,
};

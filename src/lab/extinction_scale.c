/* SPDX-License-Identifier: MIT */
/* extinction_scale.c - cost of an extinction scale per fine voxel, and its opacity error against level 0. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/file.h"
#include "base/parallel.h"
#include "lab/lab.h"
#include "lab/volumes.h"
#include "fit/extinction_scale.h"
#include "renderers/renderers.h"
#include "tf/adapt.h"

typedef struct scale_bench {
    const iso_cli *cli;
    iso_volume_input input;
    int levels, size, runs;
    iso_renderers renderers;
    json_t *rows;
} scale_bench;

/* A level under one transfer function. */
typedef struct scale_case {
    const iso_pyramid *pyramid;
    size_t level;
    const char *volume, *tf;
    iso_view *view; /* with the original transfer function; borrowed */
} scale_case;

typedef struct scale_cost {
    double create_seconds, apply_seconds, frame_seconds;
    iso_extinction_scale_cost errors;
} scale_cost;

/* Measures the fastest of several runs, for the work per level and per edit. Processor time over all cores is less
 * affected by other work than the clock. */
static iso_status time_scale(const scale_bench *b, const scale_case *c, const iso_tf_table *own, uint8_t *bytes,
                             scale_cost *cost, iso_error *err)
{
    const iso_level *levels = c->pyramid->levels;
    iso_status status = ISO_OK;
    for (int run = 0; run < b->runs && status == ISO_OK; ++run) {
        iso_extinction_scaler *s;
        const double start = iso_cpu_seconds();
        status = iso_extinction_scaler_create(&levels[0], &levels[c->level], c->level, b->cli->threads, &s, err);
        const double made = iso_cpu_seconds();
        TRY(status, iso_extinction_scaler_apply(s, &c->view->tf, own, bytes, &cost->errors, err));
        cost->create_seconds = fmin(cost->create_seconds, made - start);
        cost->apply_seconds = fmin(cost->apply_seconds, iso_cpu_seconds() - made);
        iso_extinction_scaler_destroy(s);
    }
    return status;
}

static iso_status time_frame(scale_bench *b, const scale_case *c, const iso_tf_table *own, uint8_t *bytes,
                             double *seconds, iso_error *err)
{
    iso_render_options opt = iso_render_defaults(iso_renderers_usual());
    const iso_progress silent = {0};
    iso_render_stats stats = {0};
    iso_image image = {0};
    iso_view shown = *c->view; /* borrowed */
    shown.tf = *own;
    shown.extinction_scale = bytes;
    opt.processor_time = true;
    opt.repeats = (size_t)b->runs + 1;
    opt.stats = &stats;
    const iso_status status = iso_render_with(&(iso_render_request){&b->renderers, c->pyramid, c->level, &shown, &opt,
                                                                    &silent},
                                              &image, NULL, err);
    *seconds = stats.seconds;
    iso_image_destroy(&image);
    return status;
}

static void note(scale_bench *b, const scale_case *c, const scale_cost *cost)
{
    const double fine = (double)iso_geometry_voxel_count(&c->pyramid->levels[0].geometry);
    const double seen = (double)cost->errors.seen, a_voxel = seen > 0 ? cost->apply_seconds / seen : 0;
    const double frames = a_voxel * 1e6 / cost->frame_seconds;
    json_array_append_new(b->rows,
                          json_pack("{s:s, s:s, s:i, s:f, s:f, s:f, s:f, s:f, s:f, s:f}", "volume", c->volume, "tf",
                                    c->tf, "level", (int)c->level, "seen_part", seen / fine, "create_ns_per_fine_voxel",
                                    1e9 * cost->create_seconds / fine, "apply_ns_per_seen_voxel", 1e9 * a_voxel,
                                    "apply_seconds", cost->apply_seconds, "frames_per_million_seen_voxels", frames,
                                    "rms_opacity_unscaled", cost->errors.error_one, "rms_opacity_scaled",
                                    cost->errors.error));
    if (!b->cli->json)
        printf("%-20s %-13s %zu %7.1f %% %9.1f %9.1f %10.1f %10.1f %8.2f   %.4f %.4f\n", c->volume, c->tf, c->level,
               100 * seen / fine, 1e9 * cost->create_seconds / fine, 1e9 * a_voxel, 1e3 * cost->apply_seconds,
               1e3 * cost->frame_seconds, frames, cost->errors.error_one, cost->errors.error);
    fflush(stdout);
}

static iso_status run_case(scale_bench *b, const scale_case *c, iso_error *err)
{
    iso_adapt_options opt = iso_adapt_defaults();
    scale_cost cost = {.create_seconds = INFINITY, .apply_seconds = INFINITY};
    iso_tf_table own;
    opt.fall_back = false;
    uint8_t *bytes = malloc(iso_geometry_voxel_count(&c->pyramid->levels[c->level].geometry));
    iso_status status = bytes ? iso_adapt_level(c->pyramid, c->level, &c->view->tf, &opt, &own, NULL, err)
                              : iso_fail(err, ISO_E_MEMORY, "no memory for one byte per voxel");
    if (status != ISO_OK) {
        free(bytes);
        return status;
    }
    status = time_scale(b, c, &own, bytes, &cost, err);
    TRY(status, time_frame(b, c, &own, bytes, &cost.frame_seconds, err));
    if (status == ISO_OK)
        note(b, c, &cost);
    iso_tf_table_destroy(&own);
    free(bytes);
    return status;
}

static iso_status make_view(const scale_bench *b, const iso_pyramid *p, const iso_tf *tf, iso_view *view,
                            iso_error *err)
{
    const iso_level *level0 = &p->levels[0];
    const iso_scene scene = {.path = "bench",
                             .width = (size_t)b->size,
                             .height = (size_t)b->size,
                             .camera_fit = true,
                             .camera_direction = {0.5, 1, -0.4},
                             .camera_up = {0, 0, 1},
                             .fov_y_deg = 30,
                             .margin = 1,
                             .light_count = 1,
                             .lights = {{.direction = {-0.5, 0.5, 1}, .in_camera_space = true, .intensity = 1}},
                             .shading = {.ambient = 0.3, .diffuse = 0.7, .power = 1},
                             .step_voxels = 0.5,
                             .tf = *tf};
    return iso_scene_resolve(&scene, &level0->geometry, level0->min, level0->max, view, err);
}

static iso_status run_tf(void *user, const iso_lab_visited *v, iso_error *err)
{
    const iso_tf tf = iso_level_tf_of(v->tf);
    iso_view view = {0};
    iso_status status = make_view(user, v->pyramid, &tf, &view, err);
    for (size_t level = 1; level < v->pyramid->level_count && status == ISO_OK; ++level)
        status = run_case(user, &(scale_case){v->pyramid, level, v->volume, v->tf->name, &view}, err);
    iso_view_destroy(&view);
    return status;
}

static iso_status run_all(scale_bench *b, iso_error *err)
{
    iso_status status =
        iso_lab_check_pictures(&(iso_lab_pictures){.size = b->size, .levels = b->levels, .most_levels = 8}, err);
    if (status != ISO_OK)
        return status;
    b->rows = json_array();
    if (!b->cli->json)
        printf("%-20s %-13s %c %9s %9s %9s %10s %10s %8s   %s\n%-20s %-13s %c %9s %9s %9s %10s %10s %8s\n", "volume",
               "tf", 'k', "seen", "once, ns", "edit, ns", "edit", "frame", "frames", "opacity off by", "", "", ' ', "",
               "per voxel", "per seen", "ms", "ms", "per 10^6");
    const iso_progress progress = iso_cli_progress(b->cli);
    status = iso_lab_visit_volumes(&(iso_lab_volumes){b->cli, &b->input, b->levels, &progress}, run_tf, b, err);
    if (status == ISO_OK && b->cli->json) {
        json_t *root = iso_cli_json(b->cli);
        json_object_set(root, "cases", b->rows);
        iso_cli_print_json(root);
    }
    json_decref(b->rows);
    iso_renderers_end(&b->renderers);
    return status;
}

static const iso_option options[] = {
    {"levels", 0, "use N levels, counting level 0", "N", ISO_IN(scale_bench, levels), .flags = ISO_SHOWN},
    {"size", 0, "render a frame of N x N pixels", "N", ISO_IN(scale_bench, size), .flags = ISO_SHOWN},
    {"runs", 0, "run N times; the fastest counts", "N", ISO_IN(scale_bench, runs), .flags = ISO_SHOWN, .least = 1,
     .most = 15},
    ISO_OPTIONS_OF(scale_bench, input, iso_input_rows),
    ISO_OPTIONS_END,
};

static iso_status run(const iso_cli *cli, void *values, iso_error *err)
{
    scale_bench *b = values;
    b->cli = cli;
    return run_all(b, err);
}

const iso_command iso_lab_extinction_scale = {
    .name = "extinction-scale",
    .summary = "time to compute an extinction scale, against a frame, and the remaining error",
    .min_arguments = 1,
    .max_arguments = 64,
    .usage = "VOLUME... [options]",
    .details =
        "Four transfer functions, adapted to each level. Once per level: the ranges of runs of fine voxels. Per edit\n"
        "of the transfer function: three passes over the fine voxels of visible runs, and a check of the result; per\n"
        "such voxel, and per million of them in frames of the ray caster. All times are processor time over all\n"
        "cores. \"opacity off by\": RMS over these voxels, without and with a scale.",
    .examples = "  isoshade make shells --size 48 --type uint8 -o shells.nrrd\n"
                "  isoshade-lab extinction-scale shells.nrrd --levels 3 --size 64 --runs 1\n",
    ISO_COMMAND_OPTIONS(scale_bench, options, .levels = 4, .size = 256, .runs = 3),
    .run = run,
};

/* SPDX-License-Identifier: MIT */
/* tf.c - cost of adapted transfer functions: counting joint histograms once per volume, adapting after each edit, and
 * bytes per level. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/json.h"
#include "base/parallel.h"
#include "lab/lab.h"
#include "options/input.h"
#include "scene/subject.h"
#include "render/gl/raycaster.h"
#include "tf/adapt.h"
#include "volume/synthetic.h"

typedef struct tf_bench {
    const iso_cli *cli;
    iso_volume_input input;
    int size, levels, runs, no_gl;
} tf_bench;

typedef struct tf_times {
    double histogram_seconds, histogram_cpu_seconds, plan_seconds, adapt_seconds, edit_seconds, stored_bytes;
    double views_seconds; /* processor time */
    size_t entry_count;
} tf_times;

static iso_status make_pyramid(const tf_bench *b, iso_pyramid *p, iso_error *err)
{
    iso_pyramid_options build = iso_pyramid_defaults();
    iso_progress progress = iso_cli_progress(b->cli);
    build.level_count = (size_t)b->levels;
    build.threads = b->cli->threads;
    if (b->cli->argument_count > 0)
        return iso_subject_load_pyramid(b->cli->arguments[0], &b->input, &build, &progress, p, err);
    size_t n = (size_t)b->size;
    iso_field field = {.kind = ISO_FIELD_NOISE, .seed = 1};
    OWNED(iso_volume) v = {0};
    field.geometry = iso_geometry_axis_aligned((size_t[]){n, n, n}, (double[]){1, 1, 1});
    NEED(iso_field_sample(&field, ISO_U16, &v, err));
    return iso_pyramid_build(&v, "noise", &build, p, &progress, err);
}

/* Makes a soft ramp whose entries all differ. */
static iso_status make_table(const iso_pyramid *p, iso_tf_table *table, iso_error *err)
{
    static iso_tf_point points[] = {{0, {0.1, 0.2, 0.6}, 0}, {0.3, {0.3, 0.4, 0.5}, 0.01}, {1, {1, 0.9, 0.6}, 0.2}};
    const iso_tf tf = {.fit_range = true,
                       .unit_distance = 1,
                       .unit_is_voxels = true,
                       .table_size = 256,
                       .point_count = 3,
                       .points = points};
    return iso_tf_tabulate(&tf, p->levels[0].min, p->levels[0].max, &p->levels[0].geometry, table, err);
}

/* Measures the shortest time of several runs, for each step separately. */
static iso_status measure(const tf_bench *b, const iso_pyramid *p, size_t level, int bits, const iso_tf_table *tf,
                          tf_times *t, iso_error *err)
{
    const iso_geometry *level0 = &p->levels[0].geometry;
    iso_adapt_options opt = iso_adapt_defaults();
    iso_joint joint = {0};
    iso_adapter *adapter = NULL;
    iso_tf_table table = {0};
    iso_status status = ISO_OK;
    *t = (tf_times){INFINITY, INFINITY, INFINITY, INFINITY, INFINITY, 0, INFINITY, 0};
    for (int run = 0; run < b->runs && status == ISO_OK; ++run) {
        iso_joint_destroy(&joint);
        double start = iso_clock_seconds(), cpu = iso_cpu_seconds();
        status = iso_joint_compute(p, level, bits, ISO_SECOND_VALUE_NONE, b->cli->threads, &joint, err);
        t->histogram_seconds = fmin(t->histogram_seconds, iso_clock_seconds() - start);
        t->histogram_cpu_seconds = fmin(t->histogram_cpu_seconds, iso_cpu_seconds() - cpu);
        iso_adapter_destroy(adapter);
        start = iso_clock_seconds();
        TRY(status, iso_adapter_create(&joint, &opt, &adapter, err));
        t->plan_seconds = fmin(t->plan_seconds, iso_clock_seconds() - start);
    }
    TRY(status, iso_adapter_apply(adapter, tf, level0, level, &table, err));
    for (int run = 0; run < 10 * b->runs && status == ISO_OK; ++run) {
        iso_adapt_judgment verdict;
        double start = iso_clock_seconds();
        status = iso_adapter_update(adapter, tf, level0, level, &table, err);
        t->adapt_seconds = fmin(t->adapt_seconds, iso_clock_seconds() - start);
        TRY(status, iso_adapt_judge(&joint, tf, &table, level0, &verdict, err));
        t->edit_seconds = fmin(t->edit_seconds, iso_clock_seconds() - start);
    }
    const iso_small_views_input views = {.fine = p->levels,
                                         .coarse = &p->levels[level],
                                         .level = level,
                                         .original = tf,
                                         .tfs = {tf, &table},
                                         .tf_count = 2,
                                         .threads = b->cli->threads};
    for (int run = 0; run < b->runs && status == ISO_OK; ++run) {
        iso_small_views_error errors[ISO_SMALL_VIEWS_MAX_TFS];
        const double start = iso_cpu_seconds();
        status = iso_small_views_compare(&views, errors, err);
        t->views_seconds = fmin(t->views_seconds, iso_cpu_seconds() - start);
    }
    t->stored_bytes = iso_joint_stored_bytes(&joint);
    t->entry_count = joint.entry_count;
    iso_tf_table_destroy(&table);
    iso_adapter_destroy(adapter);
    iso_joint_destroy(&joint);
    return status;
}

/* Copies level 0: the least time of a pass over it. */
static iso_status measure_copy(const tf_bench *b, const iso_pyramid *p, double *seconds, iso_error *err)
{
    const size_t bytes = iso_geometry_voxel_count(&p->levels[0].geometry) * sizeof(float);
    float *copy = malloc(bytes);
    void *(*volatile copy_bytes)(void *, const void *,
                                 size_t) = memcpy; /* keeps the compiler from removing the unused copy */
    NEED_MEMORY(copy, err, "bench: no memory for a copy of %zu bytes", bytes);
    *seconds = INFINITY;
    for (int run = 0; run <= b->runs; ++run) { /* the first run touches the pages */
        double start = iso_clock_seconds();
        copy_bytes(copy, p->levels[0].scalar, bytes);
        *seconds = run > 0 ? fmin(*seconds, iso_clock_seconds() - start) : INFINITY;
    }
    free(copy);
    return ISO_OK;
}

/* Renders one frame of level 0 at 512 x 512, for scale. */
static iso_status measure_frame(const tf_bench *b, const iso_pyramid *p, const iso_tf_table *tf, double *seconds,
                                iso_error *err)
{
    iso_gl *gl = NULL;
    iso_view view;
    iso_image image = {0};
    iso_gl_options opt = iso_gl_defaults();
    opt.repeats = (size_t)b->runs;
    opt.seconds = seconds;
    opt.fast_filter = true;
    static iso_tf_point points[] = {{0, {0, 0, 0}, 0}, {1, {1, 1, 1}, 0.1}};
    const iso_scene scene = {.path = "bench",
                             .width = 512,
                             .height = 512,
                             .camera_fit = true,
                             .orthographic = true,
                             .camera_direction = {1, 2, -1},
                             .camera_up = {0, 0, 1},
                             .margin = 0.8,
                             .light_count = 1,
                             .lights = {{.direction = {0, 0, 1}, .in_camera_space = true, .intensity = 1}},
                             .shading = {.ambient = 0.3, .diffuse = 0.7, .power = 1},
                             .step_voxels = 0.5,
                             .tf = {.fit_range = true,
                                    .unit_distance = 1,
                                    .unit_is_voxels = true,
                                    .table_size = 256,
                                    .point_count = 2,
                                    .points = points}};
    NEED(iso_scene_resolve(&scene, &p->levels[0].geometry, p->levels[0].min, p->levels[0].max, &view, err));
    iso_tf_table own = view.tf;
    view.tf = *tf;
    iso_status status = iso_gl_create(&gl, NULL, err);
    TRY(status, iso_gl_render(gl, &p->levels[0], p->options.code, &view, &opt, &image, err));
    view.tf = own;
    iso_image_destroy(&image);
    iso_view_destroy(&view);
    iso_gl_destroy(gl);
    return status;
}

/* Reports Table 1 of the paper: bytes in addition to the levels' voxels, at one byte per voxel. histograms: of all
 * coarse levels, 8 bits. Younesy et al. store four bytes per coarse voxel (mean, deviation, gradient), three more. */
static void report_storage(const tf_bench *b, const iso_pyramid *p, double histograms, json_t *root)
{
    const double table = 256 * 4 * sizeof(float), levels = (double)(p->level_count - 1);
    double coarse = 0, all = (double)iso_geometry_voxel_count(&p->levels[0].geometry);
    for (size_t k = 1; k < p->level_count; ++k)
        coarse += (double)iso_geometry_voxel_count(&p->levels[k].geometry);
    all += coarse;
    const double tf_1d = histograms + levels * table, tf_2d = coarse + tf_1d + levels * ISO_TF_2D_ROWS * table;
    json_object_set_new(root, "storage",
                        json_pack("{s:f, s:f, s:f, s:f}", "voxel_bytes", all, "tf_1d_bytes", tf_1d, "tf_2d_bytes",
                                  tf_2d, "four_bytes_a_coarse_voxel", 3 * coarse));
    if (!b->cli->json)
        printf("storage: voxels of all levels %.4g MB; in addition histograms and tables %.3g MB, with 2D transfer\n"
               "         functions of the deviation %.3g MB; four bytes per coarse voxel [younesy-2006] add %.4g MB\n",
               all / 1e6, tf_1d / 1e6, tf_2d / 1e6, 3 * coarse / 1e6);
}

static iso_status run_all(const tf_bench *b, iso_error *err)
{
    OWNED(iso_pyramid) p = {0};
    OWNED(iso_tf_table) tf = {0};
    double frame = NAN, copy = NAN, histograms = 0;
    json_t *root = iso_cli_json(b->cli), *rows = json_array();
    iso_status status = make_pyramid(b, &p, err);
    TRY(status, make_table(&p, &tf, err));
    if (status == ISO_OK && !b->no_gl)
        status = measure_frame(b, &p, &tf, &frame, err);
    TRY(status, measure_copy(b, &p, &copy, err));
    const double voxels = status == ISO_OK ? (double)iso_geometry_voxel_count(&p.levels[0].geometry) : 1;
    if (status == ISO_OK && !b->cli->json && isfinite(frame))
        printf("a frame of 512 x 512 takes %.4g ms\n", 1e3 * frame);
    if (status == ISO_OK && !b->cli->json)
        printf(
            "%.0f fine voxels, %d threads; a copy of level 0 (memcpy, one thread) takes %.3g ns per voxel; least of %d\n"
            "                ---- counting per volume: ns per voxel ------   per level    ------ after an edit ------    - small views -\n"
            "k bits   clock  processor  processor of a copy    weights ms   adapt ms   all ms  of a frame       ms  ns / voxel   entries     bytes\n",
            voxels, iso_threads(b->cli->threads), 1e9 * copy / voxels, b->runs);
    for (int bits = 8; bits <= 12 && status == ISO_OK; bits += 4)
        for (size_t level = 1; level < p.level_count && status == ISO_OK; ++level) {
            tf_times t;
            status = measure(b, &p, level, bits, &tf, &t, err);
            if (status != ISO_OK)
                break;
            histograms += bits == 8 ? t.stored_bytes : 0;
            double ns = 1e9 * t.histogram_seconds / voxels, cpu_ns = 1e9 * t.histogram_cpu_seconds / voxels;
            if (!b->cli->json)
                printf("%zu %4d  %6.3f  %9.3f  %19.2f  %12.3f %10.4f %8.4f  %10.5f  %7.1f  %10.2f  %8zu  %8.0f\n",
                       level, bits, ns, cpu_ns, t.histogram_cpu_seconds / copy, 1e3 * t.plan_seconds,
                       1e3 * t.adapt_seconds, 1e3 * t.edit_seconds, t.edit_seconds / frame, 1e3 * t.views_seconds,
                       1e9 * t.views_seconds / voxels, t.entry_count, t.stored_bytes);
            json_array_append_new(rows,
                                  json_pack("{s:i, s:i, s:f, s:f, s:f, s:f, s:f, s:f, s:I, s:f}", "level", (int)level,
                                            "bits", bits, "histogram_ns_per_voxel", ns,
                                            "histogram_processor_ns_per_voxel", cpu_ns, "weights_seconds",
                                            t.plan_seconds, "adapt_seconds", t.adapt_seconds, "edit_seconds",
                                            t.edit_seconds, "small_views_processor_seconds", t.views_seconds, "entries",
                                            (json_int_t)t.entry_count, "stored_bytes", t.stored_bytes));
        }
    if (status == ISO_OK)
        report_storage(b, &p, histograms, root);
    json_object_set_new(root, "cases", rows);
    json_object_set_new(root, "copy_ns_per_voxel", json_real(1e9 * copy / voxels));
    json_object_set_new(root, "threads", json_integer(iso_threads(b->cli->threads)));
    json_object_set_new(root, "frame_seconds", iso_json_number(frame));
    if (status == ISO_OK && b->cli->json)
        iso_cli_print_json(root);
    else
        json_decref(root);
    return status;
}

static const iso_option options[] = {
    {"size", 0, "use noise of N^3 voxels if no volume is given", "N", ISO_IN(tf_bench, size), .flags = ISO_SHOWN,
     .least = 8, .most = 2048},
    {"levels", 0, "use N levels, counting level 0", "N", ISO_IN(tf_bench, levels), .flags = ISO_SHOWN, .least = 2,
     .most = 16},
    {"runs", 0, "run N times; the least time counts", "N", ISO_IN(tf_bench, runs), .flags = ISO_SHOWN, .least = 1,
     .most = 1000},
    {"no-gl", 0, "skip the frame that times are compared with", NULL, ISO_IN(tf_bench, no_gl)},
    ISO_OPTIONS_OF(tf_bench, input, iso_input_rows),
    ISO_OPTIONS_END,
};

static iso_status run(const iso_cli *cli, void *values, iso_error *err)
{
    tf_bench *b = values;
    b->cli = cli;
    return run_all(b, err);
}

const iso_command iso_lab_tf = {
    .name = "tf",
    .summary = "joint histograms and adapted transfer functions: time and bytes",
    .max_arguments = 1,
    .usage = "[VOLUME] [options]",
    .details =
        "Counting runs once per volume, weights once per level, adapting after each edit of the transfer function.\n"
        "\"all\" is adapting and computing its error at the voxels, for which the histogram and the transfer function\n"
        "suffice. Small views decide whether an adapted transfer function is used; their time is processor time.",
    .examples = "  isoshade-lab tf --size 64 --runs 2\n",
    ISO_COMMAND_OPTIONS(tf_bench, options, .size = 128, .levels = 4, .runs = 3),
    .run = run,
};

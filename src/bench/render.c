/* SPDX-License-Identifier: MIT */
/* render.c - time of the OpenGL ray caster by transfer function, gradients and loop. */
#include "bench/render.h"
#include "options/input.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "volume/synthetic.h"

const char *const iso_bench_tf_names[TF_COUNT] = {"dense", "sparse"};
const char *const iso_bench_gradients_names[GRADIENTS_COUNT] = {"none", "codes", "on-the-fly"};
const char *const iso_bench_loop_names[LOOP_COUNT] = {"plain", "skipping", "auto"};
static const iso_gl_skip loop_skips[LOOP_COUNT] = {ISO_GL_SKIP_NEVER, ISO_GL_SKIP_ALWAYS, ISO_GL_SKIP_AUTO};

/* Makes a TF. Dense: shows every value, too thin to end rays early. Sparse: shows the upper 40 % of the range,
 * denser. */
static iso_tf make_tf(bench_tf kind)
{
    static iso_tf_point dense[] = {{0, {0.2, 0.3, 0.9}, 0.002}, {1, {1, 0.9, 0.7}, 0.02}};
    static iso_tf_point sparse[] = {{0, {0, 0, 0}, 0}, {0.6, {0.9, 0.4, 0.2}, 0}, {0.7, {1, 0.9, 0.7}, 0.3}};
    iso_tf tf = {.fit_range = true,
                 .unit_distance = 1,
                 .unit_is_voxels = true,
                 .table_size = 256,
                 .point_count = kind == TF_DENSE ? 2 : 3,
                 .points = kind == TF_DENSE ? dense : sparse};
    return tf;
}

iso_scene iso_bench_scene(const bench_render_options *opt, bench_tf tf, bench_gradients gradients)
{
    return (iso_scene){
        .path = "bench",
        .width = (size_t)opt->image,
        .height = (size_t)opt->image,
        .camera_fit = true,
        .camera_direction = iso_normalize(iso_v3(0.5, 1, -0.4)),
        .camera_up = {0, 0, 1},
        .fov_y_deg = 30,
        .margin = 0.8,
        .light_count = gradients == GRADIENTS_NONE ? 0 : 1,
        .lights = {{.direction = iso_normalize(iso_v3(-0.5, 0.5, 1)), .in_camera_space = true, .intensity = 1}},
        .shading = {.ambient = gradients == GRADIENTS_NONE ? 1 : 0.3, .diffuse = 0.7},
        .step_voxels = opt->step_voxels,
        .tf = make_tf(tf)};
}

iso_status iso_bench_measure(iso_gl *gl, const iso_pyramid *p, const bench_render_options *opt, bench_render_case what,
                             double *seconds, iso_error *err)
{
    const iso_level *level = &p->levels[0];
    iso_scene scene = iso_bench_scene(opt, what.tf, what.gradients);
    iso_gl_options options = iso_gl_defaults();
    options.source = what.gradients == GRADIENTS_ON_THE_FLY ? ISO_FROM_ON_THE_FLY : ISO_FROM_CODES;
    options.skip = loop_skips[what.loop];
    options.repeats = (size_t)opt->runs + 1; /* the first one compiles */
    options.seconds = seconds;
    options.fast_filter = true;
    OWNED(iso_view) view = {0};
    iso_image image;
    NEED(iso_scene_resolve(&scene, &level->geometry, level->min, level->max, &view, err));
    NEED(iso_gl_render(gl, level, p->options.code, &view, &options, &image, err));
    iso_image_destroy(&image);
    return ISO_OK;
}

/* Measures all loops in turn, run after run, so that other load affects all of them. */
static iso_status measure_loops(iso_gl *gl, const iso_pyramid *p, const bench_render_options *opt, bench_tf tf,
                                bench_gradients gradients, double seconds[LOOP_COUNT], iso_error *err)
{
    bench_render_options once = *opt;
    iso_status status = ISO_OK;
    once.runs = 1;
    for (int loop = 0; loop < LOOP_COUNT; ++loop)
        seconds[loop] = INFINITY;
    for (int run = 0; run < opt->runs; ++run)
        for (int i = 0; i < LOOP_COUNT && status == ISO_OK; ++i) {
            const int loop = (i + run) % LOOP_COUNT;
            double least = INFINITY;
            status = iso_bench_measure(gl, p, &once, (bench_render_case){tf, gradients, (bench_loop)loop}, &least, err);
            seconds[loop] = fmin(seconds[loop], least);
        }
    return status;
}

static iso_status run_cases(const iso_cli *cli, iso_gl *gl, const iso_pyramid *p, const bench_render_options *opt,
                            iso_error *err)
{
    const size_t *size = p->levels[0].geometry.size;
    char size_text[64];
    snprintf(size_text, sizeof size_text, "%zux%zux%zu", size[0], size[1], size[2]);
    json_t *root = iso_cli_json(cli), *cases = json_array();
    json_object_set_new(root, "gl", json_string(iso_gl_describe(gl).renderer));
    json_object_set_new(root, "image", json_integer(opt->image));
    if (!cli->json)
        printf("%s, %s, image %d x %d, step %g voxels; milliseconds, least of %d\n%-8s %-12s %10s %10s %10s\n",
               iso_gl_describe(gl).renderer, size_text, opt->image, opt->image, opt->step_voxels, opt->runs, "tf",
               "gradients", iso_bench_loop_names[0], iso_bench_loop_names[1], iso_bench_loop_names[2]);
    iso_status status = ISO_OK;
    for (int tf = 0; tf < TF_COUNT; ++tf)
        for (int g = 0; g < GRADIENTS_COUNT && status == ISO_OK; ++g) {
            double seconds[LOOP_COUNT];
            if (opt->tf && strcmp(opt->tf, iso_bench_tf_names[tf]) != 0)
                continue;
            status = measure_loops(gl, p, opt, (bench_tf)tf, (bench_gradients)g, seconds, err);
            for (int loop = 0; loop < LOOP_COUNT && status == ISO_OK; ++loop)
                json_array_append_new(cases,
                                      json_pack("{s:s, s:s, s:s, s:s, s:s, s:f, s:f}", "renderer", "gl", "size",
                                                size_text, "tf", iso_bench_tf_names[tf], "gradients",
                                                iso_bench_gradients_names[g], "loop", iso_bench_loop_names[loop],
                                                "step_voxels", opt->step_voxels, "milliseconds", 1e3 * seconds[loop]));
            if (!cli->json && status == ISO_OK)
                printf("%-8s %-12s %10.1f %10.1f %10.1f\n", iso_bench_tf_names[tf], iso_bench_gradients_names[g],
                       1e3 * seconds[0], 1e3 * seconds[1], 1e3 * seconds[2]);
        }
    json_object_set_new(root, "cases", cases);
    if (cli->json && status == ISO_OK)
        iso_cli_print_json(root);
    else
        json_decref(root);
    return status;
}

iso_status iso_bench_load(const iso_cli *cli, const bench_render_options *opt, iso_pyramid *p, iso_error *err)
{
    const size_t n = (size_t)opt->size, size[3] = {n, n, n};
    const double spacing[3] = {1, 1, 1};
    iso_field field = {.kind = ISO_FIELD_SHELLS, .geometry = iso_geometry_axis_aligned(size, spacing), .seed = 1};
    iso_pyramid_options options = iso_pyramid_defaults();
    options.level_count = opt->bricks ? BENCH_LEVELS : 1;
    options.threads = cli->threads;
    OWNED(iso_volume) v = {0};
    NEED(cli->argument_count ? iso_volume_input_load(cli->arguments[0], &opt->input, &v, err)
                             : iso_field_sample(&field, ISO_U16, &v, err));
    return iso_pyramid_build(&v, cli->argument_count ? cli->arguments[0] : "shells", &options, p, NULL, err);
}

static iso_status bench(const iso_cli *cli, const bench_render_options *opt, iso_error *err)
{
    iso_pyramid p;
    iso_gl *gl;
    NEED(iso_gl_create(&gl, NULL, err));
    iso_gl_time_processor(gl, opt->processor_time);
    iso_status status = iso_bench_load(cli, opt, &p, err);
    if (status == ISO_OK) {
        status = opt->bricks ? iso_bench_bricks(cli, gl, &p, opt, err) : run_cases(cli, gl, &p, opt, err);
        iso_pyramid_destroy(&p);
    }
    iso_gl_destroy(gl);
    return status;
}

static const iso_option options[] = {
    {"size", 0, "voxels per side of the synthetic volume", "N", ISO_IN(bench_render_options, size), .flags = ISO_SHOWN,
     .least = 8, .most = 1024},
    {"image", 0, "pixels per side", "N", ISO_IN(bench_render_options, image), .flags = ISO_SHOWN, .least = 1,
     .most = 8192},
    {"step", 0, "set the ray step", "VOXELS", ISO_IN(bench_render_options, step_voxels), .flags = ISO_SHOWN,
     .least = 1e-3, .most = 100},
    {"runs", 0, "draw each case N times; the least time counts", "N", ISO_IN(bench_render_options, runs),
     .flags = ISO_SHOWN, .least = 1, .most = 1000},
    {"tf", 0, "measure only dense or only sparse", "dense|sparse", ISO_IN(bench_render_options, tf),
     .flags = ISO_ONE_OF},
    {"processor-time", 0, "measure processor time of all cores, for software GL on a busy machine", NULL,
     ISO_IN(bench_render_options, processor_time)},
    {"bricks", 0, "compare bricks of two levels with one texture instead", "VOXELS",
     ISO_IN(bench_render_options, bricks)},
    ISO_OPTIONS_OF(bench_render_options, input, iso_input_rows),
    ISO_OPTIONS_END,
};

static iso_status run(const iso_cli *cli, void *values, iso_error *err)
{
    return bench(cli, values, err);
}

const iso_command iso_bench_render = {
    .name = "bench render",
    .summary = "the OpenGL ray caster: dense and sparse TFs, sources of gradients, empty-space skipping",
    .max_arguments = 1,
    .usage = "[VOLUME] [options]",
    .details =
        "Without a volume: two thin shells of --size voxels per side. The dense TF shows every value thinly, the\n"
        "sparse one the upper 40 % of the range. Loops: plain takes every sample, skipping leaves out bricks that\n"
        "the TF does not show, auto selects one of them by the share of visible bricks.\n"
        "With --bricks: one texture; separate bricks (discontinuous); bricks with baked faces (smooth). A quarter of\n"
        "the bricks are in transition.",
    .common = "size image step runs tf processor-time bricks threads",
    .examples = "  isoshade bench render --size 48 --image 64 --runs 1\n"
                "  isoshade bench render --size 48 --image 64 --runs 1 --bricks 8\n",
    ISO_COMMAND_OPTIONS(bench_render_options, options, .size = 256, .image = 512, .runs = 3, .step_voxels = 1),
    .run = run,
};

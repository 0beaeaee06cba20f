/* bench_render.c - the ray caster's time by transfer function, gradients and loop. */
#include "cli/bench.h"
#include "cli/input.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "compare/metrics.h"
#include "render/bricks_gl.h"
#include "volume/synthetic.h"

typedef struct render_options {
    iso_cli_input input;
    int size, image, runs, bricks;
    double step_voxels;
} render_options;

typedef enum bench_tf { TF_DENSE, TF_SPARSE, TF_COUNT } bench_tf;
static const char *const tf_names[TF_COUNT] = {"dense", "sparse"};

typedef enum bench_gradients { GRADIENTS_NONE, GRADIENTS_CODES, GRADIENTS_ON_THE_FLY, GRADIENTS_COUNT } bench_gradients;
static const char *const gradients_names[GRADIENTS_COUNT] = {"none", "codes", "on-the-fly"};

typedef enum bench_loop { LOOP_PLAIN, LOOP_SKIPPING, LOOP_AUTO, LOOP_COUNT } bench_loop;
static const char *const loop_names[LOOP_COUNT] = {"plain", "skipping", "auto"};
static const iso_gl_skip loop_skips[LOOP_COUNT] = {ISO_GL_SKIP_NEVER, ISO_GL_SKIP_ALWAYS, ISO_GL_SKIP_AUTO};

/* Dense: every value shows, so thinly that no ray ends early. Sparse: the upper 40 % of the range alone, and denser. */
static iso_tf make_tf(bench_tf kind)
{
    static iso_tf_point dense[] = {{0, {0.2, 0.3, 0.9}, 0.002}, {1, {1, 0.9, 0.7}, 0.02}};
    static iso_tf_point sparse[] = {{0, {0, 0, 0}, 0}, {0.6, {0.9, 0.4, 0.2}, 0}, {0.7, {1, 0.9, 0.7}, 0.3}};
    iso_tf tf = {.fit_range = true, .unit_distance = 1, .unit_is_voxels = true, .table_size = 256,
                 .point_count = kind == TF_DENSE ? 2 : 3, .points = kind == TF_DENSE ? dense : sparse};
    return tf;
}

static iso_scene make_scene(const render_options *opt, bench_tf tf, bench_gradients gradients)
{
    return (iso_scene){.path = "bench", .width = (size_t)opt->image, .height = (size_t)opt->image, .camera_fit = true,
                       .camera_direction = {0.5, 1, -0.4}, .camera_up = {0, 0, 1}, .fov_y_deg = 30, .margin = 0.8,
                       .light_count = gradients == GRADIENTS_NONE ? 0 : 1,
                       .lights = {{.direction = {-0.5, 0.5, 1}, .in_camera_space = true, .intensity = 1}},
                       .shading = {.ambient = gradients == GRADIENTS_NONE ? 1 : 0.3, .diffuse = 0.7},
                       .step_voxels = opt->step_voxels, .tf = make_tf(tf)};
}

static iso_status measure(iso_gl *gl, const iso_pyramid *p, const render_options *opt, bench_tf tf,
                          bench_gradients gradients, bench_loop loop, double *seconds, iso_error *err)
{
    const iso_level *level = &p->levels[0];
    iso_scene scene = make_scene(opt, tf, gradients);
    iso_gl_options options = iso_gl_defaults();
    options.source = gradients == GRADIENTS_ON_THE_FLY ? ISO_FROM_ON_THE_FLY : ISO_FROM_CODES;
    options.skip = loop_skips[loop];
    options.repeats = (size_t)opt->runs + 1; /* the first one compiles */
    iso_view view;
    iso_image image;
    iso_status status = iso_scene_resolve(&scene, &level->geometry, level->min, level->max, &view, err);
    if (status != ISO_OK)
        return status;
    status = iso_gl_render(gl, level, p->options.code, &view, &options, &image, seconds, err);
    if (status == ISO_OK)
        iso_image_destroy(&image);
    iso_view_destroy(&view);
    return status;
}

static iso_status run_cases(const iso_cli *cli, iso_gl *gl, const iso_pyramid *p, const render_options *opt,
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
               "gradients", loop_names[0], loop_names[1], loop_names[2]);
    iso_status status = ISO_OK;
    for (int tf = 0; tf < TF_COUNT; ++tf)
        for (int g = 0; g < GRADIENTS_COUNT && status == ISO_OK; ++g) {
            double seconds[LOOP_COUNT] = {0};
            for (int loop = 0; loop < LOOP_COUNT && status == ISO_OK; ++loop) {
                status = measure(gl, p, opt, (bench_tf)tf, (bench_gradients)g, (bench_loop)loop, &seconds[loop], err);
                json_array_append_new(cases, json_pack("{s:s, s:s, s:s, s:s, s:s, s:f, s:f}", "renderer", "gl", "size",
                                                       size_text, "tf", tf_names[tf], "gradients", gradients_names[g],
                                                       "loop", loop_names[loop], "step_voxels", opt->step_voxels,
                                                       "milliseconds", 1e3 * seconds[loop]));
            }
            if (!cli->json && status == ISO_OK)
                printf("%-8s %-12s %10.1f %10.1f %10.1f\n", tf_names[tf], gradients_names[g], 1e3 * seconds[0],
                       1e3 * seconds[1], 1e3 * seconds[2]);
        }
    json_object_set_new(root, "cases", cases);
    if (cli->json && status == ISO_OK)
        iso_cli_print_json(root);
    else
        json_decref(root);
    return status;
}

enum { ACCURACY_LEVELS = 4 };

/* ---- bricks ------------------------------------------------------------------- */

typedef enum bench_texture { TEXTURE_UNIFORM, TEXTURE_OWN, TEXTURE_BAKED, TEXTURE_COUNT } bench_texture;
static const char *const texture_names[TEXTURE_COUNT] = {"uniform", "bricks-own", "bricks-baked"};

/* Fine in a box of bricks in the middle, coarse around it; returns the part of all bricks that are fine and touch a
 * coarse one. */
static double fill_box(const iso_node_levels *n, const size_t box[3], uint8_t *levels)
{
    size_t inner = 1, fine = 1;
    for (size_t i = 0; i < iso_brick_count(n); ++i) {
        const size_t b[3] = {i % n->count[0], i / n->count[0] % n->count[1], i / (n->count[0] * n->count[1])};
        levels[i] = 0;
        for (int a = 0; a < 3; ++a) {
            size_t first = (n->count[a] - box[a]) / 2;
            levels[i] = levels[i] || b[a] < first || b[a] >= first + box[a];
        }
    }
    for (int a = 0; a < 3; ++a) {
        size_t first = (n->count[a] - box[a]) / 2, faces = (first > 0) + (first + box[a] < n->count[a]);
        fine *= box[a];
        inner *= box[a] > faces ? box[a] - faces : 0;
    }
    return (double)(fine - inner) / (double)iso_brick_count(n);
}

/* The box whose part of transition bricks is nearest to a quarter. */
static double fill_quarter(const iso_node_levels *n, uint8_t *levels)
{
    size_t best[3] = {0, 0, 0};
    double nearest = 1;
    for (size_t z = 1; z <= n->count[2]; ++z)
        for (size_t y = 1; y <= n->count[1]; ++y)
            for (size_t x = 1; x <= n->count[0]; ++x) {
                double part = fill_box(n, (const size_t[3]){x, y, z}, levels);
                if (fabs(part - 0.25) < nearest) {
                    nearest = fabs(part - 0.25);
                    best[0] = x, best[1] = y, best[2] = z;
                }
            }
    return fill_box(n, best, levels);
}

static iso_status measure_texture(iso_gl *gl, const iso_pyramid *p, const iso_brick_field *field,
                                  const render_options *opt, bench_gradients gradients, bench_texture texture,
                                  double *seconds, iso_error *err)
{
    iso_scene scene = make_scene(opt, TF_DENSE, gradients);
    iso_gl_brick_options options = iso_gl_brick_defaults();
    iso_brick_field f = *field;
    iso_gl_brick_stats stats;
    iso_view view;
    iso_image image;
    if (texture == TEXTURE_UNIFORM)
        return measure(gl, p, opt, TF_DENSE, gradients, LOOP_PLAIN, seconds, err);
    const iso_level *level = &p->levels[0];
    iso_status status = iso_scene_resolve(&scene, &level->geometry, level->min, level->max, &view, err);
    if (status != ISO_OK)
        return status;
    f.faces = texture == TEXTURE_BAKED ? ISO_FACES_BAKED : ISO_FACES_OWN;
    options.shaded = gradients != GRADIENTS_NONE;
    options.skip = ISO_GL_SKIP_NEVER;
    options.repeats = (size_t)opt->runs + 1;
    status = iso_gl_render_bricks(gl, &f, &view, &options, &image, &stats, err);
    if (status == ISO_OK) {
        *seconds = stats.seconds;
        iso_image_destroy(&image);
    }
    iso_view_destroy(&view);
    return status;
}

static iso_status run_brick_cases(const iso_cli *cli, iso_gl *gl, const iso_pyramid *p, const iso_brick_field *field,
                                  double transition, const render_options *opt, json_t *root, iso_error *err)
{
    json_t *cases = json_array();
    json_object_set_new(root, "gl", json_string(iso_gl_describe(gl).renderer));
    json_object_set_new(root, "image", json_integer(opt->image));
    json_object_set_new(root, "transition_bricks", json_real(transition));
    if (!cli->json)
        printf("%s, image %d x %d, bricks of %d, %.0f %% of them in transition; milliseconds, least of %d\n%-12s %12s "
               "%12s %12s %22s\n",
               iso_gl_describe(gl).renderer, opt->image, opt->image, opt->bricks, 100 * transition, opt->runs,
               "gradients", texture_names[0], texture_names[1], texture_names[2], "baked / own, / uniform");
    iso_status status = ISO_OK;
    for (int g = GRADIENTS_NONE; g <= GRADIENTS_CODES && status == ISO_OK; ++g) {
        double seconds[TEXTURE_COUNT];
        for (int t = 0; t < TEXTURE_COUNT && status == ISO_OK; ++t) {
            status = measure_texture(gl, p, field, opt, (bench_gradients)g, (bench_texture)t, &seconds[t], err);
            if (status == ISO_OK)
                json_array_append_new(cases, json_pack("{s:s, s:s, s:s, s:s, s:f, s:f}", "renderer", "gl", "texture",
                                                       texture_names[t], "tf", "dense", "gradients", gradients_names[g],
                                                       "step_voxels", opt->step_voxels, "milliseconds",
                                                       1e3 * seconds[t]));
        }
        if (!cli->json && status == ISO_OK)
            printf("%-12s %12.1f %12.1f %12.1f %12.3f %9.3f\n", gradients_names[g], 1e3 * seconds[TEXTURE_UNIFORM],
                   1e3 * seconds[TEXTURE_OWN], 1e3 * seconds[TEXTURE_BAKED],
                   seconds[TEXTURE_BAKED] / seconds[TEXTURE_OWN], seconds[TEXTURE_BAKED] / seconds[TEXTURE_UNIFORM]);
    }
    json_object_set_new(root, "cases", cases);
    return status;
}

/* ---- nodes against cells ------------------------------------------------------ */


/* An image of a whole level, made of cells (2x2x2 means) or of nodes ([1 2 1]), at the same step in mm. */
static iso_status draw_level(iso_gl *gl, const iso_pyramid *p, const iso_node_levels *n, const iso_view *view, size_t k,
                             bool nodes, double step_voxels, uint8_t *levels, iso_image *image, iso_error *err)
{
    if (!nodes) {
        iso_gl_options options = iso_gl_defaults();
        options.step_voxels = ldexp(step_voxels, -(int)k);
        return iso_gl_render(gl, &p->levels[k], p->options.code, view, &options, image, NULL, err);
    }
    const iso_brick_field f = {.nodes = n, .levels = levels, .faces = ISO_FACES_BAKED};
    iso_gl_brick_options options = iso_gl_brick_defaults();
    options.step_voxels = step_voxels;
    memset(levels, (int)k, iso_brick_count(n));
    return iso_gl_render_bricks(gl, &f, view, &options, image, NULL, err);
}

/* RMSE of both to level 0, for one TF. */
static iso_status compare_levels(const iso_cli *cli, iso_gl *gl, const iso_pyramid *p, const iso_node_levels *n,
                                 const render_options *opt, bench_tf tf, uint8_t *levels, json_t *cases, iso_error *err)
{
    iso_scene scene = make_scene(opt, tf, GRADIENTS_CODES);
    const iso_level *level = &p->levels[0];
    iso_view view;
    iso_image exact = {0};
    iso_status status = iso_scene_resolve(&scene, &level->geometry, level->min, level->max, &view, err);
    if (status != ISO_OK)
        return status;
    status = draw_level(gl, p, n, &view, 0, false, opt->step_voxels, levels, &exact, err);
    for (size_t k = 1; k < p->level_count && k < n->level_count && status == ISO_OK; ++k) {
        iso_metrics m[2];
        for (int nodes = 0; nodes < 2 && status == ISO_OK; ++nodes) {
            iso_image image;
            status = draw_level(gl, p, n, &view, k, nodes, opt->step_voxels, levels, &image, err);
            if (status == ISO_OK)
                status = iso_metrics_measure(&image, &exact, &m[nodes], err);
            iso_image_destroy(&image);
        }
        if (status != ISO_OK)
            break;
        json_array_append_new(cases, json_pack("{s:s, s:I, s:f, s:f, s:f, s:f}", "tf", tf_names[tf], "level",
                                               (json_int_t)k, "cells_rmse", m[0].rmse, "nodes_rmse", m[1].rmse,
                                               "cells_ssim", m[0].ssim, "nodes_ssim", m[1].ssim));
        if (!cli->json)
            printf("%-8s %5zu %12.5f %12.5f %12.4f %12.4f\n", tf_names[tf], k, m[0].rmse, m[1].rmse, m[0].ssim,
                   m[1].ssim);
    }
    iso_image_destroy(&exact);
    iso_view_destroy(&view);
    return status;
}

static iso_status compare_nodes_with_cells(const iso_cli *cli, iso_gl *gl, const iso_pyramid *p,
                                           const iso_node_levels *n, const render_options *opt, uint8_t *levels,
                                           json_t *root, iso_error *err)
{
    json_t *cases = json_array();
    iso_status status = ISO_OK;
    if (!cli->json)
        printf("\nwhole levels against level 0, shaded\n%-8s %5s %12s %12s %12s %12s\n", "tf", "level", "cells RMSE",
               "nodes RMSE", "cells SSIM", "nodes SSIM");
    for (int tf = 0; tf < TF_COUNT && status == ISO_OK; ++tf)
        status = compare_levels(cli, gl, p, n, opt, (bench_tf)tf, levels, cases, err);
    json_object_set_new(root, "accuracy", cases);
    return status;
}

static iso_status bench_bricks(const iso_cli *cli, iso_gl *gl, const iso_pyramid *p, const render_options *opt,
                               iso_error *err)
{
    iso_node_levels n;
    iso_status status =
        iso_node_levels_create(&n, &p->levels[0], (size_t)opt->bricks, opt->bricks < 8 ? 2 : ACCURACY_LEVELS, true,
                               cli->threads, err);
    if (status != ISO_OK)
        return status;
    iso_node_levels_round(&n);
    uint8_t *levels = malloc(iso_brick_count(&n));
    if (!levels)
        status = iso_fail(err, ISO_E_MEMORY, "no memory for %zu bricks", iso_brick_count(&n));
    if (status == ISO_OK) {
        double transition = fill_quarter(&n, levels);
        const iso_brick_field field = {.nodes = &n, .levels = levels};
        json_t *root = iso_cli_json(cli);
        status = run_brick_cases(cli, gl, p, &field, transition, opt, root, err);
        if (status == ISO_OK)
            status = compare_nodes_with_cells(cli, gl, p, &n, opt, levels, root, err);
        if (cli->json && status == ISO_OK)
            iso_cli_print_json(root);
        else
            json_decref(root);
    }
    free(levels);
    iso_node_levels_destroy(&n);
    return status;
}

/* The volume that is named, or two thin shells. */
static iso_status load(const iso_cli *cli, const render_options *opt, iso_pyramid *p, iso_error *err)
{
    const size_t n = (size_t)opt->size, size[3] = {n, n, n};
    const double spacing[3] = {1, 1, 1};
    iso_field field = {.kind = ISO_FIELD_SHELLS, .geometry = iso_geometry_axis_aligned(size, spacing), .seed = 1};
    iso_pyramid_options options = iso_pyramid_defaults();
    options.level_count = opt->bricks ? ACCURACY_LEVELS : 1;
    options.threads = cli->threads;
    iso_volume v;
    iso_status status = cli->argument_count ? iso_cli_load_volume(cli->arguments[0], &opt->input, &v, err)
                                            : iso_field_sample(&field, ISO_U16, &v, err);
    if (status != ISO_OK)
        return status;
    status = iso_pyramid_build(&v, cli->argument_count ? cli->arguments[0] : "shells", &options, p, NULL, err);
    iso_volume_destroy(&v);
    return status;
}

static iso_status bench(const iso_cli *cli, const render_options *opt, iso_error *err)
{
    iso_pyramid p;
    iso_gl *gl;
    iso_status status = iso_cli_check_range("--size", opt->size, 8, 1024, err);
    if (status == ISO_OK)
        status = iso_cli_check_range("--image", opt->image, 1, 8192, err);
    if (status == ISO_OK)
        status = iso_cli_check_range("--runs", opt->runs, 1, 1000, err);
    if (status == ISO_OK)
        status = iso_cli_check_range("--step", opt->step_voxels, 1e-3, 100, err);
    if (status == ISO_OK)
        status = iso_gl_create(&gl, NULL, err);
    if (status != ISO_OK)
        return status;
    status = load(cli, opt, &p, err);
    if (status == ISO_OK) {
        status = opt->bricks ? bench_bricks(cli, gl, &p, opt, err) : run_cases(cli, gl, &p, opt, err);
        iso_pyramid_destroy(&p);
    }
    iso_gl_destroy(gl);
    return status;
}

static iso_status run(const iso_command *self, int argc, const char **argv, iso_error *err)
{
    render_options opt = {.size = 256, .image = 512, .runs = 3, .step_voxels = 1};
    iso_cli_input_defaults(&opt.input);
    struct poptOption options[] = {
        {"size", 0, POPT_ARG_INT | POPT_ARGFLAG_SHOW_DEFAULT, &opt.size, 0, "voxels a side of the synthetic volume", "N"},
        {"image", 0, POPT_ARG_INT | POPT_ARGFLAG_SHOW_DEFAULT, &opt.image, 0, "pixels a side", "N"},
        {"step", 0, POPT_ARG_DOUBLE | POPT_ARGFLAG_SHOW_DEFAULT, &opt.step_voxels, 0, "ray step", "VOXELS"},
        {"runs", 0, POPT_ARG_INT | POPT_ARGFLAG_SHOW_DEFAULT, &opt.runs, 0, "draws a case; the least time counts", "N"},
        {"bricks", 0, POPT_ARG_INT, &opt.bricks, 0, "instead: bricks of two levels against one texture", "VOXELS"},
        ISO_CLI_INPUT_OPTIONS(&opt.input),
        POPT_TABLEEND,
    };
    iso_cli cli;
    iso_cli_next next;
    iso_status status = iso_cli_parse(&cli, self, argc, argv, options, 0, 1, &next, err);
    if (status == ISO_OK && next == ISO_CLI_RUN)
        status = bench(&cli, &opt, err);
    iso_cli_end(&cli);
    return status;
}

const iso_command iso_bench_render = {
    .name = "bench render",
    .summary = "the OpenGL ray caster: dense and sparse TFs, sources of gradients, empty-space skipping",
    .usage = "[VOLUME] [options]",
    .details = "Without a volume: two thin shells of --size voxels a side. The dense TF shows every value thinly, the "
               "sparse one\nthe upper 40 % of the range. Loops: plain takes every sample, skipping leaves out bricks "
               "that the TF does not\nshow, auto chooses by the part of the bricks that it shows.\n"
               "With --bricks: one texture, bricks on their own (discontinuous) and bricks with baked faces (smooth), a "
               "quarter\nof the bricks in transition; then whole levels of cells (2x2x2 means) and of nodes ([1 2 1]) against level 0.",
    .examples = "  isoshade bench render --size 48 --image 64 --runs 1\n"
                "  isoshade bench render --size 48 --image 64 --runs 1 --bricks 8\n",
    .run = run,
};

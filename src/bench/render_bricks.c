/* SPDX-License-Identifier: MIT */
/* render_bricks.c - bench render --bricks: the cost of bricks of two levels. */
#include "bench/render.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "image/image.h"
#include "render/gl/bricks_gl.h"

typedef enum bench_texture { TEXTURE_UNIFORM, TEXTURE_OWN, TEXTURE_BAKED, TEXTURE_COUNT } bench_texture;
static const char *const texture_names[TEXTURE_COUNT] = {"uniform", "bricks-own", "bricks-baked"};

/* Sets fine levels in a box of bricks in the middle and coarse ones around it. Returns the share of bricks that are
 * fine and touch a coarse one. */
static double fill_box(const size_t count[3], const size_t box[3], uint8_t *levels)
{
    size_t inner = 1, fine = 1, all = count[0] * count[1] * count[2];
    for (size_t i = 0; i < all; ++i) {
        const size_t b[3] = {i % count[0], i / count[0] % count[1], i / (count[0] * count[1])};
        levels[i] = 0;
        for (int a = 0; a < 3; ++a) {
            size_t first = (count[a] - box[a]) / 2;
            levels[i] = levels[i] || b[a] < first || b[a] >= first + box[a];
        }
    }
    for (int a = 0; a < 3; ++a) {
        size_t first = (count[a] - box[a]) / 2, faces = (first > 0) + (first + box[a] < count[a]);
        fine *= box[a];
        inner *= box[a] > faces ? box[a] - faces : 0;
    }
    return (double)(fine - inner) / (double)all;
}

/* Sets levels so that a box of fine bricks in the middle has about a quarter of all bricks beside coarse ones. Returns
 * that share. */
static double bench_fill_quarter(const size_t count[3], uint8_t *levels)
{
    size_t best[3] = {0, 0, 0};
    double nearest = 1;
    for (size_t z = 1; z <= count[2]; ++z)
        for (size_t y = 1; y <= count[1]; ++y)
            for (size_t x = 1; x <= count[0]; ++x) {
                double part = fill_box(count, (const size_t[3]){x, y, z}, levels);
                if (fabs(part - 0.25) < nearest) {
                    nearest = fabs(part - 0.25);
                    best[0] = x, best[1] = y, best[2] = z;
                }
            }
    return fill_box(count, best, levels);
}

/* Measures one draw, after one that compiles. */
static iso_status draw_texture(iso_gl *gl, const iso_pyramid *p, const iso_brick_field *nodes,
                               const bench_render_options *opt, bench_render_case what, bench_texture texture,
                               double *seconds, iso_error *err)
{
    iso_scene scene = iso_bench_scene(opt, what.tf, what.gradients);
    iso_gl_brick_options options = iso_gl_brick_defaults();
    iso_brick_field f = *nodes;
    iso_gl_brick_stats stats;
    OWNED(iso_view) view = {0};
    OWNED(iso_image) image = {0};
    const bench_render_options once = {.image = opt->image, .step_voxels = opt->step_voxels, .runs = 1};
    if (texture == TEXTURE_UNIFORM)
        return iso_bench_measure(gl, p, &once, what, seconds, err);
    const iso_level *level = &p->levels[0];
    NEED(iso_scene_resolve(&scene, &level->geometry, level->min, level->max, &view, err));
    options.shaded = what.gradients != GRADIENTS_NONE;
    options.skip = ISO_GL_SKIP_NEVER;
    options.repeats = 2;
    options.fast_filter = true;
    f.faces = texture == TEXTURE_BAKED ? ISO_FACES_BAKED : ISO_FACES_OWN;
    NEED(iso_gl_render_bricks(gl, &f, &view, &options, &image, &stats, err));
    *seconds = stats.seconds;
    return ISO_OK;
}

/* Measures all textures in turn, run after run, so that other load affects all of them. */
static iso_status measure_textures(iso_gl *gl, const iso_pyramid *p, const iso_brick_field *nodes,
                                   const bench_render_options *opt, bench_gradients gradients,
                                   double seconds[TEXTURE_COUNT], iso_error *err)
{
    const bench_render_case what = {TF_DENSE, gradients, LOOP_PLAIN};
    iso_status status = ISO_OK;
    for (int t = 0; t < TEXTURE_COUNT; ++t)
        seconds[t] = INFINITY;
    for (int run = 0; run < opt->runs; ++run)
        for (int t = 0; t < TEXTURE_COUNT && status == ISO_OK; ++t) {
            double once = INFINITY;
            status = draw_texture(gl, p, nodes, opt, what, (bench_texture)t, &once, err);
            seconds[t] = fmin(seconds[t], once);
        }
    return status;
}

static iso_status run_brick_cases(const iso_cli *cli, iso_gl *gl, const iso_pyramid *p, const iso_brick_field *nodes,
                                  double transition, const bench_render_options *opt, json_t *root, iso_error *err)
{
    json_t *cases = json_array();
    json_object_set_new(root, "gl", json_string(iso_gl_describe(gl).renderer));
    json_object_set_new(root, "image", json_integer(opt->image));
    json_object_set_new(root, "transition_bricks", json_real(transition));
    if (!cli->json)
        printf("%s, image %d x %d, bricks of %d, %.0f %% of them in transition; milliseconds, least of %d\n%-12s %13s "
               "%13s %13s\n",
               iso_gl_describe(gl).renderer, opt->image, opt->image, opt->bricks, 100 * transition, opt->runs,
               "gradients", texture_names[0], texture_names[1], texture_names[2]);
    iso_status status = ISO_OK;
    for (int g = GRADIENTS_NONE; g <= GRADIENTS_CODES && status == ISO_OK; ++g) {
        double s[TEXTURE_COUNT];
        status = measure_textures(gl, p, nodes, opt, (bench_gradients)g, s, err);
        for (int t = 0; t < TEXTURE_COUNT && status == ISO_OK; ++t)
            json_array_append_new(cases,
                                  json_pack("{s:s, s:s, s:s, s:s, s:f, s:f}", "renderer", "gl", "texture",
                                            texture_names[t], "tf", "dense", "gradients", iso_bench_gradients_names[g],
                                            "step_voxels", opt->step_voxels, "milliseconds", 1e3 * s[t]));
        if (!cli->json && status == ISO_OK)
            printf("%-12s %13.1f %13.1f %13.1f\n"
                   "  smooth / discontinuous %.3f (baked / bricks-own); bricks / uniform %.3f\n",
                   iso_bench_gradients_names[g], 1e3 * s[TEXTURE_UNIFORM], 1e3 * s[TEXTURE_OWN], 1e3 * s[TEXTURE_BAKED],
                   s[TEXTURE_BAKED] / s[TEXTURE_OWN], s[TEXTURE_BAKED] / s[TEXTURE_UNIFORM]);
    }
    TRY(status, iso_bench_bricks_on_cpu(cli, p, nodes, opt, cases, err));
    json_object_set_new(root, "cases", cases);
    return status;
}

iso_status iso_bench_bricks(const iso_cli *cli, iso_gl *gl, const iso_pyramid *p, const bench_render_options *opt,
                            iso_error *err)
{
    OWNED(iso_node_levels) n = {0};
    iso_status status = iso_node_levels_create(&n, &p->levels[0], (size_t)opt->bricks,
                                               opt->bricks < 8 ? 2 : BENCH_LEVELS, true, cli->threads, err);
    TRY(status, iso_node_levels_round(&n, cli->threads, err));
    if (status != ISO_OK)
        return status;
    FREED uint8_t *levels = malloc(iso_brick_count(&n));
    if (!levels)
        status = iso_fail(err, ISO_E_MEMORY, "no memory for %zu bricks", iso_brick_count(&n));
    if (status == ISO_OK) {
        const iso_brick_field nodes = {.nodes = &n, .levels = levels};
        json_t *root = iso_cli_json(cli);
        status = run_brick_cases(cli, gl, p, &nodes, bench_fill_quarter(n.count, levels), opt, root, err);
        if (cli->json && status == ISO_OK)
            iso_cli_print_json(root);
        else
            json_decref(root);
    }
    return status;
}

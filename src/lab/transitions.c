/* SPDX-License-Identifier: MIT */
/* transitions.c - the cost of transitions between bricks of two levels, and nodes against cells. */
#include "bench/render.h"
#include "lab/lab.h"
#include "lab/warp_gl.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "compare/metrics.h"
#include "image/image.h"
#include "options/input.h"
#include "render/gl/bricks_gl.h"

/* own and baked: samples on the faces of bricks (brick/bricks.h); the paper's: inside them (lab/warp.h). */
typedef enum bench_texture {
    TEXTURE_UNIFORM,
    TEXTURE_OWN,
    TEXTURE_BAKED,
    TEXTURE_CENTERS_OWN,
    TEXTURE_PAPER,
    TEXTURE_PAPER_CORRECTED,
    TEXTURE_COUNT
} bench_texture;
static const char *const texture_names[TEXTURE_COUNT] = {"uniform",     "bricks-own", "bricks-baked",
                                                         "centers-own", "paper",      "paper-corrected"};
/* Names in --transition. */
static const char *const transition_names[TEXTURE_COUNT] = {NULL,    "discontinuous",  "baked", "centers-discontinuous",
                                                            "paper", "paper-corrected"};
static const iso_warp_mode warp_modes[TEXTURE_COUNT] = {
    [TEXTURE_PAPER] = ISO_WARP_WRITTEN, [TEXTURE_PAPER_CORRECTED] = ISO_WARP_CORRECTED};

typedef struct transitions_options {
    bench_render_options render;
    char *transition, *picture; /* only this transition, and its image file; or NULL */
} transitions_options;

/* One volume and layout, in bricks of both kinds. */
typedef struct bench_fields {
    const iso_pyramid *pyramid;
    iso_brick_field nodes;
    iso_warp_field centers;
} bench_fields;

/* Measures one draw, after one that compiles. */
static iso_status draw_texture(iso_gl *gl, const bench_fields *fields, const transitions_options *opt,
                               bench_gradients gradients, bench_texture texture, double *seconds, iso_error *err)
{
    iso_scene scene = iso_bench_scene(&opt->render, TF_DENSE, gradients);
    iso_gl_brick_options options = iso_gl_brick_defaults();
    iso_brick_field f = fields->nodes;
    iso_warp_field warp = fields->centers;
    iso_gl_brick_stats stats;
    iso_view view;
    iso_image image = {0};
    const bench_render_options once = {.image = opt->render.image, .step_voxels = opt->render.step_voxels, .runs = 1};
    if (texture == TEXTURE_UNIFORM)
        return iso_bench_measure(gl, fields->pyramid, &once, (bench_render_case){TF_DENSE, gradients, LOOP_PLAIN},
                                 seconds, err);
    const iso_level *level = &fields->pyramid->levels[0];
    iso_status status = iso_scene_resolve(&scene, &level->geometry, level->min, level->max, &view, err);
    if (status != ISO_OK)
        return status;
    options.shaded = gradients != GRADIENTS_NONE;
    options.skip = ISO_GL_SKIP_NEVER;
    options.repeats = 2;
    options.fast_filter = true;
    f.faces = texture == TEXTURE_BAKED ? ISO_FACES_BAKED : ISO_FACES_OWN;
    warp.mode = warp_modes[texture];
    if (texture <= TEXTURE_BAKED)
        status = iso_gl_render_bricks(gl, &f, &view, &options, &image, &stats, err);
    else
        status = iso_gl_render_warp(gl, &(iso_gl_warp){&warp, level}, &view, &options, &image, &stats, err);
    if (status == ISO_OK)
        *seconds = stats.seconds;
    if (status == ISO_OK && opt->picture && gradients != GRADIENTS_NONE)
        status = iso_image_save_png(&image, opt->picture, 1, err);
    iso_image_destroy(&image);
    iso_view_destroy(&view);
    return status;
}

/* Measures all textures in turn, run after run, so that other load affects all of them. */
static iso_status measure_textures(iso_gl *gl, const bench_fields *fields, const transitions_options *opt,
                                   bench_gradients gradients, double seconds[TEXTURE_COUNT], iso_error *err)
{
    iso_status status = ISO_OK;
    for (int t = 0; t < TEXTURE_COUNT; ++t)
        seconds[t] = INFINITY;
    for (int run = 0; run < opt->render.runs; ++run)
        for (int t = 0; t < TEXTURE_COUNT && status == ISO_OK; ++t) {
            double once = INFINITY;
            if (opt->transition && (t == TEXTURE_UNIFORM || strcmp(opt->transition, transition_names[t]) != 0))
                continue;
            status = draw_texture(gl, fields, opt, gradients, (bench_texture)t, &once, err);
            seconds[t] = fmin(seconds[t], once);
        }
    return status;
}

static void print_ratios(const double s[TEXTURE_COUNT])
{
    printf(
        "  smooth / discontinuous %.3f (baked / bricks-own); paper %.2f, corrected %.2f (to centers-own); bricks / uniform %.3f\n",
        s[TEXTURE_BAKED] / s[TEXTURE_OWN], s[TEXTURE_PAPER] / s[TEXTURE_CENTERS_OWN],
        s[TEXTURE_PAPER_CORRECTED] / s[TEXTURE_CENTERS_OWN], s[TEXTURE_BAKED] / s[TEXTURE_UNIFORM]);
}

static iso_status run_brick_cases(const iso_cli *cli, iso_gl *gl, const bench_fields *fields, double transition,
                                  const transitions_options *opt, json_t *root, iso_error *err)
{
    json_t *cases = json_array();
    json_object_set_new(root, "gl", json_string(iso_gl_describe(gl).renderer));
    json_object_set_new(root, "image", json_integer(opt->render.image));
    json_object_set_new(root, "transition_bricks", json_real(transition));
    if (!cli->json) {
        printf("%s, image %d x %d, bricks of %d, %.0f %% of them in transition; milliseconds, least of %d\n%-12s",
               iso_gl_describe(gl).renderer, opt->render.image, opt->render.image, opt->render.bricks, 100 * transition,
               opt->render.runs, "gradients");
        for (int t = 0; t < TEXTURE_COUNT; ++t)
            printf(" %13s", texture_names[t]);
        printf("\n");
    }
    iso_status status = ISO_OK;
    for (int g = GRADIENTS_NONE; g <= GRADIENTS_CODES && status == ISO_OK; ++g) {
        double seconds[TEXTURE_COUNT];
        status = measure_textures(gl, fields, opt, (bench_gradients)g, seconds, err);
        for (int t = 0; t < TEXTURE_COUNT && status == ISO_OK; ++t) {
            if (isinf(seconds[t]))
                continue; /* not requested */
            json_array_append_new(cases,
                                  json_pack("{s:s, s:s, s:s, s:s, s:f, s:f}", "renderer", "gl", "texture",
                                            texture_names[t], "tf", "dense", "gradients", iso_bench_gradients_names[g],
                                            "step_voxels", opt->render.step_voxels, "milliseconds", 1e3 * seconds[t]));
        }
        if (!cli->json && status == ISO_OK) {
            printf("%-12s", iso_bench_gradients_names[g]);
            for (int t = 0; t < TEXTURE_COUNT; ++t)
                isinf(seconds[t]) ? printf(" %13s", "-") : printf(" %13.1f", 1e3 * seconds[t]);
            printf("\n");
            if (!opt->transition)
                print_ratios(seconds);
        }
    }
    json_object_set_new(root, "cases", cases);
    return status;
}

/* ---- nodes against cells ------------------------------------------------------ */


/* Position of a node of a level among the level's cells along an axis: the four cells around and their weights, of the
 * cubic through them [catmull-1974], or linear in the two in the middle. */
typedef struct cell_stencil {
    size_t cell[4];
    float cubic[4], linear[4];
} cell_stencil;

static cell_stencil among_cells(size_t node, size_t level, size_t size)
{
    const double x = (double)node + ldexp(0.5, -(int)level) - 0.5, low = floor(x);
    const float t = (float)(x - low);
    cell_stencil s = {.cubic = {0.5f * t * (-1 + t * (2 - t)), 1 + 0.5f * t * t * (3 * t - 5),
                                0.5f * t * (1 + t * (4 - 3 * t)), 0.5f * t * t * (t - 1)},
                      .linear = {0, 1 - t, t, 0}};
    for (int i = 0; i < 4; ++i)
        s.cell[i] = (size_t)fmin(fmax(low + i - 1, 0), (double)(size - 1));
    return s;
}

/* Interpolates a node: the scalar cubically, clamped to the range of the eight cells around; the direction linearly. */
static void node_from_cells(const iso_level *level, const float *directions, const cell_stencil s[3],
                            float node[ISO_NODE_CHANNELS])
{
    const size_t *size = level->geometry.size;
    float lowest = INFINITY, highest = -INFINITY;
    memset(node, 0, ISO_NODE_CHANNELS * sizeof *node);
    for (size_t z = 0; z < 4; ++z)
        for (size_t y = 0; y < 4; ++y)
            for (size_t x = 0; x < 4; ++x) {
                const size_t v = s[0].cell[x] + size[0] * (s[1].cell[y] + size[1] * s[2].cell[z]);
                const float weight = s[0].linear[x] * s[1].linear[y] * s[2].linear[z];
                node[0] += s[0].cubic[x] * s[1].cubic[y] * s[2].cubic[z] * level->scalar[v];
                if (weight == 0)
                    continue;
                lowest = fminf(lowest, level->scalar[v]);
                highest = fmaxf(highest, level->scalar[v]);
                for (size_t a = 0; a < 3; ++a)
                    node[1 + a] += weight * directions[3 * v + a];
            }
    node[0] = fminf(fmaxf(node[0], lowest), highest);
}

/* Creates nodes from the levels of a pyramid instead of its level 0: blurrier, because the voxels are already means. */
static iso_status create_from_cells(iso_node_levels *n, const iso_pyramid *p, size_t brick_voxels, size_t level_count,
                                    int threads, iso_error *err)
{
    if (level_count > p->level_count)
        return iso_fail(err, ISO_E_RANGE, "bricks: %zu levels requested, the pyramid has %zu", level_count,
                        p->level_count);
    /* Its nodes are replaced. */
    iso_status status = iso_node_levels_create(n, &p->levels[0], brick_voxels, level_count, true, threads, err);
    for (size_t l = 0; l < level_count && status == ISO_OK; ++l) {
        const iso_level *level = &p->levels[l];
        const size_t *size = level->geometry.size, voxels = iso_geometry_voxel_count(&level->geometry);
        const size_t nx = iso_node_count(n, l, 0), ny = iso_node_count(n, l, 1), nz = iso_node_count(n, l, 2);
        float *directions = malloc(3 * voxels * sizeof *directions);
        if (!directions) {
            status = iso_fail(err, ISO_E_MEMORY, "bricks: no memory for %zu directions", voxels);
            break;
        }
        iso_code_decode_all(p->options.code, level->codes, directions, voxels);
#pragma omp parallel for schedule(static) num_threads(iso_threads(threads))
        for (size_t z = 0; z < nz; ++z)
            for (size_t y = 0; y < ny; ++y)
                for (size_t x = 0; x < nx; ++x) {
                    const cell_stencil s[3] = {among_cells(x, l, size[0]), among_cells(y, l, size[1]),
                                               among_cells(z, l, size[2])};
                    node_from_cells(level, directions, s, n->nodes[l] + ISO_NODE_CHANNELS * (x + nx * (y + ny * z)));
                }
        free(directions);
    }
    if (status != ISO_OK)
        iso_node_levels_destroy(n);
    return status;
}

/* How a whole level is made. LEVEL_FROM_CELLS: from a pyramid's cells, the only values that are stored. */
typedef enum level_kind { LEVEL_CELLS, LEVEL_SMOOTH, LEVEL_SHARP, LEVEL_FROM_CELLS, LEVEL_KINDS } level_kind;
static const char *const level_kind_names[LEVEL_KINDS] = {"cells", "nodes-smooth", "nodes-sharp", "nodes-from-cells"};

/* The pyramid and views to compare, and one level per brick. */
typedef struct level_comparison {
    const iso_cli *cli;
    iso_gl *gl;
    const iso_pyramid *pyramid;
    const bench_render_options *opt;
    uint8_t *levels;
} level_comparison;

/* Draws a whole level, at the same step in mm. */
static iso_status draw_level(const level_comparison *c, const iso_node_levels *n, const iso_view *view, size_t k,
                             iso_image *image, iso_error *err)
{
    iso_gl *gl = c->gl;
    const iso_pyramid *p = c->pyramid;
    const double step_voxels = c->opt->step_voxels;
    uint8_t *levels = c->levels;
    if (!n) {
        iso_gl_options options = iso_gl_defaults();
        options.step_voxels = ldexp(step_voxels, -(int)k);
        return iso_gl_render(gl, &p->levels[k], p->options.code, view, &options, image, err);
    }
    const iso_brick_field f = {.nodes = n, .levels = levels, .faces = ISO_FACES_BAKED};
    iso_gl_brick_options options = iso_gl_brick_defaults();
    options.step_voxels = step_voxels;
    memset(levels, (int)k, iso_brick_count(n));
    return iso_gl_render_bricks(gl, &f, view, &options, image, NULL, err);
}

static void report_level(const iso_cli *cli, bench_tf tf, size_t k, const iso_metrics m[LEVEL_KINDS], json_t *cases)
{
    for (int i = 0; i < LEVEL_KINDS; ++i)
        json_array_append_new(cases, json_pack("{s:s, s:I, s:s, s:f, s:f}", "tf", iso_bench_tf_names[tf], "level",
                                               (json_int_t)k, "made", level_kind_names[i], "rmse", m[i].rmse, "ssim",
                                               m[i].ssim));
    if (cli->json)
        return;
    printf("%-8s %5zu", iso_bench_tf_names[tf], k);
    for (int i = 0; i < LEVEL_KINDS; ++i)
        printf("   %.5f %.4f ", m[i].rmse, m[i].ssim);
    printf("\n");
}

/* Computes RMSE and SSIM of all kinds to level 0, for one TF; nodes[LEVEL_CELLS] is NULL. */
static iso_status compare_levels(const level_comparison *c, const iso_node_levels *const nodes[LEVEL_KINDS],
                                 bench_tf tf, json_t *cases, iso_error *err)
{
    const iso_pyramid *p = c->pyramid;
    iso_scene scene = iso_bench_scene(c->opt, tf, GRADIENTS_CODES);
    const iso_level *level = &p->levels[0];
    iso_view view;
    iso_image exact = {0};
    iso_status status = iso_scene_resolve(&scene, &level->geometry, level->min, level->max, &view, err);
    if (status != ISO_OK)
        return status;
    status = draw_level(c, NULL, &view, 0, &exact, err);
    for (size_t k = 1; k < p->level_count && k < nodes[LEVEL_SHARP]->level_count && status == ISO_OK; ++k) {
        iso_metrics m[LEVEL_KINDS];
        for (int i = 0; i < LEVEL_KINDS && status == ISO_OK; ++i) {
            iso_image image = {0};
            status = draw_level(c, nodes[i], &view, k, &image, err);
            TRY(status, iso_metrics_measure(&image, &exact, &m[i], err));
            iso_image_destroy(&image);
        }
        if (status == ISO_OK)
            report_level(c->cli, tf, k, m, cases);
    }
    iso_image_destroy(&exact);
    iso_view_destroy(&view);
    return status;
}

static iso_status compare_nodes_with_cells(const level_comparison *c, const iso_node_levels *sharp, json_t *root,
                                           iso_error *err)
{
    const iso_cli *cli = c->cli;
    const iso_pyramid *p = c->pyramid;
    json_t *cases = json_array();
    iso_node_levels smooth = {0}, from_cells = {0};
    const iso_node_levels *const nodes[LEVEL_KINDS] = {NULL, &smooth, sharp, &from_cells};
    iso_status status = iso_node_levels_create_by(&smooth, &p->levels[0],
                                                  &(iso_node_options){sharp->brick_voxels, sharp->level_count,
                                                                      ISO_NODES_SMOOTH, true, cli->threads},
                                                  err);
    TRY(status, create_from_cells(&from_cells, p, sharp->brick_voxels, sharp->level_count, cli->threads, err));
    if (!cli->json) {
        printf("\nwhole levels against level 0, shaded: RMSE and SSIM\n%-8s %5s", "tf", "level");
        for (int i = 0; i < LEVEL_KINDS; ++i)
            printf(" %16s", level_kind_names[i]);
        printf("\n");
    }
    for (int tf = 0; tf < TF_COUNT && status == ISO_OK; ++tf)
        status = compare_levels(c, nodes, (bench_tf)tf, cases, err);
    json_object_set_new(root, "accuracy", cases);
    iso_node_levels_destroy(&smooth);
    iso_node_levels_destroy(&from_cells);
    return status;
}

static iso_status check_transition(const char *name, iso_error *err)
{
    bool known = !name;
    for (int t = 1; t < TEXTURE_COUNT; ++t)
        known = known || strcmp(name, transition_names[t]) == 0;
    return known ? ISO_OK
                 : iso_fail(err, ISO_E_USAGE,
                            "--transition is \"%s\", must be discontinuous, baked, centers-discontinuous, "
                            "paper or paper-corrected",
                            name);
}

static iso_status measure_bricks(const iso_cli *cli, iso_gl *gl, const iso_pyramid *p, const transitions_options *opt,
                                 iso_error *err)
{
    const size_t side = (size_t)opt->render.bricks;
    iso_node_levels n;
    bench_fields fields = {.pyramid = p};
    iso_status status = check_transition(opt->transition, err);
    if (status != ISO_OK)
        return status;
    status = iso_node_levels_create(&n, &p->levels[0], side, opt->render.bricks < 8 ? 2 : BENCH_LEVELS, true,
                                    cli->threads, err);
    TRY(status, iso_node_levels_round(&n, cli->threads, err));
    if (status != ISO_OK) {
        iso_node_levels_destroy(&n);
        return status;
    }
    status = iso_warp_field_of_level(&fields.centers, &p->levels[0], p->options.code, side, err);
    size_t count[3] = {iso_warp_bricks(&fields.centers, 0), iso_warp_bricks(&fields.centers, 1),
                       iso_warp_bricks(&fields.centers, 2)};
    uint8_t *levels = malloc((iso_brick_count(&n) + count[0] * count[1] * count[2]));
    if (status == ISO_OK && !levels)
        status = iso_fail(err, ISO_E_MEMORY, "no memory for %zu bricks", iso_brick_count(&n));
    if (status == ISO_OK) {
        uint8_t *of_centers = levels + iso_brick_count(&n);
        const double transition = iso_bench_fill_quarter(n.count, levels);
        iso_bench_fill_quarter(count, of_centers);
        fields.nodes = (iso_brick_field){.nodes = &n, .levels = levels};
        fields.centers.levels = of_centers;
        json_t *root = iso_cli_json(cli);
        status = run_brick_cases(cli, gl, &fields, transition, opt, root, err);
        if (status == ISO_OK && !opt->transition)
            status = compare_nodes_with_cells(&(level_comparison){cli, gl, p, &opt->render, levels}, &n, root, err);
        if (cli->json && status == ISO_OK)
            iso_cli_print_json(root);
        else
            json_decref(root);
    }
    free(levels);
    iso_warp_field_destroy(&fields.centers);
    iso_node_levels_destroy(&n);
    return status;
}

static iso_status bench(const iso_cli *cli, const transitions_options *opt, iso_error *err)
{
    const bench_render_options *r = &opt->render;
    iso_pyramid p;
    iso_gl *gl;
    iso_status status = ISO_OK;
    if (opt->picture && !opt->transition)
        status = iso_fail(err, ISO_E_USAGE, "-o needs --transition");
    TRY(status, iso_gl_create(&gl, NULL, err));
    if (status != ISO_OK)
        return status;
    status = iso_bench_load(cli, r, &p, err);
    if (status == ISO_OK) {
        status = measure_bricks(cli, gl, &p, opt, err);
        iso_pyramid_destroy(&p);
    }
    iso_gl_destroy(gl);
    return status;
}

static const iso_option options[] = {
    {"size", 0, "voxels per side of the synthetic volume", "N", ISO_IN(transitions_options, render.size),
     .flags = ISO_SHOWN, .least = 8, .most = 1024},
    {"image", 0, "pixels per side", "N", ISO_IN(transitions_options, render.image), .flags = ISO_SHOWN, .least = 1,
     .most = 8192},
    {"step", 0, "set the ray step", "VOXELS", ISO_IN(transitions_options, render.step_voxels), .flags = ISO_SHOWN,
     .least = 1e-3, .most = 100},
    {"runs", 0, "draw each case N times; the least time counts", "N", ISO_IN(transitions_options, render.runs),
     .flags = ISO_SHOWN, .least = 1, .most = 1000},
    {"bricks", 0, "voxels per side of a brick", "VOXELS", ISO_IN(transitions_options, render.bricks),
     .flags = ISO_SHOWN},
    {"transition", 0, "only discontinuous, baked, centers-discontinuous, paper or paper-corrected", "NAME",
     ISO_IN(transitions_options, transition)},
    {"output", 'o', "with --transition: write the shaded image", "FILE.png", ISO_IN(transitions_options, picture)},
    ISO_OPTIONS_OF(transitions_options, render.input, iso_input_rows),
    ISO_OPTIONS_END,
};

static iso_status run(const iso_cli *cli, void *values, iso_error *err)
{
    return bench(cli, values, err);
}

const iso_command iso_lab_transitions = {
    .name = "transitions",
    .summary = "transitions between bricks of two levels: time of each, and nodes against cells",
    .max_arguments = 1,
    .usage = "[VOLUME] [options]",
    .details =
        "One texture; separate bricks (discontinuous); bricks with baked faces (smooth). With samples inside bricks:\n"
        "separate ones, and the transitions of [beyer-2008] as written and as corrected. A quarter of the bricks are\n"
        "in transition. Then whole levels against level 0: of cells (2x2x2 means), of nodes filtered by [1 2 1]\n"
        "(smooth) and by [-1 2 6 2 -1] (sharp, as bricks use), and of nodes interpolated between the cells.",
    .examples = "  isoshade-lab transitions --size 48 --image 64 --runs 1 --bricks 8\n"
                "  isoshade-lab transitions --size 48 --image 64 --runs 1 --bricks 8 --transition paper -o paper.png\n",
    ISO_COMMAND_OPTIONS(transitions_options, options,
                        .render = {.size = 256, .image = 512, .runs = 3, .step_voxels = 1, .bricks = 32}),
    .run = run,
};

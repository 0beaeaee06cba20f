/* SPDX-License-Identifier: MIT */
/* render_bricks_cpu.c - bench render --bricks: bricks of two levels by the CPU ray caster, and the whole volume. */
#include <math.h>
#include <stdio.h>

#include "base/parallel.h"
#include "bench/render.h"
#include "render/cpu/mixed.h"
#include "scene/scene.h"

enum { WHOLE, OWN, BAKED, KINDS };
static const char *const kind_names[KINDS] = {"uniform", "bricks-own", "bricks-baked"};

typedef struct cpu_cases {
    iso_view view;
    iso_cpu_scene *scene[KINDS];
    double seconds[KINDS];
} cpu_cases;

static iso_status prepare(cpu_cases *c, const iso_pyramid *p, iso_brick_field field, bool is_lit, int threads,
                          iso_error *err)
{
    iso_cpu_options whole = iso_cpu_defaults();
    iso_cpu_brick_options bricks = iso_cpu_brick_defaults();
    whole.skip = bricks.skip = ISO_CPU_SKIP_NEVER;
    whole.threads = bricks.threads = threads;
    bricks.shaded = is_lit;
    iso_status status = iso_cpu_prepare(&c->scene[WHOLE], &p->levels[0], p->options.code, &c->view, &whole, err);
    for (int kind = OWN; kind <= BAKED && status == ISO_OK; ++kind) {
        field.faces = kind == OWN ? ISO_FACES_OWN : ISO_FACES_BAKED;
        status = iso_cpu_prepare_bricks(&c->scene[kind], &field, &c->view, &bricks, err);
    }
    return status;
}

/* Draws all cases in turn, run after run, so that other load affects all of them. */
static iso_status draw(cpu_cases *c, const bench_render_options *opt, iso_error *err)
{
    double (*clock)(void) = opt->processor_time ? iso_cpu_seconds : iso_clock_seconds;
    iso_image image;
    iso_status status = iso_image_create(&image, c->view.width, c->view.height, err);
    for (int kind = 0; kind < KINDS; ++kind)
        c->seconds[kind] = INFINITY;
    for (int run = 0; run <= 2 * opt->runs && status == ISO_OK; ++run)
        for (int kind = 0; kind < KINDS; ++kind) {
            const double start = clock();
            iso_cpu_draw(c->scene[kind], &image);
            if (run > 0) /* the first run warms the cache */
                c->seconds[kind] = fmin(c->seconds[kind], clock() - start);
        }
    if (status == ISO_OK)
        iso_image_destroy(&image);
    return status;
}

static void report(const iso_cli *cli, const cpu_cases *c, bench_gradients gradients, double step_voxels, json_t *cases)
{
    for (int kind = 0; kind < KINDS; ++kind)
        json_array_append_new(cases,
                              json_pack("{s:s, s:s, s:s, s:s, s:f, s:f}", "renderer", "cpu", "texture", kind_names[kind],
                                        "tf", "dense", "gradients", iso_bench_gradients_names[gradients], "step_voxels",
                                        step_voxels, "milliseconds", 1e3 * c->seconds[kind]));
    if (cli->json)
        return;
    printf("cpu %-8s", iso_bench_gradients_names[gradients]);
    for (int kind = 0; kind < KINDS; ++kind)
        printf(" %13.1f", 1e3 * c->seconds[kind]);
    printf("\n  smooth / discontinuous %.3f (baked / bricks-own); bricks / uniform %.3f\n",
           c->seconds[BAKED] / c->seconds[OWN], c->seconds[BAKED] / c->seconds[WHOLE]);
}

iso_status iso_bench_bricks_on_cpu(const iso_cli *cli, const iso_pyramid *p, const iso_brick_field *field,
                                   const bench_render_options *opt, json_t *cases, iso_error *err)
{
    const iso_level *level = &p->levels[0];
    iso_status status = ISO_OK;
    for (int g = GRADIENTS_NONE; g <= GRADIENTS_CODES && status == ISO_OK; ++g) {
        cpu_cases c = {0};
        const iso_scene scene = iso_bench_scene(opt, TF_DENSE, (bench_gradients)g);
        NEED(iso_scene_resolve(&scene, &level->geometry, level->min, level->max, &c.view, err));
        status = prepare(&c, p, *field, g != GRADIENTS_NONE, cli->threads, err);
        TRY(status, draw(&c, opt, err));
        if (status == ISO_OK)
            report(cli, &c, (bench_gradients)g, opt->step_voxels, cases);
        for (int kind = 0; kind < KINDS; ++kind)
            iso_cpu_release(c.scene[kind]);
        iso_view_destroy(&c.view);
    }
    return status;
}

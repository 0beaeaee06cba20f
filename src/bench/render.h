/* SPDX-License-Identifier: MIT */
/* render.h - shared by the parts of `bench render`: its cases and the measurement of one. */
#pragma once

#include "bench/bench.h"
#include "brick/bricks.h"
#include "options/input.h"
#include "pyramid/pyramid.h"
#include "render/gl/raycaster.h"

enum { BENCH_LEVELS = 4 }; /* for --bricks */

typedef struct bench_render_options {
    iso_volume_input input;
    int size, image, runs, bricks, processor_time;
    double step_voxels;
    char *tf; /* only this one, or NULL */
} bench_render_options;

typedef enum bench_tf { TF_DENSE, TF_SPARSE, TF_COUNT } bench_tf;
extern const char *const iso_bench_tf_names[TF_COUNT];

typedef enum bench_gradients { GRADIENTS_NONE, GRADIENTS_CODES, GRADIENTS_ON_THE_FLY, GRADIENTS_COUNT } bench_gradients;
extern const char *const iso_bench_gradients_names[GRADIENTS_COUNT];

typedef enum bench_loop { LOOP_PLAIN, LOOP_SKIPPING, LOOP_AUTO, LOOP_COUNT } bench_loop;
extern const char *const iso_bench_loop_names[LOOP_COUNT];

/* Loads the given volume, or creates two thin shells. */
iso_status iso_bench_load(const iso_cli *cli, const bench_render_options *opt, iso_pyramid *p, iso_error *err);

iso_scene iso_bench_scene(const bench_render_options *opt, bench_tf tf, bench_gradients gradients);

/* Fastest time of opt->runs draws of level 0 as one texture. */
typedef struct bench_render_case {
    bench_tf tf;
    bench_gradients gradients;
    bench_loop loop;
} bench_render_case;
iso_status iso_bench_measure(iso_gl *gl, const iso_pyramid *p, const bench_render_options *opt, bench_render_case what,
                             double *seconds, iso_error *err);

/* Measures bricks (--bricks). */
iso_status iso_bench_bricks(const iso_cli *cli, iso_gl *gl, const iso_pyramid *p, const bench_render_options *opt,
                            iso_error *err);

/* Measures bricks and the whole volume by the CPU ray caster; appends to cases. */
iso_status iso_bench_bricks_on_cpu(const iso_cli *cli, const iso_pyramid *p, const iso_brick_field *field,
                                   const bench_render_options *opt, json_t *cases, iso_error *err);

/* SPDX-License-Identifier: MIT */
/* cast.c - compares the CPU ray caster with the OpenGL one in one run: time, and distance from the reference. */
#define _GNU_SOURCE /* setenv */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/order.h"
#include "base/parallel.h"
#include "bench/cast_bound.h"
#include "bench/render.h"
#include "compare/metrics.h"
#include "render/cpu/caster.h"
#include "render/reference.h"

enum { MOST_ROUNDS = 32, DRAWS = 3, WHO_GL = 0, WHO_CPU, WHO_COUNT };

typedef struct cast_options {
    bench_render_options render;
    int rounds, truth;
    char *width;
    iso_cpu_width wide;
} cast_options;

/* Least processor time and least wall-clock time of a round's draws. */
typedef struct cast_time {
    double processor, wall;
} cast_time;

typedef struct cast_case {
    bench_tf tf;
    bench_gradients gradients;
    bench_loop loop;
    iso_view view;
    cast_time round[WHO_COUNT][MOST_ROUNDS];
    double rmse[WHO_COUNT];
} cast_case;

static const iso_gl_skip gl_skips[LOOP_COUNT] = {ISO_GL_SKIP_NEVER, ISO_GL_SKIP_ALWAYS, ISO_GL_SKIP_AUTO};
static const iso_cpu_skip cpu_skips[LOOP_COUNT] = {ISO_CPU_SKIP_NEVER, ISO_CPU_SKIP_ALWAYS, ISO_CPU_SKIP_AUTO};

static iso_direction_source source_of(const cast_case *c)
{
    return c->gradients == GRADIENTS_ON_THE_FLY ? ISO_FROM_ON_THE_FLY : ISO_FROM_CODES;
}

static iso_status draw_gl(iso_gl *gl, const iso_pyramid *p, const cast_case *c, const iso_view *view, iso_image *image,
                          cast_time *time, iso_error *err)
{
    iso_gl_stats stats = {0};
    iso_gl_options o = iso_gl_defaults();
    o.source = source_of(c);
    o.skip = gl_skips[c->loop];
    o.repeats = DRAWS + 1; /* the first compiles */
    o.stats = &stats;
    o.fast_filter = true;
    const iso_status status = iso_gl_render(gl, &p->levels[0], p->options.code, view, &o, image, err);
    *time = (cast_time){INFINITY, INFINITY};
    for (size_t i = 1; i < stats.draw_count; ++i) {
        time->processor = fmin(time->processor, stats.draw_processor_seconds[i]);
        time->wall = fmin(time->wall, stats.draw_seconds[i]);
    }
    return status;
}

static iso_status draw_cpu(const cast_options *opt, int threads, const iso_pyramid *p, const cast_case *c,
                           const iso_view *view, iso_image *image, cast_time *time, iso_error *err)
{
    iso_cpu_options o = iso_cpu_defaults();
    iso_cpu_scene *scene;
    o.source = source_of(c);
    o.skip = cpu_skips[c->loop];
    o.threads = threads;
    o.width = opt->wide;
    *image = (iso_image){0};
    iso_status status = iso_cpu_prepare(&scene, &p->levels[0], p->options.code, view, &o, err);
    TRY(status, iso_image_create(image, view->width, view->height, err));
    *time = (cast_time){INFINITY, INFINITY};
    for (int i = 0; i <= DRAWS && status == ISO_OK; ++i) {
        const double processor = iso_cpu_seconds(), wall = iso_clock_seconds();
        iso_cpu_draw(scene, image);
        if (i == 0)
            continue;
        time->processor = fmin(time->processor, iso_cpu_seconds() - processor);
        time->wall = fmin(time->wall, iso_clock_seconds() - wall);
    }
    iso_cpu_release(scene);
    return status;
}

/* Draws with both; the first one alternates between rounds. */
static iso_status run_round(const iso_cli *cli, iso_gl *gl, const iso_pyramid *p, const cast_options *opt, cast_case *c,
                            int round, iso_error *err)
{
    for (int turn = 0; turn < WHO_COUNT; ++turn) {
        iso_image image;
        const int who = (turn + round) % WHO_COUNT;
        NEED(who == WHO_GL ? draw_gl(gl, p, c, &c->view, &image, &c->round[who][round], err)
                           : draw_cpu(opt, cli->threads, p, c, &c->view, &image, &c->round[who][round], err));
        iso_image_destroy(&image);
    }
    return ISO_OK;
}

/* Measures the RMSE of both to the reference with the same samples, in a smaller picture. */
static iso_status measure_errors(const iso_cli *cli, iso_gl *gl, const iso_pyramid *p, const cast_options *opt,
                                 cast_case *c, iso_error *err)
{
    iso_view view = c->view;
    view.width = view.height = (size_t)opt->truth;
    iso_reference_options o = iso_reference_defaults();
    o.quadrature = ISO_QUADRATURE_MIDPOINT;
    o.source = source_of(c);
    o.threads = cli->threads;
    OWNED(iso_image) truth = {0};
    NEED(iso_reference_render(&p->levels[0], p->options.code, &view, &o, &truth, NULL, err));
    for (int who = 0; who < WHO_COUNT; ++who) {
        iso_image image;
        iso_metrics m;
        cast_time time;
        NEED(who == WHO_GL ? draw_gl(gl, p, c, &view, &image, &time, err)
                           : draw_cpu(opt, cli->threads, p, c, &view, &image, &time, err));
        NEED(iso_metrics_measure(&truth, &image, &m, err));
        c->rmse[who] = m.rmse;
        iso_image_destroy(&image);
    }
    return ISO_OK;
}

/* Returns the median over the rounds of OpenGL's time divided by the CPU ray caster's. */
static double median_ratio(const cast_case *c, int rounds, bool processor)
{
    double ratio[MOST_ROUNDS];
    for (int i = 0; i < rounds; ++i) {
        const cast_time *gl = &c->round[WHO_GL][i], *cpu = &c->round[WHO_CPU][i];
        ratio[i] = processor ? gl->processor / cpu->processor : gl->wall / cpu->wall;
    }
    qsort(ratio, (size_t)rounds, sizeof *ratio, iso_order_doubles);
    return 0.5 * (ratio[(rounds - 1) / 2] + ratio[rounds / 2]);
}

static cast_time best_of(const cast_case *c, int who, int rounds)
{
    cast_time best = c->round[who][0];
    for (int i = 1; i < rounds; ++i) {
        best.processor = fmin(best.processor, c->round[who][i].processor);
        best.wall = fmin(best.wall, c->round[who][i].wall);
    }
    return best;
}

static void report(const iso_cli *cli, const cast_options *opt, const cast_case *c, json_t *rows)
{
    const cast_time gl = best_of(c, WHO_GL, opt->rounds), cpu = best_of(c, WHO_CPU, opt->rounds);
    const double processor = median_ratio(c, opt->rounds, true), wall = median_ratio(c, opt->rounds, false);
    if (!cli->json)
        printf("%-8s %-12s %-10s %9.1f %9.1f %9.1f %9.1f %8.2f %8.2f  %8.1e %8.1e\n", iso_bench_tf_names[c->tf],
               iso_bench_gradients_names[c->gradients], iso_bench_loop_names[c->loop], 1e3 * gl.processor,
               1e3 * cpu.processor, 1e3 * gl.wall, 1e3 * cpu.wall, processor, wall, c->rmse[WHO_GL], c->rmse[WHO_CPU]);
    json_array_append_new(rows,
                          json_pack("{s:s, s:s, s:s, s:{s:f, s:f, s:f}, s:{s:f, s:f, s:f}, s:f, s:f}", "tf",
                                    iso_bench_tf_names[c->tf], "gradients", iso_bench_gradients_names[c->gradients],
                                    "loop", iso_bench_loop_names[c->loop], "gl", "processor_ms", 1e3 * gl.processor,
                                    "wall_ms", 1e3 * gl.wall, "rmse", c->rmse[WHO_GL], "cpu", "processor_ms",
                                    1e3 * cpu.processor, "wall_ms", 1e3 * cpu.wall, "rmse", c->rmse[WHO_CPU],
                                    "processor_ratio", processor, "wall_ratio", wall));
}

static iso_status resolve(const iso_pyramid *p, const cast_options *opt, bench_tf tf, bench_gradients gradients,
                          iso_view *view, iso_error *err)
{
    const iso_level *level = &p->levels[0];
    const iso_scene scene = iso_bench_scene(&opt->render, tf, gradients);
    return iso_scene_resolve(&scene, &level->geometry, level->min, level->max, view, err);
}

static iso_status run_case(const iso_cli *cli, iso_gl *gl, const iso_pyramid *p, const cast_options *opt, cast_case *c,
                           iso_error *err)
{
    iso_status status = resolve(p, opt, c->tf, c->gradients, &c->view, err);
    if (status != ISO_OK)
        return status;
    for (int i = 0; i < opt->rounds && status == ISO_OK; ++i)
        status = run_round(cli, gl, p, opt, c, i, err);
    TRY(status, measure_errors(cli, gl, p, opt, c, err));
    iso_view_destroy(&c->view);
    return status;
}

/* Least processor times of all cases, in seconds. */
typedef double cast_times[TF_COUNT][GRADIENTS_COUNT][LOOP_COUNT][WHO_COUNT];

static iso_status count_samples(const iso_cli *cli, const iso_pyramid *p, const cast_options *opt,
                                bench_samples samples[TF_COUNT], iso_error *err)
{
    iso_status status = ISO_OK;
    for (int tf = 0; tf < TF_COUNT && status == ISO_OK; ++tf) {
        iso_view view;
        status = resolve(p, opt, (bench_tf)tf, GRADIENTS_NONE, &view, err);
        if (status == ISO_OK) {
            status = iso_bench_count_samples(&p->levels[0], p->options.code, &view, cli->threads, &samples[tf], err);
            iso_view_destroy(&view);
        }
    }
    return status;
}

/* Reports how much faster empty-space skipping makes the sparse pictures, and the upper bound of that factor. */
static json_t *report_skipping(const iso_cli *cli, const bench_samples samples[TF_COUNT], cast_times times)
{
    static const char *const names[WHO_COUNT] = {"gl", "cpu"};
    json_t *rows = json_array();
    const double share = (double)samples[TF_SPARSE].shown / (double)samples[TF_SPARSE].looked_up;
    if (!cli->json)
        printf("\nsparse: %zu of %zu samples are visible (%.2f %%), dense: %zu of %zu; `bound`: factor for the\n"
               "sparse picture if skipping the other samples cost nothing\n%-12s %-4s %8s %8s\n",
               samples[TF_SPARSE].shown, samples[TF_SPARSE].looked_up, 100 * share, samples[TF_DENSE].shown,
               samples[TF_DENSE].looked_up, "gradients", "by", "factor", "bound");
    for (int g = 0; g < GRADIENTS_COUNT; ++g)
        for (int who = 0; who < WHO_COUNT; ++who) {
            const double plain = times[TF_SPARSE][g][LOOP_PLAIN][who];
            const double factor = plain / times[TF_SPARSE][g][LOOP_SKIPPING][who];
            const double bound = iso_bench_skipping_bound(&samples[TF_DENSE], times[TF_DENSE][g][LOOP_PLAIN][who],
                                                          &samples[TF_SPARSE], plain);
            if (!cli->json)
                printf("%-12s %-4s %8.1f %8.1f\n", iso_bench_gradients_names[g], names[who], factor, bound);
            json_array_append_new(rows, json_pack("{s:s, s:s, s:f, s:o}", "gradients", iso_bench_gradients_names[g],
                                                  "by", names[who], "factor", factor, "bound",
                                                  isfinite(bound) ? json_real(bound) : json_null()));
        }
    return json_pack("{s:I, s:I, s:o}", "samples", (json_int_t)samples[TF_SPARSE].looked_up, "shown",
                     (json_int_t)samples[TF_SPARSE].shown, "cases", rows);
}

static iso_status run_cases(const iso_cli *cli, iso_gl *gl, const iso_pyramid *p, const cast_options *opt,
                            iso_error *err)
{
    const size_t *size = p->levels[0].geometry.size;
    const char *width = iso_cpu_width_name(opt->wide ? opt->wide : iso_cpu_widest());
    json_t *root = iso_cli_json(cli), *rows = json_array();
    if (!cli->json)
        printf(
            "%s against %s; %zux%zux%zu, image %d x %d, step %g voxels, threads %d; milliseconds, least of %d x %d;\n"
            "ratios: medians of %d rounds; error: rmse from the reference's same samples, %d x %d\n"
            "%-8s %-12s %-10s %9s %9s %9s %9s %8s %8s  %8s %8s\n%-8s %-12s %-10s %9s %9s %9s %9s %8s %8s  %8s %8s\n",
            iso_gl_describe(gl).renderer, width, size[0], size[1], size[2], opt->render.image, opt->render.image,
            opt->render.step_voxels, iso_threads(cli->threads), opt->rounds, DRAWS, opt->rounds, opt->truth, opt->truth,
            "", "", "", "processor", "", "wall", "", "ratio", "", "error", "", "tf", "gradients", "loop", "gl", "cpu",
            "gl", "cpu", "proc.", "wall", "gl", "cpu");
    cast_times times;
    bench_samples samples[TF_COUNT] = {{0}};
    iso_status status = ISO_OK;
    for (int tf = 0; tf < TF_COUNT; ++tf)
        for (int g = 0; g < GRADIENTS_COUNT; ++g)
            for (int loop = 0; loop < LOOP_COUNT && status == ISO_OK; ++loop) {
                cast_case c = {.tf = (bench_tf)tf, .gradients = (bench_gradients)g, .loop = (bench_loop)loop};
                status = run_case(cli, gl, p, opt, &c, err);
                if (status == ISO_OK)
                    report(cli, opt, &c, rows);
                for (int who = 0; who < WHO_COUNT; ++who)
                    times[tf][g][loop][who] = best_of(&c, who, opt->rounds).processor;
                fflush(stdout);
            }
    TRY(status, count_samples(cli, p, opt, samples, err));
    if (status == ISO_OK)
        json_object_set_new(root, "skipping", report_skipping(cli, samples, times));
    json_object_set_new(root, "gl", json_string(iso_gl_describe(gl).renderer));
    json_object_set_new(root, "cpu", json_string(width));
    json_object_set_new(root, "image", json_integer(opt->render.image));
    json_object_set_new(root, "cases", rows);
    if (cli->json && status == ISO_OK)
        iso_cli_print_json(root);
    else
        json_decref(root);
    return status;
}

static iso_status choose_width(cast_options *opt, iso_error *err)
{
    static const struct width_name {
        const char *name;
        iso_cpu_width width;
    } names[] = {{"avx512", ISO_CPU_AVX512},
                 {"avx2", ISO_CPU_AVX2},
                 {"baseline", ISO_CPU_BASELINE},
                 {"one", ISO_CPU_ONE}};
    if (!opt->width)
        return ISO_OK;
    for (size_t i = 0; i < sizeof names / sizeof *names; ++i)
        if (strcmp(opt->width, names[i].name) == 0) {
            opt->wide = names[i].width;
            return ISO_OK;
        }
    return iso_fail(err, ISO_E_USAGE, "--width is \"%s\", must be avx512, avx2, baseline or one", opt->width);
}

static iso_status bench(const iso_cli *cli, cast_options *opt, iso_error *err)
{
    char threads[16];
    iso_pyramid p;
    iso_gl *gl;
    NEED(choose_width(opt, err));
    snprintf(threads, sizeof threads, "%d", iso_threads(cli->threads));
    setenv("LP_NUM_THREADS", threads, 0); /* read by llvmpipe */
    NEED(iso_gl_create(&gl, NULL, err));
    iso_status status = iso_bench_load(cli, &opt->render, &p, err);
    if (status == ISO_OK) {
        status = run_cases(cli, gl, &p, opt, err);
        iso_pyramid_destroy(&p);
    }
    iso_gl_destroy(gl);
    return status;
}

static const iso_option options[] = {
    {"size", 0, "voxels per side of the synthetic volume", "N", ISO_IN(cast_options, render.size), .flags = ISO_SHOWN},
    {"image", 0, "pixels per side", "N", ISO_IN(cast_options, render.image), .flags = ISO_SHOWN, .least = 1,
     .most = 8192},
    {"truth", 0, "pixels per side of the picture compared with the reference", "N", ISO_IN(cast_options, truth),
     .flags = ISO_SHOWN, .least = 1, .most = 512},
    {"step", 0, "set the ray step", "VOXELS", ISO_IN(cast_options, render.step_voxels), .flags = ISO_SHOWN},
    {"rounds", 0, "draw with both in turn, N times", "N", ISO_IN(cast_options, rounds), .flags = ISO_SHOWN, .least = 1,
     .most = MOST_ROUNDS},
    {"width", 0, "use avx512, avx2, baseline or one (the widest available)", "NAME", ISO_IN(cast_options, width)},
    ISO_OPTIONS_OF(cast_options, render.input, iso_input_rows),
    ISO_OPTIONS_END,
};

static iso_status run(const iso_cli *cli, void *values, iso_error *err)
{
    return bench(cli, values, err);
}

const iso_command iso_bench_cast = {
    .name = "bench cast",
    .summary = "the CPU ray caster against the OpenGL one: times, and distance from the reference",
    .max_arguments = 1,
    .usage = "[VOLUME] [options]",
    .details =
        "Volumes, transfer functions and loops are those of bench render. Both programs draw the same samples in\n"
        "turn with the same number of threads: --threads, which software OpenGL gets as well unless LP_NUM_THREADS\n"
        "is set. Times are of the drawing alone. The last lines give the number of visible samples, the factor by\n"
        "which skipping makes the sparse pictures faster, and its bound if invisible samples cost nothing (processor\n"
        "time).",
    .common = "size image truth step rounds width threads spacing",
    .examples = "  isoshade bench cast --size 32 --image 48 --rounds 1 --truth 16\n",
    ISO_COMMAND_OPTIONS(cast_options, options, .render = {.size = 256, .image = 512, .step_voxels = 1}, .rounds = 3,
                        .truth = 64),
    .run = run,
};

/* SPDX-License-Identifier: MIT */
/* threads.c - what works with several threads, small, to be watched by the sanitizer of threads (tests/threads/run.sh).
 *
 *     isoshade-threads PART        build, stream, reference, cast, bricks, progress, programs, signal; race: a fault that is planted
 * / */
#define _GNU_SOURCE
#include "tests/folder.h"
#include "tests/test.h"

#include <pthread.h>
#include <signal.h>
#include <string.h>
#include <unistd.h>

#include "base/process.h"
#include "base/progress_line.h"
#include "pyramid/pyramid_stream.h"
#include "render/cpu/caster.h"
#include "render/cpu/mixed.h"
#include "render/reference.h"
#include "scene/scene.h"
#include "volume/stream.h"
#include "volume/synthetic.h"

enum { THREADS = 3 };

static void make_volume(iso_volume *v)
{
    const iso_field field = {.kind = ISO_FIELD_SHELLS,
                             .geometry = iso_geometry_axis_aligned((size_t[]){21, 18, 24}, (double[]){1, 0.9, 1.2}),
                             .seed = 1};
    assert_ok(iso_field_sample(&field, ISO_U16, v, &err));
}

static iso_pyramid_options options_of(iso_scalar_filter scalar, iso_direction_filter direction)
{
    iso_pyramid_options opt = iso_pyramid_defaults();
    opt.level_count = 3;
    opt.threads = THREADS;
    opt.scalar_filter = scalar;
    opt.direction_filter = direction;
    return opt;
}

static void build_with(iso_scalar_filter scalar, iso_direction_filter direction)
{
    iso_volume v;
    iso_pyramid p;
    const iso_pyramid_options opt = options_of(scalar, direction);
    make_volume(&v);
    assert_ok(iso_pyramid_build(&v, "threads", &opt, &p, NULL, &err));
    iso_pyramid_destroy(&p);
    iso_volume_destroy(&v);
}

static void build(void)
{
    build_with(ISO_SCALAR_MEAN, ISO_DIRECTION_MOMENTS);
    build_with(ISO_SCALAR_GAUSS, ISO_DIRECTION_EQ1);
    build_with(ISO_SCALAR_LEAST_SQUARES, ISO_DIRECTION_TENSOR);
    build_with(ISO_SCALAR_DAMPED, ISO_DIRECTION_AUTO);
}

static iso_status open_path(void *user, iso_volume_source **source, iso_error *err)
{
    return iso_source_open(user, source, err);
}

/* From a file to files, a few planes at a time: threads read and write beside those that compute. */
static void stream(void)
{
    char *source = iso_path_join(folder, "v.nrrd"), *pyramid = iso_path_join(folder, "v.iso");
    iso_volume v;
    iso_stream_report report;
    const iso_pyramid_options opt = options_of(ISO_SCALAR_MEAN, ISO_DIRECTION_MOMENTS);
    const iso_stream_options how = {.max_slab = 4};
    const iso_stream_input in = {open_path, source, source};
    make_volume(&v);
    assert_ok(iso_volume_save(&v, source, false, &err));
    assert_ok(iso_pyramid_stream(&in, &opt, &how, pyramid, &report, NULL, &err));
    iso_volume_destroy(&v);
    free(source);
    free(pyramid);
}

typedef struct shown {
    iso_volume volume;
    iso_pyramid pyramid;
    iso_view view;
} shown;

static void make_shown(shown *s)
{
    iso_scene scene;
    const iso_pyramid_options opt = options_of(ISO_SCALAR_MEAN, ISO_DIRECTION_MOMENTS);
    make_volume(&s->volume);
    assert_ok(iso_pyramid_build(&s->volume, "threads", &opt, &s->pyramid, NULL, &err));
    const iso_level *level = &s->pyramid.levels[0];
    assert_ok(iso_scene_load("refscenes/shells.scene.json", &scene, &err));
    scene.width = 24, scene.height = 20;
    assert_ok(iso_scene_resolve(&scene, &level->geometry, level->min, level->max, &s->view, &err));
    iso_scene_destroy(&scene);
}

static void destroy_shown(shown *s)
{
    iso_view_destroy(&s->view);
    iso_pyramid_destroy(&s->pyramid);
    iso_volume_destroy(&s->volume);
}

static void reference(void)
{
    shown s;
    iso_image image;
    iso_reference_options opt = iso_reference_defaults();
    opt.threads = THREADS;
    make_shown(&s);
    assert_ok(iso_reference_render(&s.pyramid.levels[0], s.pyramid.options.code, &s.view, &opt, &image, NULL, &err));
    iso_image_destroy(&image);
    destroy_shown(&s);
}

static void cast(void)
{
    shown s;
    iso_image image;
    iso_cpu_options opt = iso_cpu_defaults();
    opt.threads = THREADS;
    make_shown(&s);
    assert_ok(iso_cpu_render(&s.pyramid.levels[0], s.pyramid.options.code, &s.view, &opt, &image, &err));
    iso_image_destroy(&image);
    destroy_shown(&s);
}

/* Bricks of two levels, whose cells of several bricks are noted in one word. */
static void cast_bricks(void)
{
    shown s;
    iso_node_levels nodes;
    iso_image image;
    iso_cpu_brick_options opt = iso_cpu_brick_defaults();
    opt.threads = THREADS;
    opt.skip = ISO_CPU_SKIP_ALWAYS;
    make_shown(&s);
    assert_ok(iso_node_levels_create(&nodes, &s.pyramid.levels[0], 2, 2, true, THREADS, &err));
    uint8_t *levels = malloc(iso_brick_count(&nodes));
    assert_non_null(levels);
    for (size_t i = 0; i < iso_brick_count(&nodes); ++i)
        levels[i] = i % 3 == 0;
    const iso_brick_field field = {.nodes = &nodes, .levels = levels, .faces = ISO_FACES_BAKED};
    assert_ok(iso_cpu_render_bricks(&field, &s.view, &opt, &image, &err));
    iso_image_destroy(&image);
    free(levels);
    iso_node_levels_destroy(&nodes);
    destroy_shown(&s);
}

/* The line is written by a thread of its own while the work reports. */
static void progress(void)
{
    iso_progress_line *line = iso_progress_line_create("threads");
    assert_non_null(line);
    const iso_progress p = iso_progress_of_line(line);
    iso_progress_line_expect(line, "work", 1);
    for (int i = 0; i <= 20; ++i) {
        iso_progress_report(&p, "work", i / 20.0);
        usleep(10000);
    }
    iso_progress_line_destroy(line);
}

/* ---- other programs, that several threads run ---- */

static void count_line(void *user, const char *line)
{
    (void)line;
    ++*(int *)user;
}

static void *run_programs(void *user)
{
    const char *argv[] = {"/bin/sh", "-c", "echo one; echo two; exit 3", NULL};
    int *lines = user;
    for (int i = 0; i < 4; ++i) {
        iso_error error = {""};
        iso_process_outcome outcome = {0};
        const iso_process_options options = {.line = count_line, .user = lines, .outcome = &outcome};
        const iso_status status = iso_process_run(argv, &options, &error);
        *lines += 100 * (status == ISO_E_PROGRAM && outcome.exit_code == 3);
    }
    return NULL;
}

/* Two threads run programs while this one talks with a third. */
static void programs(void)
{
    pthread_t threads[2];
    int lines[2] = {0, 0}, told = 0;
    for (int i = 0; i < 2; ++i)
        assert_int_equal(pthread_create(&threads[i], NULL, run_programs, &lines[i]), 0);
    const char *argv[] = {"/bin/sh", "-c", "while read line; do echo $line; echo ready; done", NULL};
    const iso_sandbox_wish wish = {0};
    const iso_process_options options = {.line = count_line, .user = &told};
    iso_process *p;
    assert_ok(iso_process_start(argv, NULL, &wish, &p, &err));
    for (int i = 0; i < 4; ++i) {
        bool ended;
        iso_process_say(p, "a line");
        assert_ok(iso_process_listen(p, "ready", &options, &ended, &err));
        assert_false(ended);
    }
    iso_process_end(p);
    for (int i = 0; i < 2; ++i) {
        pthread_join(threads[i], NULL);
        assert_int_equal(lines[i], 4 * (100 + 2));
    }
    assert_int_equal(told, 4 * 2);
}

static void send_signal(void *user, const char *line)
{
    (void)user, (void)line;
    raise(SIGTERM);
}

static void *run_until_stopped(void *user)
{
    const char *argv[] = {"/bin/sh", "-c", "echo ready; exec sleep 60", NULL};
    const iso_process_options options = {.line = user ? send_signal : NULL, .timeout_seconds = 50};
    iso_error error = {""};
    const iso_status status = iso_process_run(argv, &options, &error);
    static char yes;
    return status == ISO_E_PROGRAM && strstr(error.text, "stopped by signal 15") ? &yes : NULL;
}

/* A handler runs in the one, and the other asks whether it did. */
static void stop_by_signal(void)
{
    pthread_t other;
    void *stopped = NULL;
    assert_int_equal(pthread_create(&other, NULL, run_until_stopped, NULL), 0);
    usleep(300000);
    assert_non_null(run_until_stopped(""));
    pthread_join(other, &stopped);
    assert_non_null(stopped);
}

static void race(void)
{
    static int shared;
#pragma omp parallel for num_threads(THREADS)
    for (int i = 0; i < 1000; ++i)
        ++shared;
    printf("%d\n", shared);
}

static const struct {
    const char *name;
    void (*run)(void);
} parts[] = {{"build", build},         {"stream", stream},     {"reference", reference}, {"cast", cast},
             {"bricks", cast_bricks},  {"progress", progress}, {"programs", programs},   {"signal", stop_by_signal},
             {"race", race}};
static const char *wanted;

static void the_part(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof parts / sizeof *parts; ++i)
        if (strcmp(parts[i].name, wanted) == 0) {
            parts[i].run();
            return;
        }
    fail_msg("there is no part %s", wanted);
}

int main(int argc, char **argv)
{
    wanted = argc > 1 ? argv[1] : "";
    const struct CMUnitTest tests[] = {cmocka_unit_test(the_part)};
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}

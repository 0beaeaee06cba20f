/* SPDX-License-Identifier: MIT */
/* One Blender for several scenes: its pictures are those of a Blender for each, and a scene that it fails at takes no
 * other one along. */
#define _GNU_SOURCE
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/file.h"
#include "base/process.h"
#include "base/work.h"
#include "difference.h"
#include "cycles.h"
#include "folder.h"
#include "rendered.h"

enum { scenes = 2 };

/* A level, a size, a camera and a table of its own: what a scene could leave to the next. */
typedef struct subject {
    iso_pyramid pyramid;
    iso_view views[scenes];
    size_t levels[scenes];
} subject;

static subject make_subject(void)
{
    subject s = {.pyramid = build_field(&(iso_field){.kind = ISO_FIELD_SHELLS,
                                                     .geometry = iso_geometry_axis_aligned((size_t[]){14, 12, 10},
                                                                                           (double[]){1, 1, 1.5})},
                                        2),
                 .levels = {0, 1}};
    iso_tf_point points[] = {{0, {1, 0.2, 0.1}, 0}, {1, {0.1, 0.5, 1}, 0.3}};
    for (size_t i = 0; i < scenes; ++i) {
        iso_scene scene = scene_of_points(points, 2);
        scene.width = 12 + 2 * i;
        scene.height = 12;
        scene.orthographic = i == 1;
        points[1].opacity = 0.2 + 0.1 * (double)i;
        s.views[i] = view_of(&scene, &s.pyramid);
    }
    return s;
}

static void end_subject(subject *s)
{
    for (size_t i = 0; i < scenes; ++i)
        iso_view_destroy(&s->views[i]);
    iso_pyramid_destroy(&s->pyramid);
}

static iso_status draw(const subject *s, size_t i, iso_blender_session **session, iso_image *image, iso_error *err)
{
    iso_blender_options opt = iso_blender_defaults();
    opt.session = session;
    opt.threads = 1;
    return iso_cycles_render(&s->pyramid, s->levels[i], &s->views[i], &opt, image, NULL, err);
}

/* A Blender in front of the real one that finds that its second line names no file. */
static void set_wrapper(void)
{
    FREED char *wrapper = iso_path_join(folder, "blender"), *blender = NULL, *text = NULL;
    assert_ok(iso_process_find("blender", "blender", &blender, &err));
    const int n = asprintf(&text,
                           "#!/bin/bash\n"
                           "exec '%s' \"$@\" < <(exec sed -u '2s/.*/nothing.json/')\n",
                           blender);
    assert_true(n > 0);
    assert_ok(iso_file_write(wrapper, text, (size_t)n, &err));
    assert_int_equal(chmod(wrapper, 0755), 0);
    setenv("ISOSHADE_BLENDER", wrapper, 1);
}

/* Scene by scene: the first start draws both and fails at the third; the next one draws that. */
TEST(pictures_are_those_of_a_blender_for_each_and_a_failure_ends_one_scene)
{
    need_cycles();
    subject s = make_subject();
    iso_image alone[scenes], image;
    iso_blender_session *session = NULL;
    iso_error why = {""};
    for (size_t i = 0; i < scenes; ++i)
        assert_ok(draw(&s, i, NULL, &alone[i], &why));
    set_wrapper();
    const size_t before = iso_work_sum().starts;
    const struct {
        size_t scene, starts;
        iso_status status;
    } steps[] = {{0, 1, ISO_OK}, {1, 1, ISO_OK}, {0, 1, ISO_E_PROGRAM}, {0, 2, ISO_OK}};
    for (size_t k = 0; k < sizeof steps / sizeof *steps; ++k) {
        const size_t i = steps[k].scene;
        assert_int_equal(draw(&s, i, &session, &image, &why), steps[k].status);
        assert_int_equal(iso_work_sum().starts - before, steps[k].starts);
        if (steps[k].status != ISO_OK) {
            assert_null(image.rgba);
            assert_non_null(strstr(why.text, "nothing.json"));
            continue;
        }
        assert_true(difference_of(&image, &alone[i]).max_abs == 0);
        iso_image_destroy(&image);
    }
    unsetenv("ISOSHADE_BLENDER");
    iso_blender_session_end(session);
    for (size_t i = 0; i < scenes; ++i)
        iso_image_destroy(&alone[i]);
    end_subject(&s);
}

TEST_MAIN(make_folder, remove_folder)

/* SPDX-License-Identifier: MIT */
/* validated.h - a volume, its levels and a scene as `isoshade validate` has them when it measures how levels stand to
 * level 0; for tests in a folder of their own (folder.h). */
#pragma once

#include <stdlib.h>

#include "tests/folder.h"
#include "tests/sampled.h"
#include "validate/validate.h"
#include "volume/synthetic.h"

static iso_renderers renderers;

static inline int end_renderers_and_folder(void **state)
{
    iso_renderers_end(&renderers);
    return remove_folder(state);
}

typedef struct subject {
    iso_pyramid pyramid;
    iso_scene scene;
    iso_view view;
    iso_validation validation;
    char *dir;
} subject;

/* What a program's subjects have alike. */
typedef struct subject_size {
    size_t pixels, levels, views;
} subject_size;

/* One light, an orthographic camera; the points are lent. */
static inline iso_scene scene_of_points(iso_tf_point *points, size_t count, size_t pixels, double ambient)
{
    return (iso_scene){.path = "test",
                       .width = pixels,
                       .height = pixels,
                       .camera_fit = true,
                       .orthographic = true,
                       .camera_direction = {0, 1, 0},
                       .camera_up = {0, 0, 1},
                       .margin = 1,
                       .light_count = 1,
                       .lights = {{.direction = {0.3, 0.5, 0.8}, .in_camera_space = true, .intensity = 1}},
                       .shading = {.ambient = ambient, .diffuse = 1 - ambient, .power = 1},
                       .step_voxels = 0.5,
                       .tf = {.fit_range = true,
                              .unit_distance = 1,
                              .unit_is_voxels = true,
                              .table_size = 256,
                              .point_count = count,
                              .points = points}};
}

static inline void open_volume(subject *s, const iso_volume *volume, iso_scene scene, const char *name,
                               subject_size size)
{
    const iso_report_about about = {.title = name};
    iso_pyramid_options build = iso_pyramid_defaults();
    *s = (subject){.scene = scene, .dir = iso_path_join(folder, name)};
    build.level_count = size.levels;
    assert_ok(iso_pyramid_build(volume, name, &build, &s->pyramid, NULL, &err));
    const iso_level *l = &s->pyramid.levels[0];
    assert_ok(iso_scene_resolve(&s->scene, &l->geometry, l->min, l->max, &s->view, &err));
    s->validation = (iso_validation){.pyramid = &s->pyramid,
                                     .scene = &s->scene,
                                     .view = &s->view,
                                     .scene_name = name,
                                     .consistency_size = size.pixels,
                                     .consistency_views = size.views,
                                     .threads = 1,
                                     .renderers = renderers};
    s->validation.wanted[iso_renderer_index(&iso_renderer_gl)] = true;
    assert_ok(iso_report_create(&s->validation.report, s->dir, &about, &err));
    assert_ok(iso_validate_adapt(&s->validation, &err));
}

static inline void open_field(subject *s, const iso_field *field, iso_scene scene, const char *name, subject_size size)
{
    OWNED(iso_volume) volume;
    assert_ok(iso_field_sample(field, ISO_F32, &volume, &err));
    open_volume(s, &volume, scene, name, size);
}

static inline void measure_levels(subject *s)
{
    assert_ok(iso_validate_consistency(&s->validation, &err));
    renderers = s->validation.renderers; /* the context is made at first use */
}

static inline void close_subject(subject *s)
{
    iso_report_destroy(s->validation.report);
    iso_validate_forget_tfs(&s->validation);
    iso_view_destroy(&s->view);
    iso_pyramid_destroy(&s->pyramid);
    free(s->dir);
}

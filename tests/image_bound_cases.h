/* SPDX-License-Identifier: MIT */
/* image_bound_cases.h - pyramids, views, images and bounds for tests of the bound of a level's image. */
#pragma once

#include <math.h>

#include "compare/metrics.h"
#include "render/image_bound.h"
#include "render/reference.h"
#include "test.h"
#include "volume/synthetic.h"

enum { PIXELS = 24 };

static inline iso_pyramid pyramid_of(iso_field_kind kind, size_t levels)
{
    iso_field field = {.kind = kind, .seed = 3};
    OWNED(iso_volume) v;
    iso_pyramid p;
    field.geometry = iso_geometry_axis_aligned((size_t[]){20, 17, 23}, (double[]){1, 1.4, 0.8});
    field.geometry.index_to_world.m[1][0] = 0.3; /* sheared */
    assert_ok(iso_field_sample(&field, ISO_F32, &v, &err));
    iso_pyramid_options opt = iso_pyramid_defaults();
    opt.level_count = levels;
    assert_ok(iso_pyramid_build(&v, "v", &opt, &p, NULL, &err));
    return p;
}

/* A step to `opacity` a voxel at `at` of the range, in two colors. */
static inline iso_view view_of(const iso_pyramid *p, double at, double opacity, bool orthographic, bool lit)
{
    iso_tf_point points[] = {{0, {0.2, 0.8, 0.5}, 0},
                             {at - 0.1, {0.2, 0.8, 0.5}, 0},
                             {at + 0.1, {0.9, 0.5, 0.1}, opacity},
                             {1, {0.1, 0.2, 1}, opacity}};
    const iso_level *level0 = &p->levels[0];
    const iso_scene scene = {.path = "test",
                             .width = PIXELS,
                             .height = PIXELS,
                             .camera_fit = true,
                             .orthographic = orthographic,
                             .fov_y_deg = 50,
                             .camera_direction = iso_normalize(iso_v3(1, 2, -1)),
                             .camera_up = {0, 0, 1},
                             .margin = 1,
                             .light_count = 1,
                             .lights = {{.direction = {0.3, 0.5, 0.8}, .in_camera_space = true, .intensity = 1}},
                             .shading = {lit ? 0.2 : 1, lit ? 0.5 : 0, lit ? 0.3 : 0, 12},
                             .background = {0.1, 0.3, 0.6},
                             .step_voxels = 0.5,
                             .tf = {.point_count = 4,
                                    .points = points,
                                    .fit_range = true,
                                    .unit_distance = 1,
                                    .unit_is_voxels = true,
                                    .table_size = 128}};
    iso_view view;
    assert_ok(iso_scene_resolve(&scene, &level0->geometry, level0->min, level0->max, &view, &err));
    return view;
}

static inline iso_image draw(const iso_pyramid *p, size_t level, const iso_view *view)
{
    iso_reference_options opt = iso_reference_defaults();
    iso_image image;
    opt.tolerance = 1e-4;
    assert_ok(iso_reference_render(&p->levels[level], p->options.code, view, &opt, &image, NULL, &err));
    return image;
}

static inline iso_image_bound_input input_of(const iso_pyramid *p, size_t level, const iso_view *view,
                                             const iso_tf_table *tf)
{
    return (iso_image_bound_input){.fine = p->levels,
                                   .coarse = &p->levels[level],
                                   .level = level,
                                   .code = p->options.code,
                                   .source = ISO_FROM_CODES,
                                   .view = view,
                                   .coarse_tf = tf};
}

static inline double bound_of(const iso_pyramid *p, size_t level, const iso_view *view, const iso_tf_table *tf,
                              int threads)
{
    iso_image_bound_input in = input_of(p, level, view, tf);
    double rmse = NAN;
    in.threads = threads;
    assert_ok(iso_image_bound_rmse(&in, &rmse, &err));
    return rmse;
}

static inline double measured_rmse(const iso_image *a, const iso_image *b)
{
    iso_metrics m;
    assert_ok(iso_metrics_measure(a, b, &m, &err));
    return m.rmse;
}

/* SPDX-License-Identifier: MIT */
/* rendered.h - sampled fields as pyramids, a small scene with a transfer function of points, and renderers that a
 * program's tests share. */
#pragma once

#include "renderers/renderers.h"
#include "scene/scene.h"
#include "sampled.h"
#include "volume/synthetic.h"

static iso_renderers renderers;

static inline int end_renderers(void **state)
{
    (void)state;
    iso_renderers_end(&renderers);
    return 0;
}

/* Of bytes, with so many levels. */
static inline iso_pyramid build_field(const iso_field *field, size_t levels)
{
    iso_pyramid_options opt = iso_pyramid_defaults();
    opt.level_count = levels;
    iso_pyramid p = sampled_pyramid(field, ISO_U8, &opt);
    return p;
}

/* In perspective, under one light, with highlights and a background. The points are lent. */
static inline iso_scene scene_of_points(iso_tf_point *points, size_t count)
{
    return (iso_scene){.path = "test",
                       .width = 32,
                       .height = 26,
                       .camera_fit = true,
                       .camera_direction = iso_normalize(iso_v3(1, 2, -0.7)),
                       .camera_up = {0, 0, 1},
                       .margin = 1.05,
                       .fov_y_deg = 30,
                       .light_count = 1,
                       .lights = {{.direction = iso_normalize(iso_v3(-1, 0.5, 2)), .intensity = 0.9}},
                       .shading = {.ambient = 0.3, .diffuse = 0.6, .specular = 0.2, .power = 12},
                       .background = {0.1, 0.2, 0.05},
                       .step_voxels = 0.5,
                       .tf = {.fit_range = true,
                              .unit_distance = 1,
                              .unit_is_voxels = true,
                              .table_size = 256,
                              .point_count = count,
                              .points = points}};
}

static inline iso_view view_of(const iso_scene *scene, const iso_pyramid *p)
{
    iso_view view;
    assert_ok(iso_scene_resolve(scene, &p->levels[0].geometry, p->levels[0].min, p->levels[0].max, &view, &err));
    return view;
}

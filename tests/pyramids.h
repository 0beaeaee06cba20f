/* SPDX-License-Identifier: MIT */
/* pyramids.h - small volumes and their pyramids, for tests. */
#pragma once

#include "test.h"

#include "pyramid/pyramid.h"
#include "scene/scene.h"

static inline iso_geometry plain(size_t nx, size_t ny, size_t nz)
{
    const size_t size[3] = {nx, ny, nz};
    const double spacing[3] = {1, 0.75, 2.5};
    return iso_geometry_axis_aligned(size, spacing);
}

static inline double noise_at(size_t i)
{
    uint64_t h = (i + 1) * 0x9E3779B97F4A7C15u;
    h = (h ^ (h >> 29)) * 0xBF58476D1CE4E5B9u;
    return (double)((h ^ (h >> 32)) & 0xFFFF) / 65536;
}

static inline iso_volume noise(size_t nx, size_t ny, size_t nz)
{
    iso_geometry g = plain(nx, ny, nz);
    iso_volume v;
    assert_ok(iso_volume_create(&v, &g, ISO_F32, "test", &err));
    for (size_t i = 0; i < nx * ny * nz; ++i)
        ((float *)v.data)[i] = (float)noise_at(i);
    return v;
}

static inline iso_pyramid_options keeping(iso_direction_filter filter)
{
    iso_pyramid_options opt = iso_pyramid_defaults();
    opt.direction_filter = filter;
    opt.keep_float = opt.keep_magnitude = true;
    opt.threads = 2;
    return opt;
}

static inline iso_pyramid build(const iso_volume *v, const iso_pyramid_options *opt)
{
    iso_pyramid p;
    assert_ok(iso_pyramid_build(v, "test", opt, &p, NULL, &err));
    return p;
}

static inline void place(const iso_geometry *g, size_t i, size_t at[3])
{
    at[0] = i % g->size[0];
    at[1] = i / g->size[0] % g->size[1];
    at[2] = i / g->size[0] / g->size[1];
}

/* A scene of a surface under a headlight, by the points of its transfer function. */
static inline iso_scene scene_of(const char *path, iso_tf_point points[4])
{
    return (iso_scene){.path = (char *)path,
                       .orthographic = true,
                       .light_count = 1,
                       .lights = {{.direction = {0, 0, 1}, .in_camera_space = true, .intensity = 1}},
                       .shading = {.ambient = 0.3, .diffuse = 0.7, .power = 1},
                       .step_voxels = 0.5,
                       .tf = {.point_count = 4,
                              .points = points,
                              .fit_range = true,
                              .unit_distance = 1,
                              .unit_is_voxels = true,
                              .table_size = 256}};
}

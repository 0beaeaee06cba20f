/* SPDX-License-Identifier: MIT */
/* povray_scenes.h - a smooth field, rendered by POV-Ray and by the reference. */
#pragma once

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "povray/povray.h"
#include "render/reference.h"
#include "difference.h"
#include "test.h"

enum { pixels = 40 };

/* A smooth field in world coordinates, in [0, 1], and its gradient: waves that differ along the axes. */
static inline double field(iso_vec3 w, iso_vec3 *gradient)
{
    const double x = 0.11 * w.x + 0.3, y = 0.08 * w.y - 0.4, z = 0.05 * w.z + 0.9;
    *gradient = iso_v3(0.4 * 0.11 * cos(x) * cos(y) - 0.1 * 0.11 * sin(2 * x), -0.4 * 0.08 * sin(x) * sin(y),
                       -0.05 * 0.05 * sin(z));
    return 0.5 + 0.4 * sin(x) * cos(y) + 0.05 * cos(2 * x) + 0.05 * cos(z);
}

/* Samples at the voxel centers of a level, directions encoded as bytes. */
static inline void fill_level(iso_level *level, const iso_geometry *g, iso_type type)
{
    const size_t count = iso_geometry_voxel_count(g);
    *level = (iso_level){.geometry = *g, .stored_type = type, .min = INFINITY, .max = -INFINITY};
    level->scalar = malloc(count * sizeof(float));
    level->codes = malloc(3 * count);
    level->directions = malloc(3 * count * sizeof(float));
    for (size_t i = 0; i < count; ++i) {
        const size_t x = i % g->size[0], y = i / g->size[0] % g->size[1], z = i / g->size[0] / g->size[1];
        iso_vec3 gradient;
        double value = field(iso_geometry_to_world(g, iso_v3((double)x + 0.5, (double)y + 0.5, (double)z + 0.5)),
                             &gradient);
        const iso_vec3 d = iso_normalize(gradient);
        value = type == ISO_U16 ? round(65535 * value) : value;
        level->scalar[i] = (float)value;
        level->min = fmin(level->min, value);
        level->max = fmax(level->max, value);
        level->directions[3 * i] = (float)d.x;
        level->directions[3 * i + 1] = (float)d.y;
        level->directions[3 * i + 2] = (float)d.z;
    }
    iso_code_encode(ISO_CODE_SNORM, level->directions, level->codes, count);
}

/* Unequal sizes, and an index-to-world matrix that rotates, stretches and is unequal along every axis. */
static inline iso_geometry tilted(size_t nx, size_t ny, size_t nz)
{
    iso_geometry g = iso_geometry_axis_aligned((size_t[]){nx, ny, nz}, (double[]){1, 1.2, 2.5});
    const double c = cos(0.5), s = sin(0.5), c2 = cos(-0.3), s2 = sin(-0.3);
    const iso_mat3 turn = {{{c, -s * c2, s * s2}, {s, c * c2, -c * s2}, {0, s2, c2}}};
    for (int a = 0; a < 3; ++a) {
        const iso_vec3 column = iso_mul(turn, iso_column(g.index_to_world, a));
        g.index_to_world.m[0][a] = column.x;
        g.index_to_world.m[1][a] = column.y;
        g.index_to_world.m[2][a] = column.z;
    }
    g.origin_mm = iso_add(g.origin_mm, iso_v3(30, -20, 10));
    return g;
}

/* Two levels: level 0 of 16 bits, level 1 float; odd sizes, so that level 1 overhangs. */
static inline iso_pyramid two_levels(void)
{
    iso_pyramid p = {.options = {.code = ISO_CODE_SNORM}, .level_count = 2, .levels = calloc(2, sizeof(iso_level))};
    const iso_geometry g0 = tilted(41, 56, 33), g1 = iso_geometry_coarser(&g0);
    fill_level(&p.levels[0], &g0, ISO_U16);
    fill_level(&p.levels[1], &g1, ISO_F32);
    for (size_t i = 0; i < iso_geometry_voxel_count(&g1); ++i)
        p.levels[1].scalar[i] *= 65535;
    p.levels[1].min *= 65535;
    p.levels[1].max *= 65535;
    return p;
}

static inline void release(iso_pyramid *p)
{
    for (size_t k = 0; k < p->level_count; ++k) {
        free(p->levels[k].scalar);
        free(p->levels[k].codes);
        free(p->levels[k].directions);
    }
    free(p->levels);
}

static inline float *smooth_table(size_t count, double opaque)
{
    float *entries = malloc(4 * count * sizeof *entries);
    for (size_t i = 0; i < count; ++i) {
        const double u = (double)i / (double)(count - 1);
        entries[4 * i] = (float)(0.5 + 0.5 * sin(3 * u));
        entries[4 * i + 1] = (float)(u * u);
        entries[4 * i + 2] = (float)(1 - u);
        entries[4 * i + 3] = (float)(opaque * u * u * (3 - 2 * u));
    }
    return entries;
}

/* A camera that sees the whole box at an angle; two lights, highlights, a background. */
static inline iso_view oblique_view(const iso_geometry *g, bool orthographic, size_t table)
{
    iso_view v = {.width = pixels, .height = pixels * 3 / 4, .light_count = 2, .background = {0.1, 0.2, 0.4}};
    const double radius = iso_geometry_box_radius_mm(g);
    v.camera.orthographic = orthographic;
    v.camera.forward = iso_normalize(iso_v3(1, 2, -0.7));
    v.camera.right = iso_normalize(iso_cross(v.camera.forward, iso_v3(0, 0, 1)));
    v.camera.up = iso_cross(v.camera.right, v.camera.forward);
    v.camera.position = iso_madd(iso_geometry_box_center_mm(g), v.camera.forward, -4 * radius);
    v.camera.half_height = orthographic ? 0.8 * radius : 0.22;
    v.lights[0] = (iso_light){.direction = iso_normalize(iso_v3(0.2, -1, 0.6)), .intensity = 0.7};
    v.lights[1] = (iso_light){.direction = iso_normalize(iso_v3(-1, -0.3, 0.4)), .intensity = 0.3};
    v.shading = (iso_shading){.ambient = 0.3, .diffuse = 0.7, .specular = 0.2, .power = 20};
    v.tf = (iso_tf_table){.count = table, .lo = 6000, .hi = 60000, .entries = smooth_table(table, 0.05)};
    return v;
}

static inline bool progress_rises_to_one(void *user, const char *stage, double fraction)
{
    double *last = user;
    if (strstr(stage, "rendering")) {
        assert_true(fraction >= *last && fraction <= 1);
        *last = fraction;
    }
    return true;
}

static inline void render_povray(const iso_pyramid *p, size_t level, const iso_view *view,
                                 const iso_povray_options *opt, iso_image *image)
{
    double last = 0;
    const iso_progress progress = {.report = progress_rises_to_one, .user = &last};
    assert_ok(iso_povray_render(p, level, view, opt, image, &progress, &err));
    assert_within(last, 1, 0);
}

static inline void render_reference(const iso_pyramid *p, size_t level, const iso_view *view, iso_quadrature quadrature,
                                    size_t intervals, double iso, iso_image *image)
{
    iso_reference_options opt = iso_reference_defaults();
    opt.quadrature = quadrature;
    opt.intervals = intervals;
    opt.iso = iso;
    assert_ok(iso_reference_render(&p->levels[level], p->options.code, view, &opt, image, NULL, &err));
}

/* One comparison: what POV-Ray and the reference make of the same level and view. */
typedef struct comparison {
    iso_pyramid pyramid;
    iso_view view;
    size_t level;
    iso_povray_options options;
    iso_quadrature quadrature;
    iso_image image; /* POV-Ray's */
} comparison;

static inline comparison lock_step(size_t level, bool orthographic, size_t table)
{
    comparison c = {.pyramid = two_levels(),
                    .level = level,
                    .options = iso_povray_defaults(),
                    .quadrature = ISO_QUADRATURE_POVRAY};
    c.view = oblique_view(&c.pyramid.levels[0].geometry, orthographic, table);
    c.options.planes = 0;
    c.options.extrapolate = false;
    c.options.intervals = 60;
    return c;
}

static inline comparison converged(size_t level)
{
    comparison c = lock_step(level, false, 256);
    c.quadrature = ISO_QUADRATURE_CONVERGED;
    c.view.width = 24; /* the converged reference is the slow side */
    c.view.height = 18;
    c.options.intervals = 120;
    c.options.planes = 1;
    c.options.extrapolate = true;
    return c;
}

static inline void end_comparison(comparison *c)
{
    iso_image_destroy(&c->image);
    free(c->view.tf.entries);
    release(&c->pyramid);
}

/* The largest difference to the reference, which sees what the comparison holds now. */
static inline double compare(comparison *c, double *rmse)
{
    OWNED(iso_image) wanted;
    if (!c->image.rgba)
        render_povray(&c->pyramid, c->level, &c->view, &c->options, &c->image);
    render_reference(&c->pyramid, c->level, &c->view, c->quadrature, c->options.intervals, c->options.iso, &wanted);
    const difference d = difference_of(&c->image, &wanted);
    const double most = d.max_abs;
    *rmse = d.rmse;
    return most;
}

/* Half a step of POV-Ray's 16 bits is 7.6e-6, of emission up to 1.2 times that and of the background; its colors
 * and optical depths are floats. */
static const double lock_step_max = 2e-5;
/* What is left of 240 and 480 midpoint samples a ray behind extrapolation, on a TF with a continuous slope. */
static const double converged_rmse = 1e-4;

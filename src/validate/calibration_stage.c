/* SPDX-License-Identifier: MIT */
#include "validate/calibration_stage.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "compare/statistics.h"
#include "render/sampler.h"

/* Returns a grid turned about an oblique axis, with three spacings of which none, nor their mean, is 1. */
iso_geometry iso_calibration_turned_grid(size_t nx, size_t ny, size_t nz)
{
    const size_t size[3] = {nx, ny, nz};
    const double spacing[3] = {1.05, 1.25, 0.8};
    iso_geometry g = iso_geometry_axis_aligned(size, spacing);
    const double c = cos(0.5), s = sin(0.5), c2 = cos(0.3), s2 = sin(0.3);
    const iso_mat3 turn = {{{c, -s * c2, s * s2}, {s, c * c2, -c * s2}, {0, s2, c2}}};
    iso_mat3 m = g.index_to_world;
    for (int r = 0; r < 3; ++r)
        for (int k = 0; k < 3; ++k)
            g.index_to_world.m[r][k] = turn.m[r][k] * m.m[k][k];
    g.origin_mm = iso_mul(turn, g.origin_mm);
    return g;
}

iso_camera iso_calibration_look(iso_vec3 forward, double half_height, bool orthographic)
{
    iso_camera c = {.orthographic = orthographic, .forward = iso_normalize(forward), .half_height = half_height};
    c.right = iso_normalize(iso_cross(c.forward, iso_v3(0, 0, 1)));
    c.up = iso_cross(c.right, c.forward);
    c.position = iso_scale(c.forward, -60);
    return c;
}

iso_status iso_calibration_stage_set(iso_calibration_stage *s, const iso_geometry *g,
                                     double (*value)(const iso_geometry *, iso_vec3 index), iso_error *err)
{
    iso_volume v;
    iso_pyramid_options opt = iso_pyramid_defaults();
    opt.level_count = 2; /* the second is for a planted fault alone */
    *s = (iso_calibration_stage){.view = {.width = ISO_CALIBRATION_PIXELS,
                                          .height = ISO_CALIBRATION_PIXELS,
                                          .light_count = 1,
                                          .step_voxels = 0.25,
                                          .shading = {.ambient = 1, .power = 1}}};
    s->view.lights[0] = (iso_light){.direction = iso_normalize(iso_v3(-0.9, 0.3, 0.5)), .intensity = 1};
    NEED(iso_volume_create(&v, g, ISO_F32, "calibration", err));
    float *out = v.data;
    for (size_t z = 0; z < g->size[2]; ++z)
        for (size_t y = 0; y < g->size[1]; ++y)
            for (size_t x = 0; x < g->size[0]; ++x)
                *out++ = (float)value(g, iso_v3((double)x + 0.5, (double)y + 0.5, (double)z + 0.5));
    iso_status status = iso_pyramid_build(&v, "calibration", &opt, &s->pyramid, NULL, err);
    iso_volume_destroy(&v);
    s->view.tf = (iso_tf_table){.count = ISO_CALIBRATION_TF_ENTRIES, .lo = 0, .hi = 1};
    s->view.tf.entries = calloc(ISO_CALIBRATION_TF_ENTRIES * 4, sizeof(float));
    if (status == ISO_OK && !s->view.tf.entries)
        status = iso_fail(err, ISO_E_MEMORY, "no memory for a calibration");
    TRY(status, iso_image_create(&s->expected, ISO_CALIBRATION_PIXELS, ISO_CALIBRATION_PIXELS, err));
    return status;
}

void iso_calibration_stage_clear(iso_calibration_stage *s)
{
    iso_image_destroy(&s->expected);
    iso_image_destroy(&s->got);
    iso_view_destroy(&s->view);
    iso_pyramid_destroy(&s->pyramid);
}

void iso_calibration_set_entry(iso_view *view, size_t i, float r, float g, float b, float extinction)
{
    const float entry[4] = {r, g, b, extinction};
    memcpy(view->tf.entries + 4 * i, entry, sizeof entry);
}

/* Renderers of a fixed number of intervals take by default as many as they can, for any size of volume. These volumes
 * have a few voxels: a sixteenth of one, extrapolated, leaves 1e-5. */
static iso_render_options stage_options(const iso_calibration_stage *s, const iso_renderer_info *which)
{
    const double step_voxels = 1.0 / 16;
    iso_render_options opt = iso_render_defaults(which);
    if (which->max_intervals > 0) {
        iso_render_ask_steps(which, &s->pyramid.levels[0], step_voxels, 1, 1, &opt);
        opt.extrapolate = true;
    }
    return opt;
}

iso_status iso_calibration_render(iso_calibration_stage *stages, size_t count, iso_renderers *r,
                                  const iso_renderer_info *which, const iso_calibration_fault *fault, iso_error *err)
{
    iso_render_options options[ISO_RENDER_MAX_SCENES];
    iso_render_request requests[ISO_RENDER_MAX_SCENES];
    iso_image images[ISO_RENDER_MAX_SCENES];
    for (size_t i = 0; i < count; ++i) {
        iso_calibration_stage *s = &stages[i];
        options[i] = stage_options(s, which);
        const size_t level = fault ? fault->plant(fault->hook.user, &s->pyramid, &s->view) : 0;
        requests[i] = (iso_render_request){r, &s->pyramid, level, &s->view, &options[i], NULL};
    }
    r->after = fault ? fault->hook : (iso_image_hook){0};
    const iso_status status = iso_render_scenes(requests, count, images, err);
    r->after = (iso_image_hook){0};
    for (size_t i = 0; i < count && status == ISO_OK; ++i)
        stages[i].got = images[i];
    return status;
}

/* Integers clamp at a color of 1: the expected value is clamped, too. */
double iso_calibration_largest_difference(iso_calibration_stage *s, const iso_renderer_info *which)
{
    double worst = 0;
    if (which->output.most > 0)
        iso_image_clip(&s->expected, (float)which->output.most);
    for (size_t i = 0; i < ISO_CALIBRATION_PIXELS * ISO_CALIBRATION_PIXELS * 4; ++i)
        worst = iso_larger(worst, fabs((double)s->got.rgba[i] - (double)s->expected.rgba[i]));
    return worst;
}

static double chord(const iso_calibration_stage *s, size_t column, size_t row)
{
    double t0, t1;
    iso_ray ray = iso_camera_ray(&s->view.camera, ISO_CALIBRATION_PIXELS, ISO_CALIBRATION_PIXELS, column, row);
    return iso_ray_box(&ray, &s->pyramid.levels[0].geometry, &t0, &t1) ? t1 - t0 : 0;
}

void iso_calibration_expect_pixel(iso_calibration_stage *s, size_t column, size_t row, const double rgbs[4],
                                  double shade)
{
    double alpha = -expm1(-rgbs[3] * chord(s, column, row));
    float *p = s->expected.rgba + 4 * (row * ISO_CALIBRATION_PIXELS + column);
    for (int c = 0; c < 3; ++c)
        p[c] = (float)(rgbs[c] * shade * alpha);
    p[3] = (float)alpha;
}

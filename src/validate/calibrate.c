/* SPDX-License-Identifier: MIT */
#include "validate/calibrate.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "render/sampler.h"

enum { pixels = 32, tf_entries = 17 };

/* A subject, its view, and the image that it must give. */
typedef struct stage {
    iso_pyramid pyramid;
    iso_view view;
    iso_image expected, got;
} stage;

/* A grid turned about an oblique axis, with three different spacings. */
static iso_geometry turned_grid(size_t nx, size_t ny, size_t nz)
{
    const size_t size[3] = {nx, ny, nz};
    const double spacing[3] = {1.0, 1.25, 0.8};
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

static iso_camera look(iso_vec3 forward, double half_height, bool orthographic)
{
    iso_camera c = {.orthographic = orthographic, .forward = iso_normalize(forward), .half_height = half_height};
    c.right = iso_normalize(iso_cross(c.forward, iso_v3(0, 0, 1)));
    c.up = iso_cross(c.right, c.forward);
    c.position = iso_scale(c.forward, -60);
    return c;
}

static iso_status set_stage(stage *s, const iso_geometry *g, double (*value)(const iso_geometry *, iso_vec3 index),
                            iso_error *err)
{
    iso_volume v;
    iso_pyramid_options opt = iso_pyramid_defaults();
    opt.level_count = 2; /* the second is for a planted fault alone */
    *s = (stage){.view = {.width = pixels,
                          .height = pixels,
                          .light_count = 1,
                          .step_voxels = 0.25,
                          .shading = {.ambient = 1, .power = 1}}};
    s->view.lights[0] = (iso_light){.direction = iso_normalize(iso_v3(-0.9, 0.3, 0.5)), .intensity = 1};
    iso_status status = iso_volume_create(&v, g, ISO_F32, "calibration", err);
    if (status != ISO_OK)
        return status;
    float *out = v.data;
    for (size_t z = 0; z < g->size[2]; ++z)
        for (size_t y = 0; y < g->size[1]; ++y)
            for (size_t x = 0; x < g->size[0]; ++x)
                *out++ = (float)value(g, iso_v3((double)x + 0.5, (double)y + 0.5, (double)z + 0.5));
    status = iso_pyramid_build(&v, "calibration", &opt, &s->pyramid, NULL, err);
    iso_volume_destroy(&v);
    s->view.tf = (iso_tf_table){.count = tf_entries, .lo = 0, .hi = 1};
    s->view.tf.entries = calloc(tf_entries * 4, sizeof(float));
    if (status == ISO_OK && !s->view.tf.entries)
        status = iso_fail(err, ISO_E_MEMORY, "no memory for a calibration");
    if (status == ISO_OK)
        status = iso_image_create(&s->expected, pixels, pixels, err);
    return status;
}

static void clear_stage(stage *s)
{
    iso_image_destroy(&s->expected);
    iso_image_destroy(&s->got);
    iso_view_destroy(&s->view);
    iso_pyramid_destroy(&s->pyramid);
}

static void set_entry(iso_view *view, size_t i, float r, float g, float b, float extinction)
{
    const float entry[4] = {r, g, b, extinction};
    memcpy(view->tf.entries + 4 * i, entry, sizeof entry);
}

static iso_status render_stage(stage *s, iso_renderers *r, const iso_renderer_info *which, const iso_planted *planted,
                               iso_error *err)
{
    iso_render_options opt = iso_render_defaults(which);
    iso_plant(planted, &s->pyramid, 0, &s->view);
    r->after = iso_planted_hook(planted);
    iso_status status = iso_render_with(&(iso_render_request){r, &s->pyramid, iso_planted_level(planted, 0), &s->view,
                                                              &opt, NULL},
                                        &s->got, NULL, err);
    r->after = (iso_image_hook){0};
    return status;
}

static double largest_difference(const stage *s)
{
    double worst = 0;
    for (size_t i = 0; i < pixels * pixels * 4; ++i) {
        double d = fabs((double)s->got.rgba[i] - (double)s->expected.rgba[i]);
        worst = d <= worst ? worst : d; /* NaN stays */
    }
    return worst;
}

static double chord(const stage *s, size_t column, size_t row)
{
    double t0, t1;
    iso_ray ray = iso_camera_ray(&s->view.camera, pixels, pixels, column, row);
    return iso_ray_box(&ray, &s->pyramid.levels[0].geometry, &t0, &t1) ? t1 - t0 : 0;
}

static void expect_pixel(stage *s, size_t column, size_t row, const double rgbs[4], double shade)
{
    double alpha = -expm1(-rgbs[3] * chord(s, column, row));
    float *p = s->expected.rgba + 4 * (row * pixels + column);
    for (int c = 0; c < 3; ++c)
        p[c] = (float)(rgbs[c] * shade * alpha);
    p[3] = (float)alpha;
}

/* ---- the checks ---- */

static double blob(const iso_geometry *g, iso_vec3 index)
{
    iso_vec3 center = {0.42 * (double)g->size[0], 0.55 * (double)g->size[1], 0.47 * (double)g->size[2]};
    double r2 = iso_dot(iso_sub(index, center), iso_sub(index, center));
    return fmax(0, 1 - r2 / 12); /* ends inside the grid: the border is zero */
}

/* Trilinear hats have their centroid at the voxel's centre, and projection is linear. */
static void expected_centroid(const stage *s, double at[2])
{
    const iso_level *level = &s->pyramid.levels[0];
    const iso_camera *c = &s->view.camera;
    iso_vec3 sum = {0};
    double mass = 0;
    size_t i = 0;
    for (size_t z = 0; z < level->geometry.size[2]; ++z)
        for (size_t y = 0; y < level->geometry.size[1]; ++y)
            for (size_t x = 0; x < level->geometry.size[0]; ++x, ++i) {
                double v = (double)level->scalar[i];
                iso_vec3 index = {(double)x + 0.5, (double)y + 0.5, (double)z + 0.5};
                sum = iso_madd(sum, iso_geometry_to_world(&level->geometry, index), v);
                mass += v;
            }
    iso_vec3 p = iso_sub(iso_scale(sum, 1 / mass), c->position);
    at[0] = (iso_dot(p, c->right) / c->half_height + 1) * 0.5 * pixels - 0.5;
    at[1] = (1 - iso_dot(p, c->up) / c->half_height) * 0.5 * pixels - 0.5;
}

static iso_status check_placement(stage *s, iso_renderers *r, const iso_renderer_info *which,
                                  const iso_planted *planted, double *value, iso_error *err)
{
    iso_geometry g = turned_grid(15, 12, 18);
    double expected[2], sum[3] = {0};
    iso_status status = set_stage(s, &g, blob, err);
    if (status != ISO_OK)
        return status;
    s->view.camera = look(iso_v3(1, 2, -0.7), 8, true);
    for (size_t i = 0; i < tf_entries; ++i)
        set_entry(&s->view, i, 1, 1, 1, 0.2f * (float)i / (tf_entries - 1));
    expected_centroid(s, expected);
    status = render_stage(s, r, which, planted, err);
    for (size_t i = 0; status == ISO_OK && i < pixels * pixels; ++i) {
        double depth = -log1p(-(double)s->got.rgba[4 * i + 3]);
        sum[0] += depth * (double)(i % pixels);
        sum[1] += depth * (double)(i / pixels);
        sum[2] += depth;
    }
    *value = hypot(sum[0] / sum[2] - expected[0], sum[1] / sum[2] - expected[1]);
    return status;
}

static double half(const iso_geometry *g, iso_vec3 index)
{
    (void)g;
    (void)index;
    return 0.5;
}

static iso_status check_slab(stage *s, iso_renderers *r, const iso_renderer_info *which, const iso_planted *planted,
                             double *value, iso_error *err)
{
    iso_geometry g = turned_grid(9, 7, 12);
    iso_status status = set_stage(s, &g, half, err);
    if (status != ISO_OK)
        return status;
    s->view.camera = look(iso_v3(1, 2, -0.7), 0.14, false);
    for (size_t i = 0; i < tf_entries; ++i)
        set_entry(&s->view, i, 0.9f, 0.5f, 0.2f, 0.15f);
    for (size_t i = 0; i < pixels * pixels; ++i) {
        const double rgbs[4] = {(double)0.9f, 0.5, (double)0.2f, (double)0.15f};
        expect_pixel(s, i % pixels, i / pixels, rgbs, 1);
    }
    status = render_stage(s, r, which, planted, err);
    *value = largest_difference(s);
    return status;
}

/* 16 intervals between the first and the last voxel centre: every TF entry is met. */
static double ramp_along_x(const iso_geometry *g, iso_vec3 index)
{
    return (index.x - 0.5) / (double)(g->size[0] - 1);
}

static iso_status check_transfer_function(stage *s, iso_renderers *r, const iso_renderer_info *which,
                                          const iso_planted *planted, double *value, iso_error *err)
{
    const size_t size[3] = {17, 5, 6};
    const double spacing[3] = {1, 1, 1};
    iso_geometry g = iso_geometry_axis_aligned(size, spacing);
    iso_status status = set_stage(s, &g, ramp_along_x, err);
    if (status != ISO_OK)
        return status;
    s->view.camera = look(iso_v3(0, 1, 0), 8.5, true);
    for (size_t i = 0; i < tf_entries; ++i)
        set_entry(&s->view, i, (float)(i % 5) / 4, (float)(i % 3) / 2, (float)((i * 7) % 11) / 10,
                  0.05f + 0.1f * (float)(i % 4));
    for (size_t i = 0; i < pixels * pixels; ++i) {
        iso_ray ray = iso_camera_ray(&s->view.camera, pixels, pixels, i % pixels, i / pixels);
        iso_vec3 index = iso_geometry_to_index(&g, ray.origin);
        double rgbs[4];
        iso_tf_lookup(&s->view.tf, ramp_along_x(&g, index), rgbs);
        expect_pixel(s, i % pixels, i / pixels, rgbs, 1);
    }
    status = render_stage(s, r, which, planted, err);
    *value = largest_difference(s);
    return status;
}

static double tilted_ramp(const iso_geometry *g, iso_vec3 index)
{
    iso_vec3 world = iso_geometry_to_world(g, index);
    return 0.5 + 0.03 * world.x - 0.01 * world.y + 0.02 * world.z;
}

static iso_status check_light(stage *s, iso_renderers *r, const iso_renderer_info *which, const iso_planted *planted,
                              double *value, iso_error *err)
{
    iso_geometry g = turned_grid(9, 7, 12);
    iso_status status = set_stage(s, &g, tilted_ramp, err);
    if (status != ISO_OK)
        return status;
    s->view.camera = look(iso_v3(1, -0.6, 0.9), 7, true); /* light and viewer are where the gradient does not look */
    s->view.shading = (iso_shading){.ambient = 0.2, .diffuse = 0.8, .specular = 0.9, .power = 2};
    for (size_t i = 0; i < tf_entries; ++i)
        set_entry(&s->view, i, 0.9f, 0.5f, 0.2f, 0.9f);
    /* The gradient of the field is (3, -1, 2) / 100 per mm in the world; what its code keeps of it is the truth here. */
    const float direction[3] = {3 / sqrtf(14), -1 / sqrtf(14), 2 / sqrtf(14)};
    uint8_t bytes[3];
    double e[3], d[3], n[3];
    iso_code_encode(s->pyramid.options.code, direction, bytes, 1);
    iso_code_lattice(s->pyramid.options.code, bytes, e);
    iso_code_decode(s->pyramid.options.code, e, d);
    iso_code_normal(d, n);
    iso_vec3 light = s->view.lights[0].direction, normal = iso_v3(n[0], n[1], n[2]);
    double highlight = iso_dot(normal, iso_normalize(iso_sub(light, s->view.camera.forward)));
    double shade = 0.2 + 0.8 * fabs(iso_dot(normal, light)) + 0.9 * highlight * highlight;
    for (size_t i = 0; i < pixels * pixels; ++i) {
        const double rgbs[4] = {(double)0.9f, 0.5, (double)0.2f, (double)0.9f};
        expect_pixel(s, i % pixels, i / pixels, rgbs, shade);
    }
    status = render_stage(s, r, which, planted, err);
    *value = largest_difference(s);
    return status;
}

static const struct {
    iso_calibration blank;
    iso_status (*run)(stage *, iso_renderers *, const iso_renderer_info *, const iso_planted *, double *, iso_error *);
} checks[ISO_CALIBRATION_COUNT] = {
    {{.check = "placement",
      .unit = "pixel",
      .limit = 0.02,
      .why = "the blob is sampled at 32 x 32 pixels; half a voxel would be 0.6 pixel or more"},
     check_placement},
    {{.check = "slab",
      .unit = "largest difference",
      .limit = 2e-4,
      .why = "marching adds up to one rounding of the step at the box's faces; 1 % of extinction would be 3e-3"},
     check_slab},
    {{.check = "transfer function",
      .unit = "largest difference",
      .limit = 5e-4,
      .why = "tables are looked up in float or through 16-bit files; an sRGB table would be off by 0.1"},
     check_transfer_function},
    {{.check = "light",
      .unit = "largest difference",
      .limit = 5e-4,
      .why = "directions travel as bytes, floats or 16-bit files; a mirrored axis would be off by 0.1"},
     check_light},
};

int iso_calibration_number(const char *check)
{
    int i = 0;
    while (i + 1 < ISO_CALIBRATION_COUNT && strcmp(checks[i].blank.check, check) != 0)
        ++i;
    return i;
}

iso_status iso_calibrate_check(iso_renderers *r, const iso_renderer_info *which, const iso_planted *planted, int check,
                               iso_calibration *out, iso_error *err)
{
    stage s = {0};
    *out = checks[check].blank;
    iso_status status = checks[check].run(&s, r, which, planted, &out->value, err);
    out->passed = out->value <= out->limit; /* NaN does not pass */
    clear_stage(&s);
    return status == ISO_OK ? ISO_OK : iso_fail_in(err, status, "calibration of %s", which->name);
}

iso_status iso_calibrate(iso_renderers *r, const iso_renderer_info *which, const iso_planted *planted,
                         iso_calibration out[ISO_CALIBRATION_COUNT], const iso_progress *progress, iso_error *err)
{
    iso_status status = ISO_OK;
    for (int i = 0; i < ISO_CALIBRATION_COUNT && status == ISO_OK; ++i) {
        iso_progress_report(progress, "calibration", (double)i / ISO_CALIBRATION_COUNT);
        status = iso_calibrate_check(r, which, planted, i, &out[i], err);
    }
    return status;
}

/* SPDX-License-Identifier: MIT */
#include "validate/calibrate.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/process.h"
#include "render/sampler.h"
#include "validate/calibration_stage.h"

/* ---- the checks ---- */

static double blob(const iso_geometry *g, iso_vec3 index)
{
    iso_vec3 center = {0.42 * (double)g->size[0], 0.55 * (double)g->size[1], 0.47 * (double)g->size[2]};
    double r2 = iso_dot(iso_sub(index, center), iso_sub(index, center));
    return fmax(0, 1 - r2 / 12); /* ends inside the grid: the border is zero */
}

/* Projects the volume's centroid, at[2] in pixels. Trilinear hats have theirs at the voxel's center, and projection is
 * linear. */
static void expected_centroid(const iso_calibration_stage *s, double at[2])
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
    at[0] = (iso_dot(p, c->right) / c->half_height + 1) * 0.5 * ISO_CALIBRATION_PIXELS - 0.5;
    at[1] = (1 - iso_dot(p, c->up) / c->half_height) * 0.5 * ISO_CALIBRATION_PIXELS - 0.5;
}

static iso_status prepare_placement(iso_calibration_stage *s, iso_error *err)
{
    iso_geometry g = iso_calibration_turned_grid(15, 12, 18);
    NEED(iso_calibration_stage_set(s, &g, blob, err));
    s->view.camera = iso_calibration_look(iso_v3(1, 2, -0.7), 8, true);
    for (size_t i = 0; i < ISO_CALIBRATION_TF_ENTRIES; ++i)
        iso_calibration_set_entry(&s->view, i, 1, 1, 1, 0.2f * (float)i / (ISO_CALIBRATION_TF_ENTRIES - 1));
    expected_centroid(s, s->centroid);
    return ISO_OK;
}

/* Returns the distance of the centroid of the optical depth from its expected place. */
static double judge_placement(iso_calibration_stage *s, const iso_renderer_info *which)
{
    (void)which;
    double sum[3] = {0};
    for (size_t i = 0; i < ISO_CALIBRATION_PIXELS * ISO_CALIBRATION_PIXELS; ++i) {
        double depth = -log1p(-(double)s->got.rgba[4 * i + 3]);
        sum[0] += depth * (double)(i % ISO_CALIBRATION_PIXELS);
        sum[1] += depth * (double)(i / ISO_CALIBRATION_PIXELS);
        sum[2] += depth;
    }
    return hypot(sum[0] / sum[2] - s->centroid[0], sum[1] / sum[2] - s->centroid[1]);
}

static double half(const iso_geometry *g, iso_vec3 index)
{
    (void)g;
    (void)index;
    return 0.5;
}

static iso_status prepare_slab(iso_calibration_stage *s, iso_error *err)
{
    iso_geometry g = iso_calibration_turned_grid(9, 7, 12);
    NEED(iso_calibration_stage_set(s, &g, half, err));
    s->view.camera = iso_calibration_look(iso_v3(1, 2, -0.7), 0.14, false);
    for (size_t i = 0; i < ISO_CALIBRATION_TF_ENTRIES; ++i)
        iso_calibration_set_entry(&s->view, i, 0.9f, 0.5f, 0.2f, 0.15f);
    for (size_t i = 0; i < ISO_CALIBRATION_PIXELS * ISO_CALIBRATION_PIXELS; ++i) {
        const double rgbs[4] = {(double)0.9f, 0.5, (double)0.2f, (double)0.15f};
        iso_calibration_expect_pixel(s, i % ISO_CALIBRATION_PIXELS, i / ISO_CALIBRATION_PIXELS, rgbs, 1);
    }
    return ISO_OK;
}

/* Returns the value of a ramp with 16 intervals between the first and the last voxel center: every TF entry is met. */
static double ramp_along_x(const iso_geometry *g, iso_vec3 index)
{
    return (index.x - 0.5) / (double)(g->size[0] - 1);
}

static iso_status prepare_transfer_function(iso_calibration_stage *s, iso_error *err)
{
    const size_t size[3] = {17, 5, 6};
    const double spacing[3] = {1, 1, 1};
    iso_geometry g = iso_geometry_axis_aligned(size, spacing);
    NEED(iso_calibration_stage_set(s, &g, ramp_along_x, err));
    s->view.camera = iso_calibration_look(iso_v3(0, 1, 0), 8.5, true);
    for (size_t i = 0; i < ISO_CALIBRATION_TF_ENTRIES; ++i)
        iso_calibration_set_entry(&s->view, i, (float)(i % 5) / 4, (float)(i % 3) / 2, (float)((i * 7) % 11) / 10,
                                  0.05f + 0.1f * (float)(i % 4));
    for (size_t i = 0; i < ISO_CALIBRATION_PIXELS * ISO_CALIBRATION_PIXELS; ++i) {
        iso_ray ray = iso_camera_ray(&s->view.camera, ISO_CALIBRATION_PIXELS, ISO_CALIBRATION_PIXELS,
                                     i % ISO_CALIBRATION_PIXELS, i / ISO_CALIBRATION_PIXELS);
        iso_vec3 index = iso_geometry_to_index(&g, ray.origin);
        double rgbs[4];
        iso_tf_lookup(&s->view.tf, ramp_along_x(&g, index), rgbs);
        iso_calibration_expect_pixel(s, i % ISO_CALIBRATION_PIXELS, i / ISO_CALIBRATION_PIXELS, rgbs, 1);
    }
    return ISO_OK;
}

/* ---- order: the color and nothing else changes along the ray ---- */

/* Returns the integral of sigma exp(-sigma t) (from + (to - from) t / length) dt over a piece, times the transmittance
 * at its start. */
static double colored_piece(double through, double sigma, double length, double from, double to)
{
    const double slope = length > 0 ? (to - from) / length : 0;
    return through * (from + slope / sigma - exp(-sigma * length) * (to + slope / sigma));
}

/* Adds a pixel's expected color. The value is a ramp along x, clamped half a voxel before both faces: at most three
 * pieces, linear each. */
static void expect_colors(iso_calibration_stage *s, size_t column, size_t row, const double first[3],
                          const double last[3], double sigma)
{
    const iso_geometry *g = &s->pyramid.levels[0].geometry;
    const iso_ray ray = iso_camera_ray(&s->view.camera, ISO_CALIBRATION_PIXELS, ISO_CALIBRATION_PIXELS, column, row);
    const double ramp = (double)g->size[0] - 1;
    double t[4], x[2];
    if (!iso_ray_box(&ray, g, &t[0], &t[3]))
        return;
    for (int end = 0; end < 2; ++end)
        x[end] = iso_geometry_to_index(g, iso_madd(ray.origin, ray.direction, t[3 * end])).x - 0.5;
    for (int i = 0; i < 2; ++i) { /* where the ramp begins and ends, in the order of the ray */
        const double bend = (i == 0) == (x[1] > x[0]) ? 0 : ramp;
        t[1 + i] = fmin(fmax(t[0] + (bend - x[0]) / (x[1] - x[0]) * (t[3] - t[0]), t[0]), t[3]);
    }
    float *p = s->expected.rgba + 4 * (row * ISO_CALIBRATION_PIXELS + column);
    for (int c = 0; c < 3; ++c)
        for (int i = 0; i < 3; ++i) {
            double color[2];
            for (int end = 0; end < 2; ++end) {
                const double at = x[0] + (x[1] - x[0]) * (t[i + end] - t[0]) / (t[3] - t[0]);
                color[end] = first[c] + (last[c] - first[c]) * fmin(fmax(at / ramp, 0), 1);
            }
            p[c] += (float)colored_piece(exp(-sigma * (t[i] - t[0])), sigma, t[i + 1] - t[i], color[0], color[1]);
        }
    p[3] = (float)-expm1(-sigma * (t[3] - t[0]));
}

static iso_status prepare_order(iso_calibration_stage *s, iso_error *err)
{
    const double first[3] = {1, 0.25, 0.125}, last[3] = {0.125, 0.5, 1}, sigma = 0.25;
    iso_geometry g = iso_calibration_turned_grid(9, 7, 12);
    NEED(iso_calibration_stage_set(s, &g, ramp_along_x, err));
    s->view.camera = iso_calibration_look(iso_v3(1, 1.6, -0.7), 0.14, false); /* no ray is parallel to a face */
    for (size_t i = 0; i < ISO_CALIBRATION_TF_ENTRIES; ++i) {
        float color[3];
        for (int c = 0; c < 3; ++c)
            color[c] = (float)(first[c] + (last[c] - first[c]) * (double)i / (ISO_CALIBRATION_TF_ENTRIES - 1));
        iso_calibration_set_entry(&s->view, i, color[0], color[1], color[2], (float)sigma);
    }
    for (size_t i = 0; i < ISO_CALIBRATION_PIXELS * ISO_CALIBRATION_PIXELS; ++i)
        expect_colors(s, i % ISO_CALIBRATION_PIXELS, i / ISO_CALIBRATION_PIXELS, first, last, sigma);
    return ISO_OK;
}

/* ---- shading: the equation of scene.h ---- */

static double expected_shade(const iso_view *view, const double n[3], iso_vec3 to_viewer)
{
    const iso_vec3 normal = iso_v3(n[0], n[1], n[2]), light = view->lights[0].direction;
    const double highlight = fabs(iso_dot(normal, iso_normalize(iso_add(light, to_viewer))));
    return view->shading.ambient + view->shading.diffuse * fabs(iso_dot(normal, light)) +
           view->shading.specular * pow(highlight, view->shading.power);
}

/* Rounds a direction by the code: the expected picture is shaded with the rounded direction. */
static void coded_direction(iso_code code, const float direction[3], uint8_t bytes[3], double d[3])
{
    double e[3];
    iso_code_encode(code, direction, bytes, 1);
    iso_code_lattice(code, bytes, e);
    iso_code_decode(code, e, d);
}

static double tilted_ramp(const iso_geometry *g, iso_vec3 index)
{
    iso_vec3 world = iso_geometry_to_world(g, index);
    return 0.5 + 0.03 * world.x - 0.01 * world.y + 0.02 * world.z;
}

static iso_status prepare_linear_field(iso_calibration_stage *s, const iso_camera *camera, const iso_shading *shading,
                                       iso_error *err)
{
    iso_geometry g = iso_calibration_turned_grid(9, 7, 12);
    NEED(iso_calibration_stage_set(s, &g, tilted_ramp, err));
    s->view.camera = *camera;
    s->view.shading = *shading;
    for (size_t i = 0; i < ISO_CALIBRATION_TF_ENTRIES; ++i)
        iso_calibration_set_entry(&s->view, i, 0.9f, 0.5f, 0.2f, 0.9f);
    /* The gradient of the field is (3, -1, 2) / 100 per mm in the world. */
    const float direction[3] = {3 / sqrtf(14), -1 / sqrtf(14), 2 / sqrtf(14)};
    uint8_t bytes[3];
    double d[3], n[3];
    coded_direction(s->pyramid.options.code, direction, bytes, d);
    iso_code_normal(d, n);
    for (size_t i = 0; i < ISO_CALIBRATION_PIXELS * ISO_CALIBRATION_PIXELS; ++i) {
        const double rgbs[4] = {(double)0.9f, 0.5, (double)0.2f, (double)0.9f};
        const iso_ray ray = iso_camera_ray(&s->view.camera, ISO_CALIBRATION_PIXELS, ISO_CALIBRATION_PIXELS,
                                           i % ISO_CALIBRATION_PIXELS, i / ISO_CALIBRATION_PIXELS);
        iso_calibration_expect_pixel(s, i % ISO_CALIBRATION_PIXELS, i / ISO_CALIBRATION_PIXELS, rgbs,
                                     expected_shade(&s->view, n, iso_scale(ray.direction, -1)));
    }
    return ISO_OK;
}

static iso_status prepare_light(iso_calibration_stage *s, iso_error *err)
{
    const iso_camera camera = iso_calibration_look(iso_v3(1, -0.6, 0.9), 7,
                                                   true); /* the gradient looks away from light and viewer */
    const iso_shading shading = {.ambient = 0.2, .diffuse = 0.8, .specular = 0.9, .power = 2};
    return prepare_linear_field(s, &camera, &shading, err);
}

/* Places the camera so near that the highlight differs in each pixel. */
static iso_status prepare_view_vector(iso_calibration_stage *s, iso_error *err)
{
    const iso_shading shading = {.ambient = 0.1, .diffuse = 0.2, .specular = 0.9, .power = 6};
    iso_camera camera = iso_calibration_look(iso_v3(0.5, 0.6, 1), 0.25, false);
    camera.position = iso_scale(camera.forward, -30);
    return prepare_linear_field(s, &camera, &shading, err);
}

/* Alternates two directions at right angles along x, one of them half as long. Columns of pixels show the way from one
 * to the next, each a single shade along its ray. */
static iso_status prepare_interpolation(iso_calibration_stage *s, iso_error *err)
{
    const size_t size[3] = {9, 6, 8};
    const double spacing[3] = {1, 1, 1};
    const float direction[2][3] = {{1, 0, 0}, {0, 0.3f, 0.4f}};
    iso_geometry g = iso_geometry_axis_aligned(size, spacing);
    NEED(iso_calibration_stage_set(s, &g, half, err));
    s->view.camera = iso_calibration_look(iso_v3(0, 1, 0), 4.5, true);
    s->view.lights[0].direction = iso_normalize(iso_v3(1, 0.3, 0.8));
    s->view.shading = (iso_shading){.ambient = 0.1, .diffuse = 0.8, .specular = 0.3, .power = 2};
    uint8_t bytes[2][3];
    double d[2][3];
    for (int i = 0; i < 2; ++i)
        coded_direction(s->pyramid.options.code, direction[i], bytes[i], d[i]);
    for (size_t i = 0; i < iso_geometry_voxel_count(&g); ++i)
        memcpy(s->pyramid.levels[0].codes + 3 * i, bytes[i % size[0] % 2], 3);
    for (size_t i = 0; i < ISO_CALIBRATION_TF_ENTRIES; ++i)
        iso_calibration_set_entry(&s->view, i, 0.9f, 0.5f, 0.2f, 0.5f);
    for (size_t i = 0; i < ISO_CALIBRATION_PIXELS * ISO_CALIBRATION_PIXELS; ++i) {
        const double rgbs[4] = {(double)0.9f, 0.5, (double)0.2f, 0.5};
        const iso_ray ray = iso_camera_ray(&s->view.camera, ISO_CALIBRATION_PIXELS, ISO_CALIBRATION_PIXELS,
                                           i % ISO_CALIBRATION_PIXELS, i / ISO_CALIBRATION_PIXELS);
        const double x = fmin(fmax(iso_geometry_to_index(&g, ray.origin).x - 0.5, 0), (double)size[0] - 1);
        const double second = fabs(x - 2 * floor((x + 1) / 2)); /* the share of the odd voxel */
        double mean[3], n[3];
        for (int a = 0; a < 3; ++a)
            mean[a] = (1 - second) * d[0][a] + second * d[1][a];
        iso_code_normal(mean, n);
        iso_calibration_expect_pixel(s, i % ISO_CALIBRATION_PIXELS, i / ISO_CALIBRATION_PIXELS, rgbs,
                                     expected_shade(&s->view, n, iso_scale(ray.direction, -1)));
    }
    return ISO_OK;
}

static const struct {
    iso_calibration blank;
    unsigned needs;   /* iso_trait */
    const char *open; /* what stays open if the check is not made */
    iso_status (*prepare)(iso_calibration_stage *s, iso_error *err);
    double (*judge)(iso_calibration_stage *s, const iso_renderer_info *which); /* its value, of s->got */
} checks[ISO_CALIBRATION_COUNT] = {
    {{.check = "placement",
      .unit = "pixel",
      .limit = 0.02,
      .why = "the blob is sampled at 32 x 32 pixels; half a voxel would be 0.6 pixel or more"},
     ISO_HAS_ORTHOGRAPHIC,
     "where the volume stands, by half a voxel",
     prepare_placement,
     judge_placement},
    {{.check = "slab",
      .unit = "largest difference",
      .limit = 2e-4,
      .why = "marching adds up to one rounding of the step at the box's faces; 1 % of extinction would be 3e-3"},
     0,
     "extinction per millimeter, and how long rays are",
     prepare_slab,
     iso_calibration_largest_difference},
    {{.check = "transfer function",
      .unit = "largest difference",
      .limit = 5e-4,
      .why = "tables are looked up in float or through 16-bit files; an sRGB table would be off by 0.1"},
     ISO_HAS_ORTHOGRAPHIC,
     "how the table is looked up, and that its colors are linear light",
     prepare_transfer_function,
     iso_calibration_largest_difference},
    {{.check = "light",
      .unit = "largest difference",
      .limit = 5e-4,
      .why = "directions travel as bytes, floats or 16-bit files; a mirrored axis would be off by 0.1"},
     ISO_HAS_ORTHOGRAPHIC | ISO_HAS_LIGHTS,
     "how gradients come to the world, and from where the light comes",
     prepare_light,
     iso_calibration_largest_difference},
    {{.check = "order",
      .unit = "largest difference",
      .limit = 5e-4,
      .why =
          "a color that changes along the ray is summed up in steps of a quarter of a voxel; reversed it is off by 0.1"},
     0,
     "whether near samples cover far ones",
     prepare_order,
     iso_calibration_largest_difference},
    {{.check = "view vector",
      .unit = "largest difference",
      .limit = 5e-4,
      .why = "directions travel as bytes, floats or 16-bit files; one view vector for all pixels would be off by 0.1"},
     ISO_HAS_LIGHTS,
     "the direction to the eye, pixel by pixel",
     prepare_view_vector,
     iso_calibration_largest_difference},
    {{.check = "interpolation",
      .unit = "largest difference",
      .limit = 5e-4,
      .why = "directions travel as bytes, floats or 16-bit files; those not normalized again would be off by 0.1"},
     ISO_HAS_ORTHOGRAPHIC | ISO_HAS_LIGHTS,
     "how directions are filtered",
     prepare_interpolation,
     iso_calibration_largest_difference},
};

int iso_calibration_number(const char *check)
{
    int i = 0;
    while (i + 1 < ISO_CALIBRATION_COUNT && strcmp(checks[i].blank.check, check) != 0)
        ++i;
    return i;
}

const char *iso_calibration_name(int check)
{
    return checks[check].blank.check;
}

static const char *lacking(const iso_renderer_info *which, int check)
{
    const unsigned lacks = checks[check].needs & ~which->traits;
    return lacks & ISO_HAS_LIGHTS ? "lights" : lacks ? "orthographic views" : NULL;
}

/* Widens the limit by the quantization error and by the error that the renderer states. A centroid of this many
 * ISO_CALIBRATION_PIXELS is accurate to a tenth of a pixel. */
static void widen_limit(const iso_renderer_info *which, iso_calibration *c)
{
    if (which->output.half && strcmp(c->unit, "pixel") != 0) { /* their colors are at most 1 */
        c->limit += iso_half_rounding(1);
        snprintf(c->why, sizeof c->why, "half floats: %.400s", which->lock_step->why);
    }
    const double stated = !which->output.most             ? 0
                          : strcmp(c->unit, "pixel") == 0 ? 0.1
                                                          : which->lock_step->smooth.max_abs;
    if (stated <= c->limit)
        return;
    c->limit = stated;
    snprintf(c->why, sizeof c->why, "%u bits a channel: %.400s", which->output.bits, which->lock_step->why);
}

/* Fills in the requirements of a check before anything is drawn. */
static void begin(const iso_renderer_info *which, int check, iso_calibration *out)
{
    *out = checks[check].blank;
    out->lacks = lacking(which, check);
    out->value = NAN;
    widen_limit(which, out);
}

/* Judges the drawn picture. */
static void judge(iso_calibration_stage *s, const iso_renderer_info *which, int check, iso_calibration *out)
{
    out->value = checks[check].judge(s, which);
    out->passed = out->value <= out->limit; /* NaN does not pass */
}

iso_status iso_calibration_prepare(int check, iso_calibration_stage *s, iso_error *err)
{
    return checks[check].prepare(s, err);
}

iso_status iso_calibration_picture(iso_renderers *r, const iso_renderer_info *which, int check, iso_image *image,
                                   iso_error *err)
{
    iso_calibration_stage s = {0};
    char scene[64];
    *image = (iso_image){0};
    if (lacking(which, check))
        return ISO_OK;
    snprintf(scene, sizeof scene, "calibration-%s", iso_calibration_name(check));
    iso_status status = checks[check].prepare(&s, err);
    r->scene = scene;
    TRY(status, iso_calibration_render(&s, 1, r, which, NULL, err));
    r->scene = NULL;
    *image = s.got;
    s.got = (iso_image){0};
    iso_calibration_stage_clear(&s);
    return status == ISO_E_MISSING ? ISO_OK : status;
}

iso_status iso_calibrate_check(iso_renderers *r, const iso_renderer_info *which, const iso_calibration_fault *fault,
                               int check, iso_calibration *out, iso_error *err)
{
    iso_calibration_stage s = {0};
    begin(which, check, out);
    if (out->lacks)
        return ISO_OK;
    char scene[64];
    snprintf(scene, sizeof scene, "calibration-%s", out->check);
    iso_status status = checks[check].prepare(&s, err);
    r->scene = scene;
    TRY(status, iso_calibration_render(&s, 1, r, which, fault, err));
    r->scene = NULL;
    if (status == ISO_OK)
        judge(&s, which, check, out);
    if (status == ISO_E_MISSING && iso_renderer_has(which, ISO_IS_OF_PICTURES)) {
        out->no_picture = checks[check].open;
        status = ISO_OK;
    }
    iso_calibration_stage_clear(&s);
    return status == ISO_OK ? ISO_OK : iso_fail_in(err, status, "calibration of %s", which->name);
}

/* Makes all checks by one start. If that fails, makes them one after the other, to identify the failing check. */
static iso_status calibrate_together(iso_renderers *r, const iso_renderer_info *which,
                                     const iso_calibration_fault *fault, iso_calibration out[ISO_CALIBRATION_COUNT],
                                     iso_error *err)
{
    iso_calibration_stage stages[ISO_CALIBRATION_COUNT] = {{.got = {0}}};
    int asked[ISO_CALIBRATION_COUNT], count = 0;
    iso_status status = ISO_OK;
    for (int i = 0; i < ISO_CALIBRATION_COUNT && status == ISO_OK; ++i) {
        begin(which, i, &out[i]);
        if (!out[i].lacks) {
            status = checks[i].prepare(&stages[count], err);
            asked[count++] = i;
        }
    }
    TRY(status, iso_calibration_render(stages, (size_t)count, r, which, fault, err));
    for (int k = 0; k < count; ++k) {
        if (status == ISO_OK)
            judge(&stages[k], which, asked[k], &out[asked[k]]);
        iso_calibration_stage_clear(&stages[k]);
    }
    return status;
}

iso_status iso_calibrate(iso_renderers *r, const iso_renderer_info *which, const iso_calibration_fault *fault,
                         iso_calibration out[ISO_CALIBRATION_COUNT], size_t *made, iso_error *err)
{
    iso_error why = {""};
    iso_status status = which->render_scenes ? calibrate_together(r, which, fault, out, &why) : ISO_OK;
    *made = which->render_scenes && status == ISO_OK ? ISO_CALIBRATION_COUNT : 0;
    if (status != ISO_OK && iso_process_was_stopped()) /* a stop is not a failure of a check */
        return iso_fail(err, status, "calibration of %s: %s", which->name, why.text);
    status = ISO_OK;
    for (; *made < ISO_CALIBRATION_COUNT && status == ISO_OK; *made += status == ISO_OK)
        status = iso_calibrate_check(r, which, fault, (int)*made, &out[*made], err);
    return status;
}

/* SPDX-License-Identifier: MIT */
/* What single precision may change of a picture: the bound is the closed form's, holds for the ray caster, and rejects
 * what is no rounding. */
#include "render/reference.h"
#include "test.h"
#include "validate/rounding.h"
#include "validate/validate.h"
#include "volume/synthetic.h"

enum { pixels = 32 };

static iso_renderers renderers;

static int end_renderers(void **state)
{
    (void)state;
    iso_renderers_end(&renderers);
    return 0;
}

typedef struct subject {
    iso_pyramid pyramid;
    iso_view view;
} subject;

/* Seen along z, orthographic, the whole picture within the box; a TF of two slopes: 0 up to entry `from`, and
 * `extinction` at entry `to` and beyond it. One color, ambient light alone unless it is lit. */
static subject open_subject(const iso_volume *volume, size_t entries, size_t from, size_t to, double extinction, bool lit)
{
    subject s = {.view = {.width = pixels,
                          .height = pixels,
                          .step_voxels = 0.5,
                          .light_count = 1,
                          .lights = {{.direction = {0, 0.6, -0.8}, .intensity = 1}},
                          .shading = {.ambient = lit ? 0.3 : 1, .diffuse = lit ? 0.7 : 0, .power = 1}}};
    iso_pyramid_options build = iso_pyramid_defaults();
    iso_camera *c = &s.view.camera;
    build.level_count = 1;
    assert_ok(iso_pyramid_build(volume, "rounding", &build, &s.pyramid, NULL, &err));
    const iso_geometry *g = &s.pyramid.levels[0].geometry;
    *c = (iso_camera){.orthographic = true, .forward = {0, 0, 1}, .right = {1, 0, 0}, .up = {0, -1, 0}};
    c->half_height = 0.4 * (double)g->size[1] * iso_geometry_min_spacing_mm(g);
    c->position = iso_madd(iso_geometry_box_center_mm(g), c->forward, -200);
    s.view.tf = (iso_tf_table){.count = entries,
                               .lo = s.pyramid.levels[0].min,
                               .hi = s.pyramid.levels[0].max,
                               .entries = calloc(entries, 4 * sizeof(float))};
    for (size_t i = 0; i < entries; ++i) {
        const double part = i <= from ? 0 : i >= to ? 1 : (double)(i - from) / (double)(to - from);
        const float e[4] = {0.5f, 0.5f, 0.5f, (float)(extinction * part)};
        memcpy(s.view.tf.entries + 4 * i, e, sizeof e);
    }
    return s;
}

static void close_subject(subject *s)
{
    iso_view_destroy(&s->view);
    iso_pyramid_destroy(&s->pyramid);
}

static iso_volume ramp_along_z(const size_t size[3], double spacing)
{
    const iso_geometry g = iso_geometry_axis_aligned(size, (double[]){spacing, spacing, spacing});
    iso_volume v;
    assert_ok(iso_volume_create(&v, &g, ISO_F32, "ramp", &err));
    for (size_t i = 0; i < iso_geometry_voxel_count(&g); ++i)
        ((float *)v.data)[i] = (float)(i / (size[0] * size[1]));
    return v;
}

static iso_sample_error bound(const subject *s, bool float_rays)
{
    iso_sample_error most;
    assert_ok(iso_rounding_bound(&s->pyramid.levels[0], s->pyramid.options.code, &s->view, ISO_FROM_CODES, float_rays,
                                 1, &most, &err));
    return most;
}

static iso_sample_error bound_of(const subject *s)
{
    return bound(s, false);
}

/* Extinction grows with z from 0 to S, so little that T is 1. Its slope is S / (n - 1) per voxel. Rounding moves a
 * sample by n 2^-24 voxels, but not in the half voxels at both faces, where the value is constant; and the value by 4 x
 * 2^-24 of n - 1. The opacity is off by the integral of both, a color of 1/2 by half of that. Rays in floats move it by
 * 4 x 2^-24 of its distance from the eye, which is 200 mm before the center, too. */
TEST(the_bound_of_a_ramp_is_the_closed_form)
{
    const size_t size[3] = {12, 14, 41};
    const double h = 0.7, extinction = 1e-4, n = (double)size[2], step = ldexp(1, -24);
    const iso_volume v = ramp_along_z(size, h);
    ENDED_BY(close_subject) subject s = open_subject(&v, 65, 0, 64, extinction, false);
    const double opacity = h * extinction * step * ((n - 1) * n / (n - 1) + n * 4);
    const iso_sample_error most = bound_of(&s);
    assert_within(most.max_abs / opacity, 1, 0.01); /* 1 - T is .003 here; steps end at the faces of voxels */
    assert_within(most.rmse / (opacity * sqrt((3 * 0.25 + 1) / 4)), 1, 0.01);
    assert_within(bound(&s, true).max_abs / (opacity + h * extinction * step * 4 * 200 / h), 1, 0.01);
    iso_volume_destroy((iso_volume *)&v);
}

static iso_image picture(const subject *s, const iso_renderer_info *by)
{
    iso_image image;
    iso_render_options opt = iso_render_defaults(by);
    opt.quadrature = ISO_QUADRATURE_MIDPOINT;
    assert_ok(iso_render_with(&(iso_render_request){&renderers, &s->pyramid, 0, &s->view, &opt, NULL}, &image, NULL, &err));
    return image;
}

static iso_metrics difference(const iso_image *a, const iso_image *b)
{
    iso_metrics m;
    assert_ok(iso_metrics_measure(a, b, &m, &err));
    return m;
}

/* The limits that validation has for usual lookups. */
static iso_sample_error limits_of(const subject *s)
{
    const iso_sample_error most = bound_of(s), usual = iso_renderer_gl.lock_step->rounded;
    return (iso_sample_error){fmax(most.rmse, usual.rmse), fmax(most.max_abs, usual.max_abs)};
}

static double rmse_of_a_shifted_table(const subject *s, double entries)
{
    subject other = *s; /* borrows */
    const double shift = entries * (s->view.tf.hi - s->view.tf.lo) / (double)(s->view.tf.count - 1);
    other.view.tf.lo += shift;
    other.view.tf.hi += shift;
    OWNED(iso_image) a = picture(s, &iso_renderer_reference), b = picture(&other, &iso_renderer_reference);
    const double rmse = difference(&a, &b).rmse;
    return rmse;
}

static double rmse_of_a_moved_eye(const subject *s, double voxels)
{
    subject other = *s; /* borrows */
    other.view.camera.position.x += voxels * iso_geometry_min_spacing_mm(&s->pyramid.levels[0].geometry);
    OWNED(iso_image) a = picture(s, &iso_renderer_reference), b = picture(&other, &iso_renderer_reference);
    const double rmse = difference(&a, &b).rmse;
    return rmse;
}

/* The smallest shift of the table that the limit rejects, in entries, within a factor of 1.1. */
static double smallest_rejected(const subject *s, double limit)
{
    double lo = 1e-9, hi = 0.5;
    while (hi > 1.1 * lo) {
        const double middle = sqrt(lo * hi);
        *(rmse_of_a_shifted_table(s, middle) > limit ? &hi : &lo) = middle;
    }
    return hi;
}

static iso_volume sampled(iso_field_kind kind)
{
    const iso_field field = {.kind = kind,
                             .seed = 5,
                             .geometry = iso_geometry_axis_aligned((size_t[]){24, 26, 22}, (double[]){1, 1.2, 0.9})};
    iso_volume v;
    assert_ok(iso_field_sample(&field, ISO_F32, &v, &err));
    return v;
}

/* From smooth to one entry wide: what the ray caster does with the same samples is within the bound, or within what the
 * rest of its arithmetic is allowed, 5e-7 and 1e-5. */
TEST(the_ray_caster_is_within_the_bound)
{
    const iso_field_kind kinds[] = {ISO_FIELD_NOISE, ISO_FIELD_TUBES, ISO_FIELD_BALLS};
    const size_t widths[] = {40, 8, 1};
    const iso_sample_error rest = iso_renderer_gl.lock_step->exact;
    for (size_t k = 0; k < 3; ++k)
        for (size_t w = 0; w < 3; ++w) {
            OWNED(iso_volume) v = sampled(kinds[k]);
            ENDED_BY(close_subject) subject s = open_subject(&v, 64, 20, 20 + widths[w], 2, true);
            const iso_sample_error most = bound_of(&s);
            OWNED(iso_image) a = picture(&s, &iso_renderer_reference), b = picture(&s, &iso_renderer_gl);
            const iso_metrics m = difference(&a, &b);
            if (!(m.rmse <= most.rmse + rest.rmse) || !(m.max_abs <= most.max_abs + rest.max_abs))
                fail_msg("kind %zu, %zu entries: RMSE %g of %g, largest %g of %g", k, widths[w], m.rmse, most.rmse,
                         m.max_abs, most.max_abs);
        }
}

/* Ordinary tables keep their limit, so that what it finds is as small as before. Steep ones have a wider one: the
 * smallest shift of the table that is rejected is still less than a tenth of the half entry that a wrong lookup is off
 * by. With rays in floats, a shift of half a voxel is 20 times the limit, one of a hundredth is rejected. */
TEST(what_is_no_rounding_is_rejected)
{
    const double usual = iso_renderer_gl.lock_step->rounded.rmse;
    OWNED(iso_volume) v = sampled(ISO_FIELD_NOISE);
    ENDED_BY(close_subject) subject ordinary = open_subject(&v, 256, 60, 200, 0.3, true),
                                    steep = open_subject(&v, 1024, 512, 513, 9, true);
    assert_true(limits_of(&ordinary).rmse == usual);
    assert_more_than(bound_of(&steep).rmse, usual); /* else this shows nothing */
    assert_at_most(smallest_rejected(&ordinary, limits_of(&ordinary).rmse), 0.01);
    assert_at_most(smallest_rejected(&steep, limits_of(&steep).rmse), 0.05);
    assert_more_than(rmse_of_a_shifted_table(&ordinary, 0.5), 20 * limits_of(&ordinary).rmse);
    assert_more_than(rmse_of_a_shifted_table(&steep, 0.5), 5 * limits_of(&steep).rmse);
    assert_more_than(rmse_of_a_moved_eye(&steep, 0.5), 20 * bound(&steep, true).rmse);
    assert_more_than(rmse_of_a_moved_eye(&steep, 0.01), bound(&steep, true).rmse);
}

TEST_MAIN(NULL, end_renderers)

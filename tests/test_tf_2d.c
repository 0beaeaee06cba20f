/* SPDX-License-Identifier: MIT */
/* 2D transfer functions: what the second value is, and that every renderer looks up one definition. Sizes and
 * spacings are unequal, the grid is rotated. */
#include "rendered.h"
#include "test.h"
#include "cycles.h"

#include "renderers/renderers.h"
#include "compare/metrics.h"
#include "scene/scene.h"
#include "tf/adapt.h"
#include "volume/synthetic.h"

/* The ray caster: samples in float, some 100 a ray. POV-Ray: 16 bits a channel, half a step is 7.6e-6 of the brightest
 * color. Cycles: the error of a step of an eighth of a voxel, of second order; the sixteenth has a quarter of it. */
#define GL_MAX_ABS 2e-5
#define GL_RMSE 1e-6
#define POVRAY_MAX_ABS 2e-5
#define CYCLES_RMSE 4e-4

static iso_pyramid noise_pyramid(void)
{
    const iso_field field = {.kind = ISO_FIELD_NOISE, .geometry = rotated_geometry(22, 27, 17), .seed = 3};
    return build_field(&field, 2);
}

/* Soft, in colors that differ; a second light and highlights, so that nothing is left out. */
static iso_view make_view(const iso_pyramid *p)
{
    static iso_tf_point points[] = {{0, {0.9, 0.3, 0.2}, 0},
                                    {0.3, {0.9, 0.3, 0.2}, 0},
                                    {0.55, {0.9, 0.8, 0.3}, 0.2},
                                    {0.7, {0.2, 0.5, 0.9}, 0.02},
                                    {1, {0.3, 0.9, 0.5}, 0.3}};
    iso_scene scene = scene_of_points(points, 5);
    scene.light_count = 2;
    scene.lights[0].intensity = 0.8;
    scene.lights[1] = (iso_light){.direction = {0, 0, 1}, .in_camera_space = true, .intensity = 0.2};
    return view_of(&scene, p);
}

static iso_tf_2d adapt(const iso_pyramid *p, iso_second_value second, const iso_view *view)
{
    const iso_adapt_options opt = iso_adapt_defaults();
    iso_tf_2d t;
    assert_ok(iso_adapt_tf_2d(p, 1, second, &view->tf, &opt, &t, &err));
    return t;
}

/* ---- planted faults -------------------------------------------------------------------- */

typedef enum fault { SWAPPED_AXES, HALF_A_ROW_OFF, FIRST_ROW_ALONE, FAULT_COUNT } fault;

static size_t voxel_count(const iso_pyramid *p)
{
    return iso_geometry_voxel_count(&p->levels[1].geometry);
}

static iso_tf_2d with_fault(const iso_tf_2d *t, const iso_pyramid *p, fault which)
{
    iso_tf_2d bad = *t;
    const size_t count = t->rows[0].count, last = count - 1;
    bad.bytes = malloc(voxel_count(p));
    for (size_t i = 0; i < voxel_count(p); ++i) {
        int byte = t->bytes[i] + (which == HALF_A_ROW_OFF ? 255 / (2 * (ISO_TF_2D_ROWS - 1)) : 0);
        bad.bytes[i] = (uint8_t)(which == FIRST_ROW_ALONE ? 0 : byte < 255 ? byte : 255);
    }
    for (size_t c = 0; c < ISO_TF_2D_ROWS; ++c) {
        bad.rows[c].entries = malloc(4 * count * sizeof(float));
        memcpy(bad.rows[c].entries, t->rows[c].entries, 4 * count * sizeof(float));
        for (size_t i = 0; i < count && which == SWAPPED_AXES; ++i) {
            double rgbs[4], value = t->rows[0].lo + (t->rows[0].hi - t->rows[0].lo) * (double)c / (ISO_TF_2D_ROWS - 1);
            iso_tf_2d_lookup(t, value, (double)i / (double)last * (ISO_TF_2D_ROWS - 1), rgbs);
            for (size_t k = 0; k < 4; ++k)
                bad.rows[c].entries[4 * i + k] = (float)rgbs[k];
        }
    }
    return bad;
}

/* ---- renderers ------------------------------------------------------------------------- */

static iso_image render(const iso_pyramid *p, const iso_view *own, iso_tf_2d *tf_2d, const iso_render_options *opt)
{
    iso_view view = *own; /* lent */
    iso_image image;
    view.tf_2d = tf_2d;
    assert_ok(iso_render_with(&(iso_render_request){&renderers, p, 1, &view, opt, NULL}, &image, NULL, &err));
    return image;
}

static iso_metrics compare(const iso_image *a, const iso_image *b)
{
    iso_metrics m;
    assert_ok(iso_metrics_measure(a, b, &m, &err));
    return m;
}

/* The renderer meets the reference on both tables, and no faulty table of the reference would have passed. */
static void check_renderer(const iso_render_options *with, const iso_render_options *reference, double max_abs,
                           double rmse)
{
    OWNED(iso_pyramid) p = noise_pyramid();
    OWNED(iso_view) view = make_view(&p);
    for (int second = ISO_SECOND_VALUE_DEVIATION; second <= ISO_SECOND_VALUE_GRADIENT; ++second) {
        OWNED(iso_tf_2d) t = adapt(&p, (iso_second_value)second, &view);
        OWNED(iso_image) have = render(&p, &view, &t, with), want = render(&p, &view, &t, reference);
        iso_metrics m = compare(&have, &want);
        print_message("%s, second %d: rmse %.3g, max %.3g\n", with->renderer->name, second, m.rmse, m.max_abs);
        assert_at_most(m.max_abs, max_abs);
        assert_at_most(m.rmse, rmse);
        for (int f = 0; f < FAULT_COUNT; ++f) {
            OWNED(iso_tf_2d) bad = with_fault(&t, &p, (fault)f);
            OWNED(iso_image) wrong = render(&p, &view, &bad, reference);
            iso_metrics e = compare(&have, &wrong);
            assert_true(e.max_abs > max_abs || e.rmse > rmse);
            assert_more_than(e.rmse, 2.5 * rmse); /* with a margin */
        }
    }
}

TEST(the_ray_caster_looks_up_the_same_tables)
{
    iso_render_options gl = iso_render_defaults(&iso_renderer_gl),
                       reference = iso_render_defaults(&iso_renderer_reference);
    reference.quadrature = ISO_QUADRATURE_MIDPOINT;
    check_renderer(&gl, &reference, GL_MAX_ABS, GL_RMSE);
}

TEST(povray_looks_up_the_same_tables)
{
    iso_render_options povray = iso_render_defaults(&iso_renderer_povray),
                       reference = iso_render_defaults(&iso_renderer_reference);
    reference.quadrature = ISO_QUADRATURE_POVRAY;
    povray.intervals = reference.intervals = 60;
    check_renderer(&povray, &reference, POVRAY_MAX_ABS, 1e-5);
}

VALUES_TEST(cycles_looks_up_the_same_tables)
{
    need_cycles();
    iso_render_options cycles = iso_render_defaults(&iso_renderer_cycles),
                       reference = iso_render_defaults(&iso_renderer_reference);
    cycles.step_voxels = 0.125;
    check_renderer(&cycles, &reference, 1, CYCLES_RMSE);
}

/* ---- the table ------------------------------------------------------------------------- */

TEST(lookups_are_bilinear_and_clamped)
{
    float entries[ISO_TF_2D_ROWS][12];
    iso_tf_2d t = {.bytes = NULL};
    for (int c = 0; c < ISO_TF_2D_ROWS; ++c) {
        for (int i = 0; i < 12; ++i) /* bilinear in (entry, row), differently in each component */
            entries[c][i] = (float)(i % 4 + (1 + 0.5 * c) * (i / 4) + 0.25 * c * (i % 4));
        t.rows[c] = (iso_tf_table){.count = 3, .lo = 10, .hi = 20, .entries = entries[c]};
    }
    const double values[] = {8, 10, 12.5, 19, 25}, coordinates[] = {-1, 0, 0.3, 3, 6.75, 7, 9};
    for (int v = 0; v < 5; ++v)
        for (int k = 0; k < 7; ++k) {
            double rgbs[4], x = fmin(fmax((values[v] - 10) / 5, 0), 2), c = fmin(fmax(coordinates[k], 0), 7);
            iso_tf_2d_lookup(&t, values[v], coordinates[k], rgbs);
            for (int i = 0; i < 4; ++i)
                assert_within(rgbs[i], i + (1 + 0.5 * c) * x + 0.25 * c * i, 1e-12);
        }
    assert_within(iso_tf_2d_row_of(255), ISO_TF_2D_ROWS - 1, 0);
}

/* A ramp: a gradient of 3 a voxel along x, so 6 a voxel at level 1, on a range of 3 (n - 1). */
TEST(the_gradient_of_a_ramp_has_one_second_value)
{
    iso_geometry g = iso_geometry_axis_aligned((const size_t[]){16, 6, 4}, (const double[]){2, 1, 5});
    OWNED(iso_volume) v;
    OWNED(iso_pyramid) p;
    iso_pyramid_options opt = iso_pyramid_defaults();
    opt.level_count = 2;
    assert_ok(iso_volume_create(&v, &g, ISO_U8, "ramp", &err));
    for (size_t i = 0; i < 16 * 6 * 4; ++i)
        ((uint8_t *)v.data)[i] = (uint8_t)(3 * (i % 16));
    assert_ok(iso_pyramid_build(&v, "ramp", &opt, &p, NULL, &err));
    float tf_2d[8 * 3 * 2];
    assert_ok(iso_joint_second_coordinates(&p, 1, ISO_SECOND_VALUE_GRADIENT, 2, tf_2d, &err));
    for (int i = 0; i < 48; ++i)
        assert_within(tf_2d[i], 7 * sqrt(6 / 22.5), 1e-6); /* in float */
    assert_ok(iso_joint_second_coordinates(&p, 1, ISO_SECOND_VALUE_DEVIATION, 2, tf_2d, &err));
    for (int i = 0; i < 48; ++i)
        assert_within(tf_2d[i], 7 * sqrt(1.5 / 22.5), 1e-6); /* two values 3 apart */
}

TEST(the_envelope_bounds_every_row)
{
    OWNED(iso_pyramid) p = noise_pyramid();
    OWNED(iso_view) view = make_view(&p);
    OWNED(iso_tf_2d) t = adapt(&p, ISO_SECOND_VALUE_DEVIATION, &view);
    OWNED(iso_tf_table) envelope;
    assert_ok(iso_tf_2d_envelope(&t, &envelope, &err));
    for (size_t i = 0; i < 4 * envelope.count; ++i) {
        float largest = 0;
        for (size_t c = 0; c < ISO_TF_2D_ROWS; ++c)
            largest = fmaxf(largest, t.rows[c].entries[i]);
        assert_true(envelope.entries[i] == largest);
    }
}

TEST_MAIN(NULL, end_renderers)

/* SPDX-License-Identifier: MIT */
/* test_reference.c - the reference against closed forms. */
#include "render/reference.h"
#include "difference.h"
#include "test.h"

/* A level whose directions all point along +z of the world. */
static iso_level make_level(const size_t size[3], const double spacing[3], double (*value)(iso_vec3 world))
{
    iso_level level = {.geometry = iso_geometry_axis_aligned(size, spacing),
                       .stored_type = ISO_F32,
                       .min = 0,
                       .max = 1};
    size_t count = iso_geometry_voxel_count(&level.geometry), i = 0;
    level.scalar = malloc(count * sizeof(float));
    level.codes = malloc(3 * count);
    for (size_t z = 0; z < size[2]; ++z)
        for (size_t y = 0; y < size[1]; ++y)
            for (size_t x = 0; x < size[0]; ++x, ++i) {
                iso_vec3 index = {(double)x + 0.5, (double)y + 0.5, (double)z + 0.5};
                const float up[3] = {0, 0, 1};
                level.scalar[i] = (float)value(iso_geometry_to_world(&level.geometry, index));
                iso_code_encode(ISO_CODE_SNORM, up, level.codes + 3 * i, 1);
            }
    return level;
}

static void free_level(iso_level *level)
{
    free(level->scalar);
    free(level->codes);
}

/* Two entries over [0, 1]: value 0 and value 1. */
static float line_entries[8];
static iso_view make_view(iso_vec3 forward, const float entries[8])
{
    memcpy(line_entries, entries, sizeof line_entries);
    iso_vec3 helper = fabs(forward.z) < 0.9 ? iso_v3(0, 0, 1) : iso_v3(0, 1, 0);
    iso_view view = {
        .width = 5, .height = 4, .shading = {.ambient = 1, .power = 1}, .light_count = 1, .step_voxels = 0.25};
    view.lights[0] = (iso_light){.direction = {0, 0, 1}, .intensity = 1};
    view.camera = (iso_camera){.orthographic = true, .forward = forward, .half_height = 0.5};
    view.camera.right = iso_normalize(iso_cross(forward, helper));
    view.camera.up = iso_cross(view.camera.right, forward);
    view.camera.position = iso_scale(forward, -50);
    view.tf = (iso_tf_table){.count = 2, .lo = 0, .hi = 1, .entries = line_entries};
    return view;
}

static iso_image render(const iso_level *level, const iso_view *view, const iso_reference_options *opt)
{
    iso_image image;
    assert_ok(iso_reference_render(level, ISO_CODE_SNORM, view, opt, &image, NULL, &err));
    return image;
}

static double constant(iso_vec3 p)
{
    (void)p;
    return 0.5;
}
/* size 6 along z at spacing 2: voxel centers at -5 .. 5; 0.1 to 0.9 between them */
static double ramp(iso_vec3 p)
{
    return 0.5 + 0.08 * p.z;
}
static double paraboloid(iso_vec3 p)
{
    return fmax(0, 1 - iso_dot(p, p));
}

static const size_t small_size[3] = {4, 5, 6};
static const double small_spacing[3] = {1, 1.5, 2};

TEST(a_slab_has_the_opacity_of_its_thickness)
{
    const float entries[8] = {0.8f, 0.4f, 0.2f, 0.3f, 0.8f, 0.4f, 0.2f, 0.3f};
    ENDED_BY(free_level) iso_level level = make_level(small_size, small_spacing, constant);
    const iso_vec3 axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, -1}};
    const double thickness[3] = {4, 7.5, 12};
    for (int a = 0; a < 3; ++a) {
        iso_view view = make_view(axes[a], entries);
        view.background[1] = 0.5;
        for (int q = 0; q < 2; ++q) { /* converged and midpoint are both exact here */
            iso_reference_options opt = iso_reference_defaults();
            opt.quadrature = q ? ISO_QUADRATURE_MIDPOINT : ISO_QUADRATURE_CONVERGED;
            OWNED(iso_image) image = render(&level, &view, &opt);
            double alpha = 1 - exp(-(double)0.3f * thickness[a]);
            for (size_t i = 0; i < 20; ++i) { /* 1e-7: the image is float */
                assert_within(image.rgba[4 * i + 3], alpha, 1e-7);
                assert_within(image.rgba[4 * i], alpha * (double)0.8f, 1e-7);
                assert_within(image.rgba[4 * i + 1], alpha * (double)0.4f + (1 - alpha) * 0.5, 1e-7);
            }
        }
    }
}

static double a_third(iso_vec3 p)
{
    (void)p;
    return 1.0 / 3; /* no sum of parts of it is sure to be it again */
}

/* It has no gradient: what rounding leaves of its differences is none, and the light is ambient alone. */
TEST(a_constant_volume_has_no_direction_on_the_fly)
{
    const float entries[8] = {1, 1, 1, 0.3f, 1, 1, 1, 0.3f};
    ENDED_BY(free_level) iso_level level = make_level(small_size, small_spacing, a_third);
    level.min = level.max = (double)level.scalar[0];
    iso_view view = make_view(iso_normalize(iso_v3(1, 0.3, 0.2)), entries);
    view.shading = (iso_shading){.ambient = 0.25, .diffuse = 0.75, .power = 1};
    for (int q = 0; q < 2; ++q) {
        iso_reference_options opt = iso_reference_defaults();
        opt.quadrature = q ? ISO_QUADRATURE_MIDPOINT : ISO_QUADRATURE_CONVERGED;
        opt.source = ISO_FROM_ON_THE_FLY;
        OWNED(iso_image) image = render(&level, &view, &opt);
        for (size_t i = 0; i < 20; ++i)
            assert_within(image.rgba[4 * i], 0.25 * (double)image.rgba[4 * i + 3], 1e-7);
    }
}

/* The chord of an oblique ray through the middle of the box is closed as well. */
TEST(an_oblique_chord_counts_in_full)
{
    const float entries[8] = {1, 1, 1, 0.1f, 1, 1, 1, 0.1f};
    ENDED_BY(free_level) iso_level level = make_level(small_size, small_spacing, constant);
    iso_view view = make_view(iso_normalize(iso_v3(1, 0, 1)), entries);
    view.camera.half_height = 1e-6;
    iso_reference_options opt = iso_reference_defaults();
    OWNED(iso_image) image = render(&level, &view, &opt);
    assert_within(image.rgba[3], 1 - exp(-(double)0.1f * 4 * sqrt(2)), 2e-6); /* the pixels' own offsets */
}

/* Opacity of the ball with extinction s0 (1 - r^2) through its center: tau = s0 4/3. Trilinear
 * interpolation of r^2 is off by h^2 f (1 - f) an axis, so the error falls with h^2. */
static double sphere_error(size_t n)
{
    const size_t size[3] = {n, n, n};
    const double spacing[3] = {2.2 / (double)n, 2.2 / (double)n, 2.2 / (double)n};
    const float entries[8] = {1, 1, 1, 0, 1, 1, 1, 0.75f};
    ENDED_BY(free_level) iso_level level = make_level(size, spacing, paraboloid);
    iso_view view = make_view(iso_normalize(iso_v3(1, 2, 3)), entries);
    view.camera.half_height = 1e-9;
    iso_reference_options opt = iso_reference_defaults();
    OWNED(iso_image) image = render(&level, &view, &opt);
    double error = fabs((double)image.rgba[3] - (1 - exp(-1.0)));
    return error;
}

/* One entry of 1025: a shell of 1/40 of a cell, which no equal division by 2, 4 or 8 meets. */
TEST(a_shell_thinner_than_a_cell_is_met)
{
    float entries[4 * 1025] = {0};
    const size_t places[3] = {300, 481, 777};
    ENDED_BY(free_level) iso_level level = make_level(small_size, small_spacing, ramp);
    for (int i = 0; i < 3; ++i) {
        iso_view view = make_view(iso_v3(0, 0, -1), line_entries);
        view.tf = (iso_tf_table){.count = 1025, .lo = 0, .hi = 1, .entries = entries};
        entries[4 * places[i] + 3] = 50;
        iso_reference_options opt = iso_reference_defaults();
        OWNED(iso_image) image = render(&level, &view, &opt);
        /* a triangle of height 50/mm, one entry to either side; the ramp climbs 0.08 a mm; 1e-7: floats */
        assert_within(image.rgba[3], 1 - exp(-50 * (1.0 / 1024) / 0.08), 1e-7);
        entries[4 * places[i] + 3] = 0;
    }
}

TEST(a_sphere_converges_with_the_square_of_the_spacing)
{
    double coarse = sphere_error(20), fine = sphere_error(40);
    assert_at_most(fine, 2e-3);
    assert_within(coarse / fine, 4, 0.6); /* the order is 2; the ray's phase in the cells differs */
}

TEST(stepping_quadratures_converge_to_the_converged_one)
{
    const float entries[8] = {0, 0.2f, 1, 0, 1, 0.2f, 0, 2};
    const size_t size[3] = {12, 11, 10};
    const double spacing[3] = {0.18, 0.2, 0.22};
    ENDED_BY(free_level) iso_level level = make_level(size, spacing, paraboloid);
    iso_view view = make_view(iso_normalize(iso_v3(1, -2, 0.5)), entries);
    view.shading = (iso_shading){.ambient = 0.2, .diffuse = 0.6, .specular = 0.3, .power = 8};
    iso_reference_options opt = iso_reference_defaults();
    OWNED(iso_image) exact = render(&level, &view, &opt);
    double error[2][2];
    for (int fine = 0; fine < 2; ++fine) {
        opt.quadrature = ISO_QUADRATURE_MIDPOINT;
        opt.step_voxels = fine ? 0.125 : 0.25;
        OWNED(iso_image) a = render(&level, &view, &opt);
        opt.quadrature = ISO_QUADRATURE_POVRAY;
        opt.intervals = fine ? 160 : 80;
        OWNED(iso_image) b = render(&level, &view, &opt);
        error[0][fine] = difference_of(&a, &exact).max_abs;
        error[1][fine] = difference_of(&b, &exact).max_abs;
    }
    for (int q = 0; q < 2; ++q) {
        assert_at_most(error[q][1], 1e-3);
        assert_more_than(error[q][0] / error[q][1], 2.5); /* order 2, with the phase of knots and cell borders */
    }
}

TEST(threads_do_not_change_the_image)
{
    const float entries[8] = {0, 0.2f, 1, 0, 1, 0.2f, 0, 2};
    const size_t size[3] = {8, 7, 6};
    const double spacing[3] = {0.2, 0.2, 0.2};
    ENDED_BY(free_level) iso_level level = make_level(size, spacing, paraboloid);
    iso_view view = make_view(iso_normalize(iso_v3(1, -2, 0.5)), entries);
    iso_reference_options opt = iso_reference_defaults();
    opt.threads = 1;
    OWNED(iso_image) one = render(&level, &view, &opt);
    opt.threads = 3;
    OWNED(iso_image) three = render(&level, &view, &opt);
    assert_memory_equal(one.rgba, three.rgba, 4 * 5 * 4 * sizeof(float));
}

/* All directions are +z: a light from +z is full, one from the side is none, two-sided. */
TEST(light_follows_the_directions_in_the_world)
{
    const float entries[8] = {1, 1, 1, 5, 1, 1, 1, 5};
    ENDED_BY(free_level) iso_level level = make_level(small_size, small_spacing, constant);
    iso_view view = make_view(iso_v3(0, 1, 0), entries);
    view.shading = (iso_shading){.ambient = 0.25, .diffuse = 0.75, .power = 1};
    iso_reference_options opt = iso_reference_defaults();
    const iso_vec3 lights[3] = {{0, 0, 1}, {0, 0, -1}, {1, 0, 0}};
    const double expected[3] = {1, 1, 0.25};
    for (int i = 0; i < 3; ++i) {
        view.lights[0].direction = lights[i];
        OWNED(iso_image) image = render(&level, &view, &opt);
        assert_within(image.rgba[0], expected[i], 1e-4); /* eps = one code step: 3e-5; exp(-5 * 7.5) */
    }
}

TEST(floats_that_are_not_there_are_refused)
{
    const float entries[8] = {1, 1, 1, 5, 1, 1, 1, 5};
    ENDED_BY(free_level) iso_level level = make_level(small_size, small_spacing, constant);
    iso_view view = make_view(iso_v3(0, 1, 0), entries);
    iso_reference_options opt = iso_reference_defaults();
    iso_image image;
    opt.source = ISO_FROM_FLOAT;
    assert_status(iso_reference_render(&level, ISO_CODE_SNORM, &view, &opt, &image, NULL, &err), ISO_E_RANGE);
    opt = iso_reference_defaults();
    opt.tolerance = 0;
    assert_status(iso_reference_render(&level, ISO_CODE_SNORM, &view, &opt, &image, NULL, &err), ISO_E_RANGE);
}

TEST_MAIN(NULL, NULL)

/* SPDX-License-Identifier: MIT */
/* test_preintegration.c - means of a transfer function: against sums, against closed forms, and in both ray casters. */
#include "render/gl/raycaster.h"
#include "render/reference.h"
#include "difference.h"
#include "sampled.h"
#include "tf/integral.h"
#include "volume/synthetic.h"

/* A table with a narrow shell, a step and a plateau. */
enum { COUNT = 100 };
static float entries[4 * COUNT];
static iso_tf_table make_table(void)
{
    for (int i = 0; i < COUNT; ++i) {
        float *e = entries + 4 * i;
        e[0] = (float)(0.5 + 0.5 * sin(0.3 * i));
        e[1] = (float)i / COUNT;
        e[2] = i < 50 ? 1 : 0.25f;
        e[3] = i == 30 ? 5 : i >= 60 ? 0.3f : 0;
    }
    return (iso_tf_table){.count = COUNT, .lo = -3, .hi = 7, .entries = entries};
}

/* By brute force; a midpoint sum of piecewise parabolas. */
static void sum_mean(const iso_tf_table *tf, double a, double b, double mean[4])
{
    enum { n = 400000 };
    for (int c = 0; c < 4; ++c)
        mean[c] = 0;
    for (int i = 0; i < n; ++i) {
        double rgbs[4];
        iso_tf_lookup(tf, a + (b - a) * (i + 0.5) / n, rgbs);
        for (int c = 0; c < 3; ++c)
            mean[c] += rgbs[c] * rgbs[3] / n;
        mean[3] += rgbs[3] / n;
    }
}

TEST(means_are_those_of_a_fine_sum)
{
    static const double ends[][2] = {{-3, 7},    {7, -3}, {-0.3, 0.2}, {0.001, 0.0011}, {-0.02, 0.13}, {2.9, 3.4},
                                     {-20, 0.5}, {5, 40}, {-9, 30},    {-9, -5},        {8, 11}};
    iso_tf_table tf = make_table();
    OWNED(iso_tf_integral) integral;
    assert_ok(iso_tf_integral_create(&integral, &tf, &err));
    for (size_t i = 0; i < sizeof ends / sizeof *ends; ++i) {
        double mean[4], sum[4];
        iso_tf_integral_mean(&integral, ends[i][0], ends[i][1], mean);
        sum_mean(&tf, ends[i][0], ends[i][1], sum);
        for (int c = 0; c < 4; ++c)
            assert_within(mean[c], sum[c], 2e-6); /* the sum's own error at the bends */
    }
}

TEST(equal_values_give_the_transfer_function_itself)
{
    iso_tf_table tf = make_table();
    OWNED(iso_tf_integral) integral;
    assert_ok(iso_tf_integral_create(&integral, &tf, &err));
    for (double value = -4; value < 8; value += 0.0371) {
        double mean[4], rgbs[4];
        iso_tf_integral_mean(&integral, value, value, mean);
        iso_tf_lookup(&tf, value, rgbs);
        for (int c = 0; c < 4; ++c)
            assert_within(mean[c], c < 3 ? rgbs[c] * rgbs[3] : rgbs[3], 1e-12);
    }
}

/* ---- a ramp through a thin shell: the opacity is closed ------------------------------------------------------------- */

/* Value z in [0, 1] along z over 8 voxels of 1 mm; looked at along z. */
static iso_level make_ramp(void)
{
    const size_t size[3] = {3, 3, 8};
    const double spacing[3] = {1, 1, 1};
    iso_level level = {.geometry = iso_geometry_axis_aligned(size, spacing),
                       .stored_type = ISO_F32,
                       .min = 0,
                       .max = 1};
    level.scalar = malloc(72 * sizeof(float));
    level.codes = calloc(72, 3);
    for (size_t i = 0; i < 72; ++i)
        level.scalar[i] = (float)((double)(i / 9) / 7);
    return level;
}

static iso_view make_ramp_view(float *table)
{
    iso_view view = {.width = 2, .height = 2, .shading = {.ambient = 1, .power = 1}, .step_voxels = 1};
    view.camera = (iso_camera){.orthographic = true,
                               .forward = {0, 0, 1},
                               .right = {1, 0, 0},
                               .up = {0, -1, 0},
                               .half_height = 0.5,
                               .position = {0, 0, -50}};
    view.tf = (iso_tf_table){.count = 1001, .lo = 0, .hi = 1, .entries = table};
    return view;
}

static double alpha_of(const iso_level *level, const iso_view *view, iso_quadrature quadrature, double step)
{
    OWNED(iso_image) image;
    iso_reference_options opt = iso_reference_defaults();
    opt.quadrature = quadrature;
    opt.step_voxels = step;
    assert_ok(iso_reference_render(level, ISO_CODE_SNORM, view, &opt, &image, NULL, &err));
    double alpha = (double)image.rgba[3];
    return alpha;
}

/* A triangle of entries 399, 400, 401 of 1000 over 7 mm has an optical depth of sigma * 7 / 1000, at any step that
 * stays on the ramp; the midpoint rule, which falls beside it, is the fault that the tolerance rejects. */
TEST(a_shell_thinner_than_a_step_keeps_its_opacity)
{
    FREED float *table = calloc(4 * 1001, sizeof *table);
    table[4 * 400 + 3] = 100;
    table[4 * 400] = 1;
    iso_level level = make_ramp();
    iso_view view = make_ramp_view(table);
    const double exact = 1 - exp(-100 * 7.0 / 1000);
    for (double step = 0.3; step < 2.8; step *= 1.7) /* 1e-6: entries and voxels are floats */
        assert_within(alpha_of(&level, &view, ISO_QUADRATURE_PREINTEGRATED, step), exact, 1e-6);
    assert_true(fabs(alpha_of(&level, &view, ISO_QUADRATURE_MIDPOINT, 1) - exact) > 0.1);
    free(level.scalar);
    free(level.codes);
}

/* ---- the ray caster ------------------------------------------------------------------------------------------------- */

typedef struct scene_of_field {
    iso_pyramid pyramid;
    iso_view view;
} scene_of_field;

static scene_of_field make_scene(const char *path, iso_field_kind kind, iso_type type)
{
    const size_t size[3] = {40, 33, 28};
    const double spacing[3] = {1, 0.8, 1.7};
    iso_field f = {.kind = kind, .geometry = iso_geometry_axis_aligned(size, spacing), .seed = 1};
    OWNED(iso_scene) scene;
    scene_of_field s;
    iso_pyramid_options opt = iso_pyramid_defaults();
    opt.level_count = 2;
    s.pyramid = sampled_pyramid(&f, type, &opt);
    assert_ok(iso_scene_load(path, &scene, &err));
    assert_ok(iso_scene_resolve(&scene, &f.geometry, s.pyramid.levels[0].min, s.pyramid.levels[0].max, &s.view, &err));
    s.view.width = s.view.height = 48;
    return s;
}

static void destroy_scene(scene_of_field *s)
{
    iso_view_destroy(&s->view);
    iso_pyramid_destroy(&s->pyramid);
}

static iso_image render_gl(iso_gl *gl, const scene_of_field *s, size_t level, bool preintegrated, iso_gl_skip skip,
                           double step)
{
    iso_image image;
    iso_gl_options opt = iso_gl_defaults();
    opt.preintegrated = preintegrated;
    opt.skip = skip;
    opt.step_voxels = step;
    assert_ok(iso_gl_render(gl, &s->pyramid.levels[level], s->pyramid.options.code, &s->view, &opt, &image, &err));
    return image;
}

/* 5e-5: texture coordinates and filter weights are floats, and a thin shell turns 1e-6 of a value into as much more
 * opacity as it is steep. Skipping changes nothing but rounding, though segments reach out of their bricks. The
 * midpoint rule, and sums without what floats leave of them, would be caught. */
TEST(the_ray_caster_agrees_with_the_reference)
{
    static const struct {
        const char *path;
        iso_field_kind kind;
        iso_type type;
    } cases[] = {{"refscenes/shells.scene.json", ISO_FIELD_SHELLS, ISO_U16},
                 {"refscenes/marschner-lobb.scene.json", ISO_FIELD_MARSCHNER_LOBB, ISO_F32},
                 {"refscenes/shells.scene.json", ISO_FIELD_NOISE, ISO_U8}};
    iso_gl *gl;
    assert_ok(iso_gl_create(&gl, NULL, &err));
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        ENDED_BY(destroy_scene) scene_of_field s = make_scene(cases[i].path, cases[i].kind, cases[i].type);
        for (size_t k = 0; k < 2; ++k)
            for (double step = 0.7; step < 4; step *= 4) {
                iso_reference_options opt = iso_reference_defaults();
                opt.quadrature = ISO_QUADRATURE_PREINTEGRATED;
                opt.step_voxels = step;
                OWNED(iso_image)
                wanted, dense = render_gl(gl, &s, k, true, ISO_GL_SKIP_NEVER, step),
                        sparse = render_gl(gl, &s, k, true, ISO_GL_SKIP_ALWAYS, step),
                        midpoint = render_gl(gl, &s, k, false, ISO_GL_SKIP_NEVER, step);
                assert_ok(iso_reference_render(&s.pyramid.levels[k], s.pyramid.options.code, &s.view, &opt, &wanted,
                                               NULL, &err));
                assert_at_most(difference_of(&wanted, &dense).max_abs, 5e-5);
                assert_at_most(difference_of(&wanted, &sparse).max_abs, 5e-5);
                assert_more_than(difference_of(&wanted, &midpoint).max_abs, 1e-3);
            }
    }
    iso_gl_destroy(gl);
}

/* At half a voxel a step the error of a shell thinner than a voxel falls to less than half of the midpoint's. */
TEST(it_is_nearer_to_the_converged_image_than_the_midpoint_rule)
{
    ENDED_BY(destroy_scene) scene_of_field s = make_scene("refscenes/shells.scene.json", ISO_FIELD_SHELLS, ISO_U16);
    double rmse[2];
    iso_reference_options opt = iso_reference_defaults();
    iso_image wanted, image;
    opt.tolerance = 1e-3;
    assert_ok(iso_reference_render(&s.pyramid.levels[0], s.pyramid.options.code, &s.view, &opt, &wanted, NULL, &err));
    for (int q = 0; q < 2; ++q) {
        double sum = 0;
        opt.quadrature = q ? ISO_QUADRATURE_PREINTEGRATED : ISO_QUADRATURE_MIDPOINT;
        opt.step_voxels = 0.5;
        assert_ok(
            iso_reference_render(&s.pyramid.levels[0], s.pyramid.options.code, &s.view, &opt, &image, NULL, &err));
        for (size_t i = 0; i < 4 * 48 * 48; ++i)
            sum += pow((double)image.rgba[i] - (double)wanted.rgba[i], 2);
        rmse[q] = sqrt(sum / (4 * 48 * 48));
        iso_image_destroy(&image);
    }
    assert_at_most(rmse[1] / rmse[0], 0.5);
    iso_image_destroy(&wanted);
}

TEST_MAIN(NULL, NULL)

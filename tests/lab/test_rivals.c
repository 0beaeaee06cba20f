/* SPDX-License-Identifier: MIT */
/* The methods of the literature that `isoshade-lab levels` compares with, on fields for which each has an answer in
 * closed form. */
#include "lab/level_methods.h"
#include "lab/rivals/rivals.h"
#include "render/sampler.h"
#include "tests/test.h"

typedef iso_status (*rival_maker)(const iso_level_subject *s, iso_rival *r, iso_error *err);

/* Extinction .3 (red) at value 0, .9 (blue) at 100; linear between, 101 entries. */
static iso_tf_table make_tf(void)
{
    iso_tf_table tf = {.count = 101, .lo = 0, .hi = 100, .entries = calloc(404, sizeof(float))};
    for (size_t i = 0; i < 101; ++i) {
        tf.entries[4 * i] = 1 - 0.01F * (float)i;
        tf.entries[4 * i + 2] = 0.01F * (float)i;
        tf.entries[4 * i + 3] = 0.3F + 0.006F * (float)i;
    }
    return tf;
}

typedef float (*value_of)(size_t x, size_t y, size_t z);
static float forty(size_t x, size_t y, size_t z)
{
    return (void)x, (void)y, (void)z, 40;
}
static float stripes(size_t x, size_t y, size_t z)
{
    return (void)y, (void)z, x % 2 ? 100 : 0;
}
static float ramp(size_t x, size_t y, size_t z)
{
    return (float)(x + 2 * y + z);
}

static iso_pyramid build(value_of value, size_t size)
{
    OWNED(iso_volume) v;
    iso_pyramid p;
    iso_pyramid_options opt = iso_pyramid_defaults();
    const iso_geometry g = iso_geometry_axis_aligned((size_t[]){size, size, size}, (double[]){1, 1, 1});
    opt.level_count = 2;
    assert_ok(iso_volume_create(&v, &g, ISO_F32, "test", &err));
    for (size_t i = 0; i < size * size * size; ++i)
        ((float *)v.data)[i] = value(i % size, i / size % size, i / (size * size));
    assert_ok(iso_pyramid_build(&v, "test", &opt, &p, NULL, &err));
    return p;
}

/* What the rival emits in the middle of level 1, under ambient light alone. */
static double emit_at(rival_maker make, const iso_pyramid *p, const iso_tf_table *tf, iso_vec3 index, double color[3])
{
    const iso_view view = {.shading = {.ambient = 1, .power = 1}, .tf = *tf};
    OWNED(iso_rival) r = {0};
    OWNED(iso_sampler) sampler;
    assert_ok(make(&(iso_level_subject){p, 1, tf, tf, 1}, &r, &err));
    assert_ok(iso_sampler_create(&sampler, &p->levels[1], p->options.code, ISO_FROM_CODES, &err));
    const iso_emitter_place at = {&view, &sampler, index, {0, 0, 1}};
    const double extinction = r.emitter.emit(&r.emitter, &at, color);
    return extinction;
}

static const rival_maker all_rivals[] = {iso_rival_opacity,       iso_rival_extinction, iso_rival_transmittance,
                                         iso_rival_two_gaussians, iso_rival_deviation,  iso_rival_bricks,
                                         iso_rival_sggx};

/* Everywhere 40: extinction .54 and its color, as level 0 has. The rivals keep floats: 1e-6. */
TEST(a_homogeneous_volume_is_what_level_0_is)
{
    OWNED(iso_pyramid) p = build(forty, 8);
    OWNED(iso_tf_table) tf = make_tf();
    for (size_t i = 0; i < sizeof all_rivals / sizeof *all_rivals; ++i) {
        double color[3];
        const double extinction = emit_at(all_rivals[i], &p, &tf, iso_v3(2.1, 1.7, 0.2), color);
        assert_within(extinction, 0.54, 2e-6);
        assert_within(color[0], 0.54 * 0.6, 2e-6);
        assert_within(color[1], 0, 0);
        assert_within(color[2], 0.54 * 0.4, 2e-6);
    }
}

/* Every voxel of level 1 is half 0 and half 100, side by side along x: all voxels are alike, so filtering does
 * nothing. */
TEST(half_and_half_voxels_have_their_means)
{
    OWNED(iso_pyramid) p = build(stripes, 8);
    OWNED(iso_tf_table) tf = make_tf();
    const double a0 = -expm1(-0.3), a1 = -expm1(-0.9), mean = 0.5 * (a0 + a1);
    double color[3];
    const double opacity = emit_at(iso_rival_opacity, &p, &tf, iso_v3(1.3, 2, 2), color);
    assert_within(opacity, -log1p(-mean), 1e-6);
    assert_within(color[0], opacity * 0.5 * a0 / mean, 1e-6);
    assert_within(color[2], opacity * 0.5 * a1 / mean, 1e-6);
    assert_within(emit_at(iso_rival_extinction, &p, &tf, iso_v3(1.3, 2, 2), color), 0.6, 1e-6);
    assert_within(color[0], 0.15, 1e-6);
    assert_within(color[2], 0.45, 1e-6);
    /* each of the two Gaussians is one value: the histogram itself, so the limit of sparse pdfs is met */
    assert_within(emit_at(iso_rival_two_gaussians, &p, &tf, iso_v3(1.3, 2, 2), color), opacity, 1e-6);
    assert_within(color[2], opacity * 0.5 * a1 / mean, 1e-6);
}

/* Along x a ray meets both halves, along y and z one of them. Means of transmittances are larger than the transmittance
 * of the mean: less extinction than the mean's .6. */
TEST(transmittance_is_kept_along_each_axis)
{
    OWNED(iso_pyramid) p = build(stripes, 8);
    OWNED(iso_tf_table) tf = make_tf();
    double color[3];
    const double t0 = exp(-0.6), t1 = exp(-1.8), across = -log(0.5 * (t0 + t1)) / 2;
    const double wanted = (0.6 + 2 * across) / 3;
    assert_within(emit_at(iso_rival_transmittance, &p, &tf, iso_v3(2.6, 2, 2), color), wanted, 1e-6);
    assert_at_most(wanted, 0.6 - 0.01);
    /* from both ends along x: .5 (1 + e^-.9) of the first half's opacity is seen, .5 (1 + e^-.3) of the second's */
    const double red = 0.5 * (1 + exp(-0.9)) * -expm1(-0.3) + 2 * 0.5 * (1 - t0);
    const double blue = 0.5 * (1 + exp(-0.3)) * -expm1(-0.9) + 2 * 0.5 * (1 - t1);
    const double opacity = 1 - exp(-1.2) + 2 * (1 - 0.5 * (t0 + t1));
    assert_within(color[0], wanted * red / opacity, 1e-6);
    assert_within(color[2], wanted * blue / opacity, 1e-6);
}

/* The same by a sum over many values of the density. */
static void by_sum(const iso_tf_table *tf, double length_mm, double mean, double deviation, double rgba[4])
{
    enum { steps = 40000 };
    double weights = 0;
    memset(rgba, 0, 4 * sizeof *rgba);
    for (int i = 0; i < steps; ++i) {
        const double x = -9 + 18 * (i + 0.5) / steps, weight = exp(-0.5 * x * x);
        const double place = (mean + deviation * x - tf->lo) / (tf->hi - tf->lo) * (double)(tf->count - 1);
        const double at = fmin(fmax(place, 0), (double)(tf->count - 1));
        const size_t lower = at < (double)(tf->count - 2) ? (size_t)at : tf->count - 2;
        for (size_t c = 0; c < 4; ++c) {
            double value[2];
            for (size_t e = 0; e < 2; ++e) {
                const float *entry = tf->entries + 4 * (lower + e);
                const double a = -expm1(-(double)entry[3] * length_mm);
                value[e] = c < 3 ? a * (double)entry[c] : a;
            }
            rgba[c] += weight * (value[0] + (at - (double)lower) * (value[1] - value[0]));
        }
        weights += weight;
    }
    for (int c = 0; c < 4; ++c)
        rgba[c] /= weights;
}

/* 1e-6: the sum's step at a bend of the table; clamped ends, narrow and wide Gaussians, a mean beyond the range. */
TEST(the_tf_under_a_gaussian_is_its_closed_form)
{
    OWNED(iso_tf_table) tf = make_tf();
    for (size_t i = 40; i < 60; ++i)
        tf.entries[4 * i + 3] = 3; /* a shell */
    const double cases[][2] = {{50, 3}, {40, 0.2}, {2, 10}, {97, 30}, {-5, 4}, {120, 20}, {33, 0}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        double closed[4], summed[4];
        iso_tf_under_gaussian(&tf, 0.8, cases[i][0], cases[i][1], closed);
        by_sum(&tf, 0.8, cases[i][0], cases[i][1], summed);
        for (int c = 0; c < 4; ++c)
            assert_within(closed[c], summed[c], 1e-6);
    }
}

/* Half 0 and half 100: mean and deviation are 50. 1e-4: the table over means and deviations is linear between
 * entries. */
TEST(mean_and_deviation_are_put_under_one_gaussian)
{
    OWNED(iso_pyramid) p = build(stripes, 8);
    OWNED(iso_tf_table) tf = make_tf();
    double color[3], rgba[4];
    iso_tf_under_gaussian(&tf, 1, 50, 50, rgba);
    assert_within(emit_at(iso_rival_deviation, &p, &tf, iso_v3(2, 2, 2), color), -log1p(-rgba[3]), 1e-4);
    assert_within(color[2] / color[0], rgba[2] / rgba[0], 1e-4);
}

/* A level of 16^3 voxels is one brick: its table is that of the whole level. */
TEST(one_brick_is_the_whole_level)
{
    OWNED(iso_pyramid) p = build(ramp, 32);
    OWNED(iso_tf_table) tf = make_tf(), whole;
    iso_adapt_options opt = iso_adapt_defaults();
    opt.fall_back = false;
    assert_ok(iso_adapt_level(&p, 1, &tf, &opt, &whole, NULL, &err));
    for (size_t i = 1; i < 7; ++i) {
        double color[3], rgbs[4];
        const iso_vec3 at = {2.0 * (double)i, 3.3, 1.9 * (double)i};
        OWNED(iso_sampler) sampler;
        assert_ok(iso_sampler_create(&sampler, &p.levels[1], p.options.code, ISO_FROM_CODES, &err));
        iso_tf_lookup(&whole, iso_sample_scalar(&sampler, at), rgbs);
        assert_within(emit_at(iso_rival_bricks, &p, &tf, at, color), rgbs[3], 1e-9);
        assert_within(color[2], rgbs[3] * rgbs[2], 1e-9);
    }
}

TEST(one_direction_of_microflakes_is_a_surface)
{
    const iso_vec3 n = iso_normalize(iso_v3(0.3, -0.8, 0.5)), light = iso_normalize(iso_v3(1, 2, -0.5));
    iso_sggx_sums sums = {0};
    double s[6];
    iso_sggx_add(&sums, n, 2.5);
    iso_sggx_matrix(&sums, s);
    const double wanted[6] = {n.x * n.x, n.y * n.y, n.z * n.z, n.x * n.y, n.x * n.z, n.y * n.z};
    for (int i = 0; i < 6; ++i)
        assert_within(s[i], wanted[i], 1e-12);
    for (int i = 0; i < 5; ++i) {
        const iso_vec3 view = iso_normalize(iso_v3(1, 0.4 * i - 1, 0.3));
        assert_within(iso_sggx_diffuse(s, view, light), fabs(iso_dot(n, light)), 1e-4); /* a root of rounding's 1e-9 */
    }
}

/* All directions alike: the visible ones have the density of the cosine, and the mean of the cosine is 2/3. 18 points:
 * .01. */
TEST(a_ball_of_microflakes_has_two_thirds)
{
    const double ball[6] = {0.25, 0.25, 0.25, 0, 0, 0}, none[6] = {0};
    for (int i = 0; i < 5; ++i) {
        const iso_vec3 view = iso_normalize(iso_v3(0.2 * i, 1 - 0.5 * i, 0.3));
        assert_within(iso_sggx_diffuse(ball, view, view), 2.0 / 3, 0.01);
    }
    assert_true(iso_sggx_diffuse(none, iso_v3(0, 0, 1), iso_v3(0, 0, 1)) == 0);
}

/* The gradient of a ramp is one direction everywhere. */
TEST(a_ramp_is_shaded_by_its_gradient)
{
    OWNED(iso_pyramid) p = build(ramp, 16);
    OWNED(iso_tf_table) tf = make_tf();
    const iso_vec3 n = iso_normalize(iso_v3(1, 2, 1)), light = iso_normalize(iso_v3(-1, 1, 3));
    const iso_view view = {.shading = {.ambient = 0.3, .diffuse = 0.7, .power = 1},
                           .light_count = 1,
                           .lights = {{.direction = light, .intensity = 1}},
                           .tf = tf};
    OWNED(iso_rival) r = {0};
    OWNED(iso_sampler) sampler;
    double color[3], rgbs[4];
    const iso_vec3 at = {4.2, 3.6, 4.4};
    assert_ok(iso_rival_sggx(&(iso_level_subject){&p, 1, &tf, &tf, 1}, &r, &err));
    assert_ok(iso_sampler_create(&sampler, &p.levels[1], p.options.code, ISO_FROM_CODES, &err));
    const double extinction = r.emitter.emit(&r.emitter, &(iso_emitter_place){&view, &sampler, at, {0, 0, 1}}, color);
    iso_tf_lookup(&tf, iso_sample_scalar(&sampler, at), rgbs);
    assert_within(extinction, rgbs[3], 1e-9);
    /* 3 bytes of a direction: .01 */
    assert_within(color[2], rgbs[3] * rgbs[2] * (0.3 + 0.7 * fabs(iso_dot(n, light))), 0.01);
}

TEST(fine_boxes_are_cut_by_the_volume)
{
    iso_level levels[3] = {{.geometry = {.size = {7, 5, 4}}},
                           {.geometry = {.size = {4, 3, 2}}},
                           {.geometry = {.size = {2, 2, 1}}}};
    const iso_pyramid p = {.level_count = 3, .levels = levels};
    const iso_fine_box last = iso_fine_box_of(&p, 1, 4 * 3 * 2 - 1), coarse = iso_fine_box_of(&p, 2, 1);
    assert_int_equal(last.lo[0], 6);
    assert_int_equal(last.hi[0], 7);
    assert_int_equal(last.lo[1], 4);
    assert_int_equal(last.hi[1], 5);
    assert_int_equal(last.hi[2], 4);
    assert_int_equal(coarse.lo[0], 4);
    assert_int_equal(coarse.hi[0], 7);
    assert_int_equal(coarse.hi[1], 4);
}

TEST_MAIN(NULL, NULL)

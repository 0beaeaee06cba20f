/* SPDX-License-Identifier: MIT */
/* Which direction filter a level gets by itself: closed forms of the figures, and that a level is that of the filter
 * named. */
#include "pyramid/agreement.h"
#include "pyramid/pyramid_verify.h"
#include "tests/test.h"
#include "volume/synthetic.h"

static iso_pyramid build(const iso_volume *v, iso_direction_filter filter)
{
    iso_pyramid p;
    iso_pyramid_options opt = iso_pyramid_defaults();
    opt.direction_filter = filter;
    opt.keep_float = opt.keep_magnitude = true;
    assert_ok(iso_pyramid_build(v, "test", &opt, &p, NULL, &err));
    return p;
}

static iso_volume sample(iso_field_kind kind, const size_t size[3], const double spacing[3])
{
    const iso_field field = {.kind = kind, .seed = 1, .geometry = iso_geometry_axis_aligned(size, spacing)};
    iso_volume v;
    assert_ok(iso_field_sample(&field, ISO_F32, &v, &err));
    return v;
}

/* 0 1 2 3 4 3 2 1, again and again, along z: of the differences 0 1 1 1 0 -1 -1 -1 the first half and the second agree,
 * and a voxel of level 3 holds both. The first plane has a difference of 1, as there is nothing before it: of its eight
 * one is left, and seven of 49 squares are its own. */
TEST(opposite_faces_within_a_voxel_are_an_axis)
{
    const iso_geometry g = iso_geometry_axis_aligned((size_t[]){8, 8, 64}, (double[]){1, 1, 1});
    OWNED(iso_volume) v;
    assert_ok(iso_volume_create(&v, &g, ISO_F32, "zigzag", &err));
    for (size_t i = 0; i < iso_geometry_voxel_count(&g); ++i)
        ((float *)v.data)[i] = (float)(i / 64 % 8 < 4 ? i / 64 % 8 : 8 - i / 64 % 8);
    OWNED(iso_pyramid) p = build(&v, ISO_DIRECTION_AUTO);
    const iso_direction_choice *c = &p.options.choice;
    for (size_t k = 1; k < 3; ++k) { /* sums of small integers: exact but for the unit of the sums */
        assert_within(c->mean_agreement[k], 1, 1e-8);
        assert_within(c->axis_agreement[k], 1, 1e-8);
        assert_int_equal(c->filter[k], ISO_DIRECTION_MOMENTS);
    }
    assert_within(c->mean_agreement[3], 1.0 / 49, 1e-8);
    assert_within(c->axis_agreement[3], 1, 1e-8);
    assert_int_equal(c->filter[3], ISO_DIRECTION_TENSOR);
}

/* Gradients of one direction agree whatever their sizes are; where there are none, nothing is lost. */
TEST(one_direction_agrees_and_none_does_not_matter)
{
    static const iso_field_kind kinds[] = {ISO_FIELD_RAMP, ISO_FIELD_CONSTANT};
    for (size_t i = 0; i < 2; ++i) {
        OWNED(iso_volume) v = sample(kinds[i], (size_t[]){17, 13, 22}, (double[]){1, 2, 0.5});
        OWNED(iso_pyramid) p = build(&v, ISO_DIRECTION_AUTO);
        for (size_t k = 1; k < p.level_count; ++k) {
            assert_within(p.options.choice.mean_agreement[k], 1, 1e-6); /* float states */
            assert_within(p.options.choice.axis_agreement[k], 1, 1e-6);
            assert_int_equal(p.options.choice.filter[k], ISO_DIRECTION_MOMENTS);
        }
    }
}

/* The row's own figures: no axis at all, and the limit itself. */
TEST(the_limit_is_where_it_says)
{
    const float third = 1.0f / 3, none[10] = {0, 0, 0, 1, third, third, third, 0, 0, 0};
    /* |T| = 1: an axis; |N| as much less as the limit, or a little more than that */
    const float at[10] = {0.59375f, 0, 0, 1, 1, 0, 0, 0, 0, 0}, over[10] = {0.609375f, 0, 0, 1, 1, 0, 0, 0, 0, 0};
    const struct {
        const float *state;
        double mean, axis;
        iso_direction_filter filter;
    } cases[] = {{none, 0, 1 / sqrt(3), ISO_DIRECTION_TENSOR},
                 {at, 0.59375, 1, ISO_DIRECTION_TENSOR},
                 {over, 0.609375, 1, ISO_DIRECTION_MOMENTS}};
    for (size_t i = 0; i < 3; ++i) {
        iso_agreement levels[2] = {0};
        iso_direction_choice c;
        iso_agreement_add_row(&levels[1], cases[i].state, 1, 1);
        iso_agreement_choose(levels, 1, &c);
        assert_within(c.mean_agreement[1], cases[i].mean, 1e-7);
        assert_within(c.axis_agreement[1], cases[i].axis, 1e-7);
        assert_int_equal(c.filter[1], cases[i].filter);
        assert_int_equal(c.filter[31], c.filter[1]); /* levels above have the last one's */
    }
}

static bool is_same_level(const iso_level *a, const iso_level *b)
{
    const size_t count = iso_geometry_voxel_count(&a->geometry);
    return memcmp(a->codes, b->codes, 3 * count) == 0 && memcmp(a->scalar, b->scalar, count * sizeof(float)) == 0 &&
           memcmp(a->directions, b->directions, 3 * count * sizeof(float)) == 0 &&
           memcmp(a->magnitude, b->magnitude, count * sizeof(float)) == 0;
}

TEST(a_level_has_every_bit_of_the_filter_that_is_named)
{
    static const iso_field_kind kinds[] = {ISO_FIELD_MARSCHNER_LOBB, ISO_FIELD_PLATE, ISO_FIELD_SPHERE,
                                           ISO_FIELD_TUBES};
    size_t chosen[ISO_DIRECTION_COUNT] = {0};
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; ++i) {
        OWNED(iso_volume) v = sample(kinds[i], (size_t[]){41, 38, 33}, (double[]){1, 1, 1.5});
        iso_pyramid p = build(&v, ISO_DIRECTION_AUTO), all[ISO_DIRECTION_COUNT];
        iso_level_check checks[32];
        for (int f = 0; f < ISO_DIRECTION_COUNT; ++f)
            all[f] = build(&v, (iso_direction_filter)f);
        for (size_t k = 1; k < p.level_count; ++k) {
            const iso_direction_filter f = p.options.choice.filter[k];
            assert_true(is_same_level(&p.levels[k], &all[f].levels[k]));
            assert_false(is_same_level(&p.levels[k], &all[ISO_DIRECTION_NAIVE].levels[k])); /* can fail */
            ++chosen[f];
        }
        assert_ok(iso_pyramid_verify(&p, 2, checks, NULL, &err));
        for (size_t k = 0; k < p.level_count; ++k)
            assert_null(checks[k].what);
        /* a choice that is none of its own, planted */
        p.options.choice.filter[2] = p.options.choice.filter[2] == ISO_DIRECTION_TENSOR ? ISO_DIRECTION_MOMENTS
                                                                                        : ISO_DIRECTION_TENSOR;
        assert_ok(iso_pyramid_verify(&p, 2, checks, NULL, &err));
        assert_string_equal(checks[2].what, "direction filter");
        for (int f = 0; f < ISO_DIRECTION_COUNT; ++f)
            iso_pyramid_destroy(&all[f]);
        iso_pyramid_destroy(&p);
    }
    assert_more_than((double)chosen[ISO_DIRECTION_MOMENTS], 0);
    assert_more_than((double)chosen[ISO_DIRECTION_TENSOR], 0);
}

/* Sums are integers: neither threads nor a power of two in the values changes a bit of the figures. */
TEST(figures_do_not_depend_on_threads_or_units)
{
    OWNED(iso_volume) v = sample(ISO_FIELD_MARSCHNER_LOBB, (size_t[]){33, 47, 29}, (double[]){1, 1, 1.5});
    iso_pyramid_options opt = iso_pyramid_defaults();
    iso_direction_choice first = {0};
    opt.direction_filter = ISO_DIRECTION_AUTO;
    for (int i = 0; i < 3; ++i) {
        OWNED(iso_pyramid) p;
        opt.threads = 1 + i;
        assert_ok(iso_pyramid_build(&v, "test", &opt, &p, NULL, &err));
        for (size_t k = 1; k < p.level_count && i > 0; ++k) {
            assert_true(p.options.choice.mean_agreement[k] == first.mean_agreement[k]);
            assert_true(p.options.choice.axis_agreement[k] == first.axis_agreement[k]);
        }
        first = p.options.choice;
        for (size_t n = 0; n < iso_geometry_voxel_count(&v.geometry); ++n)
            ((float *)v.data)[n] *= 1024;
    }
}

TEST_MAIN(NULL, NULL)

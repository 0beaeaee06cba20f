/* SPDX-License-Identifier: MIT */
/* Error bars of extrapolated limits, where each figure has a closed form. */
#include "compare/extrapolation.h"
#include "test.h"

enum { side = 8, seeds = 2 };

static iso_image uniform(double value)
{
    iso_image image;
    assert_ok(iso_image_create(&image, side, side, &err));
    for (size_t i = 0; i < 4 * side * side; ++i)
        image.rgba[i] = (float)value;
    return image;
}

/* The reference is .5. The error of the step is 4e at the double step and e at the step, in every value; the two seeds
 * are n above and below it at the step, in all channels or in alpha alone. */
static iso_extrapolated extrapolate(double e, double n, bool alpha_alone, double factor)
{
    iso_image images[2 * seeds], reference = uniform(0.5);
    iso_extrapolated limit = {.seeds = seeds};
    for (size_t k = 0; k < 2 * seeds; ++k) {
        const bool fine = k >= seeds;
        images[k] = uniform(0.5 + (fine ? e : 4 * e));
        for (size_t i = 0; fine && i < 4 * side * side; ++i)
            if (i % 4 == 3 || !alpha_alone)
                images[k].rgba[i] += (float)(k % 2 ? n : -n);
    }
    assert_ok(iso_extrapolate(&(iso_extrapolation_input){images, seeds, &reference, factor, NULL, false}, &limit, &err));
    for (size_t k = 0; k < 2 * seeds; ++k)
        iso_image_destroy(&images[k]);
    iso_image_destroy(&reference);
    return limit;
}

static const double rounding = 1e-7; /* of floats near 1/2 */

TEST(the_bar_is_what_the_step_leaves_times_the_factor)
{
    OWNED(iso_extrapolated) l = extrapolate(0.01, 0, false, 2);
    assert_within(l.rmse, 0, rounding);
    assert_within(l.step_bar, 0.01, rounding);
    assert_within(l.noise_bar, 0, rounding);
    assert_within(l.bar, 0.02, 3 * rounding);
    assert_within(l.allowed, 0.02 + 1e-5, 3 * rounding); /* one rounding of 16 bits, and no more */
    assert_within(l.order, 2, 1e-4);
    assert_within(iso_extrapolated_error_left(&l), 0.25, 1e-3);
}

/* A seed's limit is 4/3 of the fine image less 1/3 of the coarse one, so that two seeds n above and below have limits
 * 4n/3 off, which is the standard error of the mean of two. */
TEST(noise_is_part_of_the_bar)
{
    iso_extrapolated l = extrapolate(0.01, 0.03, false, 2);
    assert_within(l.noise_bar, 0.04, 3 * rounding);
    assert_within(l.bar, 2 * hypot(0.01, 0.04), 6 * rounding);
    iso_extrapolated_destroy(&l);
    l = extrapolate(0.01, 0.03, true, 2.5); /* a quarter of all values, so half of the root of the mean square */
    assert_within(l.noise_bar, 0.02, 3 * rounding);
    assert_within(l.bar, 2.5 * hypot(0.01, 0.02), 6 * rounding);
    iso_extrapolated_destroy(&l);
}

TEST(what_is_no_number_has_an_infinite_bar)
{
    OWNED(iso_extrapolated) l = extrapolate(NAN, 0, false, 2);
    assert_true(isinf(l.bar) && isinf(l.allowed) && isnan(iso_extrapolated_error_left(&l)));
    assert_true(l.noise.rejected == 4 * side * side);
}

/* ---- two limits ---- */

enum { compared_seeds = 4 };

/* Images of 0.5 with the same error of the step and noise of 1e-4, other noise for another `which`; and what is added
 * to the red of a pixel, and to all values, of a limit. */
static iso_extrapolated version(unsigned which, double of_pixel, double of_all)
{
    iso_image images[2 * compared_seeds], reference = uniform(0.5);
    iso_extrapolated limit = {.seeds = compared_seeds};
    uint32_t random = 1 + which;
    for (size_t k = 0; k < 2 * compared_seeds; ++k) {
        images[k] = uniform(0.5 + of_all + (k < compared_seeds ? 4e-5 : 1e-5));
        images[k].rgba[4 * (3 * side + 5)] += (float)of_pixel;
        for (size_t i = 0; i < 4 * side * side; ++i) {
            random = random * 1664525 + 1013904223;
            images[k].rgba[i] += (float)(2e-4 * (ldexp((double)random, -32) - 0.5));
        }
    }
    const iso_extrapolation_input of = {images, compared_seeds, &reference, 2, NULL, true};
    assert_ok(iso_extrapolate(&of, &limit, &err));
    for (size_t k = 0; k < 2 * compared_seeds; ++k)
        iso_image_destroy(&images[k]);
    iso_image_destroy(&reference);
    return limit;
}

static iso_extrapolated_change compare_versions(iso_extrapolated a, iso_extrapolated b)
{
    iso_extrapolated_change change;
    assert_ok(iso_extrapolated_compare(&a, &b, &change, &err));
    iso_extrapolated_destroy(&a);
    iso_extrapolated_destroy(&b);
    return change;
}

TEST(a_version_does_not_differ_from_itself)
{
    const iso_extrapolated_change c = compare_versions(version(1, 0, 0), version(1, 0, 0));
    assert_true(c.largest == 0 && c.noise == 0 && c.test.passed);
}

TEST(other_noise_is_no_change)
{
    const iso_extrapolated_change c = compare_versions(version(1, 0, 0), version(2, 0, 0));
    assert_true(c.largest > 0 && c.noise > 0 && c.largest < 10 * c.noise);
    assert_true(c.test.passed && c.test.tests == 4 * side * side);
}

TEST(a_pixel_that_changed_is_found)
{
    const iso_extrapolated_change c = compare_versions(version(1, 0, 0), version(2, 0.02, 0));
    assert_int_equal(c.column, 5);
    assert_int_equal(c.row, 3);
    assert_int_equal(c.channel, 0);
    assert_within(c.largest, 0.02, 5e-4);
    assert_within(c.noise, 8e-5, 8e-5);
    assert_true(c.test.rejected == 1 && !c.test.passed);
}

/* Less than the noise of a pixel, but everywhere. */
TEST(a_change_of_all_pixels_is_a_bias)
{
    const iso_extrapolated_change c = compare_versions(version(1, 0, 0), version(2, 0, 3e-4));
    assert_true(c.test.biased);
    assert_within(c.test.bias, 3e-4, 5e-5);
}

TEST(limits_that_were_not_kept_are_not_compared)
{
    OWNED(iso_extrapolated) a = extrapolate(0.01, 0.01, false, 2), b = version(1, 0, 0);
    iso_extrapolated_change change;
    assert_status(iso_extrapolated_compare(&a, &b, &change, &err), ISO_E_RANGE);
}

TEST_MAIN(NULL, NULL)

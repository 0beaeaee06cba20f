/* SPDX-License-Identifier: MIT */
/* Error bars of extrapolated limits, where each figure has a closed form. */
#include <math.h>

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

/* The reference is .5. The error of the step is 4e at the double step and e at the step, in every value; the two seeds are n
 * above and below it at the step, in all channels or in alpha alone. */
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
    assert_ok(iso_extrapolate(&(iso_extrapolation_input){images, seeds, &reference, factor, NULL}, &limit, &err));
    for (size_t k = 0; k < 2 * seeds; ++k)
        iso_image_destroy(&images[k]);
    iso_image_destroy(&reference);
    return limit;
}

static const double rounding = 1e-7; /* of floats near 1/2 */

static void the_bar_is_what_the_step_leaves_times_the_factor(void **state)
{
    (void)state;
    iso_extrapolated l = extrapolate(0.01, 0, false, 2);
    assert_within(l.rmse, 0, rounding);
    assert_within(l.step_bar, 0.01, rounding);
    assert_within(l.noise_bar, 0, rounding);
    assert_within(l.bar, 0.02, 3 * rounding);
    assert_within(l.allowed, 0.02 + 1e-5, 3 * rounding); /* one rounding of 16 bits, and no more */
    assert_within(l.order, 2, 1e-4);
    assert_within(iso_extrapolated_error_left(&l), 0.25, 1e-3);
    iso_extrapolated_destroy(&l);
}

/* A seed's limit is 4/3 of the fine image less 1/3 of the coarse one, so that two seeds n above and below have limits 4n/3 off,
 * which is the standard error of the mean of two. */
static void noise_is_part_of_the_bar(void **state)
{
    (void)state;
    iso_extrapolated l = extrapolate(0.01, 0.03, false, 2);
    assert_within(l.noise_bar, 0.04, 3 * rounding);
    assert_within(l.bar, 2 * hypot(0.01, 0.04), 6 * rounding);
    iso_extrapolated_destroy(&l);
    l = extrapolate(0.01, 0.03, true, 2.5); /* a quarter of all values, so half of the root of the mean square */
    assert_within(l.noise_bar, 0.02, 3 * rounding);
    assert_within(l.bar, 2.5 * hypot(0.01, 0.02), 6 * rounding);
    iso_extrapolated_destroy(&l);
}

static void what_is_no_number_has_an_infinite_bar(void **state)
{
    (void)state;
    iso_extrapolated l = extrapolate(NAN, 0, false, 2);
    assert_true(isinf(l.bar) && isinf(l.allowed) && isnan(iso_extrapolated_error_left(&l)));
    assert_true(l.noise.rejected == 4 * side * side);
    iso_extrapolated_destroy(&l);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_bar_is_what_the_step_leaves_times_the_factor),
        cmocka_unit_test(noise_is_part_of_the_bar),
        cmocka_unit_test(what_is_no_number_has_an_infinite_bar),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

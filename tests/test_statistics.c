/* SPDX-License-Identifier: MIT */
/* Statistics: tables and closed forms of the distribution, extrapolation of known series, and faults with noise. */
#include "compare/extrapolation.h"
#include "tests/test.h"

enum { width = 24, height = 17 };

static double uniform01(uint64_t *state)
{
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    return (double)(*state >> 11) / 9007199254740992.0;
}

static double normal(uint64_t *state)
{
    double u = uniform01(state), v = uniform01(state);
    return sqrt(-2 * log(1 - u)) * cos(2 * acos(-1) * v);
}

static double truth(size_t x, size_t y, size_t c)
{
    return 0.5 + 0.3 * sin(0.4 * (double)x + (double)c) * cos(0.3 * (double)y);
}

/* shift: along x in pixels; gain, offset: faults; noise: standard deviation. */
static iso_image rendered(double shift, double gain, double offset, double noise, uint64_t *state)
{
    iso_image image;
    assert_ok(iso_image_create(&image, width, height, &err));
    for (size_t y = 0; y < height; ++y)
        for (size_t x = 0; x < width; ++x) {
            float *p = image.rgba + 4 * (y * width + x);
            for (size_t c = 0; c < 3; ++c) {
                double clean = 0.5 + 0.3 * sin(0.4 * ((double)x + shift) + (double)c) * cos(0.3 * (double)y);
                p[c] = (float)(gain * clean + offset + (noise > 0 ? noise * normal(state) : 0));
            }
            p[3] = 1;
        }
    return image;
}

static iso_noise_test run(size_t count, double shift, double gain, double offset, double noise, double tolerance,
                          uint64_t seed)
{
    uint64_t state = seed * 0x9E3779B97F4A7C15u + 1;
    OWNED(iso_image) reference = rendered(0, 1, 0, 0, &state);
    OWNED(iso_samples) s;
    iso_noise_test test;
    assert_ok(iso_samples_create(&s, &reference, &err));
    for (size_t i = 0; i < count; ++i) {
        OWNED(iso_image) image = rendered(shift, gain, offset, noise, &state);
        assert_ok(iso_samples_add(&s, &image, &err));
    }
    assert_ok(iso_samples_test(
        &s, &(iso_noise_options){.significance = 0.001, .tolerance = tolerance, .bias_tolerance = tolerance}, &test,
        &err));
    return test;
}

TEST(student_equals_closed_forms_and_tables)
{
    const double pi = acos(-1);
    for (double t = 0.1; t < 100; t *= 3) {
        assert_within(iso_student_two_sided(t, 1), 1 - 2 * atan(t) / pi, 1e-13);
        assert_within(iso_student_two_sided(t, 2), 1 - t / sqrt(2 + t * t), 1e-13);
        assert_within(iso_student_two_sided(-t, 4), iso_student_two_sided(t, 4), 0);
    }
    assert_within(iso_student_two_sided(0, 7), 1, 1e-15);
    assert_within(iso_student_two_sided(2.776445105, 4), 0.05, 1e-9); /* printed tables */
    assert_within(iso_student_two_sided(3.169272673, 10), 0.01, 1e-9);
    assert_within(iso_student_two_sided(1.959963985, 1e7), 0.05, 1e-6); /* the normal limit, 1 / freedom away */
    /* Far out the tail falls as t^-freedom: halving t multiplies by 2^freedom. */
    assert_within(iso_student_two_sided(1e6, 3) / iso_student_two_sided(2e6, 3), 8, 1e-6);
}

TEST(clean_noise_is_never_flagged_in_20_repetitions)
{
    for (uint64_t seed = 1; seed <= 20; ++seed) {
        iso_noise_test t = run(6, 0, 1, 0, 0.02, 0, seed); /* a chance of 0.2 % a repetition at these fixed seeds */
        if (!t.passed)
            fail_msg("seed %d: %zu rejected, smallest p %g", (int)seed, t.rejected, t.smallest_p);
        assert_int_equal(t.tests, 4 * width * height);
    }
}

TEST(each_planted_fault_is_flagged)
{
    for (uint64_t seed = 1; seed <= 5; ++seed) {
        assert_false(run(12, 0.5, 1, 0, 0.005, 0, seed).passed); /* half a pixel aside */
        assert_false(run(12, 0, 0.95, 0, 0.02, 0, seed).passed); /* five percent too dark */
        assert_true(run(12, 0, 1, 0.002, 0.02, 0, seed).biased); /* a bias of a tenth of the noise */
        assert_false(run(12, 0, -1, 1, 0.02, 0, seed).passed);   /* light from the wrong side */
    }
}

TEST(a_bias_within_the_tolerance_is_allowed)
{
    assert_true(run(12, 0, 1, 0.002, 0.02, 0.004, 3).passed);
    assert_false(run(12, 0, 1, 0.002, 0.02, 0.001, 3).passed);
}

TEST(without_noise_the_tolerance_decides)
{
    assert_true(run(2, 0, 1, 0, 0, 0, 1).passed);
    iso_noise_test t = run(2, 0, 1, 0.001, 0, 0, 1);
    assert_false(t.passed);
    assert_int_equal(t.rejected, 3 * width * height);
    assert_within(t.bias, 0.001, 1e-7); /* float images */
    assert_true(run(2, 0, 1, 0.001, 0, 0.0011, 1).passed);
}

TEST(sidak_keeps_the_significance_of_all_tests)
{
    iso_noise_test t = run(3, 0, 1, 0, 0.02, 0, 9);
    assert_within(1 - pow(1 - t.pixel_significance, (double)t.tests), 0.001, 1e-12);
    assert_at_most(t.pixel_significance, 0.001 / (double)t.tests * 1.001);
}

/* ---- rates: what is promised by chance, and what is seen ------------------------ */

typedef enum noise_kind { NOISE_NORMAL, NOISE_ALIKE, NOISE_UNIFORM } noise_kind; /* alike: one value for all channels */
enum { small_width = 6, small_height = 5, small_tests = 4 * small_width * small_height };

typedef struct rates {
    double pixels, bias; /* of the repetitions, how many were flagged */
} rates;

/* offset: of channel 0 in standard deviations of the noise; of all pixels, or of one alone. */
static rates measure_rates(noise_kind kind, size_t n, size_t repetitions, double significance, double offset,
                           bool everywhere)
{
    uint64_t state = 0x1234567 + n;
    OWNED(iso_image) reference, image;
    rates r = {0};
    assert_ok(iso_image_create(&reference, small_width, small_height, &err));
    assert_ok(iso_image_create(&image, small_width, small_height, &err));
    for (size_t k = 0; k < repetitions; ++k) {
        OWNED(iso_samples) s;
        iso_noise_test t;
        assert_ok(iso_samples_create(&s, &reference, &err));
        for (size_t j = 0; j < n; ++j) {
            double value = 0;
            for (size_t i = 0; i < small_tests; ++i) {
                if (kind != NOISE_ALIKE || i % 4 == 0)
                    value = kind == NOISE_UNIFORM ? sqrt(12) * (uniform01(&state) - 0.5) : normal(&state);
                image.rgba[i] = (float)(value + (i == 0 || (everywhere && i % 4 == 0) ? offset : 0));
            }
            assert_ok(iso_samples_add(&s, &image, &err));
        }
        assert_ok(iso_samples_test(&s, &(iso_noise_options){.significance = significance}, &t, &err));
        r.pixels += (t.rejected > 0) / (double)repetitions;
        r.bias += t.biased / (double)repetitions;
    }
    return r;
}

/* Binomial: four standard deviations, at these fixed seeds. */
static void expect_rate(const char *what, double seen, double expected, size_t repetitions)
{
    const double deviation = sqrt(expected * (1 - expected) / (double)repetitions);
    if (!(fabs(seen - expected) <= 4 * deviation))
        fail_msg("%s: a rate of %g, expected %g +- %g", what, seen, expected, deviation);
}

TEST(noise_alone_is_flagged_as_often_as_was_said)
{
    for (size_t n = 3; n <= 8; n = 2 * n - 2) { /* 3, 4, 6 */
        rates r = measure_rates(NOISE_NORMAL, n, 1500, 0.05, 0, false);
        expect_rate("pixels", r.pixels, 0.05, 1500);
        expect_rate("bias", r.bias, 0.05, 1500);
    }
    rates strict = measure_rates(NOISE_NORMAL, 4, 8000, 0.001, 0, false); /* what the gates ask */
    expect_rate("pixels at 1e-3", strict.pixels, 0.001, 8000);
    expect_rate("bias at 1e-3", strict.bias, 0.001, 8000);
}

/* Sidak's bound: tests that go together are flagged together, and the rate is lower. Four channels count as one. */
TEST(channels_that_are_alike_are_flagged_less_often)
{
    rates r = measure_rates(NOISE_ALIKE, 4, 3000, 0.1, 0, false);
    expect_rate("pixels", r.pixels, 1 - pow(0.9, 0.25), 3000);
    expect_rate("bias", r.bias, 1 - pow(0.9, 0.25), 3000);
}

/* n values of density f are alike at x with a chance that goes as x^(n-1) f(x)^n: integrated, 1/32 for the uniform
 * density and 1/(16 pi^2) for the normal one, both of variance 1. */
TEST(bounded_noise_is_flagged_five_times_as_often)
{
    const double times = 16 * acos(-1) * acos(-1) / 32;
    rates r = measure_rates(NOISE_UNIFORM, 4, 3000, 0.01, 0, false);
    expect_rate("pixels", r.pixels, 1 - pow(0.99, times), 3000);
}

static double critical(double p, double freedom)
{
    double lo = 0, hi = 1e6;
    for (int i = 0; i < 100; ++i) {
        double middle = 0.5 * (lo + hi);
        *(iso_student_two_sided(middle, freedom) > p ? &lo : &hi) = middle;
    }
    return lo;
}

/* P(|T| > t) of the noncentral distribution: Z + shift over sqrt(chi squared / freedom), integrated over chi. */
static double noncentral_tail(double t, double freedom, double shift)
{
    const double h = 1e-3, front = log(2) * (1 - freedom / 2) - lgamma(freedom / 2);
    double sum = 0;
    for (double chi = h / 2; chi < 12; chi += h) {
        double reach = t * chi / sqrt(freedom);
        double density = exp(front + (freedom - 1) * log(chi) - chi * chi / 2);
        sum += h * density * 0.5 * (erfc((reach - shift) / sqrt(2)) + erfc((reach + shift) / sqrt(2)));
    }
    return sum;
}

/* What a planted offset of known size is caught with: computed, and seen. */
TEST(a_planted_offset_is_caught_as_often_as_computed)
{
    assert_within(noncentral_tail(2.776445105, 4, 0), 0.05, 1e-6); /* the integral's step */
    for (size_t n = 4; n <= 8; n += 4) {
        const double freedom = (double)n - 1, alpha = 1 - pow(0.95, 1.0 / small_tests), channel = 1 - pow(0.95, 0.25);
        const double offset = n == 4 ? 6 : 2.5, mean_offset = 0.3;
        const double one = noncentral_tail(critical(alpha, freedom), freedom, offset * sqrt((double)n));
        const double all = noncentral_tail(critical(channel, freedom), freedom,
                                           mean_offset * sqrt((double)n * small_tests / 4));
        rates r = measure_rates(NOISE_NORMAL, n, 1500, 0.05, offset, false);
        assert_true(one > 0.2 && one < 0.95 && all > 0.2 && all < 0.95); /* neither never nor always */
        expect_rate("one pixel", r.pixels, 1 - (1 - one) * pow(0.95, 1 - 1.0 / small_tests), 1500);
        r = measure_rates(NOISE_NORMAL, n, 1500, 0.05, mean_offset, true);
        expect_rate("all pixels", r.bias, 1 - (1 - all) * pow(0.95, 0.75), 1500);
    }
}

TEST(critical_values_are_those_of_the_header)
{
    const double n[] = {3, 4, 8, 16}, pixel[] = {2023, 208, 19.4, 8.85}, bias[] = {63.2, 20.6, 6.81, 4.77},
                 beside[] = {25.4, 19.4, 11.2, 7.80};
    for (int i = 0; i < 4; ++i) {
        assert_within(critical(1 - pow(0.999, 1.0 / 4096), n[i] - 1) / pixel[i], 1, 3e-3); /* as printed */
        assert_within(critical(1 - pow(0.999, 1.0 / 4096), n[i] - 1 + ISO_NOISE_NEIGHBORS) / beside[i], 1, 4e-3);
        assert_within(critical(1 - pow(0.999, 0.25), n[i] - 1) / bias[i], 1, 3e-3);
    }
}

/* Red up and blue down; and alpha alone: neither shows in the mean of all channels' colors. */
TEST(channels_do_not_cancel_and_alpha_counts)
{
    const double offsets[2][4] = {{0.01, 0, -0.01, 0}, {0, 0, 0, 0.01}};
    for (int k = 0; k < 2; ++k) {
        uint64_t random = 77;
        OWNED(iso_image) reference, image;
        OWNED(iso_samples) s;
        iso_noise_test t;
        assert_ok(iso_image_create(&reference, 16, 16, &err));
        assert_ok(iso_image_create(&image, 16, 16, &err));
        assert_ok(iso_samples_create(&s, &reference, &err));
        for (int j = 0; j < 4; ++j) {
            for (size_t i = 0; i < 4 * 16 * 16; ++i)
                image.rgba[i] = (float)(0.005 * normal(&random) + offsets[k][i % 4]);
            assert_ok(iso_samples_add(&s, &image, &err));
        }
        assert_ok(iso_samples_test(&s, &(iso_noise_options){.significance = 0.001}, &t, &err));
        assert_true(t.biased);
        assert_true(k == 0 ? t.bias_channel == 0 || t.bias_channel == 2 : t.bias_channel == 3);
    }
}

TEST(mean_and_bias_are_those_of_the_images)
{
    uint64_t random = 5;
    OWNED(iso_image)
    reference = rendered(0, 1, 0, 0, &random),
    a = rendered(0, 1, 0.01, 0, &random), b = rendered(0, 1, 0.03, 0, &random);
    OWNED(iso_samples) s;
    iso_noise_test t;
    assert_ok(iso_samples_create(&s, &reference, &err));
    assert_ok(iso_samples_add(&s, &a, &err));
    assert_ok(iso_samples_add(&s, &b, &err));
    assert_ok(iso_samples_test(&s, &(iso_noise_options){.significance = 0.01}, &t, &err));
    assert_within(s.mean[0], truth(0, 0, 0) + 0.02, 1e-7); /* float images */
    assert_within(t.bias, 0.02, 1e-7);
    assert_within(t.bias_error, 0.01, 1e-7); /* deviation .0141, over the root of 2 */
}

TEST(bad_samples_are_refused)
{
    uint64_t random = 5;
    iso_image reference = rendered(0, 1, 0, 0, &random), bad = rendered(0, 1, 0, 0, &random), small, none = {0};
    OWNED(iso_samples) s;
    iso_noise_test t;
    assert_ok(iso_image_create(&small, 3, 3, &err));
    assert_status(iso_samples_create(&s, &none, &err), ISO_E_RANGE);
    assert_ok(iso_samples_create(&s, &reference, &err));
    assert_status(iso_samples_test(&s, &(iso_noise_options){.significance = 0.01}, &t, &err), ISO_E_RANGE);
    assert_status(iso_samples_add(&s, &small, &err), ISO_E_RANGE);
    bad.rgba[5] = NAN;
    assert_status(iso_samples_add(&s, &bad, &err), ISO_E_RANGE);
    assert_ok(iso_samples_add(&s, &reference, &err));
    assert_ok(iso_samples_add(&s, &reference, &err));
    assert_int_equal(s.count, 2);
    assert_status(iso_samples_test(&s, &(iso_noise_options){.significance = 0}, &t, &err), ISO_E_RANGE);
    assert_status(iso_samples_test(&s, &(iso_noise_options){.significance = 0.01, .tolerance = NAN}, &t, &err),
                  ISO_E_RANGE);
    assert_status(iso_samples_test(&s, &(iso_noise_options){.significance = 0.01, .bias_tolerance = -1}, &t, &err),
                  ISO_E_RANGE);
    iso_image_destroy(&reference);
    iso_image_destroy(&bad);
    iso_image_destroy(&small);
}

/* limit + c(x, y) h^order */
static iso_image at_step(double h, double order)
{
    iso_image image;
    assert_ok(iso_image_create(&image, width, height, &err));
    for (size_t i = 0; i < 4 * (size_t)width * height; ++i) {
        double limit = truth(i / 4 % width, i / 4 / width, i % 4), c = 0.3 * cos(0.1 * (double)i);
        image.rgba[i] = (float)(limit + c * pow(h, order));
    }
    return image;
}

TEST(richardson_finds_the_limit_and_the_bar_of_a_power_law)
{
    for (double order = 1; order <= 4; ++order) {
        OWNED(iso_image) coarse = at_step(0.5, order), fine = at_step(0.25, order), exact = at_step(0, 1), limit;
        iso_extrapolation out;
        assert_ok(iso_richardson(&coarse, &fine, 2, order, &limit, &out, &err));
        double squares = 0, largest = 0;
        for (size_t i = 0; i < 4 * (size_t)width * height; ++i) {
            assert_within(limit.rgba[i], exact.rgba[i], 4e-7); /* three float roundings, doubled by extrapolation */
            double d = fabs((double)fine.rgba[i] - (double)exact.rgba[i]);
            squares += d * d;
            largest = fmax(largest, d);
        }
        assert_within(out.error_bar, sqrt(squares / (4 * width * height)), 2e-7);
        assert_within(out.error_bar_max, largest, 4e-7);
    }
}

/* Where the step is not resolved the error is of first order: extrapolated as if of second, it is two bars off. */
TEST(a_limit_of_first_order_is_two_bars_off)
{
    iso_image coarse = at_step(0.5, 1), fine = at_step(0.25, 1), exact = at_step(0, 1), limit;
    iso_extrapolation out;
    assert_ok(iso_richardson(&coarse, &fine, 2, 2, &limit, &out, &err));
    double squares = 0;
    for (size_t i = 0; i < 4 * (size_t)width * height; ++i)
        squares += pow((double)limit.rgba[i] - (double)exact.rgba[i], 2);
    assert_within(sqrt(squares / (4 * width * height)) / out.error_bar, 2, 1e-5); /* floats against bars of .02 */
    iso_image *const all[] = {&coarse, &fine, &exact, &limit};
    for (int i = 0; i < 4; ++i)
        iso_image_destroy(all[i]);
}

TEST(limits_with_a_planted_fault_do_not_agree)
{
    iso_image c1 = at_step(0.1, 2), f1 = at_step(0.05, 2), c2 = at_step(0.08, 1), f2 = at_step(0.04, 1), l1, l2;
    iso_extrapolation e1, e2;
    assert_ok(iso_richardson(&c1, &f1, 2, 2, &l1, &e1, &err));
    assert_ok(iso_richardson(&c2, &f2, 2, 1, &l2, &e2, &err));
    double clean = 0, shifted = 0;
    for (size_t i = 0; i < 4 * (size_t)width * height; ++i) {
        size_t beside = i + 4 < 4 * (size_t)width * height ? i + 4 : i;
        clean += pow(l1.rgba[i] - l2.rgba[i], 2);
        shifted += pow(l1.rgba[i] - 0.5 * (l2.rgba[i] + l2.rgba[beside]), 2);
    }
    clean = sqrt(clean / (4 * width * height));
    shifted = sqrt(shifted / (4 * width * height));
    assert_at_most(clean, hypot(e1.error_bar, e2.error_bar));
    assert_more_than(shifted, hypot(e1.error_bar, e2.error_bar)); /* half a pixel */
    iso_image *const all[] = {&c1, &f1, &c2, &f2, &l1, &l2};
    for (int i = 0; i < 6; ++i)
        iso_image_destroy(all[i]);
}

TEST(bad_extrapolations_are_refused)
{
    OWNED(iso_image) a = at_step(0.5, 1), small, limit = {0};
    iso_extrapolation out;
    assert_ok(iso_image_create(&small, 3, 3, &err));
    assert_status(iso_richardson(&a, &small, 2, 1, &limit, &out, &err), ISO_E_RANGE);
    assert_status(iso_richardson(&a, &a, 1, 1, &limit, &out, &err), ISO_E_RANGE);
    assert_status(iso_richardson(&a, &a, 2, 0, &limit, &out, &err), ISO_E_RANGE);
    assert_status(iso_richardson(&a, &a, NAN, 1, &limit, &out, &err), ISO_E_RANGE);
    a.rgba[9] = NAN;
    assert_ok(iso_richardson(&a, &a, 2, 1, &limit, &out, &err));
    assert_true(isinf(out.error_bar) && isinf(out.error_bar_max));
}

TEST_MAIN(NULL, NULL)

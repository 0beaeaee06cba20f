/* SPDX-License-Identifier: MIT */
/* Pixels beyond chance, with synthetic frames of a random renderer: blocks that are wrong are rejected, of whatever
 * part of an image; frames whose noise is as uneven as that of Cycles pass; and only what the reference excuses is
 * excused. */
#include "test.h"
#include "validate/validate.h"

static double uniform01(uint64_t *state)
{
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    return (double)(*state >> 11) / 9007199254740992.0;
}

/* Square pictures. step: what the finer step is off in one row of them; block: so many pixels squared, off by amount in
 * all frames; shift: what every value is off in all frames. */
typedef struct frames {
    size_t side, seeds, block;
    double step, noise, amount, shift;
    uint64_t random;
} frames;

static double truth_at(size_t x, size_t y, size_t c)
{
    return 0.5 + 0.3 * sin(0.1 * (double)x + (double)c) * cos(0.07 * (double)y);
}

static iso_image truth_of(const frames *f)
{
    iso_image image;
    assert_ok(iso_image_create(&image, f->side, f->side, &err));
    for (size_t i = 0; i < 4 * f->side * f->side; ++i)
        image.rgba[i] = (float)truth_at(i / 4 % f->side, i / 4 / f->side, i % 4);
    return image;
}

/* Of second order in the step, with noise that is nearly yes or no in every third column, and bounded elsewhere. */
static iso_image frame_of(frames *f, bool coarse)
{
    iso_image image = truth_of(f);
    const size_t from = f->side / 2;
    for (size_t i = 0; i < 4 * f->side * f->side; ++i) {
        const size_t x = i / 4 % f->side, y = i / 4 / f->side;
        const double u = uniform01(&f->random), jump = x % 3 == 0 ? (u < 0.2 ? 4 : -1) : sqrt(12) * (u - 0.5);
        const double here = y == 3 ? f->step : 2e-5, size = (1 + sin(0.3 * (double)y)) * (coarse ? 2 : 1);
        const bool wrong = i % 4 < 3 && x >= from && x < from + f->block && y >= from && y < from + f->block;
        image.rgba[i] += (float)((coarse ? 4 : 1) * here + f->noise * size * jump + (wrong ? f->amount : 0) + f->shift);
    }
    return image;
}

static iso_extrapolated extrapolate(frames *f, const iso_image *unsteady)
{
    iso_image images[2 * ISO_EXTRAPOLATION_MAX_SEEDS], reference = truth_of(f);
    iso_extrapolated limit = {.seeds = f->seeds};
    f->random = 0x9E3779B97F4A7C15u + f->random;
    for (size_t k = 0; k < 2 * f->seeds; ++k)
        images[k] = frame_of(f, k < f->seeds);
    assert_ok(iso_extrapolate(&(iso_extrapolation_input){images, f->seeds, &reference, 2, unsteady, false}, &limit, &err));
    for (size_t k = 0; k < 2 * f->seeds; ++k)
        iso_image_destroy(&images[k]);
    iso_image_destroy(&reference);
    return limit;
}

static bool gate_rejects(iso_gate gate, const iso_extrapolated *limit, bool sharp)
{
    const iso_scene_agreement asked = {.tier = ISO_TIER_CONVERGENCE, .sharp = sharp};
    iso_report_agreement row = {.a = "a", .renderer = "b"};
    iso_validate_limit_row(&asked, limit, &row);
    for (size_t i = 0; i < row.gate_count; ++i)
        if (row.gates[i].gate == gate)
            return !(row.gates[i].value <= row.gates[i].limit);
    fail_msg("the row lacks the gate %d", (int)gate);
    return false;
}

/* Whether the gate of pixels rejects the row. */
static bool is_rejected(const iso_extrapolated *limit, bool sharp)
{
    return gate_rejects(ISO_GATE_PIXELS, limit, sharp);
}

/* The tolerance of every pixel was once that of the worst one: 2 x .02 in the row that the step does not resolve. */
TEST(a_block_is_rejected_though_the_step_errs_elsewhere)
{
    const size_t seeds[] = {3, 4, 16};
    for (int i = 0; i < 3; ++i)
        for (uint64_t k = 0; k < 3; ++k) {
            frames f = {.side = 96, .seeds = seeds[i], .block = 10, .step = 0.02, .noise = 3e-4, .random = k};
            iso_extrapolated limit = extrapolate(&f, NULL);
            assert_false(is_rejected(&limit, false));
            iso_extrapolated_destroy(&limit);
            f.amount = 8.7 / 255;
            limit = extrapolate(&f, NULL);
            assert_true(is_rejected(&limit, false));
            assert_true(limit.noise.rejected >= 250 && limit.noise.rejected <= 300);
            assert_true(limit.noise.worst[0] >= 48 && limit.noise.worst[0] < 58);
            assert_more_than(limit.noise.tolerance_largest, 0.04);
            assert_at_most(limit.noise.tolerance_median, 0.01);
            iso_extrapolated_destroy(&limit);
        }
}

/* 192 values of four million were once fewer than might be beyond chance. */
VALUES_TEST(a_block_of_a_large_image_is_rejected)
{
    frames f = {.side = 1024, .seeds = 3, .block = 8, .step = 0.045, .noise = 1e-3, .amount = 0.4, .random = 1};
    OWNED(iso_extrapolated) limit = extrapolate(&f, NULL);
    assert_true(is_rejected(&limit, true));
    assert_int_equal(limit.noise.rejected, 192);
}

/* 200 groups of each number of seeds: below 1.5 % at 95 % confidence. */
VALUES_TEST(uneven_noise_alone_is_not_rejected)
{
    const size_t seeds[] = {3, 4, 16};
    for (int i = 0; i < 3; ++i)
        for (uint64_t k = 0; k < 200; ++k) {
            frames f = {.side = 24, .seeds = seeds[i], .step = 0.01, .noise = 1e-3, .random = 100 + k};
            OWNED(iso_extrapolated) limit = extrapolate(&f, NULL);
            if (is_rejected(&limit, true))
                fail_msg("%zu seeds, group %d: %zu values beyond chance", seeds[i], (int)k, limit.noise.rejected);
        }
}

/* One pixel is off by 2e-3. It is excused where the reference moves there, up to a step of 8 bits, and where few
 * are. */
TEST(only_what_the_reference_moves_is_excused)
{
    const struct {
        double amount, moves;
        size_t block;
        bool rejected;
    } cases[] = {{2e-3, 0, 1, true},       /* it does not move */
                 {2e-3, 2.2e-3, 1, false}, /* it does, by more */
                 {2e-3, 1e-3, 1, true},    /* it moves, but not enough */
                 {8e-3, 0.5, 1, true},     /* more than a step of 8 bits */
                 {2e-3, 2.2e-3, 9, true}}; /* 243 values of 16384, more than half a percent */
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        frames f = {.side = 64,
                    .seeds = 4,
                    .block = cases[i].block,
                    .step = 2e-5,
                    .noise = 1e-6,
                    .random = i,
                    .amount = cases[i].amount};
        OWNED(iso_image) unsteady;
        assert_ok(iso_image_create(&unsteady, f.side, f.side, &err));
        for (size_t k = 0; k < 4 * f.side * f.side; ++k)
            unsteady.rgba[k] = (float)cases[i].moves;
        OWNED(iso_extrapolated) limit = extrapolate(&f, &unsteady);
        assert_int_equal(is_rejected(&limit, false), cases[i].rejected);
        if (!cases[i].rejected) {
            assert_int_equal(limit.noise.excused, 3);
            assert_within(limit.noise.largest_excused, cases[i].amount,
                          1e-4); /* less a tolerance of 5e-5 and some noise */
        }
    }
}

/* As much as most pixels' noise: the mean of 8 frames shows it in few single pixels, a channel's mean shows it
 * surely. */
TEST(a_shift_that_no_pixel_shows_is_a_bias)
{
    for (uint64_t k = 0; k < 5; ++k) {
        frames f = {.side = 48, .seeds = 8, .step = 2e-5, .noise = 5e-3, .random = k};
        iso_extrapolated limit = extrapolate(&f, NULL);
        assert_false(gate_rejects(ISO_GATE_BIAS, &limit, false));
        iso_extrapolated_destroy(&limit);
        f.shift = 5e-3;
        limit = extrapolate(&f, NULL);
        assert_true(gate_rejects(ISO_GATE_BIAS, &limit, false));
        iso_extrapolated_destroy(&limit);
    }
}

TEST_MAIN(NULL, NULL)

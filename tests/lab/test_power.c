/* SPDX-License-Identifier: MIT */
/* test_power.c - what is planted is what its name says, and the gates of validation answer for random scenes. */
#include "lab/frame_cache.h"
#include "lab/power.h"
#include "tests/test.h"
#include "tests/cycles.h"

static iso_renderers renderers;

static int end_renderers(void **state)
{
    (void)state;
    iso_renderers_end(&renderers);
    return 0;
}

static iso_power_case open_case(uint64_t seed)
{
    iso_power_case c = {.seed = seed, .pixels = 12, .seeds = 3, .threads = 1};
    assert_ok(iso_power_open(&renderers, &c, &err));
    return c;
}

static double change(const iso_power_case *c, iso_planted planted)
{
    double rmse;
    assert_ok(iso_power_change(&renderers, c, &planted, &rmse, &err));
    return rmse;
}

static bool is_rejected(const iso_power_case *c, iso_power_gate gate, const iso_planted *planted)
{
    bool rejected;
    assert_ok(iso_power_run_gate(&renderers, c, gate, &iso_renderer_gl, planted, &rejected, &err));
    assert_null(renderers.after.change);
    return rejected;
}

TEST(kinds_take_turns_and_bright_ones_are_above_1)
{
    for (uint64_t seed = 500; seed < 504; ++seed) {
        iso_power_case c = open_case(seed);
        assert_int_equal(c.kind, seed % ISO_POWER_KIND_COUNT);
        assert_int_equal(c.asked.sharp, c.kind == ISO_POWER_SHARP);
        assert_int_equal(c.asked.tier == ISO_TIER_LIT, c.kind == ISO_POWER_LIT);
        if (c.kind == ISO_POWER_BRIGHT) {
            assert_more_than(c.brightest, 1);
            assert_more_than(change(&c, (iso_planted){.fault = ISO_FAULT_CLIPPED}), iso_validate_error_bar(&c.asked));
        }
        iso_power_close(&c);
    }
}

TEST(nothing_changes_nothing)
{
    iso_power_case c = open_case(500);
    assert_within(change(&c, (iso_planted){0}), 0, 0);
    for (int d = ISO_DEVIATION_NONE + 1; d < ISO_DEVIATION_COUNT; ++d)
        assert_at_most(change(&c, (iso_planted){.deviation = (iso_deviation)d}), 1e-7); /* directions are coded again */
    iso_power_close(&c);
}

/* A tenth of a small amount changes a picture by about a tenth: nothing is lost or clamped on the way. */
TEST(deviations_change_a_picture_in_proportion)
{
    iso_power_case c = open_case(501);
    for (int d = ISO_DEVIATION_NONE + 1; d < ISO_DEVIATION_COUNT; ++d) {
        const double most = iso_deviation_most((iso_deviation)d);
        double whole = change(&c, (iso_planted){.deviation = (iso_deviation)d, .amount = most / 8});
        double tenth = change(&c, (iso_planted){.deviation = (iso_deviation)d, .amount = most / 80});
        /* 0.3 degrees are below the directions' codes, which then turn by all or nothing */
        if (!(tenth > 0.05 * whole && tenth < 0.3 * whole))
            fail_msg("%s: %g by an eighth of %g, %g by a tenth of that", iso_deviation_name((iso_deviation)d), whole,
                     most, tenth);
    }
    iso_power_close(&c);
}

TEST(every_fault_changes_some_scene)
{
    size_t seen[ISO_FAULT_COUNT] = {0};
    for (uint64_t seed = 504; seed < 506; ++seed) {
        iso_power_case c = open_case(seed);
        for (int f = ISO_FAULT_NONE + 1; f < ISO_FAULT_COUNT; ++f)
            seen[f] += change(&c, (iso_planted){.fault = (iso_fault)f}) > iso_validate_error_bar(&c.asked);
        iso_power_close(&c);
    }
    for (int f = ISO_FAULT_NONE + 1; f < ISO_FAULT_COUNT; ++f)
        if (!seen[f])
            fail_msg("%s: changes neither scene", iso_fault_name((iso_fault)f));
}

/* 16 bits a channel are coarser where the highlights' peak is high. */
TEST(a_bright_scene_of_povray_passes)
{
    bool rejected;
    iso_power_case c = open_case(505);
    assert_more_than(c.lock_step[iso_renderer_index(&iso_renderer_povray)].max_abs, 2.5e-5);
    assert_ok(iso_power_run_gate(&renderers, &c, ISO_POWER_LOCK_STEP, &iso_renderer_povray, NULL, &rejected, &err));
    assert_false(rejected);
    assert_ok(iso_power_run_gate(&renderers, &c, ISO_POWER_LOCK_STEP, &iso_renderer_povray,
                                 &(iso_planted){.fault = ISO_FAULT_CLIPPED}, &rejected, &err));
    assert_true(rejected);
    iso_power_close(&c);
}

/* What the ray caster is asked. The faults of the picture have to reach the limit's frames, too. */
TEST(clean_scenes_pass_and_faulty_ones_do_not)
{
    const iso_fault faults[] = {ISO_FAULT_MIRRORED, ISO_FAULT_PREMULTIPLIED, ISO_FAULT_CLIPPED, ISO_FAULT_LEVEL,
                                ISO_FAULT_ONE_SIDED};
    iso_power_case c = open_case(505);
    for (int g = 0; g < ISO_POWER_GATE_COUNT; ++g) {
        const iso_power_gate gate = (iso_power_gate)g;
        assert_false(is_rejected(&c, gate, NULL));
        for (size_t i = 0; i < sizeof faults / sizeof *faults; ++i)
            if (!is_rejected(&c, gate, &(iso_planted){.fault = faults[i]}))
                fail_msg("%s: not caught by the %s", iso_fault_name(faults[i]), iso_power_gate_name(gate));
    }
    iso_power_close(&c);
}

/* The limit's gates have bars of 1/2550, lock-step has single precision: a deviation between them tells the two
 * apart. */
TEST(lock_step_sees_what_a_limit_cannot)
{
    iso_power_case c = open_case(504);
    const iso_planted tiny = {.deviation = ISO_DEVIATION_UNIT, .amount = 0.01},
                      little = {.deviation = ISO_DEVIATION_UNIT, .amount = 2};
    assert_true(is_rejected(&c, ISO_POWER_LOCK_STEP, &tiny));
    assert_false(is_rejected(&c, ISO_POWER_LIMIT, &tiny));
    assert_true(is_rejected(&c, ISO_POWER_LIMIT, &little));
    iso_power_close(&c);
}

/* The renderer's scene deviates from the reference's, or the reference's the other way from the renderer's: it is the
 * same question, and the second needs the renderer's images once. */
TEST(a_deviation_may_be_planted_on_the_other_side)
{
    const iso_deviation asked[] = {ISO_DEVIATION_SHIFT, ISO_DEVIATION_UNIT, ISO_DEVIATION_PIXEL};
    iso_power_case c = open_case(504);
    iso_frame_cache cache = {0};
    size_t answers[2] = {0};
    for (size_t d = 0; d < sizeof asked / sizeof *asked; ++d)
        for (double part = 1e-6; part < 0.1; part *= 100) {
            const iso_planted planted = {.deviation = asked[d], .amount = part * iso_deviation_most(asked[d])};
            const iso_planted twice = iso_planted_inverse(
                &(iso_planted){.deviation = asked[d], .amount = iso_planted_inverse(&planted).amount});
            assert_within(twice.amount / planted.amount, 1, 1e-6); /* 1 + a few 1e-8 and back */
            for (int g = 0; g < ISO_POWER_GATE_COUNT; ++g) {
                bool there;
                const bool here = is_rejected(&c, (iso_power_gate)g, &planted);
                iso_frame_cache_use(&renderers, &cache);
                assert_ok(iso_power_run_deviation_gate(&renderers, &c, (iso_power_gate)g, &iso_renderer_gl,
                                                       &(iso_planted){.deviation = asked[d], .amount = planted.amount},
                                                       &there, &err));
                iso_frame_cache_use(&renderers, NULL);
                assert_int_equal(here, there);
                answers[here] += 1;
            }
        }
    assert_true(answers[0] >= 4 && answers[1] >= 4);
    assert_true(cache.count >= 2 && cache.count <= 5); /* a lock-step's image, and those of a few steps */
    iso_frame_cache_clear(&cache);
    iso_power_close(&c);
}

/* Three seeds see a block of a few steps of 8 bits; of how many seeds there are not, nothing is said. */
TEST(few_seeds_of_cycles_see_a_block)
{
    if (!cycles_shows_volumes())
        skip();
    iso_power_case c = open_case(500);
    iso_power_noise n;
    assert_ok(iso_power_test_noise(&renderers, &c, &iso_renderer_cycles, 2, &n, &err));
    assert_int_equal(n.groups, 2);
    assert_int_equal(n.flagged, 0);
    for (int b = 0; b < ISO_POWER_BLOCKS; ++b) {
        assert_true(n.block[0][b] > 1e-4 && n.block[0][b] < 0.05);
        assert_true(n.block[1][b] > 1e-4 && n.block[1][b] < 0.05);
        assert_within(n.block[2][b], 0, 0);
    }
    iso_power_close(&c);
}

/* A NaN is a row that differs, by every renderer, not the end of the validation. */
/* Clopper and Pearson's one-sided bounds, as tables have them. */
TEST(rates_are_bounded_as_tables_say)
{
    assert_within(iso_power_rate_bound(0, 300), 1 - pow(0.05, 1.0 / 300), 1e-12);
    assert_within(iso_power_rate_bound(1, 10), 0.39416, 1e-5);
    assert_within(iso_power_rate_bound(5, 100), 0.10226, 1e-5);
    assert_within(iso_power_rate_bound(10, 10), 1, 0);
}

/* A row of any section, also of an unknown one: what is right must not differ anywhere. */
TEST(an_alarm_is_found_in_any_section)
{
    const char *const alarms[] = {
        "{\"agreement\": [{\"verdict\": \"agree\"}, {\"b\": \"gl\", \"verdict\": \"differ\"}]}",
        "{\"levels\": [{\"level\": 2, \"verdict\": \"differ\"}]}",
        "{\"calibration\": [{\"check\": \"slab\", \"verdict\": \"fail\"}]}",
        "{\"made_up\": [{\"verdict\": \"no word\"}]}"};
    char text[200];
    for (size_t i = 0; i < sizeof alarms / sizeof *alarms; ++i) {
        json_t *report = json_loads(alarms[i], 0, NULL);
        assert_true(iso_power_is_alarm(report, text, sizeof text));
        json_decref(report);
    }
    json_t *report = json_loads("{\"agreement\": [{\"verdict\": \"agree\"}, {\"verdict\": \"not compared\"}],"
                                " \"consistency\": [{\"level\": 1}]}",
                                0, NULL);
    assert_false(iso_power_is_alarm(report, text, sizeof text));
    json_decref(report);
}

/* Only pictures that are behind the simple way's may be a finding; anything else that is flagged stays a false alarm. */
TEST(a_finding_is_of_pictures_alone)
{
    static const struct {
        bool is_finding;
        const char *more; /* keys of the level's row, or sections */
    } cases[] = {{true, ", \"simple_held\": false, \"bound\": {\"held\": true}, \"figures\": [{\"held\": true}]}]"},
                 {false, ", \"simple_held\": true}]"},
                 {false, ", \"simple_held\": false, \"bound\": {\"held\": false}}]"},
                 {false, ", \"simple_held\": false, \"stored\": {\"held\": false}}]"},
                 {false, ", \"simple_held\": false, \"extinction_scale\": {\"held\": false}}]"},
                 {false, ", \"simple_held\": false, \"figures\": [{\"held\": false}]}]"},
                 {false, ", \"simple_held\": false}], \"agreement\": [{\"verdict\": \"differ\"}]"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        char text[400];
        snprintf(text, sizeof text, "{\"levels\": [{\"level\": 1, \"verdict\": \"differ\"%s}", cases[i].more);
        json_auto_t *report = json_loads(text, 0, NULL);
        assert_non_null(report);
        assert_true(iso_power_is_finding(report) == cases[i].is_finding);
    }
    json_auto_t *clean = json_loads("{\"levels\": [{\"verdict\": \"agree\", \"simple_held\": false}]}", 0, NULL);
    assert_false(iso_power_is_finding(clean));
}

TEST(a_pixel_that_is_no_number_is_rejected)
{
    const iso_planted nan_pixel = {.deviation = ISO_DEVIATION_PIXEL, .amount = NAN};
    const iso_renderer_info *const renderer[] = {&iso_renderer_gl, &iso_renderer_cycles};
    const int count = cycles_shows_volumes() ? 2 : 1;
    iso_power_case c = open_case(500);
    for (int i = 0; i < count; ++i) {
        bool rejected;
        assert_ok(iso_power_run_gate(&renderers, &c, ISO_POWER_LIMIT, renderer[i], &nan_pixel, &rejected, &err));
        assert_true(rejected);
    }
    iso_power_close(&c);
}

TEST_MAIN(NULL, end_renderers)

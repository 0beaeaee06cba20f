/* SPDX-License-Identifier: MIT */
/* test_calibrate.c - each renderer passes its calibration, and each planted fault fails it. */
#include "base/work.h"
#include "lab/faults.h"
#include "test.h"
#include "cycles.h"

static iso_renderers renderers;

static int end_renderers(void **state)
{
    (void)state;
    iso_renderers_end(&renderers);
    return 0;
}

static int count_failures(const iso_renderer_info *which, iso_fault fault, iso_calibration c[ISO_CALIBRATION_COUNT])
{
    int failures = 0;
    size_t made;
    const iso_calibration_fault planted = iso_planted_calibration(&(iso_planted){.fault = fault});
    assert_ok(iso_calibrate(&renderers, which, &planted, c, &made, &err));
    for (int i = 0; i < ISO_CALIBRATION_COUNT; ++i)
        failures += !c[i].passed;
    return failures;
}

static void expect_trust(const iso_renderer_info *which)
{
    iso_calibration c[ISO_CALIBRATION_COUNT];
    int failures = count_failures(which, ISO_FAULT_NONE, c);
    for (int i = 0; i < ISO_CALIBRATION_COUNT; ++i)
        printf("%-10s %-18s %.3g %s, limit %g\n", which->name, c[i].check, c[i].value, c[i].unit, c[i].limit);
    assert_int_equal(failures, 0);
}

TEST(the_reference_passes_its_calibration)
{
    expect_trust(&iso_renderer_reference);
}

TEST(the_ray_caster_passes_its_calibration)
{
    expect_trust(&iso_renderer_gl);
}

TEST(the_cpu_ray_caster_passes_its_calibration)
{
    expect_trust(&iso_renderer_cpu);
}

/* By one start, and what single checks draw by starts of their own is the same to the last bit. */
VALUES_TEST(povray_passes_its_calibration_by_one_start)
{
    const char *single[] = {"placement", "view vector"};
    iso_calibration c[ISO_CALIBRATION_COUNT], one;
    const size_t before = iso_work_sum().starts;
    assert_int_equal(count_failures(&iso_renderer_povray, ISO_FAULT_NONE, c), 0);
    assert_int_equal(iso_work_sum().starts - before, 1);
    for (size_t i = 0; i < sizeof single / sizeof *single; ++i) {
        const int at = iso_calibration_number(single[i]);
        assert_ok(iso_calibrate_check(&renderers, &iso_renderer_povray, NULL, at, &one, &err));
        assert_true(one.value == c[at].value && one.passed);
    }
}

/* The pictures of the scenes, each for the next. */
static iso_status render_exchanged(const iso_render_request *scenes, size_t count, iso_image *images, iso_error *why)
{
    iso_status status = ISO_OK;
    iso_render_stats unused;
    for (size_t i = 0; i < count && status == ISO_OK; ++i)
        status = iso_renderer_reference.render(&scenes[i], &images[(i + 1) % count], &unused, why);
    return status;
}

static iso_status render_scenes_fails(const iso_render_request *scenes, size_t count, iso_image *images, iso_error *why)
{
    (void)scenes, (void)count, (void)images;
    return iso_fail(why, ISO_E_PROGRAM, "it crashed");
}

TEST(scenes_of_one_start_are_each_judged_by_their_own_picture)
{
    iso_calibration c[ISO_CALIBRATION_COUNT];
    iso_renderer_info together = iso_renderer_reference;
    together.render_scenes = render_exchanged;
    assert_int_equal(count_failures(&together, ISO_FAULT_NONE, c), ISO_CALIBRATION_COUNT);
    together.render_scenes = render_scenes_fails; /* then one by one */
    assert_int_equal(count_failures(&together, ISO_FAULT_NONE, c), 0);
}

TEST(cycles_passes_its_calibration)
{
    need_cycles();
    expect_trust(&iso_renderer_cycles);
}

/* For the two renderers that cost nothing to run. */
TEST(every_planted_fault_is_caught_by_the_check_that_is_made_for_it)
{
    static const struct {
        iso_fault fault;
        const char *text, *check;
    } faults[] = {
#define FAULT_ROW(name, text, check) {name, text, check},
        ISO_FAULT_LIST(FAULT_ROW)
#undef FAULT_ROW
    };
    for (size_t i = 0; i < sizeof faults / sizeof *faults; ++i)
        for (int w = 0; w < 2; ++w) {
            const iso_renderer_info *which = w ? &iso_renderer_gl : &iso_renderer_reference;
            iso_calibration c;
            const int at = iso_calibration_number(faults[i].check);
            const iso_calibration_fault fault = iso_planted_calibration(&(iso_planted){.fault = faults[i].fault});
            assert_ok(iso_calibrate_check(&renderers, which, &fault, at, &c, &err));
            assert_string_equal(c.check, faults[i].check);
            if (c.passed)
                fail_msg("%s: passed the check %s of %s with %g", faults[i].text, c.check, which->name, c.value);
            assert_more_than(c.value, 5 * c.limit); /* not by a hair */
        }
}

/* A fixed view vector in perspective, and a point of view where there is none: each has its own check. */
TEST(both_projections_have_their_view_vector_checked)
{
    iso_calibration c[ISO_CALIBRATION_COUNT];
    count_failures(&iso_renderer_gl, ISO_FAULT_VIEW_VECTOR, c);
    assert_more_than(c[iso_calibration_number("light")].value, 5 * c[iso_calibration_number("light")].limit);
    assert_more_than(c[iso_calibration_number("view vector")].value,
                     5 * c[iso_calibration_number("view vector")].limit);
    assert_true(c[iso_calibration_number("order")].passed);
}

static iso_status render_fails(const iso_render_request *q, iso_image *image, iso_render_stats *stats, iso_error *why)
{
    (void)q, (void)image, (void)stats;
    return iso_fail(why, ISO_E_PROGRAM, "it crashed");
}

/* A program may be ended, or crash, in any of the checks. */
TEST(a_renderer_that_fails_in_any_check_is_refused_with_its_reason)
{
    iso_renderer_info failing = iso_renderer_reference;
    failing.name = "failing";
    failing.render = render_fails;
    for (int i = 0; i < ISO_CALIBRATION_COUNT; ++i) {
        iso_calibration c;
        iso_error why = {""};
        assert_int_equal(iso_calibrate_check(&renderers, &failing, NULL, i, &c, &why), ISO_E_PROGRAM);
        assert_string_equal(why.text, "calibration of failing: it crashed");
        assert_false(c.passed);
    }
}

static iso_status render_a_hole(const iso_render_request *q, iso_image *image, iso_render_stats *stats, iso_error *why)
{
    const iso_status status = iso_renderer_reference.render(q, image, stats, why);
    for (int c = 0; c < 4 && status == ISO_OK; ++c)
        image->rgba[4 * (image->width * image->height / 2) + (size_t)c] = NAN;
    return status;
}

/* One pixel that is no number, with good ones behind it. */
TEST(what_is_no_number_passes_no_check)
{
    iso_renderer_info holed = iso_renderer_reference;
    holed.render = render_a_hole;
    for (int i = 0; i < ISO_CALIBRATION_COUNT; ++i) {
        iso_calibration c;
        iso_error why = {""};
        const iso_status status = iso_calibrate_check(&renderers, &holed, NULL, i, &c, &why);
        if (status == ISO_OK && c.passed)
            fail_msg("%s: passed with %g", c.check, c.value);
    }
}

static int wrong_channel;

static iso_status render_a_faint_channel(const iso_render_request *q, iso_image *image, iso_render_stats *stats,
                                         iso_error *why)
{
    const iso_status status = iso_renderer_reference.render(q, image, stats, why);
    for (size_t i = 0; status == ISO_OK && i < image->width * image->height; ++i)
        image->rgba[4 * i + (size_t)wrong_channel] *= 0.98F;
    return status;
}

/* A fiftieth less of red, green, blue or alpha alone. */
TEST(each_channel_is_looked_at)
{
    iso_renderer_info faint = iso_renderer_reference;
    faint.render = render_a_faint_channel;
    const int slab = iso_calibration_number("slab");
    for (wrong_channel = 0; wrong_channel < 4; ++wrong_channel) {
        iso_calibration c;
        iso_error why = {""};
        assert_int_equal(iso_calibrate_check(&renderers, &faint, NULL, slab, &c, &why), ISO_OK);
        if (c.passed)
            fail_msg("channel %d: passed with %g", wrong_channel, c.value);
    }
}

TEST_MAIN(NULL, end_renderers)

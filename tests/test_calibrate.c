/* SPDX-License-Identifier: MIT */
/* test_calibrate.c - each renderer passes its calibration, and each planted fault fails it. */
#include <string.h>

#include "validate/calibrate.h"
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
    assert_ok(iso_calibrate(&renderers, which, &(iso_planted){.fault = fault}, c, &made, NULL, &err));
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

static void the_reference_passes_its_calibration(void **state)
{
    (void)state;
    expect_trust(&iso_renderer_reference);
}

static void the_ray_caster_passes_its_calibration(void **state)
{
    (void)state;
    expect_trust(&iso_renderer_gl);
}

static void the_cpu_ray_caster_passes_its_calibration(void **state)
{
    (void)state;
    expect_trust(&iso_renderer_cpu);
}

static void povray_passes_its_calibration(void **state)
{
    (void)state;
    expect_trust(&iso_renderer_povray);
}

static void cycles_passes_its_calibration(void **state)
{
    (void)state;
    need_cycles();
    expect_trust(&iso_renderer_cycles);
}

/* For the two renderers that cost nothing to run. */
static void every_planted_fault_is_caught_by_the_check_that_is_made_for_it(void **state)
{
    static const struct {
        iso_fault fault;
        const char *text, *check;
    } faults[] = {
#define FAULT_ROW(name, text, check) {name, text, check},
        ISO_FAULT_LIST(FAULT_ROW)
#undef FAULT_ROW
    };
    (void)state;
    for (size_t i = 0; i < sizeof faults / sizeof *faults; ++i)
        for (int w = 0; w < 2; ++w) {
            const iso_renderer_info *which = w ? &iso_renderer_gl : &iso_renderer_reference;
            iso_calibration c[ISO_CALIBRATION_COUNT];
            const int at = iso_calibration_number(faults[i].check);
            count_failures(which, faults[i].fault, c);
            assert_string_equal(c[at].check, faults[i].check);
            if (c[at].passed)
                fail_msg("%s: passed the check %s of %s with %g", faults[i].text, c[at].check, which->name,
                         c[at].value);
            assert_more_than(c[at].value, 5 * c[at].limit); /* not by a hair */
        }
}

/* A fixed view vector in perspective, and a point of view where there is none: each has its own check. */
static void both_projections_have_their_view_vector_checked(void **state)
{
    iso_calibration c[ISO_CALIBRATION_COUNT];
    (void)state;
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
static void a_renderer_that_fails_in_any_check_is_refused_with_its_reason(void **state)
{
    (void)state;
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
static void what_is_no_number_passes_no_check(void **state)
{
    (void)state;
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
static void each_channel_is_looked_at(void **state)
{
    (void)state;
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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_reference_passes_its_calibration),
        cmocka_unit_test(the_ray_caster_passes_its_calibration),
        cmocka_unit_test(the_cpu_ray_caster_passes_its_calibration),
        cmocka_unit_test(povray_passes_its_calibration),
        cmocka_unit_test(cycles_passes_its_calibration),
        cmocka_unit_test(every_planted_fault_is_caught_by_the_check_that_is_made_for_it),
        cmocka_unit_test(a_renderer_that_fails_in_any_check_is_refused_with_its_reason),
        cmocka_unit_test(what_is_no_number_passes_no_check),
        cmocka_unit_test(each_channel_is_looked_at),
        cmocka_unit_test(both_projections_have_their_view_vector_checked),
    };
    return cmocka_run_group_tests(tests, NULL, end_renderers);
}

/* test_calibrate.c - each renderer passes its calibration, and each planted fault fails it. */
#include "cli/calibrate.h"
#include "test.h"

static iso_renderers renderers;

static int end_renderers(void **state)
{
    (void)state;
    iso_renderers_end(&renderers);
    return 0;
}

static int count_failures(iso_renderer which, iso_fault fault, iso_calibration c[ISO_CALIBRATION_COUNT])
{
    int failures = 0;
    assert_ok(iso_calibrate(&renderers, which, fault, c, NULL, &err));
    for (int i = 0; i < ISO_CALIBRATION_COUNT; ++i)
        failures += !c[i].passed;
    return failures;
}

static void expect_trust(iso_renderer which)
{
    iso_calibration c[ISO_CALIBRATION_COUNT];
    int failures = count_failures(which, ISO_FAULT_NONE, c);
    for (int i = 0; i < ISO_CALIBRATION_COUNT; ++i)
        printf("%-10s %-18s %.3g %s, limit %g\n", iso_renderer_name(which), c[i].check, c[i].value, c[i].unit, c[i].limit);
    assert_int_equal(failures, 0);
}

static void the_reference_passes_its_calibration(void **state)
{
    (void)state;
    expect_trust(ISO_WITH_REFERENCE);
}

static void the_ray_caster_passes_its_calibration(void **state)
{
    (void)state;
    expect_trust(ISO_WITH_GL);
}

static void povray_passes_its_calibration(void **state)
{
    (void)state;
    expect_trust(ISO_WITH_POVRAY);
}

static void cycles_passes_its_calibration(void **state)
{
    (void)state;
    expect_trust(ISO_WITH_CYCLES);
}

/* Which check must catch which fault, for the two renderers that cost nothing to run. */
static void every_planted_fault_is_caught_by_the_check_that_is_made_for_it(void **state)
{
    static const struct {
        iso_fault fault;
        int check;
    } faults[] = {{ISO_FAULT_HALF_VOXEL, 0}, {ISO_FAULT_HALF_VOXEL, 1}, {ISO_FAULT_UNIT, 1}, {ISO_FAULT_SRGB, 2},
                  {ISO_FAULT_UNIT, 2},       {ISO_FAULT_AXIS_SWAP, 3},  {ISO_FAULT_LIGHT, 3}};
    (void)state;
    for (size_t i = 0; i < sizeof faults / sizeof *faults; ++i)
        for (int which = ISO_WITH_REFERENCE; which <= ISO_WITH_GL; ++which) {
            iso_calibration c[ISO_CALIBRATION_COUNT];
            count_failures((iso_renderer)which, faults[i].fault, c);
            if (c[faults[i].check].passed)
                fail_msg("fault %d passed the check %s of %s with %g", (int)faults[i].fault, c[faults[i].check].check,
                         iso_renderer_name((iso_renderer)which), c[faults[i].check].value);
            assert_more_than(c[faults[i].check].value, 5 * c[faults[i].check].limit); /* not by a hair */
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_reference_passes_its_calibration),
        cmocka_unit_test(the_ray_caster_passes_its_calibration),
        cmocka_unit_test(povray_passes_its_calibration),
        cmocka_unit_test(cycles_passes_its_calibration),
        cmocka_unit_test(every_planted_fault_is_caught_by_the_check_that_is_made_for_it),
    };
    return cmocka_run_group_tests(tests, NULL, end_renderers);
}

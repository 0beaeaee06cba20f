/* SPDX-License-Identifier: MIT */
/* The power by which a command's time grows with the number of voxels: exact for times that follow one, and wrong by a
 * known amount where what a process costs is not taken off. */
#include "bench/growth.h"
#include "tests/test.h"

enum { SIZES = 5 };
static const double voxels[SIZES] = {64. * 64 * 64, 128. * 128 * 128, 256. * 256 * 256, 512. * 512 * 512,
                                     1024. * 1024 * 1024};

/* seconds = start + voxels^power times what makes 256^3 voxels take a second */
static void make_times(double power, double start, double seconds[SIZES])
{
    for (int i = 0; i < SIZES; ++i)
        seconds[i] = start + pow(voxels[i] / voxels[2], power);
}

TEST(powers_are_found)
{
    static const double powers[] = {0.667, 0.9, 1, 1.1, 2};
    for (size_t p = 0; p < sizeof powers / sizeof *powers; ++p) {
        double seconds[SIZES];
        make_times(powers[p], 0.01, seconds);
        assert_within(iso_growth_slope(voxels, seconds, SIZES, 0.01, NULL), powers[p], 1e-12); /* rounding */
    }
}

/* The planted fault: a cost that every size has, taken for time that grows, makes 1 look like less. */
TEST(a_start_that_is_not_taken_off_is_seen)
{
    double seconds[SIZES];
    make_times(1, 0.2, seconds);
    assert_true(iso_growth_slope(voxels, seconds, SIZES, 0, NULL) < 0.95);
    assert_within(iso_growth_slope(voxels, seconds, SIZES, 0.2, NULL), 1, 1e-12);
}

/* A start that is a third off moves the slope by less than the header says. */
TEST(sizes_whose_time_is_mostly_start_are_left_out)
{
    double seconds[SIZES];
    size_t used;
    make_times(1, 0.1, seconds); /* .102, .225, 1.1, 8.1, 64.1 */
    iso_growth_slope(voxels, seconds, SIZES, 0.1, &used);
    assert_int_equal(used, 3);
    assert_within(iso_growth_slope(voxels, seconds, SIZES, 0.1 * 2 / 3, &used), 1, 0.016);
}

TEST(what_was_not_measured_is_left_out)
{
    double seconds[SIZES];
    make_times(1, 0, seconds);
    seconds[0] = 0, seconds[3] = NAN;
    assert_within(iso_growth_slope(voxels, seconds, SIZES, 0, NULL), 1, 1e-12);
    assert_true(isnan(iso_growth_slope(voxels, seconds, 2, 0, NULL)));
}

TEST_MAIN(NULL, NULL)

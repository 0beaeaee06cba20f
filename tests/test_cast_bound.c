/* SPDX-License-Identifier: MIT */
/* What leaving out empty space can give at most: samples are counted where the answer is known, and times that are made
 * of known costs give the bound of these costs. */
#include "bench/cast_bound.h"
#include "test.h"

enum { SIDE = 24, SLAB = 6, PIXELS = 9 };

/* Value 1 in the middle voxels along z, else 0. */
static void make_slab(iso_level *level, float values[SIDE * SIDE * SIDE])
{
    const size_t size[3] = {SIDE, SIDE, SIDE};
    const double spacing[3] = {1, 1, 1};
    for (size_t i = 0; i < (size_t)SIDE * SIDE * SIDE; ++i) {
        const size_t z = i / (SIDE * SIDE);
        values[i] = z >= (SIDE - SLAB) / 2 && z < (SIDE + SLAB) / 2;
    }
    *level = (iso_level){.geometry = iso_geometry_axis_aligned(size, spacing), .scalar = values, .max = 1};
}

/* Along z, from whole millimeters: samples of a step of a voxel stand in the middles of voxels. Values above 1/2 have
 * an extinction. */
static iso_view view_along_z(float entries[8])
{
    return (iso_view){.width = PIXELS,
                      .height = PIXELS,
                      .step_voxels = 1,
                      .camera = {.orthographic = true,
                                 .position = {0, 0, -2 * SIDE},
                                 .forward = {0, 0, 1},
                                 .right = {1, 0, 0},
                                 .up = {0, -1, 0},
                                 .half_height = SIDE / 3.0},
                      .tf = {.count = 2, .lo = 0.5, .hi = 1, .entries = entries}};
}

static bench_samples count(double extinction)
{
    static float values[SIDE * SIDE * SIDE];
    float entries[8] = {0};
    iso_level level;
    bench_samples samples;
    entries[7] = (float)extinction;
    make_slab(&level, values);
    const iso_view view = view_along_z(entries);
    assert_ok(iso_bench_count_samples(&level, ISO_CODE_CUBE, &view, 2, &samples, NULL));
    return samples;
}

TEST(samples_in_a_slab_show_something)
{
    const bench_samples clear = count(0.01), opaque = count(100);
    assert_int_equal(clear.looked_up, PIXELS * PIXELS * SIDE);
    assert_int_equal(clear.shown, PIXELS * PIXELS * SLAB);
    /* Behind the first sample of the slab there is no light left. */
    assert_int_equal(opaque.looked_up, PIXELS * PIXELS * ((SIDE - SLAB) / 2 + 1));
    assert_int_equal(opaque.shown, PIXELS * PIXELS);
}

/* Seconds of a plain loop whose samples cost 3, and 5 more where they show something. */
static double seconds(const bench_samples *s)
{
    return 3 * (double)s->looked_up + 5 * (double)s->shown;
}

TEST(known_costs_give_their_bound)
{
    const bench_samples dense = {1000, 900}, sparse = {1200, 60}, unlike = {1200, 90};
    const double bound = iso_bench_skipping_bound(&dense, seconds(&dense), &sparse, seconds(&sparse));
    assert_true(fabs(bound - 3900.0 / (8 * 60)) < 1e-9);
    /* Where half as many more samples show something there is less to gain. */
    assert_true(iso_bench_skipping_bound(&dense, seconds(&dense), &unlike, seconds(&unlike)) < 0.7 * bound);
}

TEST(visible_samples_cost_no_less_than_hidden_ones)
{
    const bench_samples dense = {1000, 900}, sparse = {1200, 60};
    assert_true(fabs(iso_bench_skipping_bound(&dense, 900, &sparse, 1200) - 1200.0 / 60) < 1e-9);
}

TEST(without_visible_samples_there_is_no_bound)
{
    const bench_samples dense = {1000, 900}, none = {1200, 0};
    assert_true(isnan(iso_bench_skipping_bound(&dense, 900, &none, 1200)));
    assert_true(isnan(iso_bench_skipping_bound(&dense, 900, &dense, 900)));
}

TEST_MAIN(NULL, NULL)

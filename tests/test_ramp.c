/* SPDX-License-Identifier: MIT */
/* Transfer functions as Blender's ColorRamp: stops, and what they lose. */
#include "test.h"

#include "blender/blender.h"

/* Colors and opacities of a length of 2 mm go up and down. */
static void fill_table(iso_tf_table *t, size_t count, size_t knots)
{
    *t = (iso_tf_table){.count = count, .lo = 0, .hi = 1, .unit_mm = 2, .entries = malloc(4 * count * sizeof(float))};
    for (size_t i = 0; i < count; ++i) {
        double x = (double)i / (double)(count - 1) * (double)(knots - 1), zigzag = fabs(x - 2 * round(x / 2));
        for (size_t c = 0; c < 3; ++c)
            t->entries[4 * i + c] = (float)(zigzag * 0.5);
        t->entries[4 * i + 3] = (float)(-log1p(-zigzag * 0.9) / 2);
    }
}

/* Knots at multiples of 15 entries: at i / 255 Cycles bakes them all; at i / 256 it cuts them, by a quarter of a step
 * of the slopes' difference at most. */
TEST(ramps_of_knots_lose_what_baking_cuts)
{
    iso_tf_table t;
    iso_color_ramp ramp;
    fill_table(&t, 256, 18);
    iso_color_ramp_fit(&t, &ramp);
    assert_int_equal(ramp.count, 18);
    assert_false(ramp.own_points);
    const double cut = 2 * 17 * 0.5 / 256 /
                       4; /* slopes of a tooth of 1/2 up and down, 17 of them; entries are at i / 255 */
    assert_at_most(ramp.color_loss, cut);
    assert_more_than(ramp.color_loss, 0.5 * cut);                  /* the knot in the middle between two baked ones */
    assert_within(ramp.opacity_loss, 1.8 * ramp.color_loss, 2e-3); /* opacity .9 */
    assert_within(ramp.unit_mm, 2, 1e-12);
    free(t.entries);
    fill_table(&t, 256, 52); /* more knots than stops: lost ones cost half a tooth */
    iso_color_ramp_fit(&t, &ramp);
    assert_true(ramp.count >= 2 && ramp.count <= ISO_RAMP_MAX_STOPS);
    assert_more_than(ramp.color_loss, 0.25);
    assert_more_than(ramp.opacity_loss, 0.25);
    assert_more_than(ramp.off, 0.25);
    free(t.entries);
    fill_table(&t, 951,
               20); /* 19 does not divide 255: knots between the baked entries are cut, 19/255 of a tooth at most */
    iso_color_ramp_fit(&t, &ramp);
    assert_more_than(ramp.opacity_loss, 0.001);
    assert_at_most(ramp.opacity_loss, 0.9 * 19.0 / 255);
    free(t.entries);
}

/* Five points of which two make a step, not at entries; the range goes beyond them. */
static iso_tf_table table_of_points(void)
{
    static iso_tf_point points[] = {{-300, {0.1, 0.2, 0.3}, 0},
                                    {-33, {0.9, 0.2, 0.3}, 0.25},
                                    {111, {0.9, 0.2, 0.7}, 0.5},
                                    {111, {0.2, 0.9, 0.7}, 0.75},
                                    {1700, {1, 1, 1}, 1}};
    const iso_tf tf = {
        .point_count = 5, .points = points, .range = {-1024, 3071}, .unit_distance = 3, .table_size = 4096};
    const iso_geometry g = iso_geometry_axis_aligned((size_t[]){1, 1, 1}, (double[]){1, 1, 1});
    iso_tf_table t = {0};
    assert_ok(iso_tf_tabulate(&tf, 0, 1, &g, &t, &err));
    return t;
}

TEST(a_ramp_has_the_points_of_the_transfer_function)
{
    OWNED(iso_tf_table) t = table_of_points();
    iso_color_ramp ramp;
    iso_color_ramp_fit(&t, &ramp);
    assert_true(ramp.own_points);
    assert_int_equal(ramp.count, 5);
    assert_within(ramp.lo, -300, 0);
    assert_within(ramp.hi, 1700, 0);
    assert_within(ramp.unit_mm, 3, 0);
    for (size_t i = 0; i < 5; ++i) {
        assert_within(ramp.lo + ramp.position[i] * (ramp.hi - ramp.lo), t.points[i].value,
                      2000 * 2.4e-7); /* two ulps */
        assert_within(ramp.rgba[i][0], t.points[i].rgb_linear[0], 0);
        assert_within(ramp.rgba[i][3], t.points[i].opacity, 0);
        assert_true(i == 0 || ramp.position[i] > ramp.position[i - 1]); /* or Blender may exchange them */
    }
    /* The step is lost between two baked entries, which are 2000 / 255 of a value apart: at most two of them. */
    assert_within(ramp.worst_value, 111, 2000.0 / 255);
    assert_more_than(ramp.color_loss, 0.3);
    assert_at_most(ramp.off, 2 * 2000.0 / 255 / 4095);
    /* Without it the bend at -33 is what baking cuts. */
    t.points[3] = t.points[2];
    iso_tf again = {
        .point_count = 5, .points = t.points, .range = {-1024, 3071}, .unit_distance = 3, .table_size = 4096};
    const iso_geometry g = iso_geometry_axis_aligned((size_t[]){1, 1, 1}, (double[]){1, 1, 1});
    OWNED(iso_tf_table) smooth = {0};
    assert_ok(iso_tf_tabulate(&again, 0, 1, &g, &smooth, &err));
    iso_color_ramp_fit(&smooth, &ramp);
    assert_true(ramp.own_points);
    assert_at_most(ramp.color_loss, 0.8 / 267 * 2000 / 255 / 4 + 1e-6); /* slope, times a quarter of a baked step */
    /* Planted: other entries under the same points. */
    for (size_t i = 0; i < t.count; ++i)
        t.entries[4 * i] *= 0.9f;
    iso_color_ramp_fit(&t, &ramp);
    assert_false(ramp.own_points);
}

/* More points than a ramp holds, all visible: fitted where it matters, and only between the values where it does. */
TEST(a_smooth_curve_has_few_stops_within_a_thousandth)
{
    enum { N = 2001 };
    iso_tf_table t = {.count = N, .lo = 0, .hi = 2000, .unit_mm = 1, .entries = malloc(4 * N * sizeof(float))};
    iso_color_ramp ramp;
    for (size_t i = 0; i < N; ++i) {
        const double x = fmin(fmax(((double)i - 400) / 800, 0), 1);
        for (size_t c = 0; c < 3; ++c)
            t.entries[4 * i + c] = (float)(0.5 + 0.5 * sin(3 * x));
        t.entries[4 * i + 3] = (float)-log1p(-0.8 * x * x);
    }
    iso_color_ramp_fit(&t, &ramp);
    assert_within(ramp.lo, 400, 1e-9);
    assert_within(ramp.hi, 1200, 1e-9);
    assert_true(ramp.count >= 8 && ramp.count <= ISO_RAMP_MAX_STOPS - 1);
    assert_at_most(ramp.color_loss, 1.1 / 1024);
    assert_at_most(ramp.opacity_loss, 1.1 / 1024);
    free(t.entries);
}

TEST_MAIN(NULL, NULL)

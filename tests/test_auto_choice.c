/* SPDX-License-Identifier: MIT */
/* What build --auto measures, predicts and chooses. */
#include <math.h>
#include <string.h>

#include "plan/auto_choice.h"
#include "pyramids.h"

static size_t design(const char *name)
{
    size_t d = 0;
    while (d < ISO_AUTO_DESIGNS && strcmp(iso_auto_design_at(d)->name, name) != 0)
        ++d;
    assert_true(d < ISO_AUTO_DESIGNS);
    return d;
}

/* All designs err alike at two coarse levels. */
static iso_auto_choice alike(double error)
{
    iso_auto_choice c = {.level_count = 3};
    for (size_t d = 0; d < ISO_AUTO_DESIGNS; ++d)
        c.error[d][1] = c.error[d][2] = error;
    return c;
}

static void choose(iso_auto_choice *c, int bytes)
{
    assert_ok(iso_auto_choose(c, bytes, &err));
}

static void equal_errors_leave_the_priors(void **state)
{
    (void)state;
    iso_auto_choice c = alike(0.1);
    choose(&c, ISO_AUTO_MOST_BYTES);
    for (size_t d = 0; d < ISO_AUTO_DESIGNS; ++d) {
        const double *a = iso_auto_design_at(d)->prior;
        assert_within(c.predicted[d], exp((a[0] + a[1]) / 2), 1e-12);
    }
    assert_within(c.predicted[0], 1, 0);
}

static void a_prediction_is_a_power_of_the_error(void **state)
{
    (void)state;
    const size_t d = design("least-squares");
    iso_auto_choice before = alike(0.1), after = alike(0.1);
    after.error[d][1] = after.error[d][2] = 0.05;
    choose(&before, ISO_AUTO_MOST_BYTES);
    choose(&after, ISO_AUTO_MOST_BYTES);
    const double *b = iso_auto_design_at(d)->slope;
    assert_within(after.predicted[d] / before.predicted[d], pow(0.5, (b[0] + b[1]) / 2),
                  1e-5); /* what keeps logs finite */
}

static void what_errs_least_by_far_is_chosen_within_the_budget(void **state)
{
    (void)state;
    iso_error err;
    const size_t cheap = design("damped-adapted"), dear = design("scaled-damped");
    iso_auto_choice c = alike(0.1);
    for (size_t k = 1; k < 3; ++k) {
        c.error[cheap][k] = 1e-4;
        c.error[dear][k] = 1e-6;
    }
    choose(&c, 4);
    assert_int_equal(c.chosen, dear);
    choose(&c, 3);
    assert_int_equal(c.chosen, cheap);
    assert_int_equal(iso_auto_choose(&c, 2, &err), ISO_E_RANGE);
    assert_non_null(strstr(err.text, "2 bytes"));
}

static void the_default_stays_where_nothing_is_much_nearer(void **state)
{
    (void)state;
    iso_auto_choice c = alike(0.1);
    for (size_t d = 1; d < ISO_AUTO_DESIGNS; ++d)
        for (size_t k = 1; k < 3; ++k) /* so that each is predicted to be farther */
            c.error[d][k] = iso_auto_design_at(d)->slope[k - 1] > 0 ? 1e3 : 0;
    choose(&c, ISO_AUTO_LEAST_BYTES);
    for (size_t d = 1; d < ISO_AUTO_DESIGNS; ++d)
        assert_true(iso_auto_design_at(d)->bytes > ISO_AUTO_LEAST_BYTES || c.predicted[d] > 1 - ISO_AUTO_GAIN);
    assert_int_equal(c.chosen, 0);
}

/* Of a level that is there the designs with its own filter are chosen from, level by level. */
static void a_level_is_shown_by_designs_of_its_own_filter(void **state)
{
    (void)state;
    static const iso_scalar_filter filters[] = {ISO_SCALAR_MEAN, ISO_SCALAR_DAMPED, ISO_SCALAR_LEAST_SQUARES};
    iso_auto_choice c = alike(0.1);
    size_t chosen;
    double gain;
    iso_error failure;
    for (size_t f = 0; f < 3; ++f)
        for (size_t k = 1; k < 3; ++k)
            for (int bytes = ISO_AUTO_LEAST_BYTES; bytes <= ISO_AUTO_MOST_BYTES; ++bytes) {
                assert_ok(iso_auto_choose_level(&c, k, filters[f], bytes, &chosen, &gain, &err));
                assert_int_equal(iso_auto_design_at(chosen)->scalar, filters[f]);
                assert_true(iso_auto_design_at(chosen)->bytes <= bytes);
                assert_at_most(gain, 1);
            }
    assert_ok(iso_auto_choose_level(&c, 1, ISO_SCALAR_MEAN, ISO_AUTO_LEAST_BYTES, &chosen, &gain, &err));
    assert_int_equal(chosen, 0); /* small views decide: nothing of 3 bytes is predicted to be much nearer */
    assert_within(gain, 1, 0);
    assert_ok(iso_auto_choose_level(&c, 1, ISO_SCALAR_MEAN, ISO_AUTO_MOST_BYTES, &chosen, &gain, &err));
    assert_int_equal(chosen, design("scaled"));
    c.error[design("original")][2] = 1e-5; /* at one level alone */
    assert_ok(iso_auto_choose_level(&c, 2, ISO_SCALAR_MEAN, ISO_AUTO_LEAST_BYTES, &chosen, &gain, &err));
    assert_int_equal(chosen, design("original"));
    assert_within(gain, exp(iso_auto_design_at(chosen)->prior[1]) *
                            pow((1e-5 + 1e-6) / (0.1 + 1e-6), iso_auto_design_at(chosen)->slope[1]),
                  1e-12);
    assert_ok(iso_auto_choose_level(&c, 1, ISO_SCALAR_MEAN, ISO_AUTO_LEAST_BYTES, &chosen, &gain, &err));
    assert_int_equal(chosen, 0);
    assert_int_equal(iso_auto_choose_level(&c, 1, ISO_SCALAR_GAUSS, 4, &chosen, &gain, &failure), ISO_E_RANGE);
    assert_non_null(strstr(failure.text, "gauss"));
    assert_int_equal(iso_auto_choose_level(&c, 1, ISO_SCALAR_MEAN, 2, &chosen, &gain, &failure), ISO_E_RANGE);
}

/* What a level of this size can show: least squares give it back, means do not. */
/* What is predicted to be nearer by 1 % does not take the place of what small views choose, by 3 % it does. */
static void a_level_keeps_what_small_views_choose_unless_much_is_gained(void **state)
{
    (void)state;
    const size_t d = design("original");
    const iso_auto_design *of = iso_auto_design_at(d);
    for (int percent = 1; percent <= 3; percent += 2) {
        iso_auto_choice c = alike(0.1);
        size_t chosen;
        double gain;
        c.error[d][2] = (0.1 + 1e-6) * exp((log(1 - percent / 100.0) - of->prior[1]) / of->slope[1]) - 1e-6;
        assert_ok(iso_auto_choose_level(&c, 2, ISO_SCALAR_MEAN, ISO_AUTO_LEAST_BYTES, &chosen, &gain, &err));
        assert_int_equal(chosen, percent > 2 ? d : 0);
        assert_within(gain, percent > 2 ? 1 - percent / 100.0 : 1, 1e-9);
    }
}

static void a_level_that_is_right_has_no_error(void **state)
{
    (void)state;
    iso_tf_point points[] = {{0, {1, 1, 1}, 0}, {1, {1, 1, 1}, 0.9}};
    iso_tf tf = {.point_count = 2,
                 .points = points,
                 .fit_range = true,
                 .unit_distance = 1,
                 .unit_is_voxels = true,
                 .table_size = 256};
    iso_tf_table table;
    iso_volume v = noise(16, 16, 16);
    for (size_t i = 0; i < 16 * 16 * 16; ++i) { /* a wave of 8 voxels a side, linear between centers of level 1 */
        const double x = fmin(fmax((double)(i % 16) + 0.5, 1), 15), u = (x - 1) / 2, f = u - floor(u);
        const double a = (int)floor(u) % 2 == 0 ? 0.2 : 0.8, b = 1 - a;
        ((float *)v.data)[i] = (float)(a + f * (b - a));
    }
    iso_pyramid_options opt = iso_pyramid_defaults();
    iso_auto_choice c;
    opt.level_count = 2;
    opt.threads = 1;
    assert_ok(iso_tf_tabulate(&tf, 0, 1, &v.geometry, &table, &err));
    assert_ok(iso_auto_measure(&v, &opt, &table, &c, NULL, &err));
    assert_int_equal(c.level_count, 2);
    assert_at_most(c.error[design("least-squares")][1], 5e-3); /* the wave's corners inside of voxels */
    assert_more_than(c.error[design("original")][1], 0.05);
    assert_more_than(c.error[design("damped")][1], c.error[design("least-squares")][1]);
    assert_at_most(c.error[design("scaled-original")][1], c.error[design("original")][1]);
    iso_tf_table_destroy(&table);
    iso_volume_destroy(&v);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(equal_errors_leave_the_priors),
        cmocka_unit_test(a_prediction_is_a_power_of_the_error),
        cmocka_unit_test(what_errs_least_by_far_is_chosen_within_the_budget),
        cmocka_unit_test(the_default_stays_where_nothing_is_much_nearer),
        cmocka_unit_test(a_level_is_shown_by_designs_of_its_own_filter),
        cmocka_unit_test(a_level_keeps_what_small_views_choose_unless_much_is_gained),
        cmocka_unit_test(a_level_that_is_right_has_no_error),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

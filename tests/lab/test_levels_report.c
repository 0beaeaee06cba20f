/* SPDX-License-Identifier: MIT */
/* What `isoshade-lab levels` counts: ratios to the base, cases that are worse, cases left out, and errors over what is
 * shown. */
#include "lab/levels_report.h"
#include "lab/volumes.h"
#include "tests/test.h"

enum { BASE = 0, OTHER = 1 };

static struct iso_level_result result(double error)
{
    const iso_level_error e = {error, 2 * error, 3 * error};
    return (struct iso_level_result){.full = e, .minified = e, .alpha = 1};
}

/* A case with these errors of the base and of the other method. */
static void add_case(iso_level_cases *c, const char *volume, bool held, double base, double other)
{
    iso_level_case *one = iso_level_cases_add(c);
    assert_non_null(one);
    one->volume = volume;
    one->tf = "soft";
    one->level = 1;
    one->held = held;
    one->finest_alpha = 1;
    one->results[BASE] = result(base);
    one->results[OTHER] = result(other);
}

static iso_level_cases two_methods(void)
{
    iso_level_cases c = {.against = BASE};
    c.wanted[BASE] = c.wanted[OTHER] = true;
    return c;
}

static json_t *row_of(json_t *blocks, size_t block, size_t method)
{
    json_t *level = json_array_get(json_object_get(json_array_get(blocks, block), "levels"), 0);
    return json_array_get(json_object_get(level, "methods"), method);
}

static double ratio_of(json_t *row, const char *figure, const char *statistic)
{
    return json_number_value(json_object_get(json_object_get(json_object_get(row, "ratios"), figure), statistic));
}

static json_int_t count_of(json_t *row, const char *key)
{
    return json_integer_value(json_object_get(row, key));
}

TEST(the_base_has_ratio_one_in_every_figure)
{
    OWNED(iso_level_cases) c = two_methods();
    add_case(&c, "a", false, 0.1, 0.3);
    add_case(&c, "b", false, 0.02, 0.001);
    json_t *blocks = iso_levels_report(&c, false), *row = row_of(blocks, 0, BASE);
    static const char *const figures[] = {"dssim", "rmse", "flip", "dssim_minified", "rmse_minified", "flip_minified"};
    for (size_t i = 0; i < 6; ++i) {
        assert_true(ratio_of(row, figures[i], "geometric_mean") == 1);
        assert_true(ratio_of(row, figures[i], "upper_quartile") == 1);
    }
    assert_int_equal(count_of(row, "worse_count"), 0);
    json_decref(blocks);
}

/* Ratios 1.01, 1.03 and 1.10: two worse by 2 %, one by 5 %; the worst is named first. */
TEST(worse_cases_are_counted_by_both_limits_and_named)
{
    OWNED(iso_level_cases) c = two_methods();
    add_case(&c, "slightly", false, 0.1, 0.101);
    add_case(&c, "worse", false, 0.1, 0.103);
    add_case(&c, "worst", false, 0.1, 0.110);
    json_t *blocks = iso_levels_report(&c, false), *row = row_of(blocks, 0, OTHER);
    assert_int_equal(count_of(row, "worse_count"), 2);
    assert_int_equal(count_of(row, "much_worse_count"), 1);
    const json_t *first = json_array_get(json_object_get(row, "worst"), 0);
    assert_string_equal(json_string_value(json_object_get(first, "volume")), "worst");
    assert_true(fabs(ratio_of(row, "dssim", "median") - 1.03) < 1e-4); /* both have 1e-6 added */
    assert_true(fabs(ratio_of(row, "dssim", "geometric_mean") - cbrt(1.01 * 1.03 * 1.10)) < 1e-4);
    json_decref(blocks);
}

TEST(what_is_held_back_stands_in_its_own_block)
{
    OWNED(iso_level_cases) c = two_methods();
    add_case(&c, "a", false, 0.1, 0.05);
    add_case(&c, "b", true, 0.1, 0.2);
    json_auto_t *blocks = iso_levels_report(&c, false);
    assert_int_equal(json_array_size(blocks), 2);
    assert_true(fabs(ratio_of(row_of(blocks, 0, OTHER), "dssim", "geometric_mean") - 0.5) < 1e-4);
    assert_true(fabs(ratio_of(row_of(blocks, 1, OTHER), "dssim", "geometric_mean") - 2) < 1e-4);
}

TEST(cases_that_tell_nothing_are_left_out_with_their_reason)
{
    OWNED(iso_level_cases) c = two_methods();
    add_case(&c, "counts", false, 0.1, 0.05);
    add_case(&c, "empty", false, 0.1, 0.9);
    c.cases[1].finest_alpha = 0.5 / 255;
    add_case(&c, "vanished", false, 0.1, 0.9);
    c.cases[2].results[BASE].alpha = c.cases[2].results[OTHER].alpha = 0;
    add_case(&c, "no error", false, 1e-6, 3e-6);
    assert_null(iso_level_case_left_out(&c, &c.cases[0]));
    assert_string_equal(iso_level_case_left_out(&c, &c.cases[1]), "level 0 shows nothing");
    assert_string_equal(iso_level_case_left_out(&c, &c.cases[2]), "the level shows nothing under any method");
    assert_string_equal(iso_level_case_left_out(&c, &c.cases[3]), "no method has an error");
    /* an error of a single figure is enough to count */
    c.cases[3].results[OTHER].minified.flip = 0.01;
    assert_null(iso_level_case_left_out(&c, &c.cases[3]));
    c.cases[3].results[OTHER].minified.flip = 0;
    json_t *blocks = iso_levels_report(&c, false), *row = row_of(blocks, 0, OTHER);
    assert_int_equal(json_object_size(json_object_get(json_array_get(blocks, 0), "left_out")), 3);
    assert_true(fabs(ratio_of(row, "dssim", "geometric_mean") - 0.5) < 1e-4);
    json_decref(blocks);
}

static iso_image plain_image(size_t width, size_t height, float value)
{
    iso_image image;
    assert_ok(iso_image_create(&image, width, height, &err));
    for (size_t i = 0; i < 4 * width * height; ++i)
        image.rgba[i] = value;
    return image;
}

/* Half the picture is background in both: it does not thin the error. */
/* Volume a: ratios 1/2 and 8, together 2, so the base is the best; b: 1/4, the other is. */
TEST(the_best_is_counted_over_all_levels_of_a_pair)
{
    OWNED(iso_level_cases) c = two_methods();
    add_case(&c, "a", false, 0.1, 0.05);
    add_case(&c, "a", false, 0.01, 0.08);
    add_case(&c, "b", false, 0.04, 0.01);
    add_case(&c, "b", true, 0.04, 0.01);
    const iso_level_nearness base = iso_level_cases_nearness(&c, false, BASE),
                             other = iso_level_cases_nearness(&c, false, OTHER);
    assert_int_equal(base.pairs, 2);
    assert_int_equal(base.near_best, 1);
    assert_int_equal(other.near_best, 1);
    assert_within(base.over_best, 2, 1e-3);        /* 1 and 4; 1e-6 is added to errors */
    assert_within(other.over_best, sqrt(2), 1e-3); /* 2 and 1 */
    assert_int_equal(iso_level_cases_nearness(&c, true, OTHER).near_best, 1);
}

TEST(errors_are_over_what_either_image_shows)
{
    OWNED(iso_image) a = plain_image(32, 32, 0), b = plain_image(32, 32, 0);
    for (size_t i = 0; i < 32 * 16; ++i)
        for (size_t c = 0; c < 4; ++c) {
            a.rgba[4 * i + c] = c < 3 ? 0.25F : 1;
            b.rgba[4 * i + c] = c < 3 ? 0.375F : 1;
        }
    iso_level_error e;
    assert_ok(iso_level_error_measure(&a, &b, &e, &err));
    assert_true(fabs(e.rmse - 0.125) < 1e-12);
    assert_true(e.flip > 0 && e.dssim > 0);
    assert_ok(iso_level_error_measure(&a, &a, &e, &err));
    assert_true(e.rmse == 0 && e.flip == 0 && e.dssim == 0);
    /* what only the second shows counts as well */
    OWNED(iso_image) empty = plain_image(32, 32, 0);
    assert_ok(iso_level_error_measure(&empty, &b, &e, &err));
    assert_true(fabs(e.rmse - 0.375) < 1e-12);
}

/* 5 x 3 pixels in boxes of 2: 3 x 2, the last ones cut. */
TEST(minifying_takes_means_of_boxes_that_the_border_cuts)
{
    OWNED(iso_image) image = plain_image(5, 3, 0), out;
    for (size_t i = 0; i < 15; ++i)
        image.rgba[4 * i] = (float)i;
    assert_ok(iso_image_minify(&image, 2, &out, &err));
    assert_int_equal(out.width, 3);
    assert_int_equal(out.height, 2);
    const float wanted[6] = {3, 5, 6.5F, 10.5F, 12.5F, 14};
    for (size_t i = 0; i < 6; ++i)
        assert_true(out.rgba[4 * i] == wanted[i]);
    assert_int_equal(iso_image_minify(&image, 0, &out, NULL), ISO_E_RANGE);
}

TEST(methods_are_chosen_by_whole_names)
{
    bool wanted[ISO_LEVEL_MAX_METHODS] = {false};
    assert_ok(iso_level_methods_choose("original,tf-2d", wanted, &err));
    for (size_t m = 0; m < iso_level_method_count(); ++m) {
        const char *name = iso_level_method_at(m)->name;
        assert_int_equal(wanted[m], strcmp(name, "original") == 0 || strcmp(name, "tf-2d") == 0);
    }
    assert_int_equal(iso_level_methods_choose("origina", wanted, NULL), ISO_E_USAGE);
    assert_ok(iso_level_methods_choose("all", wanted, &err));
    for (size_t m = 0; m < iso_level_method_count(); ++m)
        assert_true(wanted[m]);
}

/* The middle of an odd and of an even axis; the shorter axis stays. Voxels keep their values and their places. */
TEST(a_crop_keeps_the_middle_where_it_is)
{
    const iso_geometry g = iso_geometry_axis_aligned((size_t[]){7, 8, 3}, (double[]){1, 2, 0.5});
    OWNED(iso_volume) v;
    assert_ok(iso_volume_create(&v, &g, ISO_U16, "crop", &err));
    for (size_t i = 0; i < iso_geometry_voxel_count(&g); ++i)
        ((uint16_t *)v.data)[i] = (uint16_t)i;
    assert_ok(iso_lab_crop_to_middle(&v, 4, &err));
    assert_int_equal(v.geometry.size[0], 4);
    assert_int_equal(v.geometry.size[1], 4);
    assert_int_equal(v.geometry.size[2], 3);
    for (size_t i = 0; i < 4 * 4 * 3; ++i) {
        const size_t x = i % 4 + 1, y = i / 4 % 4 + 2, z = i / 16;
        assert_int_equal(((uint16_t *)v.data)[i], x + 7 * (y + 8 * z));
    }
    const iso_vec3 was = iso_geometry_to_world(&g, iso_v3(1, 2, 0)), is = iso_geometry_to_world(&v.geometry, iso_v3(0, 0, 0));
    assert_true(was.x == is.x && was.y == is.y && was.z == is.z);
}

TEST_MAIN(NULL, NULL)

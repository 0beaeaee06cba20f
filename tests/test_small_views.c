/* SPDX-License-Identifier: MIT */
/* Small views of a level, and the judgment that is made of them. */
#include "test.h"

#include "tf/adapt.h"

static iso_pyramid pyramid_of(const iso_geometry *g, double (*value)(const double at[3]), size_t levels)
{
    OWNED(iso_volume) v;
    iso_pyramid p;
    assert_ok(iso_volume_create(&v, g, ISO_F32, "v", &err));
    float *data = v.data;
    for (size_t z = 0; z < g->size[2]; ++z)
        for (size_t y = 0; y < g->size[1]; ++y)
            for (size_t x = 0; x < g->size[0]; ++x)
                *data++ = (float)value((double[]){((double)x + 0.5) / (double)g->size[0] * 2 - 1,
                                                  ((double)y + 0.5) / (double)g->size[1] * 2 - 1,
                                                  ((double)z + 0.5) / (double)g->size[2] * 2 - 1});
    iso_pyramid_options opt = iso_pyramid_defaults();
    opt.level_count = levels;
    assert_ok(iso_pyramid_build(&v, "v", &opt, &p, NULL, &err));
    return p;
}

/* The orbital 4d(xz) of hydrogen: two signs, and zero, the value of empty space, in the middle of the range. */
static double orbital(const double at[3])
{
    const double x = 32 * at[0], y = 32 * at[1], z = 32 * at[2], r = sqrt(x * x + y * y + z * z);
    return (12 - r) * x * z * exp(-r / 4);
}

static double flat(const double at[3])
{
    return at[0] > 2 ? 1 : 0.5;
}

/* White of one extinction for all values in [-1e9, 1e9]. */
static iso_tf_table uniform(double extinction_per_mm)
{
    iso_tf_table t = {.count = 2, .lo = -1e9, .hi = 1e9, .entries = calloc(8, sizeof(float))};
    for (size_t i = 0; i < 2; ++i)
        for (size_t c = 0; c < 4; ++c)
            t.entries[4 * i + c] = c < 3 ? 1 : (float)extinction_per_mm;
    return t;
}

/* Green between .4 and .5 of the range, clear on both sides: the shell of `isoshade-lab consistency`. */
static iso_tf_table shell(const iso_level *level0)
{
    static iso_tf_point points[] = {{0, {0.2, 0.8, 0.5}, 0},
                                    {0.4, {0.2, 0.8, 0.5}, 0},
                                    {0.45, {0.3, 0.9, 0.5}, 0.5},
                                    {0.5, {0.8, 0.8, 0.2}, 0},
                                    {1, {0.8, 0.8, 0.2}, 0}};
    const iso_tf tf = {.fit_range = true,
                       .unit_distance = 1,
                       .unit_is_voxels = true,
                       .table_size = 256,
                       .point_count = 5,
                       .points = points};
    iso_tf_table table;
    assert_ok(iso_tf_tabulate(&tf, level0->min, level0->max, &level0->geometry, &table, &err));
    return table;
}

TEST(a_cube_covers_three_fifths_of_a_view)
{
    /* Along (2, 2, -1) / 3 a cube of edge a covers a^2 (2 + 2 + 1) / 3, and the frame is 5/3 a wide, in each of the
     * twelve views: an opaque cube against nothing has the mean square 3/5. */
    iso_geometry g = iso_geometry_axis_aligned((size_t[]){40, 40, 40}, (double[]){1.5, 1.5, 1.5});
    OWNED(iso_pyramid) p = pyramid_of(&g, flat, 1);
    OWNED(iso_tf_table) opaque = uniform(1e3), clear = uniform(0);
    iso_small_views_error e[ISO_SMALL_VIEWS_MAX_TFS];
    const iso_small_views_input in = {
        .fine = p.levels, .coarse = p.levels, .original = &opaque, .tfs = {&opaque, &clear}, .tf_count = 2};
    assert_ok(iso_small_views_compare(&in, e, &err));
    assert_true(e[0].rmse == 0 && e[0].ssim_dissimilarity == 0); /* level 0 against itself */
    assert_within(e[1].rmse, sqrt(0.6), 0.01); /* at the outline a ray may cross less than a step and see nothing */
    assert_more_than(e[1].ssim_dissimilarity, 0.5);
}

TEST(threads_change_nothing_and_a_wrong_level_shows)
{
    iso_geometry g = iso_geometry_axis_aligned((size_t[]){24, 29, 17}, (double[]){1, 0.8, 1.7});
    g.index_to_world.m[0][1] = 0.3; /* sheared */
    OWNED(iso_pyramid) p = pyramid_of(&g, orbital, 2);
    OWNED(iso_tf_table) tf = shell(p.levels);
    iso_small_views_error one[ISO_SMALL_VIEWS_MAX_TFS], three[ISO_SMALL_VIEWS_MAX_TFS], wrong[ISO_SMALL_VIEWS_MAX_TFS];
    iso_small_views_input in = {.fine = p.levels,
                                .coarse = p.levels + 1,
                                .level = 1,
                                .original = &tf,
                                .tfs = {&tf},
                                .tf_count = 1,
                                .threads = 1};
    assert_ok(iso_small_views_compare(&in, one, &err));
    in.threads = 3;
    assert_ok(iso_small_views_compare(&in, three, &err));
    assert_memory_equal(one, three, sizeof *one);
    iso_small_views_fine kept = {0}; /* level 0 is drawn by the first of these, and only looked at by the second */
    in.kept = &kept;
    for (int i = 0; i < 2; ++i) {
        assert_ok(iso_small_views_compare(&in, three, &err));
        assert_memory_equal(one, three, sizeof *one);
        assert_true(kept.is_drawn);
    }
    kept.views[5].rgba[4 * (32 * ISO_SMALL_VIEWS_PIXELS + 32)] += 1;
    assert_ok(iso_small_views_compare(&in, wrong, &err));
    assert_more_than(wrong[0].rmse, one[0].rmse);
    iso_small_views_fine_destroy(&kept);
    in.kept = NULL;
    in.level = 2; /* the planted fault: level 1 looked up as if it were level 2 */
    assert_ok(iso_small_views_compare(&in, wrong, &err));
    assert_more_than(wrong[0].rmse, 2 * one[0].rmse);
}

/* The error at the voxels is lower by a tenth, and the space around the orbital fills with a haze. */
/* Thin enough that opacity is proportional to extinction within its square: 20 mm of 1e-5 per mm. */
TEST(lost_opacity_is_the_part_that_is_missing)
{
    const iso_geometry g = iso_geometry_axis_aligned((size_t[]){9, 8, 7}, (double[]){1, 1, 1});
    OWNED(iso_pyramid) p = pyramid_of(&g, flat, 1);
    OWNED(iso_tf_table) whole = uniform(1e-5);
    OWNED(iso_tf_table) quarter = uniform(0.25e-5);
    OWNED(iso_tf_table) more = uniform(2e-5);
    iso_small_views_error e[ISO_SMALL_VIEWS_MAX_TFS];
    const iso_small_views_input in = {.fine = p.levels,
                                      .coarse = p.levels,
                                      .original = &whole,
                                      .tfs = {&whole, &quarter, &more},
                                      .tf_count = 3,
                                      .threads = 1};
    assert_ok(iso_small_views_compare(&in, e, &err));
    assert_within(e[0].lost, 0, 1e-9);
    assert_within(e[1].lost, 0.75, 1e-3);
    assert_within(e[2].lost, 0, 1e-9); /* more opacity is none lost */
}

TEST(a_signed_orbital_keeps_its_empty_space)
{
    iso_geometry g = iso_geometry_axis_aligned((size_t[]){48, 56, 56}, (double[]){1, 1, 1});
    OWNED(iso_pyramid) p = pyramid_of(&g, orbital, 4);
    OWNED(iso_tf_table) tf = shell(p.levels), out;
    iso_adapt_options opt = iso_adapt_defaults();
    iso_adapt_judgment v;
    assert_ok(iso_adapt_level(&p, 3, &tf, &opt, &out, &v, &err));
    assert_true(v.rms_adapted < 0.95 * v.rms_original); /* what was trusted before */
    assert_true(v.seen && v.use_original);
    assert_more_than(v.seen_adapted.ssim_dissimilarity, 2 * v.seen_original.ssim_dissimilarity);
    assert_memory_equal(out.entries, tf.entries, 4 * tf.count * sizeof(float));
}

TEST(a_picture_without_anything_in_it_keeps_the_original)
{
    iso_geometry g = iso_geometry_axis_aligned((size_t[]){16, 16, 16}, (double[]){1, 1, 1});
    OWNED(iso_pyramid) p = pyramid_of(&g, orbital, 2);
    OWNED(iso_tf_table) tf = uniform(0), out;
    iso_adapt_options opt = iso_adapt_defaults();
    iso_adapt_judgment v;
    assert_ok(iso_adapt_level(&p, 1, &tf, &opt, &out, &v, &err));
    assert_true(v.seen && v.use_original);
}

/* 1 - SSIM of .1 in each view, and what is added to it in the even and in the odd ones. */
static iso_small_views_error error_of(double even, double odd, double rmse)
{
    iso_small_views_error e = {.ssim_dissimilarity = 0.1 + (even + odd) / 2, .rmse = rmse};
    for (int i = 0; i < ISO_SMALL_VIEWS_COUNT; ++i)
        e.of_view[i] = 0.1 + (i % 2 == 0 ? even : odd);
    return e;
}

static bool is_taken(double even, double odd, double rmse)
{
    const iso_small_views_error original = error_of(0, 0, 1), adapted = error_of(even, odd, rmse);
    return iso_adapt_is_nearer(&original, &adapted);
}

TEST(each_part_of_the_rule_decides_somewhere)
{
    assert_true(is_taken(-0.01, -0.01, 1));
    assert_false(is_taken(-0.01, -0.01, 1.01)); /* farther by RMSE */
    assert_false(is_taken(-0.02, 0.015, 1));    /* nearer in the mean, within the scatter: .0025 of twice .0053 */
    assert_true(is_taken(-0.02, 0, 1));
    assert_true(is_taken(0.004, 0.004, 0.74)); /* much nearer by RMSE */
    assert_false(is_taken(0.004, 0.004, 0.76));
    assert_false(is_taken(0.006, 0.006, 0.74)); /* and too far by SSIM */
    assert_false(is_taken(-0.04, 0.021, 0.5));  /* a view much farther */
    assert_true(is_taken(-0.04, 0.019, 0.5));
}

TEST_MAIN(NULL, NULL)

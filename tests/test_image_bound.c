/* SPDX-License-Identifier: MIT */
/* The bound of a level's image is above what is measured. */

#include "image_bound_cases.h"

VALUES_TEST(no_image_is_farther_than_its_bound)
{
    static const iso_field_kind kinds[] = {ISO_FIELD_SHELLS, ISO_FIELD_MARSCHNER_LOBB, ISO_FIELD_NOISE};
    int below = 0;
    for (size_t k = 0; k < sizeof kinds / sizeof *kinds; ++k) {
        OWNED(iso_pyramid) p = pyramid_of(kinds[k], 3);
        for (int variant = 0; variant < 4; ++variant) {
            OWNED(iso_view)
            view = view_of(&p, 0.3 + 0.1 * variant, variant & 1 ? 0.7 : 0.05, variant < 2,
                           variant == 1 || variant == 2);
            OWNED(iso_image) finest = draw(&p, 0, &view);
            for (size_t level = 1; level < 3; ++level) {
                OWNED(iso_image) image = draw(&p, level, &view);
                const double measured = measured_rmse(&finest, &image), most = bound_of(&p, level, &view, &view.tf, 1);
                assert_more_than(most, measured);
                assert_more_than(1, most);
                below += most < 6 * measured;
            }
        }
    }
    assert_more_than(below, 5); /* a bound of 1 for everything would be none */
}

TEST(level_0_against_itself_is_0_and_threads_change_nothing)
{
    OWNED(iso_pyramid) p = pyramid_of(ISO_FIELD_NOISE, 2);
    OWNED(iso_view) view = view_of(&p, 0.5, 0.5, false, true);
    assert_true(bound_of(&p, 0, &view, &view.tf, 1) == 0);
    assert_true(bound_of(&p, 1, &view, &view.tf, 1) == bound_of(&p, 1, &view, &view.tf, 3));
}

/* One value everywhere, clear at level 0 and of a small extinction at the "level": C = (g - B)(1 - exp(-tau)). Nothing
 * is lost but that slabs are as bright at their end as at their beginning, and that blocks are whole: the bound is
 * tight, and half of it, the planted fault, would be exceeded. */
TEST(a_thin_fog_has_a_tight_bound)
{
    OWNED(iso_pyramid) p = pyramid_of(ISO_FIELD_CONSTANT, 1);
    OWNED(iso_view) view = view_of(&p, 0.5, 0, true, false);
    float *clear = view.tf.entries, fog[8] = {1, 1, 1, 0.02f, 1, 1, 1, 0.02f}, nothing[8] = {0};
    view.tf = (iso_tf_table){.count = 2, .lo = 0, .hi = 1, .entries = nothing};
    const iso_tf_table level_tf = {.count = 2, .lo = 0, .hi = 1, .entries = fog};
    OWNED(iso_image) finest = draw(&p, 0, &view);
    const double most = bound_of(&p, 0, &view, &level_tf, 1);
    view.tf = level_tf;
    OWNED(iso_image) image = draw(&p, 0, &view);
    const double measured = measured_rmse(&finest, &image);
    assert_more_than(most, measured);
    assert_more_than(2 * measured, most);
    view.tf = (iso_tf_table){.count = 2, .lo = 0, .hi = 1, .entries = nothing};
    view.tf.entries = clear;
}

/* Regions of one voxel instead of two: closer, and no image is above it. */
TEST(more_points_make_it_closer)
{
    OWNED(iso_pyramid) p = pyramid_of(ISO_FIELD_NOISE, 2);
    OWNED(iso_view) view = view_of(&p, 0.5, 0.5, true, false);
    view.width = view.height = 2 * PIXELS; /* pixels smaller than a voxel, which blocks cannot be smaller than */
    iso_image_bound_input in = input_of(&p, 1, &view, &view.tf);
    OWNED(iso_image) finest = draw(&p, 0, &view), image = draw(&p, 1, &view);
    double close = NAN;
    in.points = 4;
    assert_ok(iso_image_bound_rmse(&in, &close, &err));
    assert_more_than(close, measured_rmse(&finest, &image));
    assert_more_than(0.9 * bound_of(&p, 1, &view, &view.tf, 1), close);
}

TEST(what_it_does_not_hold_for_is_refused)
{
    OWNED(iso_pyramid) p = pyramid_of(ISO_FIELD_NOISE, 2);
    OWNED(iso_view) view = view_of(&p, 0.5, 0.5, true, false);
    iso_image_bound_input in = {.fine = p.levels, .coarse = p.levels + 1, .level = 1, .view = &view};
    double rmse;
    in.coarse_tf = &view.tf;
    view.clip_count = 1;
    assert_status(iso_image_bound_rmse(&in, &rmse, &err), ISO_E_RANGE);
    view.clip_count = 0;
}

TEST_MAIN(NULL, NULL)

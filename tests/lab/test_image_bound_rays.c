/* SPDX-License-Identifier: MIT */
/* The bound without signs, along the rays: between the RMSE and the bound. */
#include "lab/image_bound_rays.h"
#include "tests/image_bound_cases.h"

static double along_rays(const iso_pyramid *p, size_t level, const iso_view *view, const iso_tf_table *tf)
{
    const iso_image_bound_input in = input_of(p, level, view, tf);
    double rmse = NAN;
    assert_ok(iso_image_bound_without_signs(&in, &rmse, &err));
    return rmse;
}

TEST(the_integral_along_rays_is_between_the_error_and_the_bound)
{
    static const iso_field_kind kinds[] = {ISO_FIELD_SHELLS, ISO_FIELD_NOISE};
    for (size_t k = 0; k < sizeof kinds / sizeof *kinds; ++k) {
        OWNED(iso_pyramid) p = pyramid_of(kinds[k], 3);
        for (int variant = 0; variant < 2; ++variant) {
            OWNED(iso_view) view = view_of(&p, 0.3 + 0.1 * variant, variant ? 0.7 : 0.05, variant == 0, variant == 1);
            OWNED(iso_image) finest = draw(&p, 0, &view);
            for (size_t level = 1; level < 3; ++level) {
                OWNED(iso_image) image = draw(&p, level, &view);
                const double rays = along_rays(&p, level, &view, &view.tf);
                assert_more_than(rays, 0.97 * measured_rmse(&finest, &image)); /* its steps are 1/4 voxel */
                assert_more_than(bound_of(&p, level, &view, &view.tf, 1), rays);
            }
        }
    }
}

/* One value everywhere, clear at level 0 and of a small extinction at the "level": one sign, so nothing is added up. */
TEST(in_a_thin_fog_it_is_the_error)
{
    OWNED(iso_pyramid) p = pyramid_of(ISO_FIELD_CONSTANT, 1);
    OWNED(iso_view) view = view_of(&p, 0.5, 0, true, false);
    float *clear = view.tf.entries, fog[8] = {1, 1, 1, 0.02f, 1, 1, 1, 0.02f}, nothing[8] = {0};
    const iso_tf_table none = {.count = 2, .lo = 0, .hi = 1, .entries = nothing};
    const iso_tf_table level_tf = {.count = 2, .lo = 0, .hi = 1, .entries = fog};
    view.tf = none;
    OWNED(iso_image) finest = draw(&p, 0, &view);
    view.tf = level_tf;
    OWNED(iso_image) image = draw(&p, 0, &view);
    view.tf = none;
    assert_within(along_rays(&p, 0, &view, &level_tf) / measured_rmse(&finest, &image), 1, 0.01);
    view.tf.entries = clear;
}

TEST(a_clipped_view_has_none)
{
    OWNED(iso_pyramid) p = pyramid_of(ISO_FIELD_NOISE, 2);
    OWNED(iso_view) view = view_of(&p, 0.5, 0.5, false, true);
    const iso_image_bound_input in = input_of(&p, 1, &view, &view.tf);
    double rmse;
    view.clip_count = 1;
    assert_status(iso_image_bound_without_signs(&in, &rmse, &err), ISO_E_RANGE);
    view.clip_count = 0;
}

TEST_MAIN(NULL, NULL)

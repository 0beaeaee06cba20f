/* SPDX-License-Identifier: MIT */
/* The bound of a level's image is above what is measured. */
#include "test.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "compare/metrics.h"
#include "render/image_bound.h"
#include "render/reference.h"
#include "volume/synthetic.h"

enum { PIXELS = 24 };

static iso_pyramid pyramid_of(iso_field_kind kind, size_t levels)
{
    iso_field field = {.kind = kind, .seed = 3};
    OWNED(iso_volume) v;
    iso_pyramid p;
    field.geometry = iso_geometry_axis_aligned((size_t[]){20, 17, 23}, (double[]){1, 1.4, 0.8});
    field.geometry.index_to_world.m[1][0] = 0.3; /* sheared */
    assert_ok(iso_field_sample(&field, ISO_F32, &v, &err));
    iso_pyramid_options opt = iso_pyramid_defaults();
    opt.level_count = levels;
    assert_ok(iso_pyramid_build(&v, "v", &opt, &p, NULL, &err));
    return p;
}

/* A step to `opacity` a voxel at `at` of the range, in two colors. */
static iso_view view_of(const iso_pyramid *p, double at, double opacity, bool orthographic, bool lit)
{
    iso_tf_point points[] = {{0, {0.2, 0.8, 0.5}, 0},
                             {at - 0.1, {0.2, 0.8, 0.5}, 0},
                             {at + 0.1, {0.9, 0.5, 0.1}, opacity},
                             {1, {0.1, 0.2, 1}, opacity}};
    const iso_level *level0 = &p->levels[0];
    const iso_scene scene = {.path = "test",
                             .width = PIXELS,
                             .height = PIXELS,
                             .camera_fit = true,
                             .orthographic = orthographic,
                             .fov_y_deg = 50,
                             .camera_direction = iso_normalize(iso_v3(1, 2, -1)),
                             .camera_up = {0, 0, 1},
                             .margin = 1,
                             .light_count = 1,
                             .lights = {{.direction = {0.3, 0.5, 0.8}, .in_camera_space = true, .intensity = 1}},
                             .shading = {lit ? 0.2 : 1, lit ? 0.5 : 0, lit ? 0.3 : 0, 12},
                             .background = {0.1, 0.3, 0.6},
                             .step_voxels = 0.5,
                             .tf = {.point_count = 4,
                                    .points = points,
                                    .fit_range = true,
                                    .unit_distance = 1,
                                    .unit_is_voxels = true,
                                    .table_size = 128}};
    iso_view view;
    assert_ok(iso_scene_resolve(&scene, &level0->geometry, level0->min, level0->max, &view, &err));
    return view;
}

static iso_image draw(const iso_pyramid *p, size_t level, const iso_view *view)
{
    iso_reference_options opt = iso_reference_defaults();
    iso_image image;
    opt.tolerance = 1e-4;
    assert_ok(iso_reference_render(&p->levels[level], p->options.code, view, &opt, &image, NULL, &err));
    return image;
}

static iso_image_bound_input input_of(const iso_pyramid *p, size_t level, const iso_view *view, const iso_tf_table *tf)
{
    return (iso_image_bound_input){.fine = p->levels,
                                   .coarse = &p->levels[level],
                                   .level = level,
                                   .code = p->options.code,
                                   .source = ISO_FROM_CODES,
                                   .view = view,
                                   .coarse_tf = tf};
}

static double bound_of(const iso_pyramid *p, size_t level, const iso_view *view, const iso_tf_table *tf, int threads)
{
    iso_image_bound_input in = input_of(p, level, view, tf);
    double rmse = NAN;
    in.threads = threads;
    assert_ok(iso_image_bound_rmse(&in, &rmse, &err));
    return rmse;
}

static double along_rays(const iso_pyramid *p, size_t level, const iso_view *view, const iso_tf_table *tf)
{
    const iso_image_bound_input in = input_of(p, level, view, tf);
    double rmse = NAN;
    assert_ok(iso_image_bound_without_signs(&in, &rmse, &err));
    return rmse;
}

static double measured_rmse(const iso_image *a, const iso_image *b)
{
    iso_metrics m;
    assert_ok(iso_metrics_measure(a, b, &m, &err));
    return m.rmse;
}

TEST(no_image_is_farther_than_its_bound)
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
                const double rays = along_rays(&p, level, &view, &view.tf); /* in between; its steps are 1/4 voxel */
                assert_more_than(rays, 0.97 * measured);
                assert_more_than(most, rays);
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
    assert_within(along_rays(&p, 0, &view, &level_tf) / measured, 1, 0.01); /* one sign: nothing is added up */
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
    assert_status(iso_image_bound_without_signs(&in, &rmse, &err), ISO_E_RANGE);
    view.clip_count = 0;
}

TEST_MAIN(NULL, NULL)

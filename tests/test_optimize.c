/* SPDX-License-Identifier: MIT */
/* Levels found by rendering: nearer to level 0, the same for any number of threads, judged before they are taken,
 * stored and shown as they are. */
#include "pyramids.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fit/extinction_scale.h"
#include "folder.h"
#include "plan/scene_levels.h"
#include "tf/adapt.h"

/* A surface in the middle of the range, under a headlight. */
static iso_tf_point points[] = {{0, {0.9, 0.7, 0.4}, 0},
                                {0.45, {0.9, 0.7, 0.4}, 0},
                                {0.55, {1, 0.9, 0.8}, 0.8},
                                {1, {0.6, 0.9, 0.8}, 0.8}};

static iso_scene surface_scene(void)
{
    return (iso_scene){.path = (char *)"surface.scene.json",
                       .orthographic = true,
                       .light_count = 1,
                       .lights = {{.direction = {0, 0, 1}, .in_camera_space = true, .intensity = 1}},
                       .shading = {.ambient = 0.3, .diffuse = 0.7, .power = 1},
                       .step_voxels = 0.5,
                       .tf = {.point_count = 4,
                              .points = points,
                              .fit_range = true,
                              .unit_distance = 1,
                              .unit_is_voxels = true,
                              .table_size = 256}};
}

/* A ball with bumps of about two coarse voxels. */
static iso_pyramid bumpy_ball(iso_code code)
{
    enum { N = 28 };
    iso_pyramid_options opt = iso_pyramid_defaults();
    const iso_geometry g = iso_geometry_axis_aligned((size_t[]){N, N, N}, (double[]){1, 1, 1});
    OWNED(iso_volume) v;
    assert_ok(iso_volume_create(&v, &g, ISO_F32, "test", &err));
    for (size_t i = 0; i < (size_t)N * N * N; ++i) {
        const double x = (double)(i % N) - 13.5, y = (double)(i / N % N) - 13.5, z = (double)(i / N / N) - 13.5;
        const double r = sqrt(x * x + y * y + z * z) + 1e-9;
        const double surface = 9 + 1.2 * sin(6 * x / r) * cos(5 * y / r) * sin(7 * z / r + 1);
        ((float *)v.data)[i] = (float)fmin(fmax(0.5 + 0.4 * (surface - r), 0), 1);
    }
    opt.level_count = 2;
    opt.code = code;
    opt.threads = 2;
    iso_pyramid p = build(&v, &opt);
    return p;
}

static iso_optimize_options fast(int threads)
{
    return (iso_optimize_options){.effort = ISO_EFFORT_FAST, .seed = 5, .threads = threads};
}

TEST(a_level_is_nearer_and_threads_change_no_bit)
{
    OWNED(iso_pyramid) p = bumpy_ball(ISO_CODE_FIT);
    const iso_scene scene = surface_scene();
    const size_t count = iso_geometry_voxel_count(&p.levels[1].geometry);
    iso_optimized o[2];
    for (int i = 0; i < 2; ++i) {
        const iso_optimize_options opt = fast(1 + 2 * i);
        assert_ok(iso_optimize_level(&p, 1, &scene, &opt, &o[i], NULL, &err));
    }
    assert_memory_equal(o[0].scalar, o[1].scalar, count * sizeof(float));
    assert_memory_equal(o[0].codes, o[1].codes, 3 * count);
    assert_at_most(o[0].error, 0.8 * o[0].error_first);
    for (size_t i = 0; i < count; ++i) {
        const float *d = o[0].directions + 3 * i;
        assert_at_most((double)(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]), 1 + 1e-6); /* floats */
        assert_true(o[0].scalar[i] >= -0.5f && o[0].scalar[i] <= 1.5f);
    }
    iso_optimized_destroy(&o[0]);
    iso_optimized_destroy(&o[1]);
}

TEST(a_stopped_run_returns_the_level_so_far)
{
    OWNED(iso_pyramid) p = bumpy_ball(ISO_CODE_FIT);
    const iso_scene scene = surface_scene();
    const volatile sig_atomic_t stop = 1;
    iso_optimize_options opt = fast(2);
    OWNED(iso_optimized) o;
    opt.stop = &stop;
    assert_ok(iso_optimize_level(&p, 1, &scene, &opt, &o, NULL, &err));
    assert_int_equal(o.steps, 0);
    assert_memory_equal(o.scalar, p.levels[1].scalar, iso_geometry_voxel_count(&p.levels[1].geometry) * sizeof(float));
}

TEST(scenes_that_cannot_be_learned_are_refused)
{
    iso_tf_point hidden[] = {{0, {1, 1, 1}, 0}, {1, {1, 1, 1}, 0}};
    OWNED(iso_pyramid) p = bumpy_ball(ISO_CODE_FIT), other = bumpy_ball(ISO_CODE_REGION48);
    iso_scene scene = surface_scene();
    const iso_optimize_options opt = fast(2);
    iso_optimized o;
    assert_status(iso_optimize_level(&other, 1, &scene, &opt, &o, NULL, &err), ISO_E_RANGE);
    scene.tf.points = hidden;
    scene.tf.point_count = 2;
    assert_status(iso_optimize_level(&p, 1, &scene, &opt, &o, NULL, &err), ISO_E_RANGE);
}

/* ---- the gate ---------------------------------------------------------------------------------------------------- */

TEST(each_figure_of_the_gate_can_refuse)
{
    const iso_level_seen before = {0.1, 0.05, 0.04, 0.02};
    const iso_level_seen nearer = {0.09, 0.05, 0.03, 0.02};
    assert_true(iso_level_gate_is_nearer(&before, &nearer));
    for (int i = 0; i < 4; ++i) {
        iso_level_seen worse = nearer;
        double *figures[4] = {&worse.ssim_dissimilarity, &worse.rmse, &worse.small_ssim_dissimilarity,
                              &worse.small_rmse};
        *figures[i] = i % 2 == 0 ? 0.985 * (i == 0 ? 0.1 : 0.04) : 1.01 * *figures[i];
        assert_false(iso_level_gate_is_nearer(&before, &worse));
        *figures[i] = NAN;
        assert_false(iso_level_gate_is_nearer(&before, &worse));
    }
}

/* Directions in disorder are a level that no gate takes. */
TEST(a_spoilt_level_is_not_accepted)
{
    OWNED(iso_pyramid) p = bumpy_ball(ISO_CODE_FIT);
    const iso_scene scene = surface_scene();
    const size_t count = iso_geometry_voxel_count(&p.levels[1].geometry);
    iso_level spoilt = p.levels[1];
    iso_level_gate gate;
    spoilt.codes = malloc(3 * count);
    for (size_t i = 0; i < 3 * count; ++i)
        spoilt.codes[i] = (uint8_t)(p.levels[1].codes[i] / 2 + 40 * (i % 3));
    const iso_level_with_tf today = {&p.levels[1], NULL};
    assert_ok(iso_level_gate_judge(&p, 1, &scene, &today, &spoilt, 2, &gate, &err));
    assert_false(gate.accepts);
    assert_more_than(gate.optimized.ssim_dissimilarity, gate.today.ssim_dissimilarity);
    free(spoilt.codes);
}

/* ---- in a pyramid ------------------------------------------------------------------------------------------------ */

TEST(it_is_stored_and_shown_as_it_is)
{
    OWNED(iso_pyramid) p = bumpy_ball(ISO_CODE_FIT), loaded;
    const iso_scene scene = surface_scene();
    const iso_optimize_options opt = fast(2);
    const iso_adapt_options adapt = iso_adapt_defaults();
    iso_scene_level levels[32];
    iso_level_check checks[32];
    OWNED(iso_tf_table) tf, own;
    uint8_t *bytes;
    char *dir = iso_path_join(folder, "optimized.iso"), text[200];
    assert_ok(iso_scene_levels_make(&p, 1, &scene, &opt, 2, levels, NULL, &err));
    assert_int_equal(levels[1].chosen, ISO_LEVEL_OPTIMIZED);
    assert_at_most(levels[1].optimized.gate.optimized.ssim_dissimilarity,
                   0.7 * levels[1].optimized.gate.today.ssim_dissimilarity);
    assert_ok(iso_pyramid_save(&p, dir, &err));
    assert_ok(iso_pyramid_load(dir, &loaded, &err));
    assert_true(loaded.levels[1].is_optimized && loaded.levels[1].made_for_scene);
    assert_memory_equal(loaded.levels[1].codes, p.levels[1].codes, 3 * iso_geometry_voxel_count(&p.levels[1].geometry));
    assert_ok(iso_fit_verify(&loaded, 2, checks, NULL, &err));
    assert_null(checks[1].what);
    assert_non_null(strstr(iso_level_check_text(&checks[1], 1, text, sizeof text), "not remade"));
    assert_ok(iso_tf_tabulate(&scene.tf, 0, 1, &p.levels[0].geometry, &tf, &err));
    assert_ok(iso_adapt_level(&loaded, 1, &tf, &adapt, &own, NULL, &err));
    assert_memory_equal(own.entries, tf.entries, 4 * tf.count * sizeof(float));
    assert_ok(iso_extinction_scale_level(&loaded, 1, &tf, &own, 2, &bytes, &err));
    assert_null(bytes);
    free(dir);
}

TEST_MAIN(make_folder, remove_folder)

/* SPDX-License-Identifier: MIT */
/* Levels for a scene: which scalar is chosen, and that a pyramid which says so can be made again. */
#include "pyramids.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fit/extinction_scale.h"
#include "folder.h"
#include "plan/scene_levels.h"
#include "tf/adapt.h"
#include "tf/level_look.h"

/* A surface at a third of the range, lit by a headlight. */
static iso_tf_point points[] = {{0, {0.9, 0.7, 0.4}, 0},
                                {0.3, {0.9, 0.7, 0.4}, 0},
                                {0.36, {1, 0.9, 0.8}, 0.8},
                                {1, {0.6, 0.9, 0.8}, 0.8}};

static iso_scene surface_scene(void)
{
    return scene_of("surface.scene.json", points);
}

/* A ball with a bumpy surface, sharper than a coarse voxel. */
static iso_volume bumpy_ball(size_t n)
{
    iso_volume v = noise(n, n, n);
    float *data = v.data;
    for (size_t i = 0; i < n * n * n; ++i) {
        const double half = 0.5 * (double)n, x = (double)(i % n) + 0.5 - half, y = (double)(i / n % n) + 0.5 - half,
                     z = (double)(i / n / n) + 0.5 - half, r = sqrt(x * x + y * y + z * z) + 1e-9;
        const double surface = 0.33 * (double)n * (1 + 0.12 * sin(5 * x / r) * cos(4 * y / r) * sin(6 * z / r + 1));
        data[i] = (float)fmin(fmax(0.5 + 0.8 * (surface - r), 0), 1);
    }
    return v;
}

static iso_pyramid ball_pyramid(size_t n)
{
    iso_pyramid_options opt = iso_pyramid_defaults();
    OWNED(iso_volume) v = bumpy_ball(n);
    opt.level_count = 4;
    opt.threads = 2;
    iso_pyramid p = build(&v, &opt);
    return p;
}

/* ---- choosing ---------------------------------------------------------------------------------------------------- */

/* Places of ways. */
enum { BUILT, BUILT_SCALED, LEAST_SQUARES, DAMPED, DAMPED_SCALED, FITTED, FITTED_SCALED, OPTIMIZED };

static void set(iso_level_candidate *c, double ssim_dissimilarity, double rmse)
{
    *c = (iso_level_candidate){.tried = true,
                               .seen = {{0}, ssim_dissimilarity, rmse, 0.5 * ssim_dissimilarity, 0.5 * rmse}};
    for (int i = 0; i < ISO_LEVEL_GATE_VIEWS; ++i)
        c->seen.of_view[i] = ssim_dissimilarity;
}

TEST(ways_are_those_of_the_table)
{
    assert_int_equal(iso_level_ways[BUILT].scalar, ISO_LEVEL_AS_BUILT);
    assert_true(iso_level_ways[DAMPED_SCALED].scalar == ISO_LEVEL_DAMPED && iso_level_ways[DAMPED_SCALED].scaled);
    assert_true(iso_level_ways[FITTED].scalar == ISO_LEVEL_FITTED && !iso_level_ways[FITTED].scaled);
    assert_int_equal(OPTIMIZED, ISO_LEVEL_WAY_OPTIMIZED);
}

TEST(the_nearest_is_chosen)
{
    iso_level_candidate c[ISO_LEVEL_WAY_COUNT] = {{0}};
    set(&c[BUILT], 0.10, 0.05);
    set(&c[DAMPED_SCALED], 0.08, 0.05);
    set(&c[FITTED], 0.06, 0.05);
    assert_int_equal(iso_scene_level_choose(c), FITTED);
    set(&c[FITTED], 0.0799, 0.05); /* among those that are better, any gain counts */
    assert_int_equal(iso_scene_level_choose(c), FITTED);
    set(&c[FITTED], 0.09, 0.05);
    assert_int_equal(iso_scene_level_choose(c), DAMPED_SCALED);
    set(&c[DAMPED_SCALED], 0.11, 0.05);
    assert_int_equal(iso_scene_level_choose(c), FITTED);
    set(&c[FITTED], 0.11, 0.05);
    assert_int_equal(iso_scene_level_choose(c), BUILT);
}

TEST(what_is_no_clear_gain_is_not_chosen)
{
    iso_level_candidate c[ISO_LEVEL_WAY_COUNT] = {{0}};
    set(&c[BUILT], 0.10, 0.05);
    set(&c[LEAST_SQUARES], 0.10 * (1 - 0.5 * ISO_LEVEL_GATE_GAIN), 0.05);
    assert_int_equal(iso_scene_level_choose(c), BUILT); /* too little */
    set(&c[LEAST_SQUARES], 0.08, 0.05 * (1.01 + ISO_LEVEL_GATE_RMSE_LOSS));
    assert_int_equal(iso_scene_level_choose(c), BUILT); /* its colors are farther */
    set(&c[LEAST_SQUARES], 0.08, 0.05);
    c[LEAST_SQUARES].seen.of_view[7] = 0.10 + 1.1 * ISO_ADAPT_WORST_VIEW;
    assert_int_equal(iso_scene_level_choose(c), BUILT); /* a view is farther */
    set(&c[LEAST_SQUARES], 0.08, 0.05);
    assert_int_equal(iso_scene_level_choose(c), LEAST_SQUARES);
    c[LEAST_SQUARES].tried = false;
    assert_int_equal(iso_scene_level_choose(c), BUILT);
    set(&c[LEAST_SQUARES], NAN, 0.05);
    assert_int_equal(iso_scene_level_choose(c), BUILT);
}

/* No scene and no edit may be worse by more than 2 %; a gain elsewhere does not count. */
TEST(each_edit_can_refuse)
{
    iso_scene_level made = {0};
    for (int i = 0; i < 2 * ISO_LEVEL_GATE_EDITS; ++i) {
        made.edited_built[i / ISO_LEVEL_GATE_EDITS][i % ISO_LEVEL_GATE_EDITS] = 0.1;
        made.edited[i / ISO_LEVEL_GATE_EDITS][i % ISO_LEVEL_GATE_EDITS] = 0.05;
    }
    for (int i = 0; i < 2 * ISO_LEVEL_GATE_EDITS; ++i) {
        double *edited = &made.edited[i / ISO_LEVEL_GATE_EDITS][i % ISO_LEVEL_GATE_EDITS];
        *edited = 0.1019;
        assert_true(iso_scene_level_stands_edits(&made, 2));
        *edited = 0.1021;
        assert_false(iso_scene_level_stands_edits(&made, 2));
        *edited = NAN;
        assert_false(iso_scene_level_stands_edits(&made, 2));
        *edited = 0.05;
    }
    /* Rounding of 1e-4 moves .0009 to .0016, and .1 to .1064: what is near enough depends on the amplitude. */
    made.edited_rounding[0][1] = 1e-4;
    made.edited_built[0][1] = 0.0009;
    made.edited[0][1] = 0.0015;
    assert_true(iso_scene_level_stands_edits(&made, 2));
    made.edited[0][1] = 0.0017;
    assert_false(iso_scene_level_stands_edits(&made, 2));
    made.edited_built[0][1] = 0.1;
    made.edited[0][1] = 0.107;
    assert_false(iso_scene_level_stands_edits(&made, 2));
}

/* Scalars that look wrong lose, whatever they are called; those that look right win. */
VALUES_TEST(small_views_see_a_planted_scalar)
{
    OWNED(iso_pyramid) p = ball_pyramid(40);
    const iso_scene scene = surface_scene();
    const size_t count = iso_geometry_voxel_count(&p.levels[2].geometry);
    FREED float *good = malloc(count * sizeof *good), *bad = malloc(count * sizeof *bad);
    OWNED(iso_view) view;
    iso_level_candidate c[ISO_LEVEL_WAY_COUNT] = {{0}};
    assert_ok(iso_scene_resolve(&(iso_scene){.path = scene.path,
                                             .width = 8,
                                             .height = 8,
                                             .camera_fit = true,
                                             .orthographic = true,
                                             .camera_direction = {1, 0, 0},
                                             .camera_up = {0, 0, 1},
                                             .margin = 1,
                                             .step_voxels = 0.5,
                                             .shading = {.ambient = 1},
                                             .tf = scene.tf},
                                &p.levels[0].geometry, p.levels[0].min, p.levels[0].max, &view, &err));
    assert_ok(iso_level_scalars_make(&(iso_level_scalar_input){&p.levels[0], &view.tf, 2, 2}, bad, good, NULL, &err));
    for (size_t i = 0; i < count; ++i)
        bad[i] = p.levels[2].scalar[i] + 0.3f * ((float)noise_at(i) - 0.5f);
    assert_ok(iso_scene_level_judge(&p, 2, &scene,
                                    (float *[ISO_LEVEL_SCALAR_COUNT]){p.levels[2].scalar, bad, NULL, good}, 2, c,
                                    &err));
    assert_true(c[LEAST_SQUARES].seen.ssim_dissimilarity > c[BUILT].seen.ssim_dissimilarity);
    assert_int_equal(iso_level_ways[iso_scene_level_choose(c)].scalar, ISO_LEVEL_FITTED);
    assert_ok(iso_scene_level_judge(&p, 2, &scene,
                                    (float *[ISO_LEVEL_SCALAR_COUNT]){p.levels[2].scalar, NULL, NULL, bad}, 2, c,
                                    &err));
    assert_int_equal(iso_level_ways[iso_scene_level_choose(c)].scalar, ISO_LEVEL_AS_BUILT);
    assert_true(c[FITTED].tried && !c[LEAST_SQUARES].tried);
    assert_ok(
        iso_scene_level_judge(&p, 2, &scene, (float *[ISO_LEVEL_SCALAR_COUNT]){bad, p.levels[2].scalar}, 2, c, &err));
    assert_int_equal(iso_scene_level_choose(c), LEAST_SQUARES);
}

/* The same numbers as those of the filter, made another way: rounding, what its apron leaves out, and for damped ones
 * sums in another order. */
static void expect_scalars_of_filter(iso_scalar_filter filter)
{
    iso_pyramid_options opt = iso_pyramid_defaults();
    OWNED(iso_volume) v = noise(37, 21, 30);
    opt.scalar_filter = filter;
    opt.threads = 2;
    OWNED(iso_pyramid) p = build(&v, &opt);
    for (size_t level = 1; level < p.level_count; ++level) {
        const size_t count = iso_geometry_voxel_count(&p.levels[level].geometry);
        const iso_level_scalar_input in = {&p.levels[0], NULL, level, 3};
        float *made = malloc(count * sizeof *made);
        assert_ok(iso_level_scalars_make(&in, made, NULL, NULL, &err));
        if (filter == ISO_SCALAR_DAMPED)
            iso_level_scalar_damp(&in, made);
        for (size_t i = 0; i < count; ++i)
            assert_within((double)made[i], (double)p.levels[level].scalar[i], 1e-5);
        free(made);
    }
}

TEST(least_squares_are_those_of_the_filter)
{
    expect_scalars_of_filter(ISO_SCALAR_LEAST_SQUARES);
}

TEST(damped_scalars_are_those_of_the_filter)
{
    expect_scalars_of_filter(ISO_SCALAR_DAMPED);
}

/* ---- making, storing, making again ------------------------------------------------------------------------------- */

static iso_scene_level ball_levels[32]; /* of the ball, made once for the cases below */

static iso_pyramid stored_ball(void)
{
    iso_pyramid loaded;
    FREED char *dir = iso_path_join(folder, "ball.iso");
    if (!ball_levels[1].candidates[0][BUILT].tried) {
        OWNED(iso_pyramid) p = ball_pyramid(40);
        const iso_scene scene = surface_scene();
        assert_ok(iso_scene_levels_make(&p, 1, &scene, 1, NULL, 2, ball_levels, NULL, &err));
        assert_ok(iso_pyramid_save(&p, dir, &err));
    }
    assert_ok(iso_pyramid_load(dir, &loaded, &err));
    return loaded;
}

TEST(a_sharp_surface_gets_levels_of_its_own)
{
    OWNED(iso_pyramid) p = stored_ball();
    OWNED(iso_tf_table) tf;
    iso_level_scalar kinds[32];
    assert_int_equal(iso_level_ways[ball_levels[2].chosen].scalar, ISO_LEVEL_FITTED);
    assert_at_most(ball_levels[2].candidates[0][ball_levels[2].chosen].seen.ssim_dissimilarity,
                   0.95 * ball_levels[2].candidates[0][BUILT].seen.ssim_dissimilarity); /* .93 */
    assert_at_most(ball_levels[2].fit.error_end, ball_levels[2].fit.error_start);
    assert_ok(iso_level_scalars_read(&p, &tf, kinds, &err));
    for (size_t k = 1; k < p.level_count; ++k)
        assert_int_equal(kinds[k], iso_level_ways[ball_levels[k].chosen].scalar);
    assert_true(p.levels[2].made_for_scene);
    for (size_t i = 0; i < iso_geometry_voxel_count(&p.levels[2].geometry); ++i)
        assert_true((double)p.levels[2].scalar[i] >= p.levels[2].min &&
                    (double)p.levels[2].scalar[i] <= p.levels[2].max);
}

TEST(it_is_made_again_from_level_0)
{
    iso_level_check checks[32];
    OWNED(iso_pyramid) p = stored_ball();
    for (int threads = 1; threads < 4; threads += 2) {
        assert_ok(iso_fit_verify(&p, threads, checks, NULL, &err));
        for (size_t k = 0; k < p.level_count; ++k)
            assert_null(checks[k].what);
    }
    p.levels[2].scalar[17] = nextafterf(p.levels[2].scalar[17], 9);
    assert_ok(iso_fit_verify(&p, 1, checks, NULL, &err));
    assert_string_equal(checks[2].what, "values");
    assert_true(checks[2].differing == 1 && checks[2].first[0] == 17 % p.levels[2].geometry.size[0]);
    p.levels[2].scalar[17] = nextafterf(p.levels[2].scalar[17], -9);
    p.levels[2].max *= 1.5;
    assert_ok(iso_fit_verify(&p, 1, checks, NULL, &err));
    assert_string_equal(checks[2].what, "range");
}

/* A scaled level is made again with its scale, under its own transfer function. */
VALUES_TEST(its_extinction_scale_is_made_again)
{
    iso_level_check checks[32];
    OWNED(iso_pyramid) p = stored_ball();
    iso_level *l = &p.levels[1];
    OWNED(iso_tf_table) tf, own;
    uint8_t *scale;
    assert_ok(iso_level_scene_tf(&p, 0, &tf, &err));
    assert_ok(iso_level_look(&p, 1, &tf, &own, NULL, &err));
    free(l->scale);
    l->scale = NULL;
    json_t *made_for = p.made_for;
    p.made_for = NULL;
    assert_ok(iso_extinction_scale_level(&p, 1, &tf, &own, 2, &scale, &err));
    p.made_for = made_for;
    l->scale = scale;
    assert_ok(iso_fit_verify(&p, 2, checks, NULL, &err));
    assert_null(checks[1].what);
    scale[100] ^= 1;
    assert_ok(iso_fit_verify(&p, 2, checks, NULL, &err));
    assert_string_equal(checks[1].what, "extinction scale");
    assert_int_equal(checks[1].differing, 1);
}

/* Levels of two scenes that nothing optimizes: one scalar and one scale for both, made again from level 0. */
TEST(two_scenes_share_a_scale)
{
    iso_scene scenes[2] = {surface_scene(), surface_scene()};
    iso_tf_point fainter[4];
    iso_level_check checks[32];
    iso_scene_level levels[32];
    OWNED(iso_pyramid) p = ball_pyramid(ISO_SANITIZED ? 24 : 40);
    memcpy(fainter, points, sizeof fainter);
    fainter[2].opacity = fainter[3].opacity = 0.3;
    assert_status(iso_scene_levels_make(&p, 1, scenes, 2, NULL, 2, levels, NULL, &err), ISO_E_USAGE); /* the same */
    scenes[1].tf.points = fainter;
    assert_ok(iso_scene_levels_make(&p, 1, scenes, 2, NULL, 2, levels, NULL, &err));
    assert_non_null(p.levels[1].scale);
    const double worst = fmax(iso_scene_level_ratio(&levels[1], 0), iso_scene_level_ratio(&levels[1], 1));
    for (int way = BUILT; way < FITTED; ++way) {
        levels[1].chosen = way;
        assert_at_most(worst, fmax(iso_scene_level_ratio(&levels[1], 0), iso_scene_level_ratio(&levels[1], 1)));
    }
    assert_ok(iso_fit_verify(&p, 2, checks, NULL, &err));
    for (size_t k = 1; k < p.level_count; ++k)
        assert_null(checks[k].what);
    json_object_del(p.made_for, "others"); /* as if the scale were the first scene's alone */
    assert_ok(iso_fit_verify(&p, 2, checks, NULL, &err));
    assert_string_equal(checks[1].what, "extinction scale");
}

/* What pyramid.json says is what is checked: neither a mean that calls itself fitted passes, nor another TF's fit. */
VALUES_TEST(what_it_says_of_itself_is_held_to_it)
{
    iso_level_check checks[32];
    OWNED(iso_pyramid) p = stored_ball();
    json_t *all = json_object_get(p.made_for, "levels"), *entry = json_array_get(all, 1);
    json_object_set_new(entry, "scalar", json_string("least-squares"));
    assert_ok(iso_fit_verify(&p, 2, checks, NULL, &err));
    assert_string_equal(checks[2].what, "values");
    json_object_set_new(entry, "scalar", json_string("fitted"));
    json_t *point = json_array_get(json_object_get(json_object_get(p.made_for, "tf"), "points"), 1);
    json_object_set_new(point, "value", json_real(0.32));
    assert_ok(iso_fit_verify(&p, 2, checks, NULL, &err));
    assert_string_equal(checks[2].what, "values");
    json_object_set_new(entry, "scalar", json_string("guessed"));
    assert_status(iso_fit_verify(&p, 2, checks, NULL, &err), ISO_E_FORMAT);
}

TEST(memory_is_estimated)
{
    const size_t size[3] = {100, 100, 100};
    const iso_geometry g = iso_geometry_axis_aligned(size, (const double[]){1, 1, 1});
    /* A byte of the volume; floats and codes of the pyramid; lattice directions while level 0 is drawn; pictures of
     * four floats at 157 x 157 pixels of 1.1 voxels: eight of a scene, and 16 after edits. */
    const double picture = 16 * 157 * 157 / 1e6, plain = (double)iso_scene_levels_bytes(&g, ISO_U8, 1, 0) / 1e6;
    assert_within(plain, 1 + 8 + 12 + 8 * picture, 0.5);
    assert_within((double)iso_scene_levels_bytes(&g, ISO_U8, 3, 0) / 1e6 - plain, 16 * picture, 1e-9);
    assert_within((double)(iso_scene_levels_bytes(&g, ISO_U8, 3, ISO_EFFORT_FAST) -
                           iso_scene_levels_bytes(&g, ISO_U8, 1, ISO_EFFORT_FAST)) /
                      1e6,
                  2 * 24 * picture, 1e-9);
}

TEST_MAIN(make_folder, remove_folder)

/* SPDX-License-Identifier: MIT */
/* Levels found by rendering: nearer to level 0, the same for any number of threads, judged before they are taken,
 * stored, and shown under their own transfer function and extinction scale. */
#include "pyramids.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fit/extinction_scale.h"
#include "folder.h"
#include "plan/patch_loss.h"
#include "plan/scene_levels.h"
#include "scene/level_view.h"
#include "tf/adapt.h"
#include "tf/level_look.h"

/* A surface in the middle of the range, under a headlight. */
static iso_tf_point points[] = {{0, {0.9, 0.7, 0.4}, 0},
                                {0.45, {0.9, 0.7, 0.4}, 0},
                                {0.55, {1, 0.9, 0.8}, 0.8},
                                {1, {0.6, 0.9, 0.8}, 0.8}};

static iso_scene surface_scene(void)
{
    return scene_of("surface.scene.json", points);
}

/* A softer surface at a lower value, of another color. */
static iso_scene faint_scene(void)
{
    static iso_tf_point faint[] = {{0, {0.2, 0.5, 0.9}, 0},
                                   {0.35, {0.2, 0.5, 0.9}, 0},
                                   {0.5, {0.3, 0.6, 1}, 0.7},
                                   {1, {0.2, 0.5, 0.9}, 0.7}};
    return scene_of("faint.scene.json", faint);
}

/* A ball with bumps of about two coarse voxels. */
enum { N = 28, HALF = N / 2 };
static iso_pyramid bumpy_ball(iso_code code)
{
    iso_pyramid_options opt = iso_pyramid_defaults();
    const iso_geometry g = iso_geometry_axis_aligned((size_t[]){N, N, N}, (double[]){1, 1, 1});
    OWNED(iso_volume) v;
    assert_ok(iso_volume_create(&v, &g, ISO_F32, "test", &err));
    for (size_t i = 0; i < (size_t)N * N * N; ++i) {
        const double x = (double)(i % N) + 0.5 - HALF, y = (double)(i / N % N) + 0.5 - HALF,
                     z = (double)(i / N / N) + 0.5 - HALF;
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
    return (
        iso_optimize_options){.effort = ISO_EFFORT_FAST, .seed = 5, .rate = 1, .scene_count = 1, .threads = threads};
}

/* Level 1 as it was built, under the scene's transfer function. */
static iso_shown_level as_built(const iso_pyramid *p, const iso_scene *scene, iso_tf_table *tf)
{
    assert_ok(iso_tf_tabulate(&scene->tf, iso_pyramid_lo(p), iso_pyramid_hi(p), &p->levels[0].geometry, tf, &err));
    return (iso_shown_level){&p->levels[1], tf, NULL};
}

TEST(a_level_is_nearer_within_its_limits)
{
    OWNED(iso_pyramid) p = bumpy_ball(ISO_CODE_FIT);
    const iso_scene scene = surface_scene();
    const size_t count = iso_geometry_voxel_count(&p.levels[1].geometry);
    OWNED(iso_tf_table) tf;
    const iso_shown_level start = as_built(&p, &scene, &tf);
    const iso_optimize_options opt = fast(2);
    OWNED(iso_optimized) o;
    assert_ok(iso_optimize_level(&p, 1, &scene, &start, &opt, &o, NULL, &err));
    assert_false(iso_tf_table_equals(&o.tfs[0], &tf));
    size_t scaled = 0;
    assert_at_most(o.error, 0.8 * o.error_first);
    for (size_t i = 0; i < count; ++i) {
        const float *d = o.directions + 3 * i;
        assert_at_most((double)(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]), 1 + 1e-6); /* floats */
        assert_true(o.scalar[i] >= -0.5f && o.scalar[i] <= 1.5f);
        assert_true(o.scale[i] <= ISO_EXTINCTION_SCALE_LAST);
        scaled += o.scale[i] != ISO_EXTINCTION_SCALE_ONE;
    }
    assert_true(scaled > count / 10);
    for (size_t i = 0; i < 4 * tf.count; ++i)
        assert_true(o.tfs[0].entries[i] >= 0 && (i % 4 == 3 || o.tfs[0].entries[i] <= 1));
}

TEST(a_stopped_run_returns_the_level_so_far)
{
    OWNED(iso_pyramid) p = bumpy_ball(ISO_CODE_FIT);
    const iso_scene scene = surface_scene();
    const volatile sig_atomic_t stop = 1;
    iso_optimize_options opt = fast(2);
    OWNED(iso_optimized) o;
    OWNED(iso_tf_table) tf;
    iso_shown_level start = as_built(&p, &scene, &tf);
    uint8_t scale[HALF * HALF * HALF];
    for (size_t i = 0; i < sizeof scale; ++i)
        scale[i] = (uint8_t)(i * 7 % (ISO_EXTINCTION_SCALE_LAST + 1));
    start.scale = scale;
    opt.stop = &stop;
    assert_ok(iso_optimize_level(&p, 1, &scene, &start, &opt, &o, NULL, &err));
    assert_int_equal(o.steps, 0);
    assert_memory_equal(o.scale, scale, sizeof scale);
    assert_true(iso_tf_table_equals(&o.tfs[0], &tf));
    assert_memory_equal(o.scalar, p.levels[1].scalar, iso_geometry_voxel_count(&p.levels[1].geometry) * sizeof(float));
}

/* Returns the gate's judgment of the level under a transfer function that is optimized alone. */
static void optimize_alone(const iso_pyramid *p, const iso_scene *scene, const iso_shown_level *start,
                           const iso_optimize_options *opt, iso_tf_table *tf, iso_level_seen seen[2])
{
    iso_level_gate gate;
    assert_ok(iso_level_gate_open(&gate, p, scene, 2, &err));
    assert_ok(iso_optimize_tf(&gate, 1, scene, start, opt, tf, seen, NULL, &err));
    iso_level_gate_close(&gate);
}

VALUES_TEST(a_transfer_function_is_optimized_alone)
{
    OWNED(iso_pyramid) p = bumpy_ball(ISO_CODE_FIT);
    const iso_scene scene = surface_scene();
    iso_optimize_options opt = fast(2);
    OWNED(iso_tf_table) tf, better;
    OWNED(iso_optimized) o;
    const iso_shown_level start = as_built(&p, &scene, &tf);
    iso_level_seen seen[2];
    for (size_t i = 0; i < tf.count; ++i)
        tf.entries[4 * i + 3] *= 0.25f; /* a wrong one, so that there is something to find */
    optimize_alone(&p, &scene, &start, &opt, &better, seen);
    assert_at_most(seen[1].ssim_dissimilarity, 0.9 * seen[0].ssim_dissimilarity);
    assert_at_most(seen[1].rmse, 0.7 * seen[0].rmse);
    assert_false(iso_tf_table_equals(&better, &tf));
    opt.only_tf = true; /* the level stays */
    assert_ok(iso_optimize_level(&p, 1, &scene, &start, &opt, &o, NULL, &err));
    assert_memory_equal(o.scalar, p.levels[1].scalar, iso_geometry_voxel_count(&p.levels[1].geometry) * sizeof(float));
}

TEST(a_transfer_function_stays_if_none_is_nearer)
{
    OWNED(iso_pyramid) p = bumpy_ball(ISO_CODE_FIT);
    const iso_scene scene = surface_scene();
    const volatile sig_atomic_t stop = 1;
    iso_optimize_options opt = fast(2);
    OWNED(iso_tf_table) tf, same;
    const iso_shown_level start = as_built(&p, &scene, &tf);
    iso_level_seen seen[2];
    opt.stop = &stop;
    optimize_alone(&p, &scene, &start, &opt, &same, seen);
    assert_true(iso_tf_table_equals(&same, &tf));
    assert_memory_equal(&seen[0], &seen[1], sizeof seen[0]);
}

TEST(scenes_that_cannot_be_learned_are_refused)
{
    iso_tf_point hidden[] = {{0, {1, 1, 1}, 0}, {1, {1, 1, 1}, 0}};
    OWNED(iso_pyramid) p = bumpy_ball(ISO_CODE_FIT), other = bumpy_ball(ISO_CODE_REGION48);
    iso_scene scene = surface_scene();
    const iso_optimize_options opt = fast(2);
    iso_optimized o;
    OWNED(iso_tf_table) tf;
    iso_shown_level start = as_built(&other, &scene, &tf);
    assert_status(iso_optimize_level(&other, 1, &scene, &start, &opt, &o, NULL, &err), ISO_E_RANGE);
    start.level = &p.levels[1];
    p.levels[0].geometry.has_no_data = true;
    assert_status(iso_optimize_level(&p, 1, &scene, &start, &opt, &o, NULL, &err), ISO_E_RANGE);
    p.levels[0].geometry.has_no_data = false;
    scene.tf.points = hidden;
    scene.tf.point_count = 2;
    assert_status(iso_optimize_level(&p, 1, &scene, &start, &opt, &o, NULL, &err), ISO_E_RANGE);
}

/* ---- the loss of a patch ----------------------------------------------------------------------------------------- */

enum { SIDE = 52, BOX = 8, SMALL = 7, FIRST = 32 }; /* the picture's border cuts the patch, and boxes in it */

/* A true picture of one alpha everywhere, another one in small, and the drawn patch of the first. */
typedef struct loss_case {
    uint16_t rgba[4 * SIDE * SIDE], small[4 * SMALL * SMALL];
    float drawn[4 * ISO_ADJOINT_PIXELS], slopes[4 * ISO_ADJOINT_PIXELS];
    iso_patch_truth truth;
} loss_case;

static void begin_loss(loss_case *c, uint16_t alpha, uint16_t small_alpha)
{
    memset(c, 0, sizeof *c);
    c->truth = (iso_patch_truth){c->rgba, c->small, SIDE, SMALL, BOX, FIRST, FIRST};
    for (size_t i = 0; i < (size_t)SIDE * SIDE; ++i)
        c->rgba[4 * i + 3] = alpha;
    for (size_t i = 0; i < (size_t)SMALL * SMALL; ++i)
        c->small[4 * i + 3] = small_alpha;
    for (size_t i = 0; i < ISO_ADJOINT_PIXELS; ++i)
        c->drawn[4 * i + 3] = (float)alpha / 65535;
}

/* The patch is the truth, pixel by pixel, and .1 from it in small, in the four boxes that the border does not cut. */
TEST(a_patch_is_judged_in_small_too)
{
    loss_case c;
    const double wrong = 6553.5 / 65535, slope = wrong / sqrt(wrong * wrong + 1e-4), boxes = 4.0 * BOX * BOX;
    begin_loss(&c, 32768, 32768);
    assert_within(iso_patch_loss(&c.truth, c.drawn, c.slopes), 0, 1e-3); /* floats: 1e-8 of each of 1,024 pixels */
    begin_loss(&c, 32768, 26214);
    const double expected = (double)ISO_SMALL_WEIGHT * boxes * (sqrt(wrong * wrong + 1e-4) - 0.01);
    assert_within(iso_patch_loss(&c.truth, c.drawn, c.slopes), expected, 1e-3); /* and a half of 1/65535 */
    for (size_t i = 0; i < ISO_ADJOINT_PIXELS; ++i) {
        const bool counts = i % 32 < 2 * BOX && i / 32 < 2 * BOX;
        assert_within((double)c.slopes[4 * i + 3], counts ? (double)ISO_SMALL_WEIGHT * slope : 0, 1e-4); /* the same */
    }
}

/* Slopes against finite differences; 5e-3: floats of a loss of at most 20, with steps of 1/512. */
TEST(slopes_are_those_of_the_loss)
{
    loss_case c;
    float unused[4 * ISO_ADJOINT_PIXELS];
    begin_loss(&c, 30000, 20000);
    for (size_t i = 0; i < sizeof c.drawn / sizeof *c.drawn; ++i)
        c.drawn[i] = 0.2f + 0.6f * (float)(i * 37 % 101) / 101;
    for (size_t i = 0; i < sizeof c.rgba / sizeof *c.rgba; ++i)
        c.rgba[i] = (uint16_t)(i * 7919 % 65536);
    iso_patch_loss(&c.truth, c.drawn, c.slopes);
    for (size_t i = 0; i < sizeof c.drawn / sizeof *c.drawn; i += 29) {
        const float at = c.drawn[i], h = 1.0f / 512;
        c.drawn[i] = at + h;
        const double above = iso_patch_loss(&c.truth, c.drawn, unused);
        c.drawn[i] = at - h;
        const double below = iso_patch_loss(&c.truth, c.drawn, unused);
        c.drawn[i] = at;
        assert_within((double)c.slopes[i], (above - below) / (2 * (double)h), 5e-3);
    }
}

/* ---- the gate ---------------------------------------------------------------------------------------------------- */

TEST(each_figure_of_the_gate_can_refuse)
{
    const iso_level_seen before = {{0}, 0.1, 0.05, 0.04, 0.02};
    const iso_level_seen nearer = {{0}, 0.09, 0.05, 0.03, 0.02};
    assert_true(iso_level_gate_is_nearer(&before, &nearer, 1));
    for (int i = 0; i < 4; ++i) {
        iso_level_seen worse = nearer;
        double *figures[4] = {&worse.ssim_dissimilarity, &worse.rmse, &worse.small_ssim_dissimilarity,
                              &worse.small_rmse};
        *figures[i] = i % 2 == 0 ? 0.985 * (i == 0 ? 0.1 : 0.04) : 1.01 * *figures[i];
        assert_false(iso_level_gate_is_nearer(&before, &worse, 1));
        *figures[i] = NAN;
        assert_false(iso_level_gate_is_nearer(&before, &worse, 1));
    }
}

/* A gain in one scene does not buy a loss in another of more than 2 %. */
TEST(each_scene_can_refuse)
{
    const iso_level_seen before[2] = {{{0}, 0.1, 0.05, 0.04, 0.02}, {{0}, 0.2, 0.05, 0.08, 0.02}};
    const iso_level_seen after[2] = {{{0}, 0.05, 0.04, 0.02, 0.01}, {{0}, 0.203, 0.0505, 0.081, 0.0202}};
    assert_true(iso_level_gate_is_nearer(before, after, 2));
    assert_false(iso_level_gate_is_nearer(before + 1, after + 1, 1)); /* alone it gains nothing */
    for (int i = 0; i < 4; ++i) {
        iso_level_seen worse[2] = {after[0], after[1]};
        double *figures[4] = {&worse[1].ssim_dissimilarity, &worse[1].rmse, &worse[1].small_ssim_dissimilarity,
                              &worse[1].small_rmse};
        *figures[i] *= 1.02;
        assert_false(iso_level_gate_is_nearer(before, worse, 2));
    }
    assert_false(iso_level_gate_is_nearer(before, before, 2)); /* no gain in either */
}

/* Directions in disorder are a level that no gate takes. */
TEST(a_spoilt_level_is_not_accepted)
{
    OWNED(iso_pyramid) p = bumpy_ball(ISO_CODE_FIT);
    const iso_scene scene = surface_scene();
    const size_t count = iso_geometry_voxel_count(&p.levels[1].geometry);
    iso_level spoilt = p.levels[1];
    iso_level_gate gate;
    iso_level_seen seen[4];
    uint8_t faint[HALF * HALF * HALF] = {0}; /* an extinction scale */
    OWNED(iso_tf_table) tf, halved;
    iso_shown_level shown = as_built(&p, &scene, &tf);
    assert_ok(iso_tf_table_copy(&tf, &halved, &err));
    for (size_t i = 0; i < tf.count; ++i)
        halved.entries[4 * i + 3] *= 0.1f;
    spoilt.codes = malloc(3 * count);
    for (size_t i = 0; i < 3 * count; ++i)
        spoilt.codes[i] = (uint8_t)(p.levels[1].codes[i] / 2 + 40 * (i % 3));
    assert_ok(iso_level_gate_open(&gate, &p, &scene, 2, &err));
    assert_ok(iso_level_gate_look(&gate, 1, &shown, &seen[0], &err));
    shown.level = &spoilt;
    assert_ok(iso_level_gate_look(&gate, 1, &shown, &seen[1], &err));
    shown = (iso_shown_level){&p.levels[1], &halved, NULL};
    assert_ok(iso_level_gate_look(&gate, 1, &shown, &seen[2], &err));
    shown = (iso_shown_level){&p.levels[1], &tf, faint};
    assert_ok(iso_level_gate_look(&gate, 1, &shown, &seen[3], &err));
    for (int i = 1; i < 4; ++i) { /* directions; transfer function; extinction scale */
        assert_false(iso_level_gate_is_nearer(&seen[0], &seen[i], 1));
        assert_more_than(seen[i].ssim_dissimilarity, seen[0].ssim_dissimilarity);
    }
    iso_level_gate_close(&gate);
    free(spoilt.codes);
}

/* ---- in a pyramid ------------------------------------------------------------------------------------------------ */

/* Levels for one scene and for two, made once for the cases below. */
typedef struct made_level {
    iso_pyramid p;
    iso_scene_level levels[32];
} made_level;
static made_level made, shared;
static char *path; /* of made */

static void make_level(made_level *m, size_t scene_count, int threads)
{
    const iso_scene scenes[2] = {surface_scene(), faint_scene()};
    const iso_optimize_options opt = fast(0);
    m->p = bumpy_ball(ISO_CODE_FIT);
    assert_ok(iso_scene_levels_make(&m->p, 1, scenes, scene_count, &opt, threads, m->levels, NULL, &err));
}

static int make_levels(void **state)
{
    if (make_folder(state) != 0)
        return -1;
    path = iso_path_join(folder, "optimized.iso");
    make_level(&made, 1, 2);
    make_level(&shared, 2, 1);
    assert_ok(iso_pyramid_save(&made.p, path, &err));
    return 0;
}

static int remove_levels(void **state)
{
    iso_pyramid_destroy(&made.p);
    iso_pyramid_destroy(&shared.p);
    free(path);
    return remove_folder(state);
}

static iso_pyramid loaded_level(void)
{
    iso_pyramid loaded;
    assert_ok(iso_pyramid_load(path, &loaded, &err));
    return loaded;
}

TEST(it_is_stored_bit_by_bit)
{
    iso_level_check checks[32];
    OWNED(iso_pyramid) loaded = loaded_level();
    const size_t count = iso_geometry_voxel_count(&made.p.levels[1].geometry);
    char text[200];
    assert_int_equal(made.levels[1].chosen, ISO_LEVEL_WAY_OPTIMIZED);
    assert_at_most(made.levels[1].candidates[0][ISO_LEVEL_WAY_OPTIMIZED].seen.ssim_dissimilarity,
                   0.7 * made.levels[1].candidates[0][ISO_LEVEL_WAY_BUILT].seen.ssim_dissimilarity);
    assert_true(loaded.levels[1].is_optimized && loaded.levels[1].made_for_scene);
    assert_memory_equal(loaded.levels[1].codes, made.p.levels[1].codes, 3 * count);
    assert_memory_equal(loaded.levels[1].scale, made.p.levels[1].scale, count);
    assert_ok(iso_fit_verify(&loaded, 2, checks, NULL, &err));
    assert_null(checks[1].what);
    assert_non_null(strstr(iso_level_check_text(&checks[1], 1, text, sizeof text), "not remade"));
}

TEST(it_is_shown_under_its_own_transfer_function)
{
    const iso_scene scene = surface_scene();
    const iso_adapt_options adapt = iso_adapt_defaults();
    iso_adapt_judgment judgment;
    iso_level_gate gate;
    iso_level_seen seen;
    OWNED(iso_pyramid) loaded = loaded_level();
    const size_t count = iso_geometry_voxel_count(&made.p.levels[1].geometry);
    OWNED(iso_tf_table) tf, own;
    uint8_t *bytes;
    as_built(&made.p, &scene, &tf);
    OWNED(iso_view) view = {.step_voxels = 0.5};
    bool found;
    assert_ok(iso_tf_table_copy(&tf, &view.tf, &err));
    assert_ok(iso_view_take_level(&view, &loaded, 1, &found, &err));
    assert_true(found && !iso_tf_table_equals(&view.tf, &tf));
    assert_memory_equal(view.extinction_scale, made.p.levels[1].scale, count);
    assert_ok(iso_adapt_level(&loaded, 1, &tf, &adapt, &own, &judgment, &err));
    assert_true(iso_tf_table_equals(&own, &view.tf) && !judgment.use_original);
    assert_ok(iso_extinction_scale_level(&loaded, 1, &tf, &own, 2, &bytes, &err));
    assert_memory_equal(bytes, made.p.levels[1].scale, count);
    free(bytes);
    /* What is shown is what the gate judged. */
    assert_ok(iso_level_gate_open(&gate, &loaded, &scene, 2, &err));
    assert_ok(iso_level_gate_look(&gate, 1, &(iso_shown_level){&loaded.levels[1], &view.tf, view.extinction_scale},
                                  &seen, &err));
    assert_memory_equal(&seen, &made.levels[1].candidates[0][ISO_LEVEL_WAY_OPTIMIZED].seen, sizeof seen);
    iso_level_gate_close(&gate);
}

/* Under another transfer function it keeps its scale, since directions and scalars were made with it; with --adapt it
 * is adapted and gets another scale. */
TEST(under_another_transfer_function_it_has_its_scale_or_is_adapted)
{
    const iso_scene scene = surface_scene();
    const iso_adapt_options adapt = iso_adapt_defaults();
    OWNED(iso_pyramid) loaded = loaded_level();
    const size_t count = iso_geometry_voxel_count(&made.p.levels[1].geometry);
    OWNED(iso_tf_table) tf, own;
    iso_adapt_judgment judgment;
    uint8_t *bytes;
    bool found = true;
    assert_true(loaded.levels[1].edits_are_scaled);
    as_built(&made.p, &scene, &tf);
    tf.entries[4 * 200 + 3] *= 1.001f;
    assert_ok(iso_level_look(&loaded, 1, &tf, &own, &found, &err));
    assert_true(!found && !own.entries);
    assert_ok(iso_extinction_scale_level(&loaded, 1, &tf, &tf, 2, &bytes, &err));
    assert_memory_equal(bytes, made.p.levels[1].scale, count);
    free(bytes);
    assert_ok(iso_adapt_level(&loaded, 1, &tf, &adapt, &own, &judgment, &err));
    assert_false(iso_tf_table_equals(&own, &tf) || judgment.use_original);
    assert_ok(iso_extinction_scale_level(&loaded, 1, &tf, &own, 2, &bytes, &err));
    assert_memory_not_equal(bytes, made.p.levels[1].scale, count);
    size_t scaled = 0;
    for (size_t i = 0; i < count; ++i)
        scaled += bytes[i] != ISO_EXTINCTION_SCALE_ONE;
    assert_true(scaled > 0);
    free(bytes);
    loaded.levels[1].edits_are_scaled = false; /* then an adapted one has none */
    assert_ok(iso_extinction_scale_level(&loaded, 1, &tf, &own, 2, &bytes, &err));
    for (size_t i = 0; i < count; ++i)
        assert_int_equal(bytes[i], ISO_EXTINCTION_SCALE_ONE);
    free(bytes);
}

/* The gate judges edits as commands with --adapt show them. */
TEST(edits_are_judged_as_they_are_shown)
{
    const iso_scene scene = surface_scene();
    const iso_adapt_options adapt = iso_adapt_defaults();
    iso_level_gate edits[ISO_LEVEL_GATE_EDITS];
    OWNED(iso_pyramid) loaded = loaded_level();
    const iso_level *level = &loaded.levels[1];
    assert_ok(iso_level_gate_open_edits(edits, &loaded, &scene, 2, &err));
    assert_true(iso_scene_level_stands_edits(&made.levels[1], 1));
    for (int i = 0; i < ISO_LEVEL_GATE_EDITS; ++i) {
        const iso_tf_table *tf = &edits[i].views->tf;
        OWNED(iso_tf_table) own;
        iso_level_seen seen;
        uint8_t *scale;
        assert_ok(iso_adapt_level(&loaded, 1, tf, &adapt, &own, NULL, &err));
        assert_ok(iso_extinction_scale_level(&loaded, 1, tf, &own, 2, &scale, &err));
        assert_ok(iso_level_gate_look(&edits[i], 1, &(iso_shown_level){level, &own, scale}, &seen, &err));
        assert_true(seen.ssim_dissimilarity == made.levels[1].edited[0][i]);
        free(scale);
        iso_level_gate_close(&edits[i]);
    }
}

/* Level 0 with less opacity: a display of 8 bits hides a part of 1/2000, not half of it. A bit more or less of the
 * display is a factor of four in its rounding, 6e-5 to 9e-5 here. */
TEST(an_edit_is_stood_if_a_display_hides_the_loss)
{
    const iso_scene scene = surface_scene();
    OWNED(iso_pyramid) p = bumpy_ball(ISO_CODE_FIT);
    iso_level_gate edits[ISO_LEVEL_GATE_EDITS];
    assert_ok(iso_level_gate_open_edits(edits, &p, &scene, 2, &err));
    for (int i = 0; i < ISO_LEVEL_GATE_EDITS; ++i) {
        assert_true(edits[i].rounding > 3e-5 && edits[i].rounding < 1.5e-4);
        for (int k = 0; k < 2; ++k) {
            OWNED(iso_tf_table) tf;
            iso_level_seen seen;
            assert_ok(iso_tf_table_copy(&edits[i].views->tf, &tf, &err));
            tf.point_count = 0;
            for (size_t j = 0; j < tf.count; ++j)
                tf.entries[4 * j + 3] *= k == 0 ? 0.9995f : 0.5f;
            assert_ok(iso_level_gate_look(&edits[i], 0, &(iso_shown_level){&p.levels[0], &tf, NULL}, &seen, &err));
            assert_true(seen.ssim_dissimilarity > 0);
            assert_true(iso_level_gate_stands(0, seen.ssim_dissimilarity, edits[i].rounding) == (k == 0));
        }
        iso_level_gate_close(&edits[i]);
    }
}

/* One level for two scenes: nearer in each, shown in each under a transfer function of its own. The planted
 * fault judges the level under the other scene's. */
TEST(two_scenes_share_a_level)
{
    const iso_scene scenes[2] = {surface_scene(), faint_scene()};
    const iso_pyramid *p = &shared.p;
    const iso_scene_level *levels = shared.levels;
    iso_tf_table own[2];
    assert_int_equal(levels[1].chosen, ISO_LEVEL_WAY_OPTIMIZED);
    for (int i = 0; i < 2; ++i) {
        const iso_level_candidate *c = &levels[1].candidates[i][ISO_LEVEL_WAY_OPTIMIZED];
        iso_level_gate gate;
        iso_level_seen seen;
        OWNED(iso_tf_table) tf;
        bool found;
        as_built(p, &scenes[i], &tf);
        assert_ok(iso_level_look(p, 1, &tf, &own[i], &found, &err));
        assert_true(found);
        assert_at_most(iso_scene_level_ratio(&levels[1], (size_t)i), 0.55);
        assert_ok(iso_level_gate_open(&gate, p, &scenes[i], 2, &err));
        for (int k = 0; k <= i; ++k) {
            assert_ok(iso_level_gate_look(&gate, 1, &(iso_shown_level){&p->levels[1], &own[i - k], p->levels[1].scale},
                                          &seen, &err));
            assert_true(k == 0 ? memcmp(&seen, &c->seen, sizeof seen) == 0
                               : !iso_level_gate_is_nearer(&levels[1].best[i], &seen, 1));
        }
        iso_level_gate_close(&gate);
    }
    FREED char *names = iso_level_scene_names(p);
    assert_string_equal(names, "surface.scene.json, faint.scene.json");
    iso_tf_table_destroy(&own[0]);
    iso_tf_table_destroy(&own[1]);
}

VALUES_TEST(threads_change_no_bit)
{
    made_level again;
    make_level(&again, 2, 3);
    const iso_level *a = &again.p.levels[1], *b = &shared.p.levels[1];
    const size_t count = iso_geometry_voxel_count(&b->geometry);
    assert_memory_equal(a->scalar, b->scalar, count * sizeof(float));
    assert_memory_equal(a->codes, b->codes, 3 * count);
    assert_memory_equal(a->scale, b->scale, count);
    for (int i = 0; i < 2; ++i) /* takes the time out */
        json_object_del(json_object_get(json_array_get(json_object_get((i ? &again : &shared)->p.made_for, "levels"),
                                                       0),
                                        "optimized"),
                        "seconds");
    assert_true(json_equal(again.p.made_for, shared.p.made_for));
    iso_pyramid_destroy(&again.p);
}

TEST(a_damaged_table_is_refused)
{
    const iso_scene scene = surface_scene();
    OWNED(iso_pyramid) loaded = loaded_level();
    json_t *table = json_object_get(json_array_get(json_object_get(loaded.made_for, "levels"), 0), "tf"),
           *entries = json_object_get(table, "entries");
    OWNED(iso_tf_table) tf, own;
    as_built(&made.p, &scene, &tf);
    json_array_set_new(entries, 5, json_real(1.5)); /* a color */
    assert_status(iso_level_look(&loaded, 1, &tf, &own, NULL, &err), ISO_E_FORMAT);
    json_array_set_new(entries, 5, json_string("red"));
    assert_status(iso_level_look(&loaded, 1, &tf, &own, NULL, &err), ISO_E_FORMAT);
    json_array_remove(entries, 5);
    assert_status(iso_level_look(&loaded, 1, &tf, &own, NULL, &err), ISO_E_FORMAT);
    json_object_set_new(table, "range", json_pack("[i, i]", 1, 1));
    assert_status(iso_level_look(&loaded, 1, &tf, &own, NULL, &err), ISO_E_FORMAT);
    assert_null(own.entries);
}

TEST_MAIN(make_levels, remove_levels)

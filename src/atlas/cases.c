/* SPDX-License-Identifier: MIT */
/* cases.c - the table of failures, and the function that runs them. */
#include <math.h>
#include <string.h>

#include "atlas/atlas.h"
#include "compare/metrics.h"

/* The right picture if a level's own scalars do not matter. */
#define TRUE_NORMALS(options) \
    { \
        "true normals", NULL, options " --shading-from float", iso_atlas_true_normals \
    }
/* The right picture if they do. */
#define LEVEL_0 \
    { \
        "level 0", NULL, NULL, NULL \
    }

/* Limits are at least 10 % away from the measured values (tests/test_atlas.c): results depend only on rounding. */
const iso_atlas_case iso_atlas_cases[] = {
    {"vanishing-gradients",
     "Vanishing gradients",
     "A smooth ball in nine gray values: central differences are zero on the plateaus, and samples there get only ambient light.",
     "Terraces and dull bands on a ball that is smooth.",
     "isoshade build --estimator sobel",
     {.field = iso_atlas_ball, .size = {24, 24, 24}, .values = 9, .lo = 0.25, .hi = 0.35, .extinction_per_mm = 40},
     {TRUE_NORMALS("--level 0"),
      {"central differences", NULL, "--level 0", NULL},
      {"Sobel, of 26 neighbors", "--estimator sobel", "--level 0", NULL}},
     0.024,
     0.011,
     NULL,
     NULL},
    {"opposite-normals",
     "Opposite normals",
     "Both faces of a thin shell fall into one coarse voxel. Their gradients cancel, and the sum is mostly noise in a random direction.",
     "Dents and lumps, some with rings around them, where two coarse voxels disagree.",
     "isoshade build --direction-filter tensor",
     {.field = iso_atlas_shell, .size = {32, 32, 32}, .noise = 0.1, .lo = 0.15, .hi = 0.4, .extinction_per_mm = 40},
     {TRUE_NORMALS("--level 2"),
      {"plain mean of the gradients", "--direction-filter naive", "--level 2", NULL},
      {"tensor mean, which has no sign to cancel", "--direction-filter tensor", "--level 2", NULL}},
     0.045,
     0.031,
     NULL,
     NULL},
    {"thin-plates",
     "Thin plates",
     "A plate fills a part of its coarse voxels, whose values stay below the range that the transfer function shows.",
     "The plate disappears.",
     "isoshade render --adapt",
     {.field = iso_atlas_plate,
      .size = {32, 32, 32},
      .lo = 0.6,
      .hi = 0.8,
      .extinction_per_mm = 60,
      .light = {-0.4, -0.8, 0},
      .height_mm = 2.4},
     {LEVEL_0,
      {"level 2 with the TF of level 0", NULL, "--level 2", NULL},
      {"level 2 with the TF adapted to it", NULL, "--level 2 --adapt", NULL}},
     0.37,
     0.11,
     NULL,
     NULL},
    {"thin-vessels",
     "Thin vessels",
     "A vessel thinner than a coarse voxel is lost in the coarse level, and no transfer function can restore it.",
     "The helix disappears.",
     "isoshade render --level 0 --step 0.5; only in important regions: isoshade render --roi, isoshade plan",
     {.field = iso_atlas_vessel, .size = {32, 32, 32}, .lo = 0.45, .hi = 0.75, .extinction_per_mm = 60},
     {LEVEL_0, {"level 2", NULL, "--level 2", NULL}, {"level 0 at twice the step", NULL, "--level 0 --step 0.5", NULL}},
     0.17,
     0.011,
     NULL,
     NULL},
    {"staircases",
     "Staircases",
     "The surface of a gently curved roof has steps at a coarse level, and gradients taken from that level follow them.",
     "Terraces like contour lines on a smooth roof.",
     "isoshade render --shading-from codes (the default)",
     {.field = iso_atlas_dome,
      .size = {48, 48, 48},
      .lo = 0.2,
      .hi = 0.8,
      .extinction_per_mm = 60,
      .forward = {0.15, 0.3, -1},
      .light = {-1, 0.2, 0.4},
      .height_mm = 1.3},
     {TRUE_NORMALS("--level 1"),
      {"gradients on the fly, of level 1", NULL, "--level 1 --shading-from on-the-fly", NULL},
      {"directions of level 0, filtered to level 1", NULL, "--level 1", NULL}},
     0.024,
     0.011,
     NULL,
     NULL},
    {"noise",
     "Noise",
     "Noise of 4 % of the range outweighs the difference between neighbors.",
     "A ball like orange peel: the noise is in the normals.",
     "isoshade build --estimator sobel",
     {.field = iso_atlas_ball, .size = {48, 48, 48}, .noise = 0.04, .lo = 0.25, .hi = 0.35, .extinction_per_mm = 40},
     {TRUE_NORMALS("--level 0"),
      {"central differences", NULL, "--level 0", NULL},
      {"Sobel, which averages neighbors", "--estimator sobel", "--level 0", NULL}},
     0.035,
     0.025,
     NULL,
     NULL},
    {"sharp-tf",
     "A sharp transfer function at a coarse level",
     "The TF shows a narrow band of values. Averages over a thin shell do not reach them.",
     "Holes in the shell, where the coarse values miss the band.",
     "isoshade render --adapt",
     {.field = iso_atlas_shells, .size = {48, 48, 48}, .band = true, .lo = 0.7, .hi = 1, .extinction_per_mm = 60},
     {LEVEL_0,
      {"level 1 with the TF of level 0", NULL, "--level 1", NULL},
      {"level 1 with the TF adapted to it", NULL, "--level 1 --adapt", NULL}},
     0.34,
     0.095,
     NULL,
     NULL},
    {"shared-value",
     "A tissue that shares its value with thin plates",
     "Plates that fill half of their coarse voxels have the same value there as the block next to them. An adapted TF shows each value as most of its voxels look, so the plates vanish with the block.",
     "Plates that are not there.",
     "isoshade render --adapt --tf-2d deviation",
     {.field = iso_atlas_block_and_plates,
      .size = {48, 48, 48},
      .lo = 0.6,
      .hi = 0.7,
      .extinction_per_mm = 60,
      .forward = {0.15, 1, -0.3},
      .height_mm = 2.6},
     {LEVEL_0,
      {"adapted over the value", NULL, "--level 1 --adapt --always", NULL},
      {"adapted, 2D: value and deviation", NULL, "--level 1 --adapt --tf-2d deviation", NULL}},
     0.24,
     0.08,
     NULL,
     NULL},
    {"shared-mean",
     "Two textures of one mean",
     "Gray, and alternating black and white, are the same at level 1. A TF of the value alone makes both look the same.",
     "The left half is visible, but should be transparent.",
     "isoshade render --adapt --tf-2d deviation",
     {.field = iso_atlas_two_textures,
      .size = {48, 48, 48},
      .lo = 0.6,
      .hi = 0.7,
      .extinction_per_mm = 60,
      .forward = {0.15, 1, -0.3},
      .height_mm = 2.6},
     {LEVEL_0,
      {"adapted over the value", NULL, "--level 1 --adapt", NULL},
      {"adapted, 2D: value and deviation", NULL, "--level 1 --adapt --tf-2d deviation", NULL}},
     0.27,
     0.13,
     NULL,
     NULL},
    {"large-steps",
     "Ray steps that miss a shell",
     "A band of values thinner than a step is hit or missed by chance.",
     "Rings and holes like wood grain.",
     "isoshade render --step 0.0625; or isoshade render --quadrature preintegrated",
     {.field = iso_atlas_shells, .size = {32, 32, 32}, .band = true, .lo = 0.4, .hi = 0.6, .extinction_per_mm = 150},
     {{"step of 1/64 voxel", NULL, "--level 0 --step 0.015625", NULL},
      {"step of one voxel", NULL, "--level 0 --step 1", NULL},
      {"step of 1/16 voxel", NULL, "--level 0 --step 0.0625", NULL}},
     0.1,
     0.00021,
     NULL,
     NULL},
    {"spacing",
     "Spacing",
     "Slices three times as thick as their pixels. Gradients are covariant: an index gradient used in world space leans towards the plane of the slices.",
     "Light from a wrong direction, and a ball that seems flattened.",
     "isoshade build (by the inverse transpose); a file without a header needs --raw-spacing",
     {.field = iso_atlas_ball, .size = {24, 24, 8}, .lo = 0.25, .hi = 0.35, .extinction_per_mm = 40},
     {TRUE_NORMALS("--level 0"),
      {"index gradients, as they are", NULL, "--level 0 --shading-from float", iso_atlas_index_gradients},
      {"by the inverse transpose", NULL, "--level 0", NULL}},
     0.06,
     0.0041,
     NULL,
     NULL},
    {"radius",
     "Eq. 1 with a large radius",
     "Within four voxels, Eq. 1 mixes the directions of neighboring balls, which face each other.",
     "Balls shaded wrongly where they nearly touch: see the enlarged square.",
     "isoshade build --direction-filter moments (the default: the coarse voxel's own eight voxels)",
     {.field = iso_atlas_balls, .size = {32, 32, 32}, .lo = 0.3, .hi = 0.6, .extinction_per_mm = 40, .height_mm = 1.2},
     {TRUE_NORMALS("--level 1"),
      {"radius 4, sigma 3", "--direction-filter eq1 --gauss-radius 4 --gauss-sigma 3", "--level 1", NULL},
      {"moments of its eight voxels", NULL, "--level 1", NULL}},
     0.057,
     0.0083,
     NULL,
     NULL},
    {"exponent-four",
     "Eq. 1 with a high power of the magnitude",
     "The longest gradient of the neighborhood dominates. With noise of 25 % of the range it is the noisiest one.",
     "A dented ball.",
     "isoshade build --direction-filter eq1 --eq1-exponent 1",
     {.field = iso_atlas_ball, .size = {48, 48, 48}, .noise = 0.25, .lo = 0.25, .hi = 0.35, .extinction_per_mm = 40},
     {TRUE_NORMALS("--level 2"),
      {"exponent 4", "--direction-filter eq1 --eq1-exponent 4", "--level 2", NULL},
      {"exponent 1", "--direction-filter eq1 --eq1-exponent 1", "--level 2", NULL}},
     0.024,
     0.013,
     NULL,
     NULL},
    {"lambda",
     "Eq. 2 with an extreme lambda",
     "The code of 48 regions moves its directions by Eq. 2 to spread them evenly. With lambda = 0 they stay unmoved, and are farthest apart around an axis.",
     "Directions around an axis, 1.5 degrees to each side: brighter is farther from any direction of the code. A bright cross is a hole.",
     "isoshade build --code fit (the default; region48 has the best lambda, 0.61)",
     {0},
     {{"each direction stored", NULL, NULL, NULL}, {"lambda 0", NULL, NULL, NULL}, {"lambda 0.61", NULL, NULL, NULL}},
     0.27,
     0.13,
     "largest angle to a stored direction, degrees",
     iso_atlas_draw_holes},
    {"code-folds",
     "Codes that fold",
     "The octahedral map is folded along its edges: filtering between codes on two sides of a fold gives an unrelated direction.",
     "Seams along arcs that meet at the pole of the ball.",
     "isoshade build --code fit (the default, which is linear)",
     {.field = iso_atlas_ball, .size = {16, 16, 16}, .lo = 0.25, .hi = 0.35, .extinction_per_mm = 40},
     {TRUE_NORMALS("--level 0"),
      {"oct24, filtered", NULL, "--level 0", iso_atlas_folded_codes},
      {"fit, filtered", NULL, "--level 0", NULL}},
     0.024,
     0.00081,
     NULL,
     NULL},
    {"code-poles",
     "Codes with poles",
     "Azimuth and polar angle as two numbers: at the seam, where the azimuth wraps, filtering turns the long way round; at the poles directions scatter.",
     "A seam of wrong light up to the pole.",
     "isoshade build --code fit (the default: vectors)",
     {.field = iso_atlas_ball,
      .size = {32, 32, 32},
      .lo = 0.25,
      .hi = 0.35,
      .extinction_per_mm = 40,
      .forward = {-1.6, 0.8, -1.2}},
     {TRUE_NORMALS("--level 0"),
      {"angles, filtered", NULL, "--level 0 --shading-from float", iso_atlas_coarse_angles},
      {"vectors, filtered", NULL, "--level 0 --shading-from float", iso_atlas_coarse_vectors}},
     0.049,
     0.0011,
     NULL,
     NULL},
    {"brick-seams",
     "Seams between bricks",
     "A fine and a coarse brick interpolate between different nodes on their common face.",
     "A cut through both bricks: the gray values jump in the middle, where they meet.",
     "isoshade plan --faces baked (the default, as in isoshade render --cache-bytes; --faces own shows the seams)",
     {.field = iso_atlas_ripples, .size = {17, 17, 17}, .hi = 1, .extinction_per_mm = 1},
     {{"both bricks fine", NULL, NULL, NULL},
      {"each brick its own nodes", NULL, NULL, NULL},
      {"the face's nodes baked from the coarser brick", NULL, NULL, NULL}},
     0.4,
     1e-5,
     "largest step over the common face, of a range of 1",
     iso_atlas_cut_bricks},
};
const size_t iso_atlas_case_count = sizeof iso_atlas_cases / sizeof *iso_atlas_cases;

const char *const iso_atlas_names[ISO_ATLAS_WAYS] = {"right", "failure", "fallback"};

const iso_atlas_case *iso_atlas_find(const char *id)
{
    for (size_t i = 0; i < iso_atlas_case_count; ++i)
        if (strcmp(iso_atlas_cases[i].id, id) == 0)
            return &iso_atlas_cases[i];
    return NULL;
}

static iso_status measure(const iso_image *right, const iso_image *image, double *rmse, iso_error *err)
{
    iso_metrics m;
    iso_status status = iso_metrics_measure(right, image, &m, err);
    *rmse = status == ISO_OK ? m.rmse : NAN;
    return status;
}

iso_status iso_atlas_run(const iso_atlas_case *c, iso_atlas_result *out, iso_error *err)
{
    iso_volume v = {0};
    *out = (iso_atlas_result){{0, NAN, NAN}, {{0}}};
    iso_status status = c->scene.field ? iso_atlas_volume(&c->scene, &v, err) : ISO_OK;
    for (int w = 0; w < ISO_ATLAS_WAYS && status == ISO_OK; ++w) {
        status = iso_atlas_show(c, (iso_atlas_which)w, &v, &out->images[w], &out->values[w], err);
        if (status == ISO_OK && !c->draw)
            status = measure(&out->images[ISO_ATLAS_RIGHT], &out->images[w], &out->values[w], err);
    }
    iso_volume_destroy(&v);
    if (status == ISO_OK)
        return ISO_OK;
    iso_atlas_clear(out);
    return iso_fail_in(err, status, "%s", c->id);
}

void iso_atlas_clear(iso_atlas_result *out)
{
    for (int w = 0; w < ISO_ATLAS_WAYS; ++w)
        iso_image_destroy(&out->images[w]);
    *out = (iso_atlas_result){0};
}

/* SPDX-License-Identifier: MIT */
/* bake_error.h - what a picture loses where colors are interpolated instead of values.
 *
 * Two pictures of the reference renderer in double precision, both with samples an eighth of a voxel apart at the same
 * places: the exact one of the scene, and one of the baked grid as programs interpolate it, trilinearly and 0 outside. Their
 * difference is the baking alone; tests/test_bake.c compares it with that of pictures without a step. They are
 * compared lit as the scene is (both by the level's directions, which a baked grid does not have), and unlit, every color
 * as the transfer function has it: what a program shows that takes the colors for light. */
#ifndef ISO_BAKE_ERROR_H
#define ISO_BAKE_ERROR_H

#include "bake/bake.h"

/* Of pictures along their longer side, where the user does not say. */
enum { ISO_BAKE_ERROR_PIXELS = 128 };

typedef struct iso_bake_difference {
    double rmse, max_abs; /* over color and alpha, as compare has them */
} iso_bake_difference;

typedef struct iso_bake_error {
    size_t width, height;
    bool has_emission;
    iso_bake_difference lit, unlit; /* of extinction and color, each interpolated */
    iso_bake_difference emission;   /* unlit, of extinction and their product */
} iso_bake_error;

/* pixels: of the pictures' longer side; 0: the view's own size. */
iso_status iso_bake_measure(const iso_baked *b, bool emission, size_t pixels, iso_bake_error *out,
                            const iso_progress *progress, iso_error *err);

/* Of a level that is baked with shaded colors, which are taken for light: out->lit alone. */
iso_status iso_bake_measure_shaded(const iso_baked *b, size_t pixels, iso_bake_error *out, const iso_progress *progress,
                                   iso_error *err);

/* Of these pictures the baked one alone; view: its size, camera and shading. voxels: the step in the level's, 0: converged. */
iso_status iso_baked_render(const iso_baked *b, iso_baked_pair pair, const iso_view *view, double voxels,
                            iso_image *image, const iso_progress *progress, iso_error *err);

#endif

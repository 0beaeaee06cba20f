/* SPDX-License-Identifier: MIT */
/* bake_error.h - measures the error of interpolating colors instead of values, in the picture.
 *
 * Compares two pictures of the reference renderer in double precision, both with samples an eighth of a voxel apart at
 * the same positions: the exact one of the scene, and one of the baked grid as renderers interpolate it, trilinearly
 * and 0 outside. The difference is due to baking only; tests/test_bake.c compares it with that of pictures without a
 * step. Lit pictures use the scene's lights (both by the level's directions, which a baked grid lacks). Unlit ones use
 * the colors of the transfer function: the picture of a renderer that shows colors as light. */
#pragma once

#include "bake/bake.h"

/* Default longer side of the pictures, in pixels. */
enum { ISO_BAKE_ERROR_PIXELS = 128 };

typedef struct iso_bake_difference {
    double rmse, max_abs; /* over color and alpha, as in `compare` */
} iso_bake_difference;

typedef struct iso_bake_error {
    size_t width, height;
    bool has_emission;
    iso_bake_difference lit, unlit; /* extinction and color interpolated separately */
    iso_bake_difference emission;   /* unlit, extinction and their product interpolated */
} iso_bake_error;

/* Measures the error. pixels: longer side of the pictures; 0: the view's own size. */
iso_status iso_bake_measure(const iso_baked *b, bool emission, size_t pixels, iso_bake_error *out,
                            const iso_progress *progress, iso_error *err);

/* Measures the error of a level baked with shaded colors, which are shown as light: sets only out->lit. */
iso_status iso_bake_measure_shaded(const iso_baked *b, size_t pixels, iso_bake_error *out, const iso_progress *progress,
                                   iso_error *err);

/* Renders only the baked picture. view: size, camera and shading; voxels: step in voxels of the level, 0: converged. */
iso_status iso_baked_render(const iso_baked *b, iso_baked_pair pair, const iso_view *view, double voxels,
                            iso_image *image, const iso_progress *progress, iso_error *err);

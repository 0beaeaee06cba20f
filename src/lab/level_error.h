/* SPDX-License-Identifier: MIT */
/* level_error.h - distance of a coarse level's image from level 0's, at full size and minified.
 *
 * Errors are over visible pixels: those in which either image has an alpha of at least 1/255 (ISO_SSIM_FOREGROUND), so
 * that an empty background does not reduce them. Minified: both images are averaged over boxes of n x n pixels, so that
 * a pixel is about as wide as a voxel of the level, the size that levels are made for. */
#pragma once

#include "image/image.h"

typedef struct iso_level_error {
    double dssim; /* (1 - SSIM) / 2 */
    double rmse;  /* of linear colors */
    double flip;  /* mean of LDR FLIP */
} iso_level_error;

/* Measures the errors. ISO_E_RANGE: empty images or different sizes. ISO_E_MEMORY. */
iso_status iso_level_error_measure(const iso_image *finest, const iso_image *shown, iso_level_error *e, iso_error *err);

/* Averages n x n pixels into *out; boxes cut by the border average the remaining pixels. */
iso_status iso_image_minify(const iso_image *image, size_t n, iso_image *out, iso_error *err);

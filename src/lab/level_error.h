/* SPDX-License-Identifier: MIT */
/* level_error.h - how far the image of a coarse level is from that of level 0, at full size and minified.
 *
 * Errors are taken over what either image shows: pixels in which one of them has an alpha of at least 1/255
 * (ISO_SSIM_FOREGROUND), so that an empty background does not thin them.
 * Minified: both images are averaged over boxes of n x n pixels, so that a pixel is about as wide as a voxel of the
 * level. Levels are made for that size. */
#ifndef ISO_LAB_LEVEL_ERROR_H
#define ISO_LAB_LEVEL_ERROR_H

#include "image/image.h"

typedef struct iso_level_error {
    double dssim; /* (1 - SSIM) / 2 */
    double rmse;  /* of linear colors */
    double flip;  /* mean of LDR FLIP */
} iso_level_error;

/* ISO_E_RANGE: empty or different sizes; ISO_E_MEMORY. */
iso_status iso_level_error_measure(const iso_image *finest, const iso_image *shown, iso_level_error *e, iso_error *err);

/* *out: means of n x n pixels; columns and rows that are left over count in boxes that the border cuts. */
iso_status iso_image_minify(const iso_image *image, size_t n, iso_image *out, iso_error *err);

#endif

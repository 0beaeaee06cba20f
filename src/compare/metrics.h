/* SPDX-License-Identifier: MIT */
/* metrics.h - differences between two images.
 *
 * On RGB in linear light and alpha, over all pixels. FLIP and SSIM are taken on the
 * displayed image: sRGB of the colors clipped to [0, 1].
 *   SSIM  [wang-2004]: luma, Gaussian window 11x11, sigma 1.5, K = .01, .03.
 *   FLIP  [andersson-2020] (LDR), at 67 pixels per degree.
 * A comparison with a non-finite pixel, of different sizes or of pictures that begin elsewhere, fails. */
#pragma once

#include "base/json.h"
#include "image/image.h"

/* iso_metrics and iso_metrics_measure() stand in the library's header. */

/* The largest values that are allowed; a value of 0 or less is not checked. */
typedef struct iso_tolerances {
    double rmse, max_abs, p99_abs, ssim_dissimilarity, flip_mean;
} iso_tolerances;

/* Measures as iso_metrics_measure(), without SSIM and FLIP, which are NaN: they take most of its time. */
iso_status iso_metrics_measure_differences(const iso_image *a, const iso_image *b, iso_metrics *metrics, iso_error *err);

/* Returns the RMSE of red, green and blue alone. Values of a above `most`, the most that b can hold, count as
 * `most`; it may be INFINITY. The images have the same size. */
double iso_metrics_rmse_of_colors(const iso_image *a, const iso_image *b, double most);

/* True if m is within the tolerances. NaN never is; without any tolerance only equal images are. */
bool iso_metrics_within(const iso_metrics *m, const iso_tolerances *tolerances);

/* Returns an object of rmse, max_abs, p99_abs, psnr_db, ssim, flip_mean, nonfinite_count. */
json_t *iso_metrics_to_json(const iso_metrics *m);

/* Creates an image of |a - b| of the colors, scaled. scale 0: the largest difference becomes 1. */
iso_status iso_image_difference(const iso_image *a, const iso_image *b, double scale, iso_image *out, iso_error *err);

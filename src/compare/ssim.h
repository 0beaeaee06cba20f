/* SPDX-License-Identifier: MIT */
/* ssim.h - structural similarity.
 *
 * [wang-2004] Eq. 13 with a Gaussian window of 11x11, sigma 1.5, K1 = .01, K2 = .03, L = 1, on one channel.
 * Windows lie wholly inside the image, as in the authors' program; an image with
 * fewer than 11 rows or columns takes windows cut at its border instead. */
#pragma once

#include "image/image.h"

/* Computes the mean over all windows, of Rec. 601 luma of sRGB-encoded colors clipped to [0, 1]. ISO_E_RANGE: empty or
 * different sizes; ISO_E_MEMORY. */
iso_status iso_ssim_mean(const iso_image *a, const iso_image *b, double *mean, iso_error *err);

/* Measures only windows whose center has an alpha of at least ISO_SSIM_FOREGROUND in either image. So a large empty
 * background, equal in all images, does not thin the difference. 1 if both images are empty. */
#define ISO_SSIM_FOREGROUND (1 / 255.0)
iso_status iso_ssim_foreground(const iso_image *a, const iso_image *b, double *mean, iso_error *err);

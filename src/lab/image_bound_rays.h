/* SPDX-License-Identifier: MIT */
/* image_bound_rays.h - how much of the bound of a level's image is signs (render/image_bound.h). */
#pragma once

#include "render/image_bound.h"

/* Computes the integral of the bound along the rays themselves, of absolute values as in the bound, but of the actual T and L.
 * It lies between the RMSE and the bound. Its excess over the RMSE is due to cancellation; the excess of the bound over
 * it is due to regions that stand for their rays. It costs as much as the images. */
iso_status iso_image_bound_without_signs(const iso_image_bound_input *in, double *rmse, iso_error *err);

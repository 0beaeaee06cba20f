/* SPDX-License-Identifier: MIT */
/* rounding.h - bound of the difference between pictures of the same samples if textures are read in single precision.
 *
 * Let s be the extinction, g the color times the shade, L the radiance that arrives from beyond a point, and T the
 * transmittance in front of it. A change of s and g changes a color by (render/image_bound.h)
 *
 *     dC = integral of T [ ds (g - L) + s dg ] dt,      |dC| <= integral of T ( |ds| G + s |dg| ) dt,   G >= g, L
 *
 * and the opacity by at most the integral of T |ds| dt. Single precision moves a sample by 2^-24 of the volume along
 * each axis, and its value by 4 x 2^-24 of the largest one. ds and dg are the differences of the scene's own lookups
 * there: the slope of the transfer function times that of the values, with tables' bends, 2D tables, extinction scales
 * and directions. Rays that are set up in single precision, too, move a sample further, by 4 x 2^-24 of its distance
 * from the eye: nine roundings make a position, which partly cancel (2.8 is the most in 192 x 192 rays). The integral is that of an emitter, by the reference's midpoints. There
 * (1 - exp(-s dt)) / s >= dt exp(-s dt), so the sum bounds the change of the midpoints' sum to first order.
 *
 * It excludes the rounding of gradients on the fly that are nearly zero. */
#pragma once

#include "renderers/renderers.h"

/* Bounds the RMSE and the largest difference of the view's midpoints; float_rays: rays are in single precision, too.
 * Zeros for a view with a region of interest. */
iso_status iso_rounding_bound(const iso_level *level, iso_code code, const iso_view *view, iso_direction_source source,
                              bool float_rays, int threads, iso_sample_error *most, iso_error *err);

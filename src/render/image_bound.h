/* SPDX-License-Identifier: MIT */
/* image_bound.h - upper bound of the difference between a coarse level's image and level 0's, without drawing either.
 *
 * Bounds the RMSE over all pixels and the four channels (compare/metrics.h), for a scene, a level and its transfer
 * function. Derivation, assumptions and each inequality: doc/method/level-bound.md. In short, with s the extinction, g
 * the color times the shade, L the radiance that arrives from beyond and T the transmittance in front:
 *
 *     C_k - C_0 = integral of T_k [ s_k (g_k - L_0) - s_0 (g_0 - L_0) ] dt      exact
 *     |C_k - C_0| <= I = integral of sup T_k * sup over L of | ... | dt,  and <= M, the largest possible difference
 *     mean square over a block of pixels <= M min(M, mean of I)
 *
 * No ray is followed. The image is cut into blocks of pixels, the depth into slabs; the volume is sampled at points
 * spread evenly over its voxels, each of which falls into one region (block and slab). Regions keep the ranges of s and
 * g, from which the ranges of L and T follow slab by slab, and a second pass over the points sums the integrand. */
#pragma once

#include "scene/field.h"
#include "scene/scene.h"

typedef struct iso_image_bound_input {
    const iso_level *fine, *coarse; /* level 0 and the level */
    size_t level;
    iso_code code;
    iso_direction_source source;
    const iso_view *view;          /* its TF is level 0's */
    const iso_tf_table *coarse_tf; /* the level's */
    int points; /* along each axis of a voxel, 1 to 8; 0: 2, or 1 in volumes of more than 2^21 voxels. A region has four: more
                   of them make the bound closer, and take longer by their cube */
    int threads;
    double deadline; /* by iso_clock_seconds(): later, the bound is INFINITY; 0: none */
} iso_image_bound_input;

/* True if the view has a bound: no clip planes, 2D transfer function, extinction scale or region of interest. */
bool iso_image_bound_is_for(const iso_view *view);
/* Returns the number of sampled points per voxel in a volume of `voxels` voxels; the time is proportional to it. */
size_t iso_image_bound_points(double voxels);
/* Bounds the RMSE. ISO_E_RANGE: a view without a bound (see above). ISO_E_MEMORY. */
iso_status iso_image_bound_rmse(const iso_image_bound_input *in, double *rmse, iso_error *err);

/* SPDX-License-Identifier: MIT */
/* cell_ray.h - the rendering equation along one ray, cell by cell, with a bound of its error; private to the reference.
 *
 * Between the centers of eight voxels the scalar along a ray is a cubic of the way, and so is each component of the
 * shading vector. A transfer function's table is linear between its entries. So a ray is cut
 *   at the places where it enters a cell,
 *   where its scalar passes an entry at which the table bends,
 *   where |n.l| or |n.h| has its kink,
 * and each piece is a smooth function of the way u:
 *   extinction     sigma_i + slope (X(u) - i), a cubic; its integral, the optical depth, is a quartic in closed form
 *   emission       sigma c shade exp(-depth), by Gauss and Legendre's rule of 3, 5 or 8 points
 *
 * The error of the rule is bounded before any point is looked up. A function f that is analytic in the ellipse of foci
 * -1 and 1 and semi-axes' sum rho has Chebyshev coefficients |a_k| <= 2 M rho^-k, M the largest |f| on it
 * [trefethen-2013]; the rule of n points is exact for k < 2n and for odd k, and off by at most 2 + 2 / (k^2 - 1) for
 * others, which sums up to
 *
 *     |error| <= 64/15 M rho^-2n / (1 - rho^-2)        on an interval of length 2
 *
 * M is found from the polynomials' coefficients (each |z^k| is at most R^k in a disc of radius R that holds the
 * ellipse), for eight radii, and the least bound counts. Where no rule's bound is below what the piece may have, the
 * piece is halved. So the sum over pieces is a bound of the pixel's error, proved but for rounding (about 1e-14).
 *
 * Eight pieces are evaluated at a time, for the instruction set that the machine has; all give the same bits: own
 * exponential, whole powers by squaring, no fused products. */
#pragma once

#include "render/empty_space.h"
#include "render/reference_ray.h"

/* A ray ends if the rest of it can add at most this to a color or to the opacity: reports print nine digits, and images
 * hold floats. It is part of the bound. */
#define ISO_REFERENCE_LEFT 1e-12

typedef struct iso_cell_scene {
    const iso_sampler *sampler;
    const iso_view *view;
    const iso_tf_table *tf;
    const iso_shown *shown;
    const iso_empty_space *empty;
    size_t *bends; /* owned; bends[i]: number of the entries below i at which the visible part of the table bends */
    bool lit;
    int power;        /* of the highlights, or -1 if it is fractional */
    int whole_power;  /* the largest that is not above it */
    double eps_2;     /* of n = d / sqrt(|d|^2 + eps^2) */
    double brightest; /* color times shade, at most */
} iso_cell_scene;

/* True if this method supports the view and the sampler; reference_ray.c integrates all others. */
bool iso_cell_scene_is_for(const iso_sampler *s, const iso_view *view);
iso_status iso_cell_scene_create(iso_cell_scene *c, const iso_sampler *s, const iso_view *view, const iso_shown *shown,
                                 const iso_empty_space *empty, iso_error *err);
void iso_cell_scene_destroy(iso_cell_scene *c);

/* A ray from t0 to t1. error: bound of the error of color and opacity. */
typedef struct iso_cell_ray {
    iso_vec3 origin, direction, to_viewer; /* as ray_state's */
    double t0, t1, tolerance;
} iso_cell_ray;
stretch iso_cell_ray_integrate(const iso_cell_scene *c, const iso_cell_ray *ray, double *error);

/* The same for one instruction set, for tests; NULL beyond the last. Those that the machine lacks must not be
 * called. */
typedef stretch (*iso_cell_ray_function)(const iso_cell_scene *c, const iso_cell_ray *ray, double *error);
typedef struct iso_cell_ray_variant {
    const char *name;
    bool there;
    iso_cell_ray_function integrate;
} iso_cell_ray_variant;
size_t iso_cell_ray_variants(iso_cell_ray_variant v[4]);

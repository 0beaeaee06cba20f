/* SPDX-License-Identifier: MIT */
/* reference_ray.h - the integral along one ray of the reference (reference.h), by each quadrature. */
#pragma once

#include "render/empty_space.h"
#include "render/reference.h"
#include "render/sampler.h"
#include "tf/integral.h"

/* A field and the transfer function that it is seen through. */
typedef struct layer {
    const iso_sampler *sampler;
    const iso_tf_table *tf;
    const iso_tf_2d *tf_2d;          /* in place of tf, or NULL */
    const uint8_t *extinction_scale; /* of the sampler's level (fit/extinction_scale.h), or NULL */
    const size_t *bends;             /* bends[i]: how many of the TF's entries below i are bends */
    double scale, offset[3];         /* its index = scale * index of the level that is rendered - offset */
} layer;

/* A ray in the level's index space, with what its samples need. */
typedef struct ray_state {
    const layer *layer, *roi; /* roi: the region of interest's, or NULL */
    const iso_view *view;
    const iso_emitter *emitter;      /* or NULL */
    const iso_tf_integral *integral; /* preintegrated */
    const iso_empty_space *empty;    /* of the level that is rendered */
    bool plain;                      /* of the options */
    iso_vec3 origin, direction;      /* index per mm of t */
    iso_vec3 to_viewer;              /* world, unit */
    iso_vec3 half[ISO_MAX_LIGHTS];   /* between the lights and the viewer; set by the integral */
} ray_state;

/* Emission of a stretch of the ray towards its own start, and its optical depth. */
typedef struct stretch {
    double color[3], depth;
} stretch;

/* Computes shade(d) of scene/scene.h: n, |n| <= 1, and to_viewer in world axes. */
double iso_shade(const iso_view *view, iso_vec3 n, iso_vec3 to_viewer);

/* Integrates from t0 to t1 by opt's quadrature. *error: the sum of the changes by halving, if that is the converged
 * one. */
stretch iso_reference_integrate(ray_state *ray, const iso_reference_options *opt, double t0, double t1, double *error);

/* SPDX-License-Identifier: MIT */
/* gradient.h - gradients of the scalar field, in value per mm, in world axes.
 *
 * In:  iso_volume.   Out: 3 floats a voxel (gx, gy, gz), x fastest.
 * Paper: gradients-2017 sec. 2; Bentum et al. 1996.
 * At a border the missing neighbour is left out and the difference one-sided,
 * so that fields linear in x, y, z are exact everywhere; an axis of one voxel
 * has no gradient along it. Index gradients go to the world by the inverse
 * transpose of index_to_world. */
#ifndef ISO_GRADIENT_H
#define ISO_GRADIENT_H

#include "volume/volume.h"

/* enum, name, what it is. Errors of each: `isoshade bench gradient`. */
#define ISO_GRADIENT_LIST(X)                                                                                  \
    X(ISO_GRADIENT_CENTRAL, "central", "central differences, 6 samples")                                      \
    X(ISO_GRADIENT_INTERMEDIATE, "intermediate", "differences to the next sample, 3 samples; half a voxel off") \
    X(ISO_GRADIENT_SOBEL, "sobel", "3x3x3: central along, 1 2 1 across, 26 samples")                          \
    X(ISO_GRADIENT_CORNERS, "corners", "Sobel from the 8 corners of the voxel (Sigg and Hadwiger)")           \
    X(ISO_GRADIENT_FOURTH, "fourth", "Taylor-designed, of fourth order, 12 samples")                                  \
    X(ISO_GRADIENT_BSPLINE, "bspline", "of the interpolating cubic B-spline (recursive pre-filter), 72 samples")

typedef enum iso_gradient_method {
#define ISO_GRADIENT_ENUM(name, text, help) name,
    ISO_GRADIENT_LIST(ISO_GRADIENT_ENUM)
#undef ISO_GRADIENT_ENUM
    ISO_GRADIENT_COUNT
} iso_gradient_method;

typedef struct iso_gradient_options {
    iso_gradient_method method;
    int threads; /* 0 = all cores */
} iso_gradient_options;
iso_gradient_options iso_gradient_defaults(void);

const char *iso_gradient_name(iso_gradient_method method);
iso_status iso_gradient_from_name(const char *name, iso_gradient_method *method, iso_error *err);

/* The slab of planes [z0, z1) of the gradient; out holds 3 nx ny (z1 - z0) floats. */
iso_status iso_gradient_slab(const iso_volume *v, const iso_gradient_options *opt, size_t z0, size_t z1,
                             float *restrict out, iso_error *err);

/* The whole volume: 3 * iso_geometry_voxel_count() floats. */
iso_status iso_gradient_compute(const iso_volume *v, const iso_gradient_options *opt, float *restrict out,
                                iso_error *err);

#endif

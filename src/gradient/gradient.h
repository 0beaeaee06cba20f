/* SPDX-License-Identifier: MIT */
/* gradient.h - gradients of the scalar field, in value per mm, in world axes.
 *
 * In:  iso_volume.   Out: 3 floats per voxel (gx, gy, gz), x fastest.
 * Paper: [diaz-garcia-2017] sec. 2; [bentum-1996].
 * At a border the missing neighbor is left out and the difference one-sided,
 * so that fields linear in x, y, z are exact everywhere; an axis of one voxel
 * has no gradient along it. Index gradients go to the world by the inverse
 * transpose of index_to_world. */
#pragma once

#include "base/names.h"
#include "volume/volume.h"

/* The one list of estimators: ISO_GRADIENT_CENTRAL is the number of iso_gradient_central, the row in its kernel's
 * file. Errors of each: `isoshade-lab gradient`. */
/* clang-format off */
#define ISO_GRADIENT_LIST(X)      \
    X(CENTRAL, central)           \
    X(INTERMEDIATE, intermediate) \
    X(SOBEL, sobel)               \
    X(CORNERS, corners)           \
    X(FOURTH, fourth)             \
    X(SMOOTH, smooth)             \
    X(BSPLINE, bspline)
/* clang-format on */

typedef enum iso_gradient_method {
#define ISO_GRADIENT_ENUM(method, row) ISO_GRADIENT_##method,
    ISO_GRADIENT_LIST(ISO_GRADIENT_ENUM)
#undef ISO_GRADIENT_ENUM
        ISO_GRADIENT_COUNT
} iso_gradient_method;

struct iso_planes; /* gradient_kernel.h */
struct iso_gradient_matrix;

typedef struct iso_gradient_info {
    const char *name;
    const char *summary;
    int samples;  /* per gradient */
    int order;    /* polynomials of this degree along an axis have exact derivatives inside the volume */
    size_t reach; /* planes before and after a plane that its gradients read */
    /* Computes gradients of row (y, z), times the matrix, to the planar rows g, as iso_gradient_row() does. */
    void (*row)(const struct iso_planes *p, iso_gradient_method method, const struct iso_gradient_matrix *matrix,
                size_t y, size_t z, float *scratch, float *const g[3]);
} iso_gradient_info;

extern const iso_names iso_gradient_names;
const iso_gradient_info *iso_gradient_describe(iso_gradient_method method);

typedef struct iso_gradient_options {
    iso_gradient_method method;
    int threads; /* 0 = all cores */
} iso_gradient_options;
iso_gradient_options iso_gradient_defaults(void);

const char *iso_gradient_name(iso_gradient_method method);
iso_status iso_gradient_from_name(const char *name, iso_gradient_method *method, iso_error *err);

/* Computes the gradients of planes [z0, z1); out holds 3 nx ny (z1 - z0) floats. */
iso_status iso_gradient_slab(const iso_volume *v, const iso_gradient_options *opt, size_t z0, size_t z1,
                             float *restrict out, iso_error *err);

/* Computes the gradients of the whole volume: 3 * iso_geometry_voxel_count() floats. */
iso_status iso_gradient_compute(const iso_volume *v, const iso_gradient_options *opt, float *restrict out,
                                iso_error *err);

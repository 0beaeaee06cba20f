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

typedef enum iso_gradient_method { ISO_GRADIENT_CENTRAL, ISO_GRADIENT_COUNT } iso_gradient_method;

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

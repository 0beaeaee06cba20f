/* SPDX-License-Identifier: MIT */
/* shading_method.h - methods for a level's directions, and test fields; shared by the shading benchmarks. */
#pragma once

#include "pyramid/pyramid.h"
#include "scene/field.h"
#include "volume/synthetic.h"

typedef struct iso_shading_method {
    const char *name;
    iso_direction_filter filter;
    iso_direction_source source; /* the renderer's source of directions */
    size_t radius, exponent;     /* of Eq. 1; 0: the pyramid's defaults (sigma, too) */
    double sigma;
    bool plain;   /* Eq. 1 with exponent 0: the Gaussian alone */
    bool unit;    /* stored with unit length, without coherence */
    bool adapted; /* rendered with the level's own transfer function */
} iso_shading_method;

iso_status iso_shading_build(const iso_shading_method *m, const iso_volume *v, const char *name, size_t level_count,
                             int threads, iso_pyramid *p, iso_error *err);

/* Samples a field in a cube of n^3 floats, values 0 to 1, with normal noise of the given standard deviation. */
iso_status iso_shading_sample(iso_field_kind kind, size_t n, double noise, iso_field *field, iso_volume *v,
                              iso_error *err);

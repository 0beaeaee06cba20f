/* SPDX-License-Identifier: MIT */
/* image_bound_points.h - what both levels show at a point; private to the bound (image_bound.h). */
#pragma once

#include "render/image_bound.h"
#include "render/sampler.h"

enum { ISO_BOUND_CHANNELS = 4, ISO_BOUND_FINE = 0, ISO_BOUND_COARSE = 1 };

typedef struct iso_bound_field {
    const iso_image_bound_input *in;
    iso_sampler sampler[2];
    bool lit;
} iso_bound_field;

/* Creates the field; destroy it after a failure, too. */
iso_status iso_bound_field_create(iso_bound_field *field, const iso_image_bound_input *in, iso_error *err);
void iso_bound_field_destroy(iso_bound_field *field);

/* Classified and lit values by level: extinction, and color times shade; that of opacity is 1. */
typedef struct iso_bound_values {
    double sigma[2], g[2][ISO_BOUND_CHANNELS];
} iso_bound_values;
/* Samples both levels at a point. index: coordinates of level 0. */
void iso_bound_look_up(const iso_bound_field *field, iso_vec3 index, iso_vec3 to_viewer, iso_bound_values *values);

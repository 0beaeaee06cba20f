/* SPDX-License-Identifier: MIT */
/* code_error.h - error of a direction code, at voxels and between them.
 *
 * A probe models a filter along one axis: directions a and b at two neighboring
 * voxels are encoded, their lattice vectors are mixed with weights 1 - t and t, and
 * the result is decoded. The reference is the same mix of a and b themselves. At a
 * voxel t = 0. Means are over random directions (and t uniform in [0, 1]). The maximum
 * is found by a climb from the worst of these: some probe attains it, so it is a lower
 * bound of the true maximum. */
#pragma once

#include "base/linalg.h"
#include "encode/code.h"
#include "lab/codes/paper_table.h"

/* An encoder to measure: the code's own, another one for it, or the paper's table. */
typedef struct iso_scheme {
    const char *name;
    iso_code code;
    void (*encode)(const float *restrict directions, uint8_t *restrict bytes, size_t count); /* NULL: the code's */
    const iso_paper_table *table;                                                            /* or NULL */
} iso_scheme;

void iso_scheme_encode(const iso_scheme *scheme, const float *restrict directions, uint8_t *restrict bytes,
                       size_t count);

typedef struct iso_code_error {
    double mean_deg, max_deg;
} iso_code_error;

typedef struct iso_code_error_options {
    size_t count;      /* probes for the mean */
    double apart_deg;  /* angle between a and b; 0: at voxels */
    double min_length; /* lengths of a and b are uniform in [min_length, 1]; 1: unit vectors */
    bool climb;        /* True to climb; false: the maximum of the random probes */
    uint64_t seed;
} iso_code_error_options;
iso_code_error_options iso_code_error_defaults(void);

/* Measures mean and maximum. ISO_E_MEMORY; ISO_E_RANGE: options outside their limits. */
iso_status iso_code_error_measure(const iso_scheme *scheme, const iso_code_error_options *opt, iso_code_error *error,
                                  iso_error *err);

/* Returns the angle between two vectors, accurate for small ones; 0 if one is zero. */
double iso_angle_deg(iso_vec3 a, iso_vec3 b);

/* Returns a vector uniform on the sphere, by iso_xorshift_unit(). */
iso_vec3 iso_random_unit_vector(uint64_t *state);

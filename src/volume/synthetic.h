/* SPDX-License-Identifier: MIT */
/* synthetic.h - volumes whose values and gradients are known in closed form.
 *
 * A field is a function of the normalized position p = (world - box center) /
 * (half the shortest box edge), evaluated in double precision; p is in [-1, 1]
 * along the shortest edge. Samples are the field at the voxel centers. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "base/names.h"
#include "volume/volume.h"

/* enum, name, description */
/* clang-format off */
#define ISO_FIELD_LIST(X)                                                                     \
    X(ISO_FIELD_RAMP, "ramp", "linear in x, y and z")                                         \
    X(ISO_FIELD_SLAB, "slab", "1 inside |z| < 1/2, linear flanks one voxel wide")             \
    X(ISO_FIELD_SPHERE, "sphere", "1 - |p|: distance to the center, spherical iso-surfaces")  \
    X(ISO_FIELD_SHELLS, "shells", "two thin concentric Gaussian shells")                      \
    X(ISO_FIELD_PLATE, "plate", "a thin tilted Gaussian plate: opposite gradients close by")  \
    X(ISO_FIELD_MARSCHNER_LOBB, "marschner-lobb", "the test signal of Marschner and Lobb [marschner-1994]") \
    X(ISO_FIELD_NOISE, "noise", "smooth band-limited noise: a sum of random plane waves")     \
    X(ISO_FIELD_TUBES, "tubes", "five straight Gaussian tubes of several widths")              \
    X(ISO_FIELD_VESSELS, "vessels", "a branching tree of vessels, ever thinner")               \
    X(ISO_FIELD_BALLS, "balls", "two balls that nearly touch: surfaces that face each other")  \
    X(ISO_FIELD_CONSTANT, "constant", "1/2 everywhere: no gradient at all")
/* clang-format on */

typedef enum iso_field_kind {
#define ISO_FIELD_ENUM(name, text, help) name,
    ISO_FIELD_LIST(ISO_FIELD_ENUM)
#undef ISO_FIELD_ENUM
        ISO_FIELD_COUNT
} iso_field_kind;

typedef struct iso_field {
    iso_field_kind kind;
    iso_geometry geometry; /* where p is normalized */
    uint64_t seed;         /* of noise, vessels and grain */
    bool has_range;        /* samples run over `range` instead of the type's own */
    double range[2];       /* the range of the values 0 to 1 in the volume; within the type */
    double grain;          /* the samples alone: standard deviation of nearly normal noise, of the values 0 to 1 */
} iso_field;

const char *iso_field_name(iso_field_kind kind);
extern const iso_names iso_field_names;
iso_status iso_field_from_name(const char *name, iso_field_kind *kind, iso_error *err);

/* Returns the value in [0, 1], and its gradient per mm in world axes (gradient may be NULL). */
double iso_field_value(const iso_field *f, iso_vec3 world_mm, iso_vec3 *gradient);

/* Samples the field at f->geometry's voxel centers: lo + value * (hi - lo), rounded for integer types. [lo, hi] is
 * f->range, or the whole range of an integer type, or [0, 1]. */
iso_status iso_field_sample(const iso_field *f, iso_type type, iso_volume *v, iso_error *err);

/* Returns the type's range; [0, 1] for float and double. */
void iso_field_type_range(iso_type type, double *lo, double *hi);

/* Samples only the planes [z0, z1), for volumes larger than memory; the geometry has been checked. ISO_E_MEMORY. */
iso_status iso_field_sample_planes(const iso_field *f, iso_type type, size_t z0, size_t z1, int threads, void *out,
                                   iso_error *err);

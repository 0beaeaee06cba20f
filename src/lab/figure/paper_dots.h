/* SPDX-License-Identifier: MIT */
/* paper_dots.h - the directions of a code with fewer bits per component.
 *
 * Lattice points are those of a texture of `bits` bits per component: signed c / (2^(bits - 1) - 1), with the lowest
 * code twice; unsigned 2 c / (2^bits - 1) - 1. Every code decodes multiples of a vector to the same direction. The
 * number of directions is therefore exactly the number of integer vectors without a common factor:
 *     signed    sum over d of mu(d) ((2 floor(m / d) + 1)^3 - 1), m = 2^(bits - 1) - 1
 *     unsigned  sum over odd d of mu(d) (2 floor((floor(m / d) + 1) / 2))^3, m = 2^bits - 1, of odd numbers only */
#pragma once

#include "base/linalg.h"
#include "encode/code.h"

enum { ISO_DOTS_FEWEST_BITS = 3, ISO_DOTS_MOST_BITS = 6 };

typedef struct iso_dots {
    iso_code code;
    int bits;
    size_t count, places; /* directions, each once; lattice points without the middle */
    iso_vec3 *lattice;    /* owned; the shortest lattice vector of each direction */
    iso_vec3 *unit;       /* owned; the decoded direction */
} iso_dots;

/* Lists the directions. ISO_E_RANGE: bits out of limits, or a code without a 3D lattice. ISO_E_MEMORY. */
iso_status iso_dots_create(iso_code code, int bits, iso_dots *dots, iso_error *err);
void iso_dots_destroy(iso_dots *dots); /* accepts empty and NULL */

/* Counts the directions by the formula above. */
size_t iso_dots_formula(bool is_signed, int bits);

/* Finds the largest hole: the diameter in degrees of the largest cap without a direction, as in Table 1 of the
 * gradients paper. It is twice the radius of encode/hole.h. */
iso_status iso_dots_hole_deg(const iso_dots *dots, double *across_deg, iso_error *err);

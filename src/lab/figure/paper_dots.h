/* SPDX-License-Identifier: MIT */
/* paper_dots.h - the directions that a code with fewer bits a component can decode to.
 *
 * The places of the lattice are those of a texture of `bits` bits a component: signed ones c / (2^(bits - 1) - 1),
 * the lowest code twice; unsigned ones 2 c / (2^bits - 1) - 1. Every code decodes multiples of a vector to one
 * direction, so the
 * directions are counted exactly by the vectors of whole numbers without a common factor:
 *     signed    sum over d of mu(d) ((2 floor(m / d) + 1)^3 - 1), m = 2^(bits - 1) - 1
 *     unsigned  sum over odd d of mu(d) (2 floor((floor(m / d) + 1) / 2))^3, m = 2^bits - 1, of odd numbers alone */
#ifndef ISO_LAB_FIGURE_PAPER_DOTS_H
#define ISO_LAB_FIGURE_PAPER_DOTS_H

#include "base/linalg.h"
#include "encode/code.h"

enum { ISO_DOTS_FEWEST_BITS = 3, ISO_DOTS_MOST_BITS = 6 };

typedef struct iso_dots {
    iso_code code;
    int bits;
    size_t count, places; /* directions, each once; places of the lattice but for its middle */
    iso_vec3 *lattice;    /* owned; the shortest lattice vector of each direction */
    iso_vec3 *unit;       /* owned; what it decodes to */
} iso_dots;

/* ISO_E_RANGE: bits beyond the limits, or a code that is no lattice of three components; ISO_E_MEMORY. */
iso_status iso_dots_create(iso_code code, int bits, iso_dots *dots, iso_error *err);
void iso_dots_destroy(iso_dots *dots); /* accepts empty and NULL */

/* The formula above. */
size_t iso_dots_formula(bool is_signed, int bits);

/* The angle across the biggest hole: the diameter of the largest cap without a direction, as the gradients paper's
 * Table 1 has it; twice the radius of encode/hole.h. */
iso_status iso_dots_hole_deg(const iso_dots *dots, double *across_deg, iso_error *err);

#endif

/* SPDX-License-Identifier: MIT */
/* hole.h - the largest hole of a set of directions: the largest angle from any direction
 * to the nearest one of the set (the radius of the largest empty cap).
 *
 * The set is all directions that a code can represent, with the symmetry of the cube. It
 * is given by its members in the chamber x >= y >= z >= 0; the other 47 chambers are
 * reflections. One chamber is enough: the nearest member to a direction of the chamber
 * lies in the same chamber, since reflecting it across a mirror only moves it away.
 *
 * Exact by branch and bound. The distance to the nearest member changes by at most the
 * distance moved, so a triangle of directions with center q and radius rho has none above
 * distance(q) + rho. Triangles are cut in four until this is below the largest distance
 * found plus the tolerance. The result is attained, and at most the tolerance below the
 * supremum. */
#pragma once

#include <stddef.h>

#include "base/linalg.h"
#include "base/status.h"

typedef struct iso_hole {
    double radius_deg;
    iso_vec3 where; /* unit vector at its center */
} iso_hole;

/* Measures the hole. directions: count vectors with x >= y >= z >= 0, x > 0, of any length.
 * ISO_E_RANGE: one is outside the chamber, or there is none; ISO_E_MEMORY. */
iso_status iso_hole_measure(const iso_vec3 *directions, size_t count, double tolerance_deg, iso_hole *hole,
                            iso_error *err);

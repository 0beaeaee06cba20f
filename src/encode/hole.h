/* SPDX-License-Identifier: MIT */
/* hole.h - the biggest hole of a set of directions: the largest angle that a
 * direction can have to the nearest one of the set (a radius; the largest
 * empty cap has this radius).
 *
 * The set is what one code can decode to, with the symmetry of the cube: it is
 * given by its members in the chamber x >= y >= z >= 0, and the other 47
 * chambers are reflections. The nearest member to a direction of the chamber
 * lies in the same chamber, since a reflection to the other side of a mirror
 * only moves it away; so one chamber is enough.
 *
 * Exact by branch and bound: the distance to the nearest member changes by no
 * more than the way one goes, so a triangle of directions with center q and
 * radius rho holds none above distance(q) + rho. Triangles are cut in four
 * until this is below the largest distance found plus the tolerance. The result
 * lies below the supremum by the tolerance at most, and is attained. */
#ifndef ISO_HOLE_H
#define ISO_HOLE_H

#include <stddef.h>

#include "base/linalg.h"
#include "base/status.h"

typedef struct iso_hole {
    double radius_deg;
    iso_vec3 where; /* unit */
} iso_hole;

/* directions: count vectors, x >= y >= z >= 0, x > 0, of any length.
 * ISO_E_RANGE when one lies outside the chamber or there is none, ISO_E_MEMORY. */
iso_status iso_hole_measure(const iso_vec3 *directions, size_t count, double tolerance_deg, iso_hole *hole,
                            iso_error *err);

#endif

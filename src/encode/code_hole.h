/* SPDX-License-Identifier: MIT */
/* code_hole.h - the biggest hole of each code: how far a direction can be from
 * all those that the code holds (hole.h). */
#ifndef ISO_CODE_HOLE_H
#define ISO_CODE_HOLE_H

#include "encode/code.h"
#include "encode/hole.h"

/* *how says what the figure is:
 *   exact    branch and bound over all directions that the code holds
 *   circles  the biggest circle round the triangles of neighboring codes: a bound (oct24)
 *   bound    closed form, of the rounding (snorm, half)
 * tolerance_deg: of the exact ones. ISO_E_MEMORY. */
iso_status iso_code_hole(iso_code code, double tolerance_deg, iso_hole *hole, const char **how, iso_error *err);

/* Of the 48 regions with another lambda in Eq. 2 of [diaz-garcia-2017]; 0: no treatment. */
iso_status iso_region48_hole(double lambda, double tolerance_deg, iso_hole *hole, iso_error *err);

#endif

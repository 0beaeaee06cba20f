/* SPDX-License-Identifier: MIT */
/* code_hole.h - the largest hole of each code: the largest angle from any direction
 * to the nearest one that the code can represent (hole.h). */
#pragma once

#include "encode/code.h"
#include "lab/codes/hole.h"

/* Measures the largest hole. *how is the method:
 *   exact    branch and bound over all directions of the code
 *   circles  the largest circle around triangles of neighboring codes: a bound (oct24)
 *   bound    closed form for the rounding (snorm, half)
 * tolerance_deg: for "exact". ISO_E_MEMORY. */
iso_status iso_code_hole(iso_code code, double tolerance_deg, iso_hole *hole, const char **how, iso_error *err);

/* Measures the 48 regions with another lambda in Eq. 2 of [diaz-garcia-2017]; 0: without Eq. 2. */
iso_status iso_region48_hole(double lambda, double tolerance_deg, iso_hole *hole, iso_error *err);

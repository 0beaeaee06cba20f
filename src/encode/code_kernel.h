/* SPDX-License-Identifier: MIT */
/* code_kernel.h - the rows of the table of codes, and their shared parts. Private to src/encode. */
#ifndef ISO_CODE_KERNEL_H
#define ISO_CODE_KERNEL_H

#include "encode/code.h"
#include "encode/decode_double.h"

#define ISO_CODE_DECLARE(code, row) extern const iso_code_info iso_code_##row;
ISO_CODE_LIST(ISO_CODE_DECLARE)
#undef ISO_CODE_DECLARE

/* The points of a code in one of the 48 regions: (a, b, c) / limit with a >= b >= c >= first, in steps of `step`, of a
 * length from min_length to max_length. a > limit / 3, since longer multiples of a vector have the same direction. */
typedef struct iso_code_points {
    int limit, first, step;
    double min_length, max_length;
} iso_code_points;

/* Measures the hole among the decoded points by branch and bound: *how is "exact". */
iso_status iso_code_hole_of_points(const iso_code_info *code, const iso_code_points *points, double tolerance_deg,
                                   iso_hole *hole, const char **how, iso_error *err);
/* Does the same for all signed lattice points; for all unsigned ones. */
iso_status iso_code_hole_of_signed(const iso_code_info *code, double tolerance_deg, iso_hole *hole, const char **how,
                                   iso_error *err);
iso_status iso_code_hole_of_unsigned(const iso_code_info *code, double tolerance_deg, iso_hole *hole, const char **how,
                                     iso_error *err);
/* Bounds the hole of a rounding by at most `most` across a vector of length 1: *how is "bound". */
iso_status iso_code_hole_of_rounding(double most, iso_hole *hole, const char **how);

#endif

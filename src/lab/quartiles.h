/* SPDX-License-Identifier: MIT */
/* quartiles.h - summary of a list of ratios: one case of a hundred can move their geometric mean, not their median. */
#pragma once

#include <stddef.h>

typedef struct iso_ratios {
    size_t count;
    double geometric_mean, median, lower, upper; /* lower, upper: the first and the third quartile; NaN of no ratio */
} iso_ratios;

/* Summarizes ratios above 0, which it sorts. Quartiles are interpolated linearly between sorted neighbors; of one
 * ratio all figures are that ratio. */
iso_ratios iso_ratios_summarize(double *ratios, size_t count);

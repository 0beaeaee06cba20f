/* SPDX-License-Identifier: MIT */
/* quartiles.h - what a list of ratios comes to: one case of a hundred can move their geometric mean, not their median. */
#ifndef ISO_QUARTILES_H
#define ISO_QUARTILES_H

#include <stddef.h>

typedef struct iso_ratios {
    size_t count;
    double geometric_mean, median, lower, upper; /* lower, upper: the first and the third quartile; NaN of no ratio */
} iso_ratios;

/* ratios: above 0; they are put in order. Quartiles lie on the line between neighbors in that order, so that of one ratio
 * all figures are that one. */
iso_ratios iso_ratios_summarize(double *ratios, size_t count);

#endif

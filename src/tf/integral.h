/* SPDX-License-Identifier: MIT */
/* integral.h - pre-integrated classification: the mean of a transfer function between two values.
 *
 * Where the scalar goes linearly from one value to another along a segment of a ray, the mean extinction and the mean
 * emission sigma c are integrals of the table over its entries. Sums up to each entry make them exact in a few fetches,
 * however many entries lie between: no shell of a sharp TF falls between two samples.
 *
 *   opacity  1 - exp(-mean sigma length)
 *   color   opacity * (mean of sigma c) / (mean of sigma)
 *
 * [engel-2001] sec. 3.3: the integral functions instead of a table over both ends. Absorption within a segment ignores
 * the order of its colors, which is an error of third order in the length of the segment. */
#ifndef ISO_TF_INTEGRAL_H
#define ISO_TF_INTEGRAL_H

#include "tf/tf.h"

typedef struct iso_tf_integral {
    const iso_tf_table *tf; /* borrowed */
    double *sums;           /* owned; 4 an entry: of sigma r, g, b and of sigma, from entry 0 to this one, in entries */
} iso_tf_integral;

iso_status iso_tf_integral_create(iso_tf_integral *integral, const iso_tf_table *tf, iso_error *err);
void iso_tf_integral_destroy(iso_tf_integral *integral); /* accepts empty */

/* Means over values from a to b, in either order; equal values give the TF itself. Per mm: sigma r, g, b; sigma. */
void iso_tf_integral_mean(const iso_tf_integral *integral, double a, double b, double mean[4]);

#endif

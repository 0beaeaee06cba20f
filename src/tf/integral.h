/* SPDX-License-Identifier: MIT */
/* integral.h - pre-integrated classification: the mean of a transfer function between two values.
 *
 * If the scalar is linear along a segment of a ray, the mean extinction and the mean emission sigma c are integrals of
 * the table over its entries. Prefix sums make them exact in a few fetches, no matter how many entries lie between: no
 * shell of a sharp TF is missed between two samples.
 *
 *   opacity  1 - exp(-mean sigma length)
 *   color   opacity * (mean of sigma c) / (mean of sigma)
 *
 * [engel-2001] sec. 3.3: integral functions instead of a table over both ends. The absorption within a segment ignores
 * the order of its colors, an error of third order in the segment's length. */
#pragma once

#include "tf/tf.h"

typedef struct iso_tf_integral {
    const iso_tf_table *tf; /* borrowed */
    double *sums;           /* owned; 4 per entry: sigma r, g, b and sigma, integrated from entry 0, in entries */
} iso_tf_integral;

iso_status iso_tf_integral_create(iso_tf_integral *integral, const iso_tf_table *tf, iso_error *err);
void iso_tf_integral_destroy(iso_tf_integral *integral); /* accepts empty */

/* Computes the means over values from a to b, in either order: sigma r, g, b; sigma, per mm. a == b gives the TF. */
void iso_tf_integral_mean(const iso_tf_integral *integral, double a, double b, double mean[4]);

/* SPDX-License-Identifier: MIT */
/* curve.h - a voxel's appearance by its value: premultiplied color and opacity, as a table over the values.
 *
 *     p(s) = (a r, a g, a b, a),   a = 1 - exp(-extinction(s) length)
 *
 * linear between its entries, constant beyond its ends. Widened, it is its mean over a window of values: a steep ramp
 * becomes a gentle one, a narrow peak a broad one. So a voxel on its wrong side has a slope that shows in
 * which direction to move. */
#pragma once

#include "tf/tf.h"

typedef struct iso_fit_curve {
    size_t count;
    double lo, step; /* entry i stands at lo + i step */
    float *entries;  /* 4 each: r, g, b premultiplied, opacity */
} iso_fit_curve;

/* Creates the curve over the transfer function's range and half of it more at each end. ISO_E_MEMORY. */
iso_status iso_fit_curve_create(const iso_tf_table *tf, double length_mm, iso_fit_curve *curve, iso_error *err);
void iso_fit_curve_destroy(iso_fit_curve *curve); /* accepts empty and NULL */

/* Returns over how many values the curve's steepest part would go from its least to its largest opacity; for a ramp its
 * width. If opacity is constant, the channel that changes most counts. 0: the curve is constant. */
double iso_fit_curve_ramp_width(const iso_fit_curve *curve);

/* Fills `wide`, which has the same entries, with the mean of `curve` over [s - width / 2, s + width / 2]. */
void iso_fit_curve_widen(const iso_fit_curve *curve, double width, iso_fit_curve *wide);

/* Finds the place of a value: returns its lower entry, and the fraction of the way to the next. */
static inline size_t iso_fit_curve_find(const iso_fit_curve *curve, float value, float *fraction)
{
    const float last = (float)(curve->count - 1);
    float x = (value - (float)curve->lo) * (float)(1 / curve->step);
    x = x > 0 ? (x < last ? x : last) : 0;
    size_t i = (size_t)x;
    i = i + 1 < curve->count ? i : curve->count - 2;
    *fraction = x - (float)i;
    return i;
}

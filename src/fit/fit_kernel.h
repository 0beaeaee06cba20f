/* SPDX-License-Identifier: MIT */
/* fit_kernel.h - a row of fine voxels under a coarse level; private to src/fit. */
#pragma once

#include "fit/curve.h"

/* A row of values to compare, and their targets. */
typedef struct iso_fit_row {
    const float *fine;  /* level 0's values */
    const float *shown; /* the level's */
    float *weight;      /* w = |p'|^2; read or written */
    float *result;      /* to be scattered */
    size_t count;
    bool opacity_only;
} iso_fit_row;

/* Adds the squared errors by the wide curve and by the true one. */
void iso_fit_row_errors(const iso_fit_row *r, const iso_fit_curve *wide, const iso_fit_curve *curve, double sums[2]);
/* Fills the weights, and result = p' . (p - p(v)); returns the squared error. */
double iso_fit_row_linearize(const iso_fit_row *r, const iso_fit_curve *curve);
/* Sets result = weight shown. */
void iso_fit_row_weigh(const iso_fit_row *r);

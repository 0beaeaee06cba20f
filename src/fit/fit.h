/* SPDX-License-Identifier: MIT */
/* fit.h - the scalar of a coarse level fitted to a transfer function.
 *
 * A level is classified after it is filtered. Its values at the centers of the fine voxels are s = A c
 * (interpolation.h), and their appearance is p(s) (curve.h). The fit looks for coarse values c with the least
 *
 *     E(c) = sum over fine voxels j of |p((A c)_j) - p(v_j)|^2
 *
 * by Gauss-Newton: p is replaced by its tangent at s, so that each step is a linear least-squares problem with one
 * weight per fine voxel, w_j = |p'(s_j)|^2, solved by some rounds of conjugate gradients on A^T W A; then the step is
 * halved until the error falls. Voxels that p is flat at have no weight: they are free, and keep the values that they
 * had. So a fitted level can be nearer than the level of least squares. For the same reason a fine voxel on the wrong
 * side of a steep ramp has no effect. So p is first widened (curve.h), and its width is continued down to none.
 *
 * The result is the iterate of least E, so it is never farther than the start. */
#pragma once

#include "fit/curve.h"
#include "fit/interpolation.h"

typedef struct iso_fit_options {
    size_t round_count;   /* of Gauss-Newton */
    double widths[16];    /* of the ramp, in its own widths: 1 is as it is */
    size_t solver_rounds; /* of conjugate gradients a step */
    bool opacity_only;    /* else color counts too: on five volumes farther in most cases, at four times the work */
    int threads;
} iso_fit_options;
iso_fit_options iso_fit_defaults(void);

typedef struct iso_fit_report {
    double error_start, error_end; /* E */
    size_t best_round;             /* 0: the start */
    double seconds;
} iso_fit_report;

/* The problem: fine values, and their places under the coarse ones. */
typedef struct iso_fit_problem {
    const iso_interpolation *map;
    const float *fine;
    const iso_fit_curve *curve;
} iso_fit_problem;

/* Returns the bytes that a fit needs besides its problem: 5 per fine voxel, and 7 floats per coarse one. */
size_t iso_fit_bytes(size_t fine_count, size_t coarse_count);

/* Computes E under the curve widened to `width` ramps, and its gradient by coarse values (or NULL). ISO_E_MEMORY. */
iso_status iso_fit_error(const iso_fit_problem *problem, const iso_fit_options *opt, double width, const float *coarse,
                         double *error, float *gradient, iso_error *err);

/* Fits a level's scalars. coarse: the start, then the result. ISO_E_MEMORY. */
iso_status iso_fit_scalar(const iso_fit_problem *problem, const iso_fit_options *opt, float *coarse,
                          iso_fit_report *report, iso_error *err);

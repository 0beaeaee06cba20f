/* SPDX-License-Identifier: MIT */
/* level_scalar.h - the scalars that a coarse level can store in place of those of `build`: by least squares, or fitted
 * to a transfer function. Also tests if a pyramid stores them.
 *
 * All are functions of level 0, the level's number and the transfer function alone, bit by bit. Least squares are (A^T
 * A)^-1 A^T v, one axis after the other (pyramid/spline_kernel.h); damped scalars are a part of the way there, the fit
 * (fit.h) starts there. So a pyramid that names its kind of scalars and its transfer function can be made again from
 * its level 0.
 *
 * Memory: iso_level_scalar_bytes(), in addition to level 0. */
#pragma once

#include "base/names.h"
#include "base/progress.h"
#include "fit/fit.h"
#include "pyramid/pyramid_verify.h"

typedef enum iso_level_scalar {
    ISO_LEVEL_AS_BUILT, /* by the pyramid's scalar filter */
    ISO_LEVEL_LEAST_SQUARES,
    ISO_LEVEL_DAMPED,
    ISO_LEVEL_FITTED,
    ISO_LEVEL_OPTIMIZED, /* by plan/optimize.h, with its directions: not made again from level 0 */
    ISO_LEVEL_SCALAR_COUNT
} iso_level_scalar;
extern const iso_names iso_level_scalar_names;
const char *iso_level_scalar_name(iso_level_scalar s);

/* The inputs of a level's scalars. */
typedef struct iso_level_scalar_input {
    const iso_level *level0;
    const iso_tf_table *tf; /* of ISO_LEVEL_FITTED */
    size_t level;           /* at least 1 */
    int threads;
} iso_level_scalar_input;

/* Makes a level's scalars. least_squares, fitted: as many floats as the level has voxels; fitted may be NULL. report:
 * of the fit, or NULL. ISO_E_MEMORY. */
iso_status iso_level_scalars_make(const iso_level_scalar_input *in, float *least_squares, float *fitted,
                                  iso_fit_report *report, iso_error *err);
/* Turns least squares into damped scalars (pyramid.h). */
void iso_level_scalar_damp(const iso_level_scalar_input *in, float *scalar);

/* Returns the bytes of buffers while a level is made. */
size_t iso_level_scalar_bytes(const size_t level0_size[3]);

/* Reads pyramid.made_for (pyramid.h): the transfer function, resolved for the pyramid, and each level's kind of
 * scalars. ISO_E_FORMAT. */
iso_status iso_level_scalars_read(const iso_pyramid *p, iso_tf_table *tf, iso_level_scalar kinds[32], iso_error *err);

/* Verifies any pyramid (iso_pyramid_verify); levels made for a scene are made again for its transfer function. */
iso_status iso_fit_verify(const iso_pyramid *p, int threads, iso_level_check *checks, const iso_progress *progress,
                          iso_error *err);

/* SPDX-License-Identifier: MIT */
/* patch_loss.h - how far a drawn patch of a picture is from the true picture, for optimize.h.
 *
 *     loss of a float    sqrt(d^2 + .01^2) - .01, with d the difference in sRGB, or in alpha
 *     of a patch         the sum over its floats at the pixels, and in small: of the means of box x box pixels, each of
 *                        ISO_SMALL_WEIGHT times its pixels. Pixels beyond the picture, and boxes that its border cuts,
 *                        do not count.
 *
 * Test: tests/test_optimize.c. */
#pragma once

#include "render/cpu/adjoint.h"

/* With none, the gate (level_gate.h) refuses more levels of large voxels. */
#define ISO_SMALL_WEIGHT 0.3f

/* A true picture of side x side pixels, and a patch in it. Pictures: sRGB and alpha in 16 bits. */
typedef struct iso_patch_truth {
    const uint16_t *rgba, *small; /* small: averaged linearly, of small_side x small_side pixels */
    size_t side, small_side, box; /* box: a power of two, at most ISO_ADJOINT_TILE */
    size_t x, y;                  /* first pixel, a multiple of ISO_ADJOINT_TILE */
} iso_patch_truth;

/* Returns the loss of a patch. rgba: its ISO_ADJOINT_PIXELS pixels, linear. slopes get the derivatives by its floats. */
double iso_patch_loss(const iso_patch_truth *truth, const float *rgba, float *slopes);

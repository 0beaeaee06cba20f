/* SPDX-License-Identifier: MIT */
/* adjoint.h - pictures of a field with derivatives: the gradient of any function of the pixels by each voxel's scalar,
 * direction and extinction scale, and by the entries of the transfer function.
 *
 *     value       s(x), trilinear, clamped at the edge     color c(s) and extinction sigma(s) from the view's table
 *     extinction  2^o(x) sigma(s(x))                            o: octaves, trilinear
 *     light       ka + sum over lights, of n = d / sqrt(|d|^2 + eps^2), d(x) trilinear
 *
 * Samples are those of the CPU ray caster (caster.h): with seed 0 the pictures agree up to rounding. Another seed
 * shifts the samples of each ray by up to half a segment, so that no artefact of one set of samples is learned.
 *
 * In: voxels in floats, and a tile of pixels. Out: its colors; then, from the derivatives of a function by these
 * colors, sums that are added to the gradient. The pass back needs no memory that grows with a ray's length. Results
 * depend on no thread: a tile is one thread's work. Between instruction sets they differ by rounding.
 *
 * Paper: [weiss-2021], differentiable direct volume rendering. Test: tests/test_adjoint.c. */
#pragma once

#include "render/cpu/caster.h"

enum { ISO_ADJOINT_TILE = 32, ISO_ADJOINT_PIXELS = ISO_ADJOINT_TILE * ISO_ADJOINT_TILE };

typedef struct iso_adjoint_field {
    const iso_geometry *geometry;
    const float *voxels;  /* 4 per voxel, x fastest: scalar, direction in world axes */
    const float *octaves; /* log2 of the extinction scale, one per voxel; or NULL: 0 */
} iso_adjoint_field;

/* Sums of derivatives, to which a tile adds. octaves, table: NULL if not wanted. */
typedef struct iso_adjoint_gradient {
    float *voxels, *octaves; /* as in the field */
    double *table;           /* 4 per entry of the view's table, in its order and units */
} iso_adjoint_gradient;

typedef struct iso_adjoint_tile {
    size_t x, y; /* first pixel */
    uint32_t seed;
    iso_cpu_width width; /* of the packets of rays */
} iso_adjoint_tile;

/* Draws ISO_ADJOINT_PIXELS pixels of a view, row by row; those beyond its borders, too. The view has neither 2D
 * transfer function nor region of interest; its extinction scale is the field's. ISO_E_RANGE: a field of more than 2^31
 * voxels, an unsupported width. ISO_E_MEMORY. */
iso_status iso_adjoint_draw(const iso_adjoint_field *field, const iso_view *view, const iso_adjoint_tile *tile,
                            float *rgba, iso_error *err);

/* Adds to the gradient. rgba: from iso_adjoint_draw() of the same arguments. by_pixel: derivatives by each of its
 * floats. */
iso_status iso_adjoint_differentiate(const iso_adjoint_field *field, const iso_view *view, const iso_adjoint_tile *tile,
                                     const float *rgba, const float *by_pixel, const iso_adjoint_gradient *gradient,
                                     iso_error *err);

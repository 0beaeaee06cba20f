/* SPDX-License-Identifier: MIT */
/* warp.h - the smooth transitions of [beyer-2008], section 4, as in the paper and
 * corrected, for comparison with brick/bricks.h.
 *
 * Two levels. Fine samples are the voxel centers i + 1/2. Coarse ones are half-way
 * between them, at even positions 2 j (mean of the eight voxels around), so that
 * the faces of bricks pass through coarse samples. In a coarse brick the function is
 * trilinear among coarse samples; in a fine brick among fine ones, except within half
 * a voxel of a coarse neighbor:
 *
 *     fine     o-----o-----o-----o      depth v = 0
 *             /       \   / \     \     trapezoids over coarse cells, Eq. 6, 7;
 *     face   x---------x---------x      v = 1/2       triangles between, Eq. 8, 9
 *
 * Each axis along the face is mapped this way; axes across it (one for a face, two for an
 * edge, three for a corner primitive) shrink towards the face. The value is
 *     f = (1 - 2v) F(top) + 2v C(foot),
 * with top on the line of fine samples, foot on that of coarse ones.
 *
 * written  One trilinear fetch at the warped place, from bricks with duplicated border
 *          voxels. These have the nearest coarse sample if a brick they adjoin is coarse
 *          (section 4.3); faces before edges before corners (section 4.1). Not
 *          continuous if fine and coarse bricks meet only at an edge or a corner:
 *          one copy of a border voxel cannot serve two primitives that need different
 *          values, and a face primitive keeps fine values on a line where the
 *          neighboring bricks have coarse ones.
 * corrected  The primitive of the greatest depth, min of (1/2 - distance) over its axes,
 *          and two fetches, one from each level's own samples. Continuous.
 *
 * The text of the paper does not state its figures' numbers; primitives follow its words. */
#pragma once

#include <stddef.h>
#include <stdint.h>

#include "pyramid/pyramid.h"

typedef enum iso_warp_mode { ISO_WARP_NONE, ISO_WARP_WRITTEN, ISO_WARP_CORRECTED, ISO_WARP_MODE_COUNT } iso_warp_mode;

#define ISO_WARP_CHANNELS 4 /* limit: a scalar and a direction */

typedef struct iso_warp_field {
    size_t size[3];        /* voxels: whole bricks */
    size_t brick_voxels;   /* even */
    size_t channels;       /* per sample, 1 to ISO_WARP_CHANNELS */
    const float *fine;     /* `channels` per voxel, x fastest */
    float *coarse;         /* owned; size / 2 + 1 samples along each axis */
    const uint8_t *levels; /* one per brick: 0 fine, 1 coarse; x fastest */
    iso_warp_mode mode;
} iso_warp_field;

/* Creates a field; the caller sets levels and mode. fine is borrowed. ISO_E_RANGE: the size is not whole bricks of an
 * even side; ISO_E_MEMORY. */
iso_status iso_warp_field_create(iso_warp_field *f, const float *fine, size_t channels, const size_t size[3],
                                 size_t brick_voxels, iso_error *err);
void iso_warp_field_destroy(iso_warp_field *f); /* accepts empty and NULL */

static inline size_t iso_warp_bricks(const iso_warp_field *f, int axis)
{
    return f->size[axis] / f->brick_voxels;
}

/* Returns a bit for each coarse neighbor; 0 for a coarse brick. */
unsigned iso_warp_neighbors(const iso_warp_field *f, const size_t brick[3]);

/* Samples one brick (its first channel) at index position p in its closed box: on a face, the limit from that side. */
double iso_warp_sample_in(const iso_warp_field *f, const size_t brick[3], const double p[3]);

/* SPDX-License-Identifier: MIT */
/* warp.h - the smooth transitions of [beyer-2008], section 4: as the paper
 * has them, and corrected. For comparison with brick/bricks.h. Where they fetch is
 * defined once, in brick/warp_map.h, for this module and for the shaders.
 *
 * Two levels. Fine samples are the voxel centers i + 1/2, coarse ones stand half-way
 * between them, at even positions 2 j (the mean of the eight voxels around), so that
 * the faces of bricks pass through coarse samples. In a coarse brick the function is
 * trilinear among coarse samples; in a fine brick among fine ones, except within half
 * a voxel of a coarse neighbor:
 *
 *     fine     o-----o-----o-----o      depth v = 0
 *             /       \   / \     \     trapezoids over coarse cells, Eq. 6, 7;
 *     face   x---------x---------x      v = 1/2       triangles between, Eq. 8, 9
 *
 * Each axis along the face is mapped so; axes across it (one of a face, two of an edge,
 * three of a corner primitive) shrink towards the face. The value is
 *     f = (1 - 2v) F(top) + 2v C(foot),
 * top on the line of fine samples, foot on that of coarse ones.
 *
 * written  One trilinear fetch at the warped place, from bricks whose duplicated border
 *          voxels hold the nearest coarse sample where a brick they adjoin is coarse
 *          (section 4.3); faces before edges before corners (section 4.1). Not
 *          continuous where fine and coarse bricks meet by an edge or a corner alone:
 *          one copy of a border voxel cannot serve two primitives that need different
 *          values, and a face primitive keeps fine values on a line where the bricks
 *          beside it have coarse ones.
 * corrected  The primitive of the greatest depth, min of (1/2 - distance) over its axes,
 *          and two fetches, one from each level's own samples. Continuous.
 *
 * The figures of the paper are not in its text; the primitives are read from the words. */
#ifndef ISO_WARP_H
#define ISO_WARP_H

#include <stddef.h>
#include <stdint.h>

#include "pyramid/pyramid.h"

/* In the order of ISO_TRANSITION_... of warp_map.h. */
typedef enum iso_warp_mode { ISO_WARP_NONE, ISO_WARP_WRITTEN, ISO_WARP_CORRECTED, ISO_WARP_MODE_COUNT } iso_warp_mode;

#define ISO_WARP_CHANNELS 4 /* at most: a scalar and a direction */

typedef struct iso_warp_field {
    size_t size[3];        /* voxels: whole bricks */
    size_t brick_voxels;   /* even */
    size_t channels;       /* 1 to ISO_WARP_CHANNELS a sample */
    const float *fine;     /* channels a voxel, x fastest */
    float *owned;          /* what fine points to, where it was made here */
    float *coarse;         /* owned; size / 2 + 1 samples along each axis */
    const uint8_t *levels; /* 0 fine, 1 coarse; a brick each, x fastest */
    iso_warp_mode mode;
} iso_warp_field;

/* ISO_E_RANGE when the size is not whole bricks of an even side, ISO_E_MEMORY. levels and mode are the caller's. fine
 * is not copied. */
iso_status iso_warp_field_create(iso_warp_field *f, const float *fine, size_t channels, const size_t size[3],
                                 size_t brick_voxels, iso_error *err);
/* The scalar and the decoded directions of a level, continued by its edge to whole bricks. Coarse directions are means:
 * shorter where the eight disagree. */
iso_status iso_warp_field_of_level(iso_warp_field *f, const iso_level *level, iso_code code, size_t brick_voxels,
                                   iso_error *err);
void iso_warp_field_destroy(iso_warp_field *f); /* accepts empty and NULL */

static inline size_t iso_warp_bricks(const iso_warp_field *f, int axis)
{
    return f->size[axis] / f->brick_voxels;
}

/* A bit for each coarse neighbor (iso_warp_bit of warp_map.h); none for a brick that is coarse itself. */
unsigned iso_warp_neighbors(const iso_warp_field *f, const size_t brick[3]);

/* The samples of a brick as a cache holds them: fine bricks have side + 2 voxels along each axis, whose border is that
 * of the field or, in mode written, the nearest coarse samples; coarse bricks have side / 2 + 1 samples. f->channels a
 * sample, x fastest. */
size_t iso_warp_cache_side(const iso_warp_field *f, const size_t brick[3]);
void iso_warp_bake(const iso_warp_field *f, const size_t brick[3], float *restrict out);

/* The function of one brick (its first channel) at index position p in its closed box: on a face, the limit from that
 * side. */
double iso_warp_sample_in(const iso_warp_field *f, const size_t brick[3], const double p[3]);
/* All channels at index coordinates, clamped to the volume. */
void iso_warp_sample(const iso_warp_field *f, iso_vec3 index, double out[ISO_WARP_CHANNELS]);

#endif

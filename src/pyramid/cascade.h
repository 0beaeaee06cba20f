/* SPDX-License-Identifier: MIT */
/* cascade.h - builds all levels of a pyramid while the finest one is fed in slabs.
 *
 * The volume is fed from its first plane to its last. The planes of each level that
 * a slab completes are written into the caller's buffers. The result depends neither
 * on how the volume is cut into slabs nor on the number of threads.
 *
 * Filters that read only the 2x2x2 children of a voxel (mean; moments, naive, tensor)
 * are computed depth first: a thread takes one row of the top level, computes the rows
 * below it that it is made from, and the rows below those, down to the gradients of
 * level 0. All of it stays in the thread's caches:
 *
 *     level 2   one row                       4 rows of level 1, each
 *     level 1   ====  ====                    2 x 2 rows of level 0
 *     level 0   == == == ==   (y)   x 4 (z)
 *
 * Gaussian filters (gauss, eq1) read more than the children and are computed plane by
 * plane: a fine plane is filtered and decimated along x, then along y, and added to the
 * coarse planes that it contributes to. A coarse plane that is complete is a fine plane
 * for the next level. Least-squares scalars are made plane by plane, too, each level from
 * level 0 (cascade_spline.c). */
#pragma once

#include "gradient/gradient_kernel.h"
#include "pyramid/agreement.h"
#include "pyramid/pyramid.h"

/* Where a level's planes go; plane z stands at (z - first) planes. Planes below
 * first are not written. scalar may be NULL at level 0, whose scalars are the input. */
typedef struct iso_cascade_out {
    size_t first;
    float *scalar;
    uint8_t *codes;
    float *directions; /* with keep_float */
    float *magnitude;  /* with keep_magnitude */
} iso_cascade_out;

typedef struct iso_cascade iso_cascade;

/* Returns the number of levels by the options and the size. */
size_t iso_cascade_level_count(const iso_geometry *g, const iso_pyramid_options *opt);

/* Creates a cascade. scale: a power of two that gradients are multiplied by (iso_cascade_scale). */
iso_status iso_cascade_create(const iso_geometry *g, const iso_pyramid_options *opt, double scale, iso_cascade **out,
                              iso_error *err);
void iso_cascade_destroy(iso_cascade *c); /* accepts NULL */

/* Returns a power of two that brings gradients of samples in this range near 1. Their fourth powers then neither
 * overflow nor vanish, in any unit. */
double iso_cascade_scale(const iso_geometry *g, double range);

/* Returns a number of planes; slabs start at its multiples. */
size_t iso_cascade_step(const iso_cascade *c);
/* Returns how many planes of the input a slab needs before it, and how many after it. */
size_t iso_cascade_reach(const iso_cascade *c);
/* Returns the most planes of level k that a slab of plane_count planes can complete. */
size_t iso_cascade_capacity(const iso_cascade *c, size_t level, size_t plane_count);
/* Returns the plane to feed from to resume at plane z: then every plane that was not yet written comes out complete. */
size_t iso_cascade_warm_up(const iso_cascade *c, size_t z);
/* Returns how many planes of level k are complete after feeding up to plane z. */
size_t iso_cascade_complete(const iso_cascade *c, size_t level, size_t z);

/* Feeds the planes z0 .. z1 - 1 of `in`, which also holds the planes within reach of them. */
iso_status iso_cascade_feed(iso_cascade *c, const iso_planes *in, size_t z0, size_t z1, const iso_cascade_out *out,
                            iso_error *err);

/* Returns the states that levels above the fifth are made from at the end. Each complete plane of level
 * iso_cascade_carry_level() has one plane of `*plane_floats` floats. NULL if no level is above the fifth. */
float *iso_cascade_carry(const iso_cascade *c, size_t *plane_floats);
size_t iso_cascade_carry_level(const iso_cascade *c);

/* Returns the bytes that the cascade holds between slabs. */
size_t iso_cascade_bytes(const iso_cascade *c);

/* Gets the sums of all planes that were fed, up to the fifth level, for iso_agreement_options(). `out` of
 * iso_cascade_feed() then holds NULLs. Cascades may each be fed a part of a volume, from a multiple of
 * iso_cascade_step() on, and their sums added. */
void iso_cascade_get_agreement(const iso_cascade *c, size_t level, iso_agreement *sums);
void iso_cascade_add_agreement(iso_cascade *c, size_t level, const iso_agreement *sums);
/* Chooses by these sums. */
void iso_cascade_choose(const iso_cascade *c, iso_direction_choice *choice);

/* Gets the range of the level's scalars so far; min > max when there are none. */
void iso_cascade_range(const iso_cascade *c, size_t level, double *min, double *max);
void iso_cascade_set_range(iso_cascade *c, size_t level, double min, double max); /* when a build is resumed */

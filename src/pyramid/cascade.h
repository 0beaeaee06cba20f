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
#ifndef ISO_PYRAMID_CASCADE_H
#define ISO_PYRAMID_CASCADE_H

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

/* The number of levels that the options and the size give. */
size_t iso_cascade_level_count(const iso_geometry *g, const iso_pyramid_options *opt);

/* scale: gradients are multiplied by it, a power of two (iso_cascade_scale). */
iso_status iso_cascade_create(const iso_geometry *g, iso_type type, const iso_pyramid_options *opt, double scale,
                              iso_cascade **out, iso_error *err);
void iso_cascade_destroy(iso_cascade *c); /* accepts NULL */

/* A power of two that brings gradients of samples in this range near 1. Their fourth powers then neither overflow nor
 * vanish, in any unit. */
double iso_cascade_scale(const iso_geometry *g, double range);

/* Slabs start at multiples of this number of planes. */
size_t iso_cascade_step(const iso_cascade *c);
/* A slab needs this many planes of the input before it and after it. */
size_t iso_cascade_reach(const iso_cascade *c);
/* The most planes of level k that a slab of plane_count planes can complete. */
size_t iso_cascade_capacity(const iso_cascade *c, size_t level, size_t plane_count);
/* To resume at plane z, feed from this plane on: then every plane that was not yet written comes out complete. */
size_t iso_cascade_warm_up(const iso_cascade *c, size_t z);
/* How many planes of level k are complete after feeding up to plane z. */
size_t iso_cascade_complete(const iso_cascade *c, size_t level, size_t z);

/* Feeds the planes z0 .. z1 - 1 of `in`, which also holds the planes within reach of them. */
iso_status iso_cascade_feed(iso_cascade *c, const iso_planes *in, size_t z0, size_t z1, const iso_cascade_out *out,
                            iso_error *err);

/* Levels above the fifth are made at the end, from the states kept here. Each complete plane of level
 * iso_cascade_carry_level() has one plane of `*plane_floats` floats. NULL if no level is above the fifth. */
float *iso_cascade_carry(const iso_cascade *c, size_t *plane_floats);
size_t iso_cascade_carry_level(const iso_cascade *c);

/* Memory that the cascade holds between slabs. */
size_t iso_cascade_bytes(const iso_cascade *c);

/* For options of ISO_DIRECTION_AUTO whose choice is not made (iso_agreement_options): what all that was fed adds up to,
 * up to the fifth level; `out` of iso_cascade_feed() holds NULLs. The sums of several cascades that were fed parts of a
 * volume, from multiples of iso_cascade_step() on, may be added. */
void iso_cascade_get_agreement(const iso_cascade *c, size_t level, iso_agreement *sums);
void iso_cascade_add_agreement(iso_cascade *c, size_t level, const iso_agreement *sums);
/* The choice that follows. */
void iso_cascade_choose(const iso_cascade *c, iso_direction_choice *choice);

/* The range of the level's scalars so far; min > max when there are none. */
void iso_cascade_range(const iso_cascade *c, size_t level, double *min, double *max);
void iso_cascade_set_range(iso_cascade *c, size_t level, double min, double max); /* when a build is resumed */

#endif

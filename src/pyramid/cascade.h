/* SPDX-License-Identifier: MIT */
/* cascade.h - all levels of a pyramid from slabs of its finest one.
 *
 * The volume is fed from its first plane to its last. What a slab completes of
 * each level is written into the caller's buffers; nothing else depends on how
 * the volume is cut into slabs, or on the number of threads.
 *
 * Filters over the own children (mean; moments, naive) go depth first: a thread
 * takes one row of the top level, computes the rows that it consists of, and
 * those that they consist of, down to the gradients of level 0, while all of it
 * lies in its caches:
 *
 *     level 2   one row                       4 rows of level 1, each
 *     level 1   ====  ====                    2 x 2 rows of level 0
 *     level 0   == == == ==   (y)   x 4 (z)
 *
 * Wider filters (gauss, eq1) go plane by plane: a fine plane is filtered and
 * decimated along x, then y, and added to the coarse planes that it belongs to;
 * a coarse plane that is complete is a fine plane for the next level. */
#ifndef ISO_PYRAMID_CASCADE_H
#define ISO_PYRAMID_CASCADE_H

#include "gradient/gradient_kernel.h"
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

/* A power of two that brings gradients of samples with this range near 1, so
 * that their fourth powers neither overflow nor vanish whatever the units are. */
double iso_cascade_scale(const iso_geometry *g, double range);

/* Slabs start at multiples of this number of planes. */
size_t iso_cascade_step(const iso_cascade *c);
/* Planes of the input before and after a slab that it reads. */
size_t iso_cascade_reach(const iso_cascade *c);
/* Planes of level k that a slab of plane_count planes can complete, at most. */
size_t iso_cascade_capacity(const iso_cascade *c, size_t level, size_t plane_count);
/* To go on at plane z: the plane from which to feed, so that every plane that
 * is still missing then comes out whole. */
size_t iso_cascade_warm_up(const iso_cascade *c, size_t z);
/* What a build that has been fed up to plane z has completed of level k. */
size_t iso_cascade_complete(const iso_cascade *c, size_t level, size_t z);

/* Feeds the planes z0 .. z1 - 1 of `in`, which holds those within reach, too. */
iso_status iso_cascade_feed(iso_cascade *c, const iso_planes *in, size_t z0, size_t z1, const iso_cascade_out *out,
                            iso_error *err);

/* What levels above the fifth are made from in the end: planes of `*plane_floats`
 * floats, as many as level iso_cascade_carry_level() has complete. NULL when there
 * is no such level. */
float *iso_cascade_carry(const iso_cascade *c, size_t *plane_floats);
size_t iso_cascade_carry_level(const iso_cascade *c);

/* Memory that it holds between slabs. */
size_t iso_cascade_bytes(const iso_cascade *c);

/* Of the level's scalars so far; min > max when there are none. */
void iso_cascade_range(const iso_cascade *c, size_t level, double *min, double *max);
void iso_cascade_set_range(iso_cascade *c, size_t level, double min, double max); /* to go on with */

#endif

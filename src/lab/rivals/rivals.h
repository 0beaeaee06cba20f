/* SPDX-License-Identifier: MIT */
/* rivals.h - other ways to show a coarse level, from the literature: doc/method/levels.md says what each is.
 *
 * They are made from the level and the fine voxels under it, at float precision: what is measured is the best that a
 * method can do, before its own quantization. Each is an emitter of the reference (render/reference.h); shading is by
 * the level's own directions, unless the method is about directions. */
#ifndef ISO_LAB_RIVALS_H
#define ISO_LAB_RIVALS_H

#include "pyramid/pyramid.h"
#include "render/reference.h"

/* A level under a transfer function, for which a method makes what is shown. */
typedef struct iso_level_subject {
    const iso_pyramid *pyramid; /* by the method's filters */
    size_t level;
    const iso_tf_table *tf; /* of level 0 */
    int threads;
} iso_level_subject;

typedef struct iso_rival {
    iso_emitter emitter;
    void *field;
    void (*release)(void *field);
} iso_rival;
void iso_rival_destroy(iso_rival *r); /* accepts a zeroed one */

/* All return ISO_E_MEMORY where there is none. */

/* Pre-classified colors: means over the fine voxels of premultiplied color and ... */
iso_status iso_rival_opacity(const iso_level_subject *s, iso_rival *r, iso_error *err);    /* opacity of a fine voxel */
iso_status iso_rival_extinction(const iso_level_subject *s, iso_rival *r, iso_error *err); /* extinction */
/* Extinction that keeps the mean transmittance through the voxel, along each axis, and the color seen. */
iso_status iso_rival_transmittance(const iso_level_subject *s, iso_rival *r, iso_error *err);
/* Two Gaussians a voxel, fitted to its fine values; each convolved with the TF. */
iso_status iso_rival_two_gaussians(const iso_level_subject *s, iso_rival *r, iso_error *err);
/* Mean and deviation a voxel, filtered, then the TF convolved with their Gaussian. */
iso_status iso_rival_deviation(const iso_level_subject *s, iso_rival *r, iso_error *err);
/* Eq. 7 of [diaz-garcia-2016] for each brick of ISO_RIVAL_BRICK^3 coarse voxels, blended between their centers. */
enum { ISO_RIVAL_BRICK = 16 };
iso_status iso_rival_bricks(const iso_level_subject *s, iso_rival *r, iso_error *err);
/* The original TF on the mean; directions as SGGX microflakes. */
iso_status iso_rival_sggx(const iso_level_subject *s, iso_rival *r, iso_error *err);

/* ---- their parts, for tests ---- */

/* The fine voxels [lo, hi) under a voxel of the level. */
typedef struct iso_fine_box {
    size_t lo[3], hi[3];
} iso_fine_box;
iso_fine_box iso_fine_box_of(const iso_pyramid *p, size_t level, size_t voxel);

/* The means of premultiplied color and opacity over a length, of the TF under a Gaussian: rgb a, a. The table is linear
 * between entries, and so are their opacities taken; beyond its range it is constant. In closed form. */
void iso_tf_under_gaussian(const iso_tf_table *tf, double length_mm, double mean, double deviation, double rgba[4]);

/* The mean of |light . m| over the visible normals m of an SGGX distribution, seen from `view`: S is xx, yy, zz, xy, xz,
 * yz. 0 where S is 0. */
double iso_sggx_diffuse(const double s[6], iso_vec3 view, iso_vec3 light);
/* S of the projected areas of directions with weights, added one by one. */
typedef struct iso_sggx_sums {
    double weight, areas[6]; /* along x, y, z, x + y, x + z, y + z */
} iso_sggx_sums;
void iso_sggx_add(iso_sggx_sums *sums, iso_vec3 n, double weight);
void iso_sggx_matrix(const iso_sggx_sums *sums, double s[6]);

#endif

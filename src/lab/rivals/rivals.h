/* SPDX-License-Identifier: MIT */
/* rivals.h - methods of the literature to show a coarse level; doc/method/levels.md describes each.
 *
 * They are made from the level and its fine voxels at float precision, so that the result is the best of a method
 * before its own quantization. Each is an emitter of the reference (render/reference.h). Shading uses the level's own
 * directions, unless the method is about directions. */
#pragma once

#include "pyramid/pyramid.h"
#include "render/reference.h"

/* A level and transfer function for which a method is prepared. */
typedef struct iso_level_subject {
    const iso_pyramid *pyramid; /* built with the method's filters */
    size_t level;
    const iso_tf_table *tf;     /* level 0's */
    const iso_tf_table *before; /* the same before it was edited: levels for a scene are made for it */
    int threads;
} iso_level_subject;

typedef struct iso_rival {
    iso_emitter emitter;
    void *field;
    void (*release)(void *field);
} iso_rival;
void iso_rival_destroy(iso_rival *r); /* accepts a zeroed struct */

/* All functions below return ISO_E_MEMORY if out of memory. */

/* Averages pre-classified colors: means over the fine voxels of premultiplied color and of opacity or extinction. */
iso_status iso_rival_opacity(const iso_level_subject *s, iso_rival *r, iso_error *err);    /* opacity per fine voxel */
iso_status iso_rival_extinction(const iso_level_subject *s, iso_rival *r, iso_error *err); /* extinction */
/* Keeps the mean transmittance through the voxel along each axis, and the visible color. */
iso_status iso_rival_transmittance(const iso_level_subject *s, iso_rival *r, iso_error *err);
/* Fits two Gaussians to the fine values of each voxel; each is convolved with the TF. */
iso_status iso_rival_two_gaussians(const iso_level_subject *s, iso_rival *r, iso_error *err);
/* Filters mean and deviation per voxel; then the TF is convolved with their Gaussian. */
iso_status iso_rival_deviation(const iso_level_subject *s, iso_rival *r, iso_error *err);
/* Eq. 7 of [diaz-garcia-2016] for each brick of ISO_RIVAL_BRICK^3 coarse voxels, blended between their centers. */
enum { ISO_RIVAL_BRICK = 16 };
iso_status iso_rival_bricks(const iso_level_subject *s, iso_rival *r, iso_error *err);
/* Uses the original TF of the mean; directions are SGGX microflakes. */
iso_status iso_rival_sggx(const iso_level_subject *s, iso_rival *r, iso_error *err);

/* ---- parts, for tests ---- */

/* The fine voxels [lo, hi) under a voxel of the level. */
typedef struct iso_fine_box {
    size_t lo[3], hi[3];
} iso_fine_box;
iso_fine_box iso_fine_box_of(const iso_pyramid *p, size_t level, size_t voxel);

/* Averages premultiplied color and opacity over a length, of the TF under a Gaussian: rgb a, a. In closed form: the
 * table and its opacities are linear between entries and constant beyond the range. */
void iso_tf_under_gaussian(const iso_tf_table *tf, double length_mm, double mean, double deviation, double rgba[4]);

/* Returns the mean of |light . m| over the visible normals m of an SGGX distribution, seen from `view`; 0 if S is 0. S
 * is xx, yy, zz, xy, xz, yz. */
double iso_sggx_diffuse(const double s[6], iso_vec3 view, iso_vec3 light);
/* Sums of projected areas of weighted directions, from which S is computed. */
typedef struct iso_sggx_sums {
    double weight, areas[6]; /* along x, y, z, x + y, x + z, y + z */
} iso_sggx_sums;
void iso_sggx_add(iso_sggx_sums *sums, iso_vec3 n, double weight);
void iso_sggx_matrix(const iso_sggx_sums *sums, double s[6]);

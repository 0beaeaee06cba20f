/* SPDX-License-Identifier: MIT */
/* roi.h - a region of interest: a finer level inside a box, blended without a seam
 * into the level rendered around it.
 *
 * Paper: [diaz-garcia-2016], Figure 11, which inserts full resolution into a coarse
 * level whose transfer function (TF) is adapted, and relies on their equal
 * appearance. Here emission and absorption of the two levels are blended as well. With w the
 * weight of the finer level at a point,
 *
 *     sigma         = (1 - w) sigma_k           + w sigma_j
 *     sigma c shade = (1 - w) sigma_k c_k shade + w sigma_j c_j shade
 *
 * each level with its own scalar, directions and TF. These are two media at one place, which
 * every renderer supports. w is 1 in the box and falls to 0 over a band around it:
 *
 *     u = 1 - d / band,  w = u^2 (3 - 2 u),  d: distance of the point from the box,
 *                                            the largest of the three axes
 *
 * w has a continuous slope across the faces of the box and of the band, so the image
 * has neither a step nor a kink there. Inside the box only the finer level is looked
 * up. d and the band are in voxels of the level around it. */
#pragma once

#include "pyramid/pyramid.h"
#include "tf/tf.h"

#define ISO_ROI_BAND 2.0 /* in voxels of the level around it */

typedef struct iso_roi {
    iso_level level; /* owned: finer level in the box, its band and two voxels more: scalar, codes, directions */
    size_t number;   /* number of that level */
    iso_tf_table tf; /* owned; for that level */
    double scale, offset[3]; /* index in `level` = scale * index in the level around it - offset */
    double lo[3], hi[3];     /* the box, in index coordinates of the level around it */
    double band;
} iso_roi;

/* Settings: the box in voxels of level 0, the level inside, the band (0: a hard switch). */
typedef struct iso_roi_options {
    double lo[3], hi[3];
    size_t level;
    double band;
} iso_roi_options;
iso_roi_options iso_roi_defaults(void);

/* Creates a region. around: number of the level rendered outside; tf is copied. ISO_E_RANGE: the box is empty or
 * outside the volume, or the level is not finer; ISO_E_MEMORY. */
iso_status iso_roi_create(const iso_pyramid *p, size_t around, const iso_tf_table *tf, const iso_roi_options *opt,
                          iso_roi *roi, iso_error *err);
void iso_roi_destroy(iso_roi *roi); /* accepts empty and NULL */

/* Returns the weight of the finer level at index coordinates of the level around it. */
double iso_roi_weight(const iso_roi *roi, iso_vec3 index);

static inline iso_vec3 iso_roi_inside(const iso_roi *f, iso_vec3 index)
{
    return iso_v3(f->scale * index.x - f->offset[0], f->scale * index.y - f->offset[1],
                  f->scale * index.z - f->offset[2]);
}

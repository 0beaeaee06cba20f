/* SPDX-License-Identifier: MIT */
/* roi.h - a region of interest: a finer level inside a box, the level
 * rendered around it, and no seam between them.
 *
 * Paper: [diaz-garcia-2016], Figure 11, which sets full resolution into a coarse
 * level whose transfer function (TF) is adapted, and relies on their equal
 * appearance. Here the two levels' emission and absorption are blended as well. With w the
 * weight of the finer level at a point,
 *
 *     sigma         = (1 - w) sigma_k           + w sigma_j
 *     sigma c shade = (1 - w) sigma_k c_k shade + w sigma_j c_j shade
 *
 * each level with its own scalar, directions and TF. These are two media in one place, which
 * every renderer supports. w is 1 in the box, and falls to 0 over a band around it:
 *
 *     u = 1 - d / band,  w = u^2 (3 - 2 u),  d: how far outside the box the point
 *                                            is, the largest of the three axes
 *
 * w has a continuous slope across the box's and the band's faces, so the image
 * has neither a step nor a kink there. Inside the box nothing but the finer level
 * is looked up. d and the band are counted in voxels of the level around it. */
#ifndef ISO_SCENE_ROI_H
#define ISO_SCENE_ROI_H

#include "pyramid/pyramid.h"
#include "tf/tf.h"

#define ISO_ROI_BAND 2.0 /* voxels of the level around it */

typedef struct iso_roi {
    iso_level
        level; /* owned: scalar, codes and directions of the finer level in the box and its band, and two voxels more */
    size_t number;           /* of that level */
    iso_tf_table tf;         /* owned: of that level */
    double scale, offset[3]; /* index in `level` = scale * index in the level around it - offset */
    double lo[3], hi[3];     /* the box, in the index of the level around it */
    double band;
} iso_roi;

/* Settings: the box in voxels of level 0, the level inside, the band (0: none, a hard switch). */
typedef struct iso_roi_options {
    double lo[3], hi[3];
    size_t level;
    double band;
} iso_roi_options;
iso_roi_options iso_roi_defaults(void);

/* around: the level that is rendered outside. tf is copied. ISO_E_RANGE: a box that
 * is empty or outside the volume, a level that is not finer; ISO_E_MEMORY. */
iso_status iso_roi_create(const iso_pyramid *p, size_t around, const iso_tf_table *tf, const iso_roi_options *opt,
                          iso_roi *roi, iso_error *err);
void iso_roi_destroy(iso_roi *roi); /* accepts empty and NULL */

/* The weight of the finer level at an index of the level around it. */
double iso_roi_weight(const iso_roi *roi, iso_vec3 index);

static inline iso_vec3 iso_roi_inside(const iso_roi *f, iso_vec3 index)
{
    return iso_v3(f->scale * index.x - f->offset[0], f->scale * index.y - f->offset[1],
                  f->scale * index.z - f->offset[2]);
}

#endif

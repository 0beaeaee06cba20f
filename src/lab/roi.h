/* SPDX-License-Identifier: MIT */
/* roi.h - how a seam round a region of interest is measured; for the benchmark and its test. */
#ifndef ISO_LAB_ROI_H
#define ISO_LAB_ROI_H

#include "compare/metrics.h"
#include "scene/roi.h"
#include "render/gl/raycaster.h"
#include "render/sampler.h"
#include "tf/adapt.h"

/* Both sides of a region of interest at any point. */
typedef struct iso_roi_setup {
    const iso_roi *roi;
    iso_sampler around, inside;
    double length_mm; /* a voxel of level 0 */
} iso_roi_setup;
iso_status iso_roi_setup_create(iso_roi_setup *s, const iso_pyramid *p, size_t level, const iso_roi *roi,
                                iso_error *err);
void iso_roi_setup_destroy(iso_roi_setup *s);

/* Distances of (premultiplied color, opacity) over one level-0 voxel, unshaded, on the faces of the box and of its band. */
typedef struct iso_roi_step {
    double rms, largest; /* between the limits from both sides */
    double own;          /* rms: the finer level, half a voxel to either side of the box's faces */
    double change;       /* rms: between the two levels in one place */
    double tone;         /* of their means over the faces: what the eye sees as one side being brighter */
} iso_roi_step;
/* around: the TF of the level around the box. */
iso_roi_step iso_roi_measure_step(const iso_roi_setup *s, const iso_roi *roi, const iso_tf_table *around);

/* Along -z, orthographic, ISO_ROI_PIXELS pixels a voxel. ISO_E_RANGE: a turned grid. */
#define ISO_ROI_PIXELS 2
iso_status iso_roi_make_view(const iso_scene *scene, const iso_pyramid *p, iso_view *view, iso_error *err);
/* RMS of the color's difference between the pixels on both sides of the box's faces in x, in such an image. */
double iso_roi_image_step(const iso_image *image, const iso_pyramid *p, const iso_roi_options *box);

#endif

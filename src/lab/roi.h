/* SPDX-License-Identifier: MIT */
/* roi.h - measures the seam around a region of interest; for the benchmark and its test. */
#ifndef ISO_LAB_ROI_H
#define ISO_LAB_ROI_H

#include "compare/metrics.h"
#include "scene/roi.h"
#include "render/gl/raycaster.h"
#include "render/sampler.h"
#include "tf/adapt.h"

/* The two levels of a region of interest, at any point. */
typedef struct iso_roi_setup {
    const iso_roi *roi;
    iso_sampler around, inside;
    double length_mm; /* of one voxel of level 0 */
} iso_roi_setup;
iso_status iso_roi_setup_create(iso_roi_setup *s, const iso_pyramid *p, size_t level, const iso_roi *roi,
                                iso_error *err);
void iso_roi_setup_destroy(iso_roi_setup *s);

/* Differences of (premultiplied color, opacity) over one level-0 voxel, unshaded, at faces of box and band. */
typedef struct iso_roi_step {
    double rms, largest; /* between the limits from both sides */
    double own;          /* RMS of the finer level, half a voxel to either side of the box's faces */
    double change;       /* RMS between the two levels in one place */
    double tone;         /* of their means over the faces: visible as one brighter side */
} iso_roi_step;
/* Measures the steps. around: the TF of the level around the box. */
iso_roi_step iso_roi_measure_step(const iso_roi_setup *s, const iso_roi *roi, const iso_tf_table *around);

/* Sets up a view along -z, orthographic, ISO_ROI_PIXELS pixels per voxel. ISO_E_RANGE: a rotated grid. */
#define ISO_ROI_PIXELS 2
iso_status iso_roi_make_view(const iso_scene *scene, const iso_pyramid *p, iso_view *view, iso_error *err);
/* Returns the RMS color difference between the pixels on both sides of the box's faces in x, in such an image. */
double iso_roi_image_step(const iso_image *image, const iso_pyramid *p, const iso_roi_options *box);

#endif

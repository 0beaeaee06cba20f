/* SPDX-License-Identifier: MIT */
/* survey.h - statistics of a volume's values and gradients, from which transfer functions are suggested.
 *
 * In the joint histogram of value and gradient magnitude [kindlmann-1998] [kniss-2002], homogeneous materials are peaks
 * at small magnitudes. A boundary between two of them is an arch from one to the other; its top is the boundary's
 * middle. For each value the survey gives the number of voxels, the number of flat ones, and the mean gradient
 * magnitude on its isosurface, sum g^2 / sum g [pekar-2001]: by the coarea formula sum g is the isosurface's area.
 *
 * Padding is left out first: one value, often -2000 or -32768, that lies apart from all others and on the faces of the
 * box. The other values are binned from their .05 % to their 99.95 % quantile, so that hot pixels or the tail of a
 * simulation do not squeeze the rest into one bin; values beyond count in the end bins.
 *
 * The background is the highest peak of the values on the box's faces, from its rise to its end.
 *
 * Counts are integers, and quantiles use voxels at a fixed stride: results do not depend on the number of threads. */
#pragma once

#include <stdint.h>

#include "pyramid/pyramid.h"

enum { ISO_SURVEY_BINS = 256, ISO_SURVEY_SLOPES = 128, ISO_SURVEY_QUANTILES = 4096, ISO_SURVEY_LABELS = 2048 };

typedef struct iso_survey {
    double min, max; /* of all voxels */
    bool has_no_data; /* True if some voxels have none: they are left out like padding */
    bool has_padding;
    double padding;
    bool is_hounsfield;                        /* True if air and soft tissue of a CT have their Hounsfield units */
    bool is_label_map;                         /* True for a known label map, used without interpolation */
    const json_t *segments;                    /* names and colors of the labels; borrowed, or NULL */
    size_t label_count;                        /* 0 unless it is, or looks like, a label map */
    double labels[ISO_SURVEY_LABELS];          /* ascending; if it only looks like one, without padding */
    double quantile[ISO_SURVEY_QUANTILES + 1]; /* without padding */

    double lo, hi;        /* range of the bins; lo == hi for a volume of one value */
    uint64_t voxel_count; /* in the bins */
    uint64_t count[ISO_SURVEY_BINS];
    uint64_t face[ISO_SURVEY_BINS];                     /* of the voxels at the box's faces */
    uint64_t face_count, face_padding;                  /* voxels on the faces: all; padding */
    uint64_t joint[ISO_SURVEY_BINS][ISO_SURVEY_SLOPES]; /* by iso_survey_slope() */
    double flat[ISO_SURVEY_BINS];                       /* voxels of small magnitude, smoothed */
    double slope[ISO_SURVEY_BINS]; /* mean magnitude on the isosurface, in value per voxel, smoothed */

    bool has_background;
    double background, background_lo, background_hi; /* its peak and its ends */
} iso_survey;

/* Creates a survey of level 0, to be freed by free(). ISO_E_MEMORY; ISO_E_RANGE: level without its scalar. */
iso_status iso_survey_make(const iso_level *level0, int threads, iso_survey **survey, iso_error *err);

/* Returns the value below which that part, 0 to 1, of the voxels lies. */
double iso_survey_quantile(const iso_survey *s, double part);
/* Returns the value at the middle of a bin; the bin of a value. */
double iso_survey_value(const iso_survey *s, double bin);
int iso_survey_bin(const iso_survey *s, double value);
/* Returns the magnitude, in value per voxel, of bin `slope` of the second axis. */
double iso_survey_slope(const iso_survey *s, double slope);

/* SPDX-License-Identifier: MIT */
/* survey.h - what values a volume has, and where they change: what transfer functions are suggested from.
 *
 * The joint histogram of value and gradient magnitude [kindlmann-1998] [kniss-2002]: homogeneous materials are peaks at
 * small magnitudes, a boundary between two of them is an arch from one to the other, its top the boundary's middle. Of it
 * come, for each value, the number of voxels, how many are flat, and the mean gradient magnitude on the isosurface of that
 * value, sum g^2 / sum g [pekar-2001]: by the coarea formula sum g is the isosurface's area.
 *
 * Values that are no measurement are left out first. A scanner's padding is one value, often -2000 or -32768, that lies
 * apart from all others and on the faces of the box. The rest is binned from its .05 % to its 99.95 % quantile, so that
 * neither hot pixels nor the tail of a simulation squeeze all else into a bin; what lies beyond has the end bins.
 *
 * The background is what the box's faces show: the highest peak of their values, from where it rises to where it ends.
 *
 * Counts are integers, and quantiles come from voxels at a fixed stride: the same whatever the number of threads. */
#ifndef ISO_TF_SURVEY_H
#define ISO_TF_SURVEY_H

#include <stdint.h>

#include "pyramid/pyramid.h"

enum { ISO_SURVEY_BINS = 256, ISO_SURVEY_SLOPES = 128, ISO_SURVEY_QUANTILES = 4096, ISO_SURVEY_LABELS = 512 };

typedef struct iso_survey {
    double min, max; /* of all voxels */
    bool has_padding;
    double padding;
    bool is_hounsfield;                        /* air and soft tissue of a CT at their Hounsfield units */
    bool is_label_map;                         /* it is known to be one, and is looked up without interpolation */
    const json_t *segments;                    /* names and colors of its labels; borrowed, or NULL */
    size_t label_count;                        /* values of a label map, or of what looks like one, ascending; 0: none */
    double labels[ISO_SURVEY_LABELS];          /* of what looks like one without the padding */
    double quantile[ISO_SURVEY_QUANTILES + 1]; /* of what is no padding */

    double lo, hi;        /* of the bins; equal for a volume of one value */
    uint64_t voxel_count; /* in the bins */
    uint64_t count[ISO_SURVEY_BINS];
    uint64_t face[ISO_SURVEY_BINS];                     /* of the voxels at the box's faces */
    uint64_t face_count, face_padding;                  /* all of them; those that are padding */
    uint64_t joint[ISO_SURVEY_BINS][ISO_SURVEY_SLOPES]; /* by iso_survey_slope() */
    double flat[ISO_SURVEY_BINS];                       /* voxels of small magnitude, smoothed */
    double slope[ISO_SURVEY_BINS]; /* mean magnitude on the isosurface, in value a voxel, smoothed */

    bool has_background;
    double background, background_lo, background_hi; /* its peak and where it ends */
} iso_survey;

/* Of level 0. ISO_E_MEMORY; ISO_E_RANGE for a level without its scalar. To be freed by free(). */
iso_status iso_survey_make(const iso_level *level0, int threads, iso_survey **survey, iso_error *err);

/* The value below which that part, 0 to 1, of the voxels lies. */
double iso_survey_quantile(const iso_survey *s, double part);
/* The value at the middle of a bin, and the bin of a value. */
double iso_survey_value(const iso_survey *s, double bin);
int iso_survey_bin(const iso_survey *s, double value);
/* The magnitude, in value a voxel, that bin `slope` of the second axis stands for. */
double iso_survey_slope(const iso_survey *s, double slope);

#endif

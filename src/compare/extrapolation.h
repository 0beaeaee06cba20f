/* SPDX-License-Identifier: MIT */
/* extrapolation.h - the limit of a renderer's images as its step shrinks, from images at two steps, with error bars.
 *
 * The error of an image at step h is c h^p, so images at the steps h and 2h give the limit (Richardson extrapolation)
 * and how far the image at h is from it: its error bar. A renderer with random numbers is run with several seeds at
 * each step; each seed gives a limit, and the standard error of their mean is part of the bar. The renderer is right
 * if its limit is the reference, within the bar, for the whole image and for each pixel (compare/statistics.h).
 *
 * Only images and numbers: validate/limits.h runs the renderers and chooses the steps. Tolerances that a person sets
 * are iso_tolerances (compare/metrics.h). */
#pragma once

#include "compare/statistics.h"
#include "image/image.h"

/* ---- Richardson extrapolation ------------------------------------------------- */

typedef struct iso_extrapolation {
    double error_bar;     /* RMSE of the finer image against the limit */
    double error_bar_max; /* the largest of it */
} iso_extrapolation;

/* Creates limit = fine + (fine - coarse) / (ratio^order - 1); ratio: coarse step over fine step, above 1. ISO_E_RANGE:
 * sizes, ratio or order. Non-finite pixels make the bar infinite. */
iso_status iso_richardson(const iso_image *coarse, const iso_image *fine, double ratio, double order, iso_image *limit,
                          iso_extrapolation *out, iso_error *err);

/* ---- several seeds ------------------------------------------------------------- */

enum { ISO_EXTRAPOLATION_MAX_SEEDS = 32 };

/* The noise of a mean over seeds: its mean square over pixels and channels, and the standard error of that. */
typedef struct iso_extrapolated_noise {
    double square, uncertainty;
} iso_extrapolated_noise;

typedef struct iso_extrapolated {
    iso_image image;                                 /* the limit: the mean over the seeds */
    iso_image fine;                                  /* at step_voxels; mean over the seeds */
    double step_voxels;                              /* the finer of the last two */
    size_t planes, intervals;                        /* of a renderer with intervals there; 0 for others */
    double coarse_rmse, fine_rmse;                   /* against the reference, of the means */
    double rmse, ssim_dissimilarity, flip_mean;      /* of the limit against the reference */
    double order;                                    /* observed: log2 (coarse_rmse / fine_rmse) */
    double step_bar;                                 /* RMSE of `fine` against the limit */
    double noise_bar;                                /* standard error of the limit over the seeds */
    iso_extrapolated_noise coarse_noise, fine_noise; /* of the means at both steps; 0 if nothing is random */
    double bar;                                      /* the error bar: both together, times the factor */
    double allowed;                                  /* RMSE to the reference: the bar, and rounding */
    size_t seeds;                                    /* 1: the renderer is not random, and `noise` is not filled */
    iso_noise_test noise;                            /* tests the seeds' limits against the reference */
    bool unfinished;                                 /* by validate/limits.h: its time was over before it was good */
    size_t kept_count;                               /* 0, or with `keep` the seeds and 1 ... */
    iso_image *kept; /* ... the limit of each seed, and how far the step's error goes at each value */
} iso_extrapolated;

/* Order of the method: second, so halving the step leaves a quarter of the error. The bends of a TF fall anywhere
 * between samples, so that single halvings leave less or more. Validation allows the square root of two times a
 * quarter. */
#define ISO_EXTRAPOLATION_ORDER 2.0
/* An error bar is the difference between the fine image and the limit, times a factor of safety, as in the grid
 * convergence index of [roache-1994], who takes 3 for two grids. Suppose the errors at the two steps, r e and e, are
 * independent of each other. Then the limit is off by sqrt(r^2 + 16) / 3 e, and differs from the fine image by
 * sqrt(r^2 + 1) / 3 e. The first is 1.4 times the second for r = 4, and 1.6 times for the smallest r that passes with
 * smooth TFs. A TF that the step does not resolve has first order, r = 2, and a ratio of 2. */
#define ISO_EXTRAPOLATION_FACTOR_SMOOTH 2.0
#define ISO_EXTRAPOLATION_FACTOR_SHARP 2.5
/* The rounding of 16 bits per channel (POV-Ray) and of single precision. */
#define ISO_EXTRAPOLATION_ROUNDING 1e-5
/* Significance of the tests of all pixels and channels of an image together, and of that of its bias. */
#define ISO_EXTRAPOLATION_SIGNIFICANCE 1e-3

void iso_extrapolated_destroy(iso_extrapolated *limit); /* accepts a zeroed one */

/* The reference itself may move to and fro with the last bit of single precision of its eye. A renderer need not be
 * more exact than that. The excuse is at most a step of 8 bits. If more than half a percent of all values would need
 * one, none is given. */
#define ISO_EXTRAPOLATION_EXCUSE_MOST (1.0 / 255)
#define ISO_EXTRAPOLATION_EXCUSE_PART 5e-3

/* Images to extrapolate: `seeds` images at the double step, followed by `seeds` images at the step; at most
 * ISO_EXTRAPOLATION_MAX_SEEDS. */
typedef struct iso_extrapolation_input {
    const iso_image *images;
    size_t seeds;
    const iso_image *reference;
    double factor;             /* ISO_EXTRAPOLATION_FACTOR_... */
    const iso_image *unsteady; /* how far each value of the reference moves with its eye; or NULL: none is excused */
    bool keep;                 /* True if iso_extrapolated_compare() will follow */
} iso_extrapolation_input;

/* Fills *out but for step_voxels, planes, intervals and seeds, which the caller sets. */
iso_status iso_extrapolate(const iso_extrapolation_input *of, iso_extrapolated *out, iso_error *err);

/* Creates the image of the limit alone: the mean over the seeds. */
iso_status iso_extrapolate_image(const iso_image *images, size_t seeds, iso_image *limit, iso_error *err);

/* The differences between two kept limits of several seeds, by the same tests as one and a reference. */
typedef struct iso_extrapolated_change {
    double largest, noise;          /* of a value, and the standard error of the difference there */
    size_t column, row, channel;    /* place of the largest */
    iso_noise_test test;            /* of the differences seed by seed: those of equal images are 0 */
} iso_extrapolated_change;
/* Compares two limits. ISO_E_RANGE: not kept, or of other sizes or numbers of seeds. */
iso_status iso_extrapolated_compare(const iso_extrapolated *a, const iso_extrapolated *b, iso_extrapolated_change *out,
                                    iso_error *err);

/* Returns the part of `allowed` that limits the image as a whole: without the noise's part of the error bar. A fault
 * of the whole image shows below the noise of its pixels, since noise is subtracted in squares from the error that
 * halving leaves. It does not show far below, so a tenth of `allowed` is the least. */
double iso_extrapolated_held_to(const iso_extrapolated *limit);

/* Returns the part of the error that is left after halving the step, about 1/4; rounding and noise are subtracted. 0
 * if no error is left. */
double iso_extrapolated_error_left(const iso_extrapolated *limit);

/* SPDX-License-Identifier: MIT */
/* limits.h - where a renderer's image goes as its ray step shrinks, and how far that is known.
 *
 * Two steps h and 2h, of second order: the limit (Richardson), and the error bar of
 * the finer image. A renderer that puts its steps at random phases is run with several
 * seeds, each gives a limit of its own, and their mean has a standard error, which
 * the bar includes and by which each pixel is tested (compare/statistics.h). While
 * the bar is wider than wanted, the error does not fall at its order, the limit
 * is out of its bars, or a person would see it, the step is halved: what is right
 * gets there, sooner where many pixels show it, and what is wrong is the farther out. */
#ifndef ISO_VALIDATE_LIMITS_H
#define ISO_VALIDATE_LIMITS_H

#include "renderers/renderers.h"
#include "compare/statistics.h"

typedef struct iso_limit_options {
    double step_voxels;   /* the finer of the first two, in the level's smallest spacing */
    double finest_voxels; /* where halving ends */
    double wanted_bar;    /* RMSE, factor included */
    double factor;        /* of safety: ISO_LIMIT_FACTOR_... */
    double wanted_left;   /* of the error, by halving the step: iso_limit_left() */
    double hopeless;      /* so many bars off, of an error that halving hardly changes, end the halving; INFINITY: never */
    double wanted_ssim_dissimilarity, wanted_flip; /* of the limit; 0: not asked for */
    size_t seeds;         /* of random renderers, at least 2 */
    size_t planes, intervals; /* of renderers with intervals at the step; at its double half; 0 intervals: by the step */
    int first_seed, threads;
} iso_limit_options;
/* h = 1/4 and not below 1/64, 4 seeds, bars of 1/2550, a factor of 2; 0.354 left by halving; nothing is hopeless. */
iso_limit_options iso_limit_defaults(void);

/* What chance leaves in the mean over the seeds: mean square over pixels and channels, and its standard error. */
typedef struct iso_limit_noise {
    double square, uncertainty;
} iso_limit_noise;

typedef struct iso_limit {
    iso_image image;               /* the limit; mean over the seeds */
    iso_image fine;                /* at step_voxels; mean over the seeds */
    double step_voxels;            /* the finer of the last two */
    size_t planes, intervals;      /* of a renderer with intervals there; else 0 */
    double coarse_rmse, fine_rmse; /* against the reference, of the means */
    double rmse, ssim_dissimilarity, flip_mean; /* of the limit against the reference */
    double order;                  /* log2 (coarse_rmse / fine_rmse) */
    double step_bar, noise_bar;    /* RMSE of `fine` to the limit; standard error of the limit; of RGB and alpha */
    iso_limit_noise coarse_noise, fine_noise; /* of the means at both steps; 0 where nothing is random */
    double bar;                    /* the error bar: both, times the factor */
    double allowed;                /* RMSE: the bar, and rounding */
    size_t seeds;                  /* 1: nothing is random, and noise is not filled */
    iso_noise_test noise;          /* of the seeds' limits against the reference */
} iso_limit;

/* Second order halves to a quarter. The TF's bends fall anywhere between the samples, so that single halvings do
 * better or worse: what is left is asked to be at most half a power more. */
#define ISO_LIMIT_ORDER 2.0
/* A bar is the difference of fine image and limit, times a factor of safety: as in the grid convergence index of
 * [roache-1994], who takes 3 for two grids. Errors
 * of the two steps that are independent of each other, r e and e, leave sqrt(r^2 + 16) / 3 e in the limit, at a
 * difference of sqrt(r^2 + 1) / 3 e: 1.4 times that for r = 4, and 1.6 for the least that is let pass of smooth TFs.
 * A TF that a step does not resolve is of first order, r = 2, and then 2 times that off. */
#define ISO_LIMIT_FACTOR_SMOOTH 2.0
#define ISO_LIMIT_FACTOR_SHARP 2.5
/* What 16 bits a channel (POV-Ray) and single precision leave. */
#define ISO_LIMIT_ROUNDING 1e-5
/* Of all pixels and channels of an image together, and of its bias. */
#define ISO_LIMIT_SIGNIFICANCE 1e-3

/* what: a level and a view; its options are chosen here, and may be NULL.
 * Pixels that are not finite make the bar infinite, and all pixels of a random renderer beyond chance: a limit that fails its gates.
 * Release with iso_limit_destroy(), which accepts a zeroed one. */
iso_status iso_limit_find(const iso_render_request *what, const iso_image *reference, const iso_renderer_info *which,
                          const iso_limit_options *opt, iso_limit *out, iso_error *err);
void iso_limit_destroy(iso_limit *limit);

/* The limit of images that are there: `seeds` of the double step, then `seeds` of the step, at most 32. Fills *out but
 * for its step and seeds, which the caller has set. */
iso_status iso_limit_extrapolate(const iso_image *images, size_t seeds, const iso_image *reference, double factor,
                                 iso_limit *out, iso_error *err);

/* The image of a limit alone, from opt->step_voxels and its double, created. With the step, seeds, planes and intervals of
 * a limit that was found, it is that limit's image. */
iso_status iso_limit_render(const iso_render_request *what, const iso_renderer_info *which, const iso_limit_options *opt,
                            iso_image *image, iso_error *err);

/* Halving leaves this part of the error, beyond rounding and noise (whose squares add up); about 1/4. 0 where nothing
 * is left to shrink. */
double iso_limit_left(const iso_limit *limit);

#endif

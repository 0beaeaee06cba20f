/* SPDX-License-Identifier: MIT */
/* statistics.h - whether the images of a random renderer differ from a reference by more than chance.
 *
 * The renderer is run with n seeds. The mean image is tested against the reference pixel by
 * pixel, and all tests together keep one significance [sidak-1967]; so is the mean over the image.
 * Errors of a finite step are the matter of extrapolation.h.
 * All four channels are tested: if volume and background are equal, only alpha differs. Results do not depend on
 * threads.
 *
 * Sensitivity of n images: Student's t has n - 1 degrees of freedom, whose tails are long if n is small. In a picture
 * of 32 x 32 pixels (4096 tests at 1e-3 together) a single one, by its own spread alone, is beyond chance when it is
 * off by 2023 standard errors for n = 3, by 208 for 4, 19.4 for 8, 8.85 for 16. So a pixel borrows from its neighbors:
 * with ISO_NOISE_NEIGHBORS more degrees of freedom, and the larger of its own variance and the mean of those around it,
 * 25.4, 19.4, 11.2 and 7.80 are enough. A bias (4 tests) needs 63.2, 20.6, 6.81 and 4.77 of its own standard errors,
 * which are smaller by the root of the number of pixels. The test assumes normal noise. With bounded noise (a step of
 * random phase) n values are equal more often, and false alarms are 2.7 times as frequent for n = 3 and 4.9 times for n
 * = 4 by the own spread; the neighbors, and the tolerance for the error of the step, cover that. */
#pragma once

#include <math.h>
#include <stdbool.h>

#include "image/image.h"

/* ---- noise ------------------------------------------------------------------ */

/* Means and variances of equal-sized images, added one by one [welford-1962]. */
typedef struct iso_samples {
    size_t width, height, count;
    double *mean, *squares; /* 4 a pixel: the mean, the sum of squared deviations */
    double bias_mean[4],
        bias_squares[4];        /* the same of each image's mean signed difference to the reference, by channel */
    const iso_image *reference; /* borrowed; must outlive the samples */
} iso_samples;

/* Creates empty samples. reference: the image that the mean is tested against. ISO_E_RANGE: empty; ISO_E_MEMORY. */
iso_status iso_samples_create(iso_samples *s, const iso_image *reference, iso_error *err);
void iso_samples_destroy(iso_samples *s);
/* Adds an image. ISO_E_RANGE: another size, or pixels that are not finite. */
iso_status iso_samples_add(iso_samples *s, const iso_image *image, iso_error *err);

/* Weight of the neighbors in a pixel's variance, in degrees of freedom. They are 24, in 5 x 5 pixels, but noise
 * differs from pixel to pixel. With 4, none of 640 threes and fours of seeds of Cycles was flagged
 * (doc/results/deviations.md). */
#define ISO_NOISE_NEIGHBORS 4.0

typedef struct iso_noise_options {
    double significance;
    double tolerance; /* a systematic difference that is allowed (discretization, rounding) of every pixel ... */
    const double *tolerances; /* ... and more of each, 4 a pixel; or NULL */
    const double *excuses;    /* more still, of pixels that are beyond chance without it; or NULL: none is excused */
    size_t most_excused;      /* if more would be, none is */
    double bias_tolerance;    /* of a channel's mean */
    double neighbors;         /* 0, or ISO_NOISE_NEIGHBORS */
} iso_noise_options;

typedef struct iso_noise_test {
    size_t tests;              /* one a pixel and channel */
    double smallest_p;         /* of all tests */
    double pixel_significance; /* Sidak: 1 - (1 - significance)^(1 / tests) */
    size_t rejected;           /* tests below it */
    size_t excused;            /* that would be, but for their excuses */
    double largest_excused;    /* largest excess of an excused test over its tolerance */
    double tolerance_median, tolerance_largest;
    size_t worst[2];         /* column, row of smallest_p */
    size_t bias_channel;     /* the one whose bias is least by chance; the largest if none exceeds the tolerance */
    double bias, bias_error; /* its mean signed difference, and its standard error over the images */
    double mean_abs;         /* mean of |difference of the means| */
    bool biased; /* a channel's bias beyond the tolerance and beyond chance, for the four at `significance` */
    bool passed; /* no test rejected, and not biased */
} iso_noise_test;

/* Tests mean = reference in every pixel and channel, two-sided, by Student's t with count - 1 degrees of freedom and
 * those of the neighbors. With the same significance it tests also that each channel's mean over the image is the
 * reference's: channels of opposite signs do not cancel.
 * Right images are flagged by chance at a rate of at most twice the significance: channels of a pixel go together, and
 * Sidak's bound holds for those as well. The excess over a tolerance is tested; if all samples are equal, the tolerance
 * alone decides.
 * ISO_E_RANGE: fewer than 2 images, significance not in (0, 1), a tolerance negative or NaN. ISO_E_MEMORY. */
iso_status iso_samples_test(const iso_samples *s, const iso_noise_options *opt, iso_noise_test *out, iso_error *err);

/* Returns P(|T| >= t) of Student's distribution. */
double iso_student_two_sided(double t, double degrees_of_freedom);

/* Returns the larger of two differences; NaN stays NaN in all later comparisons. */
static inline double iso_larger(double worst, double difference)
{
    return worst >= difference || isnan(worst) ? worst : difference;
}

/* statistics.h - whether a difference is an error or only what was to be expected.
 *
 * Two kinds of expectation:
 *   noise           a renderer with a seed is run n times; its mean is tested
 *                   pixel by pixel against a reference, and all tests together
 *                   keep one significance (Sidak);
 *   discretisation  a renderer with a step h errs by c h^p: from two steps follow
 *                   the limit (Richardson) and how far the finer one is from it.
 * Only RGB is tested; alpha follows the same paths. Results do not depend on threads. */
#ifndef ISO_STATISTICS_H
#define ISO_STATISTICS_H

#include <stdbool.h>

#include "image/image.h"

/* ---- noise ------------------------------------------------------------------ */

/* Means and variances of equal-sized images, added one by one (Welford 1962). */
typedef struct iso_samples {
    size_t width, height, count;
    double *mean, *squares;       /* 3 a pixel: the mean, the sum of squared deviations */
    double bias_mean, bias_squares; /* the same of each image's mean signed difference to the reference */
    const iso_image *reference;     /* borrowed; must outlive the samples */
} iso_samples;

/* reference: what the mean is tested against. ISO_E_RANGE: empty; ISO_E_MEMORY. */
iso_status iso_samples_create(iso_samples *s, const iso_image *reference, iso_error *err);
void iso_samples_destroy(iso_samples *s);
/* ISO_E_RANGE: another size, or pixels that are not finite. */
iso_status iso_samples_add(iso_samples *s, const iso_image *image, iso_error *err);

typedef struct iso_noise_test {
    size_t tests;             /* one a pixel and channel */
    double smallest_p;        /* of all tests */
    double pixel_significance; /* Sidak: 1 - (1 - significance)^(1 / tests) */
    size_t rejected;          /* tests below it */
    size_t worst[2];          /* column, row of smallest_p */
    double bias, bias_error;  /* mean signed difference, and its standard error over the images */
    double mean_abs;          /* mean of |difference of the means| */
    bool biased;              /* |bias| beyond chance at `significance` and beyond tolerance */
    bool passed;              /* no test rejected, and not biased */
} iso_noise_test;

/* Tests mean = reference in every pixel and channel, two-sided, by Student's t with count - 1 degrees of
 * freedom. tolerance: a systematic difference that is allowed (discretisation, rounding); what exceeds it is
 * tested, and where all samples are equal, the tolerance alone decides. ISO_E_RANGE: fewer than 2 images,
 * significance not in (0, 1), tolerance negative or NaN. */
iso_status iso_samples_test(const iso_samples *s, double significance, double tolerance, iso_noise_test *out,
                            iso_error *err);

/* P(|T| >= t) of Student's distribution. */
double iso_student_two_sided(double t, double degrees_of_freedom);

/* ---- discretisation --------------------------------------------------------- */

typedef struct iso_extrapolation {
    double error_bar;     /* RMSE of the finer image against the limit */
    double error_bar_max; /* the largest of it */
} iso_extrapolation;

/* limit = fine + (fine - coarse) / (ratio^order - 1), created; ratio: coarse step over fine step, above 1.
 * ISO_E_RANGE: sizes, ratio or order. Non-finite pixels make the bar infinite. */
iso_status iso_richardson(const iso_image *coarse, const iso_image *fine, double ratio, double order, iso_image *limit,
                          iso_extrapolation *out, iso_error *err);

/* The order that three images at steps h, h / ratio, h / ratio^2 show: log |a - b| / |b - c| to that base,
 * in RMSE. NaN when the finer two are equal. */
iso_status iso_observed_order(const iso_image *a, const iso_image *b, const iso_image *c, double ratio, double *order,
                              iso_error *err);

/* Two limits agree when their RMSE is at most `factor` times the root of the summed squares of their bars,
 * plus floor (what rounding adds). NaN never agrees. */
bool iso_limits_agree(double rmse, double bar_a, double bar_b, double factor, double floor);

#endif

/* SPDX-License-Identifier: MIT */
#include "compare/statistics.h"

#include <math.h>
#include <stdlib.h>

#include "base/order.h"

/* ---- Student's distribution ----------------------------------------------- */

/* Returns the continued fraction of the incomplete beta function (Abramowitz and Stegun 26.5.8), by the method of Lentz
 * in Thompson and Barnett's form; converges fast for x < (a + 1) / (a + b + 2). */
static double beta_fraction(double a, double b, double x)
{
    const double tiny = 1e-300;
    double c = 1, d = 1 - (a + b) * x / (a + 1);
    d = 1 / (fabs(d) < tiny ? tiny : d);
    double value = d;
    for (int m = 1; m <= 300; ++m) {
        double even = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m));
        double odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1));
        double step = 1;
        for (int k = 0; k < 2; ++k) {
            double term = k ? odd : even;
            d = 1 + term * d;
            c = 1 + term / c;
            d = 1 / (fabs(d) < tiny ? tiny : d);
            c = fabs(c) < tiny ? tiny : c;
            value *= step = c * d;
        }
        if (fabs(step - 1) < 1e-15)
            break;
    }
    return value;
}

/* Returns the regularized incomplete beta function I_x(a, b). */
static double incomplete_beta(double a, double b, double x)
{
    if (!(x > 0))
        return x <= 0 ? 0 : NAN;
    if (x >= 1)
        return 1;
    double front = exp(lgamma(a + b) - lgamma(a) - lgamma(b) + a * log(x) + b * log1p(-x));
    if (x < (a + 1) / (a + b + 2))
        return front * beta_fraction(a, b, x) / a;
    return 1 - front * beta_fraction(b, a, 1 - x) / b;
}

double iso_student_two_sided(double t, double degrees_of_freedom)
{
    if (isinf(t))
        return 0;
    return incomplete_beta(degrees_of_freedom / 2, 0.5, degrees_of_freedom / (degrees_of_freedom + t * t));
}

/* ---- noise ------------------------------------------------------------------ */

iso_status iso_samples_create(iso_samples *s, const iso_image *reference, iso_error *err)
{
    *s = (iso_samples){.width = reference->width, .height = reference->height, .reference = reference};
    size_t count = 4 * s->width * s->height;
    if (count == 0)
        return iso_fail(err, ISO_E_RANGE, "statistics: the reference is empty");
    if (!iso_image_is_finite(reference))
        return iso_fail(err, ISO_E_RANGE, "statistics: the reference has pixels that are not finite");
    s->mean = calloc(count, sizeof *s->mean);
    s->squares = calloc(count, sizeof *s->squares);
    if (s->mean && s->squares)
        return ISO_OK;
    iso_samples_destroy(s);
    return iso_fail(err, ISO_E_MEMORY, "statistics: no memory for %zu values", 2 * count);
}

void iso_samples_destroy(iso_samples *s)
{
    if (!s)
        return;
    free(s->mean);
    free(s->squares);
    *s = (iso_samples){0};
}

/* Adds the n-th value to a mean and a sum of squared deviations. */
static void add_sample(double x, double n, double *mean, double *squares)
{
    double d = x - *mean;
    *mean += d / n;
    *squares += d * (x - *mean);
}

iso_status iso_samples_add(iso_samples *s, const iso_image *image, iso_error *err)
{
    if (image->width != s->width || image->height != s->height)
        return iso_fail(err, ISO_E_RANGE, "statistics: an image has %zux%zu pixels, the reference %zux%zu",
                        image->width, image->height, s->width, s->height);
    if (!iso_image_is_finite(image))
        return iso_fail(err, ISO_E_RANGE, "statistics: image %zu has pixels that are not finite", s->count);
    double n = (double)++s->count, bias[4] = {0};
    size_t pixels = s->width * s->height;
    for (size_t i = 0; i < 4 * pixels; ++i) {
        double x = image->rgba[i];
        add_sample(x, n, &s->mean[i], &s->squares[i]);
        bias[i % 4] += x - s->reference->rgba[i];
    }
    for (size_t c = 0; c < 4; ++c)
        add_sample(bias[c] / (double)pixels, n, &s->bias_mean[c], &s->bias_squares[c]);
    return ISO_OK;
}

/* Returns p of a difference with a given standard error: only the excess over the tolerance counts. */
static double p_value(double difference, double error, double tolerance, double degrees_of_freedom)
{
    double excess = fabs(difference) - tolerance;
    if (!(excess > 0))
        return 1;
    return error > 0 ? iso_student_two_sided(excess / error, degrees_of_freedom) : 0;
}

/* Sidak's correction [sidak-1967]: the tests together keep one significance. -expm1(log1p) keeps its digits. */
static double sidak(double significance, size_t tests)
{
    return -expm1(log1p(-significance) / (double)tests);
}

/* Returns the variance for a value's test: the larger of its own and that of the same channel in the 5 x 5 pixels
 * around. A few images that are equal by chance do not make a value certain, nor do calm neighbors. */
static double variance_of(const iso_samples *s, size_t i)
{
    const long width = (long)s->width, height = (long)s->height, column = (long)(i / 4) % width,
               row = (long)(i / 4) / width;
    double sum = 0, count = 0;
    for (long y = row > 2 ? row - 2 : 0; y <= row + 2 && y < height; ++y)
        for (long x = column > 2 ? column - 2 : 0; x <= column + 2 && x < width; ++x)
            if (x != column || y != row) {
                sum += s->squares[4 * (size_t)(y * width + x) + i % 4];
                count += 1;
            }
    return fmax(s->squares[i], count > 0 ? sum / count : 0) / (double)(s->count - 1);
}

static void sum_up_tolerances(const iso_noise_options *opt, double *sorted, iso_noise_test *out)
{
    for (size_t i = 0; i < out->tests; ++i)
        sorted[i] = opt->tolerance + (opt->tolerances ? opt->tolerances[i] : 0);
    qsort(sorted, out->tests, sizeof *sorted, iso_order_doubles);
    out->tolerance_median = sorted[out->tests / 2];
    out->tolerance_largest = sorted[out->tests - 1];
}

static void test_pixels(const iso_samples *s, const iso_noise_options *opt, iso_noise_test *out)
{
    const double n = (double)s->count, freedom = n - 1 + opt->neighbors;
    for (size_t i = 0; i < out->tests; ++i) {
        const double d = s->mean[i] - s->reference->rgba[i];
        const double tolerance = opt->tolerance + (opt->tolerances ? opt->tolerances[i] : 0);
        const double variance = opt->neighbors > 0 ? variance_of(s, i) : s->squares[i] / (n - 1);
        double p = p_value(d, sqrt(variance / n), tolerance, freedom);
        out->mean_abs += fabs(d) / (double)out->tests;
        if (p < out->pixel_significance && opt->excuses) {
            const double excused = p_value(d, sqrt(variance / n), tolerance + opt->excuses[i], freedom);
            if (excused >= out->pixel_significance) {
                out->excused += 1;
                out->largest_excused = fmax(out->largest_excused, fabs(d) - tolerance);
                p = excused;
            }
        }
        out->rejected += p < out->pixel_significance;
        if (p < out->smallest_p) {
            out->smallest_p = p;
            out->worst[0] = i / 4 % s->width;
            out->worst[1] = i / 4 / s->width;
        }
    }
    if (out->excused > opt->most_excused)
        out->rejected += out->excused;
}

static void test_bias(const iso_samples *s, double significance, double tolerance, iso_noise_test *out)
{
    const double n = (double)s->count, freedom = n - 1;
    double smallest_p = 2;
    for (size_t c = 0; c < 4; ++c) {
        double error = sqrt(s->bias_squares[c] / freedom / n), p = p_value(s->bias_mean[c], error, tolerance, freedom);
        if (p < smallest_p || (p == smallest_p && fabs(s->bias_mean[c]) > fabs(out->bias))) {
            smallest_p = p;
            out->bias_channel = c;
            out->bias = s->bias_mean[c];
            out->bias_error = error;
        }
    }
    out->biased = smallest_p < sidak(significance, 4);
}

iso_status iso_samples_test(const iso_samples *s, const iso_noise_options *opt, iso_noise_test *out, iso_error *err)
{
    if (s->count < 2)
        return iso_fail(err, ISO_E_RANGE, "statistics: %zu images, at least 2 are needed", s->count);
    if (!(opt->significance > 0 && opt->significance < 1))
        return iso_fail(err, ISO_E_RANGE, "statistics: significance is %g, must be between 0 and 1", opt->significance);
    if (!(opt->tolerance >= 0 && opt->bias_tolerance >= 0))
        return iso_fail(err, ISO_E_RANGE, "statistics: tolerances are %g and %g, must be at least 0", opt->tolerance,
                        opt->bias_tolerance);
    *out = (iso_noise_test){.tests = 4 * s->width * s->height, .smallest_p = 1};
    double *sorted = malloc(out->tests * sizeof *sorted);
    NEED_MEMORY(sorted, err, "statistics: no memory for %zu values", out->tests);
    sum_up_tolerances(opt, sorted, out);
    free(sorted);
    out->pixel_significance = sidak(opt->significance, out->tests);
    test_pixels(s, opt, out);
    test_bias(s, opt->significance, opt->bias_tolerance, out);
    out->passed = out->rejected == 0 && !out->biased;
    return ISO_OK;
}

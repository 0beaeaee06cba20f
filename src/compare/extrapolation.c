/* SPDX-License-Identifier: MIT */
#include "compare/extrapolation.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "compare/metrics.h"

/* ---- Richardson extrapolation ------------------------------------------------- */

static iso_status check_pair(const iso_image *a, const iso_image *b, double ratio, iso_error *err)
{
    if (a->width * a->height == 0 || a->width != b->width || a->height != b->height)
        return iso_fail(err, ISO_E_RANGE, "extrapolation: images of %zux%zu and %zux%zu pixels", a->width, a->height,
                        b->width, b->height);
    if (!(ratio > 1 && ratio <= 1e6))
        return iso_fail(err, ISO_E_RANGE, "extrapolation: the steps' ratio is %g, must be above 1", ratio);
    return ISO_OK;
}

iso_status iso_richardson(const iso_image *coarse, const iso_image *fine, double ratio, double order, iso_image *limit,
                          iso_extrapolation *out, iso_error *err)
{
    NEED(check_pair(coarse, fine, ratio, err));
    if (!(order > 0 && order <= 16))
        return iso_fail(err, ISO_E_RANGE, "extrapolation: order is %g, must be above 0 and at most 16", order);
    NEED(iso_image_create(limit, fine->width, fine->height, err));
    double scale = 1 / (pow(ratio, order) - 1), squares = 0;
    size_t count = 4 * fine->width * fine->height;
    *out = (iso_extrapolation){0};
    for (size_t i = 0; i < count; ++i) {
        double step = scale * ((double)fine->rgba[i] - (double)coarse->rgba[i]);
        limit->rgba[i] = (float)(fine->rgba[i] + step);
        squares += isfinite(step) ? step * step : INFINITY;
        out->error_bar_max = isfinite(step) ? fmax(out->error_bar_max, fabs(step)) : INFINITY;
    }
    out->error_bar = sqrt(squares / (double)count);
    return ISO_OK;
}

/* ---- several seeds ------------------------------------------------------------- */

void iso_extrapolated_destroy(iso_extrapolated *limit)
{
    iso_image_destroy(&limit->image);
    iso_image_destroy(&limit->fine);
    for (size_t i = 0; i < limit->kept_count; ++i)
        iso_image_destroy(&limit->kept[i]);
    free(limit->kept);
    *limit = (iso_extrapolated){0};
}

/* Returns the square of an RMSE less the part that chance alone leaves in it, within three of its own standard
 * errors. */
static double without_noise(double rmse, double noise_square, double uncertainty)
{
    return fmax(rmse * rmse - noise_square - 3 * uncertainty, 0);
}

double iso_extrapolated_error_left(const iso_extrapolated *l)
{
    const double fine = sqrt(without_noise(l->fine_rmse, l->fine_noise.square, l->fine_noise.uncertainty)) -
                        ISO_EXTRAPOLATION_ROUNDING;
    const double coarse = sqrt(without_noise(l->coarse_rmse, l->coarse_noise.square, 0));
    if (isnan(l->fine_rmse) || isnan(l->coarse_rmse))
        return NAN;
    return fine <= 0 ? 0 : fine / coarse; /* infinite if there was no error before */
}

double iso_extrapolated_held_to(const iso_extrapolated *l)
{
    /* The step's bar is a third of the difference between the two means, whose noises add up in squares. */
    const double chance = (l->coarse_noise.square + l->fine_noise.square) / 9, both = hypot(l->step_bar, l->noise_bar),
                 factor = both > 0 ? l->bar / both : 0, step = sqrt(fmax(l->step_bar * l->step_bar - chance, 0));
    return isfinite(l->allowed) ? fmax(factor * step + ISO_EXTRAPOLATION_ROUNDING, l->allowed / 10) : l->allowed;
}

static void mean_of(const iso_image *images, size_t count, iso_image *mean)
{
    for (size_t i = 0; i < 4 * mean->width * mean->height; ++i) {
        double sum = 0;
        for (size_t k = 0; k < count; ++k)
            sum += (double)images[k].rgba[i];
        mean->rgba[i] = (float)(sum / (double)count);
    }
}

/* Creates the means over the seeds of each half of images. */
static iso_status mean_pair(const iso_image *images, size_t seeds, iso_image *coarse, iso_image *fine, iso_error *err)
{
    NEED(iso_image_create(coarse, images[0].width, images[0].height, err));
    NEED(iso_image_create(fine, images[0].width, images[0].height, err));
    mean_of(images, seeds, coarse);
    mean_of(images + seeds, seeds, fine);
    return ISO_OK;
}

/* Returns the mean square error of the mean, over pixels and all four channels, and its uncertainty. Alpha may be
 * noisier than the colors if volume and background are equal. A variance from n samples has a variance of 2 / (n -
 * 1) times its square; the channels of a pixel err together. */
static iso_extrapolated_noise noise_of_mean(const iso_image *images, size_t n, const iso_image *mean)
{
    const size_t pixels = mean->width * mean->height;
    double sum = 0, squares = 0;
    for (size_t i = 0; i < pixels; ++i) {
        double variance = 0;
        for (size_t c = 4 * i; c < 4 * i + 4; ++c)
            for (size_t k = 0; k < n; ++k) {
                double d = (double)images[k].rgba[c] - (double)mean->rgba[c];
                variance += d * d / (double)((n - 1) * n);
            }
        sum += variance;
        squares += 2 * variance * variance / (double)(n - 1);
    }
    return (iso_extrapolated_noise){sum / (double)(4 * pixels), sqrt(squares) / (double)(4 * pixels)};
}

/* Measures the step's error at each value: the change by halving the step, in any seed, in the 3 x 3 pixels around
 * it, times the factor. Each seed counts by itself, since the means may be equal at both steps by chance. The
 * neighbors count, since one pixel's samples may miss a bend of the TF at both steps. */
static void measure_tolerances(const iso_extrapolation_input *of, const iso_image *limits, double *tolerances)
{
    const size_t width = of->reference->width, height = of->reference->height;
    for (size_t i = 0; i < 4 * width * height; ++i)
        tolerances[i] = 0;
    for (size_t i = 0; i < 4 * width * height; ++i) {
        const size_t column = i / 4 % width, row = i / 4 / width;
        double change = 0;
        for (size_t k = 0; k < of->seeds; ++k)
            change = fmax(change, fabs((double)limits[k].rgba[i] - (double)of->images[of->seeds + k].rgba[i]));
        for (size_t y = row > 0 ? row - 1 : 0; y <= row + 1 && y < height; ++y)
            for (size_t x = column > 0 ? column - 1 : 0; x <= column + 1 && x < width; ++x) {
                double *t = &tolerances[4 * (y * width + x) + i % 4];
                *t = fmax(*t, of->factor * change);
            }
    }
}

/* Tests each seed's limit as one sample. A systematic difference is allowed as far as the step's own error goes around
 * a pixel; the mean over the image hides no single pixel, and is held to the step's difference itself. */
static iso_status test_noise(const iso_extrapolation_input *of, const iso_image *limits, iso_extrapolated *out,
                             iso_error *err)
{
    OWNED(iso_samples) samples = {0};
    const size_t count = 4 * of->reference->width * of->reference->height;
    if (!isfinite(out->step_bar)) { /* pixels that are not finite: the row differs, and the others go on */
        out->noise_bar = INFINITY;
        out->noise.rejected = out->noise.tests = count;
        return ISO_OK;
    }
    iso_status status = iso_samples_create(&samples, of->reference, err);
    double *tolerances = malloc(2 * count * sizeof *tolerances), *excuses = tolerances ? tolerances + count : NULL;
    if (status == ISO_OK && !tolerances)
        status = iso_fail(err, ISO_E_MEMORY, "extrapolation: no memory for %zu values", 2 * count);
    for (size_t i = 0; i < of->seeds && status == ISO_OK; ++i)
        status = iso_samples_add(&samples, &limits[i], err);
    if (status == ISO_OK) {
        out->noise_bar = sqrt(noise_of_mean(limits, of->seeds, &out->image).square);
        measure_tolerances(of, limits, tolerances);
        for (size_t i = 0; of->unsteady && i < count; ++i)
            excuses[i] = fmin((double)of->unsteady->rgba[i], ISO_EXTRAPOLATION_EXCUSE_MOST);
        const iso_noise_options o = {.significance = ISO_EXTRAPOLATION_SIGNIFICANCE,
                                     .tolerance = ISO_EXTRAPOLATION_ROUNDING,
                                     .tolerances = tolerances,
                                     .excuses = of->unsteady ? excuses : NULL,
                                     .most_excused = (size_t)(ISO_EXTRAPOLATION_EXCUSE_PART * (double)count),
                                     .bias_tolerance = out->step_bar + ISO_EXTRAPOLATION_ROUNDING,
                                     .neighbors = ISO_NOISE_NEIGHBORS};
        status = iso_samples_test(&samples, &o, &out->noise, err);
    }
    free(tolerances);
    return status;
}

/* Moves the limits. */
static iso_status keep_limits(const iso_extrapolation_input *of, iso_image *limits, iso_extrapolated *out,
                              iso_error *err)
{
    const size_t width = of->reference->width, height = of->reference->height;
    FREED double *tolerances = malloc(4 * width * height * sizeof *tolerances);
    out->kept = calloc(of->seeds + 1, sizeof *out->kept);
    NEED(tolerances && out->kept ? iso_image_create(&out->kept[of->seeds], width, height, err)
                                 : iso_fail(err, ISO_E_MEMORY, "extrapolation: out of memory"));
    measure_tolerances(of, limits, tolerances);
    for (size_t i = 0; i < 4 * width * height; ++i)
        out->kept[of->seeds].rgba[i] = (float)tolerances[i];
    memcpy(out->kept, limits, of->seeds * sizeof *limits);
    memset(limits, 0, of->seeds * sizeof *limits);
    out->kept_count = of->seeds + 1;
    return ISO_OK;
}

static iso_status rmse_of(const iso_image *a, const iso_image *b, double *rmse, iso_error *err)
{
    iso_metrics m = {0};
    NEED(iso_metrics_measure(a, b, &m, err));
    *rmse = m.rmse;
    return ISO_OK;
}

iso_status iso_extrapolate(const iso_extrapolation_input *of, iso_extrapolated *out, iso_error *err)
{
    const iso_image *const images = of->images, *const reference = of->reference;
    const size_t seeds = of->seeds;
    iso_image limits[ISO_EXTRAPOLATION_MAX_SEEDS] = {{0}}, coarse = {0};
    iso_extrapolation e = {0}, unused;
    iso_metrics limit = {0};
    iso_status status = mean_pair(images, seeds, &coarse, &out->fine, err);
    TRY(status, iso_richardson(&coarse, &out->fine, 2, ISO_EXTRAPOLATION_ORDER, &out->image, &e, err));
    out->step_bar = e.error_bar;
    TRY(status, rmse_of(&coarse, reference, &out->coarse_rmse, err));
    TRY(status, rmse_of(&out->fine, reference, &out->fine_rmse, err));
    TRY(status, iso_metrics_measure(&out->image, reference, &limit, err));
    out->rmse = limit.rmse, out->ssim_dissimilarity = 1 - limit.ssim, out->flip_mean = limit.flip_mean;
    for (size_t i = 0; i < seeds && seeds > 1 && status == ISO_OK; ++i)
        status = iso_richardson(&images[i], &images[seeds + i], 2, ISO_EXTRAPOLATION_ORDER, &limits[i], &unused, err);
    if (status == ISO_OK && seeds > 1)
        status = test_noise(of, limits, out, err);
    if (status == ISO_OK && seeds > 1) {
        out->coarse_noise = noise_of_mean(images, seeds, &coarse);
        out->fine_noise = noise_of_mean(images + seeds, seeds, &out->fine);
    }
    if (status == ISO_OK && of->keep && seeds > 1 && isfinite(out->step_bar))
        status = keep_limits(of, limits, out, err);
    out->order = log2(out->coarse_rmse / out->fine_rmse);
    out->bar = of->factor * hypot(out->step_bar, out->noise_bar);
    out->allowed = out->bar + ISO_EXTRAPOLATION_ROUNDING;
    for (size_t i = 0; i < ISO_EXTRAPOLATION_MAX_SEEDS; ++i)
        iso_image_destroy(&limits[i]);
    iso_image_destroy(&coarse);
    return status;
}

iso_status iso_extrapolate_image(const iso_image *images, size_t seeds, iso_image *limit, iso_error *err)
{
    OWNED(iso_image) coarse = {0}, fine = {0};
    iso_extrapolation unused;
    NEED(mean_pair(images, seeds, &coarse, &fine, err));
    return iso_richardson(&coarse, &fine, 2, ISO_EXTRAPOLATION_ORDER, limit, &unused, err);
}

/* ---- two limits ---------------------------------------------------------------- */

/* Computes b - a of a seed. */
static void subtract(const iso_image *a, const iso_image *b, iso_image *difference)
{
    for (size_t i = 0; i < 4 * a->width * a->height; ++i)
        difference->rgba[i] = b->rgba[i] - a->rgba[i];
}

static void find_largest(const iso_samples *s, iso_extrapolated_change *out)
{
    for (size_t i = 0; i < 4 * s->width * s->height; ++i)
        if (!(fabs(s->mean[i]) <= out->largest)) {
            out->largest = fabs(s->mean[i]);
            out->noise = sqrt(s->squares[i] / (double)(s->count * (s->count - 1)));
            out->column = i / 4 % s->width, out->row = i / 4 / s->width, out->channel = i % 4;
        }
}

static iso_status test_differences(const iso_extrapolated *a, const iso_extrapolated *b, iso_image *difference,
                                   iso_samples *samples, iso_extrapolated_change *out, iso_error *err)
{
    const size_t seeds = a->kept_count - 1, count = 4 * difference->width * difference->height;
    FREED double *tolerances = malloc(count * sizeof *tolerances);
    NEED_MEMORY(tolerances, err, "extrapolation: out of memory");
    for (size_t k = 0; k < seeds; ++k) {
        subtract(&a->kept[k], &b->kept[k], difference);
        NEED(iso_samples_add(samples, difference, err));
    }
    for (size_t i = 0; i < count; ++i)
        tolerances[i] = (double)a->kept[seeds].rgba[i] + (double)b->kept[seeds].rgba[i];
    const iso_noise_options o = {.significance = ISO_EXTRAPOLATION_SIGNIFICANCE,
                                 .tolerance = ISO_EXTRAPOLATION_ROUNDING,
                                 .tolerances = tolerances,
                                 .bias_tolerance = a->step_bar + b->step_bar + ISO_EXTRAPOLATION_ROUNDING,
                                 .neighbors = ISO_NOISE_NEIGHBORS};
    find_largest(samples, out);
    return iso_samples_test(samples, &o, &out->test, err);
}

iso_status iso_extrapolated_compare(const iso_extrapolated *a, const iso_extrapolated *b, iso_extrapolated_change *out,
                                    iso_error *err)
{
    OWNED(iso_samples) samples = {0};
    OWNED(iso_image) zero = {0}, difference = {0};
    *out = (iso_extrapolated_change){0};
    if (a->kept_count < 3 || a->kept_count != b->kept_count || a->image.width != b->image.width ||
        a->image.height != b->image.height)
        return iso_fail(err, ISO_E_RANGE, "extrapolation: two limits of %zu and %zu seeds cannot be compared", a->seeds,
                        b->seeds);
    NEED(iso_image_create(&zero, a->image.width, a->image.height, err));
    NEED(iso_image_create(&difference, zero.width, zero.height, err));
    memset(zero.rgba, 0, 4 * zero.width * zero.height * sizeof *zero.rgba);
    NEED(iso_samples_create(&samples, &zero, err));
    return test_differences(a, b, &difference, &samples, out, err);
}

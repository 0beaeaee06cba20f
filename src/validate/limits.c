/* SPDX-License-Identifier: MIT */
#include "validate/limits.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "compare/metrics.h"

enum { most_seeds = 32 };

iso_limit_options iso_limit_defaults(void)
{
    return (iso_limit_options){.step_voxels = 0.25, .finest_voxels = 1.0 / 64, .wanted_bar = 1.0 / 2550,
                               .factor = ISO_LIMIT_FACTOR_SMOOTH, .wanted_left = 0.354, .hopeless = INFINITY, .seeds = 4};
}

void iso_limit_destroy(iso_limit *limit)
{
    iso_image_destroy(&limit->image);
    iso_image_destroy(&limit->fine);
    *limit = (iso_limit){0};
}

/* The square of an RMSE less what chance alone leaves in it, within three of its own standard errors. */
static double without_noise(double rmse, double noise_square, double uncertainty)
{
    return fmax(rmse * rmse - noise_square - 3 * uncertainty, 0);
}

double iso_limit_left(const iso_limit *l)
{
    const double fine = sqrt(without_noise(l->fine_rmse, l->fine_noise.square, l->fine_noise.uncertainty)) - ISO_LIMIT_ROUNDING;
    const double coarse = sqrt(without_noise(l->coarse_rmse, l->coarse_noise.square, 0));
    if (isnan(l->fine_rmse) || isnan(l->coarse_rmse))
        return NAN;
    return fine <= 0 ? 0 : fine / coarse; /* infinite where there was no error before */
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

/* The means over the seeds of each half of images, created. */
static iso_status mean_pair(const iso_image *images, size_t seeds, iso_image *coarse, iso_image *fine, iso_error *err)
{
    iso_status status = iso_image_create(coarse, images[0].width, images[0].height, err);
    if (status == ISO_OK)
        status = iso_image_create(fine, images[0].width, images[0].height, err);
    if (status == ISO_OK) {
        mean_of(images, seeds, coarse);
        mean_of(images + seeds, seeds, fine);
    }
    return status;
}

/* The mean square error of the mean, over pixels and all four channels (the alpha of a picture may be noisier than its
 * colours, where volume and background are alike), and how well n images tell it: a variance from n samples has a
 * variance of 2 / (n - 1) times its square; the channels of a pixel err together. */
static iso_limit_noise noise_of_mean(const iso_image *images, size_t n, const iso_image *mean)
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
    return (iso_limit_noise){sum / (double)(4 * pixels), sqrt(squares) / (double)(4 * pixels)};
}

/* Each seed's limit is one sample. A systematic difference is allowed as far as the step's own error goes: a pixel's
 * as far as the largest; the mean over the image hides no single pixel, and is held to the step's difference itself. */
static iso_status test_noise(const iso_image *limits, size_t count, const iso_image *reference, double factor,
                             double largest_step_error, iso_limit *out, iso_error *err)
{
    iso_samples samples;
    if (!isfinite(out->step_bar)) { /* pixels that are no numbers: the row differs, and the others go on */
        out->noise_bar = INFINITY;
        out->noise.rejected = out->noise.tests = 4 * reference->width * reference->height;
        return ISO_OK;
    }
    iso_status status = iso_samples_create(&samples, reference, err);
    if (status != ISO_OK)
        return status;
    for (size_t i = 0; i < count && status == ISO_OK; ++i)
        status = iso_samples_add(&samples, &limits[i], err);
    out->noise_bar = sqrt(noise_of_mean(limits, count, &out->image).square);
    if (status == ISO_OK)
        status = iso_samples_test(&samples, ISO_LIMIT_SIGNIFICANCE, factor * largest_step_error + ISO_LIMIT_ROUNDING,
                                  out->step_bar + ISO_LIMIT_ROUNDING, &out->noise, err);
    iso_samples_destroy(&samples);
    return status;
}

static iso_status rmse_of(const iso_image *a, const iso_image *b, double *rmse, iso_error *err)
{
    iso_metrics m = {0};
    iso_status status = iso_metrics_measure(a, b, &m, err);
    *rmse = m.rmse;
    return status;
}

iso_status iso_limit_extrapolate(const iso_image *images, size_t seeds, const iso_image *reference, double factor,
                                 iso_limit *out, iso_error *err)
{
    iso_image limits[most_seeds] = {{0}}, coarse = {0};
    iso_extrapolation e = {0}, unused;
    iso_metrics limit = {0};
    iso_status status = mean_pair(images, seeds, &coarse, &out->fine, err);
    if (status == ISO_OK)
        status = iso_richardson(&coarse, &out->fine, 2, ISO_LIMIT_ORDER, &out->image, &e, err);
    out->step_bar = e.error_bar;
    if (status == ISO_OK)
        status = rmse_of(&coarse, reference, &out->coarse_rmse, err);
    if (status == ISO_OK)
        status = rmse_of(&out->fine, reference, &out->fine_rmse, err);
    if (status == ISO_OK)
        status = iso_metrics_measure(&out->image, reference, &limit, err);
    out->rmse = limit.rmse, out->ssim_dissimilarity = 1 - limit.ssim, out->flip_mean = limit.flip_mean;
    for (size_t i = 0; i < seeds && seeds > 1 && status == ISO_OK; ++i)
        status = iso_richardson(&images[i], &images[seeds + i], 2, ISO_LIMIT_ORDER, &limits[i], &unused, err);
    if (status == ISO_OK && seeds > 1)
        status = test_noise(limits, seeds, reference, factor, e.error_bar_max, out, err);
    if (status == ISO_OK && seeds > 1) {
        out->coarse_noise = noise_of_mean(images, seeds, &coarse);
        out->fine_noise = noise_of_mean(images + seeds, seeds, &out->fine);
    }
    out->order = log2(out->coarse_rmse / out->fine_rmse);
    out->bar = factor * hypot(out->step_bar, out->noise_bar);
    out->allowed = out->bar + ISO_LIMIT_ROUNDING;
    for (size_t i = 0; i < most_seeds; ++i)
        iso_image_destroy(&limits[i]);
    iso_image_destroy(&coarse);
    return status;
}

/* What a limit is taken from: `seeds` images at the double step, then `seeds` at the step. */
typedef struct step_pair {
    iso_render_options frames[2 * most_seeds];
    iso_image images[2 * most_seeds];
    size_t seeds;
} step_pair;

static void destroy_pair(step_pair *pair)
{
    for (size_t i = 0; i < 2 * pair->seeds; ++i)
        iso_image_destroy(&pair->images[i]);
}

/* Asks for a step and its double, so that the step can be halved twice more, or down to the finest. */
static void ask_steps(step_pair *pair, const iso_level *level, double step, double finest)
{
    const size_t n = pair->seeds;
    iso_render_options two[2] = {pair->frames[0], pair->frames[n]};
    iso_render_ask_steps(two[0].renderer, level, step, 2, fmin(fmax(step / finest, 1), 4), two);
    for (size_t i = 0; i < 2 * n; ++i) {
        const int seed = pair->frames[i].seed;
        pair->frames[i] = two[i / n];
        pair->frames[i].seed = seed;
    }
}

/* The frames of half the step. Where its double is what was the step, those images stay: always but where there would be more
 * intervals than the renderer takes. *first is the first frame that is to be rendered. */
static void halve(step_pair *pair, const iso_level *level, double step, double finest, size_t *first)
{
    const size_t n = pair->seeds;
    const size_t doubled = 2 * pair->frames[n].intervals; /* 0 where there are none */
    const bool stays = doubled <= pair->frames[n].renderer->max_intervals;
    for (size_t i = 0; i < n; ++i) {
        iso_image_destroy(&pair->images[i]);
        if (!stays)
            iso_image_destroy(&pair->images[n + i]);
        pair->images[i] = pair->images[n + i];
        pair->images[n + i] = (iso_image){0};
        pair->frames[i] = pair->frames[n + i];
        pair->frames[n + i].step_voxels = step;
        pair->frames[n + i].intervals = doubled;
    }
    if (!stays)
        ask_steps(pair, level, step, finest);
    *first = stays ? n : 0;
}

static void first_pair(step_pair *pair, const iso_level *level, const iso_renderer_info *which, const iso_limit_options *opt)
{
    *pair = (step_pair){.seeds = iso_renderer_has(which, ISO_IS_RANDOM) ? opt->seeds : 1};
    for (size_t i = 0; i < 2 * pair->seeds; ++i) {
        pair->frames[i] = iso_render_defaults(which);
        pair->frames[i].threads = opt->threads;
        pair->frames[i].seed = opt->first_seed + (int)(i % pair->seeds);
    }
    ask_steps(pair, level, opt->step_voxels, opt->finest_voxels);
    for (size_t i = 0; i < 2 * pair->seeds && which->max_intervals && opt->intervals; ++i) {
        pair->frames[i].planes = opt->planes;
        pair->frames[i].intervals = i < pair->seeds ? opt->intervals / 2 : opt->intervals;
    }
}

static iso_status check_seeds(const iso_limit_options *opt, iso_error *err)
{
    if (opt->seeds < 2 || opt->seeds > most_seeds)
        return iso_fail(err, ISO_E_RANGE, "limits: %zu seeds, must be 2 to %d", opt->seeds, most_seeds);
    return ISO_OK;
}

iso_status iso_limit_render(const iso_render_request *what, const iso_renderer_info *which, const iso_limit_options *opt,
                            iso_image *image, iso_error *err)
{
    iso_render_request q = *what;
    step_pair pair;
    iso_image coarse = {0}, fine = {0};
    iso_extrapolation unused;
    iso_status status = check_seeds(opt, err);
    if (status != ISO_OK)
        return status;
    first_pair(&pair, &q.pyramid->levels[q.level], which, opt);
    q.options = pair.frames;
    status = iso_render_several(&q, 2 * pair.seeds, pair.images, err);
    if (status == ISO_OK)
        status = mean_pair(pair.images, pair.seeds, &coarse, &fine, err);
    if (status == ISO_OK)
        status = iso_richardson(&coarse, &fine, 2, ISO_LIMIT_ORDER, image, &unused, err);
    destroy_pair(&pair);
    iso_image_destroy(&coarse);
    iso_image_destroy(&fine);
    return status;
}

static bool is_good(const iso_limit *l, const iso_limit_options *opt)
{
    return l->bar <= opt->wanted_bar && l->rmse <= l->allowed && iso_limit_left(l) <= opt->wanted_left &&
           (opt->wanted_ssim_dissimilarity <= 0 || l->ssim_dissimilarity <= opt->wanted_ssim_dissimilarity) &&
           (opt->wanted_flip <= 0 || l->flip_mean <= opt->wanted_flip);
}

/* Halving again makes the bars narrower, and what is left of the error more; what is no number stays none. */
static bool is_hopeless(const iso_limit *limit, const iso_limit_options *opt)
{
    if (!isfinite(limit->step_bar))
        return true;
    return limit->rmse > opt->hopeless * limit->allowed && iso_limit_left(limit) > 0.9;
}

iso_status iso_limit_find(const iso_render_request *what, const iso_image *reference, const iso_renderer_info *which,
                          const iso_limit_options *opt, iso_limit *out, iso_error *err)
{
    iso_render_request q = *what;
    step_pair pair;
    iso_status status = check_seeds(opt, err);
    *out = (iso_limit){0};
    if (status != ISO_OK)
        return status;
    first_pair(&pair, &q.pyramid->levels[q.level], which, opt);
    size_t first = 0;
    for (double step = opt->step_voxels; status == ISO_OK;) {
        iso_limit_destroy(out);
        *out = (iso_limit){.step_voxels = step, .seeds = pair.seeds, .planes = pair.frames[pair.seeds].planes,
                           .intervals = pair.frames[pair.seeds].intervals};
        q.options = pair.frames + first;
        status = iso_render_several(&q, 2 * pair.seeds - first, pair.images + first, err);
        if (status == ISO_OK)
            status = iso_limit_extrapolate(pair.images, pair.seeds, reference, opt->factor, out, err);
        step /= 2;
        if (status != ISO_OK || is_good(out, opt) || is_hopeless(out, opt) || !(step >= opt->finest_voxels))
            break;
        halve(&pair, &q.pyramid->levels[q.level], step, opt->finest_voxels, &first);
    }
    destroy_pair(&pair);
    if (status != ISO_OK)
        iso_limit_destroy(out);
    return status;
}

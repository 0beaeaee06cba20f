/* SPDX-License-Identifier: MIT */
#include "validate/limits.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

iso_limit_options iso_limit_defaults(void)
{
    return (iso_limit_options){.step_voxels = 0.25,
                               .finest_voxels = 1.0 / 64,
                               .wanted_bar = 1.0 / 2550,
                               .factor = ISO_EXTRAPOLATION_FACTOR_SMOOTH,
                               .wanted_left = 0.354,
                               .hopeless = INFINITY,
                               .seeds = 4};
}

/* What is extrapolated: `seeds` images at the double step, then `seeds` at the step. */
typedef struct step_pair {
    iso_render_options frames[2 * ISO_EXTRAPOLATION_MAX_SEEDS];
    iso_image images[2 * ISO_EXTRAPOLATION_MAX_SEEDS];
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

static void first_pair(step_pair *pair, const iso_level *level, const iso_renderer_info *which,
                       const iso_limit_options *opt)
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
    if (opt->seeds < 2 || opt->seeds > ISO_EXTRAPOLATION_MAX_SEEDS)
        return iso_fail(err, ISO_E_RANGE, "limits: %zu seeds, must be 2 to %d", opt->seeds,
                        ISO_EXTRAPOLATION_MAX_SEEDS);
    return ISO_OK;
}

iso_status iso_limit_render(const iso_render_request *what, const iso_renderer_info *which,
                            const iso_limit_options *opt, iso_image *image, iso_error *err)
{
    iso_render_request q = *what;
    step_pair pair;
    iso_status status = check_seeds(opt, err);
    if (status != ISO_OK)
        return status;
    first_pair(&pair, &q.pyramid->levels[q.level], which, opt);
    q.options = pair.frames;
    status = iso_render_several(&q, 2 * pair.seeds, pair.images, err);
    if (status == ISO_OK)
        status = iso_extrapolate_image(pair.images, pair.seeds, image, err);
    destroy_pair(&pair);
    return status;
}

/* Finer steps make the bar narrower, down to what noise and rounding leave. */
static bool is_narrow(const iso_extrapolated *l, const iso_limit_options *opt)
{
    const bool possible = opt->wanted_held_to > fmax(ISO_EXTRAPOLATION_ROUNDING, opt->factor * l->noise_bar / 10);
    return !possible || iso_extrapolated_held_to(l) <= opt->wanted_held_to;
}

static bool is_good(const iso_extrapolated *l, const iso_limit_options *opt)
{
    return l->bar <= opt->wanted_bar && is_narrow(l, opt) && l->rmse <= l->allowed &&
           iso_extrapolated_error_left(l) <= opt->wanted_left &&
           (opt->wanted_ssim_dissimilarity <= 0 || l->ssim_dissimilarity <= opt->wanted_ssim_dissimilarity) &&
           (opt->wanted_flip <= 0 || l->flip_mean <= opt->wanted_flip);
}

/* Halving again makes the bars narrower, and what is left of the error more; what is no number stays none. */
static bool is_hopeless(const iso_extrapolated *limit, const iso_limit_options *opt)
{
    if (!isfinite(limit->step_bar))
        return true;
    return limit->rmse > opt->hopeless * limit->allowed && iso_extrapolated_error_left(limit) > 0.9;
}

iso_status iso_limit_find(const iso_render_request *what, const iso_image *reference, const iso_renderer_info *which,
                          const iso_limit_options *opt, iso_extrapolated *out, iso_error *err)
{
    iso_render_request q = *what;
    step_pair pair;
    iso_status status = check_seeds(opt, err);
    *out = (iso_extrapolated){0};
    if (status != ISO_OK)
        return status;
    first_pair(&pair, &q.pyramid->levels[q.level], which, opt);
    size_t first = 0;
    for (double step = opt->step_voxels; status == ISO_OK;) {
        iso_extrapolated_destroy(out);
        *out = (iso_extrapolated){.step_voxels = step,
                                  .seeds = pair.seeds,
                                  .planes = pair.frames[pair.seeds].planes,
                                  .intervals = pair.frames[pair.seeds].intervals};
        q.options = pair.frames + first;
        status = iso_render_several(&q, 2 * pair.seeds - first, pair.images + first, err);
        if (status == ISO_OK)
            status = iso_extrapolate(pair.images, pair.seeds, reference, opt->factor, out, err);
        step /= 2;
        if (status != ISO_OK || is_good(out, opt) || is_hopeless(out, opt) || !(step >= opt->finest_voxels))
            break;
        halve(&pair, &q.pyramid->levels[q.level], step, opt->finest_voxels, &first);
    }
    destroy_pair(&pair);
    if (status != ISO_OK)
        iso_extrapolated_destroy(out);
    return status;
}

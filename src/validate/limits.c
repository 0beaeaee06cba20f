/* SPDX-License-Identifier: MIT */
#include "validate/limits.h"

#include <math.h>

#include "base/parallel.h"

iso_limit_options iso_limit_defaults(void)
{
    return (iso_limit_options){.step_voxels = 0.25,
                               .finest_voxels = 1.0 / 64,
                               .wanted_bar = 1.0 / 2550,
                               .factor = ISO_EXTRAPOLATION_FACTOR_SMOOTH,
                               .wanted_left = 0.354,
                               .hopeless = INFINITY,
                               .confirm = true,
                               .seeds = 4};
}

/* Images to extrapolate: `seeds` images at the double step, then `seeds` at the step. */
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

/* Sets the frames of half the step. If the double of the new step is the old step, those images are reused. That fails
 * only if the renderer takes no more intervals. *first is the first frame to render. */
static void halve(step_pair *pair, const iso_level *level, double step, double finest, size_t *first)
{
    const size_t n = pair->seeds;
    const size_t doubled = 2 * pair->frames[n].intervals; /* 0 if none are kept */
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
    NEED(check_seeds(opt, err));
    first_pair(&pair, &q.pyramid->levels[q.level], which, opt);
    q.options = pair.frames;
    iso_status status = iso_render_several(&q, 2 * pair.seeds, pair.images, err);
    TRY(status, iso_extrapolate_image(pair.images, pair.seeds, image, err));
    destroy_pair(&pair);
    return status;
}

/* True if the bar is narrow enough. Finer steps make it narrower, down to noise and rounding. */
static bool is_narrow(const iso_extrapolated *l, const iso_limit_options *opt)
{
    const bool possible = opt->wanted_held_to > fmax(ISO_EXTRAPOLATION_ROUNDING, opt->factor * l->noise_bar / 10);
    return !possible || iso_extrapolated_held_to(l) <= opt->wanted_held_to;
}

/* Returns one bit of single precision at the distance from the eye to the farthest corner of the box, in mm. */
static double eye_step_mm(const iso_geometry *g, const iso_camera *camera)
{
    const iso_vec3 way = iso_sub(iso_geometry_box_center_mm(g), camera->position);
    const double distance = sqrt(iso_dot(way, way)) + iso_geometry_box_radius_mm(g);
    return ldexp(1, ilogb(distance) - 23);
}

/* Measures how far each value of the reference moves when its eye moves by eye_step_mm(), to and fro along three axes:
 * the largest less the least. Along an edge of an opaque box it is many times as much as elsewhere. A renderer in
 * single precision cannot be asked for more. */
static iso_status measure_unsteadiness(const iso_render_request *what, const iso_render_options *truth,
                                       iso_image *unsteady, iso_error *err)
{
    iso_image least = {0}, moved = {0};
    iso_view view = *what->view; /* borrows */
    iso_camera *const c = &view.camera;
    const iso_vec3 eye = c->position, axes[3] = {c->right, c->up, c->forward};
    const double step = eye_step_mm(&what->pyramid->levels[what->level].geometry, c);
    const size_t count = 4 * view.width * view.height;
    iso_status status = iso_image_create(&least, view.width, view.height, err);
    TRY(status, iso_image_create(unsteady, view.width, view.height, err));
    for (int k = 0; k < 6 && status == ISO_OK; ++k) {
        c->position = iso_add(eye, iso_scale(axes[k / 2], k % 2 ? -step : step));
        status = iso_render_with(&(iso_render_request){what->renderers, what->pyramid, what->level, &view, truth,
                                                       what->progress},
                                 &moved, NULL, err);
        for (size_t i = 0; i < count && status == ISO_OK; ++i) {
            least.rgba[i] = k ? fminf(least.rgba[i], moved.rgba[i]) : moved.rgba[i];
            unsteady->rgba[i] = k ? fmaxf(unsteady->rgba[i], moved.rgba[i]) : moved.rgba[i];
        }
        iso_image_destroy(&moved);
    }
    for (size_t i = 0; i < count && status == ISO_OK; ++i)
        unsteady->rgba[i] -= least.rgba[i];
    iso_image_destroy(&least);
    return status;
}

/* Extrapolates the pair. Only if pixels are beyond chance, the reference is rendered again to see whether it moves
 * there; *unsteady is kept for the next step. */
static iso_status extrapolate_pair(const iso_render_request *what, const step_pair *pair, const iso_image *reference,
                                   const iso_limit_options *opt, iso_image *unsteady, iso_extrapolated *out,
                                   iso_error *err)
{
    iso_extrapolation_input input = {.images = pair->images,
                                     .seeds = pair->seeds,
                                     .reference = reference,
                                     .factor = opt->factor,
                                     .unsteady = unsteady->rgba ? unsteady : NULL,
                                     .keep = opt->keep};
    const iso_extrapolated about = *out;
    NEED(iso_extrapolate(&input, out, err));
    if (pair->seeds < 2 || out->noise.rejected == 0 || input.unsteady || !opt->truth || !isfinite(out->step_bar))
        return ISO_OK;
    NEED(measure_unsteadiness(what, opt->truth, unsteady, err));
    input.unsteady = unsteady;
    iso_extrapolated_destroy(out);
    *out = about;
    return iso_extrapolate(&input, out, err);
}

static bool is_good(const iso_extrapolated *l, const iso_limit_options *opt)
{
    return l->bar <= opt->wanted_bar && is_narrow(l, opt) && l->rmse <= l->allowed &&
           iso_extrapolated_error_left(l) <= opt->wanted_left && l->noise.rejected == 0 &&
           (opt->wanted_ssim_dissimilarity <= 0 || l->ssim_dissimilarity <= opt->wanted_ssim_dissimilarity) &&
           (opt->wanted_flip <= 0 || l->flip_mean <= opt->wanted_flip);
}

/* True if one halving more has to tell chance from a fault, which stays: a limit meets all but wanted_left. With random
 * phases, a single halving can leave too much error by chance, above all with few pixels. */
static bool is_to_be_confirmed(const iso_extrapolated *l, const iso_limit_options *opt)
{
    iso_limit_options rest = *opt;
    rest.wanted_left = INFINITY;
    rest.wanted_held_to = 0; /* another row reports that a faint image is not compared */
    return opt->confirm && l->seeds < 2 && is_good(l, &rest) && iso_extrapolated_error_left(l) > opt->wanted_left;
}

/* True if the limit is far off: halving again makes the bars narrower, and increases the remaining part of the
 * error. */
static bool is_far_off(const iso_extrapolated *limit, const iso_limit_options *opt)
{
    return limit->rmse > opt->hopeless * limit->allowed && iso_extrapolated_error_left(limit) > 0.9;
}

iso_status iso_limit_find(const iso_render_request *what, const iso_image *reference, const iso_renderer_info *which,
                          const iso_limit_options *opt, iso_extrapolated *out, iso_error *err)
{
    iso_render_request q = *what;
    step_pair pair;
    iso_image unsteady = {0};
    iso_status status = check_seeds(opt, err);
    *out = (iso_extrapolated){0};
    if (status != ISO_OK)
        return status;
    first_pair(&pair, &q.pyramid->levels[q.level], which, opt);
    size_t first = 0, far_off = 0; /* pairs in a row */
    double finest = opt->finest_voxels;
    for (double step = opt->step_voxels; status == ISO_OK;) {
        iso_extrapolated_destroy(out);
        *out = (iso_extrapolated){.step_voxels = step,
                                  .seeds = pair.seeds,
                                  .planes = pair.frames[pair.seeds].planes,
                                  .intervals = pair.frames[pair.seeds].intervals};
        q.options = pair.frames + first;
        const double began = iso_clock_seconds();
        status = iso_render_several(&q, 2 * pair.seeds - first, pair.images + first, err);
        TRY(status, extrapolate_pair(&q, &pair, reference, opt, &unsteady, out, err));
        step /= 2;
        if (status == ISO_OK && step < finest && finest == opt->finest_voxels && is_to_be_confirmed(out, opt))
            finest = step;
        far_off = status == ISO_OK && is_far_off(out, opt) ? far_off + 1 : 0;
        const bool is_hopeless = far_off >= 2 || !isfinite(out->step_bar); /* NaN stays NaN */
        if (status != ISO_OK || is_good(out, opt) || is_hopeless || !(step >= finest))
            break;
        const double now = iso_clock_seconds();
        if (opt->deadline > 0 && now + 2 * (now - began) > opt->deadline) {
            out->unfinished = true;
            break;
        }
        halve(&pair, &q.pyramid->levels[q.level], step, opt->finest_voxels, &first);
    }
    destroy_pair(&pair);
    iso_image_destroy(&unsteady);
    if (status != ISO_OK)
        iso_extrapolated_destroy(out);
    return status;
}

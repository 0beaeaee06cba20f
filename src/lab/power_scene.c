/* SPDX-License-Identifier: MIT */
/* power_scene.c - random scenes for the power of validation, and the decisions of its gates. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/random.h"
#include "lab/power.h"
#include "volume/synthetic.h"

const char *iso_power_kind_name(iso_power_kind kind)
{
    static const char *const names[ISO_POWER_KIND_COUNT] = {"smooth", "bright", "sharp", "lit"};
    return names[kind];
}

const char *iso_power_gate_name(iso_power_gate gate)
{
    return gate == ISO_POWER_LOCK_STEP ? "lock-step" : "limit";
}

bool iso_power_has_gate(iso_power_gate gate, const iso_renderer_info *renderer)
{
    return gate == ISO_POWER_LOCK_STEP ? renderer->lock_step != NULL : iso_renderer_has(renderer, ISO_HAS_LIMIT);
}

/* ---- random scenes -------------------------------------------------------------- */

typedef struct power_scene {
    iso_pyramid pyramid;
    iso_view view;
} power_scene;

static double between(iso_random *r, double lo, double hi)
{
    return lo + (hi - lo) * iso_random_unit(r);
}

static iso_vec3 direction(iso_random *r)
{
    double z = between(r, -1, 1), turn = between(r, 0, 6.2831853), flat = sqrt(1 - z * z);
    return iso_v3(flat * cos(turn), flat * sin(turn), z);
}

static iso_geometry random_grid(iso_random *r)
{
    size_t size[3];
    double spacing[3];
    for (int a = 0; a < 3; ++a) {
        size[a] = 13 + iso_random_below(r, 12);
        spacing[a] = between(r, 0.8, 1.8);
    }
    iso_geometry g = iso_geometry_axis_aligned(size, spacing);
    iso_vec3 x = direction(r), z = iso_normalize(iso_cross(x, direction(r))), y = iso_cross(z, x);
    x = iso_scale(x, iso_random_below(r, 2) ? 1 : -1); /* left-handed, as many scans are */
    const iso_mat3 turn = {{{x.x, y.x, z.x}, {x.y, y.y, z.y}, {x.z, y.z, z.z}}};
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k)
            g.index_to_world.m[i][k] = turn.m[i][k] * spacing[k];
    g.origin_mm = iso_mul(turn, g.origin_mm);
    return g;
}

static void random_camera(iso_random *r, const iso_geometry *g, iso_camera *c)
{
    double radius = 0.8 * iso_geometry_box_radius_mm(g);
    *c = (iso_camera){.orthographic = iso_random_below(r, 2), .forward = direction(r)};
    c->right = iso_normalize(iso_cross(c->forward, fabs(c->forward.z) < 0.9 ? iso_v3(0, 0, 1) : iso_v3(0, 1, 0)));
    c->up = iso_cross(c->right, c->forward);
    c->half_height = c->orthographic ? radius : 0.25;
    c->position = iso_madd(iso_geometry_box_center_mm(g), c->forward, -(c->orthographic ? 3 * radius : 4.2 * radius));
}

/* Makes five colors and extinctions, linear between them. Bright: three times as dense, so that highlights are not
 * diluted. Sharp: transparent below a random entry, half an opacity or more per millimeter from it on. */
static iso_status random_tf(iso_random *r, const iso_level *level, iso_power_kind kind, iso_tf_table *tf,
                            iso_error *err)
{
    enum { entries = 64, points = 5 };
    double p[points][4];
    const double dense = kind == ISO_POWER_BRIGHT ? 3 : 1, from = kind == ISO_POWER_SHARP ? between(r, 0.4, 0.6) : 0;
    *tf = (iso_tf_table){.count = entries,
                         .lo = level->min,
                         .hi = level->max,
                         .entries = malloc(entries * 4 * sizeof(float))};
    NEED_MEMORY(tf->entries, err, "isoshade-lab power: no memory");
    for (int i = 0; i < points; ++i)
        for (int c = 0; c < 4; ++c)
            p[i][c] = c < 3 ? between(r, 0.1, 1) : i > 0 ? dense * between(r, 0.02, 0.3) : 0;
    for (size_t i = 0; i < entries; ++i) {
        double x = (double)i / (entries - 1) * (points - 1);
        size_t k = x < points - 1 ? (size_t)x : points - 2;
        for (int c = 0; c < 4; ++c)
            tf->entries[4 * i + (size_t)c] = (float)(p[k][c] + (x - (double)k) * (p[k + 1][c] - p[k][c]));
        if (kind == ISO_POWER_SHARP)
            tf->entries[4 * i + 3] = (double)i < from * entries ? 0.0f : 0.7f;
    }
    return ISO_OK;
}

static void random_light(iso_random *r, iso_power_kind kind, iso_view *v)
{
    v->light_count = 1 + iso_random_below(r, 3);
    v->shading =
        (iso_shading){.ambient = 0.2, .diffuse = 0.8, .specular = between(r, 0.3, 1), .power = between(r, 2, 20)};
    if (kind == ISO_POWER_BRIGHT) /* wide highlights, two to four times as bright as diffuse light */
        v->shading.specular = between(r, 1.6, 3.2), v->shading.power = between(r, 2, 6);
    for (size_t i = 0; i < v->light_count; ++i)
        v->lights[i] = (iso_light){.direction = direction(r), .intensity = 1.0 / (double)v->light_count};
    for (int c = 0; c < 3; ++c)
        v->background[c] = between(r, 0, 0.4);
}

static iso_status make_scene(const iso_power_case *c, power_scene *s, iso_error *err)
{
    iso_random r = {.state = c->seed * 7919};
    iso_field field = {.kind = ISO_FIELD_NOISE, .geometry = random_grid(&r), .seed = c->seed};
    iso_pyramid_options build = iso_pyramid_defaults();
    iso_volume volume;
    *s = (power_scene){.view = {.width = c->pixels, .height = c->pixels, .step_voxels = 0.5}};
    build.level_count = 2; /* level 1 is for a planted fault */
    build.threads = c->threads;
    NEED(iso_field_sample(&field, ISO_U16, &volume, err));
    iso_status status = iso_pyramid_build(&volume, "power", &build, &s->pyramid, NULL, err);
    iso_volume_destroy(&volume);
    if (status != ISO_OK)
        return status;
    random_light(&r, c->kind, &s->view);
    random_camera(&r, &field.geometry, &s->view.camera);
    return random_tf(&r, &s->pyramid.levels[0], c->kind, &s->view.tf, err);
}

static void clear_scene(power_scene *s)
{
    iso_view_destroy(&s->view);
    iso_pyramid_destroy(&s->pyramid);
}

/* ---- cases ------------------------------------------------------------------------ */

static iso_render_options reference_options(const iso_power_case *c, iso_quadrature quadrature)
{
    iso_render_options opt = iso_render_defaults(iso_renderers_reference());
    opt.quadrature = quadrature;
    opt.threads = c->threads;
    return opt;
}

/* Returns the options of the reference image that a gate compares a renderer with. */
static iso_render_options gate_reference_options(const iso_power_case *c, iso_power_gate gate,
                                                 const iso_renderer_info *renderer)
{
    if (gate == ISO_POWER_LIMIT)
        return reference_options(c, ISO_QUADRATURE_CONVERGED);
    iso_render_options opt = reference_options(c, renderer->lock_step->quadrature);
    opt.intervals = renderer->lock_step->intervals;
    return opt;
}

static double largest(const iso_image *image)
{
    double most = 0;
    for (size_t i = 0; i < 4 * image->width * image->height; ++i)
        if (i % 4 != 3)
            most = fmax(most, (double)image->rgba[i]);
    return most;
}

iso_status iso_power_open(iso_renderers *r, iso_power_case *c, iso_error *err)
{
    const iso_render_options converged = reference_options(c, ISO_QUADRATURE_CONVERGED),
                             midpoint = reference_options(c, ISO_QUADRATURE_MIDPOINT);
    power_scene s;
    c->kind = (iso_power_kind)(c->seed % ISO_POWER_KIND_COUNT);
    c->asked = (iso_scene_agreement){.tier = c->kind == ISO_POWER_LIT ? ISO_TIER_LIT : ISO_TIER_CONVERGENCE,
                                     .sharp = c->kind == ISO_POWER_SHARP,
                                     .why = "random"};
    iso_status status = make_scene(c, &s, err);
    if (status == ISO_OK)
        status = iso_render_with(&(iso_render_request){r, &s.pyramid, 0, &s.view, &converged, NULL}, &c->converged,
                                 NULL, err);
    if (status == ISO_OK)
        status = iso_render_with(&(iso_render_request){r, &s.pyramid, 0, &s.view, &midpoint, NULL}, &c->midpoint, NULL,
                                 err);
    for (size_t i = 0; i < iso_renderer_count() && status == ISO_OK; ++i) {
        const iso_renderer_info *renderer = iso_renderer_at(i);
        if (!renderer->lock_step)
            continue;
        const iso_render_options opt = gate_reference_options(c, ISO_POWER_LOCK_STEP, renderer);
        status = iso_render_with(&(iso_render_request){r, &s.pyramid, 0, &s.view, &opt, NULL}, &c->same_samples[i],
                                 NULL, err);
        c->lock_step[i] = iso_validate_lock_step(renderer, &s.view, c->asked.sharp);
    }
    c->brightest = status == ISO_OK ? largest(&c->converged) : NAN;
    clear_scene(&s);
    return status;
}

void iso_power_close(iso_power_case *c)
{
    iso_image_destroy(&c->converged);
    iso_image_destroy(&c->midpoint);
    for (size_t i = 0; i < ISO_MAX_RENDERERS; ++i)
        iso_image_destroy(&c->same_samples[i]);
}

/* Rebuilds the scene for each fault, since the fault changes it. */
static iso_status make_faulty(const iso_power_case *c, const iso_planted *planted, power_scene *s, iso_error *err)
{
    NEED(make_scene(c, s, err));
    iso_plant(planted, &s->pyramid, 0, &s->view);
    return ISO_OK;
}

static iso_status render_faulty(iso_renderers *r, const iso_power_case *c, const iso_planted *planted,
                                const iso_render_options *opt, iso_image *image, iso_error *err)
{
    power_scene s;
    *image = (iso_image){0};
    iso_status status = make_faulty(c, planted, &s, err);
    r->after = iso_planted_hook(planted);
    if (status == ISO_OK)
        status = iso_render_with(&(iso_render_request){r, &s.pyramid, iso_planted_level(planted, 0), &s.view, opt,
                                                       NULL},
                                 image, NULL, err);
    r->after = (iso_image_hook){0};
    clear_scene(&s);
    return status;
}

iso_status iso_power_change(iso_renderers *r, const iso_power_case *c, const iso_planted *planted, double *rmse,
                            iso_error *err)
{
    OWNED(iso_image) image = {0};
    iso_metrics m = {0};
    const iso_render_options opt = reference_options(c, ISO_QUADRATURE_MIDPOINT);
    iso_status status = render_faulty(r, c, planted, &opt, &image, err);
    TRY(status, iso_metrics_measure(&c->midpoint, &image, &m, err));
    *rmse = m.rmse;
    return status;
}

/* ---- gates ---------------------------------------------------------------------------- */

static bool is_rejected(const iso_report_agreement *row)
{
    return iso_report_verdict(row) != ISO_VERDICT_AGREE;
}

static iso_status ask_lock_step(iso_renderers *r, const iso_power_case *c, const iso_renderer_info *renderer,
                                const iso_planted *planted, bool *rejected, iso_error *err)
{
    const size_t index = iso_renderer_index(renderer);
    OWNED(iso_image) image = {0};
    power_scene s;
    iso_render_options opt = iso_render_defaults(renderer);
    iso_report_agreement row = {.error_bar = NAN, .tolerances = c->lock_step[index]};
    opt.intervals = renderer->lock_step->intervals;
    opt.threads = c->threads;
    iso_status status = make_faulty(c, planted, &s, err);
    r->after = iso_planted_hook(planted);
    if (status == ISO_OK)
        status = iso_render_several(&(iso_render_request){r, &s.pyramid, iso_planted_level(planted, 0), &s.view, &opt,
                                                          NULL},
                                    1, &image, err);
    r->after = (iso_image_hook){0};
    clear_scene(&s);
    TRY(status, iso_metrics_measure(&c->same_samples[index], &image, &row.metrics, err));
    *rejected = status == ISO_OK && is_rejected(&row);
    return status;
}

static iso_status ask_limit(iso_renderers *r, const iso_power_case *c, const iso_renderer_info *renderer,
                            const iso_planted *planted, bool *rejected, iso_error *err)
{
    power_scene s;
    iso_extrapolated limit = {0};
    iso_report_agreement row = {0};
    iso_limit_options opt = iso_validate_limit_options(&c->asked, renderer, c->seeds, c->threads);
    const iso_render_options truth = gate_reference_options(c, ISO_POWER_LIMIT, renderer);
    opt.first_seed = c->first_seed;
    opt.truth = &truth;
    iso_status status = make_faulty(c, planted, &s, err);
    r->after = iso_planted_hook(planted);
    if (status == ISO_OK)
        status = iso_limit_find(&(iso_render_request){r, &s.pyramid, iso_planted_level(planted, 0), &s.view, NULL,
                                                      NULL},
                                &c->converged, renderer, &opt, &limit, err);
    r->after = (iso_image_hook){0};
    TRY(status, iso_metrics_measure(&c->converged, &limit.image, &row.metrics, err));
    if (status == ISO_OK)
        iso_validate_limit_row(&c->asked, &limit, &row);
    *rejected = status == ISO_OK && is_rejected(&row);
    iso_extrapolated_destroy(&limit);
    clear_scene(&s);
    return status;
}

iso_status iso_power_run_gate(iso_renderers *r, const iso_power_case *c, iso_power_gate gate,
                              const iso_renderer_info *renderer, const iso_planted *planted, bool *rejected,
                              iso_error *err)
{
    return gate == ISO_POWER_LOCK_STEP ? ask_lock_step(r, c, renderer, planted, rejected, err)
                                       : ask_limit(r, c, renderer, planted, rejected, err);
}

iso_status iso_power_run_deviation_gate(iso_renderers *r, const iso_power_case *c, iso_power_gate gate,
                                        const iso_renderer_info *renderer, const iso_planted *deviation, bool *rejected,
                                        iso_error *err)
{
    const iso_planted inverse = iso_planted_inverse(deviation);
    const iso_render_options opt = gate_reference_options(c, gate, renderer);
    OWNED(iso_image) truth = {0};
    iso_power_case other = *c; /* borrows all members that it does not replace */
    NEED(render_faulty(r, c, &inverse, &opt, &truth, err));
    other.converged = other.same_samples[iso_renderer_index(renderer)] = truth;
    return iso_power_run_gate(r, &other, gate, renderer, NULL, rejected, err);
}

/* ---- noise ------------------------------------------------------------------------------ */

/* Averages all images except [skip, skip + count). */
static void mean_of_others(const iso_image *images, size_t all, size_t skip, size_t count, iso_image *mean)
{
    for (size_t i = 0; i < 4 * mean->width * mean->height; ++i) {
        double sum = 0;
        for (size_t k = 0; k < all; ++k)
            sum += k < skip || k >= skip + count ? (double)images[k].rgba[i] : 0;
        mean->rgba[i] = (float)(sum / (double)(all - count));
    }
}

/* Tests without tolerance, at the significance for all tests that corresponds to the wanted chance for a single one. */
static iso_status test_group(const iso_image *limits, size_t count, const iso_image *others, iso_power_noise *out,
                             iso_error *err)
{
    const double least_deviation = 1e-6; /* floats round by 6e-8 */
    OWNED(iso_samples) s = {0};
    iso_noise_test test;
    NEED(iso_samples_create(&s, others, err));
    for (size_t k = 0; k < count; ++k)
        NEED(iso_samples_add(&s, &limits[k], err));
    for (size_t i = 0; i < 4 * others->width * others->height; ++i) {
        const bool noisy = s.squares[i] > least_deviation * least_deviation * (double)(count - 1);
        out->tests += noisy;
        s.mean[i] = noisy ? s.mean[i] : (double)others->rgba[i];
    }
    NEED(iso_samples_test(&s,
                          &(iso_noise_options){.significance = -expm1(4 * (double)(others->width * others->height) *
                                                                      log1p(-ISO_POWER_NOISE_P))},
                          &test, err));
    out->below += test.rejected;
    return ISO_OK;
}

/* Tests each group. images: per group the seeds' at the double step, then at the step; limits: one per seed. */
static iso_status test_groups(const iso_power_case *c, size_t groups, double factor, const iso_image *images,
                              iso_image *limits, iso_power_noise *out, iso_error *err)
{
    const size_t n = c->seeds;
    iso_extrapolation unused;
    OWNED(iso_image) others = {0};
    iso_status status = iso_image_create(&others, c->pixels, c->pixels, err);
    for (size_t i = 0; i < groups * n && status == ISO_OK; ++i) {
        const iso_image *coarse = images + 2 * n * (i / n) + i % n;
        status = iso_richardson(coarse, coarse + n, 2, ISO_EXTRAPOLATION_ORDER, &limits[i], &unused, err);
    }
    for (size_t g = 0; g < groups && status == ISO_OK; ++g) {
        iso_extrapolated limit = {.seeds = n};
        status = iso_extrapolate(&(iso_extrapolation_input){images + 2 * n * g, n, &c->converged, factor, NULL, false}, &limit,
                                 err);
        out->groups += 1;
        out->flagged += limit.noise.rejected > 0 || limit.noise.biased;
        iso_extrapolated_destroy(&limit);
        mean_of_others(limits, groups * n, g * n, n, &others);
        TRY(status, test_group(limits + g * n, n, &others, out, err));
    }
    return status;
}

/* ---- blocks ----------------------------------------------------------------------------- */

const size_t iso_power_block_seeds[ISO_POWER_BLOCKS] = {3, 4, 16}, iso_power_block_sides[ISO_POWER_BLOCKS] = {1, 4, 8};

/* Tests whether a block that is too bright by `amount` has a pixel beyond chance. It darkens the reference. */
static iso_status see_block(const iso_extrapolation_input *of, size_t side, double amount, bool *seen, iso_error *err)
{
    const size_t width = of->reference->width, from = (width - side) / 2;
    OWNED(iso_image) dark = {0};
    OWNED(iso_extrapolated) limit = {.seeds = of->seeds};
    iso_status status = iso_image_create(&dark, width, of->reference->height, err);
    if (status == ISO_OK)
        memcpy(dark.rgba, of->reference->rgba, 4 * width * of->reference->height * sizeof *dark.rgba);
    for (size_t i = 0; i < 3 * side * side && status == ISO_OK; ++i)
        dark.rgba[4 * ((from + i / 3 / side) * width + from + i / 3 % side) + i % 3] -= (float)amount;
    if (status == ISO_OK)
        status = iso_extrapolate(&(iso_extrapolation_input){of->images, of->seeds, &dark, of->factor, NULL, false}, &limit,
                                 err);
    *seen = status == ISO_OK && limit.noise.rejected > 0;
    return status;
}

/* Finds the weakest block that the test sees, per number of seeds and side. images: as in test_groups(), joined. */
static iso_status measure_blocks(const iso_power_case *c, size_t groups, double factor, const iso_image *images,
                                 iso_power_noise *out, iso_error *err)
{
    iso_status status = ISO_OK;
    for (size_t s = 0; s < ISO_POWER_BLOCKS; ++s) {
        const size_t seeds = iso_power_block_seeds[s], n = c->seeds;
        iso_image joined[2 * ISO_EXTRAPOLATION_MAX_SEEDS]; /* borrowed */
        if (seeds > groups * n)
            continue;
        for (size_t k = 0; k < seeds; ++k) {
            joined[k] = images[2 * n * (k / n) + k % n];
            joined[seeds + k] = images[2 * n * (k / n) + n + k % n];
        }
        const iso_extrapolation_input of = {joined, seeds, &c->converged, factor, NULL, false};
        for (size_t b = 0; b < ISO_POWER_BLOCKS; ++b) {
            double lo = 1e-5, hi = 1;
            while (hi > 1.05 * lo && status == ISO_OK) {
                const double middle = sqrt(lo * hi);
                bool seen = false;
                status = see_block(&of, iso_power_block_sides[b], middle, &seen, err);
                *(seen ? &hi : &lo) = middle;
            }
            out->block[s][b] = hi;
        }
    }
    return status;
}

iso_status iso_power_test_noise(iso_renderers *r, const iso_power_case *c, const iso_renderer_info *renderer,
                                size_t groups, iso_power_noise *out, iso_error *err)
{
    const size_t n = c->seeds, count = 2 * n * groups;
    const iso_limit_options opt = iso_validate_limit_options(&c->asked, renderer, n, c->threads);
    power_scene s;
    iso_image *images = calloc(count, sizeof *images), *limits = calloc(n * groups, sizeof *limits);
    iso_render_options *frames = calloc(count, sizeof *frames);
    *out = (iso_power_noise){0};
    iso_status status = make_scene(c, &s, err);
    if (status == ISO_OK && !(images && limits && frames))
        status = iso_fail(err, ISO_E_MEMORY, "isoshade-lab power: no memory for %zu images", count);
    for (size_t i = 0; i < count && status == ISO_OK; ++i) {
        frames[i] = iso_render_defaults(renderer);
        frames[i].step_voxels = i % (2 * n) < n ? 2 * opt.step_voxels : opt.step_voxels;
        frames[i].seed = c->first_seed + (int)(i / (2 * n) * n + i % n);
        frames[i].threads = c->threads;
    }
    if (status == ISO_OK)
        status = iso_render_several(&(iso_render_request){r, &s.pyramid, 0, &s.view, frames, NULL}, count, images, err);
    TRY(status, test_groups(c, groups, opt.factor, images, limits, out, err));
    TRY(status, measure_blocks(c, groups, opt.factor, images, out, err));
    for (size_t i = 0; images && limits && i < count; ++i) {
        iso_image_destroy(&images[i]);
        iso_image_destroy(&limits[i / 2]);
    }
    free(images);
    free(limits);
    free(frames);
    clear_scene(&s);
    return status;
}

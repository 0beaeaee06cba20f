/* SPDX-License-Identifier: MIT */
#include "plan/optimize.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "base/random.h"
#include "compare/srgb.h"
#include "render/cpu/adjoint.h"
#include "scene/views.h"

enum { BUFFERS = 4, MOST_VIEWS = 128, TILE = ISO_ADJOINT_TILE, PIXELS = ISO_ADJOINT_PIXELS };

/* Of the rates .005 and .03 and the decay: larger ones spoil levels that are nearly perfect. */
#define SCALAR_RATE 0.005f /* of level 0's range */
#define DIRECTION_RATE 0.03f
#define LAST_RATE 0.05f /* of the first */
#define SHIFT 0.08      /* of the transfer function, of level 0's range */

/* samples: rays' samples per coarse voxel */
static const struct {
    const char *name, *summary;
    size_t steps, views, samples;
} efforts[ISO_EFFORT_COUNT] = {
    [ISO_EFFORT_NONE] = {"none", "filters and fits alone, which can be made again from level 0", 0, 0, 0},
    [ISO_EFFORT_FAST] = {"fast", "a few seconds per million voxels", 200, 32, 250},
    [ISO_EFFORT_NORMAL] = {"normal", "nine tenths of the gain", 400, 64, 1000},
    [ISO_EFFORT_BEST] = {"best", "four times as long", 1600, 128, 4000},
};
const iso_names iso_effort_names = ISO_NAMES_OF_ROWS("effort", efforts);

/* ---- views ------------------------------------------------------------------------------------------------------ */

static iso_vec3 random_direction(iso_random *r)
{
    const double z = 2 * iso_random_unit(r) - 1, turn = 2 * acos(-1) * iso_random_unit(r), s = sqrt(1 - z * z);
    return iso_v3(s * cos(turn), s * sin(turn), z);
}

/* Returns the side of pictures whose pixels are 1.1 fine voxels. */
static size_t picture_side(const iso_geometry *level0)
{
    const double side = 2 * iso_geometry_box_radius_mm(level0) / (1.1 * iso_geometry_min_spacing_mm(level0));
    return (size_t)fmin(fmax(side, 64), 448);
}

static iso_status random_view(const iso_pyramid *p, const iso_scene *scene, bool own_light, iso_random *r,
                              iso_view *view, iso_error *err)
{
    iso_scene s = *scene; /* copies pointers, whose targets stay the scene's */
    s.width = s.height = picture_side(&p->levels[0].geometry);
    s.camera_fit = true;
    s.camera_direction = random_direction(r);
    s.camera_up = iso_view_up(s.camera_direction);
    s.margin = 1;
    s.zoom = 1;
    const iso_vec3 light = random_direction(r);
    if (!own_light && s.light_count > 0) {
        double intensity = 0;
        for (size_t i = 0; i < s.light_count; ++i)
            intensity += s.lights[i].intensity;
        s.lights[0] = (iso_light){light, false, intensity};
        s.light_count = 1;
    }
    return iso_scene_resolve(&s, &p->levels[0].geometry, iso_pyramid_lo(p), iso_pyramid_hi(p), view, err);
}

iso_status iso_optimize_views(const iso_pyramid *p, const iso_scene *scene, uint64_t seed, size_t count,
                              iso_view *views, iso_error *err)
{
    iso_random r = {.state = seed};
    iso_status status = ISO_OK;
    memset(views, 0, count * sizeof *views);
    for (size_t i = 0; i < count && status == ISO_OK; ++i)
        status = random_view(p, scene, i % 2 == 0, &r, &views[i], err);
    return status;
}

/* Shifts a view's transfer function, and scales its extinction. */
static void change_tf(iso_view *view, double range, iso_random *r)
{
    const double shift = SHIFT * range * (2 * iso_random_unit(r) - 1), factor = exp2(-2 + 3.3 * iso_random_unit(r));
    view->tf.lo += shift;
    view->tf.hi += shift;
    for (size_t i = 0; i < view->tf.count; ++i)
        view->tf.entries[4 * i + 3] *= (float)factor;
}

/* ---- truth ------------------------------------------------------------------------------------------------------ */

/* A picture of level 0: sRGB and alpha in 16 bits. */
typedef struct picture {
    iso_view view;
    uint16_t *rgba;
} picture;

typedef struct patch {
    uint16_t view, x, y;
} patch;

typedef struct training {
    const iso_pyramid *p;
    const iso_optimize_options *opt;
    const iso_level *level;
    size_t voxels, view_count, side, patch_count, steps, patches_per_step;
    picture pictures[MOST_VIEWS];
    patch *patches;         /* those of the pictures that show something, and some that show nothing */
    float *field, *moments; /* field: 4 per voxel; moments: 8 */
    float *gradients[BUFFERS];
    float range, lo, hi;
    iso_random random;
} training;

static void encode_picture(const iso_image *image, uint16_t *rgba)
{
    for (size_t i = 0; i < 4 * image->width * image->height; ++i) {
        const double x = (double)image->rgba[i], shown = i % 4 == 3 ? x : iso_srgb_encode(x);
        rgba[i] = (uint16_t)(65535 * fmin(fmax(shown, 0), 1) + 0.5);
    }
}

static iso_status draw_truth(training *t, const iso_scene *scene, size_t i, iso_error *err)
{
    picture *c = &t->pictures[i];
    iso_cpu_options opt = iso_cpu_defaults();
    iso_image image = {0};
    iso_status status = random_view(t->p, scene, i % 4 == 0, &t->random, &c->view, err);
    if (status == ISO_OK && i % 2 == 1)
        change_tf(&c->view, (double)t->range, &t->random);
    opt.threads = t->opt->threads;
    t->side = c->view.width;
    TRY(status, iso_cpu_render(&t->p->levels[0], t->p->options.code, &c->view, &opt, &image, err));
    if (status == ISO_OK) {
        c->rgba = malloc(4 * sizeof *c->rgba * t->side * t->side);
        status = c->rgba ? ISO_OK
                         : iso_fail(err, ISO_E_MEMORY, "optimize: no memory for pictures of %zu pixels", t->side);
    }
    if (status == ISO_OK)
        encode_picture(&image, c->rgba);
    iso_image_destroy(&image);
    return status;
}

static bool shows_something(const training *t, const patch *at)
{
    const uint16_t *rgba = t->pictures[at->view].rgba;
    for (size_t y = at->y; y < (size_t)at->y + TILE && y < t->side; ++y)
        for (size_t x = at->x; x < (size_t)at->x + TILE && x < t->side; ++x)
            if (rgba[4 * (y * t->side + x) + 3] > 65535 / 255)
                return true;
    return false;
}

/* Lists the patches that show something, and every eighth of the others: there a level must show nothing. */
static iso_status list_patches(training *t, iso_error *err)
{
    const size_t tiles = (t->side + TILE - 1) / TILE;
    size_t shown = 0, empty = 0;
    t->patches = malloc(t->view_count * tiles * tiles * sizeof *t->patches);
    if (!t->patches)
        return iso_fail(err, ISO_E_MEMORY, "optimize: no memory for a list of patches");
    for (size_t i = 0; i < t->view_count * tiles * tiles; ++i) {
        const size_t tile = i % (tiles * tiles);
        const patch at = {(uint16_t)(i / (tiles * tiles)), (uint16_t)(tile % tiles * TILE),
                          (uint16_t)(tile / tiles * TILE)};
        const bool shows = shows_something(t, &at);
        shown += shows;
        if (shows || ++empty % 8 == 0)
            t->patches[t->patch_count++] = at;
    }
    return shown > 0 ? ISO_OK : iso_fail(err, ISO_E_RANGE, "optimize: the scene shows nothing of the volume");
}

/* ---- steps ------------------------------------------------------------------------------------------------------ */

/* Returns the loss of a float of a picture; *slope gets its derivative. */
static float loss_of(float drawn, uint16_t truth, bool is_alpha, float *slope)
{
    const float x = drawn > 0 ? drawn < 1 ? drawn : 1 : 0;
    const float root = is_alpha ? 0 : powf(x > 0.0031308f ? x : 0.0031308f, 1 / 2.4f);
    const float shown = is_alpha ? x : x <= 0.0031308f ? 12.92f * x : 1.055f * root - 0.055f;
    const float rate = is_alpha ? 1 : x <= 0.0031308f ? 12.92f : 1.055f / 2.4f * root / x;
    const float d = shown - (float)truth / 65535, length = sqrtf(d * d + 1e-4f);
    *slope = drawn >= 1 ? d > 0 ? rate * d / length : 0 : rate * d / length;
    return length - 0.01f;
}

/* Draws a patch of the level and adds to a gradient. Returns the sum of the losses. */
static iso_status learn_patch(const training *t, const patch *at, uint32_t seed, float *gradient, double *loss,
                              iso_error *err)
{
    const picture *c = &t->pictures[at->view];
    const iso_adjoint_field field = {&t->level->geometry, t->field, NULL};
    const iso_adjoint_tile tile = {.x = at->x, .y = at->y, .seed = seed};
    float rgba[4 * PIXELS], slopes[4 * PIXELS];
    iso_status status = iso_adjoint_draw(&field, &c->view, &tile, rgba, err);
    for (size_t i = 0; i < 4 * PIXELS && status == ISO_OK; ++i) {
        const size_t x = at->x + i / 4 % TILE, y = at->y + i / 4 / TILE;
        slopes[i] = 0;
        if (x < t->side && y < t->side)
            *loss += (double)loss_of(rgba[i], c->rgba[4 * (y * t->side + x) + i % 4], i % 4 == 3, &slopes[i]);
    }
    TRY(status, iso_adjoint_differentiate(&field, &c->view, &tile, rgba, slopes,
                                          &(iso_adjoint_gradient){gradient, NULL, NULL}, err));
    return status;
}

static void move_voxel(const training *t, size_t voxel, float rate, float first_part, float second_part)
{
    float *x = t->field + 4 * voxel, *m = t->moments + 8 * voxel;
    for (size_t k = 0; k < 4; ++k) {
        float g = 0;
        for (int b = 0; b < BUFFERS; ++b) {
            g += t->gradients[b][4 * voxel + k];
            t->gradients[b][4 * voxel + k] = 0;
        }
        m[k] += 0.1f * (g - m[k]);
        m[4 + k] += 0.01f * (g * g - m[4 + k]);
        const float size = k == 0 ? SCALAR_RATE * t->range : DIRECTION_RATE;
        x[k] -= rate * size * (m[k] / first_part) / (sqrtf(m[4 + k] / second_part) + 1e-12f);
    }
    x[0] = fminf(fmaxf(x[0], t->lo), t->hi);
    const float length = sqrtf(x[1] * x[1] + x[2] * x[2] + x[3] * x[3]);
    for (int k = 1; k < 4 && length > 1; ++k)
        x[k] /= length;
}

/* Draws the step's patches, each buffer's one after the other, and moves the field. The order of sums does not depend
 * on threads. Returns the mean loss. */
static iso_status step(training *t, size_t number, double *loss, iso_error *err)
{
    const float rate = powf(LAST_RATE, (float)number / (float)t->steps);
    const float first_part = 1 - powf(0.9f, (float)number + 1), second_part = 1 - powf(0.99f, (float)number + 1);
    const int threads = iso_threads(t->opt->threads);
    iso_status results[BUFFERS] = {ISO_OK};
    iso_error errors[BUFFERS];
    double losses[BUFFERS] = {0};
    patch *chosen = malloc(t->patches_per_step * sizeof *chosen);
    if (!chosen)
        return iso_fail(err, ISO_E_MEMORY, "optimize: out of memory");
    for (size_t i = 0; i < t->patches_per_step; ++i)
        chosen[i] = t->patches[iso_random_below(&t->random, t->patch_count)];
#pragma omp parallel for schedule(static, 1) num_threads(threads)
    for (int b = 0; b < BUFFERS; ++b)
        for (size_t i = (size_t)b; i < t->patches_per_step; i += BUFFERS)
            TRY(results[b], learn_patch(t, &chosen[i], (uint32_t)(number * t->patches_per_step + i + 1),
                                        t->gradients[b], &losses[b], &errors[b]));
#pragma omp parallel for schedule(static) num_threads(threads)
    for (size_t i = 0; i < t->voxels; ++i)
        move_voxel(t, i, rate, first_part, second_part);
    free(chosen);
    *loss = 0;
    for (int b = 0; b < BUFFERS; ++b) {
        *loss += losses[b] / (4.0 * PIXELS * (double)t->patches_per_step);
        if (results[b] != ISO_OK)
            return iso_fail(err, results[b], "%s", errors[b].text);
    }
    return ISO_OK;
}

/* ---- all of it -------------------------------------------------------------------------------------------------- */

static iso_status begin(training *t, iso_error *err)
{
    const iso_level *level = t->level, *level0 = &t->p->levels[0];
    t->voxels = iso_geometry_voxel_count(&level->geometry);
    t->range = (float)(level0->max - level0->min);
    t->lo = (float)level0->min - 0.5f * t->range;
    t->hi = (float)level0->max + 0.5f * t->range;
    t->field = malloc(4 * t->voxels * sizeof(float));
    t->moments = calloc(8 * t->voxels, sizeof(float));
    float *directions = malloc(3 * t->voxels * sizeof *directions);
    bool complete = t->field && t->moments && directions;
    for (int b = 0; b < BUFFERS; ++b)
        complete = (t->gradients[b] = calloc(4 * t->voxels, sizeof(float))) && complete;
    if (complete) {
        iso_code_decode_all(t->p->options.code, level->codes, directions, t->voxels);
        for (size_t i = 0; i < t->voxels; ++i) {
            t->field[4 * i] = level->scalar[i];
            memcpy(t->field + 4 * i + 1, directions + 3 * i, 3 * sizeof(float));
        }
    }
    free(directions);
    return complete ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "optimize: no memory for %zu voxels", t->voxels);
}

static void end(training *t)
{
    for (size_t i = 0; i < t->view_count; ++i) {
        iso_view_destroy(&t->pictures[i].view);
        free(t->pictures[i].rgba);
    }
    for (int b = 0; b < BUFFERS; ++b)
        free(t->gradients[b]);
    free(t->patches);
    free(t->field);
    free(t->moments);
}

/* Takes as many patches per step as the level's voxels need: a ray has about 1.3 samples per voxel of the level's
 * longest edge. */
static void plan_steps(training *t)
{
    const iso_geometry *g = &t->level->geometry;
    const double most = fmax((double)g->size[0], fmax((double)g->size[1], (double)g->size[2]));
    const double wanted = (double)efforts[t->opt->effort].samples * (double)t->voxels;
    t->steps = efforts[t->opt->effort].steps;
    t->patches_per_step = (size_t)fmax(ceil(wanted / ((double)t->steps * PIXELS * 1.3 * most)), BUFFERS);
}

static iso_status learn(training *t, iso_optimized *out, const iso_progress *progress, iso_error *err)
{
    const size_t part = (t->steps + 19) / 20;
    double recent = 0;
    char stage[64];
    iso_status status = ISO_OK;
    for (size_t i = 0; i < t->steps && status == ISO_OK && !(t->opt->stop && *t->opt->stop); ++i) {
        double loss;
        status = step(t, i, &loss, err);
        recent += loss;
        out->steps = i + 1;
        if ((i + 1) % part != 0 && i + 1 < t->steps)
            continue;
        out->error = recent / (double)(i % part + 1);
        out->error_first = i < part ? out->error : out->error_first;
        recent = 0;
        snprintf(stage, sizeof stage, "levels for the scene, error %.4f", out->error);
        iso_progress_report(progress, stage, (double)(i + 1) / (double)t->steps);
    }
    return status;
}

/* Copies the field, in the form in which it is stored. */
static iso_status quantize(const training *t, iso_optimized *out, iso_error *err)
{
    out->scalar = malloc(t->voxels * sizeof *out->scalar);
    out->directions = malloc(3 * t->voxels * sizeof *out->directions);
    out->codes = malloc(3 * t->voxels);
    if (!out->scalar || !out->directions || !out->codes)
        return iso_fail(err, ISO_E_MEMORY, "optimize: no memory for %zu voxels", t->voxels);
    for (size_t i = 0; i < t->voxels; ++i) {
        out->scalar[i] = t->field[4 * i];
        memcpy(out->directions + 3 * i, t->field + 4 * i + 1, 3 * sizeof(float));
    }
    iso_code_encode(t->p->options.code, out->directions, out->codes, t->voxels);
    return ISO_OK;
}

iso_status iso_optimize_level(const iso_pyramid *p, size_t level, const iso_scene *scene,
                              const iso_optimize_options *opt, iso_optimized *out, const iso_progress *progress,
                              iso_error *err)
{
    const double began = iso_clock_seconds();
    *out = (iso_optimized){0};
    if (!iso_code_describe(p->options.code)->is_linear)
        return iso_fail(err, ISO_E_RANGE, "optimize: the code %s is not linear; build with --code fit",
                        iso_code_describe(p->options.code)->name);
    training *t = calloc(1, sizeof *t);
    if (!t)
        return iso_fail(err, ISO_E_MEMORY, "optimize: out of memory");
    *t = (training){.p = p, .opt = opt, .level = &p->levels[level], .random = {.state = opt->seed}};
    t->view_count = efforts[opt->effort].views;
    iso_status status = begin(t, err);
    for (size_t i = 0; i < t->view_count; ++i)
        TRY(status, draw_truth(t, scene, i, err));
    TRY(status, list_patches(t, err));
    out->seconds_truth = iso_clock_seconds() - began;
    plan_steps(t);
    TRY(status, learn(t, out, progress, err));
    TRY(status, quantize(t, out, err));
    out->views = t->view_count;
    out->pixels = t->side;
    out->seconds = iso_clock_seconds() - began;
    end(t);
    free(t);
    if (status != ISO_OK)
        iso_optimized_destroy(out);
    return status;
}

void iso_optimized_destroy(iso_optimized *o)
{
    free(o->scalar);
    free(o->directions);
    free(o->codes);
    *o = (iso_optimized){0};
}

size_t iso_optimize_bytes(const size_t n[3], iso_effort effort)
{
    if (effort == ISO_EFFORT_NONE)
        return 0;
    const size_t coarse = ((n[0] + 1) / 2) * ((n[1] + 1) / 2) * ((n[2] + 1) / 2), side = 448;
    return coarse * sizeof(float) * (4 + 8 + 4 * BUFFERS + 7) + efforts[effort].views * side * side * 8;
}

/* SPDX-License-Identifier: MIT */
#include "plan/optimize.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "base/random.h"
#include "compare/srgb.h"
#include "fit/extinction_scale.h"
#include "plan/patch_loss.h"

enum { LEAST_PATCHES = 2 }; /* of a step: more steps are worth more than more patches */
enum { CHEAP_LEVEL = 3 };   /* takes twice the steps: their time is small against that of the true pictures */
enum { BUFFERS = 4, MOST_VIEWS = 128, TILE = ISO_ADJOINT_TILE, PIXELS = ISO_ADJOINT_PIXELS };

/* Per step, at first. Larger ones spoil levels that are nearly perfect, and learn noise. */
#define SCALAR_RATE 0.0045f /* of level 0's range */
#define DIRECTION_RATE 0.03f
#define OCTAVE_RATE 0.045f
#define COLOR_RATE 0.02f      /* of the transfer function */
#define EXTINCTION_RATE 0.04f /* of its logarithm */
#define LAST_RATE 0.05f       /* of the first */
#define SHIFT 0.08            /* of the transfer function, of level 0's range */

/* samples: rays' samples per coarse voxel */
static const struct {
    const char *name, *summary;
    size_t steps, views, samples;
} efforts[ISO_EFFORT_COUNT] = {
    [ISO_EFFORT_NONE] = {"none", "filters and fits alone, which can be made again from level 0", 0, 0, 0},
    [ISO_EFFORT_FAST] = {"fast", "a few seconds per million voxels", 400, 64, 250},
    [ISO_EFFORT_NORMAL] = {"normal", "nine tenths of the gain", 800, 128, 1000},
    [ISO_EFFORT_BEST] = {"best", "four times as long", 1600, 128, 4000},
};
const iso_names iso_effort_names = ISO_NAMES_OF_ROWS("effort", efforts);

/* ---- truth ------------------------------------------------------------------------------------------------------ */

/* A picture of level 0: sRGB and alpha in 16 bits. */
typedef struct picture {
    iso_view view;
    size_t scene;
    bool is_edited;         /* its transfer function, under which the level has to be shown, too */
    uint16_t *rgba, *small; /* small: averaged, so that a pixel is a voxel of the level */
} picture;

/* Shifts the transfer function, and multiplies its extinction. */
static void edit_tf(picture *c, double range, iso_random *r)
{
    const double shift = SHIFT * range * (2 * iso_random_unit(r) - 1), factor = exp2(-2 + 3.3 * iso_random_unit(r));
    c->is_edited = true;
    c->view.tf.lo += shift;
    c->view.tf.hi += shift;
    for (size_t i = 0; i < c->view.tf.count; ++i)
        c->view.tf.entries[4 * i + 3] *= (float)factor;
}

typedef struct patch {
    uint16_t view, x, y;
} patch;

typedef struct training {
    const iso_pyramid *p;
    const iso_optimize_options *opt;
    const iso_shown_level *starts; /* in each scene */
    const iso_geometry *geometry;
    size_t level, box, small_side; /* box: side of the squares of pixels that are averaged for pictures in small */
    size_t voxels, view_count, side, patch_count, steps, patches_per_step;
    picture pictures[MOST_VIEWS];
    patch *patches;         /* those of the pictures that show something, and some that show nothing */
    float *field, *octaves; /* 4 per voxel; 1 */
    iso_tf_table tfs[ISO_SCENES_MOST];
    float *moments, *octave_moments, *tf_moments[ISO_SCENES_MOST]; /* 2 per number */
    float *gradients[BUFFERS], *octave_gradients[BUFFERS];
    double *tf_gradients[ISO_SCENES_MOST][BUFFERS];
    float range, lo, hi;
    iso_random random;
} training;

static uint16_t *encode_picture(const iso_image *image, iso_error *err)
{
    uint16_t *rgba = malloc(4 * sizeof *rgba * image->width * image->height);
    if (!rgba)
        iso_fail(err, ISO_E_MEMORY, "optimize: no memory for pictures of %zu pixels", image->width);
    for (size_t i = 0; rgba && i < 4 * image->width * image->height; ++i) {
        const double x = (double)image->rgba[i], shown = i % 4 == 3 ? x : iso_srgb_encode(x);
        rgba[i] = (uint16_t)(65535 * fmin(fmax(shown, 0), 1) + 0.5);
    }
    return rgba;
}

/* Draws picture i. Four in a row are of one scene: its own light, an edited transfer function, two random lights. */
static iso_status draw_truth(training *t, const iso_scene *scenes, size_t i, iso_error *err)
{
    picture *c = &t->pictures[i];
    iso_cpu_options opt = iso_cpu_defaults();
    OWNED(iso_image) image = {0}, small = {0};
    c->scene = i / 4 % t->opt->scene_count;
    NEED(iso_gate_random_view(t->p, &scenes[c->scene], i % 4 == 0, &t->random, &c->view, err));
    if (i % 4 == 1 && !t->opt->only_tf)
        edit_tf(c, (double)t->range, &t->random);
    opt.threads = t->opt->threads;
    t->side = c->view.width;
    NEED(iso_cpu_render(&t->p->levels[0], t->p->options.code, &c->view, &opt, &image, err));
    NEED(iso_gate_minify(&image, t->level, &small, err));
    t->small_side = small.width;
    c->rgba = encode_picture(&image, err);
    c->small = encode_picture(&small, err);
    return c->rgba && c->small ? ISO_OK : ISO_E_MEMORY;
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
    NEED_MEMORY(t->patches, err, "optimize: no memory for a list of patches");
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

/* Draws a patch of the level and adds to the gradients of buffer b. Adds the sum of the losses to *loss. */
static iso_status learn_patch(const training *t, const patch *at, uint32_t seed, int b, double *loss, iso_error *err)
{
    const picture *c = &t->pictures[at->view];
    const iso_adjoint_field field = {t->geometry, t->field, t->octaves};
    const iso_adjoint_tile tile = {.x = at->x, .y = at->y, .seed = seed};
    const iso_patch_truth truth = {c->rgba, c->small, t->side, t->small_side, t->box, at->x, at->y};
    const iso_adjoint_gradient gradient = {t->gradients[b], t->octave_gradients[b],
                                           c->is_edited ? NULL : t->tf_gradients[c->scene][b]};
    iso_view view = c->view; /* borrowed */
    float rgba[4 * PIXELS], slopes[4 * PIXELS];
    if (!c->is_edited)
        view.tf = t->tfs[c->scene];
    iso_status status = iso_adjoint_draw(&field, &view, &tile, rgba, err);
    if (status == ISO_OK)
        *loss += iso_patch_loss(&truth, rgba, slopes);
    TRY(status, iso_adjoint_differentiate(&field, &view, &tile, rgba, slopes, &gradient, err));
    return status;
}

/* The step's part of the rates, and the corrections of the moments' start at 0. */
typedef struct pace {
    float rate, first, second;
} pace;

/* Returns the way of a number in a step [kingma-2015]. */
static float way_of(const pace *p, float *moments, float gradient, float size)
{
    moments[0] += 0.1f * (gradient - moments[0]);
    moments[1] += 0.01f * (gradient * gradient - moments[1]);
    return p->rate * size * (moments[0] / p->first) / (sqrtf(moments[1] / p->second) + 1e-12f);
}

/* Adds up a number's gradients in the buffers, and clears them. */
static float take_sum(float *const buffers[BUFFERS], size_t i)
{
    float sum = 0;
    for (int b = 0; b < BUFFERS; ++b) {
        sum += buffers[b][i];
        buffers[b][i] = 0;
    }
    return sum;
}

static void move_voxel(const training *t, size_t voxel, const pace *p)
{
    float *x = t->field + 4 * voxel, *octaves = t->octaves + voxel;
    for (size_t k = 0; k < 4; ++k)
        x[k] -= way_of(p, t->moments + 8 * voxel + 2 * k, take_sum(t->gradients, 4 * voxel + k),
                       k == 0 ? SCALAR_RATE * t->range : DIRECTION_RATE);
    x[0] = fminf(fmaxf(x[0], t->lo), t->hi);
    const float length = sqrtf(x[1] * x[1] + x[2] * x[2] + x[3] * x[3]);
    for (int k = 1; k < 4 && length > 1; ++k)
        x[k] /= length;
    *octaves -= way_of(p, t->octave_moments + 2 * voxel, take_sum(t->octave_gradients, voxel), OCTAVE_RATE);
    *octaves = fminf(fmaxf(*octaves, (float)iso_extinction_scale_log2(0)),
                     (float)iso_extinction_scale_log2(ISO_EXTINCTION_SCALE_LAST));
}

/* Moves a scene's transfer function: colors, and the logarithm of the extinction. An entry that shows nothing stays
 * so. */
static void move_tf(const training *t, size_t scene, const pace *p)
{
    for (size_t i = 0; i < 4 * t->tfs[scene].count; ++i) {
        float *x = &t->tfs[scene].entries[i], *moments = t->tf_moments[scene] + 2 * i;
        double sum = 0;
        for (int b = 0; b < BUFFERS; ++b) {
            sum += t->tf_gradients[scene][b][i];
            t->tf_gradients[scene][b][i] = 0;
        }
        if (i % 4 == 3)
            *x = fminf(*x * expf(-way_of(p, moments, (float)sum * *x, EXTINCTION_RATE)), (float)ISO_TF_MOST_EXTINCTION);
        else
            *x = fminf(fmaxf(*x - way_of(p, moments, (float)sum, COLOR_RATE), 0), 1);
    }
}

/* Draws the step's patches, each buffer's one after the other, and moves the field. The order of sums does not depend
 * on threads. Returns the mean loss. */
static iso_status step(training *t, size_t number, double *loss, iso_error *err)
{
    const pace p = {(float)t->opt->rate * powf(LAST_RATE, (float)number / (float)t->steps),
                    1 - powf(0.9f, (float)number + 1), 1 - powf(0.99f, (float)number + 1)};
    const int threads = iso_threads(t->opt->threads);
    iso_status results[BUFFERS] = {ISO_OK};
    iso_error errors[BUFFERS];
    double losses[BUFFERS] = {0};
    patch *chosen = malloc(t->patches_per_step * sizeof *chosen);
    NEED_MEMORY(chosen, err, "optimize: out of memory");
    for (size_t i = 0; i < t->patches_per_step; ++i)
        chosen[i] = t->patches[iso_random_below(&t->random, t->patch_count)];
#pragma omp parallel for schedule(static, 1) num_threads(threads)
    for (int b = 0; b < BUFFERS; ++b)
        for (size_t i = (size_t)b; i < t->patches_per_step; i += BUFFERS)
            TRY(results[b], learn_patch(t, &chosen[i], (uint32_t)(number * t->patches_per_step + i + 1), b, &losses[b],
                                        &errors[b]));
#pragma omp parallel for schedule(static) num_threads(threads)
    for (size_t i = 0; i < (t->opt->only_tf ? 0 : t->voxels); ++i)
        move_voxel(t, i, &p);
    for (size_t i = 0; i < t->opt->scene_count; ++i)
        move_tf(t, i, &p);
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

static bool allocate(training *t)
{
    bool complete = (t->field = malloc(4 * t->voxels * sizeof(float))) != NULL;
    complete = (t->octaves = calloc(t->voxels, sizeof(float))) && complete;
    complete = (t->moments = calloc(8 * t->voxels, sizeof(float))) && complete;
    complete = (t->octave_moments = calloc(2 * t->voxels, sizeof(float))) && complete;
    for (int b = 0; b < BUFFERS; ++b) {
        complete = (t->gradients[b] = calloc(4 * t->voxels, sizeof(float))) && complete;
        complete = (t->octave_gradients[b] = calloc(t->voxels, sizeof(float))) && complete;
    }
    for (size_t i = 0; i < t->opt->scene_count; ++i) {
        const size_t numbers = 4 * t->tfs[i].count;
        complete = (t->tf_moments[i] = calloc(2 * numbers, sizeof(float))) && complete;
        for (int b = 0; b < BUFFERS; ++b)
            complete = (t->tf_gradients[i][b] = calloc(numbers, sizeof(double))) && complete;
    }
    return complete;
}

static iso_status begin(training *t, iso_error *err)
{
    const iso_level *level = t->starts->level, *level0 = &t->p->levels[0];
    t->voxels = iso_geometry_voxel_count(&level->geometry);
    t->range = (float)(level0->max - level0->min);
    t->lo = (float)level0->min - 0.5f * t->range;
    t->hi = (float)level0->max + 0.5f * t->range;
    iso_status status = ISO_OK;
    for (size_t i = 0; i < t->opt->scene_count; ++i) {
        TRY(status, iso_tf_table_copy(t->starts[i].tf, &t->tfs[i], err));
        t->tfs[i].point_count = 0; /* its entries become its own */
    }
    if (status != ISO_OK)
        return status;
    FREED float *directions = malloc(3 * t->voxels * sizeof *directions);
    const bool complete = allocate(t) && directions;
    if (complete) {
        iso_code_decode_all(t->p->options.code, level->codes, directions, t->voxels);
        for (size_t i = 0; i < t->voxels; ++i) {
            t->field[4 * i] = level->scalar[i];
            memcpy(t->field + 4 * i + 1, directions + 3 * i, 3 * sizeof(float));
            t->octaves[i] = t->starts->scale ? (float)iso_extinction_scale_log2(t->starts->scale[i]) : 0;
        }
    }
    return complete ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "optimize: no memory for %zu voxels", t->voxels);
}

static void end(training *t)
{
    for (size_t i = 0; i < t->view_count; ++i) {
        iso_view_destroy(&t->pictures[i].view);
        free(t->pictures[i].rgba);
        free(t->pictures[i].small);
    }
    for (int b = 0; b < BUFFERS; ++b) {
        free(t->gradients[b]);
        free(t->octave_gradients[b]);
    }
    for (size_t i = 0; i < ISO_SCENES_MOST; ++i) {
        for (int b = 0; b < BUFFERS; ++b)
            free(t->tf_gradients[i][b]);
        free(t->tf_moments[i]);
        iso_tf_table_destroy(&t->tfs[i]);
    }
    free(t->patches);
    free(t->field);
    free(t->octaves);
    free(t->moments);
    free(t->octave_moments);
}

/* Takes as many patches per step as the level's voxels need: a ray has about 1.3 samples per voxel of the level's
 * longest edge. */
static void plan_steps(training *t)
{
    const iso_geometry *g = t->geometry;
    const double most = fmax((double)g->size[0], fmax((double)g->size[1], (double)g->size[2]));
    const double wanted = (double)efforts[t->opt->effort].samples * (double)t->voxels;
    t->steps = efforts[t->opt->effort].steps << (t->level >= CHEAP_LEVEL);
    t->patches_per_step = (size_t)fmax(ceil(wanted / ((double)t->steps * PIXELS * 1.3 * most)), LEAST_PATCHES);
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
static iso_status quantize(training *t, iso_optimized *out, iso_error *err)
{
    out->scalar = malloc(t->voxels * sizeof *out->scalar);
    out->directions = malloc(3 * t->voxels * sizeof *out->directions);
    out->codes = malloc(3 * t->voxels);
    out->scale = malloc(t->voxels);
    NEED_MEMORY(out->scalar && out->directions && out->codes && out->scale, err, "optimize: no memory for %zu voxels",
                t->voxels);
    for (size_t i = 0; i < t->voxels; ++i) {
        out->scalar[i] = t->field[4 * i];
        memcpy(out->directions + 3 * i, t->field + 4 * i + 1, 3 * sizeof(float));
        out->scale[i] = iso_extinction_scale_byte((double)t->octaves[i]);
    }
    iso_code_encode(t->p->options.code, out->directions, out->codes, t->voxels);
    memcpy(out->tfs, t->tfs, sizeof out->tfs);
    memset(t->tfs, 0, sizeof t->tfs);
    return ISO_OK;
}

static iso_status check(const iso_pyramid *p, iso_error *err)
{
    if (p->levels[0].geometry.has_no_data)
        return iso_fail(err, ISO_E_RANGE, "optimize: the volume has voxels without data");
    return iso_code_describe(p->options.code)->is_linear
               ? ISO_OK
               : iso_fail(err, ISO_E_RANGE, "optimize: the code %s is not linear; build with --code fit",
                          iso_code_describe(p->options.code)->name);
}

iso_status iso_optimize_level(const iso_pyramid *p, size_t level, const iso_scene *scenes,
                              const iso_shown_level *starts, const iso_optimize_options *opt, iso_optimized *out,
                              const iso_progress *progress, iso_error *err)
{
    const double began = iso_clock_seconds();
    *out = (iso_optimized){0};
    NEED(check(p, err));
    training *t = calloc(1, sizeof *t);
    NEED_MEMORY(t, err, "optimize: out of memory");
    *t = (training){
        .p = p, .opt = opt, .starts = starts, .geometry = &p->levels[level].geometry, .random = {.state = opt->seed}};
    t->view_count = efforts[opt->effort].views;
    t->level = level < 5 ? level : 5; /* a box is at most a patch */
    t->box = (size_t)1 << t->level;
    iso_status status = begin(t, err);
    for (size_t i = 0; i < t->view_count; ++i)
        TRY(status, draw_truth(t, scenes, i, err));
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
    free(o->scale);
    for (size_t i = 0; i < ISO_SCENES_MOST; ++i)
        iso_tf_table_destroy(&o->tfs[i]);
    *o = (iso_optimized){0};
}

iso_status iso_optimize_tf(iso_level_gate *gate, size_t level, const iso_scene *scene, const iso_shown_level *start,
                           const iso_optimize_options *opt, iso_tf_table *tf, iso_level_seen seen[2],
                           const iso_progress *progress, iso_error *err)
{
    static const double rates[] = ISO_OPTIMIZE_RATES;
    iso_optimize_options own = *opt;
    iso_status status = iso_level_gate_look(gate, level, start, &seen[0], err);
    own.only_tf = true;
    own.scene_count = 1;
    *tf = (iso_tf_table){0};
    for (size_t i = 0; i < sizeof rates / sizeof *rates && status == ISO_OK && !tf->entries; ++i) {
        iso_optimized o = {0};
        own.rate = rates[i];
        status = iso_optimize_level(gate->p, level, scene, start, &own, &o, progress, err);
        TRY(status,
            iso_level_gate_look(gate, level, &(iso_shown_level){start->level, &o.tfs[0], start->scale}, &seen[1], err));
        if (status == ISO_OK && iso_level_gate_is_nearer(&seen[0], &seen[1], 1)) {
            *tf = o.tfs[0];
            o.tfs[0] = (iso_tf_table){0};
        }
        iso_optimized_destroy(&o);
    }
    if (status != ISO_OK || tf->entries)
        return status;
    seen[1] = seen[0];
    return iso_tf_table_copy(start->tf, tf, err);
}

size_t iso_optimize_bytes(const iso_geometry *level0, iso_effort effort)
{
    if (effort == ISO_EFFORT_NONE)
        return 0;
    const size_t *n = level0->size, coarse = ((n[0] + 1) / 2) * ((n[1] + 1) / 2) * ((n[2] + 1) / 2),
                 side = iso_gate_picture_side(level0);
    return coarse * sizeof(float) * (5 + 10 + 5 * BUFFERS + 8) + efforts[effort].views * side * side * 10;
}

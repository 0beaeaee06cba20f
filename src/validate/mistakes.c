/* SPDX-License-Identifier: MIT */
#include "validate/mistakes.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "render/sampler.h"
#include "tf/color_space.h"
#include "validate/calibration_stage.h"

/* STRIDE: every second pixel of every second row serves as well, in a quarter of the time. */
enum {
    PIXELS = ISO_CALIBRATION_PIXELS,
    STRIDE = 2,
    SIDE = PIXELS / STRIDE,
    VALUES = 4 * SIDE * SIDE,
    BEST_SINGLES = 3,
    BEST_SUMS = 24
};
/* RMSE of a picture that is explained: directions are bytes, and other samples than those of the request differ by as
 * much. The mistakes change pictures by ten times that. */
static const double EXPLAINED_RMSE = 6e-3;

/* Curves of displays. */
typedef enum curve { LINEAR, SRGB, GAMMA } curve;

static double encode(curve c, double linear)
{
    return c == SRGB ? iso_linear_to_srgb(linear) : c == GAMMA ? pow(fmax(linear, 0), 1 / 2.2) : linear;
}

static double decode(curve c, double value)
{
    return c == SRGB ? iso_srgb_to_linear(value) : c == GAMMA ? pow(fmax(value, 0), 2.2) : value;
}

/* The mistakes in a picture. A right one has factors of 1, and 0 otherwise. */
typedef struct wrong {
    iso_vec3 shift;   /* of lookups, in voxels */
    bool mirrored[3]; /* lookups along an axis */
    bool nearest;     /* lookups without interpolation */
    bool coarser;     /* lookups in the level above */
    bool negated[3];  /* components of directions */
    double extinction, range_entries, pixel_x, pixel_y;
    bool in_voxels, in_spacings; /* lengths */
    curve tf, picture; /* of colors */
    bool encodes_alpha;
    bool linear_alpha; /* sigma length in place of 1 - exp(-sigma length) */
    bool swaps_xy, by_matrix, raw_normals, unlit, one_sided, one_sided_diffuse, other_light, other_diffuse_light;
    bool reversed, other_eye, one_eye;
    bool rows_up, alpha_twice, no_alpha, swaps_channels, clipped;
} wrong;

/* function, what a renderer draws as if, the change */
/* clang-format off */
#define MISTAKE_LIST(X)                                                                                             \
    X(shifted_x, "the volume stood half a voxel off along x", w->shift.x -= 0.5)                                    \
    X(shifted_y, "the volume stood half a voxel off along y", w->shift.y -= 0.5)                                    \
    X(shifted_z, "the volume stood half a voxel off along z", w->shift.z -= 0.5)                                    \
    X(shifted_x_down, "the volume stood half a voxel off toward -x", w->shift.x += 0.5)                             \
    X(shifted_y_down, "the volume stood half a voxel off toward -y", w->shift.y += 0.5)                             \
    X(shifted_z_down, "the volume stood half a voxel off toward -z", w->shift.z += 0.5)                             \
    X(shifted, "the volume stood half a voxel off along all axes", w->shift = iso_v3(-0.5, -0.5, -0.5))             \
    X(shifted_down, "the volume stood half a voxel off toward -x, -y, -z", w->shift = iso_v3(0.5, 0.5, 0.5))        \
    X(mirrored_x, "the volume were mirrored along x", w->mirrored[0] = true)                                        \
    X(mirrored_y, "the volume were mirrored along y", w->mirrored[1] = true)                                        \
    X(mirrored_z, "the volume were mirrored along z", w->mirrored[2] = true)                                        \
    X(backward, "the voxels were stored in reverse order", w->mirrored[0] = w->mirrored[1] = w->mirrored[2] = true) \
    X(nearest, "voxels were not interpolated", w->nearest = true)                                                   \
    X(coarser, "voxels were those of the next coarser level", w->coarser = true)                                    \
    X(in_voxels, "lengths along the ray were in voxels", w->in_voxels = true)                                       \
    X(in_spacings, "lengths along the ray were in units of the smallest spacing", w->in_spacings = true)            \
    X(longer, "extinction were for 10 % more length", w->extinction = 1.1)                                          \
    X(half_extinction, "extinction were half", w->extinction = 0.5)                                                 \
    X(double_extinction, "extinction were double", w->extinction = 2)                                               \
    X(linear_alpha, "opacity were extinction times length, without exp", w->linear_alpha = true)                    \
    X(tf_srgb, "the TF's colors were taken for sRGB", w->tf = SRGB)                                                 \
    X(tf_gamma, "the TF's colors were taken for values with a gamma of 2.2", w->tf = GAMMA)                         \
    X(tf_range, "the TF's range were off by one entry", w->range_entries = 1)                                       \
    X(swaps_xy, "x and y of the directions were exchanged", w->swaps_xy = true)                                     \
    X(negated_x, "x of the directions had the wrong sign", w->negated[0] = true)                                    \
    X(negated_y, "y of the directions had the wrong sign", w->negated[1] = true)                                    \
    X(negated_z, "z of the directions had the wrong sign", w->negated[2] = true)                                    \
    X(by_matrix, "gradients went to the world by the matrix itself", w->by_matrix = true)                           \
    X(raw_normals, "directions were not normalized after filtering", w->raw_normals = true)                         \
    X(unlit, "there were no light", w->unlit = true)                                                                \
    X(one_sided, "surfaces were lit on one side", w->one_sided = true)                                              \
    X(one_sided_diffuse, "diffuse light were one-sided", w->one_sided_diffuse = true)                               \
    X(other_light, "the light came from the mirrored side", w->other_light = true)                                  \
    X(other_diffuse, "diffuse light came from the mirrored side", w->other_diffuse_light = true)                    \
    X(reversed, "back and front were exchanged along the ray", w->reversed = true)                                  \
    X(other_eye, "highlights were those of the other projection", w->other_eye = true)                              \
    X(one_eye, "highlights had one view vector for all pixels", w->one_eye = true)                                  \
    X(pixel_right, "rays passed half a pixel to the right", w->pixel_x = 0.5)                                       \
    X(pixel_left, "rays passed half a pixel to the left", w->pixel_x = -0.5)                                        \
    X(pixel_down, "rays passed half a pixel below", w->pixel_y = 0.5)                                               \
    X(pixel_up, "rays passed half a pixel above", w->pixel_y = -0.5)                                                \
    X(rows_up, "the first row were the bottom one", w->rows_up = true)                                              \
    X(alpha_twice, "color were multiplied by alpha twice", w->alpha_twice = true)                                   \
    X(no_alpha, "color were not multiplied by alpha", w->no_alpha = true)                                           \
    X(srgb, "the picture were in sRGB", w->picture = SRGB)                                                          \
    X(gamma, "the picture had a gamma of 2.2", w->picture = GAMMA)                                                  \
    X(srgb_alpha, "the picture and its alpha were in sRGB", (w->picture = SRGB, w->encodes_alpha = true))           \
    X(gamma_alpha, "the picture and its alpha had a gamma of 2.2", (w->picture = GAMMA, w->encodes_alpha = true))   \
    X(channels, "red and blue were exchanged", w->swaps_channels = true)                                            \
    X(clipped, "the picture were clipped at 1", w->clipped = true)
/* clang-format on */

#define MISTAKE_FUNCTION(function, name, change) \
    static void function(wrong *w)               \
    {                                            \
        change;                                  \
    }
MISTAKE_LIST(MISTAKE_FUNCTION)
#undef MISTAKE_FUNCTION

static const struct {
    const char *name;
    void (*make)(wrong *w);
} mistakes[] = {
#define MISTAKE_ROW(function, name, change) {name, function},
    MISTAKE_LIST(MISTAKE_ROW)
#undef MISTAKE_ROW
};
enum { COUNT = sizeof mistakes / sizeof *mistakes, NONE = COUNT };

const char *iso_mistake_name(size_t number)
{
    return number < COUNT ? mistakes[number].name : NULL;
}

/* ---- drawing ---- */

/* A check's volume and view, and the mistakes. */
typedef struct scene {
    const iso_view *view;
    const iso_geometry *grid;
    iso_mat3 to_index;
    iso_sampler sampler;
    float *directions; /* 3 per voxel, owned */
    iso_tf_table tf; /* with the mistakes; its entries are borrowed */
    wrong w;
} scene;

static iso_vec3 place_of_lookup(const scene *s, iso_vec3 index)
{
    double at[3] = {index.x + s->w.shift.x, index.y + s->w.shift.y, index.z + s->w.shift.z};
    for (int a = 0; a < 3; ++a) {
        at[a] = s->w.mirrored[a] ? (double)s->grid->size[a] - at[a] : at[a];
        at[a] = s->w.nearest ? fmin(floor(fmax(at[a], 0)), (double)s->grid->size[a] - 1) + 0.5 : at[a];
    }
    return iso_v3(at[0], at[1], at[2]);
}

/* Returns the mean of the eight voxels of a voxel of the next level, without those beyond the last. */
static double mean_of_eight(const scene *s, const float *field, size_t parts, const size_t coarse[3])
{
    const size_t *n = s->grid->size;
    double sum = 0, count = 0;
    for (size_t c = 0; c < 8; ++c) {
        const size_t x = 2 * coarse[0] + (c & 1), y = 2 * coarse[1] + (c >> 1 & 1), z = 2 * coarse[2] + (c >> 2);
        if (x >= n[0] || y >= n[1] || z >= n[2])
            continue;
        sum += (double)field[parts * (x + n[0] * (y + n[1] * z))];
        ++count;
    }
    return sum / count;
}

/* Interpolates the next level at an index of this one. */
static double coarser_at(const scene *s, const float *field, size_t parts, iso_vec3 index)
{
    const double at[3] = {index.x, index.y, index.z};
    size_t low[3], last[3], corner[3];
    double part[3], sum = 0;
    for (int a = 0; a < 3; ++a) {
        last[a] = (s->grid->size[a] + 1) / 2 - 1;
        const double q = fmin(fmax(at[a] / 2 - 0.5, 0), (double)last[a]);
        low[a] = (size_t)q;
        part[a] = q - (double)low[a];
    }
    for (size_t c = 0; c < 8; ++c) {
        double weight = 1;
        for (int a = 0; a < 3; ++a) {
            const bool high = c >> a & 1;
            corner[a] = low[a] + high > last[a] ? last[a] : low[a] + high;
            weight *= high ? part[a] : 1 - part[a];
        }
        sum += weight > 0 ? weight * mean_of_eight(s, field, parts, corner) : 0;
    }
    return sum;
}

static double scalar_at(const scene *s, iso_vec3 index)
{
    return s->w.coarser ? coarser_at(s, s->sampler.level->scalar, 1, index) : iso_sample_scalar(&s->sampler, index);
}

static iso_vec3 direction_at(const scene *s, iso_vec3 index)
{
    double out[3];
    iso_sample_floats(&s->sampler, s->directions, 3, index, out);
    for (size_t a = 0; a < 3; ++a) {
        out[a] = s->w.coarser ? coarser_at(s, s->directions + a, 3, index) : out[a];
        out[a] *= s->w.negated[a] ? -1 : 1;
    }
    iso_vec3 d = s->w.swaps_xy ? iso_v3(out[1], out[0], out[2]) : iso_v3(out[0], out[1], out[2]);
    if (s->w.by_matrix)
        d = iso_mul(s->grid->index_to_world, iso_mul(iso_mat3_transpose(s->grid->index_to_world), d));
    if (s->w.raw_normals)
        return d;
    double n[3];
    iso_code_normal((const double[]){d.x, d.y, d.z}, n);
    return iso_v3(n[0], n[1], n[2]);
}

static iso_vec3 to_viewer(const scene *s, const iso_ray *ray, iso_vec3 at)
{
    const iso_camera *c = &s->view->camera;
    if (s->w.one_eye)
        return iso_scale(c->forward, -1);
    if (!s->w.other_eye)
        return iso_scale(ray->direction, -1);
    return c->orthographic ? iso_normalize(iso_sub(c->position, at)) : iso_scale(c->forward, -1);
}

static iso_vec3 turned_x(iso_vec3 v, bool is_mirrored)
{
    return is_mirrored ? iso_v3(-v.x, v.y, v.z) : v;
}

static double shade_at(const scene *s, iso_vec3 n, iso_vec3 viewer)
{
    const iso_shading *h = &s->view->shading;
    double sum = h->ambient;
    for (size_t i = 0; i < s->view->light_count && !s->w.unlit; ++i) {
        const iso_light *l = &s->view->lights[i];
        const iso_vec3 to_light = turned_x(l->direction, s->w.other_light);
        const double cosine = iso_dot(n, turned_x(to_light, s->w.other_diffuse_light)),
                     half = iso_dot(n, iso_normalize(iso_add(to_light, viewer)));
        const bool is_dark = s->w.one_sided && cosine < 0;
        if (!is_dark && !(s->w.one_sided_diffuse && cosine < 0))
            sum += l->intensity * h->diffuse * fabs(cosine);
        if (!is_dark && h->specular > 0)
            sum += l->intensity * h->specular * pow(fabs(half), h->power);
    }
    return sum;
}

static iso_ray ray_of(const scene *s, double column, double row)
{
    const iso_camera *c = &s->view->camera;
    const double x = (2 * (column + 0.5 + s->w.pixel_x) / PIXELS - 1) * c->half_height,
                 y = (1 - 2 * (row + 0.5 + s->w.pixel_y) / PIXELS) * c->half_height;
    const iso_vec3 offset = iso_madd(iso_scale(c->right, x), c->up, y);
    return c->orthographic ? (iso_ray){iso_add(c->position, offset), c->forward}
                           : (iso_ray){c->position, iso_normalize(iso_add(c->forward, offset))};
}

/* Marches along a ray, at the samples of a request. The background is black. */
static void march(const scene *s, const iso_ray *ray, double rgba[4])
{
    const double step = s->view->step_voxels * iso_geometry_min_spacing_mm(s->grid);
    double t0, t1, through = 1, per_mm = s->w.extinction;
    memset(rgba, 0, 4 * sizeof *rgba);
    per_mm *= s->w.in_voxels ? iso_norm(iso_mul(s->to_index, ray->direction)) : 1;
    per_mm /= s->w.in_spacings ? iso_geometry_min_spacing_mm(s->grid) : 1;
    if (!iso_view_ray(s->view, ray, s->grid, &t0, &t1) || t1 <= t0)
        return;
    for (double k = floor(t0 / step); k * step < t1; ++k) {
        const double a = fmax(k * step, t0), b = fmin((k + 1) * step, t1), middle = (a + b) / 2;
        const iso_vec3 at = iso_madd(ray->origin, ray->direction, s->w.reversed ? t0 + t1 - middle : middle);
        const iso_vec3 index = place_of_lookup(s, iso_mul(s->to_index, iso_sub(at, s->grid->origin_mm)));
        double rgbs[4];
        iso_tf_lookup(&s->tf, scalar_at(s, index), rgbs);
        const double depth = per_mm * rgbs[3] * (b - a),
                     alpha = s->w.linear_alpha ? fmin(depth, 1) : -expm1(-depth),
                     lit = alpha > 0 ? shade_at(s, direction_at(s, index), to_viewer(s, ray, at)) : 0;
        for (int c = 0; c < 3; ++c)
            rgba[c] += through * alpha * lit * rgbs[c];
        through *= 1 - alpha;
    }
    rgba[3] = 1 - through;
}

static void spoil_pixel(const wrong *w, double rgba[4])
{
    const double alpha = rgba[3], red = rgba[0];
    for (int c = 0; c < 3; ++c) {
        rgba[c] *= w->alpha_twice ? alpha : 1;
        rgba[c] /= w->no_alpha ? fmax(alpha, 1e-9) : 1;
    }
    if (w->swaps_channels) {
        rgba[0] = rgba[2];
        rgba[2] = red;
    }
    for (int c = 0; c < 4; ++c) {
        rgba[c] = c < 3 || w->encodes_alpha ? encode(w->picture, rgba[c]) : rgba[c];
        rgba[c] = w->clipped ? fmin(rgba[c], 1) : rgba[c];
    }
}

/* Draws each stride-th pixel of each stride-th row. */
static void draw(const scene *s, size_t stride, float *picture)
{
    const size_t side = PIXELS / stride;
    for (size_t i = 0; i < side; ++i)
        for (size_t j = 0; j < side; ++j) {
            const size_t row = s->w.rows_up ? PIXELS - 1 - i * stride : i * stride;
            const iso_ray ray = ray_of(s, (double)(j * stride), (double)row);
            float *pixel = picture + 4 * (i * side + j);
            double rgba[4];
            march(s, &ray, rgba);
            spoil_pixel(&s->w, rgba);
            for (int c = 0; c < 4; ++c)
                pixel[c] = (float)rgba[c];
        }
}

/* The volumes of all checks. */
typedef struct stages {
    iso_calibration_stage stage[ISO_CALIBRATION_COUNT];
    scene scene[ISO_CALIBRATION_COUNT];
    int threads;
} stages;

static iso_status begin_stage(stages *all, int check, iso_error *err)
{
    iso_calibration_stage *stage = &all->stage[check];
    scene *s = &all->scene[check];
    NEED(iso_calibration_prepare(check, stage, err));
    NEED(
        iso_sampler_create(&s->sampler, &stage->pyramid.levels[0], stage->pyramid.options.code, ISO_FROM_DECODED, err));
    const size_t count = iso_geometry_voxel_count(&stage->pyramid.levels[0].geometry);
    s->view = &stage->view;
    s->grid = &stage->pyramid.levels[0].geometry;
    s->to_index = iso_mat3_inverse(s->grid->index_to_world);
    s->directions = malloc(3 * count * sizeof *s->directions);
    for (size_t i = 0; s->directions && i < count; ++i)
        iso_sampler_vector(&s->sampler, i, s->directions + 3 * i);
    return s->directions ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "no memory for %zu directions", count);
}

static void end_stages(stages *all)
{
    for (int i = 0; i < ISO_CALIBRATION_COUNT; ++i) {
        iso_sampler_destroy(&all->scene[i].sampler);
        free(all->scene[i].directions);
        iso_calibration_stage_clear(&all->stage[i]);
    }
}

/* Draws a check with the mistakes a and b; NONE: without. */
static void draw_wrong(const stages *all, int check, size_t a, size_t b, size_t stride, float *picture)
{
    scene s = all->scene[check];
    s.w = (wrong){.extinction = 1};
    if (a != NONE)
        mistakes[a].make(&s.w);
    if (b != NONE)
        mistakes[b].make(&s.w);
    float entries[4 * ISO_CALIBRATION_TF_ENTRIES];
    for (size_t i = 0; i < 4 * ISO_CALIBRATION_TF_ENTRIES; ++i)
        entries[i] = i % 4 == 3 ? s.view->tf.entries[i] : (float)decode(s.w.tf, (double)s.view->tf.entries[i]);
    s.tf = s.view->tf;
    s.tf.entries = entries;
    s.tf.hi += s.w.range_entries * (s.tf.hi - s.tf.lo) / (double)(s.tf.count - 1);
    draw(&s, stride, picture);
}

iso_status iso_mistakes_draw(int check, const size_t *numbers, size_t count, int threads, iso_image *image,
                             iso_error *err)
{
    stages all = {.threads = threads};
    iso_status status = iso_image_create(image, PIXELS, PIXELS, err);
    TRY(status, begin_stage(&all, check, err));
    if (status == ISO_OK)
        draw_wrong(&all, check, count > 0 ? numbers[0] : NONE, count > 1 ? numbers[1] : NONE, 1, image->rgba);
    else
        iso_image_destroy(image);
    end_stages(&all);
    return status;
}

/* ---- the search ---- */

/* Pictures of all checks without a mistake and with each single one. */
typedef struct search {
    stages all;
    bool is_there[ISO_CALIBRATION_COUNT];
    float pictures[ISO_CALIBRATION_COUNT][VALUES]; /* the renderer's */
    float *right, *single;     /* [check][value], [mistake][check][value] */
    double error[ISO_CALIBRATION_COUNT]; /* of the renderer: squared difference from the right pictures */
} search;

static float *single_of(const search *s, size_t mistake, int check)
{
    return s->single + (mistake * ISO_CALIBRATION_COUNT + (size_t)check) * VALUES;
}

/* Takes each STRIDE-th pixel of each STRIDE-th row. */
static void take_pictures(search *s, const iso_image pictures[ISO_CALIBRATION_COUNT])
{
    for (int check = 0; check < ISO_CALIBRATION_COUNT; ++check) {
        s->is_there[check] = pictures[check].rgba != NULL;
        for (size_t i = 0; s->is_there[check] && i < SIDE; ++i)
            for (size_t j = 0; j < SIDE; ++j)
                memcpy(s->pictures[check] + 4 * (i * SIDE + j), pictures[check].rgba + 4 * STRIDE * (i * PIXELS + j),
                       4 * sizeof(float));
    }
}

static double squared_difference(const float *a, const float *b)
{
    double sum = 0;
    for (size_t i = 0; i < VALUES; ++i)
        sum += ((double)a[i] - (double)b[i]) * ((double)a[i] - (double)b[i]);
    return sum;
}

/* How well a hypothesis explains the pictures. */
typedef struct fit {
    size_t a, b;
    double score; /* sum over the checks of the part of the error that is left */
    double left;  /* squared difference that is left */
    bool explains; /* True if each picture is explained */
} fit;

/* Adds a check to a fit. An error that is within EXPLAINED_RMSE counts as that. */
static void add_check(const search *s, int check, double left, fit *f)
{
    const double least = VALUES * EXPLAINED_RMSE * EXPLAINED_RMSE;
    f->score += left / (s->error[check] + least);
    f->left += left;
    f->explains = f->explains && left <= least;
}

/* True if the pictures need no mistake: they are right, or not finite. */
static bool is_right_or_lost(const search *s)
{
    fit f = {.explains = true};
    for (int check = 0; check < ISO_CALIBRATION_COUNT; ++check)
        add_check(s, check, s->error[check], &f);
    return f.explains || !isfinite(f.left);
}

static fit fit_single(const search *s, size_t a)
{
    fit f = {.a = a, .b = NONE, .explains = true};
    for (int check = 0; check < ISO_CALIBRATION_COUNT; ++check)
        if (s->is_there[check])
            add_check(s, check, squared_difference(s->pictures[check], single_of(s, a, check)), &f);
    return f;
}

/* Makes a mistake alone. Returns true if it changes single pixels of the finished picture. */
static bool spoils_pixels(size_t mistake, wrong *w)
{
    *w = (wrong){.extinction = 1};
    mistakes[mistake].make(w);
    return w->picture != LINEAR || w->alpha_twice || w->no_alpha || w->swaps_channels || w->clipped;
}

/* Estimates the fit of a pair. Differences of two mistakes are added, unless one changes the picture of the other: sums
 * are far from that. */
static fit guess_pair(const search *s, size_t a, size_t b)
{
    wrong w;
    const bool is_first = spoils_pixels(a, &w), is_spoiled = is_first || spoils_pixels(b, &w);
    fit f = {.a = a, .b = b, .explains = true};
    for (int check = 0; check < ISO_CALIBRATION_COUNT; ++check) {
        const float *right = s->right + (size_t)check * VALUES,
                    *one = single_of(s, a, check), *two = single_of(s, b, check), *picture = s->pictures[check];
        double left = 0;
        for (size_t i = 0; s->is_there[check] && i < VALUES; i += 4) {
            double rgba[4];
            for (size_t c = 0; c < 4; ++c)
                rgba[c] = is_first     ? (double)two[i + c]
                          : is_spoiled ? (double)one[i + c]
                                       : (double)one[i + c] + (double)two[i + c] - (double)right[i + c];
            if (is_spoiled)
                spoil_pixel(&w, rgba);
            for (size_t c = 0; c < 4; ++c)
                left += ((double)picture[i + c] - rgba[c]) * ((double)picture[i + c] - rgba[c]);
        }
        if (s->is_there[check])
            add_check(s, check, left, &f);
    }
    return f;
}

static fit fit_pair(const search *s, size_t a, size_t b)
{
    float picture[VALUES];
    fit f = {.a = a, .b = b, .explains = true};
    for (int check = 0; check < ISO_CALIBRATION_COUNT; ++check)
        if (s->is_there[check]) {
            draw_wrong(&s->all, check, a, b, STRIDE, picture);
            add_check(s, check, squared_difference(s->pictures[check], picture), &f);
        }
    return f;
}

static int by_score(const void *a, const void *b)
{
    const fit *x = a, *y = b;
    return (x->score > y->score) - (x->score < y->score);
}

/* Returns the best pair of those with a good single mistake, and of those whose sum is near. */
static fit best_pair(const search *s, const fit *singles, fit *pairs)
{
    size_t count = 0;
    for (size_t a = 0; a < COUNT; ++a)
        for (size_t b = 0; b < a; ++b)
            pairs[count++] = guess_pair(s, a, b);
    qsort(pairs, count, sizeof *pairs, by_score);
    count = BEST_SUMS;
    for (size_t i = 0; i < BEST_SINGLES; ++i)
        for (size_t b = 0; b < COUNT; ++b)
            if (b != singles[i].a)
                pairs[count++] = (fit){.a = singles[i].a, .b = b};
#pragma omp parallel for schedule(dynamic) num_threads(iso_threads(s->all.threads))
    for (size_t i = 0; i < count; ++i)
        pairs[i] = fit_pair(s, pairs[i].a, pairs[i].b);
    qsort(pairs, count, sizeof *pairs, by_score);
    return pairs[0];
}

static iso_status draw_singles(search *s, iso_error *err)
{
    iso_status status = ISO_OK;
    s->right = malloc(sizeof *s->right * ISO_CALIBRATION_COUNT * VALUES);
    s->single = malloc(sizeof *s->single * COUNT * ISO_CALIBRATION_COUNT * VALUES);
    NEED_MEMORY(s->right && s->single, err, "no memory for pictures of mistakes");
    for (int check = 0; check < ISO_CALIBRATION_COUNT && status == ISO_OK; ++check) {
        float *right = s->right + (size_t)check * VALUES;
        status = begin_stage(&s->all, check, err);
        if (status != ISO_OK || !s->is_there[check])
            continue;
        draw_wrong(&s->all, check, NONE, NONE, STRIDE, right);
        s->error[check] = squared_difference(s->pictures[check], right);
#pragma omp parallel for schedule(dynamic) num_threads(iso_threads(s->all.threads))
        for (size_t m = 0; m < COUNT; ++m)
            draw_wrong(&s->all, check, m, NONE, STRIDE, single_of(s, m, check));
    }
    return status;
}

static void take(const search *s, const fit *f, iso_mistakes *found)
{
    double error = 0;
    *found = (iso_mistakes){.count = f->b == NONE ? 1 : 2, .numbers = {f->a, f->b}};
    for (int check = 0; check < ISO_CALIBRATION_COUNT; ++check) {
        error += s->error[check];
        found->check = s->error[check] > s->error[found->check] ? check : found->check;
    }
    found->explained = error > 0 ? 1 - f->left / error : 0;
}

iso_status iso_mistakes_of_pictures(const iso_image pictures[ISO_CALIBRATION_COUNT], int threads, iso_mistakes *found,
                                    iso_error *err)
{
    search s = {.all = {.threads = threads}};
    fit singles[COUNT], *guesses = malloc(sizeof *guesses * COUNT * COUNT);
    *found = (iso_mistakes){.count = 0};
    take_pictures(&s, pictures);
    iso_status status = guesses ? draw_singles(&s, err) : iso_fail(err, ISO_E_MEMORY, "out of memory");
    if (status == ISO_OK && !is_right_or_lost(&s)) {
        for (size_t m = 0; m < COUNT; ++m)
            singles[m] = fit_single(&s, m);
        qsort(singles, COUNT, sizeof *singles, by_score);
        const fit best = singles[0].explains ? singles[0] : best_pair(&s, singles, guesses);
        if (best.explains)
            take(&s, &best, found);
    }
    free(guesses);
    free(s.right);
    free(s.single);
    end_stages(&s.all);
    return status;
}

iso_status iso_mistakes_find(iso_renderers *r, const iso_renderer_info *which, int threads, iso_mistakes *found,
                             iso_mistake_pictures *shown, iso_error *err)
{
    iso_image pictures[ISO_CALIBRATION_COUNT] = {{.rgba = NULL}};
    iso_status status = ISO_OK;
    *found = (iso_mistakes){.count = 0};
    *shown = (iso_mistake_pictures){.got = {.rgba = NULL}};
    for (int check = 0; check < ISO_CALIBRATION_COUNT && status == ISO_OK; ++check)
        status = iso_calibration_picture(r, which, check, &pictures[check], err);
    TRY(status, iso_mistakes_of_pictures(pictures, threads, found, err));
    if (status == ISO_OK && found->count > 0) {
        status = iso_mistakes_draw(found->check, NULL, 0, threads, &shown->wanted, err);
        TRY(status, iso_mistakes_draw(found->check, found->numbers, found->count, threads, &shown->explained, err));
        shown->got = pictures[found->check];
        pictures[found->check] = (iso_image){.rgba = NULL};
    }
    for (int check = 0; check < ISO_CALIBRATION_COUNT; ++check)
        iso_image_destroy(&pictures[check]);
    return status;
}

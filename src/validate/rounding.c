/* SPDX-License-Identifier: MIT */
#include "validate/rounding.h"

#include <math.h>

#include "compare/statistics.h"
#include "render/reference.h"
#include "render/reference_ray.h"
#include "render/sampler.h"

/* One step of single precision at 1: a coordinate of a texture is a part of the volume, and one step of it off at most
 * after the arithmetic that makes it. */
static const double coordinate_step = 0x1p-24;
/* A ray's position, in parts of its distance from the eye, if the ray is set up in single precision. */
static const double ray_steps = 4 * 0x1p-24;
/* A value is filtered by seven interpolations, each rounded in the product and in the sum, and becomes a coordinate of
 * the table: four steps of the largest value that takes part. */
static const double value_steps = 4 * 0x1p-24;
/* So that nothing is divided by an extinction of 0 that rounding may raise. */
static const double least_extinction = 1e-30;

/* Medium through which rounding is propagated; the emitter's field. */
typedef struct medium {
    double step_voxels[3];  /* by which a coordinate is off */
    double ray_step;        /* by which a position is off, in parts of its distance from the eye */
    iso_vec3 eye;           /* index */
    iso_view below, above;  /* the view with values that are off; they borrow */
    double brightest;       /* radiance that arrives from anywhere, at most */
} medium;

typedef struct emission {
    double extinction, radiance[3]; /* per mm; color times shade */
} emission;

static emission emission_at(const iso_view *view, const iso_emitter_place *at, iso_vec3 index)
{
    double rgbs[4];
    emission e = {0};
    iso_reference_classify(at->sampler, view, index, rgbs);
    e.extinction = rgbs[3];
    if (rgbs[3] <= 0)
        return e;
    const double shade = iso_shade(view, iso_sample_normal(at->sampler, index), at->to_viewer);
    for (int c = 0; c < 3; ++c)
        e.radiance[c] = rgbs[c] * shade;
    return e;
}

/* Raises *most to the difference of the pair. If one of the two is invisible, its color does not count. */
static void widen(const emission *a, const emission *b, double *extinction, double *radiance)
{
    *extinction = fmax(*extinction, fabs(a->extinction - b->extinction));
    for (int c = 0; c < 3 && a->extinction > 0 && b->extinction > 0; ++c)
        *radiance = fmax(*radiance, fabs(a->radiance[c] - b->radiance[c]));
}

/* Emits the source of the error: first of colors, second of opacity. */
static double emit(const iso_emitter *e, const iso_emitter_place *at, double color[3])
{
    const medium *m = e->field;
    const emission here = emission_at(at->view, at, at->index);
    const double ray = m->ray_step * iso_norm(iso_sub(at->index, m->eye));
    double extinction = 0, radiance = 0; /* the sum over the axes and the value, each by the worse side */
    for (int a = 0; a < 4; ++a) {
        double more_extinction = 0, more_radiance = 0;
        for (int side = -1; side <= 1; side += 2) {
            double d[3] = {0};
            if (a < 3)
                d[a] = side * (m->step_voxels[a] + ray);
            const iso_view *view = a < 3 ? at->view : side < 0 ? &m->below : &m->above;
            const emission there = emission_at(view, at, iso_add(at->index, iso_v3(d[0], d[1], d[2])));
            widen(&here, &there, &more_extinction, &more_radiance);
        }
        extinction += more_extinction;
        radiance += more_radiance;
    }
    color[0] = extinction * m->brightest + here.extinction * radiance;
    color[1] = extinction;
    color[2] = 0;
    return fmax(here.extinction, least_extinction);
}

static void shift_tables(iso_view *view, iso_tf_2d *tf_2d, double by)
{
    view->tf.lo += by;
    view->tf.hi += by;
    if (!view->tf_2d)
        return;
    *tf_2d = *view->tf_2d;
    for (int i = 0; i < ISO_TF_2D_ROWS; ++i) {
        tf_2d->rows[i].lo += by;
        tf_2d->rows[i].hi += by;
    }
    view->tf_2d = tf_2d;
}

/* Returns the brightest color of the tables under all lights at once, or of the background. */
static double brightest_of(const iso_view *view)
{
    double light = view->shading.ambient, color = 0, most;
    for (size_t i = 0; i < view->light_count; ++i)
        light += view->lights[i].intensity * (view->shading.diffuse + view->shading.specular);
    const size_t rows = view->tf_2d ? ISO_TF_2D_ROWS : 1;
    for (size_t r = 0; r < rows; ++r) {
        const iso_tf_table *tf = view->tf_2d ? &view->tf_2d->rows[r] : &view->tf;
        for (size_t i = 0; i < 4 * tf->count; ++i)
            color = i % 4 < 3 ? fmax(color, (double)tf->entries[i]) : color;
    }
    most = light * color;
    for (int c = 0; c < 3; ++c)
        most = fmax(most, view->background[c]);
    return most;
}

static iso_sample_error sum_up(const iso_image *image)
{
    const size_t count = image->width * image->height;
    double squares = 0, most = 0;
    for (size_t i = 0; i < count; ++i) {
        const double color = image->rgba[4 * i], opacity = image->rgba[4 * i + 1];
        squares += (3 * color * color + opacity * opacity) / 4;
        most = fmax(most, fmax(color, opacity));
    }
    return (iso_sample_error){sqrt(squares / (double)count), most};
}

iso_status iso_rounding_bound(const iso_level *level, iso_code code, const iso_view *view, iso_direction_source source,
                              bool float_rays, int threads, iso_sample_error *most, iso_error *err)
{
    iso_view dark = *view; /* borrows */
    iso_tf_2d tables[2];
    medium m = {.ray_step = float_rays ? ray_steps : 0,
                .eye = iso_geometry_to_index(&level->geometry, view->camera.position),
                .below = *view,
                .above = *view,
                .brightest = brightest_of(view)};
    const double value = value_steps * fmax(fmax(fabs(level->min), fabs(level->max)), view->tf.hi - view->tf.lo);
    const iso_emitter emitter = {.emit = emit, .field = &m};
    iso_reference_options opt = iso_reference_defaults();
    iso_image image = {0};
    *most = (iso_sample_error){0};
    if (view->roi) /* an emitter has none */
        return ISO_OK;
    for (int a = 0; a < 3; ++a)
        m.step_voxels[a] = coordinate_step * (double)level->geometry.size[a];
    shift_tables(&m.below, &tables[0], -value);
    shift_tables(&m.above, &tables[1], value);
    for (int c = 0; c < 3; ++c)
        dark.background[c] = 0;
    opt.quadrature = ISO_QUADRATURE_MIDPOINT;
    opt.source = source;
    opt.threads = threads;
    opt.emitter = &emitter;
    const iso_status status = iso_reference_render(level, code, &dark, &opt, &image, NULL, err);
    if (status == ISO_OK)
        *most = sum_up(&image);
    iso_image_destroy(&image);
    return status;
}

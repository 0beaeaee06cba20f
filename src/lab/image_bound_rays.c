/* SPDX-License-Identifier: MIT */
/* image_bound_rays.c - how much of the bound is signs: its integrand along the rays themselves, with the transmittance
 * and the light that are there, and nothing given away but that absolute values are taken. */
#include "lab/image_bound_rays.h"

#include <math.h>
#include <stdlib.h>

#include "base/parallel.h"
#include "render/image_bound_points.h"

typedef struct ray_samples {
    iso_bound_values *values;                /* from the eye on, at the middles of the steps */
    double (*behind)[2][ISO_BOUND_CHANNELS]; /* L there */
    size_t count;
    double step_mm;
} ray_samples;

/* Computes L at the middle of each step, from the light beyond the step and from the far half of the step. */
static void follow_light(const iso_view *view, ray_samples *s)
{
    for (int i = 0; i < 2; ++i) {
        double light[ISO_BOUND_CHANNELS] = {view->background[0], view->background[1], view->background[2], 0};
        for (size_t n = s->count; n-- > 0;) {
            const iso_bound_values *v = &s->values[n];
            const double half = exp(-0.5 * v->sigma[i] * s->step_mm);
            for (int c = 0; c < ISO_BOUND_CHANNELS; ++c) {
                s->behind[n][i][c] = half * light[c] + (1 - half) * v->g[i][c];
                light[c] = half * s->behind[n][i][c] + (1 - half) * v->g[i][c];
            }
        }
    }
}

/* Returns the sum over the channels of the smaller integral's square: of T_k |...| with L_0, or of T_0 |...| with
 * L_k. */
static double squares_of_ray(const ray_samples *s)
{
    double integral[2][ISO_BOUND_CHANNELS] = {{0}}, through[2] = {1, 1}, squares = 0;
    for (size_t n = 0; n < s->count; ++n) {
        const iso_bound_values *v = &s->values[n];
        for (int i = 0; i < 2; ++i) {
            const double half = exp(-0.5 * v->sigma[1 - i] * s->step_mm);
            for (int c = 0; c < ISO_BOUND_CHANNELS; ++c)
                integral[i][c] += s->step_mm * through[i] * half *
                                  fabs(v->sigma[1] * (v->g[1][c] - s->behind[n][i][c]) -
                                       v->sigma[0] * (v->g[0][c] - s->behind[n][i][c]));
            through[i] *= half * half;
        }
    }
    for (int c = 0; c < ISO_BOUND_CHANNELS; ++c)
        squares += pow(fmin(integral[0][c], integral[1][c]), 2);
    return squares;
}

static bool take_samples(const iso_bound_field *field, size_t pixel, ray_samples *s)
{
    const iso_view *view = field->in->view;
    const iso_geometry *g = &field->in->fine->geometry;
    const iso_ray ray = iso_camera_ray(&view->camera, view->width, view->height, pixel % view->width,
                                       pixel / view->width);
    double t0, t1;
    s->count = 0;
    if (!iso_view_ray(view, &ray, g, &t0, &t1) || !(t1 > t0))
        return true;
    s->count = (size_t)ceil((t1 - t0) / (0.25 * iso_geometry_min_spacing_mm(g)));
    s->step_mm = (t1 - t0) / (double)s->count;
    s->values = malloc(s->count * sizeof *s->values);
    s->behind = malloc(s->count * sizeof *s->behind);
    if (!s->values || !s->behind)
        return false;
    for (size_t n = 0; n < s->count; ++n) {
        const iso_vec3 world = iso_madd(ray.origin, ray.direction, t0 + ((double)n + 0.5) * s->step_mm);
        iso_bound_look_up(field, iso_geometry_to_index(g, world), iso_scale(ray.direction, -1), &s->values[n]);
    }
    return true;
}

iso_status iso_image_bound_without_signs(const iso_image_bound_input *in, double *rmse, iso_error *err)
{
    const size_t pixels = in->view->width * in->view->height;
    iso_bound_field field;
    double *squares = calloc(pixels, sizeof *squares), sum = 0;
    bool no_memory = squares == NULL;
    iso_status status = iso_bound_field_create(&field, in, err);
    if (status == ISO_OK && !no_memory) {
#pragma omp parallel for schedule(dynamic, 16) num_threads(iso_threads(in->threads)) reduction(|| : no_memory)
        for (size_t i = 0; i < pixels; ++i) {
            ray_samples s = {0};
            if (take_samples(&field, i, &s)) {
                follow_light(in->view, &s);
                squares[i] = squares_of_ray(&s);
            } else {
                no_memory = true;
            }
            free(s.values);
            free(s.behind);
        }
    }
    for (size_t i = 0; squares && i < pixels; ++i)
        sum += squares[i];
    *rmse = sqrt(sum / (double)(ISO_BOUND_CHANNELS * pixels));
    free(squares);
    iso_bound_field_destroy(&field);
    return status == ISO_OK && no_memory ? iso_fail(err, ISO_E_MEMORY, "bound: out of memory") : status;
}

/* SPDX-License-Identifier: MIT */
#include "bench/cast_bound.h"

#include <math.h>

#include "base/parallel.h"
#include "render/sampler.h"

/* As in the ray casters: less remaining light than this changes no pixel. */
static const double opaque = 1e-7;

static void count_ray(const iso_sampler *s, const iso_view *view, const iso_ray *ray, double step_mm,
                      bench_samples *out)
{
    const iso_geometry *g = &s->level->geometry;
    double t0, t1, rgbs[4], left = 1;
    if (!iso_view_ray(view, ray, g, &t0, &t1))
        return;
    for (double k = floor(t0 / step_mm); k * step_mm < t1 && left >= opaque; ++k) {
        const double begin = fmax(k * step_mm, t0), end = fmin((k + 1) * step_mm, t1);
        const iso_vec3 middle = iso_madd(ray->origin, ray->direction, 0.5 * (begin + end));
        iso_tf_lookup(&view->tf, iso_sample_scalar(s, iso_geometry_to_index(g, middle)), rgbs);
        left *= exp(-rgbs[3] * (end - begin));
        ++out->looked_up;
        out->shown += rgbs[3] > 0;
    }
}

iso_status iso_bench_count_samples(const iso_level *level, iso_code code, const iso_view *view, int threads,
                                   bench_samples *out, iso_error *err)
{
    const double step_mm = view->step_voxels *
                           iso_geometry_min_spacing_mm(iso_view_step_geometry(view, &level->geometry));
    iso_sampler sampler;
    NEED(iso_sampler_create(&sampler, level, code, ISO_FROM_ON_THE_FLY, err));
    size_t looked_up = 0, shown = 0;
#pragma omp parallel for schedule(dynamic) num_threads(iso_threads(threads)) reduction(+ : looked_up, shown)
    for (size_t row = 0; row < view->height; ++row) {
        bench_samples of_row = {0};
        for (size_t column = 0; column < view->width; ++column) {
            const iso_ray ray = iso_camera_ray(&view->camera, view->width, view->height, column, row);
            count_ray(&sampler, view, &ray, step_mm, &of_row);
        }
        looked_up += of_row.looked_up;
        shown += of_row.shown;
    }
    *out = (bench_samples){looked_up, shown};
    iso_sampler_destroy(&sampler);
    return ISO_OK;
}

double iso_bench_skipping_bound(const bench_samples *dense, double dense_seconds, const bench_samples *sparse,
                                double sparse_seconds)
{
    const double dense_n = (double)dense->looked_up, dense_v = (double)dense->shown;
    const double sparse_n = (double)sparse->looked_up, sparse_v = (double)sparse->shown;
    const double determinant = dense_n * sparse_v - sparse_n * dense_v;
    if (determinant == 0 || sparse_v == 0)
        return NAN;
    /* Visible samples cannot be cheaper: clamp noise to 0. */
    const double shading = fmax((dense_n * sparse_seconds - sparse_n * dense_seconds) / determinant, 0);
    const double lookup = (sparse_seconds - shading * sparse_v) / sparse_n;
    return lookup > 0 ? sparse_seconds / ((lookup + shading) * sparse_v) : NAN;
}

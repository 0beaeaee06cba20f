/* SPDX-License-Identifier: MIT */
#include "lab/shading_error.h"

#include <math.h>
#include <stdlib.h>

#include "base/random.h"
#include "lab/look.h"
#include "compare/ssim.h"
#include "render/sampler.h"

enum { MOST_POINTS = 20000 };
static const double step_of_views = 0.5; /* voxels of the level */

/* ---- views ---- */

iso_status iso_shading_render(const iso_shading_subject *s, int view, const iso_shading_shown *shown, iso_image *image,
                              iso_error *err)
{
    iso_gl_options opt = iso_gl_defaults();
    opt.source = shown->source;
    opt.step_voxels = shown->step_voxels;
    iso_view own = s->views[view]; /* same view, other table */
    if (shown->tf)
        own.tf = *shown->tf;
    return iso_gl_render(s->gl, shown->level, shown->code, &own, &opt, image, err);
}

/* ---- the surface ---- */

static bool shows(const iso_tf_table *tf, const iso_level *level, size_t voxel)
{
    double rgbs[4];
    iso_tf_lookup(tf, (double)level->scalar[voxel], rgbs);
    return rgbs[3] > 0;
}

/* True if the voxel is visible and a neighbor is not; excludes the border, where the surface is the box. */
static bool is_surface(const iso_tf_table *tf, const iso_level *level, size_t x, size_t y, size_t z)
{
    const size_t *n = level->geometry.size, row = n[0], plane = n[0] * n[1], i = x + y * row + z * plane;
    if (x == 0 || y == 0 || z == 0 || x + 1 >= n[0] || y + 1 >= n[1] || z + 1 >= n[2] || !shows(tf, level, i))
        return false;
    return !shows(tf, level, i - 1) || !shows(tf, level, i + 1) || !shows(tf, level, i - row) ||
           !shows(tf, level, i + row) || !shows(tf, level, i - plane) || !shows(tf, level, i + plane);
}

/* Selects at most MOST_POINTS of the surface's voxels with a direction, all with the same probability. */
static iso_status find_surface(iso_shading_subject *s, const iso_level *level0, iso_code code, const iso_field *field,
                               iso_error *err)
{
    const size_t *n = level0->geometry.size;
    iso_random random = {1};
    size_t seen = 0;
    s->points = malloc(MOST_POINTS * sizeof *s->points);
    NEED_MEMORY(s->points, err, "no memory for %d points of a surface", MOST_POINTS);
    for (size_t i = 0; i < iso_geometry_voxel_count(&level0->geometry); ++i) {
        const size_t x = i % n[0], y = i / n[0] % n[1], z = i / (n[0] * n[1]);
        double e[3], d[3];
        if (!is_surface(&s->views[0].tf, level0, x, y, z))
            continue;
        iso_code_lattice(code, level0->codes + 3 * i, e);
        iso_code_decode(code, e, d);
        const iso_vec3 finest = iso_normalize(iso_v3(d[0], d[1], d[2]));
        if (iso_norm(finest) < 0.5)
            continue;
        /* Reservoir sampling: point number `seen` replaces any with the probability MOST_POINTS / seen. */
        const size_t place = seen < MOST_POINTS ? seen : iso_random_below(&random, seen + 1);
        ++seen;
        if (place >= MOST_POINTS)
            continue;
        iso_surface_point *point = &s->points[place];
        *point = (iso_surface_point){.at = iso_v3((double)x + 0.5, (double)y + 0.5, (double)z + 0.5), .finest = finest};
        if (field) {
            iso_vec3 gradient;
            iso_field_value(field, iso_geometry_to_world(&level0->geometry, point->at), &gradient);
            point->truth = iso_normalize(gradient);
        }
    }
    s->point_count = seen < MOST_POINTS ? seen : MOST_POINTS;
    return ISO_OK;
}

iso_status iso_shading_begin(iso_shading_subject *s, iso_gl *gl, const iso_level *level0, iso_code code,
                             const iso_field *field, const iso_shading_look *look, iso_error *err)
{
    iso_surface_tf points;
    *s = (iso_shading_subject){.gl = gl, .view_count = look->view_count};
    s->surface = look->surface > 0 ? iso_surface_at(level0, look->surface) : iso_surface_find(level0);
    if (look->any_surface)
        s->surface.left_out = NULL;
    if (s->surface.left_out)
        return ISO_OK;
    const iso_tf tf = iso_surface_make_tf(&s->surface, &points);
    const iso_lab_look seen = {look->image_size, true, step_of_views};
    iso_status status = ISO_OK;
    for (int i = 0; i < s->view_count && status == ISO_OK; ++i) {
        status = iso_lab_view(&seen, level0, &tf, iso_view_along_diagonal(i), &s->views[i], err);
        if (status == ISO_OK)
            status = iso_shading_render(s, i,
                                        &(iso_shading_shown){level0, 0, code, ISO_FROM_CODES, NULL, step_of_views},
                                        &s->finest[i], err);
    }
    TRY(status, find_surface(s, level0, code, field, err));
    if (status == ISO_OK && s->point_count == 0 && !look->any_surface)
        s->surface.left_out = "its surface has no directions";
    if (status != ISO_OK)
        iso_shading_end(s);
    return status;
}

void iso_shading_end(iso_shading_subject *s)
{
    for (int i = 0; i < s->view_count; ++i) {
        iso_view_destroy(&s->views[i]);
        iso_image_destroy(&s->finest[i]);
    }
    free(s->points);
    *s = (iso_shading_subject){0};
}

/* ---- errors ---- */

/* Returns the angle between axes; a missing direction counts as a right angle. */
static double angle_deg(iso_vec3 a, iso_vec3 b)
{
    return acos(fmin(fabs(iso_dot(iso_normalize(a), iso_normalize(b))), 1)) * (180 / 3.14159265358979323846);
}

static int compare_doubles(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Returns the length of the stored direction in the voxel of a point. */
static double length_at(const iso_level *level, iso_code code, iso_vec3 at)
{
    const size_t *n = level->geometry.size;
    const size_t voxel = ((size_t)at.z * n[1] + (size_t)at.y) * n[0] + (size_t)at.x;
    double e[3], d[3];
    iso_code_lattice(code, level->codes + 3 * voxel, e);
    iso_code_decode(code, e, d);
    return iso_norm(iso_v3(d[0], d[1], d[2]));
}

static iso_status measure_angles(const iso_shading_subject *s, const iso_level *level, size_t k, iso_code code,
                                 iso_direction_source source, iso_shading_error *e, iso_error *err)
{
    OWNED(iso_sampler) sampler = {0};
    double sum = 0, truth = 0, lengths = 0;
    FREED double *angles = malloc((s->point_count + 1) * sizeof *angles);
    e->angle_mean_deg = e->angle_p95_deg = e->truth_mean_deg = e->length_mean = NAN;
    NEED_MEMORY(angles, err, "no memory for %zu angles", s->point_count);
    NEED(iso_sampler_create(&sampler, level, code, source, err));
    for (size_t i = 0; i < s->point_count; ++i) {
        const iso_surface_point *point = &s->points[i];
        const iso_vec3 at = iso_scale(point->at, ldexp(1, -(int)k)), normal = iso_sample_normal(&sampler, at);
        angles[i] = angle_deg(normal, point->finest);
        sum += angles[i];
        truth += angle_deg(normal, point->truth);
        lengths += length_at(level, code, at);
    }
    if (s->point_count > 0) {
        qsort(angles, s->point_count, sizeof *angles, compare_doubles);
        e->angle_mean_deg = sum / (double)s->point_count;
        e->length_mean = lengths / (double)s->point_count;
        e->angle_p95_deg = angles[(size_t)(0.95 * (double)(s->point_count - 1))];
        if (iso_norm(s->points[0].truth) > 0)
            e->truth_mean_deg = truth / (double)s->point_count;
    }
    return ISO_OK;
}

static iso_status measure_images(const iso_shading_subject *s, const iso_shading_shown *shown, iso_shading_error *e,
                                 iso_error *err)
{
    iso_status status = ISO_OK;
    e->dssim_mean = e->alpha_max = 0;
    for (int i = 0; i < s->view_count && status == ISO_OK; ++i) {
        OWNED(iso_image) image = {0};
        double ssim = 0;
        status = iso_shading_render(s, i, shown, &image, err);
        TRY(status, iso_ssim_foreground(&s->finest[i], &image, &ssim, err));
        e->dssim[i] = (1 - ssim) / 2;
        e->dssim_mean += e->dssim[i] / s->view_count;
        e->alpha_max = fmax(e->alpha_max, iso_lab_largest_alpha(&image));
    }
    return status;
}

iso_status iso_shading_measure(const iso_shading_subject *s, const iso_shading_shown *shown, iso_shading_error *e,
                               iso_error *err)
{
    iso_shading_shown own = *shown;
    own.step_voxels = step_of_views;
    iso_status status = measure_images(s, &own, e, err);
    return status == ISO_OK ? measure_angles(s, shown->level, shown->k, shown->code, shown->source, e, err) : status;
}

/* Resamples the level's scalar on the grid of level 0, so that one texture coordinate serves both. This is exact at
 * fine centers and linear between them. */
iso_status iso_shading_floor(const iso_shading_subject *s, const iso_level *level0, const iso_level *level, size_t k,
                             iso_code code, iso_shading_error *e, iso_error *err)
{
    iso_level mixed = *level0;
    const size_t *n = level0->geometry.size, count = iso_geometry_voxel_count(&level0->geometry);
    iso_sampler sampler = {0};
    mixed.stored_type = ISO_F32;
    mixed.scalar = malloc(count * sizeof *mixed.scalar);
    NEED_MEMORY(mixed.scalar, err, "no memory for %zu scalars", count);
    iso_status status = iso_sampler_create(&sampler, level, code, ISO_FROM_ON_THE_FLY, err);
    if (status == ISO_OK) {
        const double scale = ldexp(1, -(int)k);
#pragma omp parallel for schedule(static)
        for (size_t i = 0; i < count; ++i) {
            const iso_vec3 at = {(double)(i % n[0]) + 0.5, (double)(i / n[0] % n[1]) + 0.5,
                                 (double)(i / (n[0] * n[1])) + 0.5};
            mixed.scalar[i] = (float)iso_sample_scalar(&sampler, iso_scale(at, scale));
        }
        *e = (iso_shading_error){.angle_mean_deg = 0, .angle_p95_deg = 0, .truth_mean_deg = NAN};
        status = measure_images(
            s, &(iso_shading_shown){&mixed, k, code, ISO_FROM_CODES, NULL, ldexp(step_of_views, (int)k)}, e, err);
    }
    iso_sampler_destroy(&sampler);
    free(mixed.scalar);
    return status;
}

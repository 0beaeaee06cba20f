/* SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdlib.h>

#include "base/order.h"
#include "render/sampler.h"
#include "validate/measured.h"

enum { WANTED = 100000 }; /* voxels */

/* Angles at the fine voxels that count, which are the same for all methods. */
typedef struct angles {
    double *deg;
    size_t *block; /* of 2 x 2 x 2 of the level's voxels */
    size_t count, block_count;
} angles;

static void destroy_angles(angles *a)
{
    free(a->deg);
    free(a->block);
}

static iso_status create_angles(angles *a, const iso_geometry *g, size_t level, size_t room, iso_error *err)
{
    a->deg = malloc(room * sizeof *a->deg);
    a->block = malloc(room * sizeof *a->block);
    a->block_count = 1;
    for (int k = 0; k < 3; ++k)
        a->block_count *= (g->size[k] >> (level + 1)) + 1;
    return a->deg && a->block ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "no memory for the angles of %zu voxels", room);
}

/* Returns the index of the voxel's block; x fastest. */
static size_t block_of(const iso_geometry *g, size_t level, const size_t at[3])
{
    const size_t shift = level + 1, nx = (g->size[0] >> shift) + 1, ny = (g->size[1] >> shift) + 1;
    return ((at[2] >> shift) * ny + (at[1] >> shift)) * nx + (at[0] >> shift);
}

static void collect_angles(const iso_validation *v, size_t level, const iso_sampler *fine, const iso_sampler *coarse,
                           size_t stride, angles *out)
{
    const iso_level *level0 = &v->pyramid->levels[0];
    const iso_geometry *g = &level0->geometry;
    for (size_t i = 0, total = iso_geometry_voxel_count(g); i < total; i += stride) {
        const size_t at[3] = {i % g->size[0], i / g->size[0] % g->size[1], i / (g->size[0] * g->size[1])};
        const iso_vec3 center = {(double)at[0] + 0.5, (double)at[1] + 0.5, (double)at[2] + 0.5};
        double rgbs[4];
        iso_tf_lookup(&v->view->tf, (double)level0->scalar[i], rgbs);
        const iso_vec3 a = iso_sample_normal(fine, center);
        if (rgbs[3] <= 0 || iso_norm(a) < 0.5)
            continue;
        const iso_vec3 b =
            iso_normalize(iso_sample_normal(coarse, iso_scale(center, 1 / (double)((size_t)1 << level))));
        /* No direction at all counts as a right angle. */
        out->deg[out->count] = acos(fmin(fmax(iso_dot(iso_normalize(a), b), -1), 1)) * (180 / 3.14159265358979323846);
        out->block[out->count++] = block_of(g, level, at);
    }
}

/* Measures the angles. *out has to be destroyed, also after a failure. */
static iso_status measure(const iso_validation *v, size_t level, iso_angles_of of, angles *out, iso_error *err)
{
    OWNED(iso_sampler) fine = {0}, coarse = {0};
    const iso_geometry *g = &v->pyramid->levels[0].geometry;
    const size_t total = iso_geometry_voxel_count(g), stride = total / WANTED | 1;
    *out = (angles){0};
    NEED(iso_sampler_create(&fine, &v->pyramid->levels[0], v->pyramid->options.code, ISO_FROM_CODES, err));
    NEED(iso_sampler_create(&coarse, &of.pyramid->levels[level], of.pyramid->options.code, of.source, err));
    NEED(create_angles(out, g, level, total / stride + 1, err));
    collect_angles(v, level, &fine, &coarse, stride, out);
    return ISO_OK;
}

iso_status iso_validate_angles(const iso_validation *v, const iso_pyramid *p, size_t level, iso_direction_source source,
                               iso_level_angles *out, iso_error *err)
{
    angles a;
    const iso_status status = measure(v, level, (iso_angles_of){p, source}, &a, err);
    double sum = 0;
    *out = (iso_level_angles){NAN, NAN};
    for (size_t i = 0; i < a.count; ++i)
        sum += a.deg[i];
    if (a.count > 0) {
        qsort(a.deg, a.count, sizeof *a.deg, iso_order_doubles);
        out->mean = sum / (double)a.count;
        out->p95 = a.deg[(size_t)(0.95 * (double)(a.count - 1))];
    }
    destroy_angles(&a);
    return status;
}

iso_status iso_validate_compare_angles(const iso_validation *v, size_t level, iso_angles_of a, iso_angles_of b,
                                       double confidence, iso_paired *difference, iso_error *err)
{
    angles of_a, of_b = {0};
    iso_status status = measure(v, level, a, &of_a, err);
    TRY(status, measure(v, level, b, &of_b, err));
    for (size_t i = 0; i < of_a.count && status == ISO_OK; ++i)
        of_a.deg[i] -= of_b.deg[i];
    TRY(status, iso_paired_of_groups(of_a.deg, of_a.block, of_a.count, of_a.block_count, confidence, difference, err));
    destroy_angles(&of_a);
    destroy_angles(&of_b);
    return status;
}

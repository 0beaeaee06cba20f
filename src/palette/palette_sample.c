/* SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "palette/palette.h"

/* Gradients of about half a million voxels at a time, which stay in the cache until they are pooled. */
#define SLAB_VOXELS ((size_t)1 << 19)

static float table_weight(const iso_palette_weighting *w, float value)
{
    double last = (double)(w->by_value_count - 1);
    double x = ((double)value - w->by_value_lo) / (w->by_value_hi - w->by_value_lo) * last;
    x = x > 0 ? (x < last ? x : last) : 0; /* NaN and a range of one value give 0 */
    size_t i = (size_t)x < w->by_value_count - 2 ? (size_t)x : w->by_value_count - 2;
    double f = x - (double)i;
    return (float)((1 - f) * (double)w->by_value[i] + f * (double)w->by_value[i + 1]);
}

/* Computes the weights of a row. scale: 1 / largest possible magnitude. */
static void weigh_row(const iso_palette_weighting *w, const float *restrict vectors, const float *restrict magnitudes,
                      const float *restrict scalars, float scale, size_t count, float *restrict out)
{
    for (size_t i = 0; i < count; ++i) {
        const float *g = vectors + 3 * i;
        float weight = 1;
        if (w->by_magnitude)
            weight = scale * (magnitudes ? magnitudes[i] : sqrtf(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]));
        if (w->by_value)
            weight *= table_weight(w, scalars[i]);
        out[i] = weight;
    }
}

static bool is_weighted(const iso_palette_weighting *w)
{
    return w && (w->by_magnitude || w->by_value);
}

static iso_status check_weighting(const iso_palette_weighting *w, iso_error *err)
{
    if (w && w->by_value && w->by_value_count < 2)
        return iso_fail(err, ISO_E_RANGE, "palette: table of %zu weights, must have at least 2", w->by_value_count);
    return ISO_OK;
}

/* How to sample a volume, and the memory for a slab of it. */
typedef struct slab_buffers {
    const iso_gradient_options *gradient;
    const iso_palette_weighting *weighting;
    size_t capacity;                  /* voxels */
    float *gradients, *weights, *row; /* row: one per thread */
    int threads;
} slab_buffers;

static iso_status buffers_create(slab_buffers *b, const iso_geometry *g, size_t planes, int threads, iso_error *err)
{
    b->threads = iso_threads(threads);
    b->capacity = g->size[0] * g->size[1] * planes;
    b->gradients = malloc(3 * b->capacity * sizeof *b->gradients);
    b->weights = malloc(b->capacity * sizeof *b->weights);
    b->row = malloc(g->size[0] * (size_t)b->threads * sizeof *b->row);
    if (b->gradients && b->weights && b->row)
        return ISO_OK;
    return iso_fail(err, ISO_E_MEMORY, "palette: no memory for a slab of %zu voxels", b->capacity);
}

static void buffers_destroy(slab_buffers *b)
{
    free(b->gradients);
    free(b->weights);
    free(b->row);
}

static size_t slab_planes(const iso_geometry *g)
{
    size_t plane = g->size[0] * g->size[1], planes = SLAB_VOXELS / plane;
    return planes < 1 ? 1 : planes < g->size[2] ? planes : g->size[2];
}

/* Adds the planes [z0, z1) of v to the pool. */
static iso_status pool_planes(iso_direction_pool *pool, const iso_volume *v, size_t z0, size_t z1, slab_buffers *b,
                              iso_error *err)
{
    const iso_palette_weighting *w = b->weighting;
    const size_t nx = v->geometry.size[0], ny = v->geometry.size[1], rows = ny * (z1 - z0);
    NEED(iso_gradient_slab(v, b->gradient, z0, z1, b->gradients, err));
    if (is_weighted(w)) {
        /* No difference of neighbors exceeds the range per step of the least spacing, along each axis. */
        double most = sqrt(3) * w->value_span / iso_geometry_min_spacing_mm(&v->geometry);
        float scale = most > 0 ? (float)(1 / most) : 0;
#pragma omp parallel for schedule(static) num_threads(b->threads)
        for (size_t i = 0; i < rows; ++i) {
            float *scalars = b->row + nx * (size_t)iso_thread_index();
            iso_volume_row(v, i % ny, z0 + i / ny, scalars);
            weigh_row(w, b->gradients + 3 * nx * i, NULL, scalars, scale, nx, b->weights + nx * i);
        }
    }
    iso_direction_pool_add(pool, b->gradients, is_weighted(w) ? b->weights : NULL, nx * rows);
    return ISO_OK;
}

iso_status iso_palette_sample_volume(iso_direction_pool *pool, const iso_volume *v,
                                     const iso_gradient_options *gradient, const iso_palette_weighting *w,
                                     const iso_progress *progress, iso_error *err)
{
    const size_t nz = v->geometry.size[2], planes = slab_planes(&v->geometry);
    ENDED_BY(buffers_destroy) slab_buffers b = {.gradient = gradient, .weighting = w};
    iso_status status = check_weighting(w, err);
    TRY(status, buffers_create(&b, &v->geometry, planes, gradient->threads, err));
    for (size_t z = 0; z < nz && status == ISO_OK; z += planes) {
        status = pool_planes(pool, v, z, z + planes < nz ? z + planes : nz, &b, err);
        iso_progress_report(progress, "directions", (double)(z + planes) / (double)nz);
    }
    return status;
}

/* Slides a window of planes over the source: one before the slab, the slab, one after it, so that its gradients are
 * those of the whole volume.
 *
 *     window planes   | before |  slab ...  | after |
 *     next window                  | before |  slab ... */
iso_status iso_palette_sample_source(iso_direction_pool *pool, iso_volume_source *source,
                                     const iso_gradient_options *gradient, const iso_palette_weighting *w,
                                     const iso_progress *progress, iso_error *err)
{
    const iso_volume *header = iso_source_volume(source);
    const size_t nz = header->geometry.size[2], planes = slab_planes(&header->geometry);
    const size_t plane_bytes = header->geometry.size[0] * header->geometry.size[1] * iso_type_bytes(header->type);
    iso_volume window = *header;
    slab_buffers b = {.gradient = gradient, .weighting = w};
    window.data = malloc((planes + 2) * plane_bytes);
    iso_status status = check_weighting(w, err);
    if (status == ISO_OK && !window.data)
        status = iso_fail(err, ISO_E_MEMORY, "palette: no memory for %zu planes", planes + 2);
    TRY(status, buffers_create(&b, &header->geometry, planes, gradient->threads, err));
    size_t first = 0, have = 0; /* the window has the planes [first, have) */
    for (size_t z = 0; z < nz && status == ISO_OK; z += planes) {
        size_t end = z + planes < nz ? z + planes : nz, need = end < nz ? end + 1 : nz;
        size_t start = z > 0 ? z - 1 : 0;
        memmove(window.data, (char *)window.data + (start - first) * plane_bytes, (have - start) * plane_bytes);
        first = start;
        status = iso_source_read(source, need - have, (char *)window.data + (have - first) * plane_bytes, err);
        if (status != ISO_OK)
            break;
        have = need;
        window.geometry.size[2] = have - first;
        status = pool_planes(pool, &window, z - first, end - first, &b, err);
        iso_progress_report(progress, "directions", (double)end / (double)nz);
    }
    buffers_destroy(&b);
    free(window.data);
    return status;
}

iso_status iso_palette_sample_field(iso_direction_pool *pool, const float *vectors, const float *scalars,
                                    const float *magnitudes, size_t count, const iso_palette_weighting *w,
                                    iso_error *err)
{
    iso_status status = check_weighting(w, err);
    if (status != ISO_OK || !is_weighted(w)) {
        if (status == ISO_OK)
            iso_direction_pool_add(pool, vectors, NULL, count);
        return status;
    }
    float most = 0;
    for (size_t i = 0; magnitudes && i < count; ++i)
        most = magnitudes[i] > most ? magnitudes[i] : most;
    FREED float *weights = malloc((count + 1) * sizeof *weights);
    NEED_MEMORY(weights, err, "palette: no memory for %zu weights", count);
    weigh_row(w, vectors, magnitudes, scalars, magnitudes && most > 0 ? 1 / most : 1, count, weights);
    iso_direction_pool_add(pool, vectors, weights, count);
    return ISO_OK;
}

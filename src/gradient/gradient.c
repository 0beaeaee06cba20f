/* SPDX-License-Identifier: MIT */
#include "gradient/gradient.h"

#include <stdlib.h>

#include "base/parallel.h"
#include "base/simd.h"
#include "gradient/gradient_kernel.h"

#define ISO_GRADIENT_POINTER(method, row) [ISO_GRADIENT_##method] = &iso_gradient_##row,
static const iso_gradient_info *const methods[] = {ISO_GRADIENT_LIST(ISO_GRADIENT_POINTER)};
#undef ISO_GRADIENT_POINTER
const iso_names iso_gradient_names = ISO_NAMES_OF_POINTERS("gradient estimator", methods);

const iso_gradient_info *iso_gradient_describe(iso_gradient_method method)
{
    return methods[method];
}

iso_gradient_options iso_gradient_defaults(void)
{
    return (iso_gradient_options){.method = ISO_GRADIENT_CENTRAL};
}

const char *iso_gradient_name(iso_gradient_method method)
{
    return methods[method]->name;
}

iso_status iso_gradient_from_name(const char *name, iso_gradient_method *method, iso_error *err)
{
    size_t row = 0;
    NEED(iso_names_find(&iso_gradient_names, name, &row, err));
    *method = (iso_gradient_method)row;
    return ISO_OK;
}

/* Interleaves three planar rows as triples, in the caches. */
ISO_SIMD static void interleave(const float *restrict x, const float *restrict y, const float *restrict z, size_t n,
                                float *restrict out)
{
    for (size_t i = 0; i < n; ++i) {
        out[3 * i] = x[i];
        out[3 * i + 1] = y[i];
        out[3 * i + 2] = z[i];
    }
}

iso_status iso_gradient_slab(const iso_volume *v, const iso_gradient_options *opt, size_t z0, size_t z1,
                             float *restrict out, iso_error *err)
{
    const size_t *n = v->geometry.size, nx = n[0], ny = n[1];
    const int threads = iso_threads(opt->threads);
    if (z0 > z1 || z1 > n[2])
        return iso_fail(err, ISO_E_RANGE, "gradient: planes %zu to %zu, the volume has %zu", z0, z1, n[2]);
    const size_t scratch_count = 6 * nx + iso_gradient_scratch_count(nx);
    float *scratch = malloc((size_t)threads * scratch_count * sizeof *scratch);
    NEED_MEMORY(scratch, err, "gradient: no memory for %d threads' rows of %zu voxels", threads, nx);
    const iso_gradient_matrix matrix = iso_gradient_matrix_from(iso_geometry_gradient_to_world(&v->geometry));
    const iso_planes planes = {.data = v->data, .type = v->type, .size = {nx, ny, n[2]}, .count = n[2],
                               .has_no_data = v->geometry.has_no_data};
    const size_t row_count = ny * (z1 - z0);
#pragma omp parallel for schedule(static) num_threads(threads)
    for (size_t i = 0; i < row_count; ++i) {
        float *own = scratch + (size_t)iso_thread_index() * scratch_count, *row = own + 3 * nx;
        float *const g[3] = {own, own + nx, own + 2 * nx};
        iso_gradient_row(&planes, opt->method, &matrix, i % ny, z0 + i / ny, row + 3 * nx, g);
        interleave(g[0], g[1], g[2], nx, row);
        iso_copy_streaming(out + 3 * nx * i, row, 3 * nx * sizeof *row);
    }
    free(scratch);
    return ISO_OK;
}

iso_status iso_gradient_compute(const iso_volume *v, const iso_gradient_options *opt, float *restrict out,
                                iso_error *err)
{
    return iso_gradient_slab(v, opt, 0, v->geometry.size[2], out, err);
}

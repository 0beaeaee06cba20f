#include "gradient/gradient.h"

#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "gradient/gradient_kernel.h"

static const char *const method_names[ISO_GRADIENT_COUNT] = {"central"};

iso_gradient_options iso_gradient_defaults(void)
{
    return (iso_gradient_options){.method = ISO_GRADIENT_CENTRAL};
}

const char *iso_gradient_name(iso_gradient_method method)
{
    return method_names[method];
}

iso_status iso_gradient_from_name(const char *name, iso_gradient_method *method, iso_error *err)
{
    for (int i = 0; i < ISO_GRADIENT_COUNT; ++i) {
        if (strcmp(method_names[i], name) == 0) {
            *method = (iso_gradient_method)i;
            return ISO_OK;
        }
    }
    return iso_fail(err, ISO_E_USAGE, "unknown gradient method \"%s\", must be one of: central", name);
}

/* Gradient of the row (y, z), interleaved to out; work holds 8 rows. */
static void gradient_row(const iso_volume *v, const float m[9], size_t y, size_t z, float *restrict work,
                         float *restrict out)
{
    const size_t nx = v->geometry.size[0], ny = v->geometry.size[1], nz = v->geometry.size[2];
    const bool y_border = y == 0 || y + 1 == ny, z_border = z == 0 || z + 1 == nz;
    float *gx = work + 5 * nx, *gy = work + 6 * nx, *gz = work + 7 * nx;
    iso_volume_row(v, y, z, work);
    iso_volume_row(v, y > 0 ? y - 1 : 0, z, work + nx);
    iso_volume_row(v, y + 1 < ny ? y + 1 : y, z, work + 2 * nx);
    iso_volume_row(v, y, z > 0 ? z - 1 : 0, work + 3 * nx);
    iso_volume_row(v, y, z + 1 < nz ? z + 1 : z, work + 4 * nx);
    iso_gradient_rows rows = {work, work + nx, work + 2 * nx, work + 3 * nx, work + 4 * nx, y_border ? 1.0f : 0.5f,
                              z_border ? 1.0f : 0.5f};
    iso_gradient_row_central(&rows, nx, m, gx, gy, gz);
    for (size_t x = 0; x < nx; ++x) {
        out[3 * x] = gx[x];
        out[3 * x + 1] = gy[x];
        out[3 * x + 2] = gz[x];
    }
}

iso_status iso_gradient_slab(const iso_volume *v, const iso_gradient_options *opt, size_t z0, size_t z1,
                             float *restrict out, iso_error *err)
{
    const size_t nx = v->geometry.size[0], ny = v->geometry.size[1];
    const int threads = iso_threads(opt->threads);
    if (z0 > z1 || z1 > v->geometry.size[2])
        return iso_fail(err, ISO_E_RANGE, "gradient: planes %zu to %zu, the volume has %zu", z0, z1,
                        v->geometry.size[2]);
    float *work = malloc((size_t)threads * 8 * nx * sizeof *work);
    if (!work)
        return iso_fail(err, ISO_E_MEMORY, "gradient: no memory for %d threads' rows of %zu voxels", threads, nx);
    iso_mat3 to_world = iso_geometry_gradient_to_world(&v->geometry);
    float m[9];
    for (int i = 0; i < 9; ++i)
        m[i] = (float)to_world.m[i / 3][i % 3];
    const size_t row_count = ny * (z1 - z0);
#pragma omp parallel num_threads(threads)
    {
        float *mine = work + (size_t)iso_thread_index() * 8 * nx;
#pragma omp for schedule(static)
        for (size_t i = 0; i < row_count; ++i)
            gradient_row(v, m, i % ny, z0 + i / ny, mine, out + 3 * nx * i);
    }
    free(work);
    return ISO_OK;
}

iso_status iso_gradient_compute(const iso_volume *v, const iso_gradient_options *opt, float *restrict out,
                                iso_error *err)
{
    return iso_gradient_slab(v, opt, 0, v->geometry.size[2], out, err);
}

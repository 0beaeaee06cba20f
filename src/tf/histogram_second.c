/* SPDX-License-Identifier: MIT */
/* histogram_second.c - the second value of a 2D transfer function: deviation or gradient magnitude. */
#include <math.h>
#include <stdlib.h>

#include "base/parallel.h"
#include "gradient/gradient.h"
#include "tf/histogram.h"

static double deviation_coordinate(const float *fine, const size_t n[3], size_t level, const size_t at[3],
                                   double half_range)
{
    size_t lo[3], hi[3], count = 1;
    for (int a = 0; a < 3; ++a) {
        lo[a] = at[a] << level;
        hi[a] = lo[a] + ((size_t)1 << level) < n[a] ? lo[a] + ((size_t)1 << level) : n[a];
        count *= hi[a] - lo[a];
    }
    const double shift = (double)fine[(lo[2] * n[1] + lo[1]) * n[0] + lo[0]]; /* avoids cancellation */
    double sum = 0, square = 0;
    for (size_t z = lo[2]; z < hi[2]; ++z)
        for (size_t y = lo[1]; y < hi[1]; ++y) {
            const float *row = fine + (z * n[1] + y) * n[0];
            for (size_t x = lo[0]; x < hi[0]; ++x) {
                double d = (double)row[x] - shift;
                sum += d;
                square += d * d;
            }
        }
    double mean = sum / (double)count, variance = fmax(square / (double)count - mean * mean, 0);
    return half_range > 0 ? (ISO_TF_2D_ROWS - 1) * sqrt(fmin(sqrt(variance) / half_range, 1)) : 0;
}

static void deviation_coordinates(const iso_level *fine, const size_t size[3], size_t level, int threads, float *out)
{
    const double half_range = (fine->max - fine->min) / 2;
    size_t rows = size[2] * size[1];
#pragma omp parallel for schedule(static) num_threads(iso_threads(threads))
    for (size_t r = 0; r < rows; ++r)
        for (size_t x = 0; x < size[0]; ++x) {
            const size_t at[3] = {x, r % size[1], r / size[1]};
            out[r * size[0] + x] = (float)deviation_coordinate(fine->scalar, fine->geometry.size, level, at,
                                                               half_range);
        }
}

/* Computes |central difference| of the level's scalar, in value per voxel, plane by plane. */
static iso_status gradient_coordinates(const iso_level *level, double half_range, int threads, float *out,
                                       iso_error *err)
{
    const size_t *n = level->geometry.size;
    const iso_volume v = {.geometry = iso_geometry_axis_aligned(n, (const double[3]){1, 1, 1}),
                          .type = ISO_F32,
                          .data = level->scalar};
    iso_gradient_options opt = iso_gradient_defaults();
    size_t plane = n[0] * n[1];
    opt.threads = threads;
    FREED float *g = malloc(3 * plane * sizeof *g);
    NEED_MEMORY(g, err, "joint histogram: no memory for a plane of gradients");
    for (size_t z = 0; z < n[2]; ++z) {
        NEED(iso_gradient_slab(&v, &opt, z, z + 1, g, err));
        for (size_t i = 0; i < plane; ++i) {
            double magnitude = sqrt((double)g[3 * i] * g[3 * i] + (double)g[3 * i + 1] * g[3 * i + 1] +
                                    (double)g[3 * i + 2] * g[3 * i + 2]);
            out[z * plane + i] = half_range > 0 ? (float)((ISO_TF_2D_ROWS - 1) * sqrt(fmin(magnitude / half_range, 1)))
                                                : 0;
        }
    }
    return ISO_OK;
}

iso_status iso_joint_second_coordinates(const iso_pyramid *p, size_t level, iso_second_value second, int threads,
                                        float *out, iso_error *err)
{
    const iso_level *fine = &p->levels[0];
    const double half_range = (fine->max - fine->min) / 2;
    if (second == ISO_SECOND_VALUE_GRADIENT)
        return gradient_coordinates(&p->levels[level], half_range, threads, out, err);
    deviation_coordinates(fine, p->levels[level].geometry.size, level, threads, out);
    return ISO_OK;
}

/* SPDX-License-Identifier: MIT */
#include "lab/denoise.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { REACH = 2 };

static size_t count_of(const size_t size[3])
{
    return size[0] * size[1] * size[2];
}

static size_t clamp(ptrdiff_t i, size_t n)
{
    return i < 0 ? 0 : (size_t)i < n ? (size_t)i : n - 1;
}

static int compare_floats(const void *a, const void *b)
{
    const float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

/* Returns the second difference (1 -2 1) along x, y and z at once. */
static double second_differences(const float *v, const size_t n[3], size_t x, size_t y, size_t z)
{
    static const double weights[3] = {1, -2, 1};
    double sum = 0;
    for (size_t k = 0; k < 3; ++k)
        for (size_t j = 0; j < 3; ++j)
            for (size_t i = 0; i < 3; ++i)
                sum += weights[i] * weights[j] * weights[k] *
                       (double)v[x + i - 1 + n[0] * (y + j - 1 + n[1] * (z + k - 1))];
    return sum;
}

iso_status iso_noise_estimate(const float *values, const size_t size[3], double *deviation, iso_error *err)
{
    size_t count = 0;
    float *found = malloc((count_of(size) + 1) * sizeof *found);
    if (!found)
        return iso_fail(err, ISO_E_MEMORY, "no memory for the noise of %zu voxels", count_of(size));
    for (size_t z = 1; z + 1 < size[2]; ++z)
        for (size_t y = 1; y + 1 < size[1]; ++y)
            for (size_t x = 1; x + 1 < size[0]; ++x) {
                const double d = fabs(second_differences(values, size, x, y, z));
                if (d > 0)
                    found[count++] = (float)d;
            }
    qsort(found, count, sizeof *found, compare_floats);
    *deviation = count > 0 ? (double)found[count / 2] / (0.6745 * sqrt(216)) : 0;
    free(found);
    return ISO_OK;
}

/* ---- non-local means ---- */

/* Averages three neighbors along an axis of the given stride, in place; the border voxel is repeated. */
static void mean_of_three(float *v, const size_t n[3], int axis)
{
    const size_t stride = axis == 0 ? 1 : axis == 1 ? n[0] : n[0] * n[1], count = count_of(n);
#pragma omp parallel for schedule(static)
    for (size_t line = 0; line < count / n[axis]; ++line) {
        const size_t start = line / stride * stride * n[axis] + line % stride;
        float before = v[start];
        for (size_t i = 0; i < n[axis]; ++i) {
            const size_t at = start + i * stride;
            const float here = v[at], after = i + 1 < n[axis] ? v[at + stride] : here;
            v[at] = (before + here + after) / 3;
            before = here;
        }
    }
}

/* Computes squared differences to the volume moved by (dx, dy, dz), averaged around each voxel. */
static void patch_distances(const float *v, const size_t n[3], const ptrdiff_t move[3], float *out)
{
#pragma omp parallel for schedule(static)
    for (size_t z = 0; z < n[2]; ++z)
        for (size_t y = 0; y < n[1]; ++y) {
            const float *row = v + n[0] * (y + n[1] * z);
            const float *moved = v + n[0] * (clamp((ptrdiff_t)y + move[1], n[1]) +
                                             n[1] * clamp((ptrdiff_t)z + move[2], n[2]));
            for (size_t x = 0; x < n[0]; ++x) {
                const float d = row[x] - moved[clamp((ptrdiff_t)x + move[0], n[0])];
                out[x + n[0] * (y + n[1] * z)] = d * d;
            }
        }
    for (int axis = 0; axis < 3; ++axis)
        mean_of_three(out, n, axis);
}

static void add_moved(const float *v, const size_t n[3], const ptrdiff_t move[3], double deviation,
                      const float *distances, float *sums, float *weights)
{
    const float floor = (float)(2 * deviation * deviation), scale = (float)(1 / (0.36 * deviation * deviation));
#pragma omp parallel for schedule(static)
    for (size_t z = 0; z < n[2]; ++z)
        for (size_t y = 0; y < n[1]; ++y) {
            const float *moved = v + n[0] * (clamp((ptrdiff_t)y + move[1], n[1]) +
                                             n[1] * clamp((ptrdiff_t)z + move[2], n[2]));
            for (size_t x = 0; x < n[0]; ++x) {
                const size_t i = x + n[0] * (y + n[1] * z);
                const float weight = expf(-fmaxf(distances[i] - floor, 0) * scale);
                sums[i] += weight * moved[clamp((ptrdiff_t)x + move[0], n[0])];
                weights[i] += weight;
            }
        }
}

iso_status iso_denoise(const float *values, const size_t size[3], double deviation, float *out, iso_error *err)
{
    const size_t count = count_of(size);
    if (!(deviation > 0)) {
        memcpy(out, values, count * sizeof *out);
        return ISO_OK;
    }
    float *distances = malloc(count * sizeof *distances), *weights = calloc(count, sizeof *weights);
    if (!distances || !weights) {
        free(distances);
        free(weights);
        return iso_fail(err, ISO_E_MEMORY, "no memory for non-local means of %zu voxels", count);
    }
    memset(out, 0, count * sizeof *out);
    for (ptrdiff_t dz = -REACH; dz <= REACH; ++dz)
        for (ptrdiff_t dy = -REACH; dy <= REACH; ++dy)
            for (ptrdiff_t dx = -REACH; dx <= REACH; ++dx) {
                const ptrdiff_t move[3] = {dx, dy, dz};
                patch_distances(values, size, move, distances);
                add_moved(values, size, move, deviation, distances, out, weights);
            }
    for (size_t i = 0; i < count; ++i)
        out[i] /= weights[i];
    free(distances);
    free(weights);
    return ISO_OK;
}

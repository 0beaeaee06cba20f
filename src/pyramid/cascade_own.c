/* SPDX-License-Identifier: MIT */
/* cascade_own.c - inputs of damped least-squares levels besides the solution. They are the mean of the fine voxels that
 * a coarse voxel covers (its own voxels), and their range, to which the solution of level 1 is clamped. A task adds its
 * rows of fine voxels. When a row of own voxels is complete, it is reduced along x and added to planes that are kept
 * next to the level's planes. */
#include <float.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "base/simd.h"
#include "pyramid/cascade_spline.h"

ISO_SIMD static void halve_mean(const float *restrict v, size_t n, float *restrict out)
{
    for (size_t i = 0; i < n; ++i)
        out[i] = 0.5f * (v[2 * i] + v[2 * i + 1]);
}

/* Adds half of the mean of each pair of voxels of two rows, a and b, or extends the voxel's range by theirs. */
ISO_SIMD static void add_mean(const float *restrict a, const float *restrict b, size_t n, float *restrict plane)
{
    for (size_t i = 0; i < n; ++i) {
        const float first = 0.5f * a[2 * i] + 0.5f * b[2 * i], second = 0.5f * a[2 * i + 1] + 0.5f * b[2 * i + 1];
        plane[i] += 0.5f * (0.5f * (first + second));
    }
}

ISO_SIMD static void extend_low(const float *restrict a, const float *restrict b, size_t n, float *restrict plane)
{
    for (size_t i = 0; i < n; ++i) {
        const float first = b[2 * i] < a[2 * i] ? b[2 * i] : a[2 * i],
                    second = b[2 * i + 1] < a[2 * i + 1] ? b[2 * i + 1] : a[2 * i + 1],
                    low = second < first ? second : first;
        plane[i] = low < plane[i] ? low : plane[i];
    }
}

ISO_SIMD static void extend_high(const float *restrict a, const float *restrict b, size_t n, float *restrict plane)
{
    for (size_t i = 0; i < n; ++i) {
        const float first = b[2 * i] > a[2 * i] ? b[2 * i] : a[2 * i],
                    second = b[2 * i + 1] > a[2 * i + 1] ? b[2 * i + 1] : a[2 * i + 1],
                    high = second > first ? second : first;
        plane[i] = high > plane[i] ? high : plane[i];
    }
}

static void fill(float value, size_t n, float *row)
{
    for (size_t i = 0; i < n; ++i)
        row[i] = value;
}

/* ---- planes ---- */

/* Numbers kept per voxel: the mean, which counts voxels beyond the volume as zeros, and at level 1 the range. */
enum { MEAN, LOW, HIGH, NUMBERS };
static const float empty[NUMBERS] = {0, FLT_MAX, -FLT_MAX};

static size_t numbers_of(const spline_level *s)
{
    return s->axis[0].ratio == 2 ? NUMBERS : 1;
}

size_t iso_own_floats(const spline_level *s)
{
    return numbers_of(s) * s->slot_count * spline_plane_floats(s);
}

bool iso_own_create(spline_level *s)
{
    s->own = calloc(iso_own_floats(s), sizeof *s->own);
    return s->own;
}

static float *own_row(const spline_level *s, int number, size_t y, size_t z)
{
    return s->own + ((size_t)number * s->slot_count + z % s->slot_count) * spline_plane_floats(s) +
           y * s->axis[0].coarse;
}

/* ---- rows ---- */

size_t iso_own_scratch(const spline_level *s)
{
    return 2 * iso_spline_padded(&s->axis[0]);
}

void iso_own_begin(const spline_level *s, size_t z, size_t j0, size_t j1, float *memory, own_rows *t)
{
    const size_t padded = iso_spline_padded(&s->axis[0]);
    *t = (own_rows){.z = z, .j0 = j0, .j1 = j1, .row = SIZE_MAX, .sums = {memory, memory + padded}};
}

/* ---- rows of level 1: the two fine rows of a row of own voxels are kept, and go into its planes together ---- */

enum { FIRST, SECOND };

static void close_pair(const spline_level *s, own_rows *t)
{
    const size_t nx = s->axis[0].coarse, n = s->axis[0].fine;
    float *a = t->sums[FIRST], *b = t->sums[SECOND], *planes[NUMBERS];
    for (int i = 0; i < NUMBERS; ++i) {
        planes[i] = own_row(s, i, t->row, t->z / 2);
        if (t->z % 2 == 0)
            fill(empty[i], nx, planes[i]);
    }
    if (t->count == 1)
        fill(0, 2 * nx, b);
    if (n < 2 * nx) /* beyond the volume zeros in the mean ... */
        a[n] = b[n] = 0;
    add_mean(a, b, nx, planes[MEAN]);
    if (n < 2 * nx) { /* ... and nothing in the range */
        a[n] = a[n - 1];
        b[n] = b[n - 1];
    }
    extend_low(a, t->count == 1 ? a : b, nx, planes[LOW]);
    extend_high(a, t->count == 1 ? a : b, nx, planes[HIGH]);
}

/* ---- rows of coarser levels: added up, and reduced along x ---- */

static void close_sums(const spline_level *s, const own_rows *t)
{
    const size_t nx = s->axis[0].coarse, ratio = s->axis[0].ratio;
    float *from = t->sums[0], *to = t->sums[1], *plane = own_row(s, MEAN, t->row, t->z / ratio);
    for (size_t n = nx * ratio / 2; n >= nx; n /= 2) {
        halve_mean(from, n, to);
        float *used = from;
        from = to, to = used;
    }
    if (t->z % ratio == 0)
        fill(empty[MEAN], nx, plane);
    iso_add_weighted_row((float)(1 / (double)ratio), from, nx, plane);
}

void iso_own_end(const spline_level *s, own_rows *t)
{
    if (t->row != SIZE_MAX && numbers_of(s) == NUMBERS)
        close_pair(s, t);
    else if (t->row != SIZE_MAX)
        close_sums(s, t);
    t->row = SIZE_MAX;
}

void iso_own_row(const spline_level *s, size_t y, const float *row, own_rows *t)
{
    const size_t ratio = s->axis[1].ratio, j = y / ratio, n = s->axis[0].fine;
    const bool has_range = numbers_of(s) == NUMBERS;
    if (j < t->j0 || j >= t->j1)
        return;
    if (j != t->row) {
        iso_own_end(s, t);
        t->row = j;
        t->count = 0;
        if (!has_range)
            fill(empty[MEAN], s->axis[0].coarse * ratio, t->sums[0]);
    }
    if (has_range)
        memcpy(t->sums[t->count++], row, n * sizeof *row);
    else
        iso_add_weighted_row((float)(1 / (double)ratio), row, n, t->sums[0]);
}

void iso_own_cells(const spline_level *s, size_t size, size_t cell_y, size_t cell_z, const float *means, size_t cells)
{
    const size_t ratio = s->axis[0].ratio / size; /* cells along an edge of a voxel */
    const double part = 1 / (double)(ratio * ratio * ratio);
    float *plane = own_row(s, MEAN, cell_y / ratio, cell_z / ratio);
    for (size_t x = 0; x < cells; ++x)
        plane[x / ratio] += (float)part * means[x];
}

/* ---- damping ---- */

/* Returns the factor along an axis that makes up for voxels beyond the volume, which the mean counted. */
static double refill(const iso_spline_axis *a, size_t j)
{
    const size_t left = a->fine - j * a->ratio;
    return left < a->ratio ? (double)a->ratio / (double)left : 1;
}

void iso_own_damp(const spline_level *s, size_t y, size_t z, float *row)
{
    const size_t nx = s->axis[0].coarse;
    const bool has_range = numbers_of(s) == NUMBERS;
    const float *mean = own_row(s, MEAN, y, z), *low = has_range ? own_row(s, LOW, y, z) : NULL,
                *high = has_range ? own_row(s, HIGH, y, z) : NULL;
    const float of_row = (float)(refill(&s->axis[1], y) * refill(&s->axis[2], z)),
                of_last = (float)((double)of_row * refill(&s->axis[0], nx - 1));
    for (size_t x = 0; x < nx; ++x) {
        if (has_range)
            row[x] = row[x] < low[x] ? low[x] : row[x] > high[x] ? high[x] : row[x];
        const float own = (x + 1 < nx ? of_row : of_last) * mean[x];
        row[x] = own + ISO_DAMPED_PART * (row[x] - own);
    }
}

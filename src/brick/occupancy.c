/* SPDX-License-Identifier: MIT */
#include "brick/occupancy.h"

#include <stdlib.h>

#include "base/parallel.h"

/* Extends min_max by the voxels [lo, hi) of one row. */
static void extend(const float *row, size_t lo, size_t hi, float min_max[2])
{
    for (size_t x = lo; x < hi; ++x) {
        min_max[0] = row[x] < min_max[0] ? row[x] : min_max[0];
        min_max[1] = row[x] > min_max[1] ? row[x] : min_max[1];
    }
}

/* Computes the range [lo, hi) of voxels that brick b of n voxels needs along an axis of `size`. */
static void brick_extent(size_t b, size_t n, size_t size, size_t *lo, size_t *hi)
{
    *lo = b * n > 0 ? b * n - 1 : 0;
    *hi = (b + 1) * n + 1 < size ? (b + 1) * n + 1 : size;
}

iso_status iso_brick_ranges_create(iso_brick_ranges *r, const float *scalar, const iso_geometry *g, size_t brick_voxels,
                                   iso_error *err)
{
    *r = (iso_brick_ranges){.brick_voxels = brick_voxels};
    if (brick_voxels == 0)
        return iso_fail(err, ISO_E_RANGE, "bricks have 0 voxels per side, must be at least 1");
    for (int a = 0; a < 3; ++a)
        r->count[a] = (g->size[a] + brick_voxels - 1) / brick_voxels;
    size_t count = iso_brick_ranges_count(r);
    r->min_max = malloc(2 * count * sizeof *r->min_max);
    NEED_MEMORY(r->min_max, err, "no memory for the ranges of %zu bricks", count);
#pragma omp parallel for schedule(static) num_threads(iso_threads(0))
    for (size_t i = 0; i < count; ++i) {
        size_t b[3] = {i % r->count[0], i / r->count[0] % r->count[1], i / (r->count[0] * r->count[1])};
        size_t lo[3], hi[3];
        for (int a = 0; a < 3; ++a)
            brick_extent(b[a], brick_voxels, g->size[a], &lo[a], &hi[a]);
        float *min_max = r->min_max + 2 * i;
        min_max[0] = min_max[1] = scalar[lo[0] + g->size[0] * (lo[1] + g->size[1] * lo[2])];
        for (size_t z = lo[2]; z < hi[2]; ++z)
            for (size_t y = lo[1]; y < hi[1]; ++y)
                extend(scalar + g->size[0] * (y + g->size[1] * z), lo[0], hi[0], min_max);
    }
    return ISO_OK;
}

void iso_brick_ranges_destroy(iso_brick_ranges *r)
{
    if (!r)
        return;
    free(r->min_max);
    *r = (iso_brick_ranges){0};
}

static iso_tf_shown measures_of(const iso_tf_table *tf)
{
    return (iso_tf_shown){.lo = tf->lo,
                          .scale = (double)(tf->count - 1) / (tf->hi - tf->lo),
                          .last = (double)(tf->count - 1)};
}

iso_tf_shown iso_tf_shown_of(const iso_tf_table *tf, uint32_t *next)
{
    iso_tf_shown s = measures_of(tf);
    uint32_t found = (uint32_t)tf->count;
    for (size_t i = tf->count; i-- > 0;) {
        if (tf->entries[4 * i + 3] > 0)
            found = (uint32_t)i;
        next[i] = found;
    }
    s.next = next;
    return s;
}

bool iso_tf_shows(const iso_tf_table *tf, double min, double max)
{
    const iso_tf_shown s = measures_of(tf);
    size_t from, to;
    iso_tf_entries_of(&s, min, max, &from, &to);
    for (size_t i = from; i <= to; ++i)
        if (tf->entries[4 * i + 3] > 0)
            return true;
    return false;
}

/* Updates each chessboard distance to the least of the 26 neighbors plus one. Exact after a forward and a backward
 * sweep, each over the neighbors already visited [rosenfeld-1968]. */
static void sweep(const size_t count[3], uint8_t *distance, int direction)
{
    size_t n = count[0] * count[1] * count[2];
    for (size_t j = 0; j < n; ++j) {
        size_t i = direction > 0 ? j : n - 1 - j;
        long x = (long)(i % count[0]), y = (long)(i / count[0] % count[1]), z = (long)(i / (count[0] * count[1]));
        int least = distance[i];
        for (int o = 0; o < 13; ++o) { /* the neighbors visited before */
            long dx = o % 3 - 1, dy = o / 3 % 3 - 1, dz = o / 9 - 1;
            long qx = x + direction * dx, qy = y + direction * dy, qz = z + direction * dz;
            if (qx < 0 || qy < 0 || qz < 0 || qx >= (long)count[0] || qy >= (long)count[1] || qz >= (long)count[2])
                continue;
            int there = distance[(size_t)qx + count[0] * ((size_t)qy + count[1] * (size_t)qz)] + 1;
            least = there < least ? there : least;
        }
        distance[i] = (uint8_t)least;
    }
}

void iso_occupancy_distance(const size_t count[3], uint8_t *distance)
{
    sweep(count, distance, 1);
    sweep(count, distance, -1);
}

static int least_of(int a, int b)
{
    return a < b ? a : b;
}

/* Fills a row of an octant's map from the rows ahead of it along y, z and both; NULL outside the volume. */
static void fill_octant_row(size_t n, bool down, const uint8_t *occupied, const uint8_t *const ahead[3], uint8_t *out)
{
    int corner = ISO_OCTANT_MOST, side = ISO_OCTANT_MOST; /* next values along x: of the rows ahead, of this row */
    for (size_t j = 0; j < n; ++j) {
        const size_t x = down ? j : n - 1 - j;
        int beside = ISO_OCTANT_MOST;
        for (int i = 0; i < 3; ++i)
            beside = ahead[i] ? least_of(beside, ahead[i][x]) : beside;
        const int least = least_of(beside, least_of(corner, side));
        side = occupied[x] == 0 ? 0 : least_of(least + 1, ISO_OCTANT_MOST);
        corner = beside;
        out[x] = (uint8_t)side;
    }
}

/* Fills in the sides of empty cubes. A cube of side n + 1 with corner b consists of b and the seven cubes of side n
 * whose corners are next to b. */
static void fill_octant(const size_t count[3], int octant, const uint8_t *occupied, uint8_t *out)
{
    const size_t nx = count[0], ny = count[1], nz = count[2];
    const bool down_y = octant & 2, down_z = octant & 4;
    for (size_t j = 0; j < ny * nz; ++j) {
        const size_t i = j % ny, k = j / ny;
        const size_t y = down_y ? i : ny - 1 - i, z = down_z ? k : nz - 1 - k, row = nx * (y + ny * z);
        const size_t next_y = down_y ? row - nx : row + nx, step_z = nx * ny;
        const uint8_t *const ahead[3] = {
            i > 0 ? out + next_y : NULL,
            k > 0 ? out + (down_z ? row - step_z : row + step_z) : NULL,
            i > 0 && k > 0 ? out + (down_z ? next_y - step_z : next_y + step_z) : NULL,
        };
        fill_octant_row(nx, octant & 1, occupied + row, ahead, out + row);
    }
}

void iso_occupancy_octants(const size_t count[3], const uint8_t *occupied, int threads, uint8_t *restrict octants)
{
    const size_t bricks = count[0] * count[1] * count[2];
#pragma omp parallel for schedule(static) num_threads(iso_threads(threads))
    for (int octant = 0; octant < ISO_OCTANTS; ++octant)
        fill_octant(count, octant, occupied, octants + (size_t)octant * bricks);
}

double iso_occupancy_compute(const iso_brick_ranges *r, const iso_tf_table *tf, uint8_t *restrict distance)
{
    size_t count = iso_brick_ranges_count(r), occupied = 0;
    for (size_t i = 0; i < count; ++i) {
        bool shows = iso_tf_shows(tf, (double)r->min_max[2 * i], (double)r->min_max[2 * i + 1]);
        distance[i] = shows ? 0 : 255;
        occupied += shows;
    }
    iso_occupancy_distance(r->count, distance);
    return (double)occupied / (double)count;
}

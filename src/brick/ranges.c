/* SPDX-License-Identifier: MIT */
/* ranges.c - ranges of scalars, brick by brick: those of level 0 from its voxels, the others from their nodes. */
#include <math.h>
#include <stdlib.h>

#include "base/parallel.h"
#include "base/simd.h"
#include "brick/made_bricks.h"

/* Ranges of rows, column by column: of all rows of a row of bricks, and of those between their faces. */
typedef struct columns {
    float *row, *whole[2], *inner[2];
} columns;

static bool columns_create(columns *c, size_t count)
{
    *c = (columns){.row = malloc(5 * count * sizeof *c->row)};
    for (size_t i = 0; c->row && i < 2; ++i) {
        c->whole[i] = c->row + (1 + i) * count;
        c->inner[i] = c->row + (3 + i) * count;
    }
    return c->row != NULL;
}

ISO_SIMD static void widen(const float *restrict row, size_t count, float *restrict least, float *restrict most)
{
    for (size_t x = 0; x < count; ++x) {
        least[x] = row[x] < least[x] ? row[x] : least[x];
        most[x] = row[x] > most[x] ? row[x] : most[x];
    }
}

/* Voxels of a brick along an axis. */
typedef struct span {
    size_t first, last;
} span;

static span span_of(const iso_node_levels *n, int axis, size_t brick)
{
    const size_t first = brick * n->brick_voxels, end = first + n->brick_voxels, last = n->geometry.size[axis] - 1;
    return (span){first, end < last ? end : last};
}

/* True if the voxel is the place of a node between the brick's faces. The volume's last voxels are repeated. */
static bool is_inner(const iso_node_levels *n, span s, size_t i)
{
    return (i > s.first || s.last == s.first) && (i < s.last || s.last < s.first + n->brick_voxels);
}

static void take_range(const columns *c, span s, const iso_node_levels *n, iso_node_range *range)
{
    *range = (iso_node_range){{INFINITY, -INFINITY}, {INFINITY, -INFINITY}};
    for (size_t x = s.first; x <= s.last; ++x) {
        range->whole[0] = fminf(range->whole[0], c->whole[0][x]);
        range->whole[1] = fmaxf(range->whole[1], c->whole[1][x]);
        if (!is_inner(n, s, x))
            continue;
        range->inner[0] = fminf(range->inner[0], c->inner[0][x]);
        range->inner[1] = fmaxf(range->inner[1], c->inner[1][x]);
    }
}

/* Measures the bricks (., by, bz) of level 0. */
static void measure_voxels(const iso_node_levels *n, size_t by, size_t bz, const columns *c)
{
    const size_t nx = n->geometry.size[0];
    const span y = span_of(n, 1, by), z = span_of(n, 2, bz);
    for (size_t x = 0; x < nx; ++x) {
        c->whole[0][x] = c->inner[0][x] = INFINITY;
        c->whole[1][x] = c->inner[1][x] = -INFINITY;
    }
    for (size_t k = z.first; k <= z.last; ++k)
        for (size_t j = y.first; j <= y.last; ++j) {
            iso_node_levels_voxels(n, 0, j, k, nx, c->row);
            widen(c->row, nx, c->whole[0], c->whole[1]);
            if (is_inner(n, y, j) && is_inner(n, z, k))
                widen(c->row, nx, c->inner[0], c->inner[1]);
        }
    for (size_t bx = 0; bx < n->count[0]; ++bx)
        take_range(c, span_of(n, 0, bx), n, &n->ranges[0][iso_brick_index(n, (const size_t[]){bx, by, bz})]);
}

iso_node_range iso_own_nodes_range(iso_own_nodes own, size_t side)
{
    iso_node_range r = {{INFINITY, -INFINITY}, {INFINITY, -INFINITY}};
    for (size_t i = 0; i < side * side * side; ++i) {
        const size_t at[3] = {i % side, i / side % side, i / (side * side)};
        const float value = own.first[ISO_NODE_CHANNELS * at[0] + own.row * at[1] + own.plane * at[2]];
        bool on_face = false;
        for (int a = 0; a < 3; ++a)
            on_face = on_face || at[a] == 0 || at[a] + 1 == side;
        r.whole[0] = value < r.whole[0] ? value : r.whole[0];
        r.whole[1] = value > r.whole[1] ? value : r.whole[1];
        if (on_face)
            continue;
        r.inner[0] = value < r.inner[0] ? value : r.inner[0];
        r.inner[1] = value > r.inner[1] ? value : r.inner[1];
    }
    return r;
}

/* Measures a brick at a level whose nodes are all there. */
static void measure_nodes(const iso_node_levels *n, size_t level, const size_t brick[3])
{
    const size_t side = iso_brick_side(n, level), nx = iso_node_count(n, level, 0), ny = iso_node_count(n, level, 1);
    const size_t first = (side - 1) * (brick[0] + nx * (brick[1] + ny * brick[2])), row = ISO_NODE_CHANNELS * nx;
    const iso_own_nodes own = {n->nodes[level] + ISO_NODE_CHANNELS * first, row, row * ny};
    n->ranges[level][iso_brick_index(n, brick)] = iso_own_nodes_range(own, side);
}

iso_status iso_node_levels_measure_ranges(iso_node_levels *n, int threads, iso_error *err)
{
    const size_t count = iso_brick_count(n);
    bool failed = false;
    for (size_t l = 0; l < n->level_count; ++l) {
        free(n->ranges[l]);
        n->ranges[l] = l == 0 || n->nodes[l] ? malloc(count * sizeof **n->ranges) : NULL;
        failed = failed || ((l == 0 || n->nodes[l]) && !n->ranges[l]);
    }
    if (failed)
        return iso_fail(err, ISO_E_MEMORY, "bricks: no memory for the ranges of %zu bricks", count);
#pragma omp parallel num_threads(iso_threads(threads)) reduction(|| : failed)
    {
        columns c;
        failed = !columns_create(&c, n->geometry.size[0]);
#pragma omp for schedule(dynamic)
        for (size_t i = 0; i < n->count[1] * n->count[2]; ++i) {
            const size_t by = i % n->count[1], bz = i / n->count[1];
            if (!failed)
                measure_voxels(n, by, bz, &c);
            for (size_t l = 1; l < n->level_count; ++l)
                for (size_t bx = 0; n->nodes[l] && bx < n->count[0]; ++bx)
                    measure_nodes(n, l, (const size_t[]){bx, by, bz});
        }
        free(c.row);
    }
    return failed ? iso_fail(err, ISO_E_MEMORY, "bricks: no memory for rows of voxels") : ISO_OK;
}

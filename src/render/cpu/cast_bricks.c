/* SPDX-License-Identifier: MIT */
#include "render/cpu/cast_bricks.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "brick/occupancy.h"

iso_cast_grid iso_cast_grid_of(const iso_geometry *g, int threads)
{
    iso_cast_grid grid = {.voxels = ISO_CAST_VOXELS, .threads = iso_threads(threads)};
    for (int a = 0; a < 3; ++a) {
        grid.size[a] = g->size[a];
        grid.count[a] = g->size[a] / ISO_CAST_BRICK + 1; /* cells 0 to the size */
        grid.voxels *= grid.count[a];
    }
    return grid;
}

/* A row of a brick: where its voxels begin in the level, and which ones they are. */
typedef struct brick_row {
    size_t start, x[ISO_CAST_ROW];
} brick_row;

static void row_of(const iso_cast_grid *g, size_t brick, size_t row, brick_row *r)
{
    const size_t b[3] = {brick % g->count[0], brick / g->count[0] % g->count[1], brick / (g->count[0] * g->count[1])};
    const size_t y = iso_cast_inner(b[1] * ISO_CAST_BRICK + row % ISO_CAST_ROW, g->size[1]);
    const size_t z = iso_cast_inner(b[2] * ISO_CAST_BRICK + row / ISO_CAST_ROW, g->size[2]);
    r->start = g->size[0] * (y + g->size[1] * z);
    for (size_t i = 0; i < ISO_CAST_ROW; ++i)
        r->x[i] = r->start + iso_cast_inner(b[0] * ISO_CAST_BRICK + i, g->size[0]);
}

/* out[i] of each voxel v of all rows of all bricks of grid. */
#define FILL(out, expression) \
    do { \
        const size_t bricks = grid->voxels / ISO_CAST_VOXELS; \
        _Pragma("omp parallel for schedule(static) num_threads(grid->threads)") for (size_t brick = 0; brick < bricks; \
                                                                                     ++brick) for (size_t row = 0; \
                                                                                                   row < \
                                                                                                   ISO_CAST_PLANE; \
                                                                                                   ++row) \
        { \
            brick_row r; \
            row_of(grid, brick, row, &r); \
            for (size_t i = 0; i < ISO_CAST_ROW; ++i) { \
                const size_t v = r.x[i]; \
                (out)[brick * ISO_CAST_VOXELS + row * ISO_CAST_ROW + i] = (expression); \
            } \
        } \
    } while (0)

static void *make(const iso_cast_grid *g, size_t bytes)
{
    char *made = malloc((g->voxels + 4) * bytes);
    if (made)
        memset(made + g->voxels * bytes, 0, 4 * bytes);
    return made;
}

uint16_t *iso_cast_brick_integers(const iso_cast_grid *grid, const float *scalar, double min)
{
    uint16_t *out = make(grid, sizeof *out);
    const float zero = (float)min;
    if (out)
        FILL(out, (uint16_t)(scalar[v] - zero)); /* whole numbers below 2^17: exact */
    return out;
}

float *iso_cast_brick_floats(const iso_cast_grid *grid, const float *scalar, double min, double range)
{
    float *out = make(grid, sizeof *out);
    if (out)
        FILL(out, range > 0 ? (float)(((double)scalar[v] - min) / range) : 0);
    return out;
}

uint16_t *iso_cast_brick_bytes(const iso_cast_grid *grid, const uint8_t *bytes)
{
    uint16_t *out = make(grid, sizeof *out);
    if (out)
        FILL(out, bytes[v]);
    return out;
}

uint32_t *iso_cast_brick_codes(const iso_cast_grid *grid, const uint8_t *codes, bool is_signed)
{
    uint32_t *out = make(grid, sizeof *out);
    if (out && is_signed)
        FILL(out, iso_cast_code_word(codes + 3 * v, true));
    else if (out)
        FILL(out, iso_cast_code_word(codes + 3 * v, false));
    return out;
}

static float component_of(const iso_sampler *sampler, size_t voxel, int component)
{
    float vector[3];
    iso_sampler_vector(sampler, voxel, vector);
    return vector[component];
}

float *iso_cast_brick_component(const iso_cast_grid *grid, const iso_sampler *sampler, int component)
{
    float *out = make(grid, sizeof *out);
    if (out)
        FILL(out, component_of(sampler, v, component));
    return out;
}

/* ---- blocks ---- */

enum { BLOCK = 1 << ISO_CAST_BLOCK_SHIFT };

/* The level's voxels that block b of an axis reaches. */
static void reach(size_t b, size_t size, size_t *lo, size_t *hi)
{
    *lo = iso_cast_inner(b * BLOCK, size);
    *hi = iso_cast_inner(b * BLOCK + BLOCK, size);
}

static bool block_shows(const iso_level *level, const iso_tf_table *tf, const size_t b[3])
{
    const size_t *size = level->geometry.size;
    size_t lo[3], hi[3];
    for (int a = 0; a < 3; ++a)
        reach(b[a], size[a], &lo[a], &hi[a]);
    float min = level->scalar[lo[0] + size[0] * (lo[1] + size[1] * lo[2])], max = min;
    for (size_t z = lo[2]; z <= hi[2]; ++z)
        for (size_t y = lo[1]; y <= hi[1]; ++y) {
            const float *row = level->scalar + size[0] * (y + size[1] * z);
            for (size_t x = lo[0]; x <= hi[0]; ++x) {
                min = row[x] < min ? row[x] : min;
                max = row[x] > max ? row[x] : max;
            }
        }
    return iso_tf_shows(tf, (double)min, (double)max);
}

iso_status iso_cast_blocks(const iso_level *level, const iso_tf_table *tf, int threads, uint8_t **distance,
                           size_t count[3], double *occupied, iso_error *err)
{
    size_t all = 1, shown = 0;
    for (int a = 0; a < 3; ++a)
        all *= count[a] = level->geometry.size[a] / BLOCK + 1;
    uint8_t *out = *distance = malloc(all + 4); /* four bytes are fetched for one */
    if (!out)
        return iso_fail(err, ISO_E_MEMORY, "cpu: no memory for %zu blocks", all);
    memset(out + all, 0, 4);
#pragma omp parallel for schedule(static) num_threads(iso_threads(threads)) reduction(+ : shown)
    for (size_t i = 0; i < all; ++i) {
        const size_t b[3] = {i % count[0], i / count[0] % count[1], i / (count[0] * count[1])};
        const bool shows = block_shows(level, tf, b);
        out[i] = shows ? 0 : 255;
        shown += shows;
    }
    iso_occupancy_distance(count, out);
    *occupied = (double)shown / (double)all;
    return ISO_OK;
}

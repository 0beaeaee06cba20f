/* SPDX-License-Identifier: MIT */
#include "render/cpu/cast_bricks.h"

#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"

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

/* The statement for the voxel v of each place `at` of all rows of all bricks of grid. */
#define FILL(statement) \
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
                const size_t v = r.x[i], at = brick * ISO_CAST_VOXELS + row * ISO_CAST_ROW + i; \
                statement; \
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

uint16_t *iso_cast_brick_integers(const iso_cast_grid *grid, const iso_cast_scalars *s, const float *scalar)
{
    uint16_t *out = make(grid, sizeof *out);
    if (out)
        FILL(out[at] = iso_cast_integer(s, scalar[v]));
    return out;
}

float *iso_cast_brick_floats(const iso_cast_grid *grid, const iso_cast_scalars *s, const float *scalar)
{
    float *out = make(grid, sizeof *out);
    if (out)
        FILL(out[at] = iso_cast_part(s, scalar[v]));
    return out;
}

uint16_t *iso_cast_brick_bytes(const iso_cast_grid *grid, const uint8_t *bytes)
{
    uint16_t *out = make(grid, sizeof *out);
    if (out)
        FILL(out[at] = bytes[v]);
    return out;
}

uint32_t *iso_cast_brick_voxels(const iso_cast_grid *grid, const iso_cast_scalars *s, const float *scalar,
                                const uint8_t *codes, bool is_signed)
{
    const size_t words = (size_t)iso_cast_voxel_words(s);
    uint32_t *out = make(grid, words * sizeof *out);
    if (out)
        FILL(iso_cast_put_voxel(s, scalar[v], codes + 3 * v, is_signed, out + words * at));
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
        FILL(out[at] = component_of(sampler, v, component));
    return out;
}

/* ---- bricks of a pool ---- */

iso_cast_box iso_cast_box_of(const size_t size[3], const size_t brick_count[3], size_t brick)
{
    const size_t *n = brick_count, at[3] = {brick % n[0], brick / n[0] % n[1], brick / (n[0] * n[1])};
    iso_cast_box box;
    for (int a = 0; a < 3; ++a) {
        box.start[a] = at[a] * ISO_CAST_BRICK;
        box.first[a] = iso_cast_inner(box.start[a], size[a]);
        box.count[a] = iso_cast_inner(box.start[a] + ISO_CAST_BRICK, size[a]) - box.first[a] + 1;
    }
    return box;
}

size_t iso_cast_voxel_bytes(const iso_cast_scalars *s, bool is_lit)
{
    return is_lit ? (size_t)iso_cast_voxel_words(s) * sizeof(uint32_t) : s->are_integers ? sizeof(uint16_t) : sizeof(float);
}

bool iso_cast_pool_create(iso_cast_pool *pool, const iso_cast_scalars *s, bool is_lit, size_t count, size_t *bytes)
{
    *pool = (iso_cast_pool){0};
    *bytes = (count * ISO_CAST_VOXELS + 4) * iso_cast_voxel_bytes(s, is_lit);
    void *made = malloc(*bytes);
    if (is_lit)
        pool->voxels = made;
    else if (s->are_integers)
        pool->integers = made;
    else
        pool->floats = made;
    return made != NULL;
}

void *iso_cast_pool_array(const iso_cast_pool *pool)
{
    return pool->voxels ? (void *)pool->voxels : pool->integers ? (void *)pool->integers : (void *)pool->floats;
}

void iso_cast_pool_use(const iso_cast_pool *pool, iso_cast *c)
{
    c->voxels = pool->voxels;
    c->integers = pool->integers;
    c->floats = pool->floats;
}

void iso_cast_pool_fill(const iso_cast_pool *pool, const iso_cast_scalars *s, bool is_signed, const size_t size[3],
                        const iso_cast_box *box, const float *scalars, const uint8_t *codes, size_t page)
{
    size_t out = page * ISO_CAST_VOXELS, at[3][ISO_CAST_ROW];
    uint32_t *voxel = pool->voxels ? pool->voxels + out * (size_t)iso_cast_voxel_words(s) : NULL;
    for (int a = 0; a < 3; ++a)
        for (size_t i = 0; i < ISO_CAST_ROW; ++i)
            at[a][i] = iso_cast_inner(box->start[a] + i, size[a]) - box->first[a];
    for (size_t row = 0; row < ISO_CAST_PLANE; ++row) {
        const size_t y = at[1][row % ISO_CAST_ROW], z = at[2][row / ISO_CAST_ROW];
        const size_t first = box->count[0] * (y + box->count[1] * z);
        for (size_t i = 0; i < ISO_CAST_ROW; ++i, ++out) {
            const size_t v = first + at[0][i];
            if (voxel)
                voxel = iso_cast_put_voxel(s, scalars[v], codes + 3 * v, is_signed, voxel);
            else if (pool->integers)
                pool->integers[out] = iso_cast_integer(s, scalars[v]);
            else
                pool->floats[out] = iso_cast_part(s, scalars[v]);
        }
    }
}

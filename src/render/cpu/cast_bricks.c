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

uint16_t *iso_cast_brick_integers(const iso_cast_grid *grid, const iso_cast_scalars *s, const float *scalar)
{
    uint16_t *out = make(grid, sizeof *out);
    if (out)
        FILL(out, iso_cast_integer(s, scalar[v]));
    return out;
}

float *iso_cast_brick_floats(const iso_cast_grid *grid, const iso_cast_scalars *s, const float *scalar)
{
    float *out = make(grid, sizeof *out);
    if (out)
        FILL(out, iso_cast_part(s, scalar[v]));
    return out;
}

uint16_t *iso_cast_brick_bytes(const iso_cast_grid *grid, const uint8_t *bytes)
{
    uint16_t *out = make(grid, sizeof *out);
    if (out)
        FILL(out, bytes[v]);
    return out;
}

typedef struct voxel_words {
    uint32_t code, scalar;
} voxel_words;

uint32_t *iso_cast_brick_voxels(const iso_cast_grid *grid, const iso_cast_scalars *s, const float *scalar,
                                const uint8_t *codes, bool is_signed)
{
    voxel_words *out = make(grid, sizeof *out);
    if (out)
        FILL(out, ((voxel_words){iso_cast_code_word(codes + 3 * v, is_signed), iso_cast_scalar_word(s, scalar[v])}));
    return (uint32_t *)out;
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

enum {
    BLOCK = 1 << ISO_CAST_BLOCK_SHIFT,
    VOXELS = BLOCK + 1,
    ALL = VOXELS * VOXELS * VOXELS,
    WORD = BLOCK * BLOCK * 2
};

/* Reads the voxels at the corners of block b's cells, VOXELS along each axis. */
static void read_block(const iso_level *level, const size_t b[3], float *out)
{
    const size_t *size = level->geometry.size;
    for (size_t z = 0; z < VOXELS; ++z)
        for (size_t y = 0; y < VOXELS; ++y) {
            const float *row = level->scalar + size[0] * (iso_cast_inner(b[1] * BLOCK + y, size[1]) +
                                                          size[1] * iso_cast_inner(b[2] * BLOCK + z, size[2]));
            for (size_t x = 0; x < VOXELS; ++x)
                *out++ = row[iso_cast_inner(b[0] * BLOCK + x, size[0])];
        }
}

/* Replaces each value by the least and the largest of it and the next along an axis. After all three axes they are
 * those of the cells. */
static void reach_next(float *min, float *max, size_t step)
{
    for (size_t i = 0; i + step < ALL; ++i) {
        min[i] = min[i] < min[i + step] ? min[i] : min[i + step];
        max[i] = max[i] > max[i + step] ? max[i] : max[i + step];
    }
}

/* Sets the bits of the visible cells. */
static void find_cells(const iso_tf_table *tf, const uint32_t *next, const float *voxels, uint32_t words[2])
{
    float min[ALL], max[ALL];
    memcpy(min, voxels, sizeof min);
    memcpy(max, voxels, sizeof max);
    for (size_t step = 1; step < ALL; step *= VOXELS)
        reach_next(min, max, step);
    words[0] = words[1] = 0;
    for (size_t i = 0; i < 2 * WORD; ++i) {
        const size_t x = i % BLOCK, y = i / BLOCK % BLOCK, z = i / (BLOCK * BLOCK), at = x + VOXELS * (y + VOXELS * z);
        if (iso_tf_shows_by(tf, next, (double)min[at], (double)max[at]))
            words[i / WORD] |= (uint32_t)1 << i % WORD;
    }
}

static void find_in_block(const iso_level *level, const iso_tf_table *tf, const uint32_t *next, const size_t b[3],
                          uint32_t words[2])
{
    float voxels[ALL];
    read_block(level, b, voxels);
    float min = voxels[0], max = min;
    for (size_t i = 1; i < ALL; ++i) {
        min = voxels[i] < min ? voxels[i] : min;
        max = voxels[i] > max ? voxels[i] : max;
    }
    words[0] = words[1] = 0;
    if (iso_tf_shows_by(tf, next, (double)min, (double)max))
        find_cells(tf, next, voxels, words);
}

iso_status iso_cast_blocks_create(iso_cast_blocks *b, const iso_level *level, const iso_tf_table *tf, int threads,
                                  iso_error *err)
{
    size_t shown = 0;
    *b = (iso_cast_blocks){.blocks = 1};
    for (int a = 0; a < 3; ++a)
        b->blocks *= b->count[a] = level->geometry.size[a] / BLOCK + 1;
    const size_t blocks = b->blocks, *count = b->count;
    uint32_t *next = malloc(tf->count * sizeof *next), *cells = b->cells = malloc(2 * blocks * sizeof *cells);
    uint8_t *empty = malloc(blocks);
    b->octants = malloc(ISO_OCTANTS * blocks + 4); /* four bytes are fetched for one */
    const bool has_all = next && cells && empty && b->octants;
    if (has_all) {
        iso_tf_next_shown(tf, next);
#pragma omp parallel for schedule(static) num_threads(iso_threads(threads)) reduction(+ : shown)
        for (size_t i = 0; i < blocks; ++i) {
            const size_t at[3] = {i % count[0], i / count[0] % count[1], i / (count[0] * count[1])};
            find_in_block(level, tf, next, at, cells + 2 * i);
            empty[i] = !(cells[2 * i] | cells[2 * i + 1]);
            shown += !empty[i];
        }
        memset(b->octants + ISO_OCTANTS * blocks, 0, 4);
        iso_occupancy_octants(count, empty, threads, b->octants);
    }
    free(empty);
    free(next);
    b->occupied = (double)shown / (double)blocks;
    return has_all ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "cpu: no memory for %zu blocks", blocks);
}

void iso_cast_blocks_destroy(iso_cast_blocks *b)
{
    free(b->octants);
    free(b->cells);
    *b = (iso_cast_blocks){0};
}

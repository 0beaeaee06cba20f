/* SPDX-License-Identifier: MIT */
/* cast_bricks.h - a level's voxels in the bricks of cast.h, and which of its blocks a transfer function shows. */
#pragma once

#include <stdint.h>
#include <string.h>

#include "pyramid/narrow.h"
#include "render/cpu/cast.h"
#include "render/sampler.h"

/* How the bricks of a level lie. */
typedef struct iso_cast_grid {
    size_t size[3], count[3];
    size_t voxels; /* of all bricks */
    int threads;
} iso_cast_grid;
iso_cast_grid iso_cast_grid_of(const iso_geometry *g, int threads);

/* Returns the level's voxel at position `at` of the grid, which repeats the outermost voxels. */
static inline size_t iso_cast_inner(size_t at, size_t size)
{
    return at == 0 ? 0 : at <= size ? at - 1 : size - 1;
}

/* Packs a code's three bytes into a word; in signed codes -128 becomes -127. */
static inline uint32_t iso_cast_code_word(const uint8_t *code, bool is_signed)
{
    uint32_t word = 0;
    for (int i = 0; i < 3; ++i)
        word |= (uint32_t)(is_signed && code[i] == 0x80 ? 0x81 : code[i]) << (8 * i);
    return word;
}

/* How a scalar is kept (cast.h). */
typedef struct iso_cast_scalars {
    bool are_integers;
    double min, range; /* of the level */
} iso_cast_scalars;

/* Counts the words of a voxel with its code: one if the scalar is a byte. */
static inline int iso_cast_voxel_words(const iso_cast_scalars *s)
{
    return s->are_integers && s->range <= 255 ? 1 : 2;
}

static inline uint16_t iso_cast_integer(const iso_cast_scalars *s, float scalar)
{
    return (uint16_t)(scalar - (float)s->min); /* whole numbers below 2^17: exact */
}
static inline float iso_cast_part(const iso_cast_scalars *s, float scalar)
{
    if (iso_is_no_data(scalar))
        return (float)-ISO_STAND_IN_DEVICE;
    return s->range > 0 ? (float)(((double)scalar - s->min) / s->range) : 0;
}
static inline uint32_t iso_cast_scalar_word(const iso_cast_scalars *s, float scalar)
{
    if (s->are_integers)
        return iso_cast_integer(s, scalar);
    const float part = iso_cast_part(s, scalar);
    uint32_t word;
    memcpy(&word, &part, sizeof word);
    return word;
}

/* Writes the words of a voxel with its code. Returns the place of the next. */
static inline uint32_t *iso_cast_put_voxel(const iso_cast_scalars *s, float scalar, const uint8_t *code, bool is_signed,
                                           uint32_t *out)
{
    const uint32_t word = iso_cast_code_word(code, is_signed), value = iso_cast_scalar_word(s, scalar);
    if (iso_cast_voxel_words(s) == 1) {
        *out++ = word | value << 24;
    } else {
        *out++ = word;
        *out++ = value;
    }
    return out;
}

/* Voxels of a brick: of the grid, which repeats the outermost ones, and the box of the level that they come from. */
typedef struct iso_cast_box {
    size_t start[3], first[3], count[3];
} iso_cast_box;
iso_cast_box iso_cast_box_of(const size_t size[3], const size_t brick_count[3], size_t brick);

/* Voxels of bricks as in iso_cast, one of the three. */
typedef struct iso_cast_pool {
    uint32_t *voxels;
    uint16_t *integers;
    float *floats;
} iso_cast_pool;
size_t iso_cast_voxel_bytes(const iso_cast_scalars *s, bool is_lit);
/* Allocates `count` bricks, and a few bytes more that a fetch may reach. False: out of memory. */
bool iso_cast_pool_create(iso_cast_pool *pool, const iso_cast_scalars *s, bool is_lit, size_t count, size_t *bytes);
void *iso_cast_pool_array(const iso_cast_pool *pool);
void iso_cast_pool_use(const iso_cast_pool *pool, iso_cast *c);
/* Fills brick number `page` of the pool from the voxels of its box; codes are not read without light. */
void iso_cast_pool_fill(const iso_cast_pool *pool, const iso_cast_scalars *s, bool is_signed, const size_t size[3],
                        const iso_cast_box *box, const float *scalars, const uint8_t *codes, size_t page);

/* Creates an array of grid->voxels elements, and a few bytes more that a fetch may reach; NULL: out of memory. So do
 * the functions down to iso_cast_brick_component(). */
uint16_t *iso_cast_brick_integers(const iso_cast_grid *grid, const iso_cast_scalars *s, const float *scalar);
float *iso_cast_brick_floats(const iso_cast_grid *grid, const iso_cast_scalars *s, const float *scalar);
uint16_t *iso_cast_brick_bytes(const iso_cast_grid *grid, const uint8_t *bytes);
/* Creates iso_cast_voxel_words() per voxel. */
uint32_t *iso_cast_brick_voxels(const iso_cast_grid *grid, const iso_cast_scalars *s, const float *scalar,
                                const uint8_t *codes, bool is_signed);
float *iso_cast_brick_component(const iso_cast_grid *grid, const iso_sampler *sampler, int component);

/* Visible parts of a level's blocks under a table: `octants` and `cells` of cast.h. */
typedef struct iso_cast_blocks {
    size_t count[3], blocks;
    uint8_t *octants; /* owned, both */
    uint32_t *cells;
    double occupied; /* share of visible blocks */
} iso_cast_blocks;

/* Creates the blocks. ISO_E_MEMORY. Destroy them after a failure, too. */
iso_status iso_cast_blocks_create(iso_cast_blocks *b, const iso_level *level, const iso_tf_table *tf, int threads,
                                  iso_error *err);
void iso_cast_blocks_destroy(iso_cast_blocks *b); /* accepts empty */

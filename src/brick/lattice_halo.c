/* SPDX-License-Identifier: MIT */
#include "brick/lattice_build.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A block's cells have their first corners in it and their last ones up to one node beyond: nine along each axis. An
 * extra row of blocks before the first ones covers the cells that end in these. */
enum { SIDE = ISO_LATTICE_SIDE + 1, CORNERS = SIDE * SIDE * SIDE };

typedef struct cell_block {
    long first[3];       /* first corner, counted from the lattice's first node; may lie outside */
    size_t lo[3], hi[3]; /* range of corners that became active; none: hi < lo */
    uint8_t active[CORNERS];
    float values[CORNERS];
} cell_block;

/* Blocks of cells still to be checked; when a node becomes active, its neighbors are checked again. */
typedef struct halo {
    const iso_lattice_builder *builder;
    size_t count[3];
    uint8_t *wanted;
} halo;

/* Copies the corners that lie in one block of nodes, from corner `from` on. */
static void gather_block(const iso_lattice_block *block, const size_t shift[3], cell_block *c)
{
    size_t size[3];
    for (int a = 0; a < 3; ++a)
        size[a] = shift[a] ? 1 : ISO_LATTICE_SIDE;
    for (size_t z = 0; z < size[2]; ++z)
        for (size_t y = 0; y < size[1]; ++y)
            for (size_t x = 0; x < size[0]; ++x) {
                const size_t from = x + ISO_LATTICE_SIDE * (y + ISO_LATTICE_SIDE * z);
                const size_t to = x + shift[0] * ISO_LATTICE_SIDE +
                                  SIDE * (y + shift[1] * ISO_LATTICE_SIDE + SIDE * (z + shift[2] * ISO_LATTICE_SIDE));
                c->active[to] = block->use[from] != ISO_LATTICE_UNUSED;
                c->values[to] = block->nodes[from][0];
            }
}

/* Collects the corners of a block's cells. False if none is active. */
static bool gather(const iso_lattice *l, const long at[3], cell_block *c)
{
    bool any = false;
    for (int a = 0; a < 3; ++a)
        c->first[a] = at[a] * ISO_LATTICE_SIDE + l->corner[a] - l->first[a];
    for (size_t i = 0; i < 8; ++i) {
        const size_t shift[3] = {i & 1, i >> 1 & 1, i >> 2};
        size_t b[3];
        bool there = true;
        for (int a = 0; a < 3; ++a) {
            b[a] = (size_t)(at[a] + (long)shift[a]); /* below 0 wraps around to a large index */
            there = there && b[a] < l->block_count[a];
        }
        const iso_lattice_block *block = there ? l->blocks[b[0] + l->block_count[0] * (b[1] + l->block_count[1] * b[2])]
                                               : NULL;
        if (block && !any) {
            memset(c->active, 0, sizeof c->active);
            for (size_t k = 0; k < CORNERS; ++k)
                c->values[k] = l->empty[0];
        }
        any = any || block;
        if (block)
            gather_block(block, shift, c);
    }
    return any;
}

/* True if a cell can be seen: bricks outside all views cannot. */
static bool matters(const iso_lattice_builder *b, const size_t at[3])
{
    const iso_lattice_options *o = b->opt;
    size_t brick[3];
    for (int a = 0; a < 3; ++a)
        brick[a] = iso_lattice_brick(b, a, iso_lattice_level0(b, a, b->lattice->first[a] + (long)at[a]));
    const size_t index = iso_brick_index(b->field->nodes, brick);
    return o->merged ? o->drawn[index] || !o->seen || o->seen[index] : iso_lattice_has(b, index);
}

/* Returns the scalar of node p of level 0 if no brick there is coarser than the lattice: the voxel, or the own node of
 * a brick coarser than level 0. Bricks of level 0 need not be made. */
static double own_scalar(const iso_lattice_builder *b, const size_t brick[3], const size_t p[3])
{
    const iso_node_levels *n = b->field->nodes;
    const size_t level = b->field->levels[iso_brick_index(n, brick)];
    size_t at[3], coarser[3];
    double value[ISO_NODE_CHANNELS];
    float voxel;
    if (level > 0 || iso_brick_coarsest_at(b->field, p, level, coarser)) {
        for (int a = 0; a < 3; ++a)
            at[a] = (p[a] - brick[a] * n->brick_voxels) >> level;
        iso_brick_node(b->field, brick, at, value);
        return value[0];
    }
    for (int a = 0; a < 3; ++a)
        at[a] = p[a] < n->geometry.size[a] ? p[a] : n->geometry.size[a] - 1;
    iso_node_levels_voxels(n, at[0], at[1], at[2], 1, &voxel);
    return (double)voxel;
}

/* Returns the scalar of a node from any brick that contains it: they agree. */
static float sample(const iso_lattice_builder *b, const size_t at[3])
{
    const iso_node_levels *n = b->field->nodes;
    double q[3], value[ISO_NODE_CHANNELS];
    size_t brick[3], p[3], coarsest[3];
    for (int a = 0; a < 3; ++a) {
        p[a] = iso_lattice_level0(b, a, b->lattice->first[a] + (long)at[a]);
        brick[a] = iso_lattice_brick(b, a, p[a]);
        q[a] = (double)p[a];
    }
    const bool sampled = b->field->levels[iso_brick_index(n, brick)] > b->lattice->level;
    if (!sampled && !iso_brick_coarsest_at(b->field, p, b->lattice->level, coarsest))
        return (float)own_scalar(b, brick, p);
    iso_brick_sample_in(b->field, sampled ? brick : coarsest, q, value);
    return iso_lattice_round_scalar(b, value[0]);
}

static iso_status activate(const iso_lattice_builder *b, cell_block *c, size_t cell, const size_t at[3], iso_error *err)
{
    for (size_t i = 0; i < 8; ++i) {
        const size_t corner = cell + (i & 1) + SIDE * ((i >> 1 & 1) + SIDE * (i >> 2));
        const size_t node[3] = {at[0] + (i & 1), at[1] + (i >> 1 & 1), at[2] + (i >> 2)};
        if (c->active[corner])
            continue;
        const float value = sample(b, node);
        NEED(iso_lattice_put(b->lattice, node, &value, ISO_LATTICE_HALO, err));
        c->active[corner] = 1;
        c->values[corner] = value;
        for (int a = 0; a < 3; ++a) {
            const size_t in = (size_t)((long)node[a] - c->first[a]);
            c->lo[a] = in < c->lo[a] ? in : c->lo[a];
            c->hi[a] = in > c->hi[a] ? in : c->hi[a];
        }
    }
    return ISO_OK;
}

/* True if any value between the corners of a cell with active and background corners would be visible. */
static bool is_seen(const iso_lattice_builder *b, const cell_block *c, size_t cell)
{
    const uint8_t *a = c->active + cell;
    const int active = a[0] + a[1] + a[SIDE] + a[SIDE + 1] + a[SIDE * SIDE] + a[SIDE * SIDE + 1] +
                       a[SIDE * SIDE + SIDE] + a[SIDE * SIDE + SIDE + 1];
    float lowest = INFINITY, highest = -INFINITY;
    if (active == 0 || active == 8)
        return false;
    for (size_t i = 0; i < 8; ++i) {
        const size_t corner = cell + (i & 1) + SIDE * ((i >> 1 & 1) + SIDE * (i >> 2));
        lowest = c->values[corner] < lowest ? c->values[corner] : lowest;
        highest = c->values[corner] > highest ? c->values[corner] : highest;
    }
    return iso_lattice_shows(b, (double)lowest, (double)highest);
}

/* Checks each cell once. */
static iso_status look(const iso_lattice_builder *b, cell_block *c, bool *changed, iso_error *err)
{
    *changed = false;
    for (size_t i = 0; i < ISO_LATTICE_CUBE; ++i) {
        const size_t in[3] = {i % ISO_LATTICE_SIDE, i / ISO_LATTICE_SIDE % ISO_LATTICE_SIDE,
                              i / (ISO_LATTICE_SIDE * ISO_LATTICE_SIDE)};
        const size_t cell = in[0] + SIDE * (in[1] + SIDE * in[2]);
        size_t at[3];
        bool inside = true;
        for (int a = 0; a < 3; ++a) {
            const long node = c->first[a] + (long)in[a];
            inside = inside && node >= 0 && node + 1 < (long)b->lattice->size[a];
            at[a] = (size_t)node;
        }
        if (!inside || !is_seen(b, c, cell) || !matters(b, at))
            continue;
        NEED(activate(b, c, cell, at, err));
        *changed = true;
    }
    return ISO_OK;
}

static bool is_mixed(const cell_block *c)
{
    return memchr(c->active, 0, CORNERS) && memchr(c->active, 1, CORNERS);
}

/* Requests a check of the neighboring blocks whose cells have corners that became active. */
static void want_around(const halo *h, const size_t at[3], const cell_block *c)
{
    for (size_t i = 0; i < 27; ++i) {
        const size_t step[3] = {i % 3, i / 3 % 3, i / 9}, x = at[0] + step[0] - 1, y = at[1] + step[1] - 1,
                     z = at[2] + step[2] - 1; /* below 0 wraps around to a large index */
        bool touched = i != 13 && x < h->count[0] && y < h->count[1] && z < h->count[2];
        for (int a = 0; a < 3; ++a)
            touched = touched && (step[a] != 0 || c->lo[a] == 0) && (step[a] != 2 || c->hi[a] == ISO_LATTICE_SIDE);
        if (touched)
            h->wanted[x + h->count[0] * (y + h->count[1] * z)] = 1;
    }
}

/* Checks a block until no more nodes become active in it. */
static iso_status settle_block(const iso_lattice_builder *b, cell_block *c, iso_error *err)
{
    for (int a = 0; a < 3; ++a)
        c->lo[a] = SIDE, c->hi[a] = 0;
    for (bool changed = true; changed;)
        NEED(look(b, c, &changed, err));
    return ISO_OK;
}

/* Checks all requested blocks. Activation only adds visible cells, so the result does not depend on the order. */
static iso_status settle(const halo *h, cell_block *c, iso_error *err)
{
    iso_status status = ISO_OK;
    bool again = true;
    while (again && status == ISO_OK) {
        again = false;
        for (size_t i = 0; i < h->count[0] * h->count[1] * h->count[2] && status == ISO_OK; ++i) {
            const size_t at[3] = {i % h->count[0], i / h->count[0] % h->count[1], i / (h->count[0] * h->count[1])};
            if (!h->wanted[i])
                continue;
            h->wanted[i] = 0;
            if (!gather(h->builder->lattice, (const long[]){(long)at[0] - 1, (long)at[1] - 1, (long)at[2] - 1}, c) ||
                !is_mixed(c))
                continue;
            status = settle_block(h->builder, c, err);
            want_around(h, at, c);
            again = again || c->lo[0] < SIDE;
        }
    }
    return status;
}

iso_status iso_lattice_add_halo(const iso_lattice_builder *b, iso_error *err)
{
    halo h = {.builder = b};
    for (int a = 0; a < 3; ++a)
        h.count[a] = b->lattice->block_count[a] + 1;
    const size_t count = h.count[0] * h.count[1] * h.count[2];
    FREED cell_block *c = malloc(sizeof *c);
    h.wanted = malloc(count);
    iso_status status = c && h.wanted ? ISO_OK
                                      : iso_fail(err, ISO_E_MEMORY, "lattice: no memory for %zu blocks", count);
    if (status == ISO_OK) {
        memset(h.wanted, 1, count);
        status = settle(&h, c, err);
    }
    free(h.wanted);
    return status;
}

/* SPDX-License-Identifier: MIT */
#include "brick/lattice.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/large.h"
#include "base/parallel.h"
#include "brick/lattice_build.h"
#include "brick/occupancy.h"

static bool any_shows(const iso_tf_table *tfs, size_t count, double min, double max)
{
    for (size_t i = 0; i < count; ++i)
        if (iso_tf_shows(&tfs[i], min, max))
            return true;
    return false;
}

double iso_lattice_step(const iso_node_levels *n)
{
    int exponent;
    frexp(n->max - n->min, &exponent);
    return ldexp(1, exponent - 16);
}

/* ---- background ---------------------------------------------------------------- */

enum { BIN_COUNT = 1024 };

/* Counts the values of some thousand rows, spread over the volume. */
static void count_values(const iso_node_levels *n, double width, float *row, size_t bins[BIN_COUNT])
{
    enum { ROWS = 1 << 14 };
    const size_t *size = n->geometry.size, rows = size[1] * size[2], step = rows / ROWS | 1; /* odd, so that y varies */
    for (size_t i = 0; i < rows; i += step) {
        iso_node_levels_voxels(n, 0, i % size[1], i / size[1], size[0], row);
        for (size_t x = 0; x < size[0]; ++x) {
            const double bin = ((double)row[x] - n->min) / width;
            ++bins[bin > 0 ? (bin < BIN_COUNT - 1 ? (size_t)bin : BIN_COUNT - 1) : 0];
        }
    }
}

/* Returns an invisible value in [min, max], from the invisible range with most of level 0; min if all is visible. */
static double lattice_background(const iso_node_levels *n, const iso_tf_table *tfs, size_t tf_count)
{
    size_t bins[BIN_COUNT] = {0}, most = 0;
    double width = (n->max - n->min) / BIN_COUNT, value = n->min;
    float *row = malloc(n->geometry.size[0] * sizeof *row);
    if (row && width > 0)
        count_values(n, width, row, bins);
    free(row);
    for (size_t start = 0; start < BIN_COUNT; ++start) {
        size_t end = start, inside = 0;
        while (end < BIN_COUNT &&
               !any_shows(tfs, tf_count, n->min + (double)start * width, n->min + (double)(end + 1) * width))
            inside += bins[end++];
        if (end > start && inside >= most) { /* as far as possible from visible values, rounded like samples */
            const double middle = n->min + 0.5 * (double)(start + end) * width, step = iso_lattice_step(n);
            most = inside;
            value = start == 0 ? n->min : end == BIN_COUNT ? n->max : step * rint(middle / step);
        }
        start = end > start ? end - 1 : start;
    }
    return value;
}

/* ---- blocks ---------------------------------------------------------------------- */

/* Memory for many blocks, in large pages: small ones for single blocks cost more time than the writes into them. */
typedef struct iso_lattice_chunk {
    struct iso_lattice_chunk *next;
    size_t used, count;
    iso_lattice_block blocks[];
} iso_lattice_chunk;

static size_t block_count(const iso_lattice *l)
{
    return l->block_count[0] * l->block_count[1] * l->block_count[2];
}

/* Returns a block without active nodes. NULL: no memory. */
static iso_lattice_block *new_block(iso_lattice *l)
{
    const size_t most = (((size_t)4 << 20) - sizeof *l->chunks) / sizeof(iso_lattice_block);
    if (!l->chunks || l->chunks->used == l->chunks->count) {
        const size_t count = block_count(l) < most ? block_count(l) : most;
        /* rounded up to the size at which iso_large_alloc() uses large pages */
        const size_t bytes = count < most ? sizeof *l->chunks + count * sizeof(iso_lattice_block) : (size_t)4 << 20;
        iso_lattice_chunk *chunk = iso_large_alloc(bytes);
        if (!chunk)
            return NULL;
        chunk->next = l->chunks;
        chunk->used = 0;
        chunk->count = count;
        l->chunks = chunk;
    }
    iso_lattice_block *block = &l->chunks->blocks[l->chunks->used++];
    memset(block, 0, sizeof *block);
    for (size_t i = 0; i < ISO_LATTICE_CUBE; ++i)
        block->nodes[i][0] = l->empty[0];
    return block;
}

iso_status iso_lattice_put(iso_lattice *l, const size_t at[3], const float *node, iso_lattice_use use, iso_error *err)
{
    size_t in;
    iso_lattice_block **block = iso_lattice_block_of(l, at[0], at[1], at[2], &in);
    if (!*block && !(*block = new_block(l)))
        return iso_fail(err, ISO_E_MEMORY, "lattice: no memory for a block of nodes");
    memcpy((*block)->nodes[in], node, (use == ISO_LATTICE_LIT ? ISO_NODE_CHANNELS : 1) * sizeof *node);
    (*block)->use[in] = (uint8_t)use;
    return ISO_OK;
}

/* Computes the box of the bricks, with one node more on all sides. False: no bricks. */
static bool find_box(const iso_lattice_builder *b)
{
    const iso_node_levels *n = b->field->nodes;
    iso_lattice *l = b->lattice;
    size_t lo[3] = {SIZE_MAX, SIZE_MAX, SIZE_MAX}, hi[3] = {0};
    for (size_t i = 0; i < iso_brick_count(n); ++i) {
        const size_t at[3] = {i % n->count[0], i / n->count[0] % n->count[1], i / (n->count[0] * n->count[1])};
        for (int a = 0; a < 3 && iso_lattice_has(b, i); ++a) {
            lo[a] = at[a] < lo[a] ? at[a] : lo[a];
            hi[a] = at[a] + 1 > hi[a] ? at[a] + 1 : hi[a];
        }
    }
    for (int a = 0; a < 3; ++a) {
        size_t cells = n->brick_voxels >> l->level;
        if (hi[a] == 0)
            return false;
        l->first[a] = (long)(lo[a] * cells) - 1;
        l->size[a] = (hi[a] - lo[a]) * cells + 3;
        l->corner[a] = l->first[a] < 0 ? -ISO_LATTICE_SIDE : l->first[a] / ISO_LATTICE_SIDE * ISO_LATTICE_SIDE;
        l->block_count[a] = ((size_t)(l->first[a] - l->corner[a]) + l->size[a] - 1) / ISO_LATTICE_SIDE + 1;
    }
    return true;
}

/* ---- box of the active nodes ------------------------------------------------------- */

/* Extent of the active nodes, counted from the lattice's first node. */
typedef struct extent {
    size_t lo[3], hi[3];
} extent;

static void extend(iso_lattice *l, size_t index, const iso_lattice_block *block, extent *e)
{
    const size_t b[3] = {index % l->block_count[0], index / l->block_count[0] % l->block_count[1],
                         index / (l->block_count[0] * l->block_count[1])};
    double lowest = l->min, highest = l->max;
    size_t lo[3] = {ISO_LATTICE_SIDE, ISO_LATTICE_SIDE, ISO_LATTICE_SIDE}, hi[3] = {0}, count = 0;
    for (size_t i = 0; i < ISO_LATTICE_CUBE; ++i) {
        const size_t in[3] = {i % ISO_LATTICE_SIDE, i / ISO_LATTICE_SIDE % ISO_LATTICE_SIDE,
                              i / (ISO_LATTICE_SIDE * ISO_LATTICE_SIDE)};
        const double value = (double)block->nodes[i][0];
        if (block->use[i] == ISO_LATTICE_UNUSED)
            continue;
        ++count;
        lowest = value < lowest ? value : lowest; /* fmin() is a call */
        highest = value > highest ? value : highest;
        for (int a = 0; a < 3; ++a) {
            lo[a] = in[a] < lo[a] ? in[a] : lo[a];
            hi[a] = in[a] + 1 > hi[a] ? in[a] + 1 : hi[a];
        }
    }
    l->active_count += count;
    l->min = lowest;
    l->max = highest;
    for (int a = 0; a < 3 && count > 0; ++a) {
        /* May lie before the box: then it wraps around, and adding lo corrects it. */
        const size_t first = b[a] * ISO_LATTICE_SIDE - (size_t)(l->first[a] - l->corner[a]);
        e->lo[a] = first + lo[a] < e->lo[a] ? first + lo[a] : e->lo[a];
        e->hi[a] = first + hi[a] > e->hi[a] ? first + hi[a] : e->hi[a];
    }
}

/* Activates the box's corners; corners that were inactive become background. */
static iso_status put_corners(iso_lattice *l, iso_error *err)
{
    const size_t corners[2][3] = {{0, 0, 0}, {l->size[0] - 1, l->size[1] - 1, l->size[2] - 1}};
    for (int i = 0; i < 2; ++i) {
        if (iso_lattice_use_of(l, corners[i][0], corners[i][1], corners[i][2]) != ISO_LATTICE_UNUSED)
            continue;
        NEED(iso_lattice_put(l, corners[i], l->empty, ISO_LATTICE_LIT, err));
        ++l->active_count;
    }
    return ISO_OK;
}

/* Shrinks the lattice to the box of the active nodes. ISO_E_RANGE: none. */
static iso_status trim(iso_lattice *l, bool whole_box, iso_error *err)
{
    extent e = {.lo = {SIZE_MAX, SIZE_MAX, SIZE_MAX}};
    l->min = l->max = l->background;
    for (size_t i = 0; i < block_count(l); ++i)
        if (l->blocks[i])
            extend(l, i, l->blocks[i], &e);
    if (l->active_count == 0)
        return iso_fail(err, ISO_E_RANGE, "lattice: the transfer function shows no cell of the drawn bricks");
    if (whole_box)
        return put_corners(l, err);
    for (int a = 0; a < 3; ++a) {
        l->first[a] += (long)e.lo[a];
        l->size[a] = e.hi[a] - e.lo[a];
    }
    return ISO_OK;
}

/* Places the center of voxel (0, 0, 0) at the first node, which is at index 2^level first + 1/2 of the volume. */
static void place(iso_lattice *l, const iso_geometry *g)
{
    double step = ldexp(1, (int)l->level), corner[3];
    for (int a = 0; a < 3; ++a) {
        corner[a] = step * ((double)l->first[a] - 0.5) + 0.5;
        l->geometry.box_index[a] = (double)l->size[a];
    }
    memcpy(l->geometry.size, l->size, sizeof l->size);
    l->geometry.index_to_world = iso_mat3_scale(g->index_to_world, step);
    l->geometry.origin_mm = iso_geometry_to_world(g, iso_v3(corner[0], corner[1], corner[2]));
}

/* ---- construction -------------------------------------------------------------------- */

static void forget_shown(iso_lattice_builder *b)
{
    for (size_t i = 0; b->shown && i < b->opt->tf_count; ++i)
        free(b->shown[i].next);
    free(b->shown);
    b->shown = NULL;
}

static bool note_shown(iso_lattice_builder *b)
{
    bool good = (b->shown = calloc(b->opt->tf_count + 1, sizeof *b->shown)) != NULL;
    for (size_t i = 0; i < b->opt->tf_count && good; ++i) {
        const iso_tf_table *tf = &b->opt->tfs[i];
        uint32_t *next = malloc(tf->count * sizeof *next);
        good = next != NULL;
        if (good)
            b->shown[i] = iso_tf_shown_of(tf, next);
    }
    return good;
}

static iso_status add_bricks(const iso_lattice_builder *b, iso_error *err)
{
    const size_t count = iso_brick_count(b->field->nodes);
    bool failed = false;
#pragma omp parallel num_threads(iso_threads(b->opt->threads)) reduction(|| : failed)
    {
        iso_node_buffers buffers = {0};
#pragma omp for schedule(dynamic)
        for (size_t i = 0; i < count; ++i)
            if (iso_lattice_has(b, i) && iso_lattice_add_brick(b, i, &buffers, NULL) != ISO_OK)
                failed = true;
        iso_node_buffers_destroy(&buffers);
    }
    return failed ? iso_fail(err, ISO_E_MEMORY, "lattice: no memory for its nodes") : ISO_OK;
}

static iso_status build(iso_lattice_builder *b, iso_error *err)
{
    iso_lattice *l = b->lattice;
    const iso_node_levels *n = b->field->nodes;
    b->step = iso_lattice_step(n);
    l->blocks = calloc(block_count(l), sizeof *l->blocks);
    NEED_MEMORY(l->blocks && note_shown(b), err, "lattice: no memory for %zu blocks", block_count(l));
    l->background = lattice_background(n, b->opt->tfs, b->opt->tf_count);
    l->empty[0] = (float)l->background;
    NEED(add_bricks(b, err));
    NEED(iso_lattice_add_halo(b, err));
    return trim(l, b->opt->whole_box, err);
}

iso_status iso_lattice_create(iso_lattice *l, const iso_brick_field *f, const iso_lattice_options *opt, iso_error *err)
{
    iso_lattice_builder b = {.field = f, .opt = opt, .lattice = l};
    *l = (iso_lattice){.level = opt->merged ? ISO_BRICK_MAX_LEVELS : opt->level};
    if (f->faces != ISO_FACES_BAKED)
        return iso_fail(err, ISO_E_RANGE, "lattice: needs baked faces, without them bricks differ at shared nodes");
    for (size_t i = 0; opt->merged && i < iso_brick_count(f->nodes); ++i)
        if (opt->drawn[i] && f->levels[i] < l->level)
            l->level = f->levels[i];
    if (l->level >= f->nodes->level_count || !find_box(&b))
        return iso_fail(err, ISO_E_RANGE, "lattice: no brick is drawn");
    const iso_status status = build(&b, err);
    forget_shown(&b);
    if (status == ISO_OK)
        place(l, &f->nodes->geometry);
    else
        iso_lattice_destroy(l);
    return status;
}

void iso_lattice_destroy(iso_lattice *l)
{
    if (!l)
        return;
    for (iso_lattice_chunk *c = l->chunks, *next; c; c = next) {
        next = c->next;
        free(c);
    }
    free(l->blocks);
    *l = (iso_lattice){0};
}

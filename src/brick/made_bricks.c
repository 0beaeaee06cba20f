/* SPDX-License-Identifier: MIT */
/* made_bricks.c - nodes of single bricks. A coarse brick's nodes are filtered from nodes of the level below around
 * them, and these from those of the next level. Each level is divided into blocks, one from the beginning of each
 * brick; a block stores the box of its needed nodes:
 *
 *     level 2   | # # # |       |       |     # a brick's nodes, the last ones in the next block
 *     level 1   |   # # # # # # # # # # |     two more on both sides, and so on down to the voxels */
#include "brick/made_bricks.h"

#include <stdlib.h>
#include <string.h>

#include "base/large.h"
#include "base/parallel.h"
#include "brick/node_box.h"
#include "pyramid/narrow.h"

struct iso_brick_maker {
    iso_level level0;
    iso_node_voxels voxels;
    const uint8_t *levels;
    iso_code code;
    bool has_code;
};

static void brick_at(const iso_node_levels *n, size_t i, size_t at[3])
{
    at[0] = i % n->count[0];
    at[1] = i / n->count[0] % n->count[1];
    at[2] = i / (n->count[0] * n->count[1]);
}

/* Writes the nodes of a box. */
static void finish(const iso_node_levels *n, const iso_node_box *box, bool is_coded, float *nodes)
{
    const size_t count = iso_node_box_count(box);
    iso_node_box_finish(box, nodes);
    if (is_coded && n->maker->has_code && n->maker->voxels.directed)
        iso_nodes_encode(n->maker->code, nodes, count);
    if (n->is_rounded)
        iso_nodes_round(n, nodes, count);
}

/* Copies a brick's nodes from a box. False: no memory. */
static bool keep_brick(const iso_node_levels *n, size_t brick, const iso_node_box *box, bool is_coded)
{
    float *nodes = malloc(ISO_NODE_CHANNELS * iso_node_box_count(box) * sizeof *nodes);
    if (!nodes)
        return false;
    finish(n, box, is_coded, nodes);
    n->bricks[brick] = nodes;
    return true;
}

/* ---- blocks ---------------------------------------------------------------------- */

typedef struct block {
    uint8_t lo[3], hi[3]; /* range of needed nodes, hi excluded; hi[0] == 0: none */
    uint16_t width;       /* nodes per row of the box that contains them, which may cover several blocks */
    float *values;        /* this block's first node in that box */
} block;

typedef struct block_level {
    size_t cells;    /* nodes per block along an axis */
    size_t count[3]; /* blocks: one more than bricks, for the last nodes */
    size_t last[3];  /* last node along each axis */
    block *blocks;
    size_t channels;
    float *values; /* owned; of all blocks */
} block_level;

/* Returns a block's nodes as a box. */
static iso_node_box box_of(const block_level *l, const block *b)
{
    return (iso_node_box){.size = {b->width, (size_t)(b->hi[1] - b->lo[1]), (size_t)(b->hi[2] - b->lo[2])},
                          .channels = l->channels,
                          .values = b->values};
}

static bool block_level_create(block_level *l, const iso_node_levels *n, size_t level)
{
    l->cells = n->brick_voxels >> level;
    l->channels = n->maker->voxels.directed ? ISO_BOX_CHANNELS : 1;
    for (int a = 0; a < 3; ++a) {
        l->count[a] = n->count[a] + 1;
        l->last[a] = iso_node_count(n, level, a) - 1;
    }
    l->blocks = calloc(l->count[0] * l->count[1] * l->count[2], sizeof *l->blocks);
    return l->blocks != NULL;
}

static size_t block_count(const block_level *l)
{
    return l->count[0] * l->count[1] * l->count[2];
}

static void block_level_destroy(block_level *l)
{
    free(l->values);
    free(l->blocks);
    *l = (block_level){0};
}

static block *block_at(const block_level *l, size_t x, size_t y, size_t z)
{
    return &l->blocks[x + l->count[0] * (y + l->count[1] * z)];
}

/* Returns the first node of block i. */
static void block_first(const block_level *l, size_t i, size_t first[3])
{
    first[0] = l->cells * (i % l->count[0]);
    first[1] = l->cells * (i / l->count[0] % l->count[1]);
    first[2] = l->cells * (i / (l->count[0] * l->count[1]));
}

/* Widens a block's range along an axis by the part of [lo, hi] inside it. */
static void widen(block *b, int axis, size_t first, size_t cells, size_t lo, size_t hi)
{
    const uint8_t from = (uint8_t)(lo > first ? lo - first : 0),
                  to = (uint8_t)((hi < first + cells ? hi + 1 : first + cells) - first);
    const bool is_new = b->hi[axis] == 0;
    b->lo[axis] = is_new || from < b->lo[axis] ? from : b->lo[axis];
    b->hi[axis] = to > b->hi[axis] ? to : b->hi[axis];
}

/* Marks the nodes [lo, hi] of the level, hi included, as needed. */
static void need(block_level *l, const long lo[3], const long hi[3])
{
    size_t from[3], to[3];
    for (int a = 0; a < 3; ++a) {
        from[a] = lo[a] > 0 ? (size_t)lo[a] : 0;
        to[a] = (size_t)hi[a] < l->last[a] ? (size_t)hi[a] : l->last[a];
    }
    for (size_t z = from[2] / l->cells; z <= to[2] / l->cells; ++z)
        for (size_t y = from[1] / l->cells; y <= to[1] / l->cells; ++y)
            for (size_t x = from[0] / l->cells; x <= to[0] / l->cells; ++x) {
                block *b = block_at(l, x, y, z);
                const size_t at[3] = {x, y, z};
                for (int a = 0; a < 3; ++a)
                    widen(b, a, at[a] * l->cells, l->cells, from[a], to[a]);
            }
}

/* Marks the nodes of the level below that are needed for a level's blocks: two more on each side. */
static void need_below(const block_level *l, block_level *below)
{
    for (size_t i = 0; i < block_count(l); ++i) {
        const block *b = &l->blocks[i];
        size_t first[3];
        long lo[3], hi[3];
        if (b->hi[0] == 0)
            continue;
        block_first(l, i, first);
        for (int a = 0; a < 3; ++a) {
            lo[a] = 2 * (long)(first[a] + b->lo[a]) - 2;
            hi[a] = 2 * (long)(first[a] + b->hi[a] - 1) + 2;
        }
        need(below, lo, hi);
    }
}

/* Marks the nodes of a level's bricks. */
static void need_own(const iso_node_levels *n, size_t level, block_level *l)
{
    const long cells = (long)l->cells;
    for (size_t i = 0; i < iso_brick_count(n); ++i) {
        size_t at[3];
        if (n->maker->levels[i] != level)
            continue;
        brick_at(n, i, at);
        const long lo[3] = {cells * (long)at[0], cells * (long)at[1], cells * (long)at[2]};
        need(l, lo, (const long[]){lo[0] + cells, lo[1] + cells, lo[2] + cells});
    }
}

/* ---- computation ------------------------------------------------------------------ */

/* Reads nodes of a row from the blocks that contain them. */
static void read_blocks(const void *user, size_t x, size_t y, size_t z, size_t count,
                        float *const rows[ISO_BOX_CHANNELS])
{
    const block_level *l = user;
    for (size_t done = 0, run; done < count; done += run) {
        const size_t at = x + done, in[3] = {at % l->cells, y % l->cells, z % l->cells};
        const block *b = block_at(l, at / l->cells, y / l->cells, z / l->cells);
        const iso_node_box box = box_of(l, b);
        run = l->cells - in[0] < count - done ? l->cells - in[0] : count - done;
        for (size_t c = 0; c < l->channels; ++c)
            memcpy(rows[c] + done, iso_node_box_row(&box, c, in[1] - b->lo[1], in[2] - b->lo[2]) + in[0] - b->lo[0],
                   run * sizeof *rows[c]);
    }
}

static iso_node_rows rows_of(const block_level *l)
{
    return (iso_node_rows){read_blocks, l, {l->last[0], l->last[1], l->last[2]}};
}

/* Consecutive blocks along x without gaps. They are computed together as one box: neighboring blocks share input, and
 * long rows take less time per node than short ones. */
typedef struct block_row {
    size_t first, count, nodes; /* nodes: along x */
} block_row;

/* Nodes per row of blocks that stay in the caches together with their input. */
enum { ROW_NODES = 32 };

static bool continues_row(const block_level *l, size_t i)
{
    const block *before = &l->blocks[i - 1], *b = &l->blocks[i];
    return i % l->count[0] > 0 && before->hi[0] == l->cells && b->hi[0] > 0 && b->lo[0] == 0 &&
           before->lo[1] == b->lo[1] && before->hi[1] == b->hi[1] && before->lo[2] == b->lo[2] &&
           before->hi[2] == b->hi[2];
}

/* Lists all rows of blocks with nodes; to be freed. NULL: no memory. */
static block_row *find_rows(const block_level *l, size_t *count)
{
    block_row *rows = malloc(block_count(l) * sizeof *rows);
    *count = 0;
    for (size_t i = 0; rows && i < block_count(l); ++i) {
        const block *b = &l->blocks[i];
        if (b->hi[0] == 0)
            continue;
        if (*count == 0 || rows[*count - 1].nodes >= ROW_NODES || !continues_row(l, i))
            rows[(*count)++] = (block_row){.first = i};
        ++rows[*count - 1].count;
        rows[*count - 1].nodes += (size_t)(b->hi[0] - b->lo[0]);
    }
    return rows;
}

static iso_node_box box_of_row(const block_level *l, const block_row *row)
{
    return box_of(l, &l->blocks[row->first]);
}

/* Allocates the values of all rows in one piece. False: no memory. */
static bool place_rows(block_level *l, const block_row *rows, size_t count)
{
    size_t total = 0;
    for (size_t i = 0; i < count; ++i) {
        for (size_t k = 0; k < rows[i].count; ++k)
            l->blocks[rows[i].first + k].width = (uint16_t)rows[i].nodes;
        const iso_node_box box = box_of_row(l, &rows[i]);
        total += box.channels * iso_node_box_count(&box);
    }
    l->values = iso_large_alloc(total * sizeof *l->values + 1);
    if (!l->values)
        return false;
    float *values = l->values;
    for (size_t i = 0; i < count; ++i) {
        block *b = &l->blocks[rows[i].first];
        for (size_t k = 0, x = 0; k < rows[i].count; ++k) {
            b[k].values = values + x;
            x += (size_t)(b[k].hi[0] - b[k].lo[0]);
        }
        const iso_node_box box = box_of_row(l, &rows[i]);
        values += box.channels * iso_node_box_count(&box);
    }
    return true;
}

/* Computes a row of blocks from the level below; NULL: from the voxels. */
static bool make_row(const iso_node_levels *n, const block_level *l, const block_row *row, const block_level *below,
                     iso_node_buffers *buffers)
{
    const block *b = &l->blocks[row->first];
    const iso_node_box box = box_of_row(l, row);
    size_t at[3], fine_size[3];
    long first[3];
    iso_node_box fine;
    block_first(l, row->first, at);
    for (int a = 0; a < 3; ++a) {
        first[a] = 2 * (long)(at[a] + b->lo[a]) - 2;
        fine_size[a] = 2 * box.size[a] + 3;
    }
    if (!iso_node_box_place(&fine, fine_size, n->maker->voxels.directed, buffers, ISO_BUFFER_FINE))
        return false;
    const iso_node_rows rows = below ? rows_of(below) : (iso_node_rows){0};
    if (below)
        iso_node_box_fill(&fine, &rows, first);
    else if (!iso_node_box_read(&fine, &n->maker->voxels, first, buffers))
        return false;
    return iso_node_box_filter(&fine, &box, buffers);
}

static bool make_own(const iso_node_levels *n, const block_level *l, size_t brick, iso_node_buffers *buffers)
{
    const iso_node_rows rows = rows_of(l);
    const size_t side = l->cells + 1, size[3] = {side, side, side};
    iso_node_box box;
    size_t at[3];
    brick_at(n, brick, at);
    if (!iso_node_box_place(&box, size, n->maker->voxels.directed, buffers, ISO_BUFFER_BOX))
        return false;
    iso_node_box_fill(&box, &rows,
                      (const long[]){(long)(l->cells * at[0]), (long)(l->cells * at[1]), (long)(l->cells * at[2])});
    return keep_brick(n, brick, &box, true);
}

static bool make_rows(const iso_node_levels *n, block_level *l, const block_level *below, int threads)
{
    size_t count;
    block_row *rows = find_rows(l, &count);
    bool failed = !rows || !place_rows(l, rows, count);
    if (failed)
        count = 0;
#pragma omp parallel num_threads(threads) reduction(|| : failed)
    {
        iso_node_buffers buffers = {0};
#pragma omp for schedule(dynamic)
        for (size_t i = 0; i < count; ++i)
            failed = failed || !make_row(n, l, &rows[i], below, &buffers);
        iso_node_buffers_destroy(&buffers);
    }
    free(rows);
    return !failed;
}

/* Computes the blocks of a level, then the bricks of that level. */
static bool make_level(const iso_node_levels *n, size_t level, block_level *l, const block_level *below, int threads)
{
    bool failed = !make_rows(n, l, below, threads);
    if (failed)
        return false;
#pragma omp parallel num_threads(threads) reduction(|| : failed)
    {
        iso_node_buffers buffers = {0};
#pragma omp for schedule(dynamic)
        for (size_t i = 0; i < iso_brick_count(n); ++i)
            if (n->maker->levels[i] == level)
                failed = failed || !make_own(n, l, i, &buffers);
        iso_node_buffers_destroy(&buffers);
    }
    return !failed;
}

/* Makes all bricks coarser than level 0. */
static iso_status make_coarse(const iso_node_levels *n, int threads, iso_error *err)
{
    block_level levels[ISO_BRICK_MAX_LEVELS] = {{0}};
    bool good = true;
    for (size_t k = n->level_count; k-- > 1 && good;) {
        good = block_level_create(&levels[k], n, k);
        if (!good)
            break;
        need_own(n, k, &levels[k]);
        if (k + 1 < n->level_count)
            need_below(&levels[k + 1], &levels[k]);
    }
    for (size_t k = 1; k < n->level_count && good; ++k) {
        good = make_level(n, k, &levels[k], k > 1 ? &levels[k - 1] : NULL, threads);
        block_level_destroy(&levels[k - 1]);
    }
    for (size_t k = 0; k < ISO_BRICK_MAX_LEVELS; ++k)
        block_level_destroy(&levels[k]);
    return good ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "bricks: no memory for the nodes of coarse bricks");
}

/* ---- interface ---------------------------------------------------------------------- */

iso_status iso_made_bricks_begin(iso_node_levels *n, const iso_level *level0, const uint8_t *levels,
                                 const iso_code *code, iso_error *err)
{
    n->bricks = calloc(iso_brick_count(n), sizeof *n->bricks);
    n->maker = malloc(sizeof *n->maker);
    NEED_MEMORY(n->bricks && n->maker, err, "bricks: no memory for %zu bricks", iso_brick_count(n));
    *n->maker = (struct iso_brick_maker){.level0 = *level0, .levels = levels, .has_code = code != NULL};
    n->maker->code = code ? *code : n->maker->code;
    n->maker->voxels = iso_node_voxels_of(&n->maker->level0, true);
    return ISO_OK;
}

const iso_node_voxels *iso_made_bricks_voxels(const iso_node_levels *n)
{
    return &n->maker->voxels;
}

iso_status iso_node_levels_create_for(iso_node_levels *n, const iso_level *level0, size_t brick_voxels,
                                      size_t level_count, const uint8_t *levels, const iso_code *code, int threads,
                                      iso_error *err)
{
    NEED(iso_node_levels_measure(n, level0, brick_voxels, level_count, err));
    iso_status status = iso_made_bricks_begin(n, level0, levels, code, err);
    TRY(status, make_coarse(n, iso_threads(threads), err));
    if (status != ISO_OK)
        iso_node_levels_destroy(n);
    return status;
}

iso_status iso_brick_make(const iso_node_levels *n, size_t brick, iso_brick_content content, iso_error *err)
{
    if (!n->bricks || n->bricks[brick])
        return ISO_OK;
    const size_t side = n->brick_voxels + 1, size[3] = {side, side, side};
    OWNED(iso_node_buffers) buffers = {0};
    iso_node_box box;
    size_t at[3];
    brick_at(n, brick, at);
    const long first[3] = {(long)(n->brick_voxels * at[0]), (long)(n->brick_voxels * at[1]),
                           (long)(n->brick_voxels * at[2])};
    iso_node_voxels voxels = n->maker->voxels;
    voxels.directed = voxels.directed && content != ISO_BRICK_SCALARS;
    const bool good = iso_node_box_place(&box, size, voxels.directed, &buffers, ISO_BUFFER_BOX) &&
                      iso_node_box_read(&box, &voxels, first, &buffers) &&
                      keep_brick(n, brick, &box, content == ISO_BRICK_WHOLE);
    return good ? ISO_OK
                : iso_fail(err, ISO_E_MEMORY, "bricks: no memory for a brick of %zu voxels per side", n->brick_voxels);
}

/* ---- temporary bricks --------------------------------------------------------------- */

bool iso_passing_brick_open(iso_passing_brick *p, const iso_node_levels *n, size_t brick, iso_node_buffers *buffers)
{
    *p = (iso_passing_brick){.nodes = n};
    brick_at(n, brick, p->first);
    for (int a = 0; a < 3; ++a) {
        const size_t last = n->geometry.size[a] - 1;
        p->first[a] *= n->brick_voxels;
        p->last[a] = p->first[a] + n->brick_voxels < last ? p->first[a] + n->brick_voxels : last;
    }
    return iso_voxel_box_read(&p->voxels, &n->maker->voxels, p->first, p->last, buffers);
}

/* Finds the volume's row for a brick's row; returns the number of its nodes inside the volume. */
static size_t passing_row(const iso_passing_brick *p, size_t y, size_t z, size_t at[2])
{
    at[0] = p->first[1] + y < p->last[1] ? p->first[1] + y : p->last[1];
    at[1] = p->first[2] + z < p->last[2] ? p->first[2] + z : p->last[2];
    return p->last[0] - p->first[0] + 1;
}

void iso_passing_brick_scalars(const iso_passing_brick *p, size_t y, size_t z, float *restrict scalars)
{
    size_t at[2];
    const size_t count = passing_row(p, y, z, at);
    memcpy(scalars, iso_voxel_box_at(&p->voxels, p->first[0], at[0], at[1]), count * sizeof *scalars);
    for (size_t x = count; x <= p->nodes->brick_voxels; ++x)
        scalars[x] = scalars[count - 1];
}

void iso_passing_brick_directions(const iso_passing_brick *p, size_t y, size_t z, const uint8_t *wanted,
                                  float *restrict directions)
{
    enum { MOST = ISO_BRICK_MOST_VOXELS + 1 };
    float scratch[ISO_BOX_CHANNELS][MOST];
    float *const rows[ISO_BOX_CHANNELS] = {scratch[0], scratch[1], scratch[2], scratch[3], scratch[4]};
    size_t at[2];
    const size_t count = passing_row(p, y, z, at);
    if (!p->nodes->maker->voxels.directed)
        memset(scratch, 0, sizeof scratch);
    else
        iso_voxel_box_moments(&p->voxels, p->first[0], at[0], at[1], count, rows);
    for (size_t x = 0; x <= p->nodes->brick_voxels; ++x) {
        const size_t from = x < count ? x : count - 1;
        float *to = directions + 3 * x;
        if (!wanted[x])
            continue;
        for (size_t a = 0; a < 3; ++a)
            to[a] = rows[ISO_BOX_MOMENTS + a][from];
        iso_node_to_direction(to, rows[ISO_BOX_SUM][from]);
    }
}

void iso_passing_brick_code(const iso_passing_brick *p, float *directions, size_t count)
{
    enum { BATCH = 256 };
    const struct iso_brick_maker *m = p->nodes->maker;
    uint8_t bytes[6 * BATCH];
    for (size_t first = 0; m->has_code && m->voxels.directed && first < count; first += BATCH) {
        const size_t batch = count - first < BATCH ? count - first : BATCH;
        iso_code_encode(m->code, directions + 3 * first, bytes, batch);
        iso_code_decode_all(m->code, bytes, directions + 3 * first, batch);
    }
}

/* ---- reading and freeing -------------------------------------------------------------- */

void iso_brick_forget(const iso_node_levels *n, size_t brick)
{
    if (!n->bricks || (n->maker->levels && n->maker->levels[brick] > 0))
        return;
    free(n->bricks[brick]);
    n->bricks[brick] = NULL;
}

void iso_node_levels_voxels(const iso_node_levels *n, size_t x, size_t y, size_t z, size_t count, float *restrict row)
{
    if (n->maker) {
        const size_t *size = n->geometry.size;
        const float *from = iso_level_floats(&n->maker->level0, x + size[0] * (y + size[1] * z), count, row);
        for (size_t i = 0; i < count; ++i)
            row[i] = n->is_rounded ? iso_node_round(n, from[i]) : from[i];
        return;
    }
    const float *from = n->nodes[0] +
                        ISO_NODE_CHANNELS * (x + iso_node_count(n, 0, 0) * (y + iso_node_count(n, 0, 1) * z));
    for (size_t i = 0; i < count; ++i)
        row[i] = from[ISO_NODE_CHANNELS * i];
}

/* Makes a box of nodes. */
static iso_status read_voxels(const iso_node_levels *n, const long first[3], const size_t size[3],
                              float *restrict nodes, iso_error *err)
{
    OWNED(iso_node_buffers) buffers = {0};
    iso_node_box box;
    const bool good = iso_node_box_place(&box, size, n->maker->voxels.directed, &buffers, ISO_BUFFER_BOX) &&
                      iso_node_box_read(&box, &n->maker->voxels, first, &buffers);
    if (good)
        finish(n, &box, true, nodes);
    return good ? ISO_OK
                : iso_fail(err, ISO_E_MEMORY, "bricks: no memory for %zu x %zu x %zu nodes", size[0], size[1], size[2]);
}

iso_status iso_node_levels_read(const iso_node_levels *n, const long first[3], const size_t size[3],
                                float *restrict nodes, iso_error *err)
{
    if (!n->nodes[0])
        return read_voxels(n, first, size, nodes, err);
    for (size_t i = 0; i < size[0] * size[1] * size[2]; ++i, nodes += ISO_NODE_CHANNELS) {
        const size_t in[3] = {i % size[0], i / size[0] % size[1], i / (size[0] * size[1])};
        size_t at[3];
        for (int a = 0; a < 3; ++a) {
            const long p = first[a] + (long)in[a], last = (long)iso_node_count(n, 0, a) - 1;
            at[a] = (size_t)(p < 0 ? 0 : p < last ? p : last);
        }
        const size_t from = at[0] + iso_node_count(n, 0, 0) * (at[1] + iso_node_count(n, 0, 1) * at[2]);
        memcpy(nodes, n->nodes[0] + ISO_NODE_CHANNELS * from, ISO_NODE_CHANNELS * sizeof *nodes);
    }
    return ISO_OK;
}

void iso_made_bricks_destroy(iso_node_levels *n)
{
    for (size_t i = 0; n->bricks && i < iso_brick_count(n); ++i)
        free(n->bricks[i]);
    free(n->bricks);
    free(n->maker);
}

/* SPDX-License-Identifier: MIT */
#include "brick/bricks.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "base/simd.h"
#include "brick/made_bricks.h"
#include "brick/node_box.h"

static size_t all_nodes(const iso_node_levels *n, size_t level)
{
    return iso_node_count(n, level, 0) * iso_node_count(n, level, 1) * iso_node_count(n, level, 2);
}

static size_t least(size_t a, size_t b)
{
    return a < b ? a : b;
}

/* ---- nodes from level 0 --------------------------------------------------------- */

/* A level in construction: `nodes` hold moments, `sums` their sums. */
typedef struct level_maker {
    const iso_node_levels *nodes;
    const iso_node_voxels *voxels;
    size_t level;
    const float *fine_sums;
    float *sums;
} level_maker;

/* Reads rows of the level below. */
static void read_fine(const void *user, size_t x, size_t y, size_t z, size_t count, float *const rows[ISO_BOX_CHANNELS])
{
    const level_maker *m = user;
    const iso_node_levels *n = m->nodes;
    const size_t i = x + iso_node_count(n, m->level - 1, 0) * (y + iso_node_count(n, m->level - 1, 1) * z);
    const float *from = n->nodes[m->level - 1] + ISO_NODE_CHANNELS * i;
    const size_t channels = m->voxels->directed ? ISO_NODE_CHANNELS : 1;
    for (size_t c = 0; c < channels; ++c)
        for (size_t k = 0; k < count; ++k)
            rows[c][k] = from[ISO_NODE_CHANNELS * k + c];
    if (m->voxels->directed)
        memcpy(rows[ISO_BOX_SUM], m->fine_sums + i, count * sizeof *m->fine_sums);
}

/* Computes a box of a level from the voxels or from the level below. False: no memory. */
static bool make_box(const level_maker *m, const size_t first[3], const iso_node_box *box, iso_node_buffers *buffers)
{
    const iso_node_levels *n = m->nodes;
    iso_node_box fine;
    if (m->level == 0)
        return iso_node_box_read(box, m->voxels, (const long[]){(long)first[0], (long)first[1], (long)first[2]},
                                 buffers);
    const iso_node_rows rows = {read_fine,
                                m,
                                {iso_node_count(n, m->level - 1, 0) - 1, iso_node_count(n, m->level - 1, 1) - 1,
                                 iso_node_count(n, m->level - 1, 2) - 1}};
    const size_t *size = box->size, fine_size[3] = {2 * size[0] + 3, 2 * size[1] + 3, 2 * size[2] + 3};
    const long fine_first[3] = {2 * (long)first[0] - 2, 2 * (long)first[1] - 2, 2 * (long)first[2] - 2};
    if (!iso_node_box_place(&fine, fine_size, m->voxels->directed, buffers, ISO_BUFFER_FINE))
        return false;
    if (n->nodes[m->level - 1])
        iso_node_box_fill(&fine, &rows, fine_first);
    else if (!iso_node_box_read(&fine, m->voxels, fine_first, buffers))
        return false;
    return iso_node_box_filter(&fine, box, buffers);
}

/* Copies a box to the level's nodes; their directions are still moments. */
static void put_box(const level_maker *m, const size_t first[3], const iso_node_box *box)
{
    const iso_node_levels *n = m->nodes;
    const size_t nx = iso_node_count(n, m->level, 0), ny = iso_node_count(n, m->level, 1);
    for (size_t z = 0; z < box->size[2]; ++z)
        for (size_t y = 0; y < box->size[1]; ++y) {
            const size_t i = first[0] + nx * (first[1] + y + ny * (first[2] + z));
            float *to = n->nodes[m->level] + ISO_NODE_CHANNELS * i;
            for (size_t c = 0; c < ISO_NODE_CHANNELS; ++c) {
                const float *row = c < box->channels ? iso_node_box_row(box, c, y, z) : NULL;
                for (size_t x = 0; x < box->size[0]; ++x)
                    to[ISO_NODE_CHANNELS * x + c] = row ? row[x] : 0;
            }
            if (m->voxels->directed)
                memcpy(m->sums + i, iso_node_box_row(box, ISO_BOX_SUM, y, z), box->size[0] * sizeof *m->sums);
        }
}

/* Computes a level in boxes that stay in the caches with their input. False: no memory. */
static bool make_level(const level_maker *m, int threads)
{
    static const size_t most[3] = {32, 8, 8};
    const iso_node_levels *n = m->nodes;
    size_t count[3];
    bool failed = false;
    for (int a = 0; a < 3; ++a)
        count[a] = (iso_node_count(n, m->level, a) + most[a] - 1) / most[a];
#pragma omp parallel num_threads(threads) reduction(|| : failed)
    {
        iso_node_buffers buffers = {0};
#pragma omp for schedule(dynamic)
        for (size_t i = 0; i < count[0] * count[1] * count[2]; ++i) {
            const size_t at[3] = {i % count[0], i / count[0] % count[1], i / (count[0] * count[1])};
            size_t first[3], size[3];
            iso_node_box box;
            for (int a = 0; a < 3; ++a) {
                first[a] = at[a] * most[a];
                size[a] = least(most[a], iso_node_count(n, m->level, a) - first[a]);
            }
            if (iso_node_box_place(&box, size, m->voxels->directed, &buffers, ISO_BUFFER_BOX) &&
                make_box(m, first, &box, &buffers))
                put_box(m, first, &box);
            else
                failed = true;
        }
        iso_node_buffers_destroy(&buffers);
    }
    return !failed;
}

/* Converts moments to directions, once every level has been made from them. */
static void moments_to_directions(float *nodes, const float *sums, size_t count, int threads)
{
#pragma omp parallel for schedule(static) num_threads(threads)
    for (size_t i = 0; i < count; ++i)
        iso_node_to_direction(nodes + ISO_NODE_CHANNELS * i + 1, sums[i]);
}

static iso_status check(size_t brick_voxels, size_t level_count, iso_error *err)
{
    if (brick_voxels < 2 || brick_voxels > ISO_BRICK_MOST_VOXELS || (brick_voxels & (brick_voxels - 1)))
        return iso_fail(err, ISO_E_RANGE, "bricks have %zu voxels per side, must be a power of two from 2 to %d",
                        brick_voxels, (int)ISO_BRICK_MOST_VOXELS);
    if (level_count < 1 || level_count > ISO_BRICK_MAX_LEVELS || brick_voxels >> (level_count - 1) == 0)
        return iso_fail(err, ISO_E_RANGE,
                        "%zu levels in bricks of %zu voxels per side, must be at most log2 of the side plus one",
                        level_count, brick_voxels);
    return ISO_OK;
}

/* Fills all levels. A level's moments become directions after the next coarser level has been made from them. */
static iso_status fill_levels(iso_node_levels *n, const iso_node_voxels *voxels, int threads, iso_error *err)
{
    const bool directed = voxels->directed;
    float *fine = NULL;
    iso_status status = ISO_OK;
    for (size_t l = n->nodes[0] ? 0 : 1; l < n->level_count && status == ISO_OK; ++l) {
        const level_maker m = {n, voxels, l, fine, directed ? malloc(all_nodes(n, l) * sizeof *fine) : NULL};
        if ((directed && !m.sums) || !make_level(&m, threads))
            status = iso_fail(err, ISO_E_MEMORY, "bricks: no memory for %zu nodes", all_nodes(n, l));
        if (fine)
            moments_to_directions(n->nodes[l - 1], fine, all_nodes(n, l - 1), threads);
        free(fine);
        fine = m.sums;
    }
    if (status == ISO_OK && fine)
        moments_to_directions(n->nodes[n->level_count - 1], fine, all_nodes(n, n->level_count - 1), threads);
    free(fine);
    return status;
}

iso_status iso_node_levels_measure(iso_node_levels *n, const iso_level *level0, size_t brick_voxels, size_t level_count,
                                   iso_error *err)
{
    *n = (iso_node_levels){.geometry = level0->geometry,
                           .min = level0->min,
                           .max = level0->max,
                           .brick_voxels = brick_voxels,
                           .level_count = level_count};
    iso_status status = check(brick_voxels, level_count, err);
    if (status == ISO_OK && level0->geometry.has_no_data)
        status = iso_fail(err, ISO_E_RANGE,
                          "bricks of mixed levels: some voxels have no data, which nodes would average; use one level");
    for (int a = 0; a < 3 && status == ISO_OK; ++a) {
        size_t cells = level0->geometry.size[a] - 1;
        n->count[a] = cells > 0 ? (cells + brick_voxels - 1) / brick_voxels : 1;
    }
    return status;
}

/* Allocates the nodes of all levels from `first` on. */
static iso_status allocate(iso_node_levels *n, size_t first, iso_error *err)
{
    for (size_t l = first; l < n->level_count; ++l)
        if (!(n->nodes[l] = malloc(ISO_NODE_CHANNELS * all_nodes(n, l) * sizeof **n->nodes)))
            return iso_fail(err, ISO_E_MEMORY, "bricks: no memory for %zu nodes", all_nodes(n, l));
    return ISO_OK;
}

iso_status iso_node_levels_create(iso_node_levels *n, const iso_level *level0, size_t brick_voxels, size_t level_count,
                                  bool with_directions, int threads, iso_error *err)
{
    const iso_node_voxels voxels = iso_node_voxels_of(level0, with_directions);
    NEED(iso_node_levels_measure(n, level0, brick_voxels, level_count, err));
    iso_status status = allocate(n, 0, err);
    TRY(status, fill_levels(n, &voxels, iso_threads(threads), err));
    if (status != ISO_OK)
        iso_node_levels_destroy(n);
    return status;
}

/* ---- rounding --------------------------------------------------------------------- */

/* Rounds the scalars of nodes to steps from `min` on, and the other channels to 1/32767. */
ISO_SIMD static void round_nodes(double min, double step, float *restrict nodes, size_t count)
{
    enum { BATCH = 64 };
    for (size_t first = 0; first < count; first += BATCH) {
        const size_t m = count - first < BATCH ? count - first : BATCH;
        float *batch = nodes + ISO_NODE_CHANNELS * first, scalars[BATCH];
        for (size_t i = 0; i < m; ++i)
            scalars[i] = (float)(min + step * rint(((double)batch[ISO_NODE_CHANNELS * i] - min) / step));
        for (size_t i = 0; i < ISO_NODE_CHANNELS * m; ++i)
            batch[i] = (float)(rint(32767 * (double)batch[i]) / 32767);
        for (size_t i = 0; i < m; ++i)
            batch[ISO_NODE_CHANNELS * i] = scalars[i];
    }
}

void iso_nodes_round(const iso_node_levels *n, float *nodes, size_t count)
{
    round_nodes(n->min, iso_node_step(n), nodes, count);
}

iso_status iso_node_levels_round(iso_node_levels *n, int threads, iso_error *err)
{
    enum { BATCH = 4096 };
    n->is_rounded = true;
    for (size_t l = 0; l < n->level_count; ++l) {
        const size_t count = n->nodes[l] ? all_nodes(n, l) : 0;
#pragma omp parallel for schedule(static) num_threads(iso_threads(threads))
        for (size_t i = 0; i < count; i += BATCH)
            iso_nodes_round(n, n->nodes[l] + ISO_NODE_CHANNELS * i, least(BATCH, count - i));
    }
    return iso_node_levels_measure_ranges(n, threads, err);
}

iso_status iso_node_levels_begin(iso_node_levels *n, const iso_level *level0, size_t brick_voxels, size_t level_count,
                                 int threads, iso_error *err)
{
    iso_status status = iso_node_levels_measure(n, level0, brick_voxels, level_count, err);
    TRY(status, iso_made_bricks_begin(n, level0, NULL, NULL, err));
    TRY(status, iso_node_levels_round(n, threads, err));
    if (status != ISO_OK)
        iso_node_levels_destroy(n);
    return status;
}

iso_status iso_node_levels_complete(iso_node_levels *n, int threads, iso_error *err)
{
    if (n->nodes[n->level_count - 1] || n->level_count == 1)
        return ISO_OK;
    NEED(allocate(n, 1, err));
    NEED(fill_levels(n, iso_made_bricks_voxels(n), iso_threads(threads), err));
    return iso_node_levels_round(n, threads, err);
}

enum { ENCODE_BATCH = 256 };

void iso_nodes_encode(iso_code code, float *nodes, size_t count)
{
    for (size_t first = 0; first < count; first += ENCODE_BATCH) {
        const size_t m = least(ENCODE_BATCH, count - first);
        float *batch = nodes + ISO_NODE_CHANNELS * first, directions[3 * ENCODE_BATCH];
        uint8_t bytes[6 * ENCODE_BATCH];
        for (size_t i = 0; i < m; ++i)
            memcpy(directions + 3 * i, batch + ISO_NODE_CHANNELS * i + 1, 3 * sizeof *directions);
        iso_code_encode(code, directions, bytes, m);
        iso_code_decode_all(code, bytes, directions, m);
        for (size_t i = 0; i < m; ++i)
            memcpy(batch + ISO_NODE_CHANNELS * i + 1, directions + 3 * i, 3 * sizeof *directions);
    }
}

void iso_node_levels_destroy(iso_node_levels *n)
{
    if (!n)
        return;
    for (size_t l = 0; l < ISO_BRICK_MAX_LEVELS; ++l) {
        free(n->nodes[l]);
        free(n->ranges[l]);
    }
    iso_made_bricks_destroy(n);
    *n = (iso_node_levels){0};
}

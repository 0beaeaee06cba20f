/* SPDX-License-Identifier: MIT */
/* cascade_gauss.c - filters wider than the own children, plane by plane: the
 * normalized convolution of [diaz-garcia-2017] Eq. 1, and the Gaussian of scalars,
 * separable and decimated as they go. */
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "pyramid/cascade_kernel.h"

/* Coarse rows that a thread filters at a time, so that their fine rows stay in its cache. */
enum { BLOCK_ROWS = 16 };

/* Fine planes between two meetings of the threads: many, as each may wait for
 * a busy core, but the coarse planes that they touch are all kept. */
enum { BATCH_LEAST = 8, BATCH_MOST = 32 };
#define BATCH_BYTES ((size_t)64 << 20)

/* Working state of one call of iso_cascade_gauss_feed. */
typedef struct gauss_run {
    iso_cascade *c;
    gauss_channel *channel;
    const iso_planes *in;
    const iso_cascade_out *out;
    float *memory;
    size_t per_thread;
} gauss_run;

static size_t slot_floats(const iso_cascade *c, const gauss_channel *w, size_t coarse)
{
    return w->components * c->size[coarse][0] * c->size[coarse][1];
}

iso_status iso_cascade_gauss_create(iso_cascade *c, iso_error *err)
{
    const iso_taps taps = iso_taps_gauss(c->opt.gauss_radius, c->opt.gauss_sigma_voxels);
    if (c->opt.scalar_filter == ISO_SCALAR_GAUSS)
        c->gauss[c->gauss_count++] = (gauss_channel){.is_scalar = true, .components = 1, .filtered = 1, .taps = taps};
    if (c->opt.direction_filter == ISO_DIRECTION_EQ1)
        c->gauss[c->gauss_count++] = (gauss_channel){.components = 5, .filtered = 4, .taps = taps};
    for (size_t i = 0; i < c->gauss_count; ++i) {
        gauss_channel *w = &c->gauss[i];
        const size_t slot_bytes = c->level_count > 1 ? slot_floats(c, w, 1) * sizeof(float) : 1;
        const size_t most = 2 * (BATCH_BYTES / slot_bytes);
        w->batch = most < BATCH_LEAST ? BATCH_LEAST : most < BATCH_MOST ? most : BATCH_MOST;
        w->slot_count = taps.count / 2 + w->batch / 2 + 1;
        for (size_t k = 0; k + 1 < c->level_count; ++k) {
            w->slots[k] = calloc(w->slot_count * slot_floats(c, w, k + 1), sizeof(float));
            NEED_MEMORY(w->slots[k], err, "pyramid: no memory for %zu planes of level %zu", w->slot_count, k + 1);
        }
    }
    return ISO_OK;
}

void iso_cascade_gauss_destroy(iso_cascade *c)
{
    for (size_t i = 0; i < c->gauss_count; ++i)
        for (size_t k = 0; k + 1 < c->level_count; ++k)
            free(c->gauss[i].slots[k]);
}

static float *slot(const gauss_run *r, size_t coarse, size_t plane)
{
    return r->channel->slots[coarse - 1] + plane % r->channel->slot_count * slot_floats(r->c, r->channel, coarse);
}

/* Rows of one thread in a block. */
typedef struct block {
    emit_rows rows;
    float *state, *padded, *narrow, *filtered;
} block;

static size_t block_scratch_count(const iso_cascade *c, const gauss_channel *w)
{
    const size_t n = row_stride(c, 0), half = row_stride(c, c->level_count > 1);
    return iso_emit_rows_count(c) + w->components * n + n + w->taps.count + 16 +
           (2 * BLOCK_ROWS + w->taps.count) * w->components * half + half + 64;
}

static block make_block(const gauss_run *r)
{
    const iso_cascade *c = r->c;
    const gauss_channel *w = r->channel;
    const size_t n = row_stride(c, 0), half = row_stride(c, c->level_count > 1);
    scratch s = {r->memory + (size_t)iso_thread_index() * r->per_thread};
    block b = {.rows = iso_take_emit_rows(c, &s)};
    b.state = take(&s, w->components * n);
    b.padded = take(&s, n + w->taps.count);
    b.narrow = take(&s, (2 * BLOCK_ROWS + w->taps.count) * w->components * half);
    b.filtered = take(&s, half);
    return b;
}

/* Returns component rows of the fine row (y, z) of level k, `*stride` apart. Makes rows of level 0 here, and stores
 * them if they are the block's own. */
static const float *fine_row(const gauss_run *r, block *b, size_t k, size_t y, size_t z, bool own, size_t *stride)
{
    const iso_cascade *c = r->c;
    if (k > 0) {
        *stride = c->size[k][0] * c->size[k][1];
        return slot(r, k, z) + y * c->size[k][0];
    }
    *stride = row_stride(c, 0);
    if (r->channel->is_scalar) {
        iso_planes_row(r->in, y, z, b->state);
        return b->state;
    }
    iso_cascade_level0_gradients(c, r->in, y, z, &b->rows);
    iso_state_from_gradients(ISO_DIRECTION_EQ1, c->opt.eq1_exponent, b->rows.g, c->size[0][0], b->state, *stride,
                             false);
    if (own)
        iso_emit_level0(c, &r->out[0], y, z, &b->rows);
    return b->state;
}

/* Filters coarse rows j0 .. j1 - 1 of the fine plane z of level k: along x into b->narrow, along y into b->filtered,
 * along z into the open planes. */
static void filter_block(const gauss_run *r, block *b, size_t k, size_t z, size_t j0, size_t j1)
{
    const gauss_channel *w = r->channel;
    const size_t *fine = r->c->size[k], *coarse = r->c->size[k + 1], taps = w->taps.count, radius = taps / 2;
    const size_t first = iso_taps_source(&w->taps, j0, 0, fine[1]),
                 last = iso_taps_source(&w->taps, j1 - 1, taps - 1, fine[1]);
    const size_t open_first = z >= radius ? (z - radius + 1) / 2 : 0, reach = (z + radius - 1) / 2;
    const size_t open_last = reach < coarse[2] ? reach : coarse[2] - 1;
    for (size_t y = first; y <= last; ++y) {
        size_t stride;
        const float *row = fine_row(r, b, k, y, z, y / 2 >= j0 && y / 2 < j1, &stride);
        for (size_t i = 0; i < w->filtered; ++i)
            iso_taps_row(&w->taps, row + i * stride, fine[0], b->padded,
                         b->narrow + ((y - first) * w->components + i) * coarse[0]);
    }
    for (size_t j = j0; j < j1; ++j)
        for (size_t i = 0; i < w->filtered; ++i) {
            memset(b->filtered, 0, coarse[0] * sizeof(float));
            for (size_t t = 0; t < taps; ++t)
                iso_add_weighted_row(w->taps.weight[t],
                                     b->narrow +
                                         ((iso_taps_source(&w->taps, j, t, fine[1]) - first) * w->components + i) *
                                             coarse[0],
                                     coarse[0], b->filtered);
            for (size_t p = open_first; p <= open_last; ++p) {
                float *to = slot(r, k + 1, p) + (i * coarse[1] + j) * coarse[0];
                if (iso_taps_source(&w->taps, p, 0, fine[2]) == z)
                    memset(to, 0, coarse[0] * sizeof(float));
                for (size_t t = 0; t < taps; ++t)
                    if (iso_taps_source(&w->taps, p, t, fine[2]) == z)
                        iso_add_weighted_row(w->taps.weight[t], b->filtered, coarse[0], to);
            }
        }
}

/* Finishes the whole coarse planes z0 .. z1 - 1: applies the last part of Eq. 1 and stores them. */
static void finish_planes(const gauss_run *r, size_t k, size_t z0, size_t z1)
{
    iso_cascade *c = r->c;
    const iso_cascade_out *out = &r->out[k];
    const size_t nx = c->size[k][0], ny = c->size[k][1];
    float lo = c->lo[k], hi = c->hi[k];
#pragma omp parallel for schedule(static) num_threads(c->threads) reduction(min : lo) reduction(max : hi)
    for (size_t i = 0; i < (z1 - z0) * ny; ++i) {
        const size_t y = i % ny, z = z0 + i / ny;
        float *row = slot(r, k, z) + y * nx;
        if (!r->channel->is_scalar) {
            block b = make_block(r);
            iso_eq1_finish(row, nx * ny, nx, c->opt.eq1_exponent);
            iso_emit_coarse(c, out, k, y, z, (iso_state_row){c->opt.direction_filter, row, nx * ny}, &b.rows);
        } else if (z >= out->first) {
            iso_row_range(row, nx, &lo, &hi);
            if (out->scalar)
                memcpy(out->scalar + ((z - out->first) * ny + y) * nx, row, nx * sizeof *row);
        }
    }
    c->lo[k] = lo;
    c->hi[k] = hi;
}

static void store_level0_only(const gauss_run *r, size_t z0, size_t z1)
{
    const size_t ny = r->c->size[0][1];
#pragma omp parallel for schedule(static) num_threads(r->c->threads)
    for (size_t i = 0; i < (z1 - z0) * ny; ++i) {
        block b = make_block(r);
        size_t stride;
        fine_row(r, &b, 0, i % ny, z0 + i / ny, true, &stride);
    }
}

/* Feeds the fine planes z0 .. z1 - 1 of level k, and all coarser planes that they complete. */
static void feed_planes(const gauss_run *r, size_t k, size_t z0, size_t z1)
{
    const iso_cascade *c = r->c;
    if (k + 1 == c->level_count) {
        if (k == 0 && !r->channel->is_scalar)
            store_level0_only(r, z0, z1);
        return;
    }
    const size_t *fine = c->size[k], rows = c->size[k + 1][1], taps = r->channel->taps.count;
    const size_t blocks = (rows + BLOCK_ROWS - 1) / BLOCK_ROWS;
#pragma omp parallel for schedule(dynamic, 1) num_threads(c->threads)
    for (size_t i = 0; i < blocks; ++i) {
        block b = make_block(r);
        for (size_t z = z0; z < z1; ++z)
            filter_block(r, &b, k, z, i * BLOCK_ROWS, (i + 1) * BLOCK_ROWS < rows ? (i + 1) * BLOCK_ROWS : rows);
    }
    size_t p0 = z0 >= taps / 2 ? (z0 - taps / 2 + 1) / 2 : 0;
    while (p0 < c->size[k + 1][2] && iso_taps_source(&r->channel->taps, p0, taps - 1, fine[2]) < z0)
        ++p0;
    size_t p1 = p0;
    while (p1 < c->size[k + 1][2] && iso_taps_source(&r->channel->taps, p1, taps - 1, fine[2]) < z1)
        ++p1;
    if (p1 > p0) {
        finish_planes(r, k + 1, p0, p1);
        feed_planes(r, k + 1, p0, p1);
    }
}

iso_status iso_cascade_gauss_feed(iso_cascade *c, const iso_planes *in, size_t z0, size_t z1,
                                  const iso_cascade_out *out, iso_error *err)
{
    for (size_t i = 0; i < c->gauss_count; ++i) {
        gauss_run r = {.c = c, .channel = &c->gauss[i], .in = in, .out = out};
        r.per_thread = (block_scratch_count(c, r.channel) + 15) / 16 * 16;
        r.memory = aligned_alloc(64, (size_t)c->threads * r.per_thread * sizeof *r.memory);
        NEED_MEMORY(r.memory, err, "pyramid: no memory for the rows of %d threads", c->threads);
        const size_t batch = r.channel->batch;
        for (size_t z = z0; z < z1; z += batch)
            feed_planes(&r, 0, z, z + batch < z1 ? z + batch : z1);
        free(r.memory);
    }
    return ISO_OK;
}

size_t iso_cascade_gauss_from(const iso_cascade *c, size_t z)
{
    const size_t radius = c->gauss[0].taps.count / 2;
    size_t need = iso_cascade_complete(c, c->level_count - 1, z);
    for (size_t k = c->level_count - 1; k-- > 0;) {
        size_t from = 2 * need > radius - 1 ? 2 * need - (radius - 1) : 0;
        size_t missing = iso_cascade_complete(c, k, z);
        need = from < missing ? from : missing;
    }
    return need;
}

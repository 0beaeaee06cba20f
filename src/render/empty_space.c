/* SPDX-License-Identifier: MIT */
#include "render/empty_space.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "base/parallel.h"

iso_status iso_shown_create(iso_shown *s, const iso_tf_table *tf, const iso_tf_2d *tf_2d, iso_error *err)
{
    *s = (iso_shown){.tf = tf, .per_entry = (double)(tf->count - 1) / (tf->hi - tf->lo)};
    s->before = calloc(tf->count + 2, sizeof *s->before);
    NEED_MEMORY(s->before, err, "empty space: no memory for %zu entries", tf->count);
    for (size_t i = 0; i < tf->count; ++i) {
        bool any = !tf_2d && tf->entries[4 * i + 3] > 0;
        for (int row = 0; tf_2d && row < ISO_TF_2D_ROWS; ++row)
            any = any || tf_2d->rows[row].entries[4 * i + 3] > 0;
        s->before[i + 1] = s->before[i] + any;
    }
    s->before[tf->count + 1] = s->before[tf->count];
    return ISO_OK;
}

void iso_shown_destroy(iso_shown *s)
{
    free(s->before);
    *s = (iso_shown){0};
}

/* Widens the range lo to hi of each column by a row of voxels. */
static void widen_columns(const float *restrict voxels, size_t count, float *restrict lo, float *restrict hi)
{
    for (size_t x = 0; x < count; ++x) {
        lo[x] = voxels[x] < lo[x] ? voxels[x] : lo[x];
        hi[x] = voxels[x] > hi[x] ? voxels[x] : hi[x];
    }
}

/* Fills one row of the finest blocks. lo, hi: buffers for a row of voxels each. */
static void look_at_blocks(iso_empty_space *e, const iso_level *level, const iso_shown *shown, size_t by, size_t bz,
                           float *lo, float *hi)
{
    const size_t *n = level->geometry.size, blocks = e->blocks[0][0];
    const size_t y0 = by > 0 ? 4 * by - 1 : 0, z0 = bz > 0 ? 4 * bz - 1 : 0;
    for (size_t x = 0; x < n[0]; ++x) {
        lo[x] = FLT_MAX;
        hi[x] = -FLT_MAX;
    }
    for (size_t z = z0 < n[2] ? z0 : n[2] - 1; z < n[2] && z < 4 * bz + 4; ++z)
        for (size_t y = y0 < n[1] ? y0 : n[1] - 1; y < n[1] && y < 4 * by + 4; ++y)
            widen_columns(level->scalar + (z * n[1] + y) * n[0], n[0], lo, hi);
    for (size_t b = 0; b < blocks; ++b) {
        const size_t first = b > 0 ? 4 * b - 1 : 0, end = 4 * b + 4 < n[0] ? 4 * b + 4 : n[0];
        float least = FLT_MAX, most = -FLT_MAX;
        for (size_t x = first < n[0] ? first : n[0] - 1; x < end; ++x) {
            least = lo[x] < least ? lo[x] : least;
            most = hi[x] > most ? hi[x] : most;
        }
        e->seen[0][(bz * e->blocks[0][1] + by) * blocks + b] = iso_shown_values(shown, (double)least, (double)most);
    }
}

static void keep_box(iso_empty_space *e, const double lo[3], const double hi[3])
{
    size_t first[3], end[3];
    for (int a = 0; a < 3; ++a) {
        const double last = (double)e->cells[a] - 1; /* the cell of an index i is that of floor(i + 1/2) */
        first[a] = (size_t)fmin(fmax(floor(lo[a] - 0.5), 0), last) >> iso_empty_shift[0];
        end[a] = (size_t)fmin(fmax(floor(hi[a] + 1.5), 0), last) >> iso_empty_shift[0];
    }
    for (size_t z = first[2]; z <= end[2]; ++z)
        for (size_t y = first[1]; y <= end[1]; ++y)
            for (size_t x = first[0]; x <= end[0]; ++x)
                e->seen[0][(z * e->blocks[0][1] + y) * e->blocks[0][0] + x] = 1;
}

/* Fills the blocks of level l from those four times finer. */
static void gather_blocks(iso_empty_space *e, int l)
{
    const size_t *n = e->blocks[l - 1], *m = e->blocks[l];
    for (size_t z = 0; z < n[2]; ++z)
        for (size_t y = 0; y < n[1]; ++y)
            for (size_t x = 0; x < n[0]; ++x)
                e->seen[l][((z >> 2) * m[1] + (y >> 2)) * m[0] + (x >> 2)] |= e->seen[l - 1][(z * n[1] + y) * n[0] + x];
}

iso_status iso_empty_space_create(iso_empty_space *e, const iso_level *level, const iso_shown *shown,
                                  const double keep_lo[3], const double keep_hi[3], int threads, iso_error *err)
{
    *e = (iso_empty_space){{0}, {{0}}, {NULL}};
    bool memory = true;
    for (int l = 0; l < ISO_EMPTY_LEVELS; ++l) {
        for (int a = 0; a < 3; ++a) {
            e->cells[a] = level->geometry.size[a] + 1;
            e->blocks[l][a] = (e->cells[a] + ((size_t)1 << iso_empty_shift[l]) - 1) >> iso_empty_shift[l];
        }
        e->seen[l] = calloc(e->blocks[l][0] * e->blocks[l][1] * e->blocks[l][2], 1);
        memory = memory && e->seen[l];
    }
    const size_t rows = e->blocks[0][1] * e->blocks[0][2];
    const size_t across = level->geometry.size[0];
    float *row = memory ? malloc((size_t)iso_threads(threads) * 2 * across * sizeof *row) : NULL;
    if (!row) {
        iso_empty_space_destroy(e);
        return iso_fail(err, ISO_E_MEMORY, "empty space: out of memory");
    }
#pragma omp parallel for schedule(static) num_threads(iso_threads(threads))
    for (size_t i = 0; i < rows; ++i) {
        float *own = row + (size_t)iso_thread_index() * 2 * across;
        look_at_blocks(e, level, shown, i % e->blocks[0][1], i / e->blocks[0][1], own, own + across);
    }
    free(row);
    if (keep_lo)
        keep_box(e, keep_lo, keep_hi);
    for (int l = 1; l < ISO_EMPTY_LEVELS; ++l)
        gather_blocks(e, l);
    return ISO_OK;
}

void iso_empty_space_destroy(iso_empty_space *e)
{
    for (int l = 0; l < ISO_EMPTY_LEVELS; ++l)
        free(e->seen[l]);
    *e = (iso_empty_space){{0}, {{0}}, {NULL}};
}

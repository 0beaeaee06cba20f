/* SPDX-License-Identifier: MIT */
#include "tf/ghost.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"

enum { ROUNDS = 4 };

/* ---- voxels that are empty in level 0 ---------------------------------------------------------------------------- */

/* Returns for each entry the number of entries before it with at least this extinction. NULL: no memory. */
static uint32_t *count_shown(const iso_tf_table *tf, double least)
{
    uint32_t *below = calloc(tf->count + 1, sizeof *below);
    for (size_t i = 0; below && i < tf->count; ++i)
        below[i + 1] = below[i] + ((double)tf->entries[4 * i + 3] >= least);
    return below;
}

static double entry_of(const iso_tf_table *tf, double value)
{
    const double last = (double)(tf->count - 1), x = (value - tf->lo) / (tf->hi - tf->lo) * last;
    return x > 0 ? (x < last ? x : last) : 0;
}

/* True if any value in [min, max] is counted by `below`: one of the entries around it is. */
static bool shows(const iso_tf_table *tf, const uint32_t *below, double min, double max)
{
    const size_t first = (size_t)entry_of(tf, min), end = (size_t)ceil(entry_of(tf, max)) + 1;
    return below[end] > below[first];
}

/* The fine voxels, [begin, end) along one axis, that decide on a coarse voxel: its own and half its size around. */
typedef struct span {
    size_t begin, end;
} span;

static span span_of(size_t at, size_t level, size_t fine_size)
{
    const size_t half = ((size_t)1 << level) / 2, first = at << level, past = ((at + 1) << level) + half;
    return (span){first > half ? first - half : 0, past < fine_size ? past : fine_size};
}

/* Widens the range at each place of a row by the value there; NaN changes none. */
static void widen(const float *values, size_t count, float *restrict min, float *restrict max)
{
    for (size_t x = 0; x < count; ++x) {
        min[x] = values[x] < min[x] ? values[x] : min[x];
        max[x] = values[x] > max[x] ? values[x] : max[x];
    }
}

/* Computes for each x the value range over all fine rows that decide on the coarse row (y, z). */
static void range_of_rows(const iso_level *fine, size_t level, size_t y, size_t z, float *min, float *max)
{
    const size_t *n = fine->geometry.size;
    const span rows = span_of(y, level, n[1]), planes = span_of(z, level, n[2]);
    for (size_t x = 0; x < n[0]; ++x) {
        min[x] = INFINITY;
        max[x] = -INFINITY;
    }
    for (size_t k = planes.begin; k < planes.end; ++k)
        for (size_t j = rows.begin; j < rows.end; ++j)
            widen(fine->scalar + n[0] * (j + n[1] * k), n[0], min, max);
}

/* A transfer function's entries that show something, and those that are visible: count_shown(). */
typedef struct counted {
    const iso_tf_table *tf;
    uint32_t *shown, *visible;
} counted;

/* Sets empty[]. rows: space for two rows of level 0 per thread. The boxes of fine voxels overlap, so that each voxel is
 * in eight of them: their ranges are joined along y and z for whole rows, which vectorizes, and then along x. */
static void mark_empty(const iso_level *fine, const iso_geometry *coarse, size_t level, const counted *c, int threads,
                       float *rows, uint8_t *empty)
{
    const size_t *n = coarse->size, width = fine->geometry.size[0];
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads)
    for (size_t z = 0; z < n[2]; ++z)
        for (size_t y = 0; y < n[1]; ++y) {
            float *min = rows + 2 * width * (size_t)iso_thread_index(), *max = min + width;
            range_of_rows(fine, level, y, z, min, max);
            for (size_t x = 0; x < n[0]; ++x) {
                const span box = span_of(x, level, width);
                float lo = INFINITY, hi = -INFINITY;
                for (size_t i = box.begin; i < box.end; ++i) {
                    lo = min[i] < lo ? min[i] : lo;
                    hi = max[i] > hi ? max[i] : hi;
                }
                empty[x + n[0] * (y + n[1] * z)] = shows(c->tf, c->visible, (double)lo, (double)hi) ? 0
                                                   : shows(c->tf, c->shown, (double)lo, (double)hi) ? ISO_GHOST_EMPTY
                                                                                                    : ISO_GHOST_CLEAR;
            }
        }
}

iso_status iso_ghost_mask(const iso_level *fine, const iso_level *coarse, size_t level, const iso_tf_table *original,
                          int threads, uint8_t **empty, iso_error *err)
{
    const int thread_count = iso_threads(threads);
    const double visible = -log1p(-ISO_GHOST_TRANSPARENT) / iso_geometry_min_spacing_mm(&fine->geometry);
    const counted c = {original, count_shown(original, DBL_TRUE_MIN), count_shown(original, visible)};
    float *rows = malloc(2 * fine->geometry.size[0] * (size_t)thread_count * sizeof *rows);
    *empty = malloc(iso_geometry_voxel_count(&coarse->geometry));
    const bool is_made = c.shown && c.visible && rows && *empty;
    if (is_made) {
        mark_empty(fine, &coarse->geometry, level, &c, thread_count, rows, *empty);
    } else {
        free(*empty);
        *empty = NULL;
    }
    free(rows);
    free(c.shown);
    free(c.visible);
    return is_made ? ISO_OK
                   : iso_fail(err, ISO_E_MEMORY, "ghost: no memory for one byte per voxel of level %zu", level);
}

iso_status iso_ghost_measure(const iso_pyramid *p, size_t level, const iso_tf_table *original, const iso_tf_table *tf,
                             const iso_tf_2d *tf_2d, int threads, double *ghost, iso_error *err)
{
    iso_small_views_error seen[ISO_SMALL_VIEWS_MAX_TFS];
    iso_small_views_input in = {.fine = &p->levels[0],
                                .coarse = &p->levels[level],
                                .level = level,
                                .original = original,
                                .tfs = {tf},
                                .tfs_2d = {tf_2d},
                                .tf_count = 1,
                                .threads = threads};
    FREED uint8_t *empty = NULL;
    *ghost = 0;
    if (!in.fine->scalar || !in.coarse->scalar ||
        iso_geometry_voxel_count(&in.fine->geometry) > ISO_SMALL_VIEWS_MAX_VOXELS)
        return ISO_OK;
    iso_status status = iso_ghost_mask(in.fine, in.coarse, level, original, threads, &empty, err);
    in.empty = empty;
    TRY(status, iso_small_views_compare(&in, seen, err));
    *ghost = status == ISO_OK ? seen[0].ghost : 0;
    return status;
}

/* ---- a transfer function without ghosts ---- */

/* Resets the entry to the original extinction if that is less. True if it is. */
static bool give_back(const iso_tf_table *original, iso_tf_table *adapted, size_t entry)
{
    const double step = (adapted->hi - adapted->lo) / (double)(adapted->count - 1);
    double rgbs[4];
    iso_tf_lookup(original, adapted->lo + (double)entry * step, rgbs);
    if (!(rgbs[3] < (double)adapted->entries[4 * entry + 3]))
        return false;
    adapted->entries[4 * entry + 3] = (float)rgbs[3];
    return true;
}

/* Resets once all entries with too large a share of ghost; returns their number. */
static size_t give_ghosts_back(const iso_tf_table *original, const iso_small_views_rows *rows, iso_tf_table *adapted)
{
    size_t given = 0;
    for (size_t i = 0; i < adapted->count; ++i)
        if (rows->ghost[i] > 0 && (double)rows->ghost[i] >= ISO_GHOST_SHARE * (double)rows->seen[i])
            given += give_back(original, adapted, i);
    return given;
}

iso_status iso_ghost_remove(const iso_small_views_input *in, iso_tf_table *adapted, size_t *given_back, iso_error *err)
{
    const size_t n = adapted->count;
    FREED int64_t *sums = malloc(2 * n * sizeof *sums);
    iso_status status = sums ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "ghost: no memory for %zu entries", n);
    size_t given = 1;
    *given_back = 0;
    for (int round = 0; round < ROUNDS && given > 0 && status == ISO_OK; ++round) {
        const iso_small_views_rows rows = {sums, sums + n};
        iso_small_views_error seen[ISO_SMALL_VIEWS_MAX_TFS];
        iso_small_views_input own = *in;
        memset(sums, 0, 2 * n * sizeof *sums);
        own.tfs[0] = adapted;
        own.tf_count = 1;
        own.rows = &rows;
        status = iso_small_views_compare(&own, seen, err);
        if (status != ISO_OK || seen[0].ghost <= ISO_GHOST_LIMIT / 10)
            break;
        given = give_ghosts_back(in->original, &rows, adapted);
        *given_back += given;
    }
    return status;
}

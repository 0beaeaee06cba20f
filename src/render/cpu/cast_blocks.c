/* SPDX-License-Identifier: MIT */
/* cast_blocks.c - the visible cells of a level, by blocks (cast_bricks.h). */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "base/simd.h"
#include "brick/occupancy.h"
#include "render/cpu/cast_bricks.h"

enum { BLOCK = 1 << ISO_CAST_BLOCK_SHIFT, CORNERS = BLOCK + 1 };

/* Values that a transfer function shows: a cell can show something only if its values reach `least` and `most`. With
 * several ranges of visible values that is not enough. */
typedef struct shown_values {
    iso_tf_shown tf;
    bool is_one_range;
    float least, most;
} shown_values;

/* Returns float number `order`, counted from 0: positive ones up to infinity, and as many negative ones. */
static float float_at(int32_t order)
{
    const uint32_t bits = (uint32_t)(order < 0 ? -order : order);
    float value;
    memcpy(&value, &bits, sizeof value);
    return order < 0 ? -value : value;
}

/* Finds the least float whose last entry is at least this one; or, downwards, the largest one whose first entry is at
 * most this one. */
static float reach_entry(const iso_tf_shown *s, size_t entry, bool up)
{
    enum { INFINITE = 0x7f800000 };
    int32_t misses = -INFINITE, reaches = INFINITE; /* both mirrored downwards */
    while (reaches - (int64_t)misses > 1) {
        const int32_t middle = (int32_t)(((int64_t)misses + reaches) / 2);
        const double value = (double)float_at(up ? middle : -middle);
        size_t from, to;
        iso_tf_entries_of(s, value, value, &from, &to);
        if (up ? to >= entry : from <= entry)
            reaches = middle;
        else
            misses = middle;
    }
    return float_at(up ? reaches : -reaches);
}

static shown_values find_shown(const iso_tf_table *tf, uint32_t *next)
{
    shown_values s = {.tf = iso_tf_shown_of(tf, next), .least = INFINITY, .most = -INFINITY, .is_one_range = true};
    const size_t first = next[0], count = tf->count;
    size_t last = 0, ranges = 0;
    if (first == count)
        return s;
    for (size_t i = 0; i < count; ++i)
        if (next[i] == i) {
            ranges += i == 0 || next[i - 1] != i - 1;
            last = i;
        }
    s.is_one_range = ranges == 1;
    s.least = first == 0 ? -INFINITY : reach_entry(&s.tf, first, true);
    s.most = last + 1 == count ? INFINITY : reach_entry(&s.tf, last, false);
    return s;
}

/* ---- rows of cells ---- */

/* Rows of a level along x, CORNERS x CORNERS of them at the corners of a row of blocks, with the outermost voxels
 * repeated; and the range of each cell of one row of cells. */
typedef struct block_rows {
    size_t stride; /* floats of a row, a multiple of 16 above the cells and BLOCK */
    float *rows, *low, *high, *min, *max;
    uint8_t *shows;
} block_rows;

static float *row_at(const block_rows *r, size_t y, size_t z)
{
    return r->rows + r->stride * (y + CORNERS * z);
}

static bool create_rows(block_rows *r, size_t nx)
{
    *r = (block_rows){.stride = (nx + 1 + BLOCK + 1 + 15) / 16 * 16};
    r->rows = calloc(r->stride * (CORNERS * CORNERS + 2 * CORNERS + 2) + r->stride / 4, sizeof *r->rows);
    if (!r->rows)
        return false;
    r->low = r->rows + r->stride * CORNERS * CORNERS;
    r->high = r->low + r->stride * CORNERS;
    r->min = r->high + r->stride * CORNERS;
    r->max = r->min + r->stride;
    r->shows = (uint8_t *)(r->max + r->stride);
    return true;
}

static void read_rows(const iso_level *level, size_t by, size_t bz, block_rows *r)
{
    const size_t *n = level->geometry.size;
    for (size_t z = 0; z < CORNERS; ++z)
        for (size_t y = 0; y < CORNERS; ++y) {
            float *row = row_at(r, y, z);
            const size_t first = n[0] * (iso_cast_inner(by * BLOCK + y, n[1]) +
                                         n[1] * iso_cast_inner(bz * BLOCK + z, n[2]));
            const float *from = iso_level_floats(level, first, n[0], row + 1);
            if (from != row + 1)
                memcpy(row + 1, from, n[0] * sizeof *row);
            row[0] = row[1];
            for (size_t x = n[0] + 1; x < r->stride; ++x)
                row[x] = row[n[0]];
        }
}

ISO_SIMD static void range_of_two(const float *restrict a, const float *restrict b, size_t n, float *restrict low,
                                  float *restrict high)
{
    for (size_t i = 0; i < n; ++i) {
        low[i] = a[i] < b[i] ? a[i] : b[i];
        high[i] = a[i] > b[i] ? a[i] : b[i];
    }
}

/* Joins the ranges of two pairs of rows, and those of the next along x. Returns whether any of the n cells can show
 * something by least and most; shows[]: which. */
ISO_SIMD static bool find_cells(const float *restrict low0, const float *restrict low1, const float *restrict high0,
                                const float *restrict high1, size_t n, float least, float most, float *restrict min,
                                float *restrict max, uint8_t *restrict shows)
{
    int any = 0;
    for (size_t i = 0; i < n; ++i) {
        const float a = low0[i] < low1[i] ? low0[i] : low1[i];
        const float b = low0[i + 1] < low1[i + 1] ? low0[i + 1] : low1[i + 1];
        const float c = high0[i] > high1[i] ? high0[i] : high1[i];
        const float d = high0[i + 1] > high1[i + 1] ? high0[i + 1] : high1[i + 1];
        min[i] = a < b ? a : b;
        max[i] = c > d ? c : d;
    }
    for (size_t i = 0; i < n; ++i) {
        const int is_shown = (max[i] >= least) & (min[i] <= most);
        shows[i] = (uint8_t)is_shown;
        any |= is_shown;
    }
    return any;
}

/* Takes the cells that lie between two ranges of visible values away. */
static void look_closely(const shown_values *s, const float *min, const float *max, size_t n, uint8_t *shows)
{
    for (size_t i = 0; i < n; ++i)
        shows[i] = shows[i] && iso_tf_shown_in(&s->tf, (double)min[i], (double)max[i]);
}

/* Adds the bits of a row of cells to the words of its blocks. */
static void add_bits(const uint8_t *shows, size_t blocks, int shift, uint32_t *words)
{
    for (size_t b = 0; b < blocks; ++b) {
        const uint8_t *four = shows + BLOCK * b;
        const uint32_t bits = (uint32_t)(four[0] | four[1] << 1 | four[2] << 2 | four[3] << 3);
        words[2 * b] |= bits << shift;
    }
}

/* Sets the words of a row of blocks. */
static void find_blocks(const iso_level *level, const shown_values *s, size_t by, size_t bz, size_t blocks,
                        block_rows *r, uint32_t *words)
{
    const size_t cells = blocks * BLOCK, corners = cells + 1;
    memset(words, 0, 2 * blocks * sizeof *words);
    read_rows(level, by, bz, r);
    for (size_t y = 0; y < BLOCK; ++y) {
        for (size_t z = 0; z < CORNERS; ++z)
            range_of_two(row_at(r, y, z), row_at(r, y + 1, z), corners, r->low + r->stride * z,
                         r->high + r->stride * z);
        for (size_t z = 0; z < BLOCK; ++z) {
            const float *low = r->low + r->stride * z, *high = r->high + r->stride * z;
            if (!find_cells(low, low + r->stride, high, high + r->stride, cells, s->least, s->most, r->min, r->max,
                            r->shows))
                continue;
            if (!s->is_one_range)
                look_closely(s, r->min, r->max, cells, r->shows);
            add_bits(r->shows, blocks, (int)(BLOCK * (y + BLOCK * (z % 2))), words + z / 2);
        }
    }
}

/* ---- all blocks ---- */

static bool find_all(iso_cast_blocks *b, const iso_level *level, const shown_values *s, int threads, uint8_t *empty,
                     size_t *shown)
{
    const size_t rows = b->count[1] * b->count[2], n = b->count[0];
    bool complete = true;
    size_t found = 0;
#pragma omp parallel num_threads(iso_threads(threads)) reduction(+ : found) reduction(&& : complete)
    {
        block_rows r = {0};
        complete = create_rows(&r, level->geometry.size[0]);
#pragma omp for schedule(dynamic, 16)
        for (size_t i = 0; i < rows; ++i) {
            uint32_t *words = b->cells + 2 * n * i;
            if (r.rows)
                find_blocks(level, s, i % b->count[1], i / b->count[1], n, &r, words);
            for (size_t x = 0; x < n; ++x) {
                empty[n * i + x] = !(words[2 * x] | words[2 * x + 1]);
                found += !empty[n * i + x];
            }
        }
        free(r.rows);
    }
    *shown = found;
    return complete;
}

iso_status iso_cast_blocks_create(iso_cast_blocks *b, const iso_level *level, const iso_tf_table *tf, int threads,
                                  iso_error *err)
{
    size_t shown = 0;
    *b = (iso_cast_blocks){.blocks = 1};
    for (int a = 0; a < 3; ++a)
        b->blocks *= b->count[a] = level->geometry.size[a] / BLOCK + 1;
    uint32_t *next = malloc(tf->count * sizeof *next);
    uint8_t *empty = malloc(b->blocks);
    b->cells = malloc(2 * b->blocks * sizeof *b->cells);
    b->octants = malloc(ISO_OCTANTS * b->blocks + 4); /* four bytes are fetched for one */
    bool has_all = next && b->cells && empty && b->octants;
    if (has_all) {
        const shown_values s = find_shown(tf, next);
        has_all = find_all(b, level, &s, threads, empty, &shown);
        memset(b->octants + ISO_OCTANTS * b->blocks, 0, 4);
        iso_occupancy_octants(b->count, empty, threads, b->octants);
    }
    free(empty);
    free(next);
    b->occupied = (double)shown / (double)b->blocks;
    return has_all ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "cpu: no memory for %zu blocks", b->blocks);
}

void iso_cast_blocks_destroy(iso_cast_blocks *b)
{
    free(b->octants);
    free(b->cells);
    *b = (iso_cast_blocks){0};
}

/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "tf/histogram.h"

#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include "base/file.h"
#include "base/parallel.h"
#include "base/simd.h"

/* ---- rows of level k at the fine voxels ---- */

/* Position of a fine voxel between two coarse ones along one axis, clamped to the edge. */
typedef struct place_between {
    size_t left, right;
    float weight_left, weight_right;
} place_between;

/* Scale of a coarse row in bins: ((blend of four rows) - lo) / step + 1/2, inside [1/2, count - 1/2]. Truncation then
 * rounds also values interpolated between two of them. */
typedef struct row_scale {
    float lo, per_step, last; /* last = count - 1 */
} row_scale;

static place_between place_at(size_t fine, size_t level, size_t coarse_count)
{
    size_t cell = fine >> level, phase = fine & (((size_t)1 << level) - 1), width = (size_t)1 << level;
    /* from the cell's center to the fine voxel's, in cells */
    float offset = ((float)(2 * phase + 1) - (float)width) / (float)(2 * width);
    place_between p = {cell, cell, 1, 0};
    if (offset < 0) {
        p.left = cell > 0 ? cell - 1 : 0;
        p.weight_left = -offset, p.weight_right = 1 + offset;
    } else {
        p.right = cell + 1 < coarse_count ? cell + 1 : cell;
        p.weight_left = 1 - offset, p.weight_right = offset;
    }
    return p;
}

/* Blends four rows into out, count + 2 floats; out[0] and out[count + 1] repeat the ends. */
ISO_SIMD static void blend_rows(const float *const rows[4], const float weights[4], row_scale scale, size_t count,
                                float *restrict out)
{
    const float *r0 = rows[0], *r1 = rows[1], *r2 = rows[2], *r3 = rows[3];
    const float w0 = weights[0], w1 = weights[1], w2 = weights[2], w3 = weights[3], last = scale.last;
    for (size_t x = 0; x < count; ++x) {
        float at = ((w0 * r0[x] + w1 * r1[x]) + (w2 * r2[x] + w3 * r3[x]) - scale.lo) * scale.per_step;
        at = at > 0 ? at : 0;
        out[x + 1] = (at < last ? at : last) + 0.5f;
    }
    out[0] = out[1];
    out[count + 1] = out[count];
}

/* Expands the cells [0, cells) of a level whose voxels are `width` wide. After inlining, `width` is a constant: the
 * inner loop unrolls and its stores become vectors. */
static inline __attribute__((always_inline)) void expand_cells(const float *row, size_t width, size_t cells,
                                                               uint32_t *restrict bins)
{
    for (size_t c = 0; c < cells; ++c) {
        const float left = row[c], own = row[c + 1], right = row[c + 2];
        for (size_t m = 0; m < width; ++m) {
            const float offset = ((float)(2 * m + 1) - (float)width) / (float)(2 * width);
            const float at = offset < 0 ? (1 + offset) * own - offset * left : (1 - offset) * own + offset * right;
            bins[c * width + m] = (uint32_t)(int32_t)at;
        }
    }
}

ISO_SIMD static void expand_by_2(const float *row, size_t cells, uint32_t *restrict bins)
{
    expand_cells(row, 2, cells, bins);
}

ISO_SIMD static void expand_by_4(const float *row, size_t cells, uint32_t *restrict bins)
{
    expand_cells(row, 4, cells, bins);
}

ISO_SIMD static void expand_by_8(const float *row, size_t cells, uint32_t *restrict bins)
{
    expand_cells(row, 8, cells, bins);
}

/* Sets bins[x] to that row, with its repeated ends, looked up at the fine voxels' centers and truncated. */
static void expand_bins(const float *row, size_t level, size_t fine_count, uint32_t *restrict bins)
{
    const size_t width = (size_t)1 << level, cells = fine_count >> level;
    switch (level) {
    case 1: expand_by_2(row, cells, bins); break;
    case 2: expand_by_4(row, cells, bins); break;
    case 3: expand_by_8(row, cells, bins); break;
    default: expand_cells(row, width, cells, bins); break;
    }
    for (size_t x = cells * width; x < fine_count; ++x) { /* the last cell is cut off by the edge */
        const float offset = ((float)(2 * (x - cells * width) + 1) - (float)width) / (float)(2 * width),
                    *own = row + cells + 1;
        bins[x] = (uint32_t)(int32_t)(offset < 0 ? (1 + offset) * own[0] - offset * own[-1]
                                                 : (1 - offset) * own[0] + offset * own[1]);
    }
}

/* Sets keys[x] to keys[x] z_count + nearest bin of values[x]. */
ISO_SIMD static void join_bins(const float *values, size_t n, row_scale scale, uint32_t z_count,
                               uint32_t *restrict keys)
{
    for (size_t x = 0; x < n; ++x) {
        float at = (values[x] - scale.lo) * scale.per_step;
        at = at > 0 ? at : 0;
        at = at < scale.last ? at : scale.last;
        keys[x] = keys[x] * z_count + (uint32_t)(int32_t)(at + 0.5f);
    }
}

/* Adds 1 to the count of each key, alternating between two tables (which may be the same one), so that an increment
 * need not wait for the last. Eight equal keys are one addition: volumes have large parts of one value. */
static void count_keys(const uint32_t *keys, size_t n, uint32_t *even, uint32_t *odd)
{
    size_t x = 0;
    for (; x + 8 <= n; x += 8) {
        const uint32_t *k = keys + x, first = k[0];
        uint32_t other = 0;
        for (int i = 1; i < 8; ++i)
            other |= k[i] ^ first;
        if (!other) {
            even[first] += 8;
            continue;
        }
        for (int i = 0; i < 8; i += 2) {
            ++even[k[i]];
            ++odd[k[i + 1]];
        }
    }
    for (; x < n; ++x)
        ++even[keys[x]];
}

/* ---- bins ---- */

/* Fine voxels per slab: its counts fit 32 bits. */
#define SLAB_VOXELS ((size_t)1 << 26)
/* Counts are kept in tables for up to DENSE_PAIRS pairs of bins; for more pairs, and for volumes that would hardly fill
 * a table, in hash maps. Each thread has its own tables (two for up to TWIN_PAIRS pairs, see count_keys()) as long
 * as all of them hold at most OWN_PAIRS pairs; more threads share one by atomic additions of runs of equal pairs. */
#define TWIN_PAIRS ((size_t)1 << 20)
#define OWN_PAIRS ((size_t)1 << 26)
#define DENSE_PAIRS ((size_t)1 << 24)

void iso_joint_bins(double min, double max, iso_type type, int bits, iso_bins *z, iso_bins *s)
{
    bool whole = type != ISO_F32 && type != ISO_F64;
    size_t count = (size_t)1 << bits, rows = count < ISO_JOINT_MAX_ROWS ? count : ISO_JOINT_MAX_ROWS;
    double range = max > min ? max - min : 1;
    /* 8-bit data keeps bins 0 to 255, so that a bin's number is its value. */
    double lo = type == ISO_U8 ? 0 : min;
    if (type == ISO_U8)
        range = max;
    bool fits_z = whole && range <= (double)(count - 1), fits_s = whole && range <= (double)(rows - 1);
    *z = (iso_bins){count, lo, fits_z ? 1 : range / (double)(count - 1)};
    *s = (iso_bins){rows, lo, fits_s ? 1 : range / (double)(rows - 1)};
}

/* ---- counting ----------------------------------------------------------------- */

/* Map from pairs to counts: open addressing, at most half full. Keys are stored plus 1; 0 means free. */
typedef struct pair_map {
    uint32_t *keys;
    uint64_t *counts;
    size_t capacity, used;
} pair_map;

static bool map_add(pair_map *m, uint32_t key, uint64_t count);

static bool map_grow(pair_map *m)
{
    pair_map bigger = {.capacity = m->capacity ? 2 * m->capacity : 1 << 16};
    bigger.keys = calloc(bigger.capacity, sizeof *bigger.keys);
    bigger.counts = malloc(bigger.capacity * sizeof *bigger.counts);
    bool good = bigger.keys && bigger.counts;
    for (size_t i = 0; good && i < m->capacity; ++i)
        if (m->keys[i])
            map_add(&bigger, m->keys[i] - 1, m->counts[i]);
    if (good) {
        pair_map old = *m;
        *m = bigger;
        bigger = old;
    }
    free(bigger.keys);
    free(bigger.counts);
    return good;
}

static bool map_add(pair_map *m, uint32_t key, uint64_t count)
{
    if (2 * m->used >= m->capacity && !map_grow(m))
        return false;
    size_t mask = m->capacity - 1, at = (key * (size_t)0x9e3779b97f4a7c15u >> 20) & mask;
    while (m->keys[at] && m->keys[at] != key + 1)
        at = (at + 1) & mask;
    if (!m->keys[at]) {
        m->keys[at] = key + 1;
        m->counts[at] = 0;
        ++m->used;
    }
    m->counts[at] += count;
    return true;
}

static void map_free(pair_map *m)
{
    free(m->keys);
    free(m->counts);
    *m = (pair_map){0};
}

/* Counts of one thread in one slab. */
typedef struct counter {
    uint32_t *tables; /* dense, table_count of them */
    pair_map map;
    float *blended;
    uint32_t *keys, *second_bins;
    bool failed;
} counter;

/* The bins, and the samples to count. */
typedef struct joint_shape {
    iso_bins z, s;
    size_t second_count;         /* bins of the second value: 1, or ISO_TF_2D_ROWS */
    const size_t *fine, *coarse; /* sizes of level 0 and of level `level` */
    const float *values, *level_values;
    float *second; /* its bin at each voxel of the level, possibly fractional; NULL with a count of 1 */
    size_t level;
    bool has_no_data; /* voxels without data, and those next to coarse ones without, are not counted */
} joint_shape;

typedef struct builder {
    joint_shape shape;
    int thread_count;
    bool dense, shared; /* shared: True if all threads add to `table` */
    size_t table_count; /* per thread: 1 or 2 */
    counter *counters;  /* one per thread */
    uint64_t *table;    /* sums if dense, else in `map` */
    pair_map map;
} builder;

static size_t pair_count(const builder *b)
{
    return b->shape.z.count * b->shape.s.count * b->shape.second_count;
}

static void free_counter(counter *c)
{
    free(c->tables);
    map_free(&c->map);
    free(c->blended);
    free(c->keys);
    free(c->second_bins);
}

static bool make_counter(counter *c, const builder *b)
{
    c->blended = malloc((b->shape.coarse[0] + 2) * sizeof *c->blended);
    c->keys = malloc(b->shape.fine[0] * sizeof *c->keys);
    c->tables = b->dense && !b->shared ? calloc(b->table_count * pair_count(b), sizeof *c->tables) : NULL;
    c->second_bins = malloc(b->shape.fine[0] * sizeof *c->second_bins);
    return c->blended && c->keys && c->second_bins && (c->tables || !b->dense || b->shared);
}

static void builder_destroy(builder *b)
{
    for (int t = 0; b->counters && t < b->thread_count; ++t)
        free_counter(&b->counters[t]);
    free(b->counters);
    free(b->table);
    map_free(&b->map);
    free(b->shape.second);
}

/* Prepares a builder whose shape is set. */
static iso_status begin(builder *b, int threads, iso_error *err)
{
    const joint_shape *shape = &b->shape;
    const size_t pairs = pair_count(b);
    b->thread_count = iso_threads(threads);
    b->dense = pairs <= TWIN_PAIRS ||
               (pairs <= DENSE_PAIRS && pairs / 8 <= shape->fine[0] * shape->fine[1] * shape->fine[2]);
    b->table_count = pairs <= TWIN_PAIRS ? 2 : 1;
    b->shared = b->dense && pairs * b->table_count * (size_t)b->thread_count > OWN_PAIRS;
    b->counters = calloc((size_t)b->thread_count, sizeof *b->counters);
    b->table = b->dense ? calloc(pairs, sizeof *b->table) : NULL;
    bool good = b->counters && (b->table || !b->dense);
    for (int t = 0; good && t < b->thread_count; ++t)
        good = make_counter(&b->counters[t], b);
    NEED_MEMORY(good, err, "joint histogram: no memory for %zu x %zu bins", shape->z.count, shape->s.count);
    return ISO_OK;
}

static void count_row(const builder *b, counter *c, size_t n)
{
    const uint32_t *keys = c->keys;
    if (!b->dense)
        for (size_t x = 0; x < n && !c->failed; ++x)
            c->failed = !map_add(&c->map, keys[x], 1);
    else if (b->shared)
        for (size_t x = 0, end; x < n; x = end) {
            for (end = x + 1; end < n && keys[end] == keys[x];)
                ++end;
            __atomic_fetch_add(&b->table[keys[x]], end - x, __ATOMIC_RELAXED);
        }
    else
        count_keys(keys, n, c->tables, c->tables + (b->table_count - 1) * pair_count(b));
}

/* A row of level 0. */
typedef struct row_place {
    size_t y, z;
} row_place;

/* Looks up the bins of a level's values at the fine voxels of a row. */
static void lookup_row(const builder *b, counter *c, row_place at, const float *coarse, row_scale scale, uint32_t *bins)
{
    const place_between py = place_at(at.y, b->shape.level, b->shape.coarse[1]),
                        pz = place_at(at.z, b->shape.level, b->shape.coarse[2]);
    const size_t plane = b->shape.coarse[0] * b->shape.coarse[1];
    const float *left = coarse + pz.left * plane, *right = coarse + pz.right * plane;
    const float *const rows[4] = {left + py.left * b->shape.coarse[0], left + py.right * b->shape.coarse[0],
                                  right + py.left * b->shape.coarse[0], right + py.right * b->shape.coarse[0]};
    const float weights[4] = {pz.weight_left * py.weight_left, pz.weight_left * py.weight_right,
                              pz.weight_right * py.weight_left, pz.weight_right * py.weight_right};
    blend_rows(rows, weights, scale, b->shape.coarse[0], c->blended);
    expand_bins(c->blended, b->shape.level, b->shape.fine[0], bins);
}

static row_scale scale_of(const iso_bins *bins)
{
    return (row_scale){(float)bins->lo, (float)(1 / bins->step), (float)(bins->count - 1)};
}

/* Keeps the keys of voxels that have data, and between coarse ones that have. Returns their number. */
static size_t keep_data(const builder *b, counter *c, row_place at, const float *fine_row)
{
    const size_t *size = b->shape.coarse, level = b->shape.level;
    const place_between y = place_at(at.y, level, size[1]), z = place_at(at.z, level, size[2]);
    size_t kept = 0;
    for (size_t i = 0; i < b->shape.fine[0]; ++i) {
        const place_between x = place_at(i, level, size[0]);
        bool is_there = !iso_is_no_data(fine_row[i]);
        for (int corner = 0; corner < 8 && is_there; ++corner) {
            const size_t cz = corner & 4 ? z.right : z.left;
            is_there = !iso_is_no_data(
                b->shape.level_values[(corner & 1 ? x.right : x.left) +
                                      size[0] * ((corner & 2 ? y.right : y.left) + size[1] * cz)]);
        }
        c->keys[kept] = c->keys[i];
        kept += is_there;
    }
    return kept;
}

static void add_row(const builder *b, counter *c, row_place at)
{
    const size_t n = b->shape.fine[0];
    const float *fine_row = b->shape.values + (at.z * b->shape.fine[1] + at.y) * n;
    lookup_row(b, c, at, b->shape.level_values, scale_of(&b->shape.s), c->keys);
    if (b->shape.second_count > 1) {
        const row_scale whole = {0, 1, (float)(b->shape.second_count - 1)};
        lookup_row(b, c, at, b->shape.second, whole, c->second_bins);
        for (size_t x = 0; x < n; ++x)
            c->keys[x] += c->second_bins[x] * (uint32_t)b->shape.s.count;
    }
    join_bins(fine_row, n, scale_of(&b->shape.z), (uint32_t)b->shape.z.count, c->keys);
    count_row(b, c, b->shape.has_no_data ? keep_data(b, c, at, fine_row) : n);
}

/* Moves counts to the sums. Most of a large table is empty: blocks without counts are skipped and stay unallocated. */
static void take_counts(uint32_t *counts, size_t pairs, uint64_t *sums)
{
    const size_t block = 16;
    for (size_t i = 0; i < pairs; i += block) {
        size_t n = pairs - i < block ? pairs - i : block;
        uint32_t any = 0;
        for (size_t j = 0; j < n; ++j)
            any |= counts[i + j];
        for (size_t j = 0; any && j < n; ++j) {
            sums[i + j] += counts[i + j];
            counts[i + j] = 0;
        }
    }
}

/* Adds all threads' counts to the sums. False: no memory. */
static bool merge(builder *b)
{
    size_t pairs = pair_count(b);
    bool good = true;
    for (int t = 0; t < b->thread_count; ++t) {
        counter *c = &b->counters[t];
        good = good && !c->failed;
        for (size_t i = 0; good && i < c->map.capacity; ++i)
            if (c->map.keys[i])
                good = map_add(&b->map, c->map.keys[i] - 1, c->map.counts[i]);
        map_free(&c->map);
        for (size_t i = 0; c->tables && i < b->table_count; ++i)
            take_counts(c->tables + i * pairs, pairs, b->table);
    }
    return good;
}

/* Counts the fine planes [z0, z1). */
static iso_status add_slab(builder *b, size_t z0, size_t z1, iso_error *err)
{
    const size_t ny = b->shape.fine[1], part = (size_t)b->thread_count;
#pragma omp parallel for schedule(static, 1) num_threads(b->thread_count)
    for (size_t t = 0; t < part; ++t) {
        const size_t row0 = (z1 - z0) * ny * t / part, row1 = (z1 - z0) * ny * (t + 1) / part;
        for (size_t r = row0; r < row1; ++r)
            add_row(b, &b->counters[t], (row_place){r % ny, z0 + r / ny});
    }
    return merge(b) ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "joint histogram: out of memory");
}

/* ---- rows ----------------------------------------------------------------------- */

static iso_status make_rows(iso_joint *joint, const builder *b, size_t entry_count, iso_error *err)
{
    *joint = (iso_joint){.z = b->shape.z,
                         .s = b->shape.s,
                         .second = ISO_SECOND_VALUE_NONE,
                         .second_count = b->shape.second_count,
                         .entry_count = entry_count};
    joint->row_start = calloc(iso_joint_row_count(joint) + 1, sizeof *joint->row_start);
    joint->entry_z = malloc((entry_count ? entry_count : 1) * sizeof *joint->entry_z);
    joint->entry_count_of = malloc((entry_count ? entry_count : 1) * sizeof *joint->entry_count_of);
    if (joint->row_start && joint->entry_z && joint->entry_count_of)
        return ISO_OK;
    iso_joint_destroy(joint);
    return iso_fail(err, ISO_E_MEMORY, "joint histogram: no memory for %zu entries", entry_count);
}

/* Stores entry number `at`; keys s * z.count + z must arrive in ascending order. */
static void put_entry(iso_joint *joint, size_t at, size_t key, uint64_t count)
{
    joint->entry_z[at] = (uint16_t)(key % joint->z.count);
    joint->entry_count_of[at] = count;
    joint->voxel_count += count;
    ++joint->row_start[key / joint->z.count + 1];
}

static void sum_rows(iso_joint *joint)
{
    for (size_t i = 0; i < iso_joint_row_count(joint); ++i)
        joint->row_start[i + 1] += joint->row_start[i];
}

typedef struct pair {
    uint32_t key;
    uint64_t count;
} pair;

static int compare_pairs(const void *a, const void *b)
{
    uint32_t ka = ((const pair *)a)->key, kb = ((const pair *)b)->key;
    return (ka > kb) - (ka < kb);
}

static iso_status rows_from_map(const builder *b, iso_joint *joint, iso_error *err)
{
    FREED pair *pairs = malloc((b->map.used ? b->map.used : 1) * sizeof *pairs);
    NEED(pairs ? make_rows(joint, b, b->map.used, err)
               : iso_fail(err, ISO_E_MEMORY, "joint histogram: no memory for %zu entries", b->map.used));
    size_t used = 0;
    for (size_t i = 0; i < b->map.capacity; ++i)
        if (b->map.keys[i])
            pairs[used++] = (pair){b->map.keys[i] - 1, b->map.counts[i]};
    qsort(pairs, used, sizeof *pairs, compare_pairs);
    for (size_t i = 0; i < used; ++i)
        put_entry(joint, i, pairs[i].key, pairs[i].count);
    sum_rows(joint);
    return ISO_OK;
}

static iso_status rows_from_table(const builder *b, iso_joint *joint, iso_error *err)
{
    const uint64_t *table = b->table;
    size_t pairs = pair_count(b), entries = 0;
    for (size_t i = 0; i < pairs; ++i)
        entries += table[i] > 0;
    NEED(make_rows(joint, b, entries, err));
    for (size_t i = 0, at = 0; i < pairs; ++i)
        if (table[i] > 0)
            put_entry(joint, at++, i, table[i]);
    sum_rows(joint);
    return ISO_OK;
}

void iso_joint_destroy(iso_joint *joint)
{
    if (!joint)
        return;
    free(joint->row_start);
    free(joint->entry_z);
    free(joint->entry_count_of);
    *joint = (iso_joint){0};
}

iso_status iso_joint_compute(const iso_pyramid *p, size_t level, int bits, iso_second_value second, int threads,
                             iso_joint *joint, iso_error *err)
{
    *joint = (iso_joint){0};
    if (level < 1 || level >= p->level_count)
        return iso_fail(err, ISO_E_RANGE, "joint histogram: level %zu, must be 1 to %zu", level, p->level_count - 1);
    if (bits < 8 || bits > 16)
        return iso_fail(err, ISO_E_RANGE, "joint histogram: %d bits, must be 8 to 16", bits);
    if (second < ISO_SECOND_VALUE_NONE || second > ISO_SECOND_VALUE_GRADIENT)
        return iso_fail(err, ISO_E_RANGE, "joint histogram: unknown second value %d", (int)second);
    if (second != ISO_SECOND_VALUE_NONE && bits > 12)
        return iso_fail(err, ISO_E_RANGE, "joint histogram: %d bits with a second value, must be 8 to 12", bits);
    const iso_level *fine = &p->levels[0], *coarse = &p->levels[level];
    const size_t *n = fine->geometry.size, voxels = iso_geometry_voxel_count(&coarse->geometry);
    OWNED(builder)
    b = {.shape = {.second_count = second == ISO_SECOND_VALUE_NONE ? 1 : ISO_TF_2D_ROWS,
                   .fine = n,
                   .coarse = coarse->geometry.size,
                   .values = fine->scalar,
                   .level_values = coarse->scalar,
                   .level = level,
                   .has_no_data = fine->geometry.has_no_data}};
    iso_joint_bins(fine->min, fine->max, fine->stored_type, bits, &b.shape.z, &b.shape.s);
    NEED(begin(&b, threads, err));
    if (second != ISO_SECOND_VALUE_NONE) {
        b.shape.second = malloc(voxels * sizeof *b.shape.second);
        NEED_MEMORY(b.shape.second, err, "joint histogram: no memory for the second value of %zu voxels", voxels);
        NEED(iso_joint_second_coordinates(p, level, second, threads, b.shape.second, err));
    }
    const size_t slab = SLAB_VOXELS / (n[0] * n[1]) > 0 ? SLAB_VOXELS / (n[0] * n[1]) : 1;
    for (size_t z = 0; z < n[2]; z += slab)
        NEED(add_slab(&b, z, z + slab < n[2] ? z + slab : n[2], err));
    NEED(b.dense ? rows_from_table(&b, joint, err) : rows_from_map(&b, joint, err));
    joint->second = second;
    return ISO_OK;
}

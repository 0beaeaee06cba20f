/* SPDX-License-Identifier: MIT */
#include "vdb/vdb_sparse.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "brick/occupancy.h"
#include "pyramid/narrow.h"

/* ---- visible voxels ---- */

/* The visible entries of a table: next[i] is the first one from i on, `count` if there is none. */
typedef struct shown_entries {
    double lo, scale, last;
    uint32_t *next;
} shown_entries;

typedef struct shown_test {
    size_t count;
    shown_entries *tables;
    bool plain; /* no tables: all values but `background` are visible */
    float background;
} shown_test;

static void shown_test_destroy(shown_test *t)
{
    for (size_t i = 0; t->tables && i < t->count; ++i)
        free(t->tables[i].next);
    free(t->tables);
    *t = (shown_test){0};
}

static void note_entries(shown_entries *e, const iso_tf_table *tf)
{
    size_t next = tf->count;
    for (size_t i = tf->count; i-- > 0;) {
        next = tf->entries[4 * i + 3] > 0 ? i : next;
        e->next[i] = next < e->next[i] ? (uint32_t)next : e->next[i];
    }
}

/* Adds a table. Tables of one range and size, such as the rows of a 2D transfer function, are merged. */
static bool add_table(shown_test *t, const iso_tf_table *tf)
{
    const double scale = (double)(tf->count - 1) / (tf->hi - tf->lo), last = (double)(tf->count - 1);
    for (size_t i = 0; i < t->count; ++i)
        if (t->tables[i].lo == tf->lo && t->tables[i].scale == scale && t->tables[i].last == last) {
            note_entries(&t->tables[i], tf);
            return true;
        }
    shown_entries *e = &t->tables[t->count];
    *e = (shown_entries){tf->lo, scale, last, malloc(tf->count * sizeof *e->next)};
    if (!e->next)
        return false;
    ++t->count;
    for (size_t i = 0; i < tf->count; ++i)
        e->next[i] = (uint32_t)tf->count;
    note_entries(e, tf);
    return true;
}

static iso_status shown_test_create(shown_test *t, const iso_vdb_shown *shown, iso_error *err)
{
    *t = (shown_test){.plain = shown->tf_count == 0, .background = (float)shown->background};
    t->tables = calloc(shown->tf_count + 1, sizeof *t->tables);
    bool good = t->tables != NULL;
    for (size_t i = 0; i < shown->tf_count && good; ++i)
        good = add_table(t, &shown->tfs[i]);
    if (good)
        return ISO_OK;
    shown_test_destroy(t);
    return iso_fail(err, ISO_E_MEMORY, "sparse grids: out of memory");
}

static inline double within(double x, double last)
{
    return x > 0 ? (x < last ? x : last) : 0;
}

/* Does the work of iso_tf_shows() for any of the tables, in constant time. */
static inline bool shows(const shown_test *t, float min, float max)
{
    if (t->plain)
        return !(min == t->background && max == t->background);
    for (size_t i = 0; i < t->count; ++i) {
        const shown_entries *e = &t->tables[i];
        const double first = within(((double)min - e->lo) * e->scale - 1e-3, e->last);
        const double end = within(((double)max - e->lo) * e->scale + 1e-3, e->last);
        if (e->next[(size_t)first] <= (size_t)ceil(end))
            return true;
    }
    return false;
}

/* True if no value between the two is visible. */
static inline bool joined(const shown_test *t, float value, float background)
{
    return !shows(t, value < background ? value : background, value < background ? background : value);
}

/* ---- the background -------------------------------------------------------------- */

enum { BIN_COUNT = 4096 };

/* Rounds to a half float if the value is in range. */
static float to_half(float value)
{
    int exponent;
    frexp((double)value, &exponent);
    return (float)ldexp(rint(ldexp((double)value, 11 - exponent)), exponent - 11);
}

static void count_values(const iso_level *level, const iso_volume *volume, double first, double width, size_t bins[BIN_COUNT])
{
    enum { BLOCK = 1024 };
    const size_t voxels = iso_geometry_voxel_count(&level->geometry);
    float values[BLOCK];
    for (size_t at = 0; at < voxels; at += BLOCK) {
        const size_t n = voxels - at < BLOCK ? voxels - at : BLOCK;
        iso_level_file_scalars(level, volume, at, n, values);
        for (size_t i = 0; i < n; ++i)
            ++bins[(size_t)within(((double)values[i] - first) / width, BIN_COUNT - 1)];
    }
}

/* Chooses the background: from the hidden range with most voxels, as far as possible from visible values; the least
 * value if all are visible. */
static float choose_background(const shown_test *t, const iso_level *level, const iso_volume *volume)
{
    const double width = (level->max - level->min) / BIN_COUNT;
    size_t bins[BIN_COUNT] = {0}, most = 0;
    double value = level->min;
    if (!(width > 0))
        return (float)value;
    count_values(level, volume, level->min, width, bins);
    for (size_t start = 0; start < BIN_COUNT; ++start) {
        size_t end = start, inside = 0;
        while (end < BIN_COUNT &&
               !shows(t, (float)(level->min + (double)start * width), (float)(level->min + (double)(end + 1) * width)))
            inside += bins[end++];
        if (end > start && inside >= most) {
            most = inside;
            value = start == 0         ? level->min
                    : end == BIN_COUNT ? level->max
                                       : level->min + 0.5 * (double)(start + end) * width;
        }
        start = end > start ? end - 1 : start;
    }
    const float exact = (float)value, rounded = to_half(exact);
    return joined(t, exact, rounded) ? rounded : exact;
}

static iso_status find_background(const shown_test *t, const iso_level *level, const iso_volume *volume,
                                  const iso_vdb_shown *shown, float *background, iso_error *err)
{
    *background = shown->has_background         ? (float)shown->background
                  : level->geometry.has_no_data ? iso_level_stand_in(level, ISO_STAND_IN_FILE)
                                                : choose_background(t, level, volume);
    if (!t->plain && shown->has_background && shows(t, *background, *background))
        return iso_fail(err, ISO_E_RANGE, "background %g is visible under the transfer function; choose another",
                        shown->background);
    return ISO_OK;
}

/* ---- cells and voxels ------------------------------------------------------------ */

/* Planes of the level with its rim are counted from 0; cell i lies between voxels i and i + 1. */
typedef struct marker {
    iso_vdb_activity *activity;
    const iso_level *level;
    const iso_volume *volume; /* its scalars if it has none */
    const shown_test *test;
    size_t pad;
} marker;

/* Buffers of one thread. */
typedef struct planes {
    float *row[2];             /* two rows of voxels, with the rim */
    float *least[2], *most[2]; /* over squares of four voxels, for this plane of voxels and the next */
    uint8_t *seen[2];          /* a byte per cell, for the layers of cells before and after this plane of voxels */
} planes;

static size_t clamped(size_t i, size_t pad, size_t size)
{
    const size_t inner = i > pad ? i - pad : 0;
    return inner < size ? inner : size - 1;
}

static void read_voxels(const marker *m, size_t y, size_t z, float *out)
{
    const size_t *n = m->level->geometry.size;
    float *row = out + m->pad;
    const size_t first = n[0] * (clamped(y, m->pad, n[1]) + n[1] * clamped(z, m->pad, n[2]));
    iso_level_file_scalars(m->level, m->volume, first, n[0], row);
    for (size_t x = 0; x < m->pad; ++x) {
        out[x] = row[0];
        row[n[0] + x] = row[n[0] - 1];
    }
}

/* Computes least and greatest value of each square of four voxels of plane z. Cells along x and y: one fewer than
 * voxels. */
static void take_plane(const marker *m, planes *p, size_t z, float *least, float *most)
{
    const size_t nx = m->activity->size[0], ny = m->activity->size[1];
    read_voxels(m, 0, z, p->row[0]);
    for (size_t y = 0; y + 1 < ny; ++y) {
        const float *a = p->row[y & 1], *b = p->row[(y + 1) & 1];
        float *lo = least + y * (nx - 1), *hi = most + y * (nx - 1);
        read_voxels(m, y + 1, z, p->row[(y + 1) & 1]);
        for (size_t x = 0; x + 1 < nx; ++x) {
            const float min_a = a[x] < a[x + 1] ? a[x] : a[x + 1], max_a = a[x] < a[x + 1] ? a[x + 1] : a[x];
            const float min_b = b[x] < b[x + 1] ? b[x] : b[x + 1], max_b = b[x] < b[x + 1] ? b[x + 1] : b[x];
            lo[x] = min_a < min_b ? min_a : min_b;
            hi[x] = max_a < max_b ? max_b : max_a;
        }
    }
}

/* Marks the seen cells of the layer between the two planes of least and most. */
static void see_layer(const marker *m, planes *p, uint8_t *seen)
{
    const size_t cells = (m->activity->size[0] - 1) * (m->activity->size[1] - 1);
    for (size_t i = 0; i < cells; ++i) {
        const float lo = p->least[0][i] < p->least[1][i] ? p->least[0][i] : p->least[1][i];
        const float hi = p->most[0][i] < p->most[1][i] ? p->most[1][i] : p->most[0][i];
        seen[i] = shows(m->test, lo, hi);
    }
}

/* Marks the layer of cells after plane z, from the planes z and z + 1 of voxels. After the last plane there are no
 * cells. */
static void next_layer(const marker *m, planes *p, size_t z, uint8_t *seen)
{
    const size_t *n = m->activity->size;
    if (z + 1 >= n[2]) {
        memset(seen, 0, (n[0] - 1) * (n[1] - 1));
        return;
    }
    take_plane(m, p, z, p->least[0], p->most[0]);
    take_plane(m, p, z + 1, p->least[1], p->most[1]);
    see_layer(m, p, seen);
}

/* Does the work of next_layer(), with plane z known from the layer before. */
static void following_layer(const marker *m, planes *p, size_t z, uint8_t *seen)
{
    float *least = p->least[0], *most = p->most[0];
    if (z + 1 >= m->activity->size[2]) {
        next_layer(m, p, z, seen);
        return;
    }
    p->least[0] = p->least[1], p->most[0] = p->most[1];
    p->least[1] = least, p->most[1] = most;
    take_plane(m, p, z + 1, p->least[1], p->most[1]);
    see_layer(m, p, seen);
}

/* True if a cell of the layer that touches the voxel is seen. */
static inline uint8_t touched(const uint8_t *seen, size_t x, size_t y, const size_t size[3])
{
    const size_t nx = size[0] - 1, ny = size[1] - 1;
    uint8_t any = 0;
    for (size_t cy = y > 0 ? y - 1 : 0; cy <= y && cy < ny; ++cy) {
        const uint8_t *row = seen + cy * nx;
        any |= (x < nx ? row[x] : 0) | (x > 0 ? row[x - 1] : 0);
    }
    return any;
}

static void mark_plane(const marker *m, planes *p, size_t z, size_t counts[2])
{
    iso_vdb_activity *a = m->activity;
    for (size_t y = 0; y < a->size[1]; ++y) {
        uint8_t *kept = a->kept + (z * a->size[1] + y) * a->row_bytes;
        uint8_t *lit = a->lit + (z * a->size[1] + y) * a->row_bytes;
        read_voxels(m, y, z, p->row[0]);
        for (size_t x = 0; x < a->size[0]; ++x) {
            const bool is_lit = touched(p->seen[0], x, y, a->size) | touched(p->seen[1], x, y, a->size);
            const bool is_kept = is_lit || (!m->test->plain && !joined(m->test, p->row[0][x], a->background));
            lit[x / 8] = (uint8_t)(lit[x / 8] | is_lit << (x & 7));
            kept[x / 8] = (uint8_t)(kept[x / 8] | is_kept << (x & 7));
            counts[0] += is_kept;
            counts[1] += is_lit;
        }
    }
}

static bool planes_create(planes *p, const size_t size[3])
{
    const size_t cells = size[0] * size[1];
    float *floats = malloc((2 * size[0] + 4 * cells) * sizeof *floats);
    uint8_t *bytes = calloc(2, cells);
    *p = (planes){.seen = {bytes, bytes ? bytes + cells : NULL}};
    if (!floats || !bytes) {
        free(floats);
        free(bytes);
        return false;
    }
    p->row[0] = floats;
    p->row[1] = floats + size[0];
    for (int i = 0; i < 2; ++i) {
        p->least[i] = floats + 2 * size[0] + (size_t)(2 * i) * cells;
        p->most[i] = p->least[i] + cells;
    }
    return true;
}

enum { CHUNK = 32 }; /* consecutive planes per thread */

/* Returns false if out of memory. */
static bool mark_chunk(const marker *m, size_t begin, size_t end, size_t counts[2])
{
    planes p;
    if (!planes_create(&p, m->activity->size))
        return false;
    FREED float *floats = p.row[0];
    FREED uint8_t *bytes = p.seen[0];
    if (begin > 0)
        next_layer(m, &p, begin - 1, p.seen[1]);
    for (size_t z = begin; z < end; ++z) {
        uint8_t *before = p.seen[0];
        p.seen[0] = p.seen[1];
        p.seen[1] = before;
        if (z == 0)
            next_layer(m, &p, z, p.seen[1]);
        else
            following_layer(m, &p, z, p.seen[1]);
        mark_plane(m, &p, z, counts);
    }
    return true;
}

/* Keeps two opposite corners of the level active, so that the grid's box equals the level's. Cycles without NanoVDB
 * fades a grid to 0 beyond its active voxels, and 0 may be visible. */
static void keep_corners(iso_vdb_activity *a)
{
    for (int end = 0; end < 2; ++end) {
        size_t at[3];
        for (int i = 0; i < 3; ++i)
            at[i] = end ? a->size[i] - 1 - a->skip : a->skip;
        uint8_t *byte = a->kept + (at[2] * a->size[1] + at[1]) * a->row_bytes + at[0] / 8;
        a->kept_count += !(*byte >> (at[0] & 7) & 1);
        *byte = (uint8_t)(*byte | 1 << (at[0] & 7));
    }
}

static bool mark_all(const marker *m, int threads)
{
    const size_t depth = m->activity->size[2];
    size_t kept = 0, lit = 0;
    bool good = true;
#pragma omp parallel for schedule(dynamic) num_threads(iso_threads(threads)) reduction(+ : kept, lit)                  \
    reduction(&& : good)
    for (size_t begin = 0; begin < depth; begin += CHUNK) {
        size_t counts[2] = {0};
        good = mark_chunk(m, begin, begin + CHUNK < depth ? begin + CHUNK : depth, counts) && good;
        kept += counts[0];
        lit += counts[1];
    }
    m->activity->kept_count = kept;
    m->activity->lit_count = lit;
    return good;
}

iso_status iso_vdb_activity_create(iso_vdb_activity *a, const iso_level *level, const iso_volume *volume,
                                   const iso_vdb_shown *shown, size_t pad, int threads, iso_error *err)
{
    OWNED(shown_test) test = {0};
    *a = (iso_vdb_activity){0};
    NEED(shown_test_create(&test, shown, err));
    NEED(find_background(&test, level, volume, shown, &a->background, err));
    /* At least one voxel of rim is marked, to include cells that reach beyond the volume's edge. */
    const size_t rim = pad > 0 ? pad : 1;
    a->skip = rim - pad;
    for (int i = 0; i < 3; ++i)
        a->size[i] = level->geometry.size[i] + 2 * rim;
    a->row_bytes = (a->size[0] + 7) / 8;
    const size_t bytes = a->row_bytes * a->size[1] * a->size[2];
    a->kept = calloc(bytes, 1);
    a->lit = calloc(bytes, 1);
    const marker m = {a, level, volume, &test, rim};
    if (!a->kept || !a->lit || !mark_all(&m, threads)) {
        iso_vdb_activity_destroy(a);
        return iso_fail(err, ISO_E_MEMORY, "sparse grids: no memory for %zu bytes of marks", 2 * bytes);
    } else {
        keep_corners(a);
    }
    return ISO_OK;
}

void iso_vdb_activity_destroy(iso_vdb_activity *a)
{
    if (!a)
        return;
    free(a->kept);
    free(a->lit);
    *a = (iso_vdb_activity){0};
}

/* SPDX-License-Identifier: MIT */
#include "encode/nearest_table.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "encode/decode_double.h"
#include "encode/region48.h"
#include "encode/simd.h"

enum { CELLS = 640, CANDIDATES = 256 };
/* Of an entry's place: 3e-6 degrees, thousands of them in the distance of neighbors. Entries reach five cells. */
#define STEP (5.0 / CELLS / 32767)

/* ---- what codes decode to ---- */

typedef struct code_point {
    double y, z;
    uint8_t a, b, c;
} code_point;

typedef struct point_grid {
    size_t count;
    code_point *points; /* by cell; the longest first in each */
    uint32_t *first;    /* CELLS^2 + 1 */
} point_grid;

static size_t cell_along(double t)
{
    const double at = t * CELLS;
    return at < CELLS ? (size_t)at : CELLS - 1;
}

static size_t cell_of(double y, double z)
{
    return cell_along(z) * CELLS + cell_along(y);
}

/* All codes of one region; a third of a vector decodes to the same direction and is left out. */
static size_t list_points(int decoder, code_point *points)
{
    size_t count = 0;
    for (int a = 255; a > 85; a -= 2)
        for (int b = 1; b <= a; b += 2)
            for (int c = 1; c <= b; c += 2) {
                const iso_vec3 d = iso_decode(decoder, iso_v3(a / 255.0, b / 255.0, c / 255.0));
                points[count++] = (code_point){d.y / d.x, d.z / d.x, (uint8_t)a, (uint8_t)b, (uint8_t)c};
            }
    return count;
}

static iso_status make_grid(int decoder, point_grid *g, iso_error *err)
{
    const size_t most = 128 * 129 * 130 / 6;
    code_point *list = malloc(most * sizeof *list);
    *g = (point_grid){.points = malloc(most * sizeof *list), .first = calloc(CELLS * CELLS + 2, sizeof *g->first)};
    if (!list || !g->points || !g->first) {
        free(list);
        return iso_fail(err, ISO_E_MEMORY, "no memory for %zu codes", most);
    }
    g->count = list_points(decoder, list);
    for (size_t i = 0; i < g->count; ++i)
        ++g->first[cell_of(list[i].y, list[i].z) + 2];
    for (size_t i = 2; i < CELLS * CELLS + 2; ++i)
        g->first[i] += g->first[i - 1];
    for (size_t i = 0; i < g->count; ++i)
        g->points[g->first[cell_of(list[i].y, list[i].z) + 1]++] = list[i];
    free(list);
    return ISO_OK;
}

/* ---- what a cell needs ---- */

/* The squared sine of the angle between (1, y, z) and the code's direction. */
static double sine_square(const code_point *p, double y, double z)
{
    const double dy = p->y - y, dz = p->z - z, square = 1 + y * y + z * z, along = dy * y + dz * z;
    return (dy * dy + dz * dz - along * along / square) / (1 + p->y * p->y + p->z * p->z);
}

typedef struct candidate {
    const code_point *point;
    double corner[4]; /* squared sines at the cell's corners */
    double farthest;
} candidate;

typedef struct cell_box {
    double y[2], z[2];
    double farthest; /* the least of the candidates' farthest corners: nothing farther is ever the nearest */
    candidate found[CANDIDATES];
    size_t count;
} cell_box;

static void offer(cell_box *box, const code_point *p)
{
    /* From the middle to any place of the cell it is half a diagonal at most. */
    const double half = 0.71 / CELLS,
                 middle = sqrt(sine_square(p, 0.5 * (box->y[0] + box->y[1]), 0.5 * (box->z[0] + box->z[1])));
    if (middle - half > sqrt(box->farthest) || box->count == CANDIDATES)
        return;
    candidate c = {.point = p};
    for (int i = 0; i < 4; ++i) {
        c.corner[i] = sine_square(p, box->y[i & 1], box->z[i >> 1]);
        c.farthest = fmax(c.farthest, c.corner[i]);
    }
    box->farthest = fmin(box->farthest, c.farthest);
    box->found[box->count++] = c;
}

/* Of points on the same ray the one that comes first is enough. */
static bool dominates(const candidate *a, const candidate *b, bool comes_first)
{
    bool less = comes_first;
    for (int i = 0; i < 4; ++i) {
        if (a->corner[i] > b->corner[i])
            return false;
        less |= a->corner[i] < b->corner[i];
    }
    return less;
}

static void prune(cell_box *box)
{
    size_t kept = 0;
    bool dead[CANDIDATES] = {false};
    for (size_t i = 0; i < box->count; ++i)
        for (size_t j = 0; j < box->count && !dead[i]; ++j)
            dead[i] = j != i && dominates(&box->found[j], &box->found[i], j < i);
    for (size_t i = 0; i < box->count; ++i)
        if (!dead[i])
            box->found[kept++] = box->found[i];
    box->count = kept;
}

static void scan(cell_box *box, const point_grid *g, long y, long z)
{
    if (y < 0 || y >= CELLS || z < 0 || z >= CELLS)
        return;
    const size_t cell = (size_t)z * CELLS + (size_t)y;
    for (uint32_t i = g->first[cell]; i < g->first[cell + 1]; ++i)
        offer(box, &g->points[i]);
}

/* Rings of cells round cell (y, z), until what lies behind them is farther than what was found: a way of t in the plane
 * turns a direction by at least t / (1 + r^2), r the farthest from the axis on the way. */
static void gather(cell_box *box, const point_grid *g, long y, long z)
{
    *box = (cell_box){.y = {(double)y / CELLS, (double)(y + 1) / CELLS},
                      .z = {(double)z / CELLS, (double)(z + 1) / CELLS},
                      .farthest = INFINITY};
    for (long ring = 0; ring < CELLS; ++ring) {
        for (long at = -ring; at <= ring; ++at) {
            scan(box, g, y + at, z - ring);
            if (ring > 0)
                scan(box, g, y + at, z + ring);
        }
        for (long at = 1 - ring; at < ring; ++at) {
            scan(box, g, y - ring, z + at);
            scan(box, g, y + ring, z + at);
        }
        const double way = (double)ring / CELLS, far_y = box->y[1] + way, far_z = box->z[1] + way;
        if (sin(way / (1 + far_y * far_y + far_z * far_z)) > sqrt(box->farthest))
            break;
    }
    prune(box);
}

/* ---- the table ---- */

/* A place that is never the nearest, to fill a block up. */
enum { FAR = 32767 };

static iso_status append(iso_nearest_table *t, const cell_box *box, size_t *count, size_t *room, iso_error *err)
{
    const size_t more = (box->count + 7) / 8;
    if (*count + more > *room) {
        *room = 2 * (*count + more);
        iso_nearest_block *blocks = aligned_alloc(sizeof *blocks, *room * sizeof *blocks);
        if (!blocks)
            return iso_fail(err, ISO_E_MEMORY, "no memory for %zu blocks of a table", *room);
        if (t->blocks)
            memcpy(blocks, t->blocks, *count * sizeof *blocks);
        free(t->blocks);
        t->blocks = blocks;
    }
    for (size_t i = 0; i < 8 * more; ++i) {
        iso_nearest_block *block = &t->blocks[*count + i / 8];
        const code_point *p = box->found[i < box->count ? i : 0].point;
        const double y = p->y - 0.5 * (box->y[0] + box->y[1]), z = p->z - 0.5 * (box->z[0] + box->z[1]);
        if (!(fabs(y) < FAR * STEP && fabs(z) < FAR * STEP))
            return iso_fail(err, ISO_E_RANGE,
                            "a code is needed %g cells from it: the decoder's holes are too large for the table",
                            fmax(fabs(y), fabs(z)) * CELLS);
        block->y[i % 8] = i < box->count ? (int16_t)lrint(y / STEP) : FAR;
        block->z[i % 8] = i < box->count ? (int16_t)lrint(z / STEP) : FAR;
        block->size[0][i % 8] = p->a, block->size[1][i % 8] = p->b, block->size[2][i % 8] = p->c;
    }
    *count += more;
    return ISO_OK;
}

iso_status iso_nearest_table_create(int decoder, iso_nearest_table *table, iso_error *err)
{
    point_grid grid;
    cell_box *box = malloc(sizeof *box);
    size_t count = 0, room = 0;
    *table = (iso_nearest_table){.first = malloc((CELLS * CELLS + 1) * sizeof *table->first)};
    iso_status status = make_grid(decoder, &grid, err);
    if (status == ISO_OK && (!box || !table->first))
        status = iso_fail(err, ISO_E_MEMORY, "no memory for a table of %d cells", CELLS * CELLS);
    for (long cell = 0; cell < CELLS * CELLS && status == ISO_OK; ++cell) {
        const long y = cell % CELLS, z = cell / CELLS;
        table->first[cell] = (uint32_t)count;
        if (z > y)
            continue; /* outside the region */
        gather(box, &grid, y, z);
        status = append(table, box, &count, &room, err);
    }
    free(box);
    free(grid.points);
    free(grid.first);
    if (status != ISO_OK)
        iso_nearest_table_destroy(table);
    else
        table->first[CELLS * CELLS] = (uint32_t)count;
    return status;
}

void iso_nearest_table_destroy(iso_nearest_table *table)
{
    if (!table)
        return;
    free(table->first);
    free(table->blocks);
    *table = (iso_nearest_table){0};
}

/* ---- looking up ---- */

/* Directions in flight: while one waits for its cell from memory the others are looked up. */
enum { IN_FLIGHT = 64 };

typedef struct query {
    double y, z;
    uint32_t cell_y, cell_z, first, last;
    uint8_t rank[3]; /* of x, y and z among |components|, 0 the largest */
} query;

ISO_INLINE query ask(const float *v)
{
    const float x = fabsf(v[0]), y = fabsf(v[1]), z = fabsf(v[2]);
    query q = {.rank = {(uint8_t)((y > x) + (z > x)), (uint8_t)((x >= y) + (z > y)), (uint8_t)((x >= z) + (y >= z))}};
    double sorted[3];
    sorted[q.rank[0]] = (double)x, sorted[q.rank[1]] = (double)y, sorted[q.rank[2]] = (double)z;
    const double per_high = 1 / (sorted[0] > 0 ? sorted[0] : 1);
    q.y = sorted[1] * per_high;
    q.z = sorted[2] * per_high;
    q.cell_y = (uint32_t)cell_along(q.y);
    q.cell_z = (uint32_t)cell_along(q.z);
    return q;
}

/* A code: a lane of a block. */
typedef struct found {
    const iso_nearest_block *block;
    size_t lane;
} found;

ISO_INLINE v8f places(const int16_t *steps, double from)
{
    typedef int16_t v8h __attribute__((vector_size(16)));
    v8h whole;
    memcpy(&whole, steps, sizeof whole);
    return __builtin_convertvector(whole, v8f) * (float)STEP - (float)from;
}

ISO_INLINE v8i v8_least(v8i a, v8i b)
{
    v8i less = a < b;
    return (a & less) | (b & ~less);
}

/* The least of eight, none of them negative. */
ISO_INLINE int32_t least_of(v8i k)
{
    k = v8_least(k, __builtin_shufflevector(k, k, 4, 5, 6, 7, 0, 1, 2, 3));
    k = v8_least(k, __builtin_shufflevector(k, k, 2, 3, 0, 1, 6, 7, 4, 5));
    k = v8_least(k, __builtin_shufflevector(k, k, 1, 0, 3, 2, 5, 4, 7, 6));
    return k[0];
}

/* sine_square() of eight, with what all candidates share left out: |p|^2 = |q|^2 + 2 d.q + |d|^2. Floats that are
 * not negative are ordered as their bits are; the last three make room for the lane. */
ISO_INLINE found find(const iso_nearest_table *t, const query *q)
{
    const double cell_y = ((double)q->cell_y + 0.5) / CELLS, cell_z = ((double)q->cell_z + 0.5) / CELLS;
    const float y = (float)q->y, z = (float)q->z, square = 1 + y * y + z * z, per_square = 1 / square;
    const iso_nearest_block *b = &t->blocks[q->first], *end = &t->blocks[q->last];
    found best = {b, 0};
    int32_t least = INT32_MAX;
    do {
        const v8f dy = places(b->y, q->y - cell_y), dz = places(b->z, q->z - cell_z);
        const v8f along = dy * y + dz * z, way = dy * dy + dz * dz, across = way - along * along * per_square;
        const v8f distance = v8_max(across, v8_set(0)) / (square + 2.0f * along + way);
        const int32_t key = least_of(((v8i)distance & ~7) | (v8i){0, 1, 2, 3, 4, 5, 6, 7});
        if (key < least) {
            least = key;
            best = (found){b, (size_t)(key & 7)};
        }
    } while (++b < end);
    return best;
}

ISO_INLINE void answer(const query *q, found e, const float *v, uint8_t *bytes)
{
    for (int a = 0; a < 3; ++a) {
        const int size = e.block->size[q->rank[a]][e.lane];
        bytes[a] = (uint8_t)((v[a] < 0 ? 255 - size : 255 + size) / 2);
    }
}

ISO_INLINE void encode(const iso_nearest_table *table, const float *restrict directions, uint8_t *restrict bytes,
                       size_t count)
{
    query q[IN_FLIGHT];
    for (size_t i = 0; i < count; ++i) {
        q[i] = ask(directions + 3 * i);
        __builtin_prefetch(&table->first[q[i].cell_z * CELLS + q[i].cell_y]);
    }
    for (size_t i = 0; i < count; ++i) {
        const uint32_t *first = &table->first[q[i].cell_z * CELLS + q[i].cell_y];
        q[i].first = first[0], q[i].last = first[1];
        __builtin_prefetch(&table->blocks[q[i].first]);
    }
    for (size_t i = 0; i < count; ++i) {
        const float *v = directions + 3 * i;
        if (v[0] != 0 || v[1] != 0 || v[2] != 0)
            answer(&q[i], find(table, &q[i]), v, bytes + 3 * i);
        else
            bytes[3 * i] = bytes[3 * i + 1] = bytes[3 * i + 2] = 128;
    }
}

__attribute__((target("avx2"))) static void encode_avx2(const iso_nearest_table *table,
                                                        const float *restrict directions, uint8_t *restrict bytes,
                                                        size_t count)
{
    encode(table, directions, bytes, count);
}

static void encode_baseline(const iso_nearest_table *table, const float *restrict directions, uint8_t *restrict bytes,
                            size_t count)
{
    encode(table, directions, bytes, count);
}

void iso_nearest_encode(const iso_nearest_table *table, const float *restrict directions, uint8_t *restrict bytes,
                        size_t count)
{
    for (size_t start = 0; start < count; start += IN_FLIGHT) {
        const size_t n = count - start < IN_FLIGHT ? count - start : IN_FLIGHT;
        if (__builtin_cpu_supports("avx2"))
            encode_avx2(table, directions + 3 * start, bytes + 3 * start, n);
        else
            encode_baseline(table, directions + 3 * start, bytes + 3 * start, n);
    }
}

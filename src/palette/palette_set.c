/* SPDX-License-Identifier: MIT */
#include <math.h>
#include <omp.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "palette/palette.h"
#include "palette/palette_cube.h"

static iso_status set_allocate(iso_direction_set *set, size_t count, iso_error *err)
{
    *set = (iso_direction_set){.count = count};
    set->xyz = calloc(3 * count + 1, sizeof *set->xyz);
    set->length = calloc(count + 1, sizeof *set->length);
    set->weight = calloc(count + 1, sizeof *set->weight);
    if (set->xyz && set->length && set->weight)
        return ISO_OK;
    iso_direction_set_destroy(set);
    return iso_fail(err, ISO_E_MEMORY, "palette: no memory for %zu directions", count);
}

void iso_direction_set_destroy(iso_direction_set *set)
{
    if (!set)
        return;
    free(set->xyz);
    free(set->length);
    free(set->weight);
    *set = (iso_direction_set){0};
}

typedef struct member {
    float d[3];
    double weight;
} member;

static int compare_members(const void *a, const void *b)
{
    const member *p = a, *q = b;
    for (int c = 0; c < 3; ++c)
        if (p->d[c] != q->d[c])
            return p->d[c] < q->d[c] ? -1 : 1;
    /* Equal directions add their weights in ascending order, so that the order of the input does not matter. */
    return (p->weight > q->weight) - (p->weight < q->weight);
}

/* Computes the unit vector in float, through double against overflow and underflow. False if there is none. */
static int to_unit(const float v[3], float d[3])
{
    double x = (double)v[0], y = (double)v[1], z = (double)v[2];
    double n = sqrt(x * x + y * y + z * z);
    if (!(n > 0) || !isfinite(n))
        return 0;
    d[0] = (float)(x / n) + 0.0f; /* no negative zero: it compares equal but prints differently */
    d[1] = (float)(y / n) + 0.0f;
    d[2] = (float)(z / n) + 0.0f;
    return 1;
}

iso_status iso_direction_set_create(iso_direction_set *set, const float *vectors, const double *weights, size_t count,
                                    iso_error *err)
{
    *set = (iso_direction_set){0};
    FREED member *members = malloc((count + 1) * sizeof *members);
    NEED_MEMORY(members, err, "palette: no memory for %zu directions", count);
    size_t used = 0, distinct = 0;
    double undefined = 0;
    for (size_t i = 0; i < count; ++i) {
        double w = weights ? weights[i] : 1;
        if (!(w >= 0) || !isfinite(w))
            return iso_fail(err, ISO_E_RANGE,
                            "palette: the weight of direction %zu is %g, must be finite and not negative", i, w);
        if (!to_unit(vectors + 3 * i, members[used].d))
            undefined += w;
        else if (w > 0)
            members[used++].weight = w;
    }
    qsort(members, used, sizeof *members, compare_members);
    for (size_t i = 0; i < used; ++i)
        distinct += i == 0 || memcmp(members[i].d, members[i - 1].d, sizeof members[i].d) != 0;
    NEED(set_allocate(set, distinct, err));
    size_t at = 0;
    for (size_t i = 0; i < used; ++i) {
        if (i > 0 && memcmp(members[i].d, members[i - 1].d, sizeof members[i].d) != 0)
            ++at;
        memcpy(set->xyz + 3 * at, members[i].d, sizeof members[i].d);
        set->weight[at] += members[i].weight;
        set->length[at] = 1;
    }
    set->undefined_weight = undefined;
    return ISO_OK;
}

/* Stores one bundle with the members' sum and weight; n is the length of the sum. */
static void put_bundle(iso_direction_set *set, size_t at, const double sum[3], double weight)
{
    double n = sqrt(sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]);
    for (size_t c = 0; c < 3; ++c)
        set->xyz[3 * at + c] = (float)(sum[c] / n);
    set->length[at] = (float)fmin(1, n / weight);
    set->weight[at] = weight;
}

typedef struct cell_sum {
    double sum[3], weight;
} cell_sum;

iso_status iso_direction_set_coarsen(const iso_direction_set *set, int cells, iso_direction_set *out, iso_error *err)
{
    size_t bins = (size_t)6 * (size_t)cells * (size_t)cells, count = 0, at = 0;
    *out = (iso_direction_set){0};
    FREED cell_sum *sums = calloc(bins, sizeof *sums);
    NEED_MEMORY(sums, err, "palette: no memory for %zu bins", bins);
    for (size_t i = 0; i < set->count; ++i) {
        const float *u = set->xyz + 3 * i;
        iso_cube_point p;
        if (!iso_cube_project(u, &p))
            continue; /* impossible: bundles have unit directions */
        cell_sum *cell = &sums[iso_cube_cell(&p, cells)];
        count += cell->weight == 0;
        cell->weight += set->weight[i];
        for (int c = 0; c < 3; ++c)
            cell->sum[c] += set->weight[i] * (double)set->length[i] * (double)u[c];
    }
    NEED(set_allocate(out, count, err));
    for (size_t bin = 0; bin < bins; ++bin)
        if (sums[bin].weight > 0)
            put_bundle(out, at++, sums[bin].sum, sums[bin].weight);
    out->undefined_weight = set->undefined_weight;
    return ISO_OK;
}

/* ---- pool -------------------------------------------------------------------- */

#define POOL_BINS ((size_t)6 * ISO_POOL_CELLS * ISO_POOL_CELLS)
/* A weight of 1 in fixed point: the precision of float; 2^39 voxels do not overflow. */
#define POOL_UNIT 16777216.0f

typedef struct pool_bin {
    int64_t sum[3], weight;
} pool_bin;

struct iso_direction_pool {
    int threads;
    pool_bin *bins;     /* POOL_BINS per thread */
    int64_t *undefined; /* one per thread, 8 apart to avoid shared cache lines */
};

iso_status iso_direction_pool_create(iso_direction_pool **pool, int threads, iso_error *err)
{
    iso_direction_pool *p = calloc(1, sizeof *p);
    *pool = NULL;
    if (p) {
        p->threads = iso_threads(threads);
        p->bins = calloc(POOL_BINS * (size_t)p->threads, sizeof *p->bins);
        p->undefined = calloc(8 * (size_t)p->threads, sizeof *p->undefined);
    }
    if (!p || !p->bins || !p->undefined) {
        iso_direction_pool_destroy(p);
        return iso_fail(err, ISO_E_MEMORY, "palette: no memory for %zu bins per thread", POOL_BINS);
    }
    *pool = p;
    return ISO_OK;
}

void iso_direction_pool_destroy(iso_direction_pool *pool)
{
    if (!pool)
        return;
    free(pool->bins);
    free(pool->undefined);
    free(pool);
}

static void add_range(pool_bin *restrict bins, int64_t *restrict undefined, const float *restrict vectors,
                      const float *restrict weights, size_t begin, size_t end)
{
    for (size_t i = begin; i < end; ++i) {
        const float *v = vectors + 3 * i;
        float w = weights ? weights[i] : 1;
        w = w > 0 ? (w < 1 ? w : 1) * POOL_UNIT : 0;
        iso_cube_point p;
        if (!iso_cube_project(v, &p)) {
            *undefined += (int64_t)w;
            continue;
        }
        pool_bin *bin = &bins[iso_cube_cell(&p, ISO_POOL_CELLS)];
        /* The unit vector in the face's own axes: no length overflows or underflows. */
        float scale = w / sqrtf(1 + p.u * p.u + p.v * p.v);
        bin->weight += (int64_t)w;
        bin->sum[0] += lrintf(scale);
        bin->sum[1] += lrintf(p.u * scale);
        bin->sum[2] += lrintf(p.v * scale);
    }
}

void iso_direction_pool_add(iso_direction_pool *pool, const float *restrict vectors, const float *restrict weights,
                            size_t count)
{
#pragma omp parallel num_threads(pool->threads)
    {
        size_t part = (size_t)omp_get_thread_num(), parts = (size_t)omp_get_num_threads();
        add_range(pool->bins + POOL_BINS * part, pool->undefined + 8 * part, vectors, weights, count * part / parts,
                  count * (part + 1) / parts);
    }
}

/* Sums one bin over the threads; integers, so that the order does not matter. */
static pool_bin merged_bin(const iso_direction_pool *pool, size_t bin)
{
    pool_bin all = {{0, 0, 0}, 0};
    for (int t = 0; t < pool->threads; ++t) {
        const pool_bin *part = &pool->bins[POOL_BINS * (size_t)t + bin];
        for (int c = 0; c < 3; ++c)
            all.sum[c] += part->sum[c];
        all.weight += part->weight;
    }
    return all;
}

iso_status iso_direction_pool_finish(const iso_direction_pool *pool, iso_direction_set *set, iso_error *err)
{
    size_t count = 0, at = 0;
    for (size_t bin = 0; bin < POOL_BINS; ++bin)
        count += merged_bin(pool, bin).weight > 0;
    NEED(set_allocate(set, count, err));
    for (size_t bin = 0; bin < POOL_BINS; ++bin) {
        pool_bin all = merged_bin(pool, bin);
        if (all.weight <= 0)
            continue;
        int face = (int)(bin / (ISO_POOL_CELLS * ISO_POOL_CELLS)), axis = face / 2;
        double sum[3];
        sum[axis] = (double)(face % 2 ? -all.sum[0] : all.sum[0]) / (double)POOL_UNIT;
        sum[(axis + 1) % 3] = (double)all.sum[1] / (double)POOL_UNIT;
        sum[(axis + 2) % 3] = (double)all.sum[2] / (double)POOL_UNIT;
        put_bundle(set, at++, sum, (double)all.weight / (double)POOL_UNIT);
    }
    for (int t = 0; t < pool->threads; ++t)
        set->undefined_weight += (double)pool->undefined[8 * t] / (double)POOL_UNIT;
    return ISO_OK;
}

/* SPDX-License-Identifier: MIT */
/* cascade_spline.c - least-squares levels (spline_kernel.h), each from level 0, plane by plane.
 *
 * A fine row is added to the coarse rows that it has a part in, these are reduced along x, and added to the coarse
 * planes that have a part in the fine plane. A coarse plane whose last fine plane has come is solved along x and y. Along
 * z the solution reaches over the whole volume, but decays: blocks of SPLINE_BLOCK planes, by their index, are
 * solved with SPLINE_APRON planes on either side, so that the result depends on no slab:
 *
 *     planes       . . . . . . . . . . . . | o o o o o o o o | . . . . . . . . . . . .
 *                  apron, 12                 block, 8          apron, 12
 *
 * What is neglected is below 1e-6 of how much the values at the apron's end differ from their neighbors. */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "pyramid/cascade_kernel.h"
#include "pyramid/spline_kernel.h"

enum { SPLINE_BLOCK = 8, SPLINE_APRON = 12, SPLINE_WINDOW = SPLINE_BLOCK + 2 * SPLINE_APRON };
/* Fine planes between two meetings of the threads, and fine rows of a thread's task. */
enum { SPLINE_BATCH = 16, SPLINE_ROWS = 32 };

struct spline_level {
    iso_spline_axis axis[3];
    iso_spline_row *solve[2]; /* along x and y */
    size_t slot_count;        /* coarse planes that are kept: plane p in slot p % slot_count */
    float *slots;
    size_t tasks; /* of coarse rows */
};

/* ---- which planes ---- */

/* Coarse planes whose fine planes are all below z. */
static size_t summed_planes(const spline_level *s, size_t z)
{
    const iso_spline_axis *a = &s->axis[2];
    if (z == a->fine)
        return a->coarse;
    return z >= a->ratio / 2 ? (z - a->ratio / 2) / a->ratio : 0;
}

/* The blocks whose window is in these planes: as planes. */
static size_t solved_planes(const spline_level *s, size_t summed)
{
    if (summed == s->axis[2].coarse)
        return summed;
    return summed >= SPLINE_APRON ? (summed - SPLINE_APRON) / SPLINE_BLOCK * SPLINE_BLOCK : 0;
}

size_t iso_cascade_spline_complete(const iso_cascade *c, size_t level, size_t z)
{
    return level == 0 ? z : solved_planes(&c->spline[level], summed_planes(&c->spline[level], z));
}

size_t iso_cascade_spline_lag(void)
{
    return SPLINE_BLOCK + SPLINE_APRON + 3;
}

size_t iso_cascade_spline_from(const iso_cascade *c, size_t level, size_t complete)
{
    const spline_level *s = &c->spline[level];
    if (complete == s->axis[2].coarse)
        return s->axis[2].fine;
    return iso_spline_first(&s->axis[2], complete > SPLINE_APRON ? complete - SPLINE_APRON : 0);
}

/* ---- create, destroy ---- */

static size_t plane_floats(const spline_level *s)
{
    return s->axis[0].coarse * s->axis[1].coarse;
}

static size_t task_rows(const spline_level *s)
{
    return SPLINE_ROWS > s->axis[1].ratio ? SPLINE_ROWS / s->axis[1].ratio : 1;
}

static bool create_level(const iso_cascade *c, size_t k, spline_level *s)
{
    bool good = true;
    for (int a = 0; a < 3; ++a)
        s->axis[a] = (iso_spline_axis){c->size[0][a], c->size[k][a], (size_t)1 << k};
    for (int a = 0; a < 2; ++a) {
        s->solve[a] = malloc(s->axis[a].coarse * sizeof *s->solve[a]);
        good = good && s->solve[a];
        if (good)
            iso_spline_factorize(&s->axis[a], 0, s->axis[a].coarse, s->solve[a]);
    }
    const size_t most = SPLINE_WINDOW + (SPLINE_BATCH >> k) + 6;
    s->slot_count = s->axis[2].coarse < most ? s->axis[2].coarse : most;
    s->slots = calloc(s->slot_count * plane_floats(s), sizeof *s->slots);
    s->tasks = (s->axis[1].coarse + task_rows(s) - 1) / task_rows(s);
    return good && s->slots;
}

iso_status iso_cascade_spline_create(iso_cascade *c, iso_error *err)
{
    if (c->opt.scalar_filter != ISO_SCALAR_LEAST_SQUARES)
        return ISO_OK;
    c->spline = calloc(c->level_count, sizeof *c->spline);
    bool good = c->spline != NULL;
    for (size_t k = 1; k < c->level_count && good; ++k)
        good = create_level(c, k, &c->spline[k]);
    return good ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "pyramid: no memory for the planes of least-squares levels");
}

void iso_cascade_spline_destroy(iso_cascade *c)
{
    for (size_t k = 1; c->spline && k < c->level_count; ++k) {
        free(c->spline[k].solve[0]);
        free(c->spline[k].solve[1]);
        free(c->spline[k].slots);
    }
    free(c->spline);
}

size_t iso_cascade_spline_floats(const iso_cascade *c)
{
    size_t floats = 0;
    for (size_t k = 1; c->spline && k < c->level_count; ++k)
        floats += c->spline[k].slot_count * plane_floats(&c->spline[k]);
    return floats;
}

/* ---- sums ---- */

/* What one call of iso_cascade_spline_feed works with. */
typedef struct spline_run {
    iso_cascade *c;
    const iso_planes *in;
    const iso_cascade_out *out;
    float *memory;
    size_t per_thread;
} spline_run;

static float *slot(const spline_level *s, size_t plane)
{
    return s->slots + plane % s->slot_count * plane_floats(s);
}

static size_t largest(size_t a, size_t b)
{
    return a > b ? a : b;
}

static size_t scratch_floats(const iso_cascade *c)
{
    size_t most = 0;
    for (size_t k = 1; k < c->level_count; ++k) {
        const spline_level *s = &c->spline[k];
        const size_t padded = iso_spline_padded(&s->axis[0]);
        most = largest(most, c->size[0][0] + task_rows(s) * padded + 2 * padded + s->axis[0].coarse + 64);
        most = largest(most, (largest(SPLINE_WINDOW, ISO_SPLINE_LANES)) * s->axis[0].coarse + 64);
    }
    return (most + 15) / 16 * 16;
}

static float *thread_scratch(const spline_run *r)
{
    return r->memory + (size_t)iso_thread_index() * r->per_thread;
}

/* sum = weight * row, or is increased by it. */
static void weigh_row(float weight, const float *row, size_t n, float *sum, bool is_first)
{
    if (is_first)
        memset(sum, 0, n * sizeof *sum);
    iso_add_weighted_row(weight, row, n, sum);
}

/* Coarse rows j0 .. j1 - 1 of the fine plane z: sums along y, `padded` floats apart and ready to be reduced along x. */
static void sum_rows(const spline_run *r, const spline_level *s, size_t z, size_t j0, size_t j1, float *row,
                     float *sums)
{
    const iso_spline_axis *a = &s->axis[1];
    const size_t padded = iso_spline_padded(&s->axis[0]), n = s->axis[0].fine, offset = s->axis[0].ratio / 2;
    memset(sums, 0, (j1 - j0) * padded * sizeof *sums);
    for (size_t y = iso_spline_first(a, j0); y < iso_spline_end(a, j1 - 1); ++y) {
        double f;
        const size_t j = iso_spline_lookup(a, y, &f);
        iso_planes_row(r->in, y, z, row);
        if (j >= j0 && j < j1)
            iso_add_weighted_row((float)((1 - f) / (double)a->ratio), row, n, sums + (j - j0) * padded + offset);
        if (f > 0 && j + 1 >= j0 && j + 1 < j1)
            iso_add_weighted_row((float)(f / (double)a->ratio), row, n, sums + (j + 1 - j0) * padded + offset);
    }
}

/* The fine plane z into the coarse planes that it has a part in: the rows of one task. */
static void sum_plane(const spline_run *r, const spline_level *s, size_t task, size_t z)
{
    const size_t nx = s->axis[0].coarse, ny = s->axis[1].coarse, padded = iso_spline_padded(&s->axis[0]);
    const size_t j0 = task * task_rows(s), j1 = j0 + task_rows(s) < ny ? j0 + task_rows(s) : ny;
    const iso_spline_axis *a = &s->axis[2];
    float *row = thread_scratch(r), *sums = row + s->axis[0].fine, *halves = sums + task_rows(s) * padded,
          *reduced = halves + 2 * padded + 16;
    double f;
    const size_t p = iso_spline_lookup(a, z, &f);
    sum_rows(r, s, z, j0, j1, row, sums);
    for (size_t j = j0; j < j1; ++j) {
        iso_spline_reduce_row(&s->axis[0], sums + (j - j0) * padded, halves, reduced);
        weigh_row((float)((1 - f) / (double)a->ratio), reduced, nx, slot(s, p) + j * nx, z == iso_spline_first(a, p));
        if (f > 0)
            weigh_row((float)(f / (double)a->ratio), reduced, nx, slot(s, p + 1) + j * nx,
                      z == iso_spline_first(a, p + 1));
    }
}

static void sum_planes(const spline_run *r, size_t z0, size_t z1)
{
    const iso_cascade *c = r->c;
    size_t count = 0;
    for (size_t k = 1; k < c->level_count; ++k)
        count += c->spline[k].tasks;
#pragma omp parallel for schedule(dynamic, 1) num_threads(c->threads)
    for (size_t i = 0; i < count; ++i) {
        size_t k = 1, task = i;
        for (; task >= c->spline[k].tasks; ++k)
            task -= c->spline[k].tasks;
        for (size_t z = z0; z < z1; ++z)
            sum_plane(r, &c->spline[k], task, z);
    }
}

/* ---- solving ---- */

/* Planes p0 .. p1 - 1 along x and y. */
static void solve_planes(const spline_run *r, const spline_level *s, size_t p0, size_t p1)
{
    enum { N = ISO_SPLINE_LANES, CHUNK = 64 };
    const size_t nx = s->axis[0].coarse, ny = s->axis[1].coarse, groups = (ny + N - 1) / N,
                 chunks = (nx + CHUNK - 1) / CHUNK;
#pragma omp parallel num_threads(r->c->threads)
    {
#pragma omp for schedule(static)
        for (size_t i = 0; i < (p1 - p0) * groups; ++i) {
            const size_t y = i % groups * N;
            iso_spline_solve_rows(s->solve[0], nx, slot(s, p0 + i / groups) + y * nx, nx, ny - y < N ? ny - y : N,
                                  thread_scratch(r));
        }
#pragma omp for schedule(static)
        for (size_t i = 0; i < (p1 - p0) * chunks; ++i) {
            const size_t x = i % chunks * CHUNK;
            iso_spline_solve(s->solve[1], ny, slot(s, p0 + i / chunks) + x, nx, nx - x < CHUNK ? nx - x : CHUNK);
        }
    }
}

/* The block that begins at plane p0, along z, to where it is stored. */
static void solve_block(const spline_run *r, size_t k, size_t p0)
{
    iso_cascade *c = r->c;
    const spline_level *s = &c->spline[k];
    const iso_cascade_out *out = &r->out[k];
    const size_t nx = s->axis[0].coarse, ny = s->axis[1].coarse, nz = s->axis[2].coarse;
    const size_t first = p0 > SPLINE_APRON ? p0 - SPLINE_APRON : 0,
                 p1 = p0 + SPLINE_BLOCK < nz ? p0 + SPLINE_BLOCK : nz,
                 end = p1 + SPLINE_APRON < nz ? p1 + SPLINE_APRON : nz;
    iso_spline_row rows[SPLINE_WINDOW];
    float lo = c->lo[k], hi = c->hi[k];
    if (p0 < out->first)
        return;
    iso_spline_factorize(&s->axis[2], first, end, rows);
#pragma omp parallel for schedule(static) num_threads(c->threads) reduction(min : lo) reduction(max : hi)
    for (size_t y = 0; y < ny; ++y) {
        float *values = thread_scratch(r);
        for (size_t p = first; p < end; ++p)
            memcpy(values + (p - first) * nx, slot(s, p) + y * nx, nx * sizeof *values);
        iso_spline_solve(rows, end - first, values, nx, nx);
        for (size_t p = p0; p < p1; ++p) {
            const float *row = values + (p - first) * nx;
            iso_row_range(row, nx, &lo, &hi);
            if (out->scalar)
                memcpy(out->scalar + ((p - out->first) * ny + y) * nx, row, nx * sizeof *row);
        }
    }
    c->lo[k] = lo;
    c->hi[k] = hi;
}

/* What the fine planes z0 .. z1 - 1 complete. */
static void finish_planes(const spline_run *r, size_t k, size_t z0, size_t z1)
{
    const spline_level *s = &r->c->spline[k];
    const size_t p0 = summed_planes(s, z0), p1 = summed_planes(s, z1);
    if (p1 > p0)
        solve_planes(r, s, p0, p1);
    for (size_t p = solved_planes(s, p0); p < solved_planes(s, p1); p += SPLINE_BLOCK)
        solve_block(r, k, p);
}

/* Values of a level may be larger than those of level 0, but not by this much. */
#define LARGEST (FLT_MAX / 256)

iso_status iso_cascade_spline_feed(iso_cascade *c, const iso_planes *in, size_t z0, size_t z1,
                                   const iso_cascade_out *out, iso_error *err)
{
    if (!c->spline || c->level_count == 1)
        return ISO_OK;
    if (!(c->lo[0] >= -LARGEST && c->hi[0] <= LARGEST))
        return iso_fail(err, ISO_E_RANGE, "values from %g to %g, least-squares levels take %g to %g", (double)c->lo[0],
                        (double)c->hi[0], -(double)LARGEST, (double)LARGEST);
    spline_run r = {.c = c, .in = in, .out = out, .per_thread = scratch_floats(c)};
    r.memory = aligned_alloc(64, (size_t)c->threads * r.per_thread * sizeof *r.memory);
    if (!r.memory)
        return iso_fail(err, ISO_E_MEMORY, "pyramid: no memory for the rows of %d threads", c->threads);
    for (size_t z = z0; z < z1; z += SPLINE_BATCH) {
        const size_t end = z + SPLINE_BATCH < z1 ? z + SPLINE_BATCH : z1;
        sum_planes(&r, z, end);
        for (size_t k = 1; k < c->level_count; ++k)
            finish_planes(&r, k, z, end);
    }
    free(r.memory);
    return ISO_OK;
}

/* SPDX-License-Identifier: MIT */
/* cascade_spline.c - least-squares levels (spline_kernel.h), each from level 0, plane by plane.
 *
 * A fine row is added to the coarse rows whose tents it touches. These are reduced along x and added to the coarse
 * planes whose tents touch the fine plane. A coarse plane whose last fine plane has come is solved along x and y. Along
 * z the solution reaches over the whole volume, but decays: blocks of SPLINE_BLOCK planes, by their index, are solved
 * with SPLINE_APRON planes on either side, so that the result depends on no slab:
 *
 *     planes       . . . . . . . . . . . . | o o o o o o o o | . . . . . . . . . . . .
 *                  apron, 12                 block, 8          apron, 12
 *
 * The truncation error is below 1e-6 of the difference between the values at the apron's end and their neighbors. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "pyramid/cascade_spline.h"

/* ---- which planes ---- */

/* Returns the number of planes in the blocks whose window lies in the summed planes. */
static size_t solved_planes(const spline_level *s, size_t summed)
{
    if (summed == s->axis[2].coarse)
        return summed;
    return summed >= SPLINE_APRON ? (summed - SPLINE_APRON) / SPLINE_BLOCK * SPLINE_BLOCK : 0;
}

/* True if the level is made at the end, from the carry. */
static bool is_top(const iso_cascade *c, size_t level)
{
    return c->carry && level > c->tile_top;
}

size_t iso_cascade_spline_complete(const iso_cascade *c, size_t level, size_t z)
{
    if (level > 0 && is_top(c, level))
        return z == c->size[0][2] ? c->size[level][2] : 0;
    return level == 0 ? z : solved_planes(&c->spline[level], iso_spline_summed(&c->spline[level].axis[2], z));
}

size_t iso_cascade_spline_lag(void)
{
    return SPLINE_BLOCK + SPLINE_APRON + 3;
}

size_t iso_cascade_spline_from(const iso_cascade *c, size_t level, size_t complete)
{
    const spline_level *s = &c->spline[level];
    if (complete == s->axis[2].coarse || is_top(c, level))
        return s->axis[2].fine;
    return iso_spline_first(&s->axis[2], complete > SPLINE_APRON ? complete - SPLINE_APRON : 0);
}

/* ---- create, destroy ---- */

static size_t task_rows(const spline_level *s)
{
    return SPLINE_ROWS > s->axis[1].ratio ? SPLINE_ROWS / s->axis[1].ratio : 1;
}

typedef struct spline_window {
    size_t p0, p1, first, end; /* planes of the block, and those that it is solved with */
} spline_window;

static spline_window window_of(const spline_level *s, size_t block)
{
    const size_t nz = s->axis[2].coarse, p0 = block * SPLINE_BLOCK,
                 p1 = p0 + SPLINE_BLOCK < nz ? p0 + SPLINE_BLOCK : nz;
    return (spline_window){p0, p1, p0 > SPLINE_APRON ? p0 - SPLINE_APRON : 0,
                           p1 + SPLINE_APRON < nz ? p1 + SPLINE_APRON : nz};
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
    const size_t blocks = (s->axis[2].coarse + SPLINE_BLOCK - 1) / SPLINE_BLOCK;
    s->solve_z = malloc(blocks * SPLINE_WINDOW * sizeof *s->solve_z);
    for (size_t b = 0; s->solve_z && b < blocks; ++b) {
        const spline_window w = window_of(s, b);
        iso_spline_factorize(&s->axis[2], w.first, w.end, s->solve_z + b * SPLINE_WINDOW);
    }
    const size_t most = SPLINE_WINDOW + (SPLINE_BATCH >> k) + 6;
    s->slot_count = s->axis[2].coarse < most || is_top(c, k) ? s->axis[2].coarse : most;
    s->slots = calloc(s->slot_count * spline_plane_floats(s), sizeof *s->slots);
    s->tasks = is_top(c, k) ? 0 : (s->axis[1].coarse + task_rows(s) - 1) / task_rows(s);
    if (c->opt.scalar_filter == ISO_SCALAR_DAMPED)
        good = iso_own_create(s) && good;
    return good && s->solve_z && s->slots;
}

iso_status iso_cascade_spline_create(iso_cascade *c, iso_error *err)
{
    if (!iso_scalar_filter_is_spline(c->opt.scalar_filter))
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
        free(c->spline[k].solve_z);
        free(c->spline[k].slots);
        free(c->spline[k].own);
    }
    free(c->spline);
}

size_t iso_cascade_spline_floats(const iso_cascade *c)
{
    size_t floats = 0;
    for (size_t k = 1; c->spline && k < c->level_count; ++k) {
        const spline_level *s = &c->spline[k];
        floats += s->slot_count * spline_plane_floats(s) + (s->own ? iso_own_floats(s) : 0);
    }
    return floats;
}

/* ---- sums ---- */

static size_t largest(size_t a, size_t b)
{
    return a > b ? a : b;
}

static size_t scratch_floats(const iso_cascade *c)
{
    size_t most = c->carry ? iso_cascade_cells_scratch(c) : 0;
    for (size_t k = 1; k < c->level_count; ++k) {
        const spline_level *s = &c->spline[k];
        const size_t padded = is_top(c, k) ? 0 : iso_spline_padded(&s->axis[0]);
        const size_t own = s->own && !is_top(c, k) ? iso_own_scratch(s) : 0;
        most = largest(most, c->size[0][0] + task_rows(s) * padded + 2 * padded + s->axis[0].coarse + own + 64);
        most = largest(most, (largest(SPLINE_WINDOW, ISO_SPLINE_LANES)) * s->axis[0].coarse + 64);
    }
    return (most + 15) / 16 * 16;
}

/* Sets sum to weight * row if is_first, otherwise adds it. */
static void weigh_row(float weight, const float *row, size_t n, float *sum, bool is_first)
{
    if (is_first)
        memset(sum, 0, n * sizeof *sum);
    iso_add_weighted_row(weight, row, n, sum);
}

/* Sums a fine plane along y into the coarse rows of `own`, `padded` floats apart and ready to be reduced along x. */
static void sum_rows(const spline_run *r, const spline_level *s, own_rows *own, float *row, float *sums)
{
    const size_t z = own->z, j0 = own->j0, j1 = own->j1;
    const iso_spline_axis *a = &s->axis[1];
    const size_t padded = iso_spline_padded(&s->axis[0]), n = s->axis[0].fine, offset = s->axis[0].ratio / 2;
    memset(sums, 0, (j1 - j0) * padded * sizeof *sums);
    for (size_t y = iso_spline_first(a, j0); y < iso_spline_end(a, j1 - 1); ++y) {
        double f;
        const size_t j = iso_spline_lookup(a, y, &f);
        iso_planes_row(r->in, y, z, row);
        if (s->own)
            iso_own_row(s, y, row, own);
        if (j >= j0 && j < j1)
            iso_add_weighted_row((float)((1 - f) / (double)a->ratio), row, n, sums + (j - j0) * padded + offset);
        if (f > 0 && j + 1 >= j0 && j + 1 < j1)
            iso_add_weighted_row((float)(f / (double)a->ratio), row, n, sums + (j + 1 - j0) * padded + offset);
    }
}

/* Adds the fine plane z to the coarse planes that it contributes to: the rows of one task. */
static void sum_plane(const spline_run *r, const spline_level *s, size_t task, size_t z)
{
    const size_t nx = s->axis[0].coarse, ny = s->axis[1].coarse, padded = iso_spline_padded(&s->axis[0]);
    const size_t j0 = task * task_rows(s), j1 = j0 + task_rows(s) < ny ? j0 + task_rows(s) : ny;
    const iso_spline_axis *a = &s->axis[2];
    float *row = spline_scratch(r), *sums = row + s->axis[0].fine, *halves = sums + task_rows(s) * padded,
          *reduced = halves + 2 * padded + 16;
    double f;
    const size_t p = iso_spline_lookup(a, z, &f);
    own_rows own;
    iso_own_begin(s, z, j0, j1, reduced + nx, &own);
    sum_rows(r, s, &own, row, sums);
    if (s->own)
        iso_own_end(s, &own);
    for (size_t j = j0; j < j1; ++j) {
        iso_spline_reduce_row(&s->axis[0], sums + (j - j0) * padded, halves, reduced);
        weigh_row((float)((1 - f) / (double)a->ratio), reduced, nx, spline_slot(s, p) + j * nx,
                  z == iso_spline_first(a, p));
        if (f > 0)
            weigh_row((float)(f / (double)a->ratio), reduced, nx, spline_slot(s, p + 1) + j * nx,
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
        for (size_t z = largest(z0, iso_cascade_spline_from(c, k, r->out[k].first)); z < z1; ++z)
            sum_plane(r, &c->spline[k], task, z);
    }
}

/* ---- solving ---- */

/* Work that fine planes complete in a level: planes to solve along x and y, and planes of blocks. */
typedef struct spline_range {
    size_t p0, p1, block0, block1;
} spline_range;

static spline_range completed(const spline_run *r, size_t k, size_t z0, size_t z1)
{
    const spline_level *s = &r->c->spline[k];
    const size_t first = r->out[k].first, p0 = iso_spline_summed(&s->axis[2], z0),
                 p1 = iso_spline_summed(&s->axis[2], z1);
    const size_t needed = largest(p0, first > SPLINE_APRON ? first - SPLINE_APRON : 0),
                 block0 = largest(solved_planes(s, p0), first) / SPLINE_BLOCK,
                 block1 = (solved_planes(s, p1) + SPLINE_BLOCK - 1) / SPLINE_BLOCK;
    return (spline_range){needed, largest(needed, p1), block0, largest(block0, block1)};
}

/* Solves a plane along x and y. */
static void solve_plane(const spline_run *r, const spline_level *s, size_t p)
{
    enum { N = ISO_SPLINE_LANES, CHUNK = 64 };
    const size_t nx = s->axis[0].coarse, ny = s->axis[1].coarse;
    float *plane = spline_slot(s, p);
    for (size_t y = 0; y < ny; y += N)
        iso_spline_solve_rows(s->solve[0], nx, plane + y * nx, nx, ny - y < N ? ny - y : N, spline_scratch(r));
    for (size_t x = 0; x < nx; x += CHUNK)
        iso_spline_solve(s->solve[1], ny, plane + x, nx, nx - x < CHUNK ? nx - x : CHUNK);
}

/* Solves row y of a block along z and stores it. */
static void solve_row(const spline_run *r, size_t k, size_t block, size_t y, float *lo, float *hi)
{
    const spline_level *s = &r->c->spline[k];
    const iso_cascade_out *out = &r->out[k];
    const size_t nx = s->axis[0].coarse, ny = s->axis[1].coarse;
    const spline_window w = window_of(s, block);
    float *values = spline_scratch(r);
    for (size_t p = w.first; p < w.end; ++p)
        memcpy(values + (p - w.first) * nx, spline_slot(s, p) + y * nx, nx * sizeof *values);
    iso_spline_solve(s->solve_z + block * SPLINE_WINDOW, w.end - w.first, values, nx, nx);
    for (size_t p = w.p0; p < w.p1; ++p) {
        float *row = values + (p - w.first) * nx;
        if (s->own)
            iso_own_damp(s, y, p, row);
        iso_row_range(row, nx, lo, hi);
        if (out->scalar)
            memcpy(out->scalar + ((p - out->first) * ny + y) * nx, row, nx * sizeof *row);
    }
}

/* Finishes levels k0 .. k1 - 1 together. Threads then meet seldom: each meeting may wait for a busy core. */
static void finish_planes(const spline_run *r, size_t k0, size_t k1, size_t z0, size_t z1)
{
    iso_cascade *c = r->c;
    spline_range of[MAX_LEVELS];
    size_t planes = 0, rows = 0;
    for (size_t k = k0; k < k1; ++k) {
        of[k] = completed(r, k, z0, z1);
        planes += of[k].p1 - of[k].p0;
        rows += (of[k].block1 - of[k].block0) * c->size[k][1];
    }
#pragma omp parallel num_threads(c->threads) if (planes + rows > 0)
    {
        float lo[MAX_LEVELS], hi[MAX_LEVELS];
        for (size_t k = k0; k < k1; ++k)
            lo[k] = INFINITY, hi[k] = -INFINITY;
#pragma omp for schedule(dynamic, 1)
        for (size_t i = 0; i < planes; ++i) {
            size_t k = k0, at = i;
            for (; at >= of[k].p1 - of[k].p0; ++k)
                at -= of[k].p1 - of[k].p0;
            solve_plane(r, &c->spline[k], of[k].p0 + at);
        }
#pragma omp for schedule(dynamic, 4)
        for (size_t i = 0; i < rows; ++i) {
            size_t k = k0, at = i;
            for (; at >= (of[k].block1 - of[k].block0) * c->size[k][1]; ++k)
                at -= (of[k].block1 - of[k].block0) * c->size[k][1];
            solve_row(r, k, of[k].block0 + at / c->size[k][1], at % c->size[k][1], &lo[k], &hi[k]);
        }
#pragma omp critical(iso_cascade_range)
        for (size_t k = k0; k < k1; ++k) {
            c->lo[k] = fminf(c->lo[k], lo[k]);
            c->hi[k] = fmaxf(c->hi[k], hi[k]);
        }
    }
}

iso_status iso_cascade_spline_feed(iso_cascade *c, const iso_planes *in, size_t z0, size_t z1,
                                   const iso_cascade_out *out, iso_error *err)
{
    if (!c->spline || c->level_count == 1)
        return ISO_OK;
    spline_run r = {.c = c, .in = in, .out = out, .per_thread = scratch_floats(c)};
    r.memory = aligned_alloc(64, (size_t)c->threads * r.per_thread * sizeof *r.memory);
    NEED_MEMORY(r.memory, err, "pyramid: no memory for the rows of %d threads", c->threads);
    const size_t top = c->carry ? c->tile_top + 1 : c->level_count; /* the first level that is made at the end */
    for (size_t z = z0; z < z1; z += SPLINE_BATCH) {
        const size_t end = z + SPLINE_BATCH < z1 ? z + SPLINE_BATCH : z1;
        sum_planes(&r, z, end);
        if (c->carry && end > out[0].first)
            iso_cascade_cells_feed(&r, largest(z, out[0].first), end);
        finish_planes(&r, 1, top, z, end);
    }
    if (top < c->level_count && z1 == c->size[0][2]) {
        for (size_t k = top; k < c->level_count; ++k)
            iso_cascade_cells_gather(&r, &c->spline[k]);
        finish_planes(&r, top, c->level_count, 0, z1);
    }
    free(r.memory);
    return ISO_OK;
}

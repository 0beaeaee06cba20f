/* SPDX-License-Identifier: MIT */
/* cascade_weighted.c - least-squares directions, each level from level 0's gradients, plane by
 * plane.
 *
 * A fine row is reduced along x and added to the coarse rows and planes whose tents it touches. The system of all
 * coarse voxels is then solved by WEIGHTED_ROUNDS rounds of Chebyshev's iteration from b / W: with W before it, M has
 * its eigenvalues between 0 and 1. Few rounds suffice: the components of the smallest eigenvalues are noise. Each round
 * reaches one plane further, and coefficients are fixed. So blocks of WEIGHTED_BLOCK planes, by their index, are solved
 * with as many planes on either side as there are rounds, and no byte depends on slabs, threads or ranks:
 *
 *     round 0      . . . o o o o o o o o . . .     planes that are made
 *     round 1        . . o o o o o o o o . .
 *     round 2          . o o o o o o o o .
 *     the last           o o o o o o o o           a block: kept
 *
 * Levels above the cascade's carry, with voxels of 2^(CARRY_LEVEL + 1) and more, keep their moments. */
#include <float.h>
#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "base/simd.h"
#include "pyramid/cascade_kernel.h"
#include "pyramid/spline_kernel.h"

/* ---- rows of the system ---- */

/* Rows of weighted least squares in three dimensions. Cannot fail or allocate, and is free of
 * threads.
 *
 * Sought are the directions D of a coarse level whose trilinear lookup is nearest to the unit directions d of the
 * fine voxels x, each as heavy as its squared gradient w(x):
 *
 *     sum_x w(x) |sum_j hat_j(x) D_j - d(x)|^2  ->  least,      or M D = b,
 *     M_ij = sum_x w hat_i hat_j,   b_i = sum_x w hat_i d,   W_i = sum_x w hat_i = sum_j M_ij
 *
 * With weights the system is not a product of axes, unlike the scalar's (spline_kernel.h). But hat_i hat_j is a
 * product, and equal for both diagonals of a cell. So 8 of a coarse voxel's 27 entries are kept, at the lower of the
 * two voxels, indexed by whether the two differ along x, y and z. A coarse voxel has W, b (3) and these 8: 12
 * planes. */
enum { ISO_WEIGHTED_W = 0, ISO_WEIGHTED_B = 1, ISO_WEIGHTED_M = 4, ISO_WEIGHTED_PLANES = 12 };

/* Returns the row of M by whether the two voxels differ along x, y, z (0 or 1 each). */
static inline size_t iso_weighted_m(size_t dx, size_t dy, size_t dz)
{
    return ISO_WEIGHTED_M + 4 * dz + 2 * dy + dx;
}


/* Sums of a fine row, reduced along x: W, b (3), and M without and with a difference along x. */
enum { ISO_WEIGHTED_REDUCED = 6 };

ISO_SIMD static void weigh(const float *restrict gx, const float *restrict gy, const float *restrict gz, size_t n,
                           float *restrict w, float *restrict dx, float *restrict dy, float *restrict dz)
{
    for (size_t i = 0; i < n; ++i) {
        const float x = gx[i], y = gy[i], z = gz[i], m2 = x * x + y * y + z * z, m = sqrtf(m2);
        w[i] = m2;
        dx[i] = m * x;
        dy[i] = m * y;
        dz[i] = m * z;
    }
}

/* Computes, for a row of n gradients, squares, and gradients times lengths, which are weighted unit directions. */
static void weighted_row(float *const g[3], size_t n, float *restrict w, float *const wd[3])
{
    weigh(g[0], g[1], g[2], n, w, wd[0], wd[1], wd[2]);
}

/* Reduces a fine row. lookup, part: for each fine voxel, the coarse voxel below its center and the weight of the next
 * one, 0 if there is none (iso_spline_lookup). out: ISO_WEIGHTED_REDUCED rows, `coarse` floats apart. */
static void weighted_reduce_row(const unsigned *lookup, const float *part, size_t fine, size_t coarse,
                                const float *restrict w, float *const wd[3], float *restrict out)
{
    float *restrict weight = out, *restrict same = out + 4 * coarse, *restrict next = out + 5 * coarse;
    memset(out, 0, ISO_WEIGHTED_REDUCED * coarse * sizeof *out);
    for (size_t i = 0; i < fine; ++i) {
        const size_t j = lookup[i], after = part[i] > 0 ? j + 1 : j;
        const float f = part[i], upper = f * w[i], lower = w[i] - upper;
        weight[j] += lower;
        weight[after] += upper;
        same[j] += lower * (1 - f);
        same[after] += upper * f;
        next[j] += lower * f;
    }
    for (size_t c = 0; c < 3; ++c) {
        const float *restrict d = wd[c];
        float *restrict b = out + (1 + c) * coarse;
        for (size_t i = 0; i < fine; ++i) {
            const size_t j = lookup[i], after = part[i] > 0 ? j + 1 : j;
            const float upper = part[i] * d[i];
            b[j] += d[i] - upper;
            b[after] += upper;
        }
    }
}

ISO_SIMD static void subtract(const float *restrict same, const float *restrict next, const float *restrict value,
                              size_t n, float *restrict residual)
{
    residual[0] -= same[0] * value[0] + (n > 1 ? next[0] * value[1] : 0);
    for (size_t i = 1; i + 1 < n; ++i)
        residual[i] -= same[i] * value[i] + (next[i] * value[i + 1] + next[i - 1] * value[i - 1]);
    if (n > 1)
        residual[n - 1] -= same[n - 1] * value[n - 1] + next[n - 2] * value[n - 2];
}

/* Subtracts one neighboring row's part of M D from residual: b - M D of a row of n, 3 rows `stride` apart. same, next:
 * M without and with a difference along x. values: the 3 rows of D, `value_stride` apart. */
static void weighted_subtract(const float *restrict same, const float *restrict next, const float *restrict values,
                              size_t value_stride, size_t n, float *restrict residual, size_t stride)
{
    for (size_t c = 0; c < 3; ++c)
        subtract(same, next, values + c * value_stride, n, residual + c * stride);
}

/* Sets step = keep * step + gain * residual / W, and D = before + step. The term with W is 0 if W vanishes. */
ISO_SIMD static void weighted_step(float keep, float gain, const float *restrict weight, const float *restrict residual,
                                   size_t n, float *restrict step, const float *before, float *after)
{
    for (size_t i = 0; i < n; ++i) {
        float inverse = 1 / weight[i];
        inverse = weight[i] >= FLT_MIN ? inverse : 0;
        const float s = keep * step[i] + gain * (residual[i] * inverse);
        step[i] = s;
        after[i] = before[i] + s;
    }
}

ISO_SIMD static void shorten(float *restrict dx, float *restrict dy, float *restrict dz, size_t n)
{
    for (size_t i = 0; i < n; ++i) {
        const float length = sqrtf(dx[i] * dx[i] + dy[i] * dy[i] + dz[i] * dz[i]);
        const float factor = length > 1 ? 1 / length : length;
        dx[i] *= factor;
        dy[i] *= factor;
        dz[i] *= factor;
    }
}

/* Shortens D of length L to the stored D L: at most 1, and shorter if gradients disagree, as with moments. */
static void weighted_shorten(float *const d[3], size_t n)
{
    shorten(d[0], d[1], d[2], n);
}

/* ---- the cascade ---- */

enum { WEIGHTED_ROUNDS = 3, WEIGHTED_BLOCK = 8, WEIGHTED_WINDOW = WEIGHTED_BLOCK + 2 * WEIGHTED_ROUNDS };
/* Fine planes between two meetings of the threads, and fine rows of a thread's task. */
enum { WEIGHTED_BATCH = 16, WEIGHTED_ROWS = 32 };
/* The least eigenvalue that the rounds are made for. */
#define WEIGHTED_LEAST 0.15

struct weighted_level {
    iso_spline_axis axis[3];
    unsigned *lookup; /* of a fine row: weighted_reduce_row() */
    float *part;
    size_t slot_count; /* coarse planes that are kept: plane p in slot p % slot_count */
    float *slots;
    float *values[2], *step; /* WEIGHTED_WINDOW planes of 3 rows each */
    size_t tasks;
};

/* Working state of one call of iso_cascade_weighted_feed. */
typedef struct weighted_run {
    iso_cascade *c;
    const iso_planes *in;
    const iso_cascade_out *out;
    float *memory;
    size_t per_thread;
} weighted_run;

/* ---- which planes ---- */

static size_t top_level(const iso_cascade *c)
{
    return c->tile_top < c->level_count - 1 ? c->tile_top : c->level_count - 1;
}

/* Returns the number of planes in the blocks whose window lies in the summed planes. */
static size_t solved_planes(const weighted_level *s, size_t summed)
{
    if (summed == s->axis[2].coarse)
        return summed;
    return summed >= WEIGHTED_ROUNDS ? (summed - WEIGHTED_ROUNDS) / WEIGHTED_BLOCK * WEIGHTED_BLOCK : 0;
}

size_t iso_cascade_weighted_complete(const iso_cascade *c, size_t level, size_t z)
{
    if (level == 0 || level > top_level(c))
        return SIZE_MAX;
    return solved_planes(&c->weighted[level], iso_spline_summed(&c->weighted[level].axis[2], z));
}

size_t iso_cascade_weighted_lag(void)
{
    return WEIGHTED_BLOCK + WEIGHTED_ROUNDS + 3;
}

size_t iso_cascade_weighted_from(const iso_cascade *c, size_t level, size_t complete)
{
    const weighted_level *s = &c->weighted[level];
    if (level > top_level(c) || complete == s->axis[2].coarse)
        return c->size[0][2];
    const size_t block = complete / WEIGHTED_BLOCK * WEIGHTED_BLOCK;
    return iso_spline_first(&s->axis[2], block > WEIGHTED_ROUNDS ? block - WEIGHTED_ROUNDS : 0);
}

/* ---- create, destroy ---- */

static size_t row_floats(const weighted_level *s)
{
    return s->axis[0].coarse;
}

static size_t plane_floats(const weighted_level *s)
{
    return s->axis[0].coarse * s->axis[1].coarse;
}

/* Returns row `row` of one of the quantities of a coarse plane. */
static float *slot_row(const weighted_level *s, size_t plane, size_t quantity, size_t row)
{
    return s->slots + (plane % s->slot_count * ISO_WEIGHTED_PLANES + quantity) * plane_floats(s) +
           row * s->axis[0].coarse;
}

static size_t task_rows(const weighted_level *s)
{
    return WEIGHTED_ROWS > s->axis[1].ratio ? WEIGHTED_ROWS / s->axis[1].ratio : 1;
}

static size_t window_floats(const weighted_level *s)
{
    const size_t nz = s->axis[2].coarse;
    return 3 * plane_floats(s) * (nz < WEIGHTED_WINDOW ? nz : WEIGHTED_WINDOW);
}

static bool create_level(const iso_cascade *c, size_t k, weighted_level *s)
{
    for (int a = 0; a < 3; ++a)
        s->axis[a] = (iso_spline_axis){c->size[0][a], c->size[k][a], (size_t)1 << k};
    const size_t most = WEIGHTED_WINDOW + (WEIGHTED_BATCH >> k) + 4;
    s->slot_count = s->axis[2].coarse < most ? s->axis[2].coarse : most;
    s->slots = calloc(s->slot_count * ISO_WEIGHTED_PLANES * plane_floats(s), sizeof *s->slots);
    s->tasks = (s->axis[1].coarse + task_rows(s) - 1) / task_rows(s);
    s->lookup = malloc(s->axis[0].fine * sizeof *s->lookup);
    s->part = malloc(s->axis[0].fine * sizeof *s->part);
    for (int i = 0; i < 2; ++i)
        s->values[i] = malloc(window_floats(s) * sizeof *s->values[i]);
    s->step = malloc(window_floats(s) * sizeof *s->step);
    for (size_t i = 0; s->lookup && s->part && i < s->axis[0].fine; ++i) {
        double f;
        s->lookup[i] = (unsigned)iso_spline_lookup(&s->axis[0], i, &f);
        s->part[i] = (float)f;
    }
    return s->slots && s->lookup && s->part && s->values[0] && s->values[1] && s->step;
}

iso_status iso_cascade_weighted_create(iso_cascade *c, iso_error *err)
{
    if (c->opt.direction_filter != ISO_DIRECTION_LEAST_SQUARES)
        return ISO_OK;
    c->weighted = calloc(c->level_count, sizeof *c->weighted);
    bool good = c->weighted != NULL;
    for (size_t k = 1; k <= top_level(c) && good; ++k)
        good = create_level(c, k, &c->weighted[k]);
    return good ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "pyramid: no memory for the planes of least-squares directions");
}

void iso_cascade_weighted_destroy(iso_cascade *c)
{
    for (size_t k = 1; c->weighted && k <= top_level(c); ++k) {
        weighted_level *s = &c->weighted[k];
        free(s->slots);
        free(s->lookup);
        free(s->part);
        free(s->values[0]);
        free(s->values[1]);
        free(s->step);
    }
    free(c->weighted);
}

size_t iso_cascade_weighted_floats(const iso_cascade *c)
{
    size_t floats = 0;
    for (size_t k = 1; c->weighted && k <= top_level(c); ++k) {
        const weighted_level *s = &c->weighted[k];
        floats += s->slot_count * ISO_WEIGHTED_PLANES * plane_floats(s) + 3 * window_floats(s);
    }
    return floats;
}

/* ---- sums ---- */

static size_t scratch_floats(const iso_cascade *c)
{
    const size_t n = row_stride(c, 0);
    return (iso_emit_rows_count(c) + (ISO_WEIGHTED_REDUCED + 3) * n + 64 + 15) / 16 * 16;
}

/* A place along y or z: the coarse voxel below it, and the weights of that one and of the next. */
typedef struct weighted_place {
    size_t at;
    float weight[2];
    bool is_two; /* the next one has a part */
} weighted_place;

static weighted_place place_of(const iso_spline_axis *a, size_t i)
{
    double f;
    const size_t j = iso_spline_lookup(a, i, &f);
    return (weighted_place){j, {(float)(1 - f), (float)f}, f > 0};
}

/* Adds a fine row, reduced along x, to one coarse row of one coarse plane; y, z: 0 for the lower of the two, 1 for the
 * next. */
static void add_reduced(const weighted_level *s, const float *reduced, const weighted_place at[2], size_t y, size_t z)
{
    const size_t n = row_floats(s), row = at[0].at + y, plane = at[1].at + z;
    const float wy = at[0].weight[y], wz = at[1].weight[z], w = wy * wz;
    for (size_t q = 0; q < 4; ++q)
        iso_add_weighted_row(w, reduced + q * n, n, slot_row(s, plane, q, row));
    for (size_t dz = 0; dz <= (size_t)(z == 0 && at[1].is_two); ++dz)
        for (size_t dy = 0; dy <= (size_t)(y == 0 && at[0].is_two); ++dy) {
            const float product = w * (dy ? at[0].weight[1] : wy) * (dz ? at[1].weight[1] : wz);
            for (size_t dx = 0; dx < 2; ++dx)
                iso_add_weighted_row(product, reduced + (4 + dx) * n, n,
                                     slot_row(s, plane, iso_weighted_m(dx, dy, dz), row));
        }
}

/* Clears rows j0 .. j1 - 1 of a coarse plane's slot, before its first fine plane. */
static void begin_plane(const weighted_level *s, size_t plane, size_t j0, size_t j1)
{
    for (size_t q = 0; q < ISO_WEIGHTED_PLANES; ++q)
        memset(slot_row(s, plane, q, j0), 0, (j1 - j0) * s->axis[0].coarse * sizeof(float));
}

/* Adds the fine plane z to the coarse planes that it contributes to: the rows of one task. */
static void sum_plane(const weighted_run *r, const weighted_level *s, size_t task, size_t z)
{
    const size_t ny = s->axis[1].coarse, n = s->axis[0].fine;
    const size_t j0 = task * task_rows(s), j1 = j0 + task_rows(s) < ny ? j0 + task_rows(s) : ny;
    scratch memory = {r->memory + (size_t)iso_thread_index() * r->per_thread};
    emit_rows rows = iso_take_emit_rows(r->c, &memory);
    float *reduced = take(&memory, ISO_WEIGHTED_REDUCED * row_floats(s));
    weighted_place at[2] = {{0}, place_of(&s->axis[2], z)};
    for (size_t p = 0; p <= (size_t)at[1].is_two; ++p)
        if (z == iso_spline_first(&s->axis[2], at[1].at + p))
            begin_plane(s, at[1].at + p, j0, j1);
    for (size_t y = iso_spline_first(&s->axis[1], j0); y < iso_spline_end(&s->axis[1], j1 - 1); ++y) {
        iso_cascade_level0_gradients(r->c, r->in, y, z, &rows);
        weighted_row(rows.g, n, rows.row, rows.d);
        weighted_reduce_row(s->lookup, s->part, n, row_floats(s), rows.row, rows.d, reduced);
        at[0] = place_of(&s->axis[1], y);
        for (size_t p = 0; p <= (size_t)at[1].is_two; ++p)
            for (size_t j = 0; j <= (size_t)at[0].is_two; ++j)
                if (at[0].at + j >= j0 && at[0].at + j < j1)
                    add_reduced(s, reduced, at, j, p);
    }
}

static void sum_planes(const weighted_run *r, size_t z0, size_t z1)
{
    const iso_cascade *c = r->c;
    size_t count = 0;
    for (size_t k = 1; k <= top_level(c); ++k)
        count += c->weighted[k].tasks;
#pragma omp parallel for schedule(dynamic, 1) num_threads(c->threads)
    for (size_t i = 0; i < count; ++i) {
        size_t k = 1, task = i;
        for (; task >= c->weighted[k].tasks; ++k)
            task -= c->weighted[k].tasks;
        const size_t from = iso_cascade_weighted_from(c, k, r->out[k].first);
        for (size_t z = z0 > from ? z0 : from; z < z1; ++z)
            sum_plane(r, &c->weighted[k], task, z);
    }
}

/* ---- solving ---- */

/* Planes p0 .. p1 - 1 of a round; those of the working arrays begin with `first`. */
typedef struct weighted_round {
    size_t p0, p1, first;
    float keep, gain;
    int from; /* which of the two arrays of values is read */
} weighted_round;

static float *value_row(const weighted_level *s, float *values, size_t plane, size_t row)
{
    return values + plane * 3 * plane_floats(s) + row * s->axis[0].coarse;
}

/* Computes b - M D of the row. */
static void row_residual(const weighted_level *s, const weighted_round *of, size_t plane, size_t row, float *residual)
{
    const size_t n = row_floats(s), area = plane_floats(s);
    for (size_t c = 0; c < 3; ++c)
        memcpy(residual + c * n, slot_row(s, plane, ISO_WEIGHTED_B + c, row), n * sizeof *residual);
    for (size_t z = plane > 0 ? plane - 1 : 0; z <= plane + 1 && z < s->axis[2].coarse; ++z)
        for (size_t y = row > 0 ? row - 1 : 0; y <= row + 1 && y < s->axis[1].coarse; ++y) {
            const size_t low_z = z < plane ? z : plane, low_y = y < row ? y : row;
            weighted_subtract(slot_row(s, low_z, iso_weighted_m(0, y != row, z != plane), low_y),
                              slot_row(s, low_z, iso_weighted_m(1, y != row, z != plane), low_y),
                              value_row(s, s->values[of->from], z - of->first, y), area, n, residual, n);
        }
}

/* Computes D of row i after this round; b / W if is_first. */
static void round_row(const weighted_run *r, const weighted_level *s, const weighted_round *of, bool is_first, size_t i)
{
    const size_t plane = of->p0 + i / s->axis[1].coarse, row = i % s->axis[1].coarse, n = row_floats(s);
    float *residual = r->memory + (size_t)iso_thread_index() * r->per_thread;
    float *before = value_row(s, s->values[of->from], plane - of->first, row),
          *after = value_row(s, s->values[!of->from], plane - of->first, row),
          *step = value_row(s, s->step, plane - of->first, row);
    if (!is_first)
        row_residual(s, of, plane, row, residual);
    for (size_t c = 0; c < 3; ++c) {
        const size_t at = c * plane_floats(s);
        if (is_first) {
            memset(before + at, 0, n * sizeof *before);
            memset(step + at, 0, n * sizeof *step);
            memcpy(residual + c * n, slot_row(s, plane, ISO_WEIGHTED_B + c, row), n * sizeof *residual);
        }
        weighted_step(of->keep, of->gain, slot_row(s, plane, ISO_WEIGHTED_W, row), residual + c * n, n, step + at,
                      before + at, after + at);
    }
}

static void emit_row(const weighted_run *r, size_t k, const weighted_round *of, size_t i)
{
    const weighted_level *s = &r->c->weighted[k];
    const size_t plane = of->p0 + i / s->axis[1].coarse, row = i % s->axis[1].coarse, n = row_floats(s);
    scratch memory = {r->memory + (size_t)iso_thread_index() * r->per_thread};
    emit_rows rows = iso_take_emit_rows(r->c, &memory);
    const float *values = value_row(s, s->values[of->from], plane - of->first, row);
    if (plane < r->out[k].first)
        return;
    for (size_t c = 0; c < 3; ++c)
        memcpy(rows.d[c], values + c * plane_floats(s), n * sizeof *values);
    weighted_shorten(rows.d, n);
    iso_emit_directions(r->c, &r->out[k], k, row, plane, &rows);
}

/* Chebyshev's iteration for eigenvalues from WEIGHTED_LEAST to 1; round 0 makes b / W. */
static void next_coefficients(size_t round, double *rho, weighted_round *of)
{
    const double middle = (1 + WEIGHTED_LEAST) / 2, half = (1 - WEIGHTED_LEAST) / 2, sigma = middle / half;
    const double before = *rho;
    of->keep = 0;
    of->gain = round == 0 ? 1 : (float)(1 / middle);
    *rho = 1 / sigma;
    if (round > 1) {
        *rho = 1 / (2 * sigma - before);
        of->keep = (float)(*rho * before);
        of->gain = (float)(2 * *rho / half);
    }
}

static void solve_block(const weighted_run *r, size_t k, size_t block)
{
    const weighted_level *s = &r->c->weighted[k];
    const size_t nz = s->axis[2].coarse, p0 = block * WEIGHTED_BLOCK,
                 p1 = p0 + WEIGHTED_BLOCK < nz ? p0 + WEIGHTED_BLOCK : nz, ny = s->axis[1].coarse;
    weighted_round of = {.first = p0 > WEIGHTED_ROUNDS ? p0 - WEIGHTED_ROUNDS : 0};
    double rho = 0;
    for (size_t round = 0; round <= WEIGHTED_ROUNDS; ++round) {
        const size_t reach = WEIGHTED_ROUNDS - round;
        of.p0 = p0 > reach ? p0 - reach : 0;
        of.p1 = p1 + reach < nz ? p1 + reach : nz;
        next_coefficients(round, &rho, &of);
#pragma omp parallel for schedule(static) num_threads(r->c->threads)
        for (size_t i = 0; i < (of.p1 - of.p0) * ny; ++i)
            round_row(r, s, &of, round == 0, i);
        of.from = !of.from;
    }
#pragma omp parallel for schedule(static) num_threads(r->c->threads)
    for (size_t i = 0; i < (of.p1 - of.p0) * ny; ++i)
        emit_row(r, k, &of, i);
}

static void finish_planes(const weighted_run *r, size_t z0, size_t z1)
{
    for (size_t k = 1; k <= top_level(r->c); ++k) {
        const weighted_level *s = &r->c->weighted[k];
        const size_t before = solved_planes(s, iso_spline_summed(&s->axis[2], z0)), first = r->out[k].first;
        const size_t end = (solved_planes(s, iso_spline_summed(&s->axis[2], z1)) + WEIGHTED_BLOCK - 1) / WEIGHTED_BLOCK;
        for (size_t b = (before > first ? before : first) / WEIGHTED_BLOCK; b < end; ++b)
            solve_block(r, k, b);
    }
}

iso_status iso_cascade_weighted_feed(iso_cascade *c, const iso_planes *in, size_t z0, size_t z1,
                                     const iso_cascade_out *out, iso_error *err)
{
    if (!c->weighted || c->level_count == 1)
        return ISO_OK;
    weighted_run r = {.c = c, .in = in, .out = out, .per_thread = scratch_floats(c)};
    r.memory = aligned_alloc(64, (size_t)c->threads * r.per_thread * sizeof *r.memory);
    NEED_MEMORY(r.memory, err, "pyramid: no memory for the rows of %d threads", c->threads);
    for (size_t z = z0; z < z1; z += WEIGHTED_BATCH) {
        const size_t end = z + WEIGHTED_BATCH < z1 ? z + WEIGHTED_BATCH : z1;
        sum_planes(&r, z, end);
        finish_planes(&r, z, end);
    }
    free(r.memory);
    return ISO_OK;
}

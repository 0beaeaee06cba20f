/* SPDX-License-Identifier: MIT */
#include "fit/extinction_scale.h"

#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "base/simd.h"
#include "fit/interpolation.h"
#include "tf/level_look.h"

/* ---- opacities of rows of values, in float ---- */

/* Opacities of rows of values, in float. */

/* A transfer function's optical depth over one length, in powers of two: opacity = 1 - 2^-depth. Linear between
 * entries, constant beyond them. */
typedef struct depth_table {
    float lo, entries_per_value, last; /* the value of entry 0; and the number of the last entry */
    const float *depth, *slope;        /* of an entry; to the next one */
    const float *sum, *rest;           /* the integral up to an entry, and its remainder after rounding to a float */
} depth_table;


/* Computes the length of the gradient, in values per voxel: central differences of the row in the middle and of its
 * four neighbors, low and high along y and z. Rows have n voxels. The first and the last have one-sided differences
 * unless the row goes on there. */
typedef struct stencil_rows {
    const float *middle, *y[2], *z[2];
    float y_scale, z_scale; /* 1 / the distance between both */
} stencil_rows;

/* Returns 2^x for |x| < 126, relative error below 2e-7: the nearest whole power and a polynomial of the rest (Cephes'
 * exp2f). */
static inline __attribute__((always_inline)) float power_of_two(float x)
{
    const int32_t biased = (int32_t)(x + 127.5f);
    const float f = x - (float)(biased - 127);
    const uint32_t bits = (uint32_t)biased << 23;
    float whole;
    memcpy(&whole, &bits, sizeof whole);
    float p = 1.535336188319500e-4f;
    p = p * f + 1.339887440266574e-3f;
    p = p * f + 9.618437357674640e-3f;
    p = p * f + 5.550332471162809e-2f;
    p = p * f + 2.402264791363012e-1f;
    p = p * f + 6.931472028550421e-1f;
    return whole * (p * f + 1);
}

/* A place in the table, and the integral from its entry to there. */
typedef struct place {
    int32_t entry;
    float part;
} place;

static inline __attribute__((always_inline)) place place_of(const depth_table *t, float x)
{
    float inside = x > 0 ? x : 0;
    inside = inside < t->last ? inside : t->last;
    const int32_t i = (int32_t)inside;
    const float f = inside - (float)i, depth = t->depth[i] + f * t->slope[i];
    return (place){i, f * 0.5f * (t->depth[i] + depth) + (x - inside) * depth};
}

/* Returns the mean depth over a range. Narrow ranges are widened a little: their integral would be all rounding. */
static inline __attribute__((always_inline)) float depth_of(const depth_table *t, float value, float width)
{
    const float narrow = 1.0f / 64, wide = width * t->entries_per_value;
    const float range = wide > narrow ? wide : narrow, x = (value - t->lo) * t->entries_per_value;
    const place a = place_of(t, x - 0.5f * range), b = place_of(t, x + 0.5f * range);
    const float whole = (t->sum[b.entry] - t->sum[a.entry]) + (t->rest[b.entry] - t->rest[a.entry]);
    const float depth = (whole + (b.part - a.part)) / range;
    return depth > 0 ? depth : 0;
}

static inline __attribute__((always_inline)) float opacity_of(float depth)
{
    return 1 - power_of_two(depth < 125 ? -depth : -125.0f);
}

/* Computes the opacity of n voxels, each of which holds the values from value - width / 2 to value + width / 2 in equal
 * parts: its depth is the mean over them. */
ISO_SIMD static void opacity_row(const depth_table *table, const float *restrict value, const float *restrict width,
                                 size_t n, float *restrict alpha)
{
    const depth_table t = *table;
    for (size_t i = 0; i < n; ++i)
        alpha[i] = opacity_of(depth_of(&t, value[i], width[i]));
}

/* Computes the same with 2^octaves times the depth. */
ISO_SIMD static void opacity_row_scaled(const depth_table *table, const float *restrict value,
                                        const float *restrict width, const float *restrict octaves, size_t n,
                                        float *restrict alpha)
{
    const depth_table t = *table;
    for (size_t i = 0; i < n; ++i)
        alpha[i] = opacity_of(depth_of(&t, value[i], width[i]) * power_of_two(octaves[i]));
}

ISO_SIMD static void slope_inside(const stencil_rows *r, size_t first, size_t count, float *restrict slope)
{
    const float *restrict m = r->middle + first;
    const float *restrict y0 = r->y[0] + first, *restrict y1 = r->y[1] + first;
    const float *restrict z0 = r->z[0] + first, *restrict z1 = r->z[1] + first;
    const float sy = r->y_scale, sz = r->z_scale;
    for (size_t i = 0; i < count; ++i) {
        const float x = 0.5f * (m[i + 1] - (m - 1)[i]), y = sy * (y1[i] - y0[i]), z = sz * (z1[i] - z0[i]);
        slope[i] = __builtin_sqrtf(x * x + y * y + z * z);
    }
}

/* Returns the slope at an end of a row; along x it is the difference between the voxels `from` and `to`. */
static float slope_at_end(const stencil_rows *r, size_t at, size_t from, size_t to)
{
    const float x = r->middle[to] - r->middle[from], y = r->y_scale * (r->y[1][at] - r->y[0][at]),
                z = r->z_scale * (r->z[1][at] - r->z[0][at]);
    return __builtin_sqrtf(x * x + y * y + z * z);
}

static void slope_row(const stencil_rows *rows, size_t first, size_t count, size_t row_length, float *restrict slope)
{
    const size_t end = first + count, begin_inside = first > 0 ? first : 1;
    const size_t end_inside = end < row_length ? end : row_length - 1;
    if (begin_inside < end_inside)
        slope_inside(rows, begin_inside, end_inside - begin_inside, slope + (begin_inside - first));
    if (first == 0)
        slope[0] = slope_at_end(rows, 0, 0, row_length > 1 ? 1 : 0);
    if (end == row_length)
        slope[count - 1] = slope_at_end(rows, end - 1, row_length > 1 ? end - 2 : 0, end - 1);
}

/* Returns sum (a - b)^2. */
ISO_SIMD static float square_distance(const float *restrict a, const float *restrict b, size_t n)
{
    enum { lanes = 8 };
    float part[lanes] = {0}, sum = 0;
    size_t i = 0;
    for (; i + lanes <= n; i += lanes)
        for (size_t k = 0; k < lanes; ++k)
            part[k] += (a[i + k] - b[i + k]) * (a[i + k] - b[i + k]);
    for (size_t k = 0; i + k < n; ++k)
        part[k] += (a[i + k] - b[i + k]) * (a[i + k] - b[i + k]);
    for (size_t k = 0; k < lanes; ++k)
        sum += part[k];
    return sum;
}

/* ---- scales ---- */

enum { ROUNDS = 3, SCRATCH_ROWS = 3 };

/* Added to both sums, as a part of all weights of a coarse voxel: a trace of opacity says little about q. */
static const float trace = 1e-3f;

/* Range that a run of fine voxels lies in, both as it is and as the level shows it. */
typedef struct range {
    float min, max;
} range;

struct iso_extinction_scaler {
    const iso_level *fine, *coarse;
    size_t level;
    int threads;
    iso_interpolation map;
    range *ranges;           /* of each run */
    uint8_t *wanted;         /* whether the transfer functions show anything of it */
    float *octaves;          /* log2 q, a coarse voxel each */
    float *slope;            /* of the level's scalar: how far values reach inside a fine voxel */
    float *target, *present; /* the two sums */
};

void iso_extinction_scaler_destroy(iso_extinction_scaler *s)
{
    if (!s)
        return;
    iso_interpolation_destroy(&s->map);
    free(s->ranges);
    free(s->wanted);
    free(s->octaves);
    free(s->slope);
    free(s->target);
    free(s->present);
    free(s);
}

static size_t runs_in_row(const iso_extinction_scaler *s)
{
    return (s->map.axis[0].fine_size + ISO_FIT_RUN - 1) / ISO_FIT_RUN;
}

static const float *fine_row(const iso_extinction_scaler *s, const iso_fine_row *row)
{
    const iso_interpolation_axis *a = s->map.axis;
    return s->fine->scalar + row->x + a[0].fine_size * (row->y + a[1].fine_size * row->z);
}

/* Returns the rows next to a row of a level. At the grid's faces one of the two is the row itself. */
static stencil_rows stencil_of(const iso_level *l, size_t y, size_t z)
{
    const size_t *n = l->geometry.size, row = n[0], plane = row * n[1];
    const float *middle = l->scalar + y * row + z * plane;
    const bool low[2] = {y > 0, z > 0}, high[2] = {y + 1 < n[1], z + 1 < n[2]};
    return (stencil_rows){.middle = middle,
                          .y = {low[0] ? middle - row : middle, high[0] ? middle + row : middle},
                          .z = {low[1] ? middle - plane : middle, high[1] ? middle + plane : middle},
                          .y_scale = low[0] && high[0] ? 0.5f : 1,
                          .z_scale = low[1] && high[1] ? 0.5f : 1};
}

/* Measures slopes of the level per fine voxel. */
static void measure_slopes(iso_extinction_scaler *s)
{
    const size_t *n = s->coarse->geometry.size;
    const float part = 1.0f / (float)((size_t)1 << s->level);
    const int threads = iso_threads(s->threads);
#pragma omp parallel for schedule(static) num_threads(threads)
    for (size_t z = 0; z < n[2]; ++z)
        for (size_t y = 0; y < n[1]; ++y) {
            const stencil_rows rows = stencil_of(s->coarse, y, z);
            float *slope = s->slope + n[0] * (y + n[1] * z);
            slope_row(&rows, 0, n[0], n[0], slope);
            for (size_t x = 0; x < n[0]; ++x)
                slope[x] *= part;
        }
}

static void fine_slopes(const iso_extinction_scaler *s, const iso_fine_row *row, float *slope)
{
    const stencil_rows rows = stencil_of(s->fine, row->y, row->z);
    slope_row(&rows, row->x, row->count, s->map.axis[0].fine_size, slope);
}

static void note_ranges(void *context, const iso_fine_row *row)
{
    iso_extinction_scaler *s = context;
    const float *own = fine_row(s, row), *shown = row->values[0], *shown_width = row->values[1];
    float *own_width = row->results[0];
    fine_slopes(s, row, own_width);
    range *r = s->ranges + runs_in_row(s) * (row->y + s->map.axis[1].fine_size * row->z);
    for (size_t begin = 0; begin < row->count; begin += ISO_FIT_RUN, ++r) {
        const size_t end = begin + ISO_FIT_RUN < row->count ? begin + ISO_FIT_RUN : row->count;
        *r = (range){own[begin], own[begin]};
        for (size_t i = begin; i < end; ++i) {
            const float a = 0.5f * own_width[i], b = 0.5f * shown_width[i];
            r->min = fminf(r->min, fminf(own[i] - a, shown[i] - b));
            r->max = fmaxf(r->max, fmaxf(own[i] + a, shown[i] + b));
        }
    }
}

static iso_status check_levels(const iso_level *fine, const iso_level *coarse, const iso_interpolation *map,
                               iso_error *err)
{
    if (!fine->scalar || !coarse->scalar)
        return iso_fail(err, ISO_E_RANGE, "extinction scale: a level has no scalars");
    for (int a = 0; a < 3; ++a)
        if (map->axis[a].coarse_size != coarse->geometry.size[a])
            return iso_fail(err, ISO_E_RANGE, "extinction scale: a level of %zu voxels along an axis, %zu expected",
                            coarse->geometry.size[a], map->axis[a].coarse_size);
    return ISO_OK;
}

iso_status iso_extinction_scaler_create(const iso_level *fine, const iso_level *coarse, size_t level, int threads,
                                        iso_extinction_scaler **out, iso_error *err)
{
    iso_extinction_scaler *s = *out = calloc(1, sizeof *s);
    NEED_MEMORY(s, err, "extinction scale: out of memory");
    s->fine = fine, s->coarse = coarse, s->level = level, s->threads = threads;
    iso_status status = iso_interpolation_create(&s->map, fine->geometry.size, level, err);
    TRY(status, check_levels(fine, coarse, &s->map, err));
    if (status == ISO_OK) {
        const size_t runs = iso_interpolation_run_count(&s->map), voxels = s->map.coarse_count;
        s->ranges = malloc(runs * sizeof *s->ranges);
        s->wanted = malloc(runs);
        s->octaves = malloc(voxels * sizeof *s->octaves);
        s->slope = malloc(voxels * sizeof *s->slope);
        s->target = malloc(voxels * sizeof *s->target);
        s->present = malloc(voxels * sizeof *s->present);
        if (!s->ranges || !s->wanted || !s->octaves || !s->slope || !s->target || !s->present)
            status = iso_fail(err, ISO_E_MEMORY, "extinction scale: no memory for %zu voxels", voxels);
    }
    if (status == ISO_OK) {
        measure_slopes(s);
        /* The output is a place for rows of widths alone. */
        const float *const inputs[] = {coarse->scalar, s->slope};
        const iso_interpolation_pass pass = {.input_count = 2,
                                             .inputs = inputs,
                                             .output_count = 1,
                                             .outputs = &s->present,
                                             .function = note_ranges,
                                             .context = s};
        status = iso_interpolation_run(&s->map, &pass, threads, err);
    }
    if (status != ISO_OK) {
        iso_extinction_scaler_destroy(s);
        *out = NULL;
    }
    return status;
}

/* ---- visibility -------------------------------------------------------------------------------------------------- */

/* A transfer function for the kernels, and how many of its entries below each one show anything. */
typedef struct shown_tf {
    depth_table table;
    float *owned;
    uint32_t *shown_below; /* an entry more than there are */
} shown_tf;

static void shown_tf_destroy(shown_tf *t)
{
    free(t->owned);
    free(t->shown_below);
}

static iso_status shown_tf_create(shown_tf *t, const iso_tf_table *tf, double length_mm, iso_error *err)
{
    const size_t n = tf->count;
    const double scale = length_mm / log(2.0);
    float *depth = t->owned = malloc(4 * n * sizeof *t->owned), *slope = depth + n, *sum = slope + n, *rest = sum + n;
    double integral = 0;
    t->shown_below = calloc(n + 1, sizeof *t->shown_below);
    NEED_MEMORY(t->owned && t->shown_below, err, "extinction scale: no memory for %zu entries", n);
    for (size_t i = 0; i < n; ++i) {
        depth[i] = (float)((double)tf->entries[4 * i + 3] * scale);
        t->shown_below[i + 1] = t->shown_below[i] + (depth[i] > 0);
    }
    for (size_t i = 0; i < n; ++i) {
        slope[i] = i + 1 < n ? depth[i + 1] - depth[i] : 0;
        sum[i] = (float)integral;
        rest[i] = (float)(integral - (double)sum[i]);
        integral += (double)depth[i] + 0.5 * (double)slope[i];
    }
    t->table = (depth_table){.lo = (float)tf->lo,
                             .entries_per_value = (float)((double)(n - 1) / (tf->hi - tf->lo)),
                             .last = (float)(n - 1),
                             .depth = depth,
                             .slope = slope,
                             .sum = sum,
                             .rest = rest};
    return ISO_OK;
}

static size_t entry_of(const depth_table *t, float value)
{
    const float x = (value - t->lo) * t->entries_per_value;
    return x > 0 ? (size_t)(x < t->last ? x : t->last) : 0;
}

/* True if any value of the range has opacity, by the entries that its values lie between. */
static bool shows(const shown_tf *t, range r)
{
    const size_t first = entry_of(&t->table, r.min), last = entry_of(&t->table, r.max);
    const size_t end = last + 2 <= (size_t)t->table.last + 1 ? last + 2 : (size_t)t->table.last + 1;
    return t->shown_below[end] > t->shown_below[first];
}

static size_t find_seen(iso_extinction_scaler *s, const shown_tf *original, const shown_tf *own)
{
    const size_t runs = iso_interpolation_run_count(&s->map);
    const int threads = iso_threads(s->threads);
    size_t seen = 0;
#pragma omp parallel for schedule(static) num_threads(threads) reduction(+ : seen)
    for (size_t r = 0; r < runs; ++r) {
        s->wanted[r] = shows(original, s->ranges[r]) || shows(own, s->ranges[r]);
        seen += s->wanted[r];
    }
    return seen;
}

/* ---- rounds ---------------------------------------------------------------------------------------------------- */

/* Sum of square distances. Integer sums do not depend on thread order. */
typedef struct thread_sum {
    int64_t square;
    float *scratch; /* of fine rows */
    char padding[48];
} thread_sum;
static const double square_unit = 1 << 20;

typedef struct round_context {
    const iso_extinction_scaler *s;
    const shown_tf *original, *own;
    thread_sum *sums;
} round_context;

static void add_square(const round_context *c, const iso_fine_row *row, const float *a, const float *b)
{
    c->sums[row->thread].square += llround((double)square_distance(a, b, row->count) * square_unit);
}

/* Compares the level's opacities with q = 1 to the fine voxels'. */
static void first_round(void *context, const iso_fine_row *row)
{
    const round_context *c = context;
    float *width = c->sums[row->thread].scratch;
    opacity_row(&c->own->table, row->values[0], row->values[1], row->count, row->results[0]);
    fine_slopes(c->s, row, width);
    opacity_row(&c->original->table, fine_row(c->s, row), width, row->count, row->results[1]);
    add_square(c, row, row->results[0], row->results[1]);
}

static void later_round(void *context, const iso_fine_row *row)
{
    const round_context *c = context;
    opacity_row_scaled(&c->own->table, row->values[0], row->values[1], row->values[2], row->count, row->results[0]);
}

/* Compares the opacities that the bytes give to the fine voxels'. */
static void last_look(void *context, const iso_fine_row *row)
{
    const round_context *c = context;
    const size_t n = c->s->map.axis[0].fine_size;
    float *width = c->sums[row->thread].scratch, *fine = width + n, *shown = fine + n;
    fine_slopes(c->s, row, width);
    opacity_row(&c->original->table, fine_row(c->s, row), width, row->count, fine);
    opacity_row_scaled(&c->own->table, row->values[0], row->values[1], row->values[2], row->count, shown);
    add_square(c, row, shown, fine);
}

static const float least_octaves = -6, most_octaves = 3;

static void multiply(iso_extinction_scaler *s)
{
    const float floor = trace * (float)((size_t)1 << (3 * s->level));
    for (size_t j = 0; j < s->map.coarse_count; ++j) {
        const float more = log2f((s->target[j] + floor) / (s->present[j] + floor));
        s->octaves[j] = fminf(fmaxf(s->octaves[j] + more, least_octaves), most_octaves);
    }
}

static iso_status pass(const round_context *c, size_t input_count, size_t output_count, iso_fine_row_function *function,
                       iso_error *err)
{
    const iso_extinction_scaler *s = c->s;
    const float *inputs[] = {s->coarse->scalar, s->slope, s->octaves};
    float *outputs[] = {s->present, s->target};
    const iso_interpolation_pass p = {.input_count = input_count,
                                      .inputs = inputs,
                                      .output_count = output_count,
                                      .outputs = outputs,
                                      .function = function,
                                      .context = (void *)c,
                                      .wanted = s->wanted};
    return iso_interpolation_run(&s->map, &p, s->threads, err);
}

static void quantize(iso_extinction_scaler *s, uint8_t *bytes)
{
    const float unit = ISO_EXTINCTION_SCALE_PER_OCTAVE;
    for (size_t j = 0; j < s->map.coarse_count; ++j) {
        bytes[j] = (uint8_t)(lrintf(s->octaves[j] * unit) + ISO_EXTINCTION_SCALE_ONE);
        s->octaves[j] = (float)(bytes[j] - ISO_EXTINCTION_SCALE_ONE) / unit;
    }
}

/* Returns the sum of all threads, which then begin at 0 again. */
static double take_sum(thread_sum *sums, int threads)
{
    int64_t sum = 0;
    for (int t = 0; t < threads; ++t) {
        sum += sums[t].square;
        sums[t].square = 0;
    }
    return (double)sum / square_unit;
}

static iso_status run_rounds(iso_extinction_scaler *s, const round_context *c, uint8_t *bytes, double squares[2],
                             iso_error *err)
{
    const int threads = iso_threads(s->threads);
    memset(s->octaves, 0, s->map.coarse_count * sizeof *s->octaves);
    NEED(pass(c, 2, 2, first_round, err));
    squares[0] = take_sum(c->sums, threads);
    for (int round = 1; round <= ROUNDS; ++round) {
        multiply(s);
        if (round < ROUNDS)
            NEED(pass(c, 3, 1, later_round, err));
    }
    quantize(s, bytes);
    NEED(pass(c, 3, 0, last_look, err));
    squares[1] = take_sum(c->sums, threads);
    if (!(squares[1] < squares[0])) {
        memset(bytes, ISO_EXTINCTION_SCALE_ONE, s->map.coarse_count);
        squares[1] = squares[0];
    }
    return ISO_OK;
}

iso_status iso_extinction_scaler_apply(iso_extinction_scaler *s, const iso_tf_table *original, const iso_tf_table *own,
                                       uint8_t *bytes, iso_extinction_scale_cost *cost, iso_error *err)
{
    const int threads = iso_threads(s->threads);
    const double length_mm = iso_geometry_mean_spacing_mm(&s->fine->geometry);
    const size_t row = s->map.axis[0].fine_size;
    OWNED(shown_tf) of_original = {.owned = NULL}, of_own = {.owned = NULL};
    double squares[2] = {0};
    FREED thread_sum *sums = calloc((size_t)threads, sizeof *sums);
    FREED float *rows = malloc((size_t)threads * SCRATCH_ROWS * row * sizeof *rows);
    NEED_MEMORY(sums && rows, err, "extinction scale: out of memory");
    for (int t = 0; t < threads; ++t)
        sums[t].scratch = rows + (size_t)t * SCRATCH_ROWS * row;
    NEED(shown_tf_create(&of_original, original, length_mm, err));
    NEED(shown_tf_create(&of_own, own, length_mm, err));
    const size_t seen = ISO_FIT_RUN * find_seen(s, &of_original, &of_own);
    const round_context c = {s, &of_original, &of_own, sums};
    NEED(run_rounds(s, &c, bytes, squares, err));
    const double count = seen > 0 ? (double)seen : 1;
    if (cost)
        *cost = (iso_extinction_scale_cost){seen, sqrt(squares[0] / count), sqrt(squares[1] / count)};
    return ISO_OK;
}

/* Copies the level's own scale; 1 if it has none. */
static void copy_own(const iso_level *l, bool goes, uint8_t *bytes)
{
    const size_t count = iso_geometry_voxel_count(&l->geometry);
    if (l->scale && !goes)
        memcpy(bytes, l->scale, count);
    else
        memset(bytes, ISO_EXTINCTION_SCALE_ONE, count);
}

iso_status iso_extinction_scale_level(const iso_pyramid *p, size_t level, const iso_tf_table *original,
                                      const iso_tf_table *own, int threads, uint8_t **bytes, iso_error *err)
{
    const iso_level *l = &p->levels[level];
    iso_extinction_scaler *s = NULL;
    OWNED(iso_tf_table) look = {0};
    bool is_made_for = false;
    *bytes = NULL;
    if (level == 0)
        return ISO_OK;
    iso_status status = iso_level_look(p, level, original, &look, &is_made_for, err);
    if (status == ISO_OK && !(*bytes = malloc(iso_geometry_voxel_count(&l->geometry))))
        status = iso_fail(err, ISO_E_MEMORY, "extinction scale: no memory for one byte per voxel");
    const bool is_adapted = l->is_optimized && !is_made_for && !iso_tf_table_equals(original, own);
    if (status == ISO_OK &&
        (is_made_for || (l->is_optimized && !(is_adapted && l->edits_are_scaled)) || l->geometry.has_no_data)) {
        copy_own(l, is_adapted, *bytes);
    } else if (status == ISO_OK) {
        status = iso_extinction_scaler_create(&p->levels[0], l, level, threads, &s, err);
        TRY(status, iso_extinction_scaler_apply(s, original, own, *bytes, NULL, err));
    }
    if (status != ISO_OK) {
        free(*bytes);
        *bytes = NULL;
    }
    iso_extinction_scaler_destroy(s);
    return status;
}

/* SPDX-License-Identifier: MIT */
#include "fit/extinction_scale.h"

#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "fit/interpolation.h"
#include "fit/opacity_kernel.h"
#include "tf/level_look.h"

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
static iso_stencil_rows stencil_of(const iso_level *l, size_t y, size_t z)
{
    const size_t *n = l->geometry.size, row = n[0], plane = row * n[1];
    const float *middle = l->scalar + y * row + z * plane;
    const bool low[2] = {y > 0, z > 0}, high[2] = {y + 1 < n[1], z + 1 < n[2]};
    return (iso_stencil_rows){.middle = middle,
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
            const iso_stencil_rows rows = stencil_of(s->coarse, y, z);
            float *slope = s->slope + n[0] * (y + n[1] * z);
            iso_slope_row(&rows, 0, n[0], n[0], slope);
            for (size_t x = 0; x < n[0]; ++x)
                slope[x] *= part;
        }
}

static void fine_slopes(const iso_extinction_scaler *s, const iso_fine_row *row, float *slope)
{
    const iso_stencil_rows rows = stencil_of(s->fine, row->y, row->z);
    iso_slope_row(&rows, row->x, row->count, s->map.axis[0].fine_size, slope);
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
    if (!s)
        return iso_fail(err, ISO_E_MEMORY, "extinction scale: out of memory");
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
    iso_depth_table table;
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
    if (!t->owned || !t->shown_below)
        return iso_fail(err, ISO_E_MEMORY, "extinction scale: no memory for %zu entries", n);
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
    t->table = (iso_depth_table){.lo = (float)tf->lo,
                                 .entries_per_value = (float)((double)(n - 1) / (tf->hi - tf->lo)),
                                 .last = (float)(n - 1),
                                 .depth = depth,
                                 .slope = slope,
                                 .sum = sum,
                                 .rest = rest};
    return ISO_OK;
}

static size_t entry_of(const iso_depth_table *t, float value)
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
    c->sums[row->thread].square += llround((double)iso_square_distance(a, b, row->count) * square_unit);
}

/* Compares the level's opacities with q = 1 to the fine voxels'. */
static void first_round(void *context, const iso_fine_row *row)
{
    const round_context *c = context;
    float *width = c->sums[row->thread].scratch;
    iso_opacity_row(&c->own->table, row->values[0], row->values[1], row->count, row->results[0]);
    fine_slopes(c->s, row, width);
    iso_opacity_row(&c->original->table, fine_row(c->s, row), width, row->count, row->results[1]);
    add_square(c, row, row->results[0], row->results[1]);
}

static void later_round(void *context, const iso_fine_row *row)
{
    const round_context *c = context;
    iso_opacity_row_scaled(&c->own->table, row->values[0], row->values[1], row->values[2], row->count, row->results[0]);
}

/* Compares the opacities that the bytes give to the fine voxels'. */
static void last_look(void *context, const iso_fine_row *row)
{
    const round_context *c = context;
    const size_t n = c->s->map.axis[0].fine_size;
    float *width = c->sums[row->thread].scratch, *fine = width + n, *shown = fine + n;
    fine_slopes(c->s, row, width);
    iso_opacity_row(&c->original->table, fine_row(c->s, row), width, row->count, fine);
    iso_opacity_row_scaled(&c->own->table, row->values[0], row->values[1], row->values[2], row->count, shown);
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
    iso_status status = pass(c, 2, 2, first_round, err);
    squares[0] = take_sum(c->sums, threads);
    for (int round = 1; status == ISO_OK && round <= ROUNDS; ++round) {
        multiply(s);
        if (round < ROUNDS)
            status = pass(c, 3, 1, later_round, err);
    }
    quantize(s, bytes);
    TRY(status, pass(c, 3, 0, last_look, err));
    squares[1] = take_sum(c->sums, threads);
    if (!(squares[1] < squares[0])) {
        memset(bytes, ISO_EXTINCTION_SCALE_ONE, s->map.coarse_count);
        squares[1] = squares[0];
    }
    return status;
}

iso_status iso_extinction_scaler_apply(iso_extinction_scaler *s, const iso_tf_table *original, const iso_tf_table *own,
                                       uint8_t *bytes, iso_extinction_scale_cost *cost, iso_error *err)
{
    const int threads = iso_threads(s->threads);
    const double length_mm = iso_geometry_mean_spacing_mm(&s->fine->geometry);
    const size_t row = s->map.axis[0].fine_size;
    shown_tf tfs[2] = {{.owned = NULL}};
    double squares[2] = {0};
    thread_sum *sums = calloc((size_t)threads, sizeof *sums);
    float *rows = malloc((size_t)threads * SCRATCH_ROWS * row * sizeof *rows);
    iso_status status = sums && rows ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "extinction scale: out of memory");
    for (int t = 0; t < threads && status == ISO_OK; ++t)
        sums[t].scratch = rows + (size_t)t * SCRATCH_ROWS * row;
    TRY(status, shown_tf_create(&tfs[0], original, length_mm, err));
    TRY(status, shown_tf_create(&tfs[1], own, length_mm, err));
    if (status == ISO_OK) {
        const size_t seen = ISO_FIT_RUN * find_seen(s, &tfs[0], &tfs[1]);
        const round_context c = {s, &tfs[0], &tfs[1], sums};
        status = run_rounds(s, &c, bytes, squares, err);
        const double count = seen > 0 ? (double)seen : 1;
        if (cost)
            *cost = (iso_extinction_scale_cost){seen, sqrt(squares[0] / count), sqrt(squares[1] / count)};
    }
    shown_tf_destroy(&tfs[0]);
    shown_tf_destroy(&tfs[1]);
    free(sums);
    free(rows);
    return status;
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
    iso_tf_table look = {0};
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
    iso_tf_table_destroy(&look);
    iso_extinction_scaler_destroy(s);
    return status;
}

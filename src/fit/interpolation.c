/* SPDX-License-Identifier: MIT */
#include "fit/interpolation.h"

#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "base/simd.h"

/* ---- rows ---- */

/* The loops over rows of interpolation.h. */

/* Computes out = (1 - w) a + w b, n floats. Equal values are kept exactly. */
ISO_SIMD static void interpolation_blend(const float *restrict a, const float *restrict b, float w, size_t n,
                                         float *restrict out)
{
    for (size_t i = 0; i < n; ++i)
        out[i] = a[i] + w * (b[i] - a[i]);
}

/* Adds w row to sum, n floats. */
ISO_SIMD static void interpolation_add(const float *restrict row, float w, size_t n, float *restrict sum)
{
    for (size_t i = 0; i < n; ++i)
        sum[i] += w * row[i];
}

/* Interpolates a coarse row at the fine voxels of its axis. */
ISO_SIMD static void interpolation_expand(const iso_interpolation_axis *axis, const float *restrict row,
                                          float *restrict fine)
{
    const uint32_t *restrict low = axis->low, *restrict high = axis->high;
    const float *restrict weight = axis->weight;
    for (size_t i = 0; i < axis->fine_size; ++i)
        fine[i] = row[low[i]] + weight[i] * (row[high[i]] - row[low[i]]);
}

/* Adds fine voxels' sums to a coarse row: the transpose. */
static void interpolation_contract(const iso_interpolation_axis *axis, const float *restrict fine, float *restrict row)
{
    for (size_t j = 0; j < axis->coarse_size; ++j) {
        const float *tap = axis->tap + axis->tap_start[j], *from = fine + axis->first[j];
        const size_t count = axis->tap_start[j + 1] - axis->tap_start[j];
        float sum = 0;
        for (size_t t = 0; t < count; ++t)
            sum += tap[t] * from[t];
        row[j] += sum;
    }
}

/* ---- the map ---- */

/* ---- weights --------------------------------------------------------------------------------------------------- */

/* Sets the place of fine voxel i between coarse ones, with the sampler's position and clamping. */
static void set_weights(iso_interpolation_axis *a, size_t i, double step)
{
    const double last = (double)(a->coarse_size - 1), p = ((double)i + 0.5) / step - 0.5;
    const double q = p > 0 ? (p < last ? p : last) : 0;
    a->low[i] = (uint32_t)q;
    a->high[i] = a->low[i] + 1 < a->coarse_size ? a->low[i] + 1 : a->low[i];
    a->weight[i] = (float)(q - (double)a->low[i]);
}

/* Sets the same weights by coarse voxels. Those of a coarse voxel are neighbors, since positions ascend. */
static void set_taps(iso_interpolation_axis *a)
{
    uint32_t tap = 0;
    for (uint32_t j = 0; j < a->coarse_size; ++j) {
        a->tap_start[j] = tap;
        uint32_t i = j ? a->first[j - 1] : 0;
        while (i < a->fine_size && a->low[i] != j && a->high[i] != j)
            ++i;
        a->first[j] = i;
        for (; i < a->fine_size && (a->low[i] == j || a->high[i] == j); ++i)
            a->tap[tap++] = a->low[i] == j ? 1 - a->weight[i] : a->weight[i];
    }
    a->tap_start[a->coarse_size] = tap;
}

static iso_status create_axis(iso_interpolation_axis *a, size_t size, size_t level, iso_error *err)
{
    const size_t step = (size_t)1 << level;
    a->fine_size = size;
    a->coarse_size = (size + step - 1) / step;
    a->low = malloc(size * sizeof *a->low);
    a->high = malloc(size * sizeof *a->high);
    a->weight = malloc(size * sizeof *a->weight);
    a->first = malloc(a->coarse_size * sizeof *a->first);
    a->tap_start = malloc((a->coarse_size + 1) * sizeof *a->tap_start);
    a->tap = malloc(2 * size * sizeof *a->tap);
    NEED_MEMORY(a->low && a->high && a->weight && a->first && a->tap_start && a->tap, err,
                "no memory for the weights of %zu voxels", size);
    for (size_t i = 0; i < size; ++i)
        set_weights(a, i, (double)step);
    set_taps(a);
    return ISO_OK;
}

iso_status iso_interpolation_create(iso_interpolation *map, const size_t fine_size[3], size_t level, iso_error *err)
{
    *map = (iso_interpolation){.fine_count = 1, .coarse_count = 1};
    if (level > 31)
        return iso_fail(err, ISO_E_RANGE, "interpolation: level %zu is not in 0 to 31", level);
    for (int a = 0; a < 3; ++a) {
        if (fine_size[a] == 0 || fine_size[a] > (size_t)1 << 31)
            return iso_fail(err, ISO_E_RANGE, "interpolation: a size of %zu is not in 1 to 2^31", fine_size[a]);
    }
    for (int a = 0; a < 3; ++a) {
        iso_status s = create_axis(&map->axis[a], fine_size[a], level, err);
        if (s != ISO_OK) {
            iso_interpolation_destroy(map);
            return s;
        }
        map->fine_count *= fine_size[a];
        map->coarse_count *= map->axis[a].coarse_size;
    }
    return ISO_OK;
}

void iso_interpolation_destroy(iso_interpolation *map)
{
    if (!map)
        return;
    for (int a = 0; a < 3; ++a) {
        iso_interpolation_axis *axis = &map->axis[a];
        free(axis->low);
        free(axis->high);
        free(axis->weight);
        free(axis->first);
        free(axis->tap_start);
        free(axis->tap);
    }
    *map = (iso_interpolation){0};
}

/* ---- a thread's buffers ---------------------------------------------------------------------------------------- */

/* Rows of the length of fine ones, one for each coarse y, and which of them are in use. */
typedef struct row_set {
    float *rows;
    uint8_t *used;
} row_set;

typedef struct scratch {
    row_set shown[ISO_FIT_GRIDS];  /* inputs in the plane of a fine z, expanded along x when first asked for */
    row_set slice[ISO_FIT_GRIDS];  /* outputs summed over the rows of a fine z */
    row_set sum[ISO_FIT_GRIDS][2]; /* ... over the fine z between two coarse planes, for each of both */
    float *values[ISO_FIT_GRIDS], *results[ISO_FIT_GRIDS], *coarse_row;
} scratch;

static bool row_set_create(row_set *s, const iso_interpolation *map)
{
    const size_t rows = map->axis[1].coarse_size;
    s->rows = calloc(rows * map->axis[0].fine_size, sizeof *s->rows);
    s->used = calloc(rows, 1);
    return s->rows && s->used;
}

static void row_set_destroy(row_set *s)
{
    free(s->rows);
    free(s->used);
}

static bool scratch_create(scratch *s, const iso_interpolation *map, const iso_interpolation_pass *pass)
{
    const size_t row_bytes = map->axis[0].fine_size * sizeof(float);
    s->coarse_row = malloc(map->axis[0].coarse_size * sizeof(float));
    bool all = s->coarse_row;
    for (size_t i = 0; i < pass->input_count; ++i)
        all = row_set_create(&s->shown[i], map) && (s->values[i] = malloc(row_bytes)) && all;
    for (size_t o = 0; o < pass->output_count; ++o)
        all = row_set_create(&s->slice[o], map) && row_set_create(&s->sum[o][0], map) &&
              row_set_create(&s->sum[o][1], map) && (s->results[o] = malloc(row_bytes)) && all;
    return all;
}

static void scratch_destroy(scratch *s)
{
    for (size_t g = 0; g < ISO_FIT_GRIDS; ++g) {
        row_set_destroy(&s->shown[g]);
        row_set_destroy(&s->slice[g]);
        row_set_destroy(&s->sum[g][0]);
        row_set_destroy(&s->sum[g][1]);
        free(s->values[g]);
        free(s->results[g]);
    }
    free(s->coarse_row);
}

/* ---- one pass -------------------------------------------------------------------------------------------------- */

typedef struct work {
    const iso_interpolation *map;
    const iso_interpolation_pass *pass;
    scratch *scratch;
    int thread;
    size_t z; /* of the fine slice at hand */
} work;

/* Returns the coarse row j of input i in the plane of this z, at fine x. */
static const float *shown_row(const work *w, size_t i, size_t j)
{
    const iso_interpolation_axis *x = &w->map->axis[0], *y = &w->map->axis[1], *z = &w->map->axis[2];
    row_set *shown = &w->scratch->shown[i];
    float *fine = shown->rows + j * x->fine_size;
    if (shown->used[j])
        return fine;
    const size_t plane = x->coarse_size * y->coarse_size, n = x->coarse_size;
    const float *a = w->pass->inputs[i] + z->low[w->z] * plane + j * n;
    const float *b = w->pass->inputs[i] + z->high[w->z] * plane + j * n;
    interpolation_blend(a, b, z->weight[w->z], n, w->scratch->coarse_row);
    interpolation_expand(x, w->scratch->coarse_row, fine);
    shown->used[j] = 1;
    return fine;
}

static void add_to(row_set *s, size_t j, size_t length, size_t x, const float *row, float weight, size_t count)
{
    if (weight == 0)
        return;
    interpolation_add(row, weight, count, s->rows + j * length + x);
    s->used[j] = 1;
}

/* Gathers voxels x to x + count - 1 of the row y, calls the function, and scatters along y. */
static void run_row(const work *w, size_t x, size_t y, size_t count)
{
    scratch *s = w->scratch;
    const iso_interpolation_axis *along_y = &w->map->axis[1];
    const size_t low = along_y->low[y], high = along_y->high[y], length = w->map->axis[0].fine_size;
    const float weight = along_y->weight[y];
    for (size_t i = 0; i < w->pass->input_count; ++i)
        interpolation_blend(shown_row(w, i, low) + x, shown_row(w, i, high) + x, weight, count, s->values[i]);
    const iso_fine_row row = {.x = x,
                              .y = y,
                              .z = w->z,
                              .count = count,
                              .values = (const float *const *)s->values,
                              .results = s->results,
                              .thread = w->thread};
    w->pass->function(w->pass->context, &row);
    for (size_t o = 0; o < w->pass->output_count; ++o) {
        add_to(&s->slice[o], low, length, x, s->results[o], 1 - weight, count);
        add_to(&s->slice[o], high, length, x, s->results[o], weight, count);
    }
}

static size_t runs_in_row(const iso_interpolation *map)
{
    return (map->axis[0].fine_size + ISO_FIT_RUN - 1) / ISO_FIT_RUN;
}

/* Runs the wanted runs of a row; adjacent ones together. */
static void run_wanted(const work *w, size_t y)
{
    const size_t runs = runs_in_row(w->map), length = w->map->axis[0].fine_size;
    const uint8_t *wanted = w->pass->wanted ? w->pass->wanted + runs * (y + w->map->axis[1].fine_size * w->z) : NULL;
    if (!wanted) {
        run_row(w, 0, y, length);
        return;
    }
    for (size_t r = 0, end; r < runs; r = end) {
        for (; r < runs && !wanted[r]; ++r) {
        }
        for (end = r; end < runs && wanted[end]; ++end) {
        }
        if (r < end)
            run_row(w, r * ISO_FIT_RUN, y, (end * ISO_FIT_RUN < length ? end * ISO_FIT_RUN : length) - r * ISO_FIT_RUN);
    }
}

/* Adds the summed rows of this z to the two coarse planes, still at fine x. */
static void add_slice(const work *w, size_t o)
{
    const size_t length = w->map->axis[0].fine_size;
    const float weight = w->map->axis[2].weight[w->z];
    row_set *slice = &w->scratch->slice[o], *sum = w->scratch->sum[o];
    for (size_t j = 0; j < w->map->axis[1].coarse_size; ++j) {
        if (!slice->used[j])
            continue;
        float *row = slice->rows + j * length;
        add_to(&sum[0], j, length, 0, row, 1 - weight, length);
        add_to(&sum[1], j, length, 0, row, weight, length);
        memset(row, 0, length * sizeof *row);
        slice->used[j] = 0;
    }
}

/* Contracts a coarse plane's sum, complete but for the neighbor's part, along x into the output, and clears it. */
static void finish_plane(const work *w, size_t o, row_set *sum, size_t plane)
{
    const iso_interpolation_axis *x = &w->map->axis[0], *y = &w->map->axis[1];
    for (size_t j = 0; j < y->coarse_size; ++j) {
        if (!sum->used[j])
            continue;
        float *row = sum->rows + j * x->fine_size;
        interpolation_contract(x, row, w->pass->outputs[o] + (plane * y->coarse_size + j) * x->coarse_size);
        memset(row, 0, x->fine_size * sizeof *row);
        sum->used[j] = 0;
    }
}

/* Runs the fine slices between the coarse planes p and p + 1. */
static void run_interval(work *w, size_t p)
{
    const iso_interpolation_axis *z = &w->map->axis[2];
    for (w->z = z->first[p]; w->z < z->fine_size && z->low[w->z] <= p; ++w->z) {
        if (z->low[w->z] < p)
            continue;
        for (size_t i = 0; i < w->pass->input_count; ++i)
            memset(w->scratch->shown[i].used, 0, w->map->axis[1].coarse_size);
        for (size_t y = 0; y < w->map->axis[1].fine_size; ++y)
            run_wanted(w, y);
        for (size_t o = 0; o < w->pass->output_count; ++o)
            add_slice(w, o);
    }
    for (size_t o = 0; o < w->pass->output_count; ++o) {
        finish_plane(w, o, &w->scratch->sum[o][0], p);
        finish_plane(w, o, &w->scratch->sum[o][1], p + 1);
    }
}

/* Runs all intervals. Each adds to the planes at both of its ends. Even ones share no plane, nor do odd ones: the
 * sums of a plane are taken in the same order for any number of threads. */
static void run_intervals(const iso_interpolation *map, const iso_interpolation_pass *pass, scratch *all, int threads)
{
    const size_t count = map->axis[2].coarse_size;
    for (size_t parity = 0; parity < 2; ++parity) {
#pragma omp parallel for schedule(dynamic) num_threads(threads)
        for (size_t p = parity; p < count; p += 2) {
            const int thread = iso_thread_index();
            work w = {.map = map, .pass = pass, .scratch = &all[thread], .thread = thread};
            run_interval(&w, p);
        }
    }
}

iso_status iso_interpolation_run(const iso_interpolation *map, const iso_interpolation_pass *pass, int threads,
                                 iso_error *err)
{
    if (pass->input_count > ISO_FIT_GRIDS || pass->output_count > ISO_FIT_GRIDS)
        return iso_fail(err, ISO_E_RANGE, "interpolation: %zu grids in and %zu out, %d is the most", pass->input_count,
                        pass->output_count, ISO_FIT_GRIDS);
    for (size_t o = 0; o < pass->output_count; ++o)
        memset(pass->outputs[o], 0, map->coarse_count * sizeof(float));
    const int count = iso_threads(threads);
    FREED scratch *all = calloc((size_t)count, sizeof *all);
    bool complete = all;
    for (int t = 0; complete && t < count; ++t)
        complete = scratch_create(&all[t], map, pass);
    if (complete)
        run_intervals(map, pass, all, count);
    for (int t = 0; all && t < count; ++t)
        scratch_destroy(&all[t]);
    return complete ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "no memory for %d threads' rows", count);
}

size_t iso_interpolation_run_count(const iso_interpolation *map)
{
    return runs_in_row(map) * map->axis[1].fine_size * map->axis[2].fine_size;
}

/* ---- each by itself -------------------------------------------------------------------------------------------- */

typedef struct fine_grid {
    const iso_interpolation *map;
    const float *in;
    float *out;
} fine_grid;

static size_t offset_of(const fine_grid *g, const iso_fine_row *row)
{
    return row->x + g->map->axis[0].fine_size * (row->y + g->map->axis[1].fine_size * row->z);
}

static void keep_row(void *context, const iso_fine_row *row)
{
    const fine_grid *g = context;
    memcpy(g->out + offset_of(g, row), row->values[0], row->count * sizeof(float));
}

static void read_row(void *context, const iso_fine_row *row)
{
    const fine_grid *g = context;
    memcpy(row->results[0], g->in + offset_of(g, row), row->count * sizeof(float));
}

iso_status iso_interpolation_gather(const iso_interpolation *map, const float *coarse, float *fine, int threads,
                                    iso_error *err)
{
    fine_grid grid = {.map = map, .out = fine};
    const iso_interpolation_pass pass = {.input_count = 1, .inputs = &coarse, .function = keep_row, .context = &grid};
    return iso_interpolation_run(map, &pass, threads, err);
}

iso_status iso_interpolation_scatter(const iso_interpolation *map, const float *fine, float *coarse, int threads,
                                     iso_error *err)
{
    fine_grid grid = {.map = map, .in = fine};
    const iso_interpolation_pass pass = {.output_count = 1, .outputs = &coarse, .function = read_row, .context = &grid};
    return iso_interpolation_run(map, &pass, threads, err);
}

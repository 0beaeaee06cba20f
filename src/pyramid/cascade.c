/* SPDX-License-Identifier: MIT */
#include "pyramid/cascade.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "base/simd.h"
#include "pyramid/cascade_kernel.h"

/* ---- from rows to stored samples ---- */

size_t iso_emit_rows_count(const iso_cascade *c)
{
    const size_t n = row_stride(c, 0);
    return (3 + 3 + 3 + 1 + 1 + 1 + 1) * n + 64 + iso_gradient_scratch_count(c->size[0][0]) + 16;
}

emit_rows iso_take_emit_rows(const iso_cascade *c, scratch *s)
{
    const size_t n = row_stride(c, 0);
    emit_rows r;
    for (int a = 0; a < 3; ++a) {
        r.d[a] = take(s, n);
        r.g[a] = take(s, n);
    }
    r.interleaved = take(s, 3 * n);
    r.magnitude = take(s, n);
    r.row = take(s, n);
    r.packed = (uint32_t *)(void *)take(s, n);
    r.bytes = (uint8_t *)take(s, n + 16);
    r.gradient = take(s, iso_gradient_scratch_count(c->size[0][0]));
    return r;
}

void iso_cascade_level0_gradients(const iso_cascade *c, const iso_planes *in, size_t y, size_t z, emit_rows *r)
{
    iso_gradient_row(in, c->opt.gradient.method, &c->matrix, y, z, r->gradient, r->g);
}

bool iso_emit_codes(iso_code code, size_t n, emit_rows *r)
{
    const iso_code_info *info = iso_code_describe(code);
    if (info->encode_rows) {
        info->encode_rows(r->d[0], r->d[1], r->d[2], n, r->packed);
        iso_unpack_bytes(r->packed, n, r->bytes);
        return false;
    }
    iso_interleave_rows(r->d[0], r->d[1], r->d[2], n, r->interleaved);
    iso_code_encode(code, r->interleaved, r->bytes, n);
    return true;
}

/* Stores the row of directions r->d: its codes, and floats and magnitudes if they are kept. */
static void store_codes(const iso_cascade *c, const iso_cascade_out *out, size_t k, size_t y, size_t z, emit_rows *r)
{
    const size_t n = c->size[k][0], at = ((z - out->first) * c->size[k][1] + y) * n;
    const bool is_interleaved = out->codes && iso_emit_codes(c->opt.code, n, r);
    if (out->directions && !is_interleaved)
        iso_interleave_rows(r->d[0], r->d[1], r->d[2], n, r->interleaved);
    if (out->codes)
        iso_copy_streaming(out->codes + 3 * at, r->bytes, 3 * n);
    if (out->directions)
        iso_copy_streaming(out->directions + 3 * at, r->interleaved, 3 * n * sizeof(float));
    if (out->magnitude) {
        iso_scale_row(r->magnitude, n, c->unscale);
        memcpy(out->magnitude + at, r->magnitude, n * sizeof(float));
    }
}

void iso_emit_level0(const iso_cascade *c, const iso_cascade_out *out, size_t y, size_t z, emit_rows *r)
{
    if (z < out->first || !(out->codes || out->directions || out->magnitude))
        return;
    iso_unit_rows(r->g, c->size[0][0], r->d, out->magnitude ? r->magnitude : NULL);
    store_codes(c, out, 0, y, z, r);
}

void iso_emit_coarse(const iso_cascade *c, const iso_cascade_out *out, size_t k, size_t y, size_t z,
                     iso_state_row state, emit_rows *r)
{
    if (z < out->first)
        return;
    const size_t n = c->size[k][0];
    iso_direction_rows(iso_direction_filter_of(&c->opt, k), &state, n, r->d, out->magnitude ? r->magnitude : NULL);
    store_codes(c, out, k, y, z, r);
}

void iso_emit_directions(const iso_cascade *c, const iso_cascade_out *out, size_t k, size_t y, size_t z, emit_rows *r)
{
    iso_cascade_out alone = *out;
    alone.magnitude = NULL;
    store_codes(c, &alone, k, y, z, r);
}

/* ---- filters of the own children, tile by tile ---- */

typedef struct tile {
    iso_cascade *c;
    const iso_planes *in;
    const iso_cascade_out *out;
    size_t base, top; /* levels */
    emit_rows rows;
    float *acc[MAX_LEVELS][2]; /* [k]: sums of two rows of level k, a half each */
    float *own[MAX_LEVELS];    /* [k]: a row of level k */
    float lo[MAX_LEVELS], hi[MAX_LEVELS];
    iso_agreement agreement[MAX_LEVELS];
} tile;

/* Returns where a row's scalars stand in the sums of two rows. Labels are not added: the second row follows. */
static float *scalar_of(const iso_cascade *c, float *acc, size_t stride, bool add)
{
    return acc + (c->state_count + (c->are_apart && add ? 1 : 0)) * stride;
}

static void level0_row(tile *t, size_t y, size_t z, float *acc, bool add)
{
    const iso_cascade *c = t->c;
    const size_t n = c->size[0][0], stride = row_stride(c, 0);
    emit_rows *r = &t->rows;
    float range[2] = {t->lo[0], t->hi[0]};
    iso_scalar_row(t->in, y, z, r->row, scalar_of(c, acc, stride, add), add && !c->are_apart, range);
    t->lo[0] = range[0], t->hi[0] = range[1];
    if (t->out[0].scalar && z >= t->out[0].first)
        memcpy(t->out[0].scalar + ((z - t->out[0].first) * c->size[0][1] + y) * n, r->row, n * sizeof(float));
    if (c->state_count == 0)
        return;
    iso_cascade_level0_gradients(c, t->in, y, z, r);
    iso_state_from_gradients(c->opt.direction_filter, 1, r->g, n, acc, stride, add);
    iso_emit_level0(c, &t->out[0], y, z, r);
}

static size_t carry_row_floats(const iso_cascade *c)
{
    return (c->state_count + 1) * c->size[c->tile_top][0];
}

static size_t carry_plane_floats(const iso_cascade *c)
{
    return carry_row_floats(c) * c->size[c->tile_top][1] + iso_cascade_cells_floats(c);
}

/* Returns row (y, z) of the level that the carry holds. */
static float *carry_row(const iso_cascade *c, size_t y, size_t z)
{
    return c->carry + z * carry_plane_floats(c) + y * carry_row_floats(c);
}

static void add_row(const tile *t, size_t k, const float *own, float *acc, bool add)
{
    const size_t stride = row_stride(t->c, k), n = t->c->size[k][0];
    const iso_cascade *c = t->c;
    for (size_t i = 0; i < c->state_count; ++i)
        iso_accumulate_row(own + i * stride, n, acc + i * stride, add);
    iso_accumulate_row(own + c->state_count * stride, n, scalar_of(c, acc, stride, add), add && !c->are_apart);
}

static void load_carried(tile *t, size_t k, size_t y, size_t z, float *own)
{
    const size_t n = t->c->size[k][0], stride = row_stride(t->c, k);
    const float *from = carry_row(t->c, y, z);
    for (size_t i = 0; i <= t->c->state_count; ++i)
        memcpy(own + i * stride, from + i * n, n * sizeof *own);
}

static void store_coarse(tile *t, size_t k, size_t y, size_t z, float *own)
{
    const iso_cascade *c = t->c;
    const iso_cascade_out *out = &t->out[k];
    const size_t n = c->size[k][0], stride = row_stride(c, k), row = (z - out->first) * c->size[k][1] + y;
    const float *scalar = own + c->state_count * stride;
    if (c->scalar_means) {
        iso_row_range(scalar, n, &t->lo[k], &t->hi[k]);
        if (out->scalar && z >= out->first)
            memcpy(out->scalar + row * n, scalar, n * sizeof *scalar);
    }
    if (c->only_sums_up)
        iso_agreement_add_row(&t->agreement[k], own, stride, n);
    else if (c->state_count > 0)
        iso_emit_coarse(c, out, k, y, z, (iso_state_row){c->opt.direction_filter, own, stride}, &t->rows);
    if (c->carry && k == c->tile_top && t->base == 0)
        for (size_t i = 0; i <= c->state_count; ++i)
            memcpy(carry_row(c, y, z) + i * n, own + i * stride, n * sizeof *own);
}

/* Makes and stores row (y, z) of level k, and sets acc to it or adds it to acc. */
static void make_row(tile *t, size_t k, size_t y, size_t z, float *acc, bool add)
{
    const iso_cascade *c = t->c;
    if (k == 0) {
        level0_row(t, y, z, acc, add);
        return;
    }
    float *own = t->own[k];
    if (k == t->base) {
        load_carried(t, k, y, z, own);
        add_row(t, k, own, acc, add);
        return;
    }
    const size_t *fine = c->size[k - 1], stride = row_stride(c, k - 1), coarse_stride = row_stride(c, k);
    const bool two_y = 2 * y + 1 < fine[1], two_z = 2 * z + 1 < fine[2];
    for (size_t half = 0; half <= (size_t)two_z; ++half) {
        float *sum = t->acc[k - 1][half];
        make_row(t, k - 1, 2 * y, 2 * z + half, sum, false);
        if (two_y)
            make_row(t, k - 1, 2 * y + 1, 2 * z + half, sum, true);
        for (size_t i = 0; !two_y && i <= c->state_count; ++i)
            iso_double_row(sum + i * stride, c->are_apart && i == c->state_count ? 0 : fine[0]);
    }
    const size_t means = c->state_count + (c->are_apart ? 0 : 1);
    for (size_t i = 0; i < means; ++i)
        iso_mean_row(t->acc[k - 1][0] + i * stride, t->acc[k - 1][two_z] + i * stride, fine[0],
                     own + i * coarse_stride);
    if (c->are_apart) {
        const float *a = t->acc[k - 1][0] + means * stride, *b = t->acc[k - 1][two_z] + means * stride;
        const size_t second = two_y ? stride : 0;
        const float *const rows[4] = {a, a + second, b, b + second};
        (c->majority ? iso_majority_row : iso_valid_mean_row)(rows, fine[0], own + means * coarse_stride);
    }
    store_coarse(t, k, y, z, own);
    if (k < t->top)
        add_row(t, k, own, acc, add);
}

static size_t tile_scratch_count(const iso_cascade *c)
{
    size_t count = iso_emit_rows_count(c);
    for (size_t k = 0; k < c->level_count; ++k)
        count += 3 * (c->state_count + 1 + c->are_apart) * row_stride(c, k);
    return count;
}

static tile make_tile(iso_cascade *c, const iso_planes *in, const iso_cascade_out *out, size_t base, size_t top,
                      float *memory)
{
    tile t = {.c = c, .in = in, .out = out, .base = base, .top = top};
    scratch s = {memory};
    t.rows = iso_take_emit_rows(c, &s);
    for (size_t k = 0; k <= top; ++k) {
        const size_t count = (c->state_count + 1 + c->are_apart) * row_stride(c, k);
        t.acc[k][0] = take(&s, count);
        t.acc[k][1] = take(&s, count);
        t.own[k] = take(&s, count);
        t.lo[k] = INFINITY;
        t.hi[k] = -INFINITY;
    }
    return t;
}

/* Rows of level `top`, planes z0 .. z1 - 1, from level `base`. */
typedef struct tile_range {
    size_t base, top, z0, z1;
} tile_range;

static iso_status run_tiles(iso_cascade *c, const iso_planes *in, const iso_cascade_out *out, tile_range range,
                            iso_error *err)
{
    const size_t base = range.base, top = range.top, z0 = range.z0, z1 = range.z1;
    const size_t rows = c->size[top][1], count = (z1 - z0) * rows, floats = tile_scratch_count(c);
    float *memory = aligned_alloc(64, (size_t)c->threads * (floats * sizeof *memory + 63) / 64 * 64);
    NEED_MEMORY(memory, err, "pyramid: no memory for the rows of %d threads", c->threads);
#pragma omp parallel num_threads(c->threads)
    {
        const size_t per_thread = floats / 16 * 16;
        tile t = make_tile(c, in, out, base, top, memory + (size_t)iso_thread_index() * per_thread);
#pragma omp for schedule(dynamic, 4)
        for (size_t i = 0; i < count; ++i)
            make_row(&t, top, i % rows, z0 + i / rows, t.acc[top][0], false);
#pragma omp critical(iso_cascade_range)
        for (size_t k = base; k <= top; ++k) {
            c->lo[k] = fminf(c->lo[k], t.lo[k]);
            c->hi[k] = fmaxf(c->hi[k], t.hi[k]);
            iso_agreement_add(&c->agreement[k], &t.agreement[k]);
        }
    }
    free(memory);
    return ISO_OK;
}

/* ---- create, feed, destroy ---- */

size_t iso_cascade_level_count(const iso_geometry *g, const iso_pyramid_options *opt)
{
    iso_geometry at = *g;
    size_t count = 1;
    for (; count < opt->level_count && count < MAX_LEVELS; ++count) {
        at = iso_geometry_coarser(&at);
        if (iso_geometry_voxel_count(&at) == 1)
            break;
    }
    return count;
}

double iso_cascade_scale(const iso_geometry *g, double range)
{
    iso_mat3 m = iso_geometry_gradient_to_world(g);
    double largest = 0;
    for (int i = 0; i < 9; ++i)
        largest = fmax(largest, fabs(m.m[i / 3][i % 3]));
    return range > 0 ? ldexp(1, -ilogb(range) - ilogb(largest)) : 1;
}

static void set_up(iso_cascade *c, const iso_geometry *g, double scale)
{
    const iso_pyramid_options *opt = &c->opt;
    iso_geometry at = *g;
    c->threads = iso_threads(opt->threads);
    c->unscale = (float)(1 / scale);
    c->matrix = iso_gradient_matrix_from(iso_mat3_scale(iso_geometry_gradient_to_world(g), scale));
    c->level_count = iso_cascade_level_count(g, opt);
    for (size_t k = 0; k < c->level_count; ++k) {
        memcpy(c->size[k], at.size, sizeof at.size);
        at = iso_geometry_coarser(&at);
        c->lo[k] = INFINITY;
        c->hi[k] = -INFINITY;
    }
    c->only_sums_up = opt->direction_filter == ISO_DIRECTION_AUTO && !opt->choice.is_made;
    c->majority = opt->scalar_filter == ISO_SCALAR_MAJORITY;
    c->are_apart = c->majority || g->has_no_data;
    c->scalar_means = opt->scalar_filter == ISO_SCALAR_MEAN || c->majority;
    c->state_count = opt->direction_filter == ISO_DIRECTION_EQ1 ? 0 : iso_state_count(opt->direction_filter);
    c->tile_top = c->level_count - 1 < CARRY_LEVEL ? c->level_count - 1 : CARRY_LEVEL;
    if (opt->scalar_filter == ISO_SCALAR_GAUSS && c->state_count == 0)
        c->tile_top = 0; /* only level 0's scalars are left */
}

/* Refuses filters and estimators that read more than a voxel's children or neighbors: they would need data there. */
static iso_status check_no_data(const iso_pyramid_options *opt, iso_error *err)
{
    if (opt->scalar_filter != ISO_SCALAR_MEAN && opt->scalar_filter != ISO_SCALAR_MAJORITY)
        return iso_fail(err, ISO_E_RANGE, "some voxels have no data: the scalar filter is %s, must be mean",
                        iso_scalar_filter_name(opt->scalar_filter));
    return opt->gradient.method == ISO_GRADIENT_CENTRAL
               ? ISO_OK
               : iso_fail(err, ISO_E_RANGE, "some voxels have no data: the estimator is %s, must be central",
                          iso_gradient_name(opt->gradient.method));
}

iso_status iso_cascade_create(const iso_geometry *g, const iso_pyramid_options *opt, double scale, iso_cascade **out,
                              iso_error *err)
{
    iso_status status = ISO_OK;
    *out = NULL;
    if (g->has_no_data && (status = check_no_data(opt, err)) != ISO_OK)
        return status;
    iso_cascade *c = calloc(1, sizeof *c);
    NEED_MEMORY(c, err, "pyramid: out of memory");
    c->opt = *opt;
    set_up(c, g, scale);
    const size_t *top = c->size[c->tile_top];
    if (c->tile_top > 0 && c->tile_top + 1 < c->level_count) {
        c->carry = malloc(carry_plane_floats(c) * top[2] * sizeof *c->carry);
        if (!c->carry)
            status = iso_fail(err, ISO_E_MEMORY, "pyramid: no memory for the state of %zu x %zu x %zu voxels", top[0],
                              top[1], top[2]);
    }
    TRY(status, iso_cascade_gauss_create(c, err));
    TRY(status, iso_cascade_spline_create(c, err));
    TRY(status, iso_cascade_weighted_create(c, err));
    if (c->weighted) /* the filter of the tiles' levels, and of those above */
        c->opt.direction_filter = ISO_DIRECTION_MOMENTS;
    if (status != ISO_OK) {
        iso_cascade_destroy(c);
        return status;
    }
    *out = c;
    return ISO_OK;
}

void iso_cascade_destroy(iso_cascade *c)
{
    if (!c)
        return;
    iso_cascade_gauss_destroy(c);
    iso_cascade_spline_destroy(c);
    iso_cascade_weighted_destroy(c);
    free(c->carry);
    free(c);
}

size_t iso_cascade_step(const iso_cascade *c)
{
    return (size_t)1 << c->tile_top;
}

size_t iso_cascade_reach(const iso_cascade *c)
{
    return iso_gradient_describe(c->opt.gradient.method)->reach;
}

float *iso_cascade_carry(const iso_cascade *c, size_t *plane_floats)
{
    *plane_floats = carry_plane_floats(c);
    return c->carry;
}

size_t iso_cascade_bytes(const iso_cascade *c)
{
    size_t floats = c->carry ? carry_plane_floats(c) * c->size[c->tile_top][2] : 0;
    for (size_t i = 0; i < c->gauss_count; ++i)
        for (size_t k = 1; k < c->level_count; ++k)
            floats += c->gauss[i].slot_count * c->gauss[i].components * c->size[k][0] * c->size[k][1];
    return (floats + iso_cascade_spline_floats(c) + iso_cascade_weighted_floats(c)) * sizeof(float);
}

size_t iso_cascade_carry_level(const iso_cascade *c)
{
    return c->tile_top;
}

size_t iso_cascade_capacity(const iso_cascade *c, size_t level, size_t plane_count)
{
    size_t planes = (plane_count >> level) + 1 + (level > 0 && c->gauss_count ? c->gauss[0].taps.count / 2 + 2 : 0);
    if (level > 0 && c->spline)
        planes += iso_cascade_spline_lag();
    if (level > 0 && c->weighted)
        planes += iso_cascade_weighted_lag();
    if (level > c->tile_top)
        planes = c->size[level][2];
    return planes < c->size[level][2] ? planes : c->size[level][2];
}

/* Returns how many planes of a level are complete after z planes of level 0, through the Gaussian filters. */
static size_t gauss_complete(const iso_cascade *c, size_t level, size_t z)
{
    for (size_t k = 0; k < level; ++k) {
        if (z == c->size[k][2])
            z = c->size[k + 1][2];
        else
            z = z > c->gauss[0].taps.count / 2 ? (z - c->gauss[0].taps.count / 2 + 1) / 2 : 0;
    }
    return z;
}

static size_t tile_complete(const iso_cascade *c, size_t level, size_t z)
{
    if (z == c->size[0][2])
        return c->size[level][2];
    return level > c->tile_top ? 0 : z >> level;
}

/* Counts a plane of a level as complete when all of its files' rows are. */
size_t iso_cascade_complete(const iso_cascade *c, size_t level, size_t z)
{
    size_t near = level == 0 || c->scalar_means || c->state_count > 0 ? tile_complete(c, level, z) : SIZE_MAX;
    size_t far = c->gauss_count > 0 ? gauss_complete(c, level, z) : SIZE_MAX;
    size_t own = c->spline ? iso_cascade_spline_complete(c, level, z) : SIZE_MAX;
    const size_t weighted = c->weighted ? iso_cascade_weighted_complete(c, level, z) : SIZE_MAX;
    near = near < far ? near : far;
    near = near < weighted ? near : weighted;
    return near < own ? near : own;
}

size_t iso_cascade_warm_up(const iso_cascade *c, size_t z)
{
    size_t from = z > 0 && c->gauss_count > 0 ? iso_cascade_gauss_from(c, z) : z;
    for (size_t k = 1; z > 0 && c->spline && k < c->level_count; ++k) {
        const size_t own = iso_cascade_spline_from(c, k, iso_cascade_complete(c, k, z));
        from = own < from ? own : from;
    }
    for (size_t k = 1; z > 0 && c->weighted && k < c->level_count; ++k) {
        const size_t own = iso_cascade_weighted_from(c, k, iso_cascade_complete(c, k, z));
        from = own < from ? own : from;
    }
    return from / iso_cascade_step(c) * iso_cascade_step(c);
}

/* Returns the first tile to make. Planes before it are stored already, and are fed for the wider filters alone. */
static size_t first_tile(const iso_cascade *c, size_t z0, size_t z1, const iso_cascade_out *out)
{
    size_t stored = SIZE_MAX;
    for (size_t k = 0; k <= c->tile_top; ++k)
        stored = out[k].first << k < stored ? out[k].first << k : stored;
    stored = stored < z1 ? stored : z1;
    return (stored > z0 ? stored : z0) / iso_cascade_step(c);
}

iso_status iso_cascade_feed(iso_cascade *c, const iso_planes *in, size_t z0, size_t z1, const iso_cascade_out *out,
                            iso_error *err)
{
    const size_t step = iso_cascade_step(c), last = c->size[0][2];
    NEED(run_tiles(c, in, out, (tile_range){0, c->tile_top, first_tile(c, z0, z1, out), (z1 + step - 1) / step}, err));
    if (c->carry && z1 == last)
        NEED(run_tiles(c, in, out, (tile_range){c->tile_top, c->level_count - 1, 0, c->size[c->level_count - 1][2]},
                       err));
    NEED(iso_cascade_gauss_feed(c, in, z0, z1, out, err));
    NEED(iso_cascade_spline_feed(c, in, z0, z1, out, err));
    return iso_cascade_weighted_feed(c, in, z0, z1, out, err);
}

void iso_cascade_get_agreement(const iso_cascade *c, size_t level, iso_agreement *sums)
{
    *sums = c->agreement[level];
}

void iso_cascade_add_agreement(iso_cascade *c, size_t level, const iso_agreement *sums)
{
    iso_agreement_add(&c->agreement[level], sums);
}

void iso_cascade_choose(const iso_cascade *c, iso_direction_choice *choice)
{
    iso_agreement_choose(c->agreement, c->level_count - 1, choice);
}

void iso_cascade_range(const iso_cascade *c, size_t level, double *min, double *max)
{
    *min = c->lo[level];
    *max = c->hi[level];
}

void iso_cascade_set_range(iso_cascade *c, size_t level, double min, double max)
{
    c->lo[level] = (float)min;
    c->hi[level] = (float)max;
}

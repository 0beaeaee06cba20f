/* SPDX-License-Identifier: MIT */
#include "bake/bake.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "brick/occupancy.h"
#include "render/reference_ray.h"

enum { PAD = 1, SIDE = ISO_BAKE_BLOCK, CHANNELS = ISO_BAKE_CHANNELS };
static const float no_color = -1;

iso_bake_options iso_bake_defaults(void)
{
    return (iso_bake_options){.points = 1, .samples = 2};
}

static size_t block_count(const iso_baked *b)
{
    return b->blocks[0] * b->blocks[1] * b->blocks[2];
}

/* Makes the lattice's geometry: `points` per voxel side, a rim of one point, x reversed if the level is left-handed. */
static iso_geometry lattice_of(const iso_geometry *g, size_t points, bool reversed)
{
    iso_geometry l = *g;
    iso_vec3 corner = iso_v3(reversed ? (double)g->size[0] : 0, 0, 0);
    l.index_to_world = iso_mat3_scale(g->index_to_world, 1.0 / (double)points);
    for (int r = 0; reversed && r < 3; ++r)
        l.index_to_world.m[r][0] = -l.index_to_world.m[r][0];
    for (int a = 0; a < 3; ++a) {
        l.size[a] = points * g->size[a] + 2 * PAD;
        l.box_index[a] = (double)l.size[a];
    }
    l.origin_mm = iso_sub(iso_geometry_to_world(g, corner), iso_mul(l.index_to_world, iso_v3(PAD, PAD, PAD)));
    return l;
}

iso_vec3 iso_baked_in_level(const iso_baked *b, iso_vec3 index)
{
    const double scale = 1.0 / (double)b->options.points;
    iso_vec3 p = iso_scale(iso_sub(index, iso_v3(PAD, PAD, PAD)), scale);
    if (b->reversed_x)
        p.x = (double)b->level->geometry.size[0] - p.x;
    return p;
}

static double clamp01(double v)
{
    return v > 0 ? (v < 1 ? v : 1) : 0;
}

/* Returns the part of a point's cell inside the box and the clip planes. p: index coordinates of the level. */
static double kept_part(const iso_baked *b, iso_vec3 p)
{
    const iso_geometry *g = &b->level->geometry;
    const double at[3] = {p.x, p.y, p.z}, n = (double)b->options.points;
    double part = 1;
    for (int a = 0; a < 3; ++a)
        part *= clamp01(at[a] * n + 0.5) * clamp01((g->box_index[a] - at[a]) * n + 0.5);
    for (size_t i = 0; i < b->view->clip_count && part > 0; ++i) {
        double plane[4];
        iso_clip_in_index(&b->view->clips[i], g, plane);
        const double width = fabs(plane[0]) + fabs(plane[1]) + fabs(plane[2]); /* of a voxel along the normal */
        const double depth = plane[0] * p.x + plane[1] * p.y + plane[2] * p.z - plane[3];
        part *= clamp01(depth * n / width + 0.5);
    }
    return part;
}

static double place_of(const iso_baked *b, double value)
{
    const iso_tf_table *tf = b->view->tf_2d ? &b->view->tf_2d->rows[0] : &b->view->tf;
    return clamp01((value - tf->lo) / (tf->hi - tf->lo));
}

/* Returns the shade of a sample in the view, or 1 for unshaded colors. p: index coordinates of the level. */
static double shade_of(const iso_baked *b, const iso_sampler *sampler, iso_vec3 p)
{
    if (!b->options.shaded)
        return 1;
    const iso_camera *camera = &b->view->camera;
    const iso_vec3 away = camera->orthographic
                              ? camera->forward
                              : iso_sub(iso_geometry_to_world(&b->level->geometry, p), camera->position);
    const double length = sqrt(iso_dot(away, away));
    const iso_vec3 to_viewer = length > 0 ? iso_scale(away, -1 / length) : iso_scale(camera->forward, -1);
    return iso_shade(b->view, iso_sample_normal(sampler, p), to_viewer);
}

/* Averages a point's samples: extinction, and color weighted by extinction. index: in the lattice. */
static void bake_point(const iso_baked *b, const iso_sampler *sampler, iso_vec3 index, float out[CHANNELS])
{
    const size_t n = b->options.samples;
    const double count = (double)(n * n * n), part = kept_part(b, iso_baked_in_level(b, index));
    double sum[CHANNELS] = {0};
    for (size_t i = 0; i < n * n * n; ++i) {
        const double at[3] = {(double)(i % n), (double)(i / n % n), (double)(i / n / n)}, half = 0.5 * (double)n - 0.5;
        const iso_vec3 q = iso_v3(index.x + (at[0] - half) / (double)n, index.y + (at[1] - half) / (double)n,
                                  index.z + (at[2] - half) / (double)n);
        const iso_vec3 p = iso_baked_in_level(b, q);
        double rgbs[4];
        const double value = part > 0 ? iso_reference_classify(sampler, b->view, p, rgbs)
                                      : iso_sample_scalar(sampler, p);
        sum[ISO_BAKE_PLACE] += place_of(b, value) / count;
        if (part <= 0 || !(rgbs[3] > 0))
            continue;
        const double shade = shade_of(b, sampler, p);
        sum[ISO_BAKE_EXTINCTION] += rgbs[3];
        for (int c = 0; c < 3; ++c)
            sum[ISO_BAKE_COLOR + c] += rgbs[3] * rgbs[c] * shade;
    }
    const double extinction = (double)(float)(part * sum[ISO_BAKE_EXTINCTION] / count); /* 0 if too small for a float */
    out[ISO_BAKE_EXTINCTION] = (float)extinction;
    out[ISO_BAKE_PLACE] = (float)sum[ISO_BAKE_PLACE];
    for (int c = 0; c < 3; ++c)
        out[ISO_BAKE_COLOR + c] = extinction > 0 ? (float)(sum[ISO_BAKE_COLOR + c] / sum[ISO_BAKE_EXTINCTION])
                                                 : no_color;
}

/* ---- blocks --------------------------------------------------------------------------------------------------- */

typedef struct block_place {
    size_t number, first[3], end[3]; /* points, within the lattice */
} block_place;

static block_place place_of_block(const iso_baked *b, size_t number)
{
    const size_t at[3] = {number % b->blocks[0], number / b->blocks[0] % b->blocks[1],
                          number / b->blocks[0] / b->blocks[1]};
    block_place p = {.number = number};
    for (int a = 0; a < 3; ++a) {
        p.first[a] = SIDE * at[a];
        p.end[a] = p.first[a] + SIDE < b->geometry.size[a] ? p.first[a] + SIDE : b->geometry.size[a];
    }
    return p;
}

static float *within(float *block, size_t x, size_t y, size_t z)
{
    return block + CHANNELS * (x % SIDE + SIDE * (y % SIDE + SIDE * (z % SIDE)));
}

static size_t block_of(const iso_baked *b, size_t x, size_t y, size_t z)
{
    return x / SIDE + b->blocks[0] * (y / SIDE + b->blocks[1] * (z / SIDE));
}

const float *iso_baked_point(const iso_baked *b, size_t x, size_t y, size_t z)
{
    float *block = b->block[block_of(b, x, y, z)];
    return block ? within(block, x, y, z) : NULL;
}

/* Finds [lo, hi) along one axis of the level: the voxels around the samples from a to b, and one more on each side. */
static void voxels_between(double a, double b, size_t size, size_t *lo, size_t *hi)
{
    const double first = floor(fmin(a, b) - 0.5) - 1, past = floor(fmax(a, b) - 0.5) + 3, last = (double)size - 1;
    *lo = (size_t)(first > 0 ? fmin(first, last) : 0);
    *hi = (size_t)(past < last + 1 ? fmax(past, 1) : last + 1);
}

/* True if the transfer function may show a value between those of the voxels around a block. Most blocks show nothing,
 * and are not sampled. Always true for a 2D one, whose second value is not tested. */
static bool may_show(const iso_baked *b, const block_place *p)
{
    const size_t *n = b->level->geometry.size;
    const iso_vec3 from = iso_baked_in_level(b, iso_v3((double)p->first[0], (double)p->first[1], (double)p->first[2]));
    const iso_vec3 to = iso_baked_in_level(b, iso_v3((double)p->end[0], (double)p->end[1], (double)p->end[2]));
    const double ends[3][2] = {{from.x, to.x}, {from.y, to.y}, {from.z, to.z}};
    size_t lo[3], hi[3];
    float min = INFINITY, max = -INFINITY;
    for (int a = 0; a < 3; ++a)
        voxels_between(ends[a][0], ends[a][1], n[a], &lo[a], &hi[a]);
    for (size_t z = lo[2]; z < hi[2]; ++z)
        for (size_t y = lo[1]; y < hi[1]; ++y)
            for (size_t x = lo[0]; x < hi[0]; ++x) {
                const float value = b->level->scalar[x + n[0] * (y + n[1] * z)];
                min = value < min ? value : min;
                max = value > max ? value : max;
            }
    return b->view->tf_2d || iso_tf_shows(&b->view->tf, (double)min, (double)max);
}

static bool fill_block(const iso_baked *b, const iso_sampler *sampler, const block_place *p, float *block)
{
    bool shows = false;
    for (size_t z = p->first[2]; z < p->end[2]; ++z)
        for (size_t y = p->first[1]; y < p->end[1]; ++y)
            for (size_t x = p->first[0]; x < p->end[0]; ++x) {
                float *point = within(block, x, y, z);
                bake_point(b, sampler, iso_v3((double)x + 0.5, (double)y + 0.5, (double)z + 0.5), point);
                shows |= point[ISO_BAKE_EXTINCTION] > 0;
            }
    return shows;
}

/* Computes the mean color of the visible points among a point's 26 neighbors, weighted by extinction. False if there is
 * none. Reads only visible points, which no thread changes meanwhile. */
static bool color_of_neighbors(const iso_baked *b, const size_t at[3], float color[3])
{
    double sum[4] = {0};
    size_t lo[3], hi[3];
    for (int a = 0; a < 3; ++a) {
        lo[a] = at[a] > 0 ? at[a] - 1 : 0;
        hi[a] = at[a] + 1 < b->geometry.size[a] ? at[a] + 1 : at[a];
    }
    for (size_t z = lo[2]; z <= hi[2]; ++z)
        for (size_t y = lo[1]; y <= hi[1]; ++y)
            for (size_t x = lo[0]; x <= hi[0]; ++x) {
                const float *p = iso_baked_point(b, x, y, z);
                const double extinction = p ? (double)p[ISO_BAKE_EXTINCTION] : 0;
                if (!(extinction > 0))
                    continue;
                sum[3] += extinction;
                for (int c = 0; c < 3; ++c)
                    sum[c] += extinction * (double)p[ISO_BAKE_COLOR + c];
            }
    for (int c = 0; c < 3 && sum[3] > 0; ++c)
        color[c] = (float)(sum[c] / sum[3]);
    return sum[3] > 0;
}

/* Colors the transparent points of a block. True if it colored any. */
static bool color_block(const iso_baked *b, const block_place *p, float *block)
{
    bool any = false;
    for (size_t z = p->first[2]; z < p->end[2]; ++z)
        for (size_t y = p->first[1]; y < p->end[1]; ++y)
            for (size_t x = p->first[0]; x < p->end[0]; ++x) {
                float *point = within(block, x, y, z);
                if (!(point[ISO_BAKE_EXTINCTION] > 0))
                    any |= color_of_neighbors(b, (const size_t[3]){x, y, z}, point + ISO_BAKE_COLOR);
            }
    return any;
}

/* True if a neighbor of a block has extinction: then a block without extinction may have points to color. */
static bool has_neighbor(const iso_baked *b, size_t number)
{
    const size_t *n = b->blocks, at[3] = {number % n[0], number / n[0] % n[1], number / n[0] / n[1]};
    for (int i = 0; i < 27; ++i) {
        const size_t x = at[0] + (size_t)(i % 3), y = at[1] + (size_t)(i / 3 % 3), z = at[2] + (size_t)(i / 9);
        if (x >= 1 && x <= n[0] && y >= 1 && y <= n[1] && z >= 1 && z <= n[2] &&
            b->block[x - 1 + n[0] * (y - 1 + n[1] * (z - 1))])
            return true;
    }
    return false;
}

enum { BLOCK_FLOATS = CHANNELS * SIDE * SIDE * SIDE };

static float *copy_block(const float *block)
{
    float *copy = malloc(BLOCK_FLOATS * sizeof *copy);
    if (copy)
        memcpy(copy, block, BLOCK_FLOATS * sizeof *copy);
    return copy;
}

static void start_block(float *block)
{
    for (size_t i = 0; i < BLOCK_FLOATS; ++i)
        block[i] = i % CHANNELS >= ISO_BAKE_COLOR && i % CHANNELS < ISO_BAKE_PLACE ? no_color : 0;
}

/* Bakes extinction and color, then colors the points next to visible ones. Each block is written by one thread only. */
static bool bake_blocks(iso_baked *b, const iso_sampler *sampler, const iso_progress *progress)
{
    const size_t count = block_count(b);
    const int threads = iso_threads(b->options.threads);
    float **rim = calloc(count, sizeof *rim);
    bool failed = !rim;
    size_t done = 0;
#pragma omp parallel for schedule(dynamic, 16) num_threads(threads) reduction(|| : failed)
    for (size_t i = 0; i < count; ++i) {
        float block[BLOCK_FLOATS];
        const block_place place = place_of_block(b, i);
        start_block(block);
        if (!failed && !iso_progress_poll(progress) && may_show(b, &place) && fill_block(b, sampler, &place, block))
            failed |= !(b->block[i] = copy_block(block));
        if (i % 256 == 0) {
#pragma omp critical(iso_bake_progress)
            iso_progress_report(progress, "baking", (double)(done += 256) / (double)(count + 256));
        }
    }
    failed = failed || iso_progress_poll(progress);
#pragma omp parallel for schedule(dynamic, 16) num_threads(threads) reduction(|| : failed)
    for (size_t i = 0; i < count; ++i) {
        float block[BLOCK_FLOATS];
        const block_place place = place_of_block(b, i);
        failed |= iso_progress_poll(progress);
        if (failed || (!b->block[i] && !has_neighbor(b, i)))
            continue;
        if (b->block[i]) {
            color_block(b, &place, b->block[i]);
            continue;
        }
        start_block(block);
        fill_block(b, sampler, &place, block);
        if (color_block(b, &place, block))
            failed |= !(rim[i] = copy_block(block));
    }
    for (size_t i = 0; rim && i < count; ++i)
        b->block[i] = b->block[i] ? b->block[i] : rim[i];
    free(rim);
    return !failed;
}

static void count_points(iso_baked *b)
{
    for (size_t i = 0; i < block_count(b); ++i)
        for (size_t k = 0; b->block[i] && k < BLOCK_FLOATS; k += CHANNELS) {
            const float *p = b->block[i] + k;
            b->visible_count += p[ISO_BAKE_EXTINCTION] > 0;
            b->color_count += p[ISO_BAKE_COLOR] >= 0;
            b->extinction_max = fmax(b->extinction_max, (double)p[ISO_BAKE_EXTINCTION]);
            for (int c = 0; c < 3; ++c)
                b->color_max[c] = fmax(b->color_max[c], (double)p[ISO_BAKE_COLOR + c]);
        }
}

static iso_status check(const iso_level *level, const iso_view *view, const iso_bake_options *opt, iso_error *err)
{
    if (opt->points < 1 || opt->points > ISO_BAKE_MOST_POINTS || opt->samples < 1 ||
        opt->samples > ISO_BAKE_MOST_POINTS)
        return iso_fail(err, ISO_E_RANGE, "bake: %zu points and %zu samples along a side, each must be 1 to %d",
                        opt->points, opt->samples, ISO_BAKE_MOST_POINTS);
    if (view->roi)
        return iso_fail(err, ISO_E_RANGE, "bake: a region of interest cannot be baked");
    for (int a = 0; a < 3; ++a)
        if (level->geometry.size[a] > (size_t)INT_MAX / opt->points - 2 * PAD)
            return iso_fail(err, ISO_E_RANGE, "bake: %zu points for each of %zu voxels, OpenVDB takes at most %d",
                            opt->points, level->geometry.size[a], INT_MAX);
    return ISO_OK;
}

iso_status iso_bake(const iso_level *level, iso_code code, const iso_view *view, const iso_bake_options *opt,
                    iso_baked *out, const iso_progress *progress, iso_error *err)
{
    *out = (iso_baked){0};
    NEED(check(level, view, opt, err));
    iso_baked b = {.level = level, .view = view, .code = code, .options = *opt};
    b.reversed_x = iso_mat3_det(level->geometry.index_to_world) < 0;
    b.geometry = lattice_of(&level->geometry, opt->points, b.reversed_x);
    for (int a = 0; a < 3; ++a)
        b.blocks[a] = (b.geometry.size[a] + SIDE - 1) / SIDE;
    iso_sampler sampler = {0};
    iso_status status = iso_geometry_check(&b.geometry, "bake", err);
    if (status == ISO_OK && !(b.block = calloc(block_count(&b), sizeof *b.block)))
        status = iso_fail(err, ISO_E_MEMORY, "bake: no memory for %zu blocks", block_count(&b));
    TRY(status, iso_sampler_create(&sampler, level, code, opt->shaded ? ISO_FROM_CODES : ISO_FROM_ON_THE_FLY, err));
    if (status == ISO_OK && !bake_blocks(&b, &sampler, progress))
        status = iso_fail(err, ISO_E_MEMORY, "bake: out of memory; a coarser --level, or fewer points, need less");
    iso_sampler_destroy(&sampler);
    if (status == ISO_OK)
        count_points(&b);
    else
        iso_baked_destroy(&b);
    *out = b;
    return status;
}

void iso_baked_destroy(iso_baked *b)
{
    if (!b)
        return;
    for (size_t i = 0; b->block && i < block_count(b); ++i)
        free(b->block[i]);
    free(b->block);
    *b = (iso_baked){0};
}

/* ---- between the points --------------------------------------------------------------------------------------- */

double iso_baked_sample(const iso_baked *b, iso_baked_pair pair, iso_vec3 index, double color[3])
{
    const double p[3] = {index.x - 0.5, index.y - 0.5, index.z - 0.5};
    double low[3], f[3], extinction = 0, sum[3] = {0};
    for (int a = 0; a < 3; ++a) {
        low[a] = floor(p[a]);
        f[a] = p[a] - low[a];
    }
    for (int i = 0; i < 8; ++i) {
        const int up[3] = {i & 1, i >> 1 & 1, i >> 2};
        size_t at[3];
        double weight = 1;
        for (int a = 0; a < 3; ++a) {
            weight *= up[a] ? f[a] : 1 - f[a];
            at[a] = (size_t)(low[a] + up[a] < 0 ? -1 : low[a] + up[a]);
            if (low[a] + up[a] < 0 || at[a] >= b->geometry.size[a])
                weight = 0;
        }
        const float *v = weight > 0 ? iso_baked_point(b, at[0], at[1], at[2]) : NULL;
        if (!v || v[ISO_BAKE_COLOR] < 0)
            continue;
        const double here = (double)v[ISO_BAKE_EXTINCTION];
        extinction += weight * here;
        for (int c = 0; c < 3; ++c)
            sum[c] += weight * (double)v[ISO_BAKE_COLOR + c] * (pair == ISO_BAKED_EMISSION ? here : 1);
    }
    for (int c = 0; c < 3; ++c)
        color[c] = pair == ISO_BAKED_EMISSION ? sum[c] : extinction * sum[c];
    return extinction;
}

/* SPDX-License-Identifier: MIT */
#include "brick/bricks.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"

/* ---- the nodes of every level ------------------------------------------------ */

/* Nodes along an axis at a level: bricks share their faces. */
static size_t node_count(const iso_node_levels *n, size_t level, int axis)
{
    return n->count[axis] * (n->brick_voxels >> level) + 1;
}

static size_t all_nodes(const iso_node_levels *n, size_t level)
{
    return node_count(n, level, 0) * node_count(n, level, 1) * node_count(n, level, 2);
}

static size_t least(size_t a, size_t b)
{
    return a < b ? a : b;
}

/* Scalar and moments (m^2 d, 3 values; m^2 is their length, so S starts as |N|) of the nodes of the planes [z0, z1), of
 * which the gradients are, or NULL. Gradients are taken in ranges a voxel, so that their squares neither overflow nor
 * vanish. */
static void fill_planes(iso_node_levels *n, const float *scalar, const float *gradients, size_t z0, size_t z1,
                        float *moment_sums, int threads)
{
    double range = n->max - n->min;
    float unit = (float)(range > 0 ? iso_geometry_min_spacing_mm(&n->geometry) / range : 1);
    const size_t *size = n->geometry.size, nx = node_count(n, 0, 0), ny = node_count(n, 0, 1);
    /* The last plane is repeated to fill whole bricks. */
    const size_t end = z1 < size[2] ? z1 : node_count(n, 0, 2), first = size[0] * size[1] * z0;
#pragma omp parallel for schedule(static) num_threads(threads)
    for (size_t z = z0; z < end; ++z)
        for (size_t y = 0; y < ny; ++y)
            for (size_t x = 0; x < nx; ++x) {
                size_t v = least(x, size[0] - 1) + size[0] * (least(y, size[1] - 1) + size[1] * least(z, size[2] - 1));
                size_t i = x + nx * (y + ny * z);
                float *node = n->nodes[0] + ISO_NODE_CHANNELS * i;
                node[0] = scalar[v];
                node[1] = node[2] = node[3] = 0;
                if (!gradients)
                    continue;
                const float *from = gradients + 3 * (v - first),
                            g[3] = {unit * from[0], unit * from[1], unit * from[2]};
                float m = sqrtf(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]);
                for (int a = 0; a < 3; ++a)
                    node[1 + a] = m * g[a];
                moment_sums[i] = m * m;
            }
}

/* One coarse node: [1 2 1]^3 / 64 round its place, continued by the edge, of the channels and of the moments' sum. */
static void filter_node(const size_t size[3], const float *fine, const float *fine_sums, const size_t at[3],
                        float *node, float *sum)
{
    float total[ISO_NODE_CHANNELS] = {0}, s = 0;
    for (int o = 0; o < 27; ++o) {
        const int d[3] = {o % 3 - 1, o / 3 % 3 - 1, o / 9 - 1};
        size_t p[3];
        float weight = 1;
        for (int a = 0; a < 3; ++a) {
            size_t c = 2 * at[a];
            p[a] = d[a] < 0 ? (c > 0 ? c - 1 : 0) : d[a] > 0 ? least(c + 1, size[a] - 1) : c;
            weight *= d[a] ? 0.25f : 0.5f;
        }
        size_t i = p[0] + size[0] * (p[1] + size[1] * p[2]);
        for (int c = 0; c < ISO_NODE_CHANNELS; ++c)
            total[c] += weight * fine[ISO_NODE_CHANNELS * i + (size_t)c];
        if (fine_sums)
            s += weight * fine_sums[i];
    }
    memcpy(node, total, sizeof total);
    if (fine_sums)
        *sum = s;
}

/* The scalar of one coarse node by [-1 2 6 2 -1]^3 / 512, the low-pass of the 5/3 wavelets [le-gall-1988]:
 * its samples are those from which linear interpolation comes nearest to the fine ones. Held within the range of the 27
 * nodes around, so that nothing is shown that is not there. */
static float filter_scalar(const size_t size[3], const float *fine, const size_t at[3])
{
    static const float weights[5] = {-0.125f, 0.25f, 0.75f, 0.25f, -0.125f};
    size_t p[3][5];
    for (int a = 0; a < 3; ++a)
        for (size_t d = 0; d < 5; ++d)
            p[a][d] = least(2 * at[a] + d > 2 ? 2 * at[a] + d - 2 : 0, size[a] - 1);
    float sum = 0, lowest = INFINITY, highest = -INFINITY;
    for (size_t z = 0; z < 5; ++z)
        for (size_t y = 0; y < 5; ++y) {
            const float *row = fine + ISO_NODE_CHANNELS * size[0] * (p[1][y] + size[1] * p[2][z]);
            const bool near = y > 0 && y < 4 && z > 0 && z < 4;
            float along = 0;
            for (size_t x = 0; x < 5; ++x) {
                const float value = row[ISO_NODE_CHANNELS * p[0][x]];
                along += weights[x] * value;
                if (near && x > 0 && x < 4) {
                    lowest = value < lowest ? value : lowest; /* fminf() is a call */
                    highest = value > highest ? value : highest;
                }
            }
            sum += weights[y] * weights[z] * along;
        }
    return fminf(fmaxf(sum, lowest), highest);
}

static void filter_level(iso_node_levels *n, size_t level, const float *fine_sums, float *sums, int threads)
{
    const size_t fine[3] = {node_count(n, level - 1, 0), node_count(n, level - 1, 1), node_count(n, level - 1, 2)};
    const size_t nx = node_count(n, level, 0), ny = node_count(n, level, 1), nz = node_count(n, level, 2);
#pragma omp parallel for schedule(static) num_threads(threads)
    for (size_t z = 0; z < nz; ++z)
        for (size_t y = 0; y < ny; ++y)
            for (size_t x = 0; x < nx; ++x) {
                const size_t i = x + nx * (y + ny * z), at[3] = {x, y, z};
                float *node = n->nodes[level] + ISO_NODE_CHANNELS * i;
                filter_node(fine, n->nodes[level - 1], fine_sums, at, node, sums + (fine_sums ? i : 0));
                if (n->filter == ISO_NODES_SHARP)
                    node[0] = filter_scalar(fine, n->nodes[level - 1], at);
            }
}

/* Moments to directions, once every level has been made from them. */
static void moments_to_directions(float *nodes, const float *sums, size_t count, int threads)
{
#pragma omp parallel for schedule(static) num_threads(threads)
    for (size_t i = 0; i < count; ++i) {
        float *d = nodes + ISO_NODE_CHANNELS * i + 1;
        double norm = sqrt((double)d[0] * d[0] + (double)d[1] * d[1] + (double)d[2] * d[2]);
        double length = sums[i] > 0 ? norm / (double)sums[i] : 0;
        double scale = norm > 0 ? length * length / norm : 0;
        for (int a = 0; a < 3; ++a)
            d[a] = (float)(d[a] * scale);
    }
}

/* Level 0: the gradients of some planes at a time, which would else be three times as large as the volume. */
static iso_status fill_level0(iso_node_levels *n, const iso_level *level, bool with_directions, float *moment_sums,
                              int threads, iso_error *err)
{
    enum { SLAB_BYTES = 1 << 24 };
    const size_t *size = level->geometry.size, plane = 3 * size[0] * size[1];
    const size_t most = SLAB_BYTES / (plane * sizeof(float)),
                 slab = most > 4 ? least(most, size[2]) : least(4, size[2]);
    const iso_volume v = {.geometry = level->geometry, .type = ISO_F32, .data = level->scalar};
    iso_gradient_options opt = iso_gradient_defaults();
    opt.threads = threads;
    if (!with_directions) {
        fill_planes(n, level->scalar, NULL, 0, size[2], moment_sums, threads);
        return ISO_OK;
    }
    float *gradients = malloc(plane * slab * sizeof *gradients);
    if (!gradients)
        return iso_fail(err, ISO_E_MEMORY, "bricks: no memory for the gradients of %zu planes", slab);
    iso_status status = ISO_OK;
    for (size_t z = 0; z < size[2] && status == ISO_OK; z += slab) {
        const size_t end = least(z + slab, size[2]);
        status = iso_gradient_slab(&v, &opt, z, end, gradients, err);
        if (status == ISO_OK)
            fill_planes(n, level->scalar, gradients, z, end, moment_sums, threads);
    }
    free(gradients);
    return status;
}

static iso_status check(size_t brick_voxels, size_t level_count, iso_error *err)
{
    if (brick_voxels < 2 || brick_voxels > 64 || (brick_voxels & (brick_voxels - 1)))
        return iso_fail(err, ISO_E_RANGE, "bricks of %zu voxels, must be a power of two from 2 to 64", brick_voxels);
    if (level_count < 1 || level_count > ISO_BRICK_MAX_LEVELS || brick_voxels >> (level_count - 1) == 0)
        return iso_fail(err, ISO_E_RANGE, "%zu levels in bricks of %zu voxels, at most log2 of the side and one",
                        level_count, brick_voxels);
    return ISO_OK;
}

/* A level's moments become directions when the next coarser level has been made from them. */
static iso_status fill_levels(iso_node_levels *n, const iso_level *level0, bool with_directions, int threads,
                              iso_error *err)
{
    float *fine = NULL, none = 0;
    iso_status status = ISO_OK;
    for (size_t l = 0; l < n->level_count && status == ISO_OK; ++l) {
        float *sums = with_directions ? malloc(all_nodes(n, l) * sizeof *sums) : &none;
        if (!sums)
            status = iso_fail(err, ISO_E_MEMORY, "bricks: no memory for %zu nodes", all_nodes(n, l));
        else if (l == 0)
            status = fill_level0(n, level0, with_directions, sums, threads, err);
        else
            filter_level(n, l, fine, sums, threads);
        if (!with_directions)
            continue;
        if (l > 0)
            moments_to_directions(n->nodes[l - 1], fine, all_nodes(n, l - 1), threads);
        free(fine);
        fine = sums;
    }
    if (status == ISO_OK && with_directions)
        moments_to_directions(n->nodes[n->level_count - 1], fine, all_nodes(n, n->level_count - 1), threads);
    free(fine);
    return status;
}

/* Sizes, and room for all nodes. */
static iso_status lay_out(iso_node_levels *n, const iso_level *level0, size_t brick_voxels, size_t level_count,
                          iso_error *err)
{
    *n = (iso_node_levels){.geometry = level0->geometry,
                           .min = level0->min,
                           .max = level0->max,
                           .brick_voxels = brick_voxels,
                           .level_count = level_count};
    iso_status status = check(brick_voxels, level_count, err);
    if (status != ISO_OK)
        return status;
    for (int a = 0; a < 3; ++a) {
        size_t cells = level0->geometry.size[a] - 1;
        n->count[a] = cells > 0 ? (cells + brick_voxels - 1) / brick_voxels : 1;
    }
    for (size_t l = 0; l < level_count; ++l)
        if (!(n->nodes[l] = malloc(ISO_NODE_CHANNELS * all_nodes(n, l) * sizeof **n->nodes))) {
            status = iso_fail(err, ISO_E_MEMORY, "bricks: no memory for %zu nodes", all_nodes(n, l));
            iso_node_levels_destroy(n);
            return status;
        }
    return ISO_OK;
}

iso_status iso_node_levels_create(iso_node_levels *n, const iso_level *level0, size_t brick_voxels, size_t level_count,
                                  bool with_directions, int threads, iso_error *err)
{
    const iso_node_options opt = {brick_voxels, level_count, ISO_NODES_SHARP, with_directions, threads};
    return iso_node_levels_create_by(n, level0, &opt, err);
}

iso_status iso_node_levels_create_by(iso_node_levels *n, const iso_level *level0, const iso_node_options *opt,
                                     iso_error *err)
{
    iso_status status = lay_out(n, level0, opt->brick_voxels, opt->level_count, err);
    if (status != ISO_OK)
        return status;
    n->filter = opt->filter;
    status = fill_levels(n, level0, opt->with_directions, iso_threads(opt->threads), err);
    if (status != ISO_OK)
        iso_node_levels_destroy(n);
    return status;
}

/* Where a node of a level lies among the level's cells, along an axis: the four cells around and their weights, of the
 * cubic through them [catmull-1974], or linear in the two in the middle. */
typedef struct cell_stencil {
    size_t cell[4];
    float cubic[4], linear[4];
} cell_stencil;

static cell_stencil among_cells(size_t node, size_t level, size_t size)
{
    const double x = (double)node + ldexp(0.5, -(int)level) - 0.5, low = floor(x);
    const float t = (float)(x - low);
    cell_stencil s = {.cubic = {0.5f * t * (-1 + t * (2 - t)), 1 + 0.5f * t * t * (3 * t - 5),
                                0.5f * t * (1 + t * (4 - 3 * t)), 0.5f * t * t * (t - 1)},
                      .linear = {0, 1 - t, t, 0}};
    for (int i = 0; i < 4; ++i)
        s.cell[i] = (size_t)fmin(fmax(low + i - 1, 0), (double)(size - 1));
    return s;
}

/* The scalar by the cubic, held within the range of the eight cells around; the direction linear. */
static void node_from_cells(const iso_level *level, const float *directions, const cell_stencil s[3],
                            float node[ISO_NODE_CHANNELS])
{
    const size_t *size = level->geometry.size;
    float lowest = INFINITY, highest = -INFINITY;
    memset(node, 0, ISO_NODE_CHANNELS * sizeof *node);
    for (size_t z = 0; z < 4; ++z)
        for (size_t y = 0; y < 4; ++y)
            for (size_t x = 0; x < 4; ++x) {
                const size_t v = s[0].cell[x] + size[0] * (s[1].cell[y] + size[1] * s[2].cell[z]);
                const float weight = s[0].linear[x] * s[1].linear[y] * s[2].linear[z];
                node[0] += s[0].cubic[x] * s[1].cubic[y] * s[2].cubic[z] * level->scalar[v];
                if (weight == 0)
                    continue;
                lowest = fminf(lowest, level->scalar[v]);
                highest = fmaxf(highest, level->scalar[v]);
                for (size_t a = 0; a < 3; ++a)
                    node[1 + a] += weight * directions[3 * v + a];
            }
    node[0] = fminf(fmaxf(node[0], lowest), highest);
}

iso_status iso_node_levels_create_from_cells(iso_node_levels *n, const iso_pyramid *p, size_t brick_voxels,
                                             size_t level_count, int threads, iso_error *err)
{
    if (level_count > p->level_count)
        return iso_fail(err, ISO_E_RANGE, "bricks: %zu levels are asked for, the pyramid has %zu", level_count,
                        p->level_count);
    iso_status status = lay_out(n, &p->levels[0], brick_voxels, level_count, err);
    for (size_t l = 0; l < level_count && status == ISO_OK; ++l) {
        const iso_level *level = &p->levels[l];
        const size_t *size = level->geometry.size, voxels = iso_geometry_voxel_count(&level->geometry);
        const size_t nx = node_count(n, l, 0), ny = node_count(n, l, 1), nz = node_count(n, l, 2);
        float *directions = malloc(3 * voxels * sizeof *directions);
        if (!directions) {
            status = iso_fail(err, ISO_E_MEMORY, "bricks: no memory for %zu directions", voxels);
            break;
        }
        iso_code_decode_all(p->options.code, level->codes, directions, voxels);
#pragma omp parallel for schedule(static) num_threads(iso_threads(threads))
        for (size_t z = 0; z < nz; ++z)
            for (size_t y = 0; y < ny; ++y)
                for (size_t x = 0; x < nx; ++x) {
                    const cell_stencil s[3] = {among_cells(x, l, size[0]), among_cells(y, l, size[1]),
                                               among_cells(z, l, size[2])};
                    node_from_cells(level, directions, s, n->nodes[l] + ISO_NODE_CHANNELS * (x + nx * (y + ny * z)));
                }
        free(directions);
    }
    if (status != ISO_OK)
        iso_node_levels_destroy(n);
    return status;
}

void iso_node_levels_round(iso_node_levels *n)
{
    double step = n->max > n->min ? (n->max - n->min) / 65535 : 1;
    for (size_t l = 0; l < n->level_count; ++l) {
        const size_t count = all_nodes(n, l);
#pragma omp parallel for schedule(static) num_threads(iso_threads(0))
        for (size_t i = 0; i < count; ++i) {
            float *node = n->nodes[l] + ISO_NODE_CHANNELS * i;
            node[0] = (float)(n->min + step * rint(((double)node[0] - n->min) / step));
            for (int a = 1; a < ISO_NODE_CHANNELS; ++a)
                node[a] = (float)(rint(32767 * (double)node[a]) / 32767);
        }
    }
}

void iso_node_levels_encode(iso_node_levels *n, iso_code code)
{
    enum { batch = 256 };
    for (size_t l = 0; l < n->level_count; ++l) {
        size_t count = all_nodes(n, l);
#pragma omp parallel for schedule(static) num_threads(iso_threads(0))
        for (size_t first = 0; first < count; first += batch) {
            size_t m = least(batch, count - first);
            float *nodes = n->nodes[l] + ISO_NODE_CHANNELS * first, directions[3 * batch];
            uint8_t bytes[6 * batch];
            for (size_t i = 0; i < m; ++i)
                memcpy(directions + 3 * i, nodes + ISO_NODE_CHANNELS * i + 1, 3 * sizeof *directions);
            iso_code_encode(code, directions, bytes, m);
            iso_code_decode_all(code, bytes, directions, m);
            for (size_t i = 0; i < m; ++i)
                memcpy(nodes + ISO_NODE_CHANNELS * i + 1, directions + 3 * i, 3 * sizeof *directions);
        }
    }
}

void iso_node_levels_destroy(iso_node_levels *n)
{
    if (!n)
        return;
    for (size_t l = 0; l < ISO_BRICK_MAX_LEVELS; ++l)
        free(n->nodes[l]);
    *n = (iso_node_levels){0};
}

/* ---- the field ---------------------------------------------------------------- */

/* The coarsest brick whose closed box holds node p of level 0 (p in whole nodes), if it is coarser than `level`. All
 * of the same level agree there, so the first one found will do. */
static bool coarsest_at(const iso_brick_field *f, const size_t p[3], size_t level, size_t brick[3])
{
    const iso_node_levels *n = f->nodes;
    size_t first[3], last[3];
    bool found = false;
    for (int a = 0; a < 3; ++a) {
        size_t b = p[a] / n->brick_voxels;
        last[a] = least(b, n->count[a] - 1);
        first[a] = p[a] % n->brick_voxels == 0 && b > 0 ? b - 1 : last[a];
    }
    for (size_t z = first[2]; z <= last[2]; ++z)
        for (size_t y = first[1]; y <= last[1]; ++y)
            for (size_t x = first[0]; x <= last[0]; ++x) {
                const size_t candidate[3] = {x, y, z};
                size_t there = f->levels[iso_brick_index(n, candidate)];
                if (there <= level)
                    continue;
                level = there;
                memcpy(brick, candidate, sizeof candidate);
                found = true;
            }
    return found;
}

const float *iso_brick_own_row(const iso_brick_field *f, const size_t brick[3], size_t y, size_t z)
{
    const iso_node_levels *n = f->nodes;
    const size_t level = f->levels[iso_brick_index(n, brick)], cells = n->brick_voxels >> level;
    const size_t nx = node_count(n, level, 0), ny = node_count(n, level, 1);
    return n->nodes[level] +
           ISO_NODE_CHANNELS * (brick[0] * cells + nx * (brick[1] * cells + y + ny * (brick[2] * cells + z)));
}

bool iso_brick_has_foreign_nodes(const iso_brick_field *f, const size_t brick[3])
{
    const iso_node_levels *n = f->nodes;
    const uint8_t level = f->levels[iso_brick_index(n, brick)];
    size_t first[3], last[3];
    if (f->faces != ISO_FACES_BAKED)
        return false;
    for (int a = 0; a < 3; ++a) {
        first[a] = brick[a] > 0 ? brick[a] - 1 : 0;
        last[a] = least(brick[a] + 1, n->count[a] - 1);
    }
    for (size_t z = first[2]; z <= last[2]; ++z)
        for (size_t y = first[1]; y <= last[1]; ++y)
            for (size_t x = first[0]; x <= last[0]; ++x)
                if (f->levels[iso_brick_index(n, (const size_t[3]){x, y, z})] > level)
                    return true;
    return false;
}

void iso_brick_node(const iso_brick_field *f, const size_t brick[3], const size_t node[3],
                    double out[ISO_NODE_CHANNELS])
{
    const iso_node_levels *n = f->nodes;
    size_t level = f->levels[iso_brick_index(n, brick)], cells = n->brick_voxels >> level, p[3], coarser[3];
    bool on_face = false;
    for (int a = 0; a < 3; ++a) {
        p[a] = brick[a] * n->brick_voxels + (node[a] << level);
        on_face = on_face || node[a] == 0 || node[a] == cells;
    }
    if (on_face && f->faces == ISO_FACES_BAKED && coarsest_at(f, p, level, coarser)) {
        iso_brick_sample_in(f, coarser, (const double[3]){(double)p[0], (double)p[1], (double)p[2]}, out);
        return;
    }
    size_t nx = node_count(n, level, 0), ny = node_count(n, level, 1);
    size_t i = (p[0] >> level) + nx * ((p[1] >> level) + ny * (p[2] >> level));
    for (size_t c = 0; c < ISO_NODE_CHANNELS; ++c)
        out[c] = (double)n->nodes[level][ISO_NODE_CHANNELS * i + c];
}

void iso_brick_sample_in(const iso_brick_field *f, const size_t brick[3], const double q[3],
                         double out[ISO_NODE_CHANNELS])
{
    const iso_node_levels *n = f->nodes;
    size_t level = f->levels[iso_brick_index(n, brick)], cells = n->brick_voxels >> level, lo[3];
    const double spacing = 1 / (double)((size_t)1 << level); /* a power of two: no rounding */
    bool own = f->faces == ISO_FACES_OWN, inside = true;
    double part[3];
    for (int a = 0; a < 3; ++a) {
        double u = spacing * (q[a] - (double)(brick[a] * n->brick_voxels));
        u = u > 0 ? (u < (double)cells ? u : (double)cells) : 0;
        lo[a] = least((size_t)u, cells - 1);
        part[a] = u - (double)lo[a];
        inside = inside && lo[a] > 0 && lo[a] + 1 < cells;
    }
    /* No coarser brick has a say in what lies within. */
    own = own || inside;
    const size_t nx = node_count(n, level, 0), ny = node_count(n, level, 1);
    const float *corner = iso_brick_own_row(f, brick, lo[1], lo[2]) + ISO_NODE_CHANNELS * lo[0];
    memset(out, 0, ISO_NODE_CHANNELS * sizeof *out);
    for (size_t c = 0; c < 8; ++c) {
        const size_t node[3] = {lo[0] + (c & 1), lo[1] + (c >> 1 & 1), lo[2] + (c >> 2)};
        double weight = 1, value[ISO_NODE_CHANNELS];
        for (int a = 0; a < 3; ++a)
            weight *= c >> a & 1 ? part[a] : 1 - part[a];
        if (weight == 0)
            continue;
        if (own)
            for (size_t k = 0; k < ISO_NODE_CHANNELS; ++k)
                value[k] = (double)corner[ISO_NODE_CHANNELS * ((c & 1) + nx * ((c >> 1 & 1) + ny * (c >> 2))) + k];
        else
            iso_brick_node(f, brick, node, value);
        for (int k = 0; k < ISO_NODE_CHANNELS; ++k)
            out[k] += weight * value[k];
    }
}

void iso_brick_sample(const iso_brick_field *f, iso_vec3 index, double out[ISO_NODE_CHANNELS])
{
    const iso_node_levels *n = f->nodes;
    double q[3] = {index.x - 0.5, index.y - 0.5, index.z - 0.5};
    size_t brick[3];
    for (int a = 0; a < 3; ++a) {
        double last = (double)(n->geometry.size[a] - 1);
        q[a] = q[a] > 0 ? (q[a] < last ? q[a] : last) : 0;
        brick[a] = least((size_t)(q[a] / (double)n->brick_voxels), n->count[a] - 1);
    }
    iso_brick_sample_in(f, brick, q, out);
}

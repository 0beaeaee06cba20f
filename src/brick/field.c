/* SPDX-License-Identifier: MIT */
#include "brick/bricks.h"

#include <assert.h>
#include <string.h>

static size_t least(size_t a, size_t b)
{
    return a < b ? a : b;
}

/* Finds a brick of that level at p. All bricks of the coarsest level agree there, so the first one is enough. */
bool iso_brick_coarsest_at(const iso_brick_field *f, const size_t p[3], size_t level, size_t brick[3])
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

iso_own_nodes iso_brick_own_nodes(const iso_brick_field *f, const size_t brick[3])
{
    const iso_node_levels *n = f->nodes;
    const size_t index = iso_brick_index(n, brick), level = f->levels[index], cells = n->brick_voxels >> level;
    if (!n->nodes[level]) {
        assert(n->bricks[index]); /* the caller has called iso_brick_make() */
        return (iso_own_nodes){n->bricks[index], ISO_NODE_CHANNELS * (cells + 1),
                               ISO_NODE_CHANNELS * (cells + 1) * (cells + 1)};
    }
    const size_t nx = iso_node_count(n, level, 0), ny = iso_node_count(n, level, 1);
    return (iso_own_nodes){n->nodes[level] + ISO_NODE_CHANNELS * cells * (brick[0] + nx * (brick[1] + ny * brick[2])),
                           ISO_NODE_CHANNELS * nx, ISO_NODE_CHANNELS * nx * ny};
}

const float *iso_brick_own_row(const iso_brick_field *f, const size_t brick[3], size_t y, size_t z)
{
    const iso_own_nodes own = iso_brick_own_nodes(f, brick);
    return own.first + y * own.row + z * own.plane;
}

bool iso_brick_has_foreign_nodes(const iso_brick_field *f, const size_t brick[3])
{
    bool parts[ISO_BRICK_PARTS], any = false;
    iso_brick_foreign_parts(f, brick, parts);
    for (size_t i = 0; i < ISO_BRICK_PARTS; ++i)
        any = any || parts[i];
    return any;
}

/* Marks the parts that a coarser neighbor touches: along an axis the first of three, the last, or all. */
void iso_brick_foreign_parts(const iso_brick_field *f, const size_t brick[3], bool parts[ISO_BRICK_PARTS])
{
    const iso_node_levels *n = f->nodes;
    const uint8_t level = f->levels[iso_brick_index(n, brick)];
    memset(parts, 0, ISO_BRICK_PARTS * sizeof *parts);
    if (f->faces != ISO_FACES_BAKED)
        return;
    for (size_t i = 0; i < ISO_BRICK_PARTS; ++i) {
        const size_t step[3] = {i % 3, i / 3 % 3, i / 9};
        size_t at[3], first[3], last[3];
        bool there = true;
        for (int a = 0; a < 3; ++a) {
            at[a] = brick[a] + step[a] - 1; /* below 0 wraps around to a large index */
            there = there && at[a] < n->count[a];
            first[a] = step[a] == 2 ? 2 : 0;
            last[a] = step[a] == 0 ? 0 : 2;
        }
        if (!there || f->levels[iso_brick_index(n, at)] <= level)
            continue;
        for (size_t z = first[2]; z <= last[2]; ++z)
            for (size_t y = first[1]; y <= last[1]; ++y)
                for (size_t x = first[0]; x <= last[0]; ++x)
                    parts[x + 3 * (y + 3 * z)] = true;
    }
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
    if (on_face && f->faces == ISO_FACES_BAKED && iso_brick_coarsest_at(f, p, level, coarser)) {
        iso_brick_sample_in(f, coarser, (const double[3]){(double)p[0], (double)p[1], (double)p[2]}, out);
        return;
    }
    const iso_own_nodes own = iso_brick_own_nodes(f, brick);
    const float *value = own.first + ISO_NODE_CHANNELS * node[0] + node[1] * own.row + node[2] * own.plane;
    for (size_t c = 0; c < ISO_NODE_CHANNELS; ++c)
        out[c] = (double)value[c];
}

/* Weights of the eight corners of a cell, of which the first is `lo`. */
typedef struct cell_place {
    size_t lo[3];
    double part[3];
    bool inside; /* True if no corner is on a face of the brick */
} cell_place;

static cell_place place_in(const iso_brick_field *f, const size_t brick[3], const double q[3])
{
    const iso_node_levels *n = f->nodes;
    const size_t level = f->levels[iso_brick_index(n, brick)], cells = n->brick_voxels >> level;
    const double spacing = 1 / (double)((size_t)1 << level); /* a power of two: no rounding */
    cell_place p = {.inside = true};
    for (int a = 0; a < 3; ++a) {
        double u = spacing * (q[a] - (double)(brick[a] * n->brick_voxels));
        u = u > 0 ? (u < (double)cells ? u : (double)cells) : 0;
        p.lo[a] = least((size_t)u, cells - 1);
        p.part[a] = u - (double)p.lo[a];
        p.inside = p.inside && p.lo[a] > 0 && p.lo[a] + 1 < cells;
    }
    return p;
}

void iso_brick_sample_in(const iso_brick_field *f, const size_t brick[3], const double q[3],
                         double out[ISO_NODE_CHANNELS])
{
    const cell_place p = place_in(f, brick, q);
    const bool own = f->faces == ISO_FACES_OWN || p.inside; /* coarser bricks do not affect the inside */
    const iso_own_nodes nodes = iso_brick_own_nodes(f, brick);
    const float *corner = nodes.first + ISO_NODE_CHANNELS * p.lo[0] + p.lo[1] * nodes.row + p.lo[2] * nodes.plane;
    double sum[ISO_NODE_CHANNELS] = {0};
    for (size_t c = 0; c < 8; ++c) {
        const size_t x = c & 1, y = c >> 1 & 1, z = c >> 2;
        const double weight = (x ? p.part[0] : 1 - p.part[0]) * (y ? p.part[1] : 1 - p.part[1]) *
                              (z ? p.part[2] : 1 - p.part[2]);
        if (weight == 0)
            continue;
        if (own) {
            const float *node = corner + ISO_NODE_CHANNELS * x + y * nodes.row + z * nodes.plane;
            for (int k = 0; k < ISO_NODE_CHANNELS; ++k)
                sum[k] += weight * (double)node[k];
            continue;
        }
        double value[ISO_NODE_CHANNELS];
        iso_brick_node(f, brick, (const size_t[3]){p.lo[0] + x, p.lo[1] + y, p.lo[2] + z}, value);
        for (int k = 0; k < ISO_NODE_CHANNELS; ++k)
            sum[k] += weight * value[k];
    }
    memcpy(out, sum, sizeof sum);
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

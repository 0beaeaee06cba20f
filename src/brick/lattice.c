/* SPDX-License-Identifier: MIT */
#include "brick/lattice.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "brick/occupancy.h"

static bool any_shows(const iso_tf_table *tfs, size_t count, double min, double max)
{
    for (size_t i = 0; i < count; ++i)
        if (iso_tf_shows(&tfs[i], min, max))
            return true;
    return false;
}

/* ---- the background ------------------------------------------------------------ */

enum { BIN_COUNT = 1024 };

double iso_lattice_background(const iso_node_levels *n, const iso_tf_table *tfs, size_t tf_count)
{
    size_t nodes = 1, bins[BIN_COUNT] = {0}, most = 0;
    double width = (n->max - n->min) / BIN_COUNT, value = n->min;
    for (int a = 0; a < 3; ++a)
        nodes *= n->count[a] * n->brick_voxels + 1;
    for (size_t i = 0; i < nodes && width > 0; ++i) {
        double bin = ((double)n->nodes[0][ISO_NODE_CHANNELS * i] - n->min) / width;
        ++bins[bin > 0 ? (bin < BIN_COUNT - 1 ? (size_t)bin : BIN_COUNT - 1) : 0];
    }
    for (size_t start = 0; start < BIN_COUNT; ++start) {
        size_t end = start, inside = 0;
        while (end < BIN_COUNT &&
               !any_shows(tfs, tf_count, n->min + (double)start * width, n->min + (double)(end + 1) * width))
            inside += bins[end++];
        if (end > start && inside >= most) { /* as far as can be from what shows */
            most = inside;
            value = start == 0 ? n->min : end == BIN_COUNT ? n->max : n->min + 0.5 * (double)(start + end) * width;
        }
        start = end > start ? end - 1 : start;
    }
    return value;
}

/* ---- what is where --------------------------------------------------------------- */

typedef struct builder {
    const iso_brick_field *field;
    const iso_lattice_options *opt;
    iso_lattice *lattice;
} builder;

static size_t node_at(const iso_lattice *l, size_t x, size_t y, size_t z)
{
    return x + l->size[0] * (y + l->size[1] * z);
}

static bool belongs(const builder *b, size_t brick)
{
    return b->opt->drawn[brick] && (b->opt->merged || b->field->levels[brick] == b->lattice->level);
}

/* The box of the bricks and one node more on all sides. False when there are none. */
static bool find_box(const builder *b)
{
    const iso_node_levels *n = b->field->nodes;
    iso_lattice *l = b->lattice;
    size_t lo[3] = {SIZE_MAX, SIZE_MAX, SIZE_MAX}, hi[3] = {0};
    for (size_t i = 0; i < iso_brick_count(n); ++i) {
        const size_t at[3] = {i % n->count[0], i / n->count[0] % n->count[1], i / (n->count[0] * n->count[1])};
        for (int a = 0; a < 3 && belongs(b, i); ++a) {
            lo[a] = at[a] < lo[a] ? at[a] : lo[a];
            hi[a] = at[a] + 1 > hi[a] ? at[a] + 1 : hi[a];
        }
    }
    for (int a = 0; a < 3; ++a) {
        size_t cells = n->brick_voxels >> l->level;
        if (hi[a] == 0)
            return false;
        l->first[a] = (long)(lo[a] * cells) - 1;
        l->size[a] = (hi[a] - lo[a]) * cells + 3;
    }
    return true;
}

/* Of a node or cell i of the lattice along an axis: its node of level 0, within the volume's bricks. */
static size_t level0_node(const builder *b, int axis, long i)
{
    const iso_node_levels *n = b->field->nodes;
    size_t last = n->count[axis] * n->brick_voxels, q = i > 0 ? (size_t)i << b->lattice->level : 0;
    /* At level 0 positions are clamped to the nodes that the volume has; coarser cells reach over its edge. */
    last = b->lattice->level == 0 ? n->geometry.size[axis] - 1 : last;
    return q < last ? q : last;
}

static size_t brick_of(const builder *b, int axis, size_t q)
{
    size_t brick = q / b->field->nodes->brick_voxels, last = b->field->nodes->count[axis] - 1;
    return brick < last ? brick : last;
}

/* Sampled values have more digits than they need, and do not compress: 1/65536 of the range and 1/1024 of a direction are
 * enough. Powers of two, so that the last bits are 0. One grid stays as continuous as it was. */
static void round_sampled(const iso_node_levels *n, double value[ISO_NODE_CHANNELS])
{
    int exponent;
    frexp(n->max - n->min, &exponent);
    double step = ldexp(1, exponent - 16);
    value[0] = step * rint(value[0] / step);
    for (int c = 1; c < ISO_NODE_CHANNELS; ++c)
        value[c] = rint(1024 * value[c]) / 1024;
}

/* Of any brick that holds the node: they agree. */
static void sample_node(const builder *b, const size_t at[3])
{
    const iso_node_levels *n = b->field->nodes;
    iso_lattice *l = b->lattice;
    double q[3], value[ISO_NODE_CHANNELS];
    size_t brick[3];
    for (int a = 0; a < 3; ++a) {
        size_t node = level0_node(b, a, l->first[a] + (long)at[a]);
        brick[a] = brick_of(b, a, node);
        q[a] = (double)node;
    }
    iso_brick_sample_in(b->field, brick, q, value);
    if (b->opt->merged && b->field->levels[iso_brick_index(n, brick)] > l->level)
        round_sampled(n, value);
    float *to = l->nodes + ISO_NODE_CHANNELS * node_at(l, at[0], at[1], at[2]);
    for (int c = 0; c < ISO_NODE_CHANNELS; ++c)
        to[c] = (float)value[c];
}

/* Whether the nodes that brick_of() says are the brick's may be corners of a cell that belongs: those on its lower faces are
 * also corners of the bricks below. */
static bool has_corners(const builder *b, size_t brick)
{
    const size_t *count = b->field->nodes->count;
    const size_t at[3] = {brick % count[0], brick / count[0] % count[1], brick / (count[0] * count[1])};
    const size_t step[3] = {1, count[0], count[0] * count[1]};
    for (int o = 0; o < 8; ++o) {
        size_t below = brick;
        bool is_there = true;
        for (int a = 0; a < 3; ++a)
            if (o >> a & 1) {
                is_there = is_there && at[a] > 0;
                below -= is_there ? step[a] : 0;
            }
        if (is_there && belongs(b, below))
            return true;
    }
    return false;
}

/* Corners of the cells that belong. Others are sampled when they become active, which few do. */
static void fill_nodes(const builder *b, const uint8_t *has)
{
    const iso_node_levels *n = b->field->nodes;
    iso_lattice *l = b->lattice;
#pragma omp parallel for schedule(dynamic) num_threads(iso_threads(b->opt->threads))
    for (size_t z = 0; z < l->size[2]; ++z)
        for (size_t y = 0; y < l->size[1]; ++y) {
            const size_t row = n->count[0] * (brick_of(b, 1, level0_node(b, 1, l->first[1] + (long)y)) +
                                              n->count[1] * brick_of(b, 2, level0_node(b, 2, l->first[2] + (long)z)));
            for (size_t x = 0; x < l->size[0]; ++x)
                if (has[row + brick_of(b, 0, level0_node(b, 0, l->first[0] + (long)x))])
                    sample_node(b, (const size_t[]){x, y, z});
        }
}

/* A byte a brick: has_corners(). To be freed. */
static uint8_t *find_corners(const builder *b)
{
    const size_t count = iso_brick_count(b->field->nodes);
    uint8_t *has = malloc(count);
    for (size_t i = 0; has && i < count; ++i)
        has[i] = has_corners(b, i);
    return has;
}

/* ---- which nodes are needed ------------------------------------------------------- */

static int active_corners(const iso_lattice *l, const size_t corners[8])
{
    int active = 0;
    for (int c = 0; c < 8; ++c)
        active += l->active[corners[c]] != 0;
    return active;
}

/* The range of a cell's corners, those that are not active as background if mixed. */
static void cell_range(const iso_lattice *l, const size_t corners[8], bool mixed, double *min, double *max)
{
    *min = INFINITY, *max = -INFINITY;
    for (int c = 0; c < 8; ++c) {
        double value = mixed && !l->active[corners[c]] ? l->background
                                                       : (double)l->nodes[ISO_NODE_CHANNELS * corners[c]];
        *min = value < *min ? value : *min;
        *max = value > *max ? value : *max;
    }
}

/* One pass over the cells: first those that show, then (mixed) those that would show with background in them. */
static size_t activate(const builder *b, bool mixed)
{
    iso_lattice *l = b->lattice;
    const iso_lattice_options *o = b->opt;
    const size_t *count = b->field->nodes->count;
    size_t changed = 0;
    for (size_t z = 0; z + 1 < l->size[2]; ++z)
        for (size_t y = 0; y + 1 < l->size[1]; ++y) {
            const size_t row = count[0] * (brick_of(b, 1, level0_node(b, 1, l->first[1] + (long)y)) +
                                           count[1] * brick_of(b, 2, level0_node(b, 2, l->first[2] + (long)z)));
            for (size_t x = 0; x + 1 < l->size[0]; ++x) {
                const size_t index = row + brick_of(b, 0, level0_node(b, 0, l->first[0] + (long)x));
                size_t corners[8];
                double min, max;
                bool matters = mixed && o->merged ? o->drawn[index] || !o->seen || o->seen[index] : belongs(b, index);
                if (!matters)
                    continue;
                for (size_t c = 0; c < 8; ++c)
                    corners[c] = node_at(l, x + (c & 1), y + (c >> 1 & 1), z + (c >> 2));
                const int active = active_corners(l, corners); /* of most cells all, or none */
                if (active == 8 || (mixed && active == 0))
                    continue;
                cell_range(l, corners, mixed, &min, &max);
                if (!any_shows(o->tfs, o->tf_count, min, max))
                    continue;
                for (size_t c = 0; c < 8; ++c) {
                    if (mixed && !l->active[corners[c]])
                        sample_node(b, (const size_t[]){x + (c & 1), y + (c >> 1 & 1), z + (c >> 2)});
                    l->active[corners[c]] = 1;
                }
                ++changed;
            }
        }
    return changed;
}

/* Shrinks to the box of the active nodes, sets the others to background. False when there are none. */
static bool trim(iso_lattice *l, bool whole_box)
{
    size_t lo[3] = {SIZE_MAX, SIZE_MAX, SIZE_MAX}, hi[3] = {0}, to = 0;
    for (size_t i = 0; i < l->size[0] * l->size[1] * l->size[2]; ++i) {
        const size_t at[3] = {i % l->size[0], i / l->size[0] % l->size[1], i / (l->size[0] * l->size[1])};
        l->active_count += l->active[i];
        for (int a = 0; a < 3 && l->active[i]; ++a) {
            lo[a] = at[a] < lo[a] ? at[a] : lo[a];
            hi[a] = at[a] + 1 > hi[a] ? at[a] + 1 : hi[a];
        }
    }
    if (l->active_count == 0)
        return false;
    for (int a = 0; a < 3 && whole_box; ++a)
        lo[a] = 0, hi[a] = l->size[a];
    const size_t size[3] = {hi[0] - lo[0], hi[1] - lo[1], hi[2] - lo[2]};
    l->min = l->max = l->background;
    for (size_t z = lo[2]; z < hi[2]; ++z)
        for (size_t y = lo[1]; y < hi[1]; ++y)
            for (size_t x = lo[0]; x < hi[0]; ++x, ++to) { /* never ahead of what is read */
                size_t from = node_at(l, x, y, z);
                const float empty[ISO_NODE_CHANNELS] = {(float)l->background};
                bool active = l->active[from] != 0;
                memmove(l->nodes + ISO_NODE_CHANNELS * to, active ? l->nodes + ISO_NODE_CHANNELS * from : empty,
                        sizeof empty);
                l->active[to] = active;
                l->min = fmin(l->min, (double)l->nodes[ISO_NODE_CHANNELS * to]);
                l->max = fmax(l->max, (double)l->nodes[ISO_NODE_CHANNELS * to]);
            }
    for (int a = 0; a < 3; ++a)
        l->first[a] += (long)lo[a];
    memcpy(l->size, size, sizeof size);
    if (whole_box) {
        l->active_count += (size_t)!l->active[0] + (size_t)!l->active[to - 1];
        l->active[0] = l->active[to - 1] = 1;
    }
    return true;
}

/* Voxel (0, 0, 0) has its centre at the first node, which is at index 2^level first + 1/2 of the volume. */
static void place(iso_lattice *l, const iso_geometry *g)
{
    double step = ldexp(1, (int)l->level), corner[3];
    for (int a = 0; a < 3; ++a) {
        corner[a] = step * ((double)l->first[a] - 0.5) + 0.5;
        l->geometry.box_index[a] = (double)l->size[a];
    }
    memcpy(l->geometry.size, l->size, sizeof l->size);
    l->geometry.index_to_world = iso_mat3_scale(g->index_to_world, step);
    l->geometry.origin_mm = iso_geometry_to_world(g, iso_v3(corner[0], corner[1], corner[2]));
}

iso_status iso_lattice_create(iso_lattice *l, const iso_brick_field *f, const iso_lattice_options *opt, iso_error *err)
{
    const builder b = {f, opt, l};
    *l = (iso_lattice){.level = opt->merged ? ISO_BRICK_MAX_LEVELS : opt->level};
    if (f->faces != ISO_FACES_BAKED)
        return iso_fail(err, ISO_E_RANGE, "lattice: bricks whose faces are their own have no one value at a node");
    for (size_t i = 0; opt->merged && i < iso_brick_count(f->nodes); ++i)
        if (opt->drawn[i] && f->levels[i] < l->level)
            l->level = f->levels[i];
    if (l->level >= f->nodes->level_count || !find_box(&b))
        return iso_fail(err, ISO_E_RANGE, "lattice: no brick is drawn");
    size_t count = l->size[0] * l->size[1] * l->size[2];
    l->nodes = malloc(ISO_NODE_CHANNELS * count * sizeof *l->nodes);
    l->active = calloc(count, 1);
    uint8_t *has = find_corners(&b);
    if (!l->nodes || !l->active || !has) {
        free(has);
        iso_lattice_destroy(l);
        return iso_fail(err, ISO_E_MEMORY, "lattice: no memory for %zu nodes", count);
    }
    l->background = iso_lattice_background(f->nodes, opt->tfs, opt->tf_count);
    fill_nodes(&b, has);
    free(has);
    activate(&b, false);
    while (activate(&b, true) > 0)
        ;
    if (!trim(l, opt->whole_box)) {
        iso_lattice_destroy(l);
        return iso_fail(err, ISO_E_RANGE, "lattice: the transfer function shows no cell of the bricks that are drawn");
    }
    place(l, &f->nodes->geometry);
    return ISO_OK;
}

void iso_lattice_destroy(iso_lattice *l)
{
    if (!l)
        return;
    free(l->nodes);
    free(l->active);
    *l = (iso_lattice){0};
}

/* SPDX-License-Identifier: MIT */
#include "brick/lattice_build.h"

#include <math.h>
#include <string.h>

#include "brick/made_bricks.h"

/* The nodes of a brick's cells in the lattice, and one cell more beyond the volume's ends. The scalars decide which
 * nodes are active, often few of many, and only these get directions. */
typedef struct cell_box {
    size_t brick[3], index;
    long first[3]; /* node of the lattice's level */
    size_t size[3];
    float *scalars, *directions;        /* in the thread's buffers; one and three per node */
    float *lowest, *highest;            /* ranges of squares of four nodes, for two planes */
    uint8_t *active, *foreign, *wanted; /* foreign: from a coarser brick; wanted: nodes of the brick's row */
    struct node_place *along[3];        /* positions of the nodes in the brick's cells */
} cell_box;

typedef struct node_place {
    size_t cell;
    double part;
} node_place;

static size_t nodes_of(const cell_box *c)
{
    return c->size[0] * c->size[1] * c->size[2];
}

static node_place place_of(const iso_lattice_builder *b, const cell_box *c, int axis, size_t i)
{
    const iso_node_levels *n = b->field->nodes;
    const size_t level = b->field->levels[c->index], q = iso_lattice_level0(b, axis, c->first[axis] + (long)i);
    const size_t from = q - c->brick[axis] * n->brick_voxels, cells = n->brick_voxels >> level;
    const size_t cell = from >> level < cells ? from >> level : cells - 1;
    return (node_place){cell, ldexp((double)(from - (cell << level)), -(int)level)};
}

/* Allocates all arrays in one buffer, those with the widest elements first. False: no memory. */
static bool take_buffers(cell_box *c, size_t most_side, iso_node_buffers *buffers)
{
    const size_t count = nodes_of(c), plane = c->size[0] * c->size[1], places = c->size[0] + c->size[1] + c->size[2];
    const size_t floats = 4 * count + 4 * plane;
    char *at = iso_node_buffers_take(buffers, ISO_BUFFER_CELLS,
                                     places * sizeof *c->along[0] + floats * sizeof(float) + 2 * count + most_side);
    if (!at)
        return false;
    c->along[0] = (node_place *)(void *)at;
    c->along[1] = c->along[0] + c->size[0];
    c->along[2] = c->along[1] + c->size[1];
    c->scalars = (float *)(void *)(c->along[2] + c->size[2]);
    c->directions = c->scalars + count;
    c->lowest = c->directions + 3 * count;
    c->highest = c->lowest + 2 * plane;
    c->active = (uint8_t *)(c->highest + 2 * plane);
    c->foreign = c->active + count;
    c->wanted = c->foreign + count;
    memset(c->active, 0, 2 * count);
    return true;
}

static bool cell_box_place(cell_box *c, const iso_lattice_builder *b, size_t index, iso_node_buffers *buffers)
{
    const iso_node_levels *n = b->field->nodes;
    const size_t cells = n->brick_voxels >> b->lattice->level;
    *c = (cell_box){.brick = {index % n->count[0], index / n->count[0] % n->count[1],
                              index / (n->count[0] * n->count[1])},
                    .index = index};
    for (int a = 0; a < 3; ++a) {
        const bool begins = c->brick[a] == 0, ends = c->brick[a] + 1 == n->count[a];
        c->first[a] = (long)(c->brick[a] * cells) - begins;
        c->size[a] = cells + 1 + begins + ends;
    }
    if (!take_buffers(c, n->brick_voxels + 1, buffers))
        return false;
    for (int a = 0; a < 3; ++a)
        for (size_t i = 0; i < c->size[a]; ++i)
            c->along[a][i] = place_of(b, c, a, i);
    return true;
}

/* ---- bricks coarser than the lattice ------------------------------------------------ */

/* Computes the field at the nodes of the brick's own cells. NULL: no memory. */
static const double *corners_of(const iso_lattice_builder *b, const cell_box *c, iso_node_buffers *buffers)
{
    const size_t side = iso_brick_side(b->field->nodes, b->field->levels[c->index]);
    double *corners = iso_node_buffers_take(buffers, ISO_BUFFER_CORNERS,
                                            ISO_NODE_CHANNELS * side * side * side * sizeof *corners);
    for (size_t i = 0; corners && i < side * side * side; ++i)
        iso_brick_node(b->field, c->brick, (const size_t[]){i % side, i / side % side, i / (side * side)},
                       corners + ISO_NODE_CHANNELS * i);
    return corners;
}

/* Interpolates `count` channels from the first of `corners` on, in iso_brick_sample_in()'s order of operations. */
static inline void interpolate(const double *corners, size_t side, const cell_box *c, const size_t at[3], size_t count,
                               double *out)
{
    const node_place place[3] = {c->along[0][at[0]], c->along[1][at[1]], c->along[2][at[2]]};
    const double *low = corners + ISO_NODE_CHANNELS * (place[0].cell + side * (place[1].cell + side * place[2].cell));
    for (size_t k = 0; k < count; ++k)
        out[k] = 0;
    for (size_t i = 0; i < 8; ++i) {
        const double *corner = low + ISO_NODE_CHANNELS * ((i & 1) + side * ((i >> 1 & 1) + side * (i >> 2)));
        double weight = 1;
        for (size_t a = 0; a < 3; ++a)
            weight *= i >> a & 1 ? place[a].part : 1 - place[a].part;
        for (size_t k = 0; k < count; ++k)
            out[k] += weight * corner[k];
    }
}

static void scalars_between(const iso_lattice_builder *b, const cell_box *c, const double *corners)
{
    const size_t side = iso_brick_side(b->field->nodes, b->field->levels[c->index]);
    float *to = c->scalars;
    for (size_t z = 0; z < c->size[2]; ++z)
        for (size_t y = 0; y < c->size[1]; ++y)
            for (size_t x = 0; x < c->size[0]; ++x) {
                double value;
                interpolate(corners, side, c, (const size_t[]){x, y, z}, 1, &value);
                *to++ = iso_lattice_round_scalar(b, value);
            }
}

static void directions_between(const iso_lattice_builder *b, const cell_box *c, const double *corners)
{
    const size_t side = iso_brick_side(b->field->nodes, b->field->levels[c->index]);
    size_t i = 0;
    for (size_t z = 0; z < c->size[2]; ++z)
        for (size_t y = 0; y < c->size[1]; ++y)
            for (size_t x = 0; x < c->size[0]; ++x, ++i) {
                double value[3];
                if (!c->active[i])
                    continue;
                interpolate(corners + 1, side, c, (const size_t[]){x, y, z}, 3, value);
                iso_lattice_round_direction(b, value, c->directions + 3 * i);
            }
}

/* ---- bricks of the lattice's level --------------------------------------------------- */

static size_t own_node(const cell_box *c, int axis, size_t i)
{
    const node_place *place = &c->along[axis][i];
    return place->cell + (place->part > 0);
}

/* Computes a row's nodes that come from a coarser brick. They are rounded from doubles as in that brick, so that all
 * bricks that share a node have the same bits. */
static void take_foreign(const iso_lattice_builder *b, const cell_box *c, const bool foreign[ISO_BRICK_PARTS], size_t y,
                         size_t z)
{
    const size_t side = iso_brick_side(b->field->nodes, b->lattice->level), first = c->size[0] * (y + c->size[1] * z);
    const size_t own_y = own_node(c, 1, y), own_z = own_node(c, 2, z);
    for (size_t x = 0; x < c->size[0]; ++x) {
        const size_t own_x = own_node(c, 0, x);
        double value[ISO_NODE_CHANNELS];
        if (!foreign[iso_brick_part(side, own_x, own_y, own_z)])
            continue;
        iso_brick_node(b->field, c->brick, (const size_t[]){own_x, own_y, own_z}, value);
        c->scalars[first + x] = iso_lattice_round_scalar(b, value[0]);
        iso_lattice_round_direction(b, value + 1, c->directions + 3 * (first + x));
        c->foreign[first + x] = 1;
    }
}

/* Sets the baked scalars. passing: a brick without nodes of its own, or NULL. */
static void scalars_baked(const iso_lattice_builder *b, const cell_box *c, const iso_passing_brick *passing)
{
    float row[ISO_BRICK_MOST_VOXELS + 1];
    bool foreign[ISO_BRICK_PARTS];
    iso_brick_foreign_parts(b->field, c->brick, foreign);
    for (size_t z = 0; z < c->size[2]; ++z)
        for (size_t y = 0; y < c->size[1]; ++y) {
            const size_t own_y = own_node(c, 1, y), own_z = own_node(c, 2, z);
            const float *own = passing ? NULL : iso_brick_own_row(b->field, c->brick, own_y, own_z);
            float *to = c->scalars + c->size[0] * (y + c->size[1] * z);
            if (passing)
                iso_passing_brick_scalars(passing, own_y, own_z, row);
            for (size_t x = 0; x < c->size[0]; ++x)
                to[x] = passing ? row[own_node(c, 0, x)] : own[ISO_NODE_CHANNELS * own_node(c, 0, x)];
            take_foreign(b, c, foreign, y, z);
        }
}

/* Sets the directions of a brick that has nodes. */
static void directions_own(const iso_lattice_builder *b, const cell_box *c)
{
    size_t i = 0;
    for (size_t z = 0; z < c->size[2]; ++z)
        for (size_t y = 0; y < c->size[1]; ++y) {
            const float *own = iso_brick_own_row(b->field, c->brick, own_node(c, 1, y), own_node(c, 2, z));
            for (size_t x = 0; x < c->size[0]; ++x, ++i)
                if (c->active[i] && !c->foreign[i])
                    memcpy(c->directions + 3 * i, own + ISO_NODE_CHANNELS * own_node(c, 0, x) + 1,
                           3 * sizeof *c->directions);
        }
}

/* Marks the nodes of a row that need directions of the brick's own, one byte per node. False: none. */
static bool select_row(const cell_box *c, size_t first, size_t side)
{
    bool any = false;
    memset(c->wanted, 0, side);
    for (size_t x = 0; x < c->size[0]; ++x) {
        const bool wanted = c->active[first + x] && !c->foreign[first + x];
        c->wanted[own_node(c, 0, x)] |= wanted;
        any = any || wanted;
    }
    return any;
}

/* Directions of several rows, collected to be encoded at once. */
enum { BATCH = 4 * (ISO_BRICK_MOST_VOXELS + 3) };
typedef struct code_batch {
    float directions[3 * BATCH];
    size_t places[BATCH], count;
} code_batch;

static void code_directions(const iso_passing_brick *p, const cell_box *c, code_batch *batch)
{
    iso_passing_brick_code(p, batch->directions, batch->count);
    for (size_t k = 0; k < batch->count; ++k)
        memcpy(c->directions + 3 * batch->places[k], batch->directions + 3 * k, 3 * sizeof *c->directions);
    batch->count = 0;
}

static void directions_passing(const cell_box *c, const iso_passing_brick *p)
{
    const size_t side = p->nodes->brick_voxels + 1;
    float row[3 * (ISO_BRICK_MOST_VOXELS + 1)];
    code_batch batch;
    batch.count = 0;
    for (size_t z = 0; z < c->size[2]; ++z)
        for (size_t y = 0; y < c->size[1]; ++y) {
            const size_t first = c->size[0] * (y + c->size[1] * z);
            if (!select_row(c, first, side))
                continue;
            iso_passing_brick_directions(p, own_node(c, 1, y), own_node(c, 2, z), c->wanted, row);
            for (size_t x = 0; x < c->size[0]; ++x) {
                if (!c->active[first + x] || c->foreign[first + x])
                    continue;
                memcpy(batch.directions + 3 * batch.count, row + 3 * own_node(c, 0, x), 3 * sizeof *row);
                batch.places[batch.count++] = first + x;
            }
            if (batch.count + c->size[0] > BATCH)
                code_directions(p, c, &batch);
        }
    code_directions(p, c, &batch);
}

/* ---- cells ---------------------------------------------------------------------- */

/* Computes the ranges of all squares of four nodes in plane z. */
static void take_plane(const cell_box *c, size_t z, float *lowest, float *highest)
{
    const size_t nx = c->size[0], ny = c->size[1];
    const float *plane = c->scalars + nx * ny * z;
    for (size_t y = 0; y + 1 < ny; ++y)
        for (size_t x = 0; x + 1 < nx; ++x) {
            const float *v = plane + x + nx * y, *w = v + nx;
            const float low_v = v[0] < v[1] ? v[0] : v[1], low_w = w[0] < w[1] ? w[0] : w[1];
            const float high_v = v[0] > v[1] ? v[0] : v[1], high_w = w[0] > w[1] ? w[0] : w[1];
            lowest[x + nx * y] = low_v < low_w ? low_v : low_w;
            highest[x + nx * y] = high_v > high_w ? high_v : high_w;
        }
}

static void activate(const cell_box *c, size_t x, size_t y, size_t z)
{
    const size_t nx = c->size[0], plane = nx * c->size[1];
    uint8_t *at = c->active + x + nx * y + plane * z;
    at[0] = at[1] = at[nx] = at[nx + 1] = 1;
    at[plane] = at[plane + 1] = at[plane + nx] = at[plane + nx + 1] = 1;
}

/* Marks the corners of visible cells. False: there are none. */
static bool mark(const iso_lattice_builder *b, const cell_box *c)
{
    const size_t nx = c->size[0], plane = nx * c->size[1];
    bool any = false;
    take_plane(c, 0, c->lowest, c->highest);
    for (size_t z = 0; z + 1 < c->size[2]; ++z) {
        const size_t here = z % 2 * plane, there = plane - here;
        take_plane(c, z + 1, c->lowest + there, c->highest + there);
        for (size_t y = 0; y + 1 < c->size[1]; ++y)
            for (size_t x = 0; x + 1 < nx; ++x) {
                const size_t i = x + nx * y;
                const float low = c->lowest[i] < c->lowest[plane + i] ? c->lowest[i] : c->lowest[plane + i];
                const float high = c->highest[i] > c->highest[plane + i] ? c->highest[i] : c->highest[plane + i];
                if (!iso_lattice_shows(b, (double)low, (double)high))
                    continue;
                activate(c, x, y, z);
                any = true;
            }
    }
    return any;
}

/* ---- construction -------------------------------------------------------------------- */

static iso_status put_active(iso_lattice *l, const cell_box *c, iso_error *err)
{
    size_t at[3], i = 0;
    for (size_t z = 0; z < c->size[2]; ++z)
        for (size_t y = 0; y < c->size[1]; ++y)
            for (size_t x = 0; x < c->size[0]; ++x, ++i) {
                const size_t in[3] = {x, y, z};
                float node[ISO_NODE_CHANNELS] = {c->scalars[i]};
                if (!c->active[i])
                    continue;
                memcpy(node + 1, c->directions + 3 * i, 3 * sizeof *node);
                for (int a = 0; a < 3; ++a)
                    at[a] = (size_t)(c->first[a] - l->first[a]) + in[a];
                NEED(iso_lattice_put(l, at, node, ISO_LATTICE_LIT, err));
            }
    return ISO_OK;
}

/* Computes values, and directions of active nodes. False: no memory. *any: True if any cell is visible. */
static bool fill(const iso_lattice_builder *b, const cell_box *c, iso_node_buffers *buffers, bool *any)
{
    const iso_node_levels *n = b->field->nodes;
    const bool between = b->field->levels[c->index] > b->lattice->level,
               passes = n->bricks && b->field->levels[c->index] == 0;
    iso_passing_brick passing;
    const double *corners = between ? corners_of(b, c, buffers) : NULL;
    if (between ? !corners : passes && !iso_passing_brick_open(&passing, n, c->index, buffers))
        return false;
    if (between)
        scalars_between(b, c, corners);
    else
        scalars_baked(b, c, passes ? &passing : NULL);
    *any = mark(b, c);
    if (*any && between)
        directions_between(b, c, corners);
    else if (*any && passes)
        directions_passing(c, &passing);
    else if (*any)
        directions_own(b, c);
    return true;
}

iso_status iso_lattice_add_brick(const iso_lattice_builder *b, size_t brick, iso_node_buffers *buffers, iso_error *err)
{
    cell_box c;
    bool any = false;
    iso_status status = ISO_OK;
    NEED_MEMORY(cell_box_place(&c, b, brick, buffers) && fill(b, &c, buffers, &any), err,
                "lattice: no memory for the nodes of a brick");
    if (any)
#pragma omp critical(iso_lattice)
        status = put_active(b->lattice, &c, err);
    return status;
}

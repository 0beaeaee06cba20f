/* SPDX-License-Identifier: MIT */
#include "brick/lattice_build.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>


/* The nodes of a brick's cells in the lattice, and beyond the volume's ends one cell more. */
typedef struct cell_box {
    size_t brick[3], index;
    long first[3]; /* node of the lattice's level */
    size_t size[3];
    float *nodes;            /* owned; ISO_NODE_CHANNELS a node */
    uint8_t *active, *coded; /* in the same allocation; not coded: its direction is to be taken through the code */
    float *lowest, *highest; /* of the squares of four nodes of two planes */
} cell_box;

static size_t nodes_of(const cell_box *c)
{
    return c->size[0] * c->size[1] * c->size[2];
}

static bool cell_box_create(cell_box *c, const iso_lattice_builder *b, size_t index)
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
    const size_t plane = c->size[0] * c->size[1];
    c->nodes = malloc((ISO_NODE_CHANNELS * nodes_of(c) + 4 * plane) * sizeof *c->nodes + 2 * nodes_of(c));
    if (!c->nodes)
        return false;
    c->lowest = c->nodes + ISO_NODE_CHANNELS * nodes_of(c);
    c->highest = c->lowest + 2 * plane;
    c->active = (uint8_t *)(c->highest + 2 * plane);
    c->coded = c->active + nodes_of(c);
    memset(c->active, 0, nodes_of(c));
    memset(c->coded, 1, nodes_of(c));
    return true;
}

/* ---- nodes ---------------------------------------------------------------------- */

/* Where a node of the box stands along an axis, in the brick's cells. */
typedef struct node_place {
    size_t cell;
    double part;
} node_place;

static node_place place_of(const iso_lattice_builder *b, const cell_box *c, int axis, size_t i)
{
    const iso_node_levels *n = b->field->nodes;
    const size_t level = b->field->levels[c->index], q = iso_lattice_level0(b, axis, c->first[axis] + (long)i);
    const size_t from = q - c->brick[axis] * n->brick_voxels, cells = n->brick_voxels >> level;
    const size_t cell = from >> level < cells ? from >> level : cells - 1;
    return (node_place){cell, ldexp((double)(from - (cell << level)), -(int)level)};
}

/* The nodes of the brick's own cells as the field has them; to be freed. */
static double *corners_of(const iso_lattice_builder *b, const cell_box *c)
{
    const size_t side = iso_brick_side(b->field->nodes, b->field->levels[c->index]);
    double *corners = malloc(ISO_NODE_CHANNELS * side * side * side * sizeof *corners);
    for (size_t i = 0; corners && i < side * side * side; ++i)
        iso_brick_node(b->field, c->brick, (const size_t[]){i % side, i / side % side, i / (side * side)},
                       corners + ISO_NODE_CHANNELS * i);
    return corners;
}

/* As iso_brick_sample_in() does, in the same order. */
static void interpolate(const double *corners, size_t side, const node_place place[3], double out[ISO_NODE_CHANNELS])
{
    const double *low = corners + ISO_NODE_CHANNELS * (place[0].cell + side * (place[1].cell + side * place[2].cell));
    memset(out, 0, ISO_NODE_CHANNELS * sizeof *out);
    for (size_t i = 0; i < 8; ++i) {
        const double *corner = low + ISO_NODE_CHANNELS * ((i & 1) + side * ((i >> 1 & 1) + side * (i >> 2)));
        double weight = 1;
        for (size_t a = 0; a < 3; ++a)
            weight *= i >> a & 1 ? place[a].part : 1 - place[a].part;
        for (size_t k = 0; k < ISO_NODE_CHANNELS; ++k)
            out[k] += weight * corner[k];
    }
}

/* The values of a brick that is coarser than the lattice. */
static bool fill_between(const iso_lattice_builder *b, const cell_box *c)
{
    const iso_node_levels *n = b->field->nodes;
    const size_t side = iso_brick_side(n, b->field->levels[c->index]);
    double *corners = corners_of(b, c);
    node_place *along = malloc(c->size[0] * sizeof *along);
    for (size_t x = 0; along && x < c->size[0]; ++x)
        along[x] = place_of(b, c, 0, x);
    for (size_t i = 0; corners && along && i < nodes_of(c); ++i) {
        double value[ISO_NODE_CHANNELS];
        const size_t x = i % c->size[0], y = i / c->size[0] % c->size[1], z = i / (c->size[0] * c->size[1]);
        const node_place place[3] = {along[x], place_of(b, c, 1, y), place_of(b, c, 2, z)};
        interpolate(corners, side, place, value);
        iso_lattice_round(b, value, c->nodes + ISO_NODE_CHANNELS * i);
    }
    const bool good = corners && along;
    free(along);
    free(corners);
    return good;
}

/* A row of what follows. along: where its nodes are. */
static void fill_baked_row(const iso_lattice_builder *b, const cell_box *c, const node_place *along,
                           const bool foreign[ISO_BRICK_PARTS], size_t y, size_t z)
{
    const size_t side = iso_brick_side(b->field->nodes, b->lattice->level), first = c->size[0] * (y + c->size[1] * z);
    const node_place at_y = place_of(b, c, 1, y), at_z = place_of(b, c, 2, z);
    const size_t row_y = at_y.cell + (at_y.part > 0), row_z = at_z.cell + (at_z.part > 0);
    const float *row = iso_brick_own_row(b->field, c->brick, row_y, row_z);
    const bool is_coded = !b->field->nodes->maker || b->lattice->level > 0;
    for (size_t x = 0; x < c->size[0]; ++x) {
        const size_t at_x = along[x].cell + (along[x].part > 0);
        float *to = c->nodes + ISO_NODE_CHANNELS * (first + x);
        memcpy(to, row + ISO_NODE_CHANNELS * at_x, ISO_NODE_CHANNELS * sizeof *to);
        if (!foreign[iso_brick_part(side, at_x, row_y, row_z)]) {
            c->coded[first + x] = is_coded;
            continue;
        }
        double value[ISO_NODE_CHANNELS];
        iso_brick_node(b->field, c->brick, (const size_t[]){at_x, row_y, row_z}, value);
        iso_lattice_round(b, value, to);
    }
}

/* The values of a brick of the lattice's level: its nodes, as they are baked. Those that a coarser brick has a say in are
 * rounded as that brick's are, from doubles: all bricks that share a node give it the same bits. */
static bool fill_baked(const iso_lattice_builder *b, const cell_box *c)
{
    node_place *along = malloc(c->size[0] * sizeof *along);
    if (!along)
        return false;
    bool foreign[ISO_BRICK_PARTS];
    iso_brick_foreign_parts(b->field, c->brick, foreign);
    for (size_t x = 0; x < c->size[0]; ++x)
        along[x] = place_of(b, c, 0, x);
    for (size_t z = 0; z < c->size[2]; ++z)
        for (size_t y = 0; y < c->size[1]; ++y)
            fill_baked_row(b, c, along, foreign, y, z);
    free(along);
    return true;
}

/* ---- cells ---------------------------------------------------------------------- */

/* The ranges of plane z's squares of four nodes. */
static void take_plane(const cell_box *c, size_t z, float *lowest, float *highest)
{
    const size_t nx = c->size[0], ny = c->size[1];
    const float *plane = c->nodes + ISO_NODE_CHANNELS * nx * ny * z;
    for (size_t y = 0; y + 1 < ny; ++y)
        for (size_t x = 0; x + 1 < nx; ++x) {
            const float *v = plane + ISO_NODE_CHANNELS * (x + nx * y), *w = v + ISO_NODE_CHANNELS * nx;
            const float low_v = v[0] < v[ISO_NODE_CHANNELS] ? v[0] : v[ISO_NODE_CHANNELS];
            const float low_w = w[0] < w[ISO_NODE_CHANNELS] ? w[0] : w[ISO_NODE_CHANNELS];
            const float high_v = v[0] > v[ISO_NODE_CHANNELS] ? v[0] : v[ISO_NODE_CHANNELS];
            const float high_w = w[0] > w[ISO_NODE_CHANNELS] ? w[0] : w[ISO_NODE_CHANNELS];
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

/* Marks the corners of the cells that are shown; false: there are none. */
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

/* The directions of the active nodes that are not coded. */
static void code_active(const iso_lattice_builder *b, const cell_box *c)
{
    enum { BATCH = 256 };
    float directions[3 * BATCH];
    size_t places[BATCH], m = 0;
    for (size_t i = 0; i < nodes_of(c); ++i) {
        if (c->active[i] && !c->coded[i]) {
            memcpy(directions + 3 * m, c->nodes + ISO_NODE_CHANNELS * i + 1, 3 * sizeof *directions);
            places[m++] = i;
        }
        if (m < BATCH && (i + 1 < nodes_of(c) || m == 0))
            continue;
        iso_brick_code(b->field->nodes, directions, m);
        for (size_t k = 0; k < m; ++k)
            memcpy(c->nodes + ISO_NODE_CHANNELS * places[k] + 1, directions + 3 * k, 3 * sizeof *directions);
        m = 0;
    }
}

static iso_status put_active(iso_lattice *l, const cell_box *c, iso_error *err)
{
    iso_status status = ISO_OK;
    for (size_t i = 0; i < nodes_of(c) && status == ISO_OK; ++i) {
        if (!c->active[i])
            continue;
        const size_t in[3] = {i % c->size[0], i / c->size[0] % c->size[1], i / (c->size[0] * c->size[1])};
        size_t at[3];
        for (int a = 0; a < 3; ++a)
            at[a] = (size_t)(c->first[a] - l->first[a]) + in[a];
        status = iso_lattice_put(l, at, c->nodes + ISO_NODE_CHANNELS * i, ISO_LATTICE_LIT, err);
    }
    return status;
}

iso_status iso_lattice_add_brick(const iso_lattice_builder *b, size_t brick, iso_error *err)
{
    cell_box c = {.nodes = NULL};
    iso_status status = iso_brick_make(b->field->nodes, brick, ISO_BRICK_UNCODED, err);
    if (status != ISO_OK)
        return status;
    const bool good = cell_box_create(&c, b, brick) &&
                      (b->field->levels[brick] > b->lattice->level ? fill_between(b, &c) : fill_baked(b, &c));
    iso_brick_forget(b->field->nodes, brick);
    if (!good)
        status = iso_fail(err, ISO_E_MEMORY, "lattice: no memory for the nodes of a brick");
    if (good && mark(b, &c)) {
        code_active(b, &c);
#pragma omp critical(iso_lattice)
        status = put_active(b->lattice, &c, err);
    }
    free(c.nodes);
    return status;
}

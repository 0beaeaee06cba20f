/* SPDX-License-Identifier: MIT */
/* cast_field.h - lookups of a packet of points in the volume: the scalar, its color and extinction, the shading
 * normal. */
#pragma once

#include "fit/extinction_scale.h"
#include "render/cpu/cast.h"
#include "render/cpu/cast_vector.h"
#include "tf/tf_2d.h"

typedef struct vec {
    vf x, y, z;
} vec;

#define ISO_REAL float
#define ISO_VEC3 vec3f
#define ISO_MAKE_VEC3(vx, vy, vz) ((vec3f){vx, vy, vz})
#define ISO_SQRT(x) sqrtf(x)
#define ISO_ABS(x) fabsf(x)
typedef struct vec3f {
    float x, y, z;
} vec3f;
#include "encode/code_decode.h"

/* Points in cells, 32 bits of a cell's part: a step of a ray is added without rounding on the way. */
typedef struct points {
    vi cell[3];
    vu part[3];
} points;

enum { PART_BITS = 24 }; /* of a cell's part, as many as a float holds */

/* The first voxel of each point's cell, in the bricks, and how far the point is from it. */
typedef struct place {
    vi voxel;
    vf part[3];
} place;

CAST vi brick_at(const iso_cast *c, const vi cell[3])
{
    const int shift = ISO_CAST_BRICK_SHIFT;
    const int32_t *stride = c->brick_stride;
    return (cell[0] >> shift) * stride[0] + (cell[1] >> shift) * stride[1] + (cell[2] >> shift) * stride[2];
}

CAST vi in_brick(const vi cell[3])
{
    const int low = ISO_CAST_BRICK - 1;
    return (cell[0] & low) + (cell[1] & low) * ISO_CAST_ROW + (cell[2] & low) * ISO_CAST_PLANE;
}

CAST vi first_voxel(const iso_cast *c, const vi cell[3], vi mask)
{
    const vi brick = brick_at(c, cell);
    return (in_brick(cell) + (c->slots ? GATHER(c->slots, brick & mask, 4) : brick)) & mask;
}

/* Does the same after it has made the missing bricks. */
CAST vi made_voxel(const iso_cast *c, const vi cell[3], vi mask)
{
    const vi bricks = brick_at(c, cell) & mask;
    int32_t brick[ISO_CAST_WIDTH], slot[ISO_CAST_WIDTH];
    memcpy(brick, &bricks, sizeof brick);
    for (int i = 0; i < ISO_CAST_WIDTH; ++i)
        slot[i] = __atomic_load_n(c->slots + brick[i], __ATOMIC_ACQUIRE);
    vi at;
    memcpy(&at, slot, sizeof at);
    if (any((at < 0) & mask)) {
        for (int i = 0; i < ISO_CAST_WIDTH; ++i)
            if (mask[i] && slot[i] < 0)
                slot[i] = c->make_brick(c->maker, brick[i]);
        memcpy(&at, slot, sizeof at);
    }
    return (in_brick(cell) + at) & mask;
}

/* Asks the memory for the first voxels of cells, with their codes; the cells need not be there. */
CAST void fetch_cells(const iso_cast *c, const vi cell[3])
{
    const vi at = first_voxel(c, cell, all_int(-1));
    int32_t voxel[ISO_CAST_WIDTH];
    memcpy(voxel, &at, sizeof voxel);
    for (int i = 0; i < ISO_CAST_WIDTH; ++i)
        __builtin_prefetch((const void *)((uintptr_t)c->voxels + sizeof *c->voxels * (size_t)c->voxel_words *
                                                                     (uintptr_t)(intptr_t)voxel[i]));
}

/* ---- bricks of mixed resolution ---- */

/* Multiplies by 2^t + 1, the nodes of a row, with a shift and a sum; twice: by those of a plane. Nodes of a level have
 * 2^t cells a side. */
CAST vi times_row(vi x, vi t)
{
    return x + (x << t);
}

/* Finds the first node of each of a cell's four rows of two nodes. */
CAST void mixed_rows(const iso_cast *c, const place *at, vi first[4])
{
    const vi t = c->cells_shift - (at->voxel & ((1 << ISO_CAST_LEVEL_BITS) - 1));
    const vi row = times_row(all_int(1), t), plane = times_row(row, t);
    first[0] = at->voxel >> ISO_CAST_LEVEL_BITS;
    first[1] = first[0] + row;
    first[2] = first[0] + plane;
    first[3] = first[1] + plane;
}

/* Clamps positions to the outermost nodes. */
CAST void stay_inside(const iso_cast *c, vi cell[3], vi part[3])
{
    for (int a = 0; a < 3; ++a) {
        const vi before = cell[a] < 0, behind = cell[a] > c->last_cell[a];
        cell[a] = select_int(behind, all_int(c->last_cell[a]), cell[a] & ~before);
        part[a] = select_int(behind, all_int((1 << PART_BITS) - 1), part[a] & ~before);
    }
}

/* Returns the first node with the level, as in iso_cast.places; -1 if the brick is left out. */
CAST place mixed_place_of(const iso_cast *c, const points *p, vi mask)
{
    const int shift = c->cells_shift, inner = (1 << shift) - 1;
    place at;
    vi cell[3], part[3], outside = all_int(0), inside[3];
    for (int a = 0; a < 3; ++a) {
        cell[a] = p->cell[a] - ISO_CAST_OUTER;
        part[a] = (vi)(p->part[a] >> (32 - PART_BITS));
        outside |= cell[a] | (c->last_cell[a] - cell[a]);
    }
    if (any((outside < 0) & mask))
        stay_inside(c, cell, part);
    const vi brick = (cell[0] >> shift) + ((cell[1] >> shift) << c->places_shift[0]) +
                     ((cell[2] >> shift) << c->places_shift[1]);
    const vi where = GATHER(c->places, brick & mask, 4), is_left_out = where < 0;
    const vi level = where & ((1 << ISO_CAST_LEVEL_BITS) - 1) & ~is_left_out;
    /* a place in the brick is a number of PART_BITS and cells_shift bits: the upper ones are the cell of its level */
    const vi bits = level + PART_BITS, below = (all_int(1) << bits) - 1, t = shift - level;
    const vf size = (vf)((127 - bits) << 23); /* 2^-bits */
    for (int a = 0; a < 3; ++a) {
        const vi fixed = ((cell[a] & inner) << PART_BITS) | part[a];
        inside[a] = fixed >> bits;
        at.part[a] = to_float(fixed & below) * size;
    }
    const vi node = inside[0] + times_row(inside[1] + times_row(inside[2], t), t);
    at.voxel = (where + (node << ISO_CAST_LEVEL_BITS)) | is_left_out;
    return at;
}

CAST place place_of(const iso_cast *c, const points *p, vi mask)
{
    if (c->places)
        return mixed_place_of(c, p, mask);
    place at = {.voxel = c->make_brick ? made_voxel(c, p->cell, mask) : first_voxel(c, p->cell, mask)};
    for (int a = 0; a < 3; ++a)
        at.part[a] = to_float((vi)(p->part[a] >> 8)) * 0x1p-24f;
    return at;
}

/* Returns the voxels that hold the points: a point half a cell from a center is in the next voxel. */
CAST vi nearest_voxel(vi voxel, const points *p)
{
    static const int offset[3] = {1, ISO_CAST_ROW, ISO_CAST_PLANE};
    for (int a = 0; a < 3; ++a)
        voxel += ((vi)p->part[a] < 0) & offset[a];
    return voxel;
}

CAST vf lerp_in_cell(const vf v[8], const vf f[3])
{
    const vf y0 = lerp(lerp(v[0], v[1], f[0]), lerp(v[2], v[3], f[0]), f[1]);
    const vf y1 = lerp(lerp(v[4], v[5], f[0]), lerp(v[6], v[7], f[0]), f[1]);
    return lerp(y0, y1, f[2]);
}

enum { CELL_Y = ISO_CAST_ROW, CELL_Z = ISO_CAST_PLANE };
#define CELL_ROW(i) ((i & 1) * CELL_Y + (i >> 1) * CELL_Z) /* of the four rows of two voxels */

CAST vf filter_integers(const uint16_t *values, const place *at)
{
    vf v[8];
    for (int i = 0; i < 4; ++i) {
        const vi pair = GATHER(values + CELL_ROW(i), at->voxel, 2);
        v[2 * i] = to_float(pair & 0xffff);
        v[2 * i + 1] = to_float((vi)((vu)pair >> 16));
    }
    return lerp_in_cell(v, at->part);
}

CAST vf filter_floats(const float *values, const place *at)
{
    vf v[8];
    for (int i = 0; i < 4; ++i) {
        const word_pair pair = gather_pairs(values + CELL_ROW(i), at->voxel);
        v[2 * i] = (vf)pair.first;
        v[2 * i + 1] = (vf)pair.second;
    }
    return lerp_in_cell(v, at->part);
}

/* Reads two neighboring voxels: code, scalar, code, scalar. Above a code may be its scalar. */
CAST word_quad row_of_voxels(const iso_cast *c, const place *at, int row)
{
    if (c->voxel_words == 2)
        return gather_quads(c->voxels + 2 * CELL_ROW(row), at->voxel, 2);
    const word_quad q = gather_quads(c->voxels + CELL_ROW(row), at->voxel, 1);
    return (word_quad){{q.word[0], (vi)((vu)q.word[0] >> 24), q.word[1], (vi)((vu)q.word[1] >> 24)}};
}

CAST vf filter_voxels(const iso_cast *c, const place *at)
{
    vf v[8];
    for (int i = 0; i < 4; ++i) {
        const word_quad row = row_of_voxels(c, at, i);
        v[2 * i] = c->has_integers ? to_float(row.word[1]) : (vf)row.word[1];
        v[2 * i + 1] = c->has_integers ? to_float(row.word[3]) : (vf)row.word[3];
    }
    return lerp_in_cell(v, at->part);
}

CAST vf filter_nodes(const iso_cast *c, const place *at)
{
    vi row[4];
    vf v[8];
    mixed_rows(c, at, row);
    for (int i = 0; i < 4; ++i) {
        if (c->small_nodes) {
            const word_quad q = gather_quads(c->small_nodes, row[i], 2);
            v[2 * i] = to_float((vi)((vu)q.word[1] >> 16));
            v[2 * i + 1] = to_float((vi)((vu)q.word[3] >> 16));
        } else if (c->large_nodes) {
            v[2 * i] = gather_floats(c->large_nodes + 3, 4 * row[i]);
            v[2 * i + 1] = gather_floats(c->large_nodes + 7, 4 * row[i]);
        } else if (c->integers) {
            const vi pair = GATHER(c->integers, row[i], 2);
            v[2 * i] = to_float(pair & 0xffff);
            v[2 * i + 1] = to_float((vi)((vu)pair >> 16));
        } else {
            const word_pair pair = gather_pairs(c->floats, row[i]);
            v[2 * i] = (vf)pair.first;
            v[2 * i + 1] = (vf)pair.second;
        }
    }
    return lerp_in_cell(v, at->part);
}

CAST vf scalar_at(const iso_cast *c, const place *at)
{
    if (c->places)
        return filter_nodes(c, at);
    if (c->voxels)
        return filter_voxels(c, at);
    return c->integers ? filter_integers(c->integers, at) : filter_floats(c->floats, at);
}

CAST vf label_at(const iso_cast *c, const place *at, const points *p)
{
    const vi voxel = nearest_voxel(at->voxel, p);
    if (c->voxels) {
        if (c->voxel_words == 1)
            return to_float((vi)((vu)GATHER(c->voxels, voxel, 4) >> 24));
        const vi word = GATHER(c->voxels + 1, voxel, 8);
        return c->has_integers ? to_float(word) : (vf)word;
    }
    return c->integers ? to_float(GATHER(c->integers, voxel, 2) & 0xffff) : gather_floats(c->floats, voxel);
}

/* ---- color and extinction ---- */

/* Places of the points on the table: the entry before each, and the distance from it. */
typedef struct entry {
    vi at;
    vf part;
    vf row; /* of a 2D transfer function */
} entry;

CAST entry entry_at(const iso_cast *c, const points *p, const place *at)
{
    const vf value = c->labels ? label_at(c, at, p) : scalar_at(c, at);
    const vf x = least(most(value * c->entries_per_value + c->first_entry, all_float(0)),
                       all_float((float)(c->entry_count - 1)));
    const vi i = to_int(x), last = all_int(c->entry_count - 2);
    entry e = {.at = select_int(i > last, last, i)};
    e.part = x - to_float(e.at);
    if (c->row_count)
        e.row = filter_integers(c->second, at) * (float)((ISO_TF_2D_ROWS - 1) / 255.0);
    return e;
}

/* Two components that are stored next to each other. */
typedef struct two {
    vf first, second;
} two;

CAST two row_components(const iso_cast *c, vi at, vf part, int component)
{
    const word_quad q = gather_quads(c->entries + component, at, ISO_CAST_ENTRY);
    return (two){(vf)q.word[0] + part * (vf)q.word[1], (vf)q.word[2] + part * (vf)q.word[3]};
}

CAST two entry_components(const iso_cast *c, const entry *e, int component)
{
    if (!c->row_count)
        return row_components(c, e->at, e->part, component);
    vi row = to_int(e->row);
    row = select_int(row > c->row_count - 2, all_int(c->row_count - 2), row);
    const vi at = e->at + row * c->entry_count;
    const two a = row_components(c, at, e->part, component),
              b = row_components(c, at + c->entry_count, e->part, component);
    const vf t = e->row - to_float(row);
    return (two){lerp(a.first, b.first, t), lerp(a.second, b.second, t)};
}

CAST vf depth_of(const iso_cast *c, const entry *e)
{
    return entry_components(c, e, ISO_CAST_DEPTH).first;
}

CAST void color_of(const iso_cast *c, const entry *e, vf color[3])
{
    const two green_blue = entry_components(c, e, ISO_CAST_GREEN);
    color[0] = entry_components(c, e, ISO_CAST_DEPTH).second;
    color[1] = green_blue.first;
    color[2] = green_blue.second;
}

/* Computes q(x) of fit/extinction_scale.h. */
CAST vf extinction_scale_at(const iso_cast *c, const place *at)
{
    vf power;
    const vf octaves = (filter_integers(c->scale, at) - (float)ISO_EXTINCTION_SCALE_ONE) *
                       (1.0f / ISO_EXTINCTION_SCALE_PER_OCTAVE);
    const vf rest = power_less_one(octaves, &power);
    return power + power * rest;
}

/* ---- normals ---- */

CAST vec shading_normal(vec d)
{
    const float eps = (float)ISO_DIRECTION_EPS;
    const vf length = root(d.x * d.x + d.y * d.y + d.z * d.z + eps * eps);
    return (vec){d.x / length, d.y / length, d.z / length};
}

CAST vec decode(int decoder, vec e)
{
    if (decoder == ISO_DECODER_LINEAR)
        return e;
    for (int i = 0; i < ISO_CAST_WIDTH; ++i) {
        const vec3f d = iso_decode(decoder, (vec3f){e.x[i], e.y[i], e.z[i]});
        e.x[i] = d.x;
        e.y[i] = d.y;
        e.z[i] = d.z;
    }
    return e;
}

CAST vf byte_of(vi word, int byte, bool is_signed)
{
    return is_signed ? to_float((word << (24 - 8 * byte)) >> 24) : to_float((vi)((vu)word >> (8 * byte)) & 0xff);
}

CAST vec lattice_at(const iso_cast *c, const place *at, bool is_signed)
{
    vi word[8];
    vf component[3];
    for (int i = 0; i < 4; ++i) {
        const word_quad row = row_of_voxels(c, at, i);
        word[2 * i] = row.word[0];
        word[2 * i + 1] = row.word[2];
    }
    for (int a = 0; a < 3; ++a) {
        vf v[8];
        for (int i = 0; i < 8; ++i)
            v[i] = byte_of(word[i], a, is_signed);
        const vf sum = lerp_in_cell(v, at->part);
        component[a] = is_signed ? sum * (1 / 127.0f) : (sum - 127.5f) * (2 / 255.0f);
    }
    return (vec){component[0], component[1], component[2]};
}

/* Reads the directions of two neighbors along x, as floats. */
CAST void small_directions(const iso_cast *c, vi row, vec d[2])
{
    const word_quad q = gather_quads(c->small_nodes, row, 2);
    for (int i = 0; i < 2; ++i)
        d[i] = (vec){to_float((q.word[2 * i] << 16) >> 16), to_float(q.word[2 * i] >> 16),
                     to_float((q.word[2 * i + 1] << 16) >> 16)};
}
CAST void large_directions(const iso_cast *c, vi row, vec d[2])
{
    for (int i = 0; i < 2; ++i) {
        const word_quad q = gather_quads(c->large_nodes, row + i, 4);
        d[i] = (vec){(vf)q.word[0], (vf)q.word[1], (vf)q.word[2]};
    }
}

CAST vec node_direction_at(const iso_cast *c, const place *at)
{
    vi row[4];
    vf x[8], y[8], z[8];
    mixed_rows(c, at, row);
    for (int i = 0; i < 4; ++i) {
        vec d[2];
        if (c->small_nodes)
            small_directions(c, row[i], d);
        else
            large_directions(c, row[i], d);
        for (int k = 0; k < 2; ++k) {
            x[2 * i + k] = d[k].x;
            y[2 * i + k] = d[k].y;
            z[2 * i + k] = d[k].z;
        }
    }
    const float unit = c->small_nodes ? 1 / 32767.0f : 1;
    return (vec){unit * lerp_in_cell(x, at->part), unit * lerp_in_cell(y, at->part), unit * lerp_in_cell(z, at->part)};
}

/* Filters directions, with those flipped that oppose the one of the largest weight times length (code_decode.h). */
CAST vec flipped_at(const iso_cast *c, const place *at)
{
    vec d[8], pivot = {{0}, {0}, {0}}, sum = {{0}, {0}, {0}};
    vf weight[8], longest = {0};
    for (int i = 0; i < 8; ++i) {
        const ptrdiff_t offset = CELL_ROW(i / 2) + (i & 1);
        d[i] = (vec){gather_floats(c->vectors[0] + offset, at->voxel), gather_floats(c->vectors[1] + offset, at->voxel),
                     gather_floats(c->vectors[2] + offset, at->voxel)};
        weight[i] = (i & 1 ? at->part[0] : 1.0f - at->part[0]) * (i & 2 ? at->part[1] : 1.0f - at->part[1]) *
                    (i & 4 ? at->part[2] : 1.0f - at->part[2]);
        const vf count = weight[i] * root(d[i].x * d[i].x + d[i].y * d[i].y + d[i].z * d[i].z);
        const vi is_longer = count > longest;
        longest = select_float(is_longer, count, longest);
        pivot = (vec){select_float(is_longer, d[i].x, pivot.x), select_float(is_longer, d[i].y, pivot.y),
                      select_float(is_longer, d[i].z, pivot.z)};
    }
    const vf pivot_length = root(pivot.x * pivot.x + pivot.y * pivot.y + pivot.z * pivot.z);
    for (int i = 0; i < 8; ++i) {
        const vf cosine = d[i].x * pivot.x + d[i].y * pivot.y + d[i].z * pivot.z;
        const vf length = root(d[i].x * d[i].x + d[i].y * d[i].y + d[i].z * d[i].z);
        const vi opposes = cosine < (float)ISO_FLIP_COSINE * length * pivot_length;
        const vf w = select_float(opposes, -weight[i], weight[i]);
        sum = (vec){sum.x + w * d[i].x, sum.y + w * d[i].y, sum.z + w * d[i].z};
    }
    return sum;
}

/* Filters the two voxels of a cell's row along x. */
CAST vf filter_row(const iso_cast *c, vi voxel, vf x)
{
    if (c->integers) {
        const vi pair = GATHER(c->integers, voxel, 2);
        return lerp(to_float(pair & 0xffff), to_float((vi)((vu)pair >> 16)), x);
    }
    const word_pair pair = gather_pairs(c->floats, voxel);
    return lerp((vf)pair.first, (vf)pair.second, x);
}

/* The scalar a voxel to each side along each axis: at the same part of the neighboring cells, of those that there
 * are. */
CAST void sides_of_labels(const iso_cast *c, const points *p, vi there[3][2], vf side[3][2])
{
    for (int a = 0; a < 3; ++a)
        for (int s = 0; s < 2; ++s) {
            const place at = {.voxel = there[a][s]};
            side[a][s] = label_at(c, &at, p);
        }
}

/* Adjacent cells along y or z have two rows in common, which are filtered along x only once:
 *
 *     z + 2        o o
 *     z + 1      o # # o        #: rows of the point's own cell
 *     z          o # # o
 *     z - 1        o o
 *            y - 1 y   y + 2
 * */
CAST void sides_of(const iso_cast *c, const place *at, vi there[3][2], vi is_edge[3][2], vf side[3][2])
{
    const vf *f = at->part;
    vf own[2][2]; /* z, y */
    for (int i = 0; i < 4; ++i)
        own[i >> 1][i & 1] = filter_row(c, at->voxel + CELL_ROW(i), f[0]);
    const vf center = lerp(lerp(own[0][0], own[0][1], f[1]), lerp(own[1][0], own[1][1], f[1]), f[2]);
    for (int s = 0; s < 2; ++s) {
        vf row[4];
        for (int i = 0; i < 4; ++i)
            row[i] = filter_row(c, there[0][s] + CELL_ROW(i), f[0]);
        side[0][s] = lerp(lerp(row[0], row[1], f[1]), lerp(row[2], row[3], f[1]), f[2]);
        vf y[2], z[2];
        for (int i = 0; i < 2; ++i) {
            const vf beyond = filter_row(c, there[1][s] + i * CELL_Z + s * CELL_Y, f[0]);
            y[i] = s ? lerp(own[i][1], beyond, f[1]) : lerp(beyond, own[i][0], f[1]);
        }
        side[1][s] = lerp(y[0], y[1], f[2]);
        for (int i = 0; i < 2; ++i)
            z[i] = filter_row(c, there[2][s] + i * CELL_Y + s * CELL_Z, f[0]);
        const vf beyond = lerp(z[0], z[1], f[1]), face = lerp(own[s][0], own[s][1], f[1]);
        side[2][s] = s ? lerp(face, beyond, f[2]) : lerp(beyond, face, f[2]);
        for (int a = 0; a < 3; ++a) /* far below all values: no data */
            side[a][s] = select_float(is_edge[a][s] | (vi)(side[a][s] < -0.5f), center, side[a][s]);
    }
}

CAST vec on_the_fly_at(const iso_cast *c, const points *p, const place *at, vi mask)
{
    vf g[3], side[3][2];
    vi there[3][2], is_edge[3][2]; /* first voxels of the neighboring cells; there is none */
    for (int a = 0; a < 3; ++a)
        for (int s = 0; s < 2; ++s) {
            vi cell[3] = {p->cell[0], p->cell[1], p->cell[2]};
            is_edge[a][s] = s ? cell[a] >= c->size[a] : cell[a] <= 0;
            cell[a] += (s ? 1 : -1) + (s ? is_edge[a][s] : -is_edge[a][s]);
            there[a][s] = first_voxel(c, cell, mask);
        }
    if (c->labels)
        sides_of_labels(c, p, there, side);
    else
        sides_of(c, at, there, is_edge, side);
    for (int a = 0; a < 3; ++a)
        g[a] = side[a][1] - side[a][0];
    const float *m = c->gradient_to_world;
    const vec w = {m[0] * g[0] + m[1] * g[1] + m[2] * g[2], m[3] * g[0] + m[4] * g[1] + m[5] * g[2],
                   m[6] * g[0] + m[7] * g[1] + m[8] * g[2]};
    const float eps = c->on_the_fly_eps;
    const vf length = root(w.x * w.x + w.y * w.y + w.z * w.z + eps * eps);
    return (vec){w.x / length, w.y / length, w.z / length};
}

CAST vec normal_at(const iso_cast *c, const points *p, const place *at, vi mask)
{
    vec d;
    if (c->normals == ISO_CAST_LATTICE) {
        d = decode(c->decoder, c->is_signed ? lattice_at(c, at, true) : lattice_at(c, at, false));
    } else if (c->normals == ISO_CAST_VECTORS) {
        d = (vec){filter_floats(c->vectors[0], at), filter_floats(c->vectors[1], at), filter_floats(c->vectors[2], at)};
    } else if (c->normals == ISO_CAST_FLIPPED) {
        d = flipped_at(c, at);
    } else if (c->normals == ISO_CAST_NODES) {
        d = node_direction_at(c, at);
    } else if (c->normals == ISO_CAST_NEAREST) {
        const vi voxel = nearest_voxel(at->voxel, p);
        d = (vec){gather_floats(c->vectors[0], voxel), gather_floats(c->vectors[1], voxel),
                  gather_floats(c->vectors[2], voxel)};
    } else {
        return on_the_fly_at(c, p, at, mask);
    }
    return shading_normal(d);
}

/* SPDX-License-Identifier: MIT */
/* cast_tile.h - a tile of pixels with empty space left out: packet by packet, in four stages.
 *
 *     seek     along each ray, the segments whose cell can show something        cells' bits, floats
 *     look     the transfer function at their samples; keeps visible ones         exact places
 *     shade    their light
 *     add      in the order of each ray, until no light is left
 *
 * Rays that go different ways leave places empty in a packet. So the first two stages write lists without holes, and
 * looking and shading, which cost most, take as many samples at once as the machine can, from any rays. Lists are
 * short, because samples hidden by opaque ones were sought in vain.
 *
 * Seeking decides by a place in floats. Near a face of a cell, or if the box cuts a segment, that may be wrong: there
 * the exact place decides. So no visible sample is left out. Each stage's operations are those of cast_packet.h, lane
 * by lane, so that the bits are the same. Pixels that can show nothing are written at once; the others' rays are
 * limited to the range that can show something (render/screen_reach.h). */
#pragma once

#include "render/cpu/cast_packet.h"
#include "render/screen_reach.h"

/* AT_ONCE: segments that a ray seeks at once in a block that shows something; they wait for the memory together. */
enum { AT_ONCE = 2, SPOTS = 32 * ISO_CAST_WIDTH, SPOT_ROOM = SPOTS + ISO_CAST_WIDTH };

/* Segments to look at: of the packet's ray `lane`. In the order of each ray. */
typedef struct spots {
    int count;
    int32_t lane[SPOT_ROOM], k[SPOT_ROOM];
} spots;

/* Samples that show something. */
typedef struct finds {
    int count;
    int32_t lane[SPOT_ROOM], voxel[SPOT_ROOM], cell[3][SPOT_ROOM], entry[SPOT_ROOM];
    float part[3][SPOT_ROOM], entry_part[SPOT_ROOM], entry_row[SPOT_ROOM], depth[SPOT_ROOM];
    float opacity[SPOT_ROOM], light[SPOT_ROOM], color[3][SPOT_ROOM];
} finds;

/* A packet's rays and their results so far. */
typedef struct walk {
    packet p; /* at segment 0 */
    vi k, end;
    /* Its places in floats, in cells: origin + k step. */
    vf origin[3], per_cell[3]; /* segments per cell, with the sign of the step; 0 if it does not move */
    vf first_exit[3];          /* the segment that leaves through the face at 0 */
    vi is_down[3];             /* mask */
    vi map;                    /* where the map of its octant begins */
    quad sum[ISO_CAST_WIDTH], rest[ISO_CAST_WIDTH];
    spots spots;
    finds finds;
} walk;

/* ---- begin ---- */

/* Leaves out the segments before the visible range of a tile of pixels, and ends the rays after it. */
CAST void narrow(const iso_cast *c, const float reach_mm[2], walk *w)
{
    const double from = floor(reach_mm[0] / c->step_mm), to = floor(reach_mm[1] / c->step_mm) + 1;
    EACH_RAY(i)
    {
        const double first = w->p.first[i], count = w->p.count[i];
        const double begin = from - first, stop = to - first;
        w->end[i] = (int32_t)(stop < count ? (stop > 0 ? stop : 0) : count);
        w->k[i] = (int32_t)(begin > 0 ? (begin < count ? begin : count) : 0);
    }
}

CAST void begin_walk(const iso_cast *c, size_t x, size_t y, const float reach_mm[2], walk *w)
{
    w->p = begin(c, x, y);
    narrow(c, reach_mm, w);
    vi octant = all_int(0);
    for (int a = 0; a < 3; ++a) {
        const vf step = w->p.step[a];
        const vi rests = step == 0;
        w->origin[a] = to_float(w->p.at.cell[a]) + to_float((vi)(w->p.at.part[a] >> 8)) * 0x1p-24f;
        w->per_cell[a] = select_float(rests, all_float(0), 1.0f / step);
        w->first_exit[a] = select_float(rests, all_float(1e9f),
                                        -w->origin[a] * w->per_cell[a] - c->margin * absolute(w->per_cell[a]));
        w->is_down[a] = step < 0;
        octant |= w->is_down[a] & (1 << a);
    }
    w->map = octant * c->blocks;
    EACH_RAY(i)
    {
        w->sum[i] = (quad){0, 0, 0, 1};
        w->rest[i] = (quad){0};
    }
}

/* ---- seek ---- */

/* Returns the sample of segment k of the packet's ray `lane`; *whole gets the part of the segment inside the box. */
CAST points sample_at(const walk *w, vi lane, vi k, vf *whole)
{
    const packet *p = &w->p;
    points at;
    for (int a = 0; a < 3; ++a) {
        const vu stride = PICK(p->stride.part[a], lane);
        at.cell[a] = PICK(p->at.cell[a], lane);
        at.part[a] = PICK(p->at.part[a], lane);
        add(&at, a, k * PICK(p->stride.cell[a], lane) + (vi)multiply_high((vu)k, stride), (vu)k * stride);
    }
    const vi is_first = k == 0, is_last = k == PICK(p->count, lane) - 1;
    *whole = all_float(1);
    if (any(is_first | is_last)) {
        const vf step[3] = {PICK(p->step[0], lane), PICK(p->step[1], lane), PICK(p->step[2], lane)};
        *whole = cut(&at, select_float(is_first, PICK(p->front_cut, lane), all_float(0)),
                     select_float(is_last, PICK(p->back_cut, lane), all_float(0)), step);
    }
    return at;
}

/* Finds the cells of the samples k of the rays of the mask. */
CAST void find_cells(const iso_cast *c, const walk *w, vi mask, vi k, vi cell[3])
{
    const vf from_start = to_float(k);
    vf off = all_float(0); /* from the middle of the cell */
    for (int a = 0; a < 3; ++a) {
        const vf at = w->origin[a] + from_start * w->p.step[a];
        cell[a] = to_int(at);
        off = most(off, absolute(at - to_float(cell[a]) - 0.5f));
    }
    const vi unsure = mask & ((off > 0.5f - c->margin) | (k == 0) | (k == w->p.count - 1));
    if (any(unsure)) {
        vf whole;
        const points exact = sample_at(w, lane_numbers(), k, &whole);
        for (int a = 0; a < 3; ++a)
            cell[a] = select_int(unsure, exact.cell[a], cell[a]);
    }
}

/* Returns the segment that leaves the cube of `side` blocks that begins at the block. */
CAST vi leave_cube(const walk *w, const vi block[3], vi side, vi k)
{
    vf last = all_float(1e9f);
    for (int a = 0; a < 3; ++a) {
        const vi face = block[a] + select_int(w->is_down[a], 1 - side, side);
        last = least(last, to_float(face << ISO_CAST_BLOCK_SHIFT) * w->per_cell[a] + w->first_exit[a]);
    }
    const vi next = to_int(last) + 1, after = k + 1;
    return select_int(next > after, next, after);
}

/* Notes the segments of the rays of the mask that have to be looked at. */
CAST void note(spots *s, vi mask, vi k)
{
    int count;
    const vi lane = pack_lanes(mask, &count), at = PICK(k, lane);
    memcpy(s->lane + s->count, &lane, sizeof lane);
    memcpy(s->k + s->count, &at, sizeof at);
    s->count += count;
}

CAST vi block_of(const iso_cast *c, const vi cell[3], vi mask, vi block[3])
{
    for (int a = 0; a < 3; ++a)
        block[a] = cell[a] >> ISO_CAST_BLOCK_SHIFT;
    return (block[0] + c->block_count[0] * (block[1] + c->block_count[1] * block[2])) & mask;
}

/* Returns a mask of the cells that can be visible, from the bits of their block's words; 0 in an empty block. */
CAST vi can_show(const iso_cast *c, const vi cell[3], vi block)
{
    const vi word = GATHER(c->cells, 2 * block + ((cell[2] >> 1) & 1), 4);
    const vi bit = (cell[0] & 3) + ((cell[1] & 3) << 2) + ((cell[2] & 1) << 4);
    return (word << (31 - bit)) < 0;
}

/* The cells of the next segments of rays that are in a visible block; returns the segment after them. */
CAST vi seek_in_cells(const iso_cast *c, walk *w, vi mask, vi k, const vi first_cell[3], vi first_block)
{
    vi shows[AT_ONCE];
    shows[0] = mask & can_show(c, first_cell, first_block);
    for (int i = 1; i < AT_ONCE; ++i) {
        const vi active = mask & (k + i < w->end);
        vi cell[3], block[3];
        find_cells(c, w, active, k + i, cell);
        shows[i] = active & can_show(c, cell, block_of(c, cell, active, block));
    }
    for (int i = 0; i < AT_ONCE; ++i)
        if (any(shows[i]))
            note(&w->spots, shows[i], k + i);
    return k + AT_ONCE;
}

/* Seeks until the lists are full. */
CAST void seek(const iso_cast *c, walk *w)
{
    vi k = w->k;
    w->spots.count = 0;
    while (w->spots.count <= SPOTS - AT_ONCE * ISO_CAST_WIDTH) {
        const vi active = k < w->end;
        if (!any(active))
            break;
        vi cell[3], block[3], next = k;
        find_cells(c, w, active, k, cell);
        const vi index = block_of(c, cell, active, block);
        const vi side = GATHER(c->octants, index + (w->map & active), 1) & 0xff;
        const vi is_occupied = active & (side == 0), is_empty = active & ~is_occupied;
        if (any(is_occupied))
            next = select_int(is_occupied, seek_in_cells(c, w, is_occupied, k, cell, index), next);
        if (any(is_empty))
            next = select_int(is_empty, leave_cube(w, block, side, k), next);
        k = next;
    }
    const vi none = all_int(0);
    memcpy(w->spots.lane + w->spots.count, &none, sizeof none);
    memcpy(w->spots.k + w->spots.count, &none, sizeof none);
    w->k = k;
}

/* ---- look ---- */

CAST void put(void *list, int at, vi v)
{
    memcpy((int32_t *)list + at, &v, sizeof v);
}
CAST vi take(const void *list, int at, vi mask)
{
    vi v;
    memcpy(&v, (const int32_t *)list + at, sizeof v);
    return v & mask;
}
CAST vf take_floats(const float *list, int at, vi mask)
{
    return (vf)take(list, at, mask);
}

CAST void look_at_spots(const iso_cast *c, walk *w)
{
    const spots *s = &w->spots;
    finds *f = &w->finds;
    f->count = 0;
    for (int i = 0; i < s->count; i += ISO_CAST_WIDTH) {
        int count;
        vf whole;
        const vi mask = lane_numbers() + i < s->count, lane = take(s->lane, i, mask);
        sample now = {.at = sample_at(w, lane, take(s->k, i, mask), &whole)};
        look_there(c, &now, whole, mask);
        const vi shows = mask & (now.depth > 0), from = pack_lanes(shows, &count);
        const int at = f->count;
        put(f->lane, at, PICK(lane, from));
        put(f->voxel, at, PICK(now.place.voxel, from));
        put(f->entry, at, PICK(now.entry.at, from));
        put(f->entry_part, at, (vi)PICK(now.entry.part, from));
        put(f->depth, at, (vi)PICK(now.depth, from));
        for (int a = 0; a < 3; ++a) {
            put(f->part[a], at, (vi)PICK(now.place.part[a], from));
            if (c->normals == ISO_CAST_ON_THE_FLY)
                put(f->cell[a], at, PICK(now.at.cell[a], from));
        }
        if (c->row_count)
            put(f->entry_row, at, (vi)PICK(now.entry.row, from));
        f->count += count;
    }
}

/* ---- shade ---- */

/* Takes the samples that look_at_spots() kept. The parts of a cell have 24 bits left, enough to find the nearest
 * voxel. */
CAST sample take_sample(const iso_cast *c, const finds *f, int i, vi mask)
{
    sample s;
    s.place.voxel = take(f->voxel, i, mask);
    s.entry = (entry){take(f->entry, i, mask), take_floats(f->entry_part, i, mask), all_float(0)};
    if (c->row_count)
        s.entry.row = take_floats(f->entry_row, i, mask);
    s.depth = take_floats(f->depth, i, mask);
    for (int a = 0; a < 3; ++a) {
        s.place.part[a] = take_floats(f->part[a], i, mask);
        s.at.part[a] = (vu)to_int(s.place.part[a] * 0x1p24f) << 8;
        s.at.cell[a] = c->normals == ISO_CAST_ON_THE_FLY ? take(f->cell[a], i, mask) : all_int(0);
    }
    return s;
}

CAST void shade_finds(const iso_cast *c, walk *w)
{
    const vec *v = &w->p.to_viewer;
    finds *f = &w->finds;
    for (int i = 0; i < f->count; i += ISO_CAST_WIDTH) {
        const vi mask = lane_numbers() + i < f->count, lane = take(f->lane, i, mask);
        sample s = take_sample(c, f, i, mask);
        if (c->scale)
            s.depth *= extinction_scale_at(c, &s.place);
        const vec to_viewer = {PICK(v->x, lane), PICK(v->y, lane), PICK(v->z, lane)};
        put(f->opacity, i, (vi)opacity_of(s.depth));
        put(f->light, i, (vi)shade(c, &to_viewer, &s, mask));
        vf color[3];
        color_of(c, &s.entry, color);
        for (int a = 0; a < 3; ++a)
            put(f->color[a], i, (vi)color[a]);
    }
}

/* ---- add ---- */

/* Adds the finds to their rays, with the sums' remainders, as add_to() does. */
static inline void add_finds(walk *w)
{
    const finds *f = &w->finds;
    for (int i = 0; i < f->count; ++i) {
        const int lane = f->lane[i];
        const quad sum = w->sum[lane];
        if (!(sum[3] >= 1e-7f))
            continue;
        const float weight = sum[3] * f->opacity[i], light = weight * f->light[i];
        const quad term = {light * f->color[0][i], light * f->color[1][i], light * f->color[2][i], -weight};
        const quad y = term + w->rest[lane], now = sum + y;
        w->rest[lane] = y - (now - sum);
        w->sum[lane] = now;
    }
}

CAST void end_opaque_rays(walk *w)
{
    EACH_RAY(i)
    w->end[i] = w->sum[i][3] >= 1e-7f ? w->end[i] : 0;
}

/* ---- a tile ---- */

CAST void write_walk(const iso_cast *c, const walk *w, size_t x, size_t y, float *rgba)
{
    sums s;
    EACH_RAY(i)
    for (int a = 0; a < 4; ++a)
        s.sum[a][i] = w->sum[i][a];
    write_packet(c, &s, x, y, rgba);
}

CAST void cast_sparse_packet(const iso_cast *c, size_t x, size_t y, const float reach_mm[2], walk *w, float *rgba)
{
    begin_walk(c, x, y, reach_mm, w);
    for (;;) {
        seek(c, w);
        if (w->spots.count == 0)
            break;
        look_at_spots(c, w);
        shade_finds(c, w);
        add_finds(w);
        end_opaque_rays(w);
    }
    write_walk(c, w, x, y, rgba);
}

CAST void cast_sparse_tile(const iso_cast *c, size_t x, size_t y, float *rgba)
{
    const sums nothing = begin_sums();
    walk w;
    for (size_t row = y; row < y + ISO_CAST_TILE && row < c->height; row += PACKET_ROWS)
        for (size_t column = x; column < x + ISO_CAST_TILE && column < c->width; column += PACKET_COLUMNS) {
            const float *mm = c->reach_mm + 2 * (row / ISO_SCREEN_TILE * c->reach_columns + column / ISO_SCREEN_TILE);
            if (mm[0] <= mm[1]) {
                cast_sparse_packet(c, column, row, mm, &w, rgba);
                continue;
            }
            write_packet(c, &nothing, column, row, rgba);
        }
}

#define ISO_CAST_TILE_OF(width) ISO_CAST_JOIN(iso_cast_tile_, width)
#define ISO_CAST_JOIN(a, b) ISO_CAST_PASTE(a, b)
#define ISO_CAST_PASTE(a, b) a##b

void ISO_CAST_TILE_OF(ISO_CAST_WIDTH)(const iso_cast *c, size_t x, size_t y, float *rgba)
{
    if (c->octants) {
        cast_sparse_tile(c, x, y, rgba);
        return;
    }
    for (size_t row = y; row < y + ISO_CAST_TILE && row < c->height; row += PACKET_ROWS)
        for (size_t column = x; column < x + ISO_CAST_TILE && column < c->width; column += PACKET_COLUMNS)
            cast_packet(c, column, row, rgba);
}

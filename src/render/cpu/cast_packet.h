/* SPDX-License-Identifier: MIT */
/* cast_packet.h - a packet of rays through the volume: ISO_CAST_WIDTH pixels at once, included by one file per width.
 *
 * The segments are those of the reference's midpoints and of the OpenGL ray caster: [k ds, (k + 1) ds] of each ray,
 * clipped to the box, one sample in the middle. Rays are neighbors, and all advance by a segment at once: if one meets
 * a visible sample, most do. Waiting for the others, each at its next visible sample, took longer. */
#pragma once

#include "render/cpu/cast_field.h"

#if ISO_CAST_WIDTH == 1
enum { PACKET_COLUMNS = 1 };
#elif ISO_CAST_WIDTH == 4
enum { PACKET_COLUMNS = 2 };
#else
enum { PACKET_COLUMNS = 4 };
#endif
enum { PACKET_ROWS = ISO_CAST_WIDTH / PACKET_COLUMNS };

typedef struct packet {
    vi count;               /* segments */
    vf front_cut, back_cut; /* parts of the first and the last one that the box cuts off, in segments */
    points at;              /* the middle of segment k */
    points stride;          /* from one to the next */
    vf step[3];             /* the same as floats */
    vi k;
    vi until; /* segments before it are in blocks that show something */
    vec to_viewer;
    double first[ISO_CAST_WIDTH]; /* segments from the camera to segment 0 */
} packet;

/* ---- the rays ---- */

/* Doubles of each ray: a thin shell that is met at a glancing angle shows 1e-5 voxels of shift. */
typedef struct ray_doubles {
    double origin[3][ISO_CAST_WIDTH], direction[3][ISO_CAST_WIDTH], world[3][ISO_CAST_WIDTH];
    double t0[ISO_CAST_WIDTH], t1[ISO_CAST_WIDTH];
} ray_doubles;

/* Red, green, blue, transmittance. */
typedef float quad __attribute__((vector_size(16)));

#define EACH_RAY(i) for (int i = 0; i < ISO_CAST_WIDTH; ++i)

CAST void aim(const iso_cast *c, size_t x, size_t y, ray_doubles *r)
{
    const double to_x = 2 / (double)c->width, to_y = 2 / (double)c->height;
    double side[ISO_CAST_WIDTH], above[ISO_CAST_WIDTH], length[ISO_CAST_WIDTH];
    EACH_RAY(i)
    {
        side[i] = (to_x * ((double)(x + (size_t)(i % PACKET_COLUMNS)) + 0.5) - 1) * c->half_width;
        above[i] = (1 - to_y * ((double)(y + (size_t)(i / PACKET_COLUMNS)) + 0.5)) * c->half_height;
        length[i] = c->orthographic ? 1 : sqrt(1 + side[i] * side[i] + above[i] * above[i]);
    }
    for (int a = 0; a < 3; ++a)
        EACH_RAY(i)
        {
            const double offset = side[i] * c->right[a] + above[i] * c->up[a];
            r->world[a][i] = (c->orthographic ? c->forward[a] : c->forward[a] + offset) / length[i];
            r->origin[a][i] = c->orthographic ? offset : 0;
        }
    for (int a = 0; a < 3; ++a) {
        const double *m = c->to_index + 3 * a;
        EACH_RAY(i)
        r->direction[a][i] = m[0] * r->world[0][i] + m[1] * r->world[1][i] + m[2] * r->world[2][i];
    }
    double moved[3][ISO_CAST_WIDTH];
    for (int a = 0; a < 3; ++a) {
        const double *m = c->to_index + 3 * a;
        EACH_RAY(i)
        moved[a][i] = m[0] * r->origin[0][i] + m[1] * r->origin[1][i] + m[2] * r->origin[2][i];
    }
    for (int a = 0; a < 3; ++a)
        EACH_RAY(i)
    r->origin[a][i] = c->position[a] + moved[a][i];
}

/* Finds the range of each ray in the box, on the kept side of the clip planes. */
CAST void clip(const iso_cast *c, ray_doubles *r)
{
    EACH_RAY(i)
    {
        r->t0[i] = 0;
        r->t1[i] = INFINITY;
    }
    for (int a = 0; a < 3; ++a)
        EACH_RAY(i)
        {
            const double d = r->direction[a][i] == 0 ? 1e-30 : r->direction[a][i], o = r->origin[a][i];
            const double p = -o / d, q = (c->box[a] - o) / d, near = p < q ? p : q, far = p < q ? q : p;
            r->t0[i] = near > r->t0[i] ? near : r->t0[i];
            r->t1[i] = far < r->t1[i] ? far : r->t1[i];
        }
    for (size_t n = 0; n < c->clip_count; ++n) {
        const double *plane = c->clips[n];
        EACH_RAY(i)
        {
            const double above = plane[0] * r->origin[0][i] + plane[1] * r->origin[1][i] + plane[2] * r->origin[2][i] -
                                 plane[3];
            const double rate = plane[0] * r->direction[0][i] + plane[1] * r->direction[1][i] +
                                plane[2] * r->direction[2][i];
            const double t = -above / rate;
            if (rate > 0)
                r->t0[i] = t > r->t0[i] ? t : r->t0[i];
            else if (rate < 0)
                r->t1[i] = t < r->t1[i] ? t : r->t1[i];
            else if (above < 0)
                r->t1[i] = r->t0[i];
        }
    }
}

/* Splits a double into a whole number and 32 bits of fraction. */
CAST void to_fixed(const double *x, vi *whole, vu *part)
{
    int32_t w[ISO_CAST_WIDTH];
    uint32_t p[ISO_CAST_WIDTH];
    EACH_RAY(i)
    {
        const int64_t fixed = (int64_t)floor(x[i] * 0x1p32); /* as one number: a value just below 0 is -2^-32, not -1 */
        w[i] = (int32_t)(fixed >> 32);
        p[i] = (uint32_t)fixed;
    }
    memcpy(whole, w, sizeof w);
    memcpy(part, p, sizeof p);
}

CAST packet begin(const iso_cast *c, size_t x, size_t y)
{
    ray_doubles r;
    packet p = {0};
    double first[ISO_CAST_WIDTH], at[ISO_CAST_WIDTH], stride[ISO_CAST_WIDTH];
    aim(c, x, y, &r);
    clip(c, &r);
    EACH_RAY(i)
    {
        const double begin = r.t0[i] / c->step_mm, end = r.t1[i] / c->step_mm;
        const bool hits = r.t1[i] > r.t0[i];
        first[i] = hits ? floor(begin) : 0;
        const double count = hits ? ceil(end) - first[i] : 0;
        p.count[i] = (int32_t)count;
        p.front_cut[i] = hits ? (float)(begin - first[i]) : 0;
        p.back_cut[i] = hits ? (float)(first[i] + count - end) : 0;
        p.first[i] = first[i];
    }
    for (int a = 0; a < 3; ++a) {
        EACH_RAY(i)
        {
            const bool hits = r.t1[i] > r.t0[i];
            stride[i] = hits ? c->step_mm * r.direction[a][i] : 0;
            at[i] = hits ? r.origin[a][i] + c->cells_before + (first[i] + 0.5) * stride[i] : 0;
        }
        to_fixed(at, &p.at.cell[a], &p.at.part[a]);
        to_fixed(stride, &p.stride.cell[a], &p.stride.part[a]);
        EACH_RAY(i) p.step[a][i] = (float)stride[i];
    }
    EACH_RAY(i)
    {
        p.to_viewer.x[i] = (float)-r.world[0][i];
        p.to_viewer.y[i] = (float)-r.world[1][i];
        p.to_viewer.z[i] = (float)-r.world[2][i];
    }
    return p;
}

/* ---- along them ---- */

CAST void add(points *p, int a, vi cell, vu part)
{
    const vu sum = p->part[a] + part;
    p->cell[a] += cell - (vi)(sum < part); /* a mask is -1 where bits were carried */
    p->part[a] = sum;
}


/* Advances the rays of the mask by one segment. */
CAST void advance(packet *p, vi mask)
{
    for (int a = 0; a < 3; ++a)
        add(&p->at, a, p->stride.cell[a] & mask, p->stride.part[a] & (vu)mask);
    p->k -= mask;
}

/* Advances by n segments: n below 2^15. */
CAST void advance_by(packet *p, vi n)
{
    for (int a = 0; a < 3; ++a) {
        const vu low = (vu)n * (p->stride.part[a] & 0xffff), high = (vu)n * (p->stride.part[a] >> 16);
        const vu part = low + (high << 16);
        const vi carry = (vi)(part < low);
        add(&p->at, a, n * p->stride.cell[a] + (vi)(high >> 16) - carry, part);
    }
    p->k += n;
}

/* Moves places to the middles of segments that the box cuts at the front and back; returns their remaining parts. A
 * number just below 0 becomes a float just above -1 plus 1, and must stay below the next whole number. */
CAST vf cut(points *at, vf front, vf back, const vf step[3])
{
    const vf shift = 0.5f * (front - back), most_part = all_float(0x1.fffffep30f);
    for (int a = 0; a < 3; ++a) {
        const vf delta = shift * step[a], low = round_down(delta);
        add(at, a, to_int(low), (vu)to_int(least((delta - low) * 0x1p31f, most_part)) << 1);
    }
    return 1.0f - front - back;
}

/* Returns the middles of the segments, cut ones included; *whole gets the remaining part of each. */
CAST points middles(const packet *p, vf *whole)
{
    points at = p->at;
    const vi is_first = p->k == 0, is_last = p->k == p->count - 1;
    *whole = all_float(1);
    if (any(is_first | is_last))
        *whole = cut(&at, select_float(is_first, p->front_cut, all_float(0)),
                     select_float(is_last, p->back_cut, all_float(0)), p->step);
    return at;
}

/* One look at the blocks of the rays of the mask that do not know theirs: past the blocks nearer than the distance,
 * which are empty; the number of segments through them is a little less than rounding could make of it. */
CAST void leave_blocks_once(const iso_cast *c, packet *p, vi ask)
{
    vf whole;
    const points at = middles(p, &whole);
    vi block[3];
    for (int a = 0; a < 3; ++a)
        block[a] = at.cell[a] >> ISO_CAST_BLOCK_SHIFT;
    const vi index = block[0] + c->block_count[0] * (block[1] + c->block_count[1] * block[2]);
    const vi distance = GATHER(c->distance, index & ask, 1) & 0xff;
    const vi is_empty = distance > 0, reach = select_int(is_empty, distance, all_int(1)); /* in blocks */
    vf steps = all_float(32000);
    for (int a = 0; a < 3; ++a) {
        const vi forth = p->step[a] > 0;
        const vi face = (block[a] + select_int(forth, reach, 1 - reach)) << ISO_CAST_BLOCK_SHIFT;
        const vf way = to_float(face - at.cell[a]) - to_float((vi)(at.part[a] >> 8)) * 0x1p-24f;
        const vf along = way / p->step[a];
        steps = select_float(p->step[a] == 0, steps, least(steps, along));
    }
    const vi n = to_int(most(steps * 0.99999f - 0.001f, all_float(0))) + 1;
    p->until = select_int(ask & ~is_empty, p->k + n, p->until);
    advance_by(p, n & ask & is_empty);
}

/* A packet's sample: its place, and its visible color. */
typedef struct sample {
    points at;
    place place;
    entry entry;
    vf depth; /* of the whole segment */
} sample;

/* Looks at s->at and s->place; whole: the remaining part of the segment. */
CAST void look_at_place(const iso_cast *c, sample *s, vf whole, vi mask)
{
    if (c->places) {
        mask &= s->place.voxel >= 0;
        s->place.voxel &= mask;
    }
    s->entry = entry_at(c, &s->at, &s->place);
    s->depth = (vf)((vi)(depth_of(c, &s->entry) * whole) & mask);
}
CAST void look_there(const iso_cast *c, sample *s, vf whole, vi mask)
{
    s->place = place_of(c, &s->at, mask);
    look_at_place(c, s, whole, mask);
}

/* Prefetches the memory that the rays will look at AHEAD segments on. The cells of neighboring rays overlap, so that
 * the first voxel of each brings nearly all of it. Places are rough, and one outside the volume does no harm. */
enum { AHEAD = 4 };
CAST void fetch_ahead(const iso_cast *c, const packet *p)
{
    vi cell[3];
    for (int a = 0; a < 3; ++a)
        cell[a] = p->at.cell[a] + to_int(p->step[a] * (float)AHEAD);
    fetch_cells(c, cell);
}

CAST sample look(const iso_cast *c, const packet *p, vi mask)
{
    sample s;
    vf whole;
    s.at = middles(p, &whole);
    look_there(c, &s, whole, mask);
    return s;
}

/* Returns the light that a normal reflects. */
CAST vf light_on(const iso_cast *c, const vec *to_viewer, vec n)
{
    vf sum = all_float(c->ambient);
    for (size_t i = 0; i < c->light_count; ++i) {
        const iso_cast_light *light = &c->lights[i];
        const float l[3] = {(float)light->direction[0], (float)light->direction[1], (float)light->direction[2]};
        sum += light->diffuse * absolute(n.x * l[0] + n.y * l[1] + n.z * l[2]);
        if (c->specular) {
            const vec h = {to_viewer->x + l[0], to_viewer->y + l[1], to_viewer->z + l[2]};
            const vf length = most(root(h.x * h.x + h.y * h.y + h.z * h.z), all_float(1e-30f));
            sum += light->specular * power_of(absolute(n.x * h.x + n.y * h.y + n.z * h.z) / length, c->power);
        }
    }
    return sum;
}

CAST vf shade(const iso_cast *c, const vec *to_viewer, const sample *s, vi mask)
{
    if (c->normals == ISO_CAST_UNLIT)
        return all_float(c->ambient);
    return light_on(c, to_viewer, normal_at(c, &s->at, &s->place, mask));
}

/* A float sum of hundreds of terms, and what rounding left of them. A ray that waits adds nothing: even 0 could move a
 * rest into its sum. */
typedef struct sums {
    vf sum[4], rest[4];
} sums;

CAST void add_to(sums *s, int i, vf term, vi mask)
{
    const vf y = term + s->rest[i], sum = s->sum[i] + y;
    s->rest[i] = select_float(mask, y - (sum - s->sum[i]), s->rest[i]);
    s->sum[i] = select_float(mask, sum, s->sum[i]);
}

/* Adds the samples of the packet to its rays. */
CAST void blend(const iso_cast *c, const packet *p, sample *found, vi shows, sums *s)
{
    if (c->scale)
        found->depth *= extinction_scale_at(c, &found->place);
    const vf weight = s->sum[3] * opacity_of(found->depth);
    const vf light = weight * shade(c, &p->to_viewer, found, shows);
    vf color[3];
    color_of(c, &found->entry, color);
    for (int i = 0; i < 3; ++i)
        add_to(s, i, light * color[i], shows);
    add_to(s, 3, -weight, shows);
}

CAST sums begin_sums(void)
{
    sums s = {.sum = {{0}, {0}, {0}, {0}}};
    s.sum[3] = all_float(1); /* transmittance */
    return s;
}

CAST void write_pixel(const iso_cast *c, const sums *s, int i, size_t column, size_t row, float *rgba)
{
    if (column >= c->width || row >= c->height)
        return;
    float *pixel = rgba + 4 * (row * c->width + column);
    for (int a = 0; a < 3; ++a)
        pixel[a] = s->sum[a][i] + s->sum[3][i] * c->background[a];
    pixel[3] = 1 - s->sum[3][i];
}

CAST void write_packet(const iso_cast *c, const sums *s, size_t x, size_t y, float *rgba)
{
    EACH_RAY(i) write_pixel(c, s, i, x + (size_t)(i % PACKET_COLUMNS), y + (size_t)(i / PACKET_COLUMNS), rgba);
}

/* Every segment of a packet of neighbors. Where the next sample is, is known before this one is shaded, so that the
 * memory is asked for it meanwhile; for codes, which take the most, it is asked some segments earlier. */
CAST void cast_packet(const iso_cast *c, size_t x, size_t y, float *rgba)
{
    packet p = begin(c, x, y);
    sums s = begin_sums();
    vf next_whole;
    vi active = p.k < p.count;
    sample next = {.at = middles(&p, &next_whole)};
    next.place = place_of(c, &next.at, active);
    for (; any(active); active = (p.k < p.count) & (s.sum[3] >= 1e-7f)) {
        sample found = next;
        look_at_place(c, &found, next_whole, active);
        advance(&p, active);
        if (c->voxels && !c->slots)
            fetch_ahead(c, &p);
        next.at = middles(&p, &next_whole);
        next.place = place_of(c, &next.at, p.k < p.count);
        const vi shows = found.depth > 0;
        if (any(shows))
            blend(c, &p, &found, shows, &s);
    }
    write_packet(c, &s, x, y, rgba);
}

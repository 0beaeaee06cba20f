/* SPDX-License-Identifier: MIT */
/* cast_adjoint.h - a tile of pixels of a field, and the gradient of a sum over its pixels (adjoint.h); included by one
 * file per width.
 *
 * Both passes go along the rays front to back and see the same samples. The second one knows the pixel's color, and
 * subtracts each sample: the rest is the light from behind it. So a ray needs the same memory for any length
 * [weiss-2021]. With a = 1 - exp(-tau), transmittance T in front of a sample, its color c and shade l, and r the
 * weighted light from behind:
 *
 *     dL/dtau = T (1 - a) l <g, c> - r        g: derivative of the sum by the pixel
 *     dL/dc   = T a l g                       dL/dl = T a <g, c>
 */
#pragma once

#include "render/cpu/cast_packet.h"

/* The eight voxels around the points, and their weights. At the edge some are the same. */
typedef struct corners {
    vi at[8];
    vf weight[8], part[3];
} corners;

CAST corners corners_of(const iso_cast_field *f, const points *p)
{
    corners k;
    vi low[3], high[3];
    for (int a = 0; a < 3; ++a) {
        const vi cell = p->cell[a], last = all_int(f->size[a] - 1), none = all_int(0);
        const vi before = select_int(cell < 1, none, select_int(cell - 1 > last, last, cell - 1));
        const vi after = select_int(cell < 0, none, select_int(cell > last, last, cell));
        low[a] = before * f->stride[a];
        high[a] = after * f->stride[a];
        k.part[a] = to_float((vi)(p->part[a] >> 8)) * 0x1p-24f;
    }
    for (int i = 0; i < 8; ++i) {
        k.at[i] = (i & 1 ? high[0] : low[0]) + (i & 2 ? high[1] : low[1]) + (i & 4 ? high[2] : low[2]);
        k.weight[i] = (i & 1 ? k.part[0] : 1.0f - k.part[0]) * (i & 2 ? k.part[1] : 1.0f - k.part[1]) *
                      (i & 4 ? k.part[2] : 1.0f - k.part[2]);
    }
    return k;
}

/* A packet's sample of the field. */
typedef struct spot {
    corners corners;
    vf direction[3], scale; /* scale: of the extinction */
    vi entry;
    vf entry_part, is_between; /* is_between: 0 if the value is beyond the table, otherwise 1 */
    vf value[4], slope[4];     /* depth of a whole segment and color, and their change to the next entry */
    vf whole, depth;           /* whole: part of the segment that the box keeps */
} spot;

/* Finds the entry of a value, and what it holds. */
CAST void classify(const iso_cast *c, vf value, spot *s)
{
    const vf x = value * c->entries_per_value + c->first_entry, last = all_float((float)(c->entry_count - 1));
    const vf inside = least(most(x, all_float(0)), last);
    const vi i = to_int(inside), before_last = all_int(c->entry_count - 2);
    s->entry = select_int(i > before_last, before_last, i);
    s->entry_part = inside - to_float(s->entry);
    s->is_between = select_float((x > 0) & (x < last), all_float(1), all_float(0));
    for (int half = 0; half < 2; ++half) {
        const word_quad q = gather_quads(c->entries + half * ISO_CAST_GREEN, s->entry, ISO_CAST_ENTRY);
        for (int k = 0; k < 2; ++k) {
            s->slope[2 * half + k] = (vf)q.word[2 * k + 1];
            s->value[2 * half + k] = (vf)q.word[2 * k] + s->entry_part * s->slope[2 * half + k];
        }
    }
}

CAST vf scale_at(const iso_cast_field *f, const corners *k)
{
    vf v[8], power;
    for (int i = 0; i < 8; ++i)
        v[i] = gather_floats(f->octaves, k->at[i]);
    const vf rest = power_less_one(lerp_in_cell(v, k->part), &power);
    return power + power * rest;
}

CAST spot spot_at(const iso_cast *c, const iso_cast_field *f, const points *at, vf whole, vi mask)
{
    spot s = {.corners = corners_of(f, at), .whole = whole, .scale = all_float(1)};
    vf v[4][8];
    for (int i = 0; i < 8; ++i) {
        const word_quad q = gather_quads(f->voxels, s.corners.at[i], 4);
        for (int k = 0; k < 4; ++k)
            v[k][i] = (vf)q.word[k];
    }
    classify(c, lerp_in_cell(v[0], s.corners.part), &s);
    for (int a = 0; a < 3; ++a)
        s.direction[a] = lerp_in_cell(v[a + 1], s.corners.part);
    if (f->octaves)
        s.scale = scale_at(f, &s.corners);
    s.depth = (vf)((vi)(s.value[0] * s.scale * whole) & mask);
    return s;
}

/* ---- rays ---- */

/* Returns a number in [-1, 1) for each ray of the packet; 0 for seed 0. */
CAST vf phases(uint32_t seed, size_t x, size_t y)
{
    vu h = (vu)lane_numbers() * 0x9e3779b9u + (seed ^ (uint32_t)(x * 0x85ebca6bu + y * 0xc2b2ae35u));
    if (seed == 0)
        return all_float(0);
    h = (h ^ (h >> 16)) * 0x7feb352du;
    h = (h ^ (h >> 15)) * 0x846ca68bu;
    h ^= h >> 16;
    return to_float((vi)(h >> 8)) * 0x1p-23f - 1.0f;
}

/* Returns the samples of the segments: their middles, shifted by the phase, in half segments. The first and the last
 * one, which the box may cut, keep their middles. */
CAST points shifted_middles(const packet *p, vf phase, vf *whole)
{
    points at = middles(p, whole);
    const vi is_inner = (p->k > 0) & (p->k < p->count - 1);
    cut(&at, select_float(is_inner, phase, all_float(0)), all_float(0), p->step);
    return at;
}

/* Returns where a ray's pixel is in the tile's floats. */
CAST size_t pixel_of(size_t x, size_t y, int ray)
{
    return 4 * ((y + (size_t)(ray / PACKET_COLUMNS)) * ISO_CAST_TILE + x + (size_t)(ray % PACKET_COLUMNS));
}

CAST vi rays_that_go_on(const packet *p, vf transmittance)
{
    return (p->k < p->count) & (transmittance >= 1e-7f);
}

CAST void draw_packet(const iso_cast *c, const iso_cast_field *f, const iso_cast_tile_at *t, size_t x, size_t y)
{
    packet p = begin(c, t->x + x, t->y + y);
    const vf phase = phases(t->seed, t->x + x, t->y + y);
    vf sum[4] = {{0}, {0}, {0}, all_float(1)}, whole;
    for (vi active; any(active = rays_that_go_on(&p, sum[3])); advance(&p, active)) {
        const points at = shifted_middles(&p, phase, &whole);
        const spot s = spot_at(c, f, &at, whole, active);
        if (!any(s.depth > 0))
            continue;
        const vec n = shading_normal((vec){s.direction[0], s.direction[1], s.direction[2]});
        const vf weight = sum[3] * opacity_of(s.depth), light = weight * light_on(c, &p.to_viewer, n);
        for (int a = 0; a < 3; ++a)
            sum[a] += light * s.value[a + 1];
        sum[3] -= weight;
    }
    EACH_RAY(i)
    {
        float *pixel = t->rgba + pixel_of(x, y, i);
        for (int a = 0; a < 3; ++a)
            pixel[a] = sum[a][i] + sum[3][i] * c->background[a];
        pixel[3] = 1 - sum[3][i];
    }
}

/* ---- the way back ---- */

/* Returns the derivative of light_on() by the normal. */
CAST vec light_slope(const iso_cast *c, const vec *to_viewer, vec n)
{
    vec sum = {{0}, {0}, {0}};
    for (size_t i = 0; i < c->light_count; ++i) {
        const iso_cast_light *light = &c->lights[i];
        const float l[3] = {(float)light->direction[0], (float)light->direction[1], (float)light->direction[2]};
        const vf cosine = n.x * l[0] + n.y * l[1] + n.z * l[2];
        const vf diffuse = select_float(cosine < 0, all_float(-light->diffuse), all_float(light->diffuse));
        sum = (vec){sum.x + diffuse * l[0], sum.y + diffuse * l[1], sum.z + diffuse * l[2]};
        if (!c->specular)
            continue;
        const vec h = {to_viewer->x + l[0], to_viewer->y + l[1], to_viewer->z + l[2]};
        const vf length = most(root(h.x * h.x + h.y * h.y + h.z * h.z), all_float(1e-30f));
        const vf along = (n.x * h.x + n.y * h.y + n.z * h.z) / length, size = most(absolute(along), all_float(1e-30f));
        /* d |x|^p / dx = p |x|^p / x */
        const vf slope = light->specular * c->power * power_of(size, c->power) / select_float(along < 0, -size, size) /
                         length;
        sum = (vec){sum.x + slope * h.x, sum.y + slope * h.y, sum.z + slope * h.z};
    }
    return sum;
}

/* Derivatives of the sum by a sample: its scalar and direction, its scale's octaves, its table values. */
typedef struct slopes {
    vf field[4], octaves, table[4];
} slopes;

/* Adds them to the gradient, ray by ray: neighbors have voxels in common. */
CAST void scatter(const iso_cast_gradient *g, const spot *s, const slopes *d, vi mask)
{
    EACH_RAY(i)
    {
        if (!mask[i])
            continue;
        const quad field = {d->field[0][i], d->field[1][i], d->field[2][i], d->field[3][i]};
        for (int k = 0; k < 8; ++k) {
            const size_t at = (size_t)s->corners.at[k][i];
            quad sum;
            memcpy(&sum, g->voxels + 4 * at, sizeof sum);
            sum += s->corners.weight[k][i] * field;
            memcpy(g->voxels + 4 * at, &sum, sizeof sum);
            if (g->octaves)
                g->octaves[at] += s->corners.weight[k][i] * d->octaves[i];
        }
        const float part = s->entry_part[i];
        for (int k = 0; g->table && k < 4; ++k) {
            float *at = g->table + 4 * s->entry[i] + k;
            at[0] += (1 - part) * d->table[k][i];
            at[4] += part * d->table[k][i];
        }
    }
}

/* The rest of a ray: its transmittance, and the weighted light from behind the sample. */
typedef struct rest {
    vf transmittance, light, of_pixel[3];
} rest;

/* Computes a sample's derivatives, and steps over it. */
CAST slopes differentiate(const iso_cast *c, const spot *s, const packet *p, rest *r)
{
    slopes d;
    const vf *e = s->direction, eps = all_float((float)ISO_DIRECTION_EPS);
    const vf length = root(e[0] * e[0] + e[1] * e[1] + e[2] * e[2] + eps * eps);
    const vec n = {e[0] / length, e[1] / length, e[2] / length};
    const vf opacity = opacity_of(s->depth), weight = r->transmittance * opacity, light = light_on(c, &p->to_viewer, n);
    vf color = all_float(0);
    for (int a = 0; a < 3; ++a)
        color += r->of_pixel[a] * s->value[a + 1];
    r->light -= weight * light * color;
    const vf by_depth = r->transmittance * (1.0f - opacity) * light * color - r->light;
    r->transmittance -= weight;
    d.table[0] = by_depth * s->scale * s->whole;
    d.octaves = by_depth * s->depth * 0.693147181f;
    vf by_entry = d.table[0] * s->slope[0];
    for (int a = 0; a < 3; ++a) {
        d.table[a + 1] = weight * light * r->of_pixel[a];
        by_entry += d.table[a + 1] * s->slope[a + 1];
    }
    d.field[0] = by_entry * s->is_between * c->entries_per_value;
    /* dn/dd = (1 - n n^T) / length */
    const vec slope = light_slope(c, &p->to_viewer, n);
    const vf along = slope.x * n.x + slope.y * n.y + slope.z * n.z, by_normal = weight * color / length;
    d.field[1] = by_normal * (slope.x - along * n.x);
    d.field[2] = by_normal * (slope.y - along * n.y);
    d.field[3] = by_normal * (slope.z - along * n.z);
    return d;
}

/* Starts the way of a packet whose colors are known. */
CAST rest begin_rest(const iso_cast_tile_at *t, size_t x, size_t y)
{
    rest r = {.transmittance = all_float(1)};
    EACH_RAY(i)
    {
        const size_t at = pixel_of(x, y, i);
        const float *pixel = t->rgba + at, *slope = t->by_pixel + at;
        r.light[i] = slope[3] * (pixel[3] - 1); /* alpha is 1 less the transmittance: a light of -1 behind it all */
        for (int a = 0; a < 3; ++a) {
            r.of_pixel[a][i] = slope[a];
            r.light[i] += slope[a] * pixel[a];
        }
    }
    return r;
}

CAST void differentiate_packet(const iso_cast *c, const iso_cast_field *f, const iso_cast_tile_at *t, size_t x,
                               size_t y, const iso_cast_gradient *g)
{
    packet p = begin(c, t->x + x, t->y + y);
    const vf phase = phases(t->seed, t->x + x, t->y + y);
    rest r = begin_rest(t, x, y);
    vf whole;
    for (vi active; any(active = rays_that_go_on(&p, r.transmittance)); advance(&p, active)) {
        const points at = shifted_middles(&p, phase, &whole);
        const spot s = spot_at(c, f, &at, whole, active);
        const vi shows = g->table ? active : s.depth > 0; /* an entry of 0 has a derivative, too */
        if (!any(shows))
            continue;
        const slopes d = differentiate(c, &s, &p, &r);
        scatter(g, &s, &d, shows);
    }
}

#define ISO_CAST_ADJOINT_OF(width) ISO_CAST_JOIN(iso_cast_adjoint_, width)
void ISO_CAST_ADJOINT_OF(ISO_CAST_WIDTH)(const iso_cast *c, const iso_cast_field *f, const iso_cast_tile_at *t,
                                         const iso_cast_gradient *g)
{
    for (size_t y = 0; y < ISO_CAST_TILE; y += PACKET_ROWS)
        for (size_t x = 0; x < ISO_CAST_TILE; x += PACKET_COLUMNS) {
            if (g)
                differentiate_packet(c, f, t, x, y, g);
            else
                draw_packet(c, f, t, x, y);
        }
}

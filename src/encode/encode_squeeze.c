/* SPDX-License-Identifier: MIT */
/* encode_squeeze.c - the nearest code of "squeeze": by a table of all codes; and
 * by its decoder, without one: Newton finds the cube-dot that decodes to the
 * direction, then at each length the lattice points round it are ranked by the
 * decoder's derivative and the best are decoded. */
#include <math.h>
#include <threads.h>

#include "encode/code_kernel.h"
#include "encode/decode_double.h"
#include "encode/encode_kernel.h"
#include "encode/nearest_table.h"
#include "encode/region48.h"

typedef struct local_map {
    double y, z;                           /* the cube-dot that decodes to the direction */
    double y_by_y, y_by_z, z_by_y, z_by_z; /* of (y, z) / x of what decodes, by the cube-dot */
} local_map;

static void decode_at(double y, double z, double *out_y, double *out_z)
{
    iso_vec3 d = iso_squeeze(y, z);
    *out_y = d.y / d.x;
    *out_z = d.z / d.x;
}

/* Differences over `step`, inside the triangle 0 <= z <= y <= 1. */
static void differentiate(local_map *m, double at_y, double at_z, double step)
{
    double dy = m->y + step <= 1 ? step : -step, dz = m->z + step <= m->y ? step : -step, y, z;
    if (m->z + dz < 0)
        dz = -dz;
    decode_at(m->y + dy, m->z, &y, &z);
    m->y_by_y = (y - at_y) / dy, m->z_by_y = (z - at_z) / dy;
    decode_at(m->y, m->z + dz, &y, &z);
    m->y_by_z = (y - at_y) / dz, m->z_by_z = (z - at_z) / dz;
}

/* wanted_y, wanted_z: of the sorted direction. A step that does not help is halved. */
static local_map invert(double wanted_y, double wanted_z)
{
    local_map m = {.y = wanted_y, .z = wanted_z};
    double at_y, at_z, step = 1;
    decode_at(m.y, m.z, &at_y, &at_z);
    differentiate(&m, at_y, at_z, 1e-6);
    double off = hypot(wanted_y - at_y, wanted_z - at_z);
    for (int i = 0; i < 60 && off > 1e-7; ++i) {
        double det = m.y_by_y * m.z_by_z - m.y_by_z * m.z_by_y, ry = wanted_y - at_y, rz = wanted_z - at_z;
        local_map next = m;
        next.y = fmin(fmax(m.y + step * (m.z_by_z * ry - m.y_by_z * rz) / det, 0), 1);
        next.z = fmin(fmax(m.z + step * (m.y_by_y * rz - m.z_by_y * ry) / det, 0), next.y);
        decode_at(next.y, next.z, &at_y, &at_z);
        double next_off = hypot(wanted_y - at_y, wanted_z - at_z);
        if (next_off < off) {
            m = next, off = next_off, step = fmin(1, 2 * step);
            differentiate(&m, at_y, at_z, 1e-6);
        } else {
            decode_at(m.y, m.z, &at_y, &at_z);
            step *= 0.5;
        }
    }
    differentiate(&m, at_y, at_z, 1 / 255.0); /* half a lattice step: what candidates differ by */
    return m;
}

enum { SHORTLIST = 48 };

typedef struct shortlist {
    double cost[SHORTLIST];
    iso_vec3 e[SHORTLIST];
    int count;
} shortlist;

/* Sorted by cost; the dearest falls out. */
static void offer(shortlist *s, double cost, iso_vec3 e)
{
    if (s->count == SHORTLIST && cost >= s->cost[SHORTLIST - 1])
        return;
    int at = s->count < SHORTLIST ? s->count++ : SHORTLIST - 1;
    for (; at > 0 && s->cost[at - 1] > cost; --at) {
        s->cost[at] = s->cost[at - 1];
        s->e[at] = s->e[at - 1];
    }
    s->cost[at] = cost;
    s->e[at] = e;
}

/* The four by four lattice points round the cube-dot at each length: near the edges
 * the decoder shrinks them to less than a hole. */
static void gather(shortlist *s, const local_map *m, double wanted_y, double wanted_z)
{
    /* Squared angle of a small (dy, dz) in the plane x = 1, but for a factor. */
    double r2 = 1 + wanted_y * wanted_y + wanted_z * wanted_z;
    for (double a = 255; a > 85; a -= 2) {
        double b0 = 2 * floor((a * m->y - 1) / 2) + 1, c0 = 2 * floor((a * m->z - 1) / 2) + 1;
        for (int i = 0; i < 16; ++i) {
            double b = b0 + 2 * (i % 4) - 2, c = c0 + 2 * (i / 4) - 2;
            if (b > a || c > b || c < 1)
                continue;
            double ry = b / a - m->y, rz = c / a - m->z;
            double dy = m->y_by_y * ry + m->y_by_z * rz, dz = m->z_by_y * ry + m->z_by_z * rz;
            double radial = dy * wanted_y + dz * wanted_z;
            offer(s, dy * dy + dz * dz - radial * radial / r2, iso_v3(a, b, c));
        }
    }
}

static iso_vec3 search(iso_vec3 d)
{
    local_map m = invert(d.y / d.x, d.z / d.x);
    shortlist s = {.count = 0};
    gather(&s, &m, d.y / d.x, d.z / d.x);
    iso_vec3 best = s.e[0];
    double best_distance = INFINITY;
    for (int i = 0; i < s.count; ++i) {
        iso_vec3 off = iso_sub(iso_normalize(iso_squeeze(s.e[i].y / s.e[i].x, s.e[i].z / s.e[i].x)), d);
        double distance = iso_dot(off, off);
        if (distance < best_distance) {
            best_distance = distance;
            best = s.e[i];
        }
    }
    return best;
}

void iso_encode_squeeze_exact(const float *restrict directions, uint8_t *restrict bytes, size_t count)
{
    for (size_t i = 0; i < count; ++i) {
        double v[3] = {directions[3 * i], directions[3 * i + 1], directions[3 * i + 2]};
        int order[3];
        iso_rank(v, order);
        iso_vec3 d = iso_normalize(iso_v3(fabs(v[order[0]]), fabs(v[order[1]]), fabs(v[order[2]])));
        if (d.x > 0)
            iso_region48_bytes(v, order, search(d), bytes + 3 * i);
        else
            bytes[3 * i] = bytes[3 * i + 1] = bytes[3 * i + 2] = 128;
    }
}

/* ---- by the table ---- */

/* A constant that takes half a second to work out: made by the first call, kept until the process ends. It would be
 * in the program's text if it were smaller than 15 MB. */
static iso_nearest_table table;
static once_flag table_once = ONCE_FLAG_INIT;

static void make_table(void)
{
    (void)iso_nearest_table_create(ISO_DECODER_SQUEEZE, &table, NULL); /* without memory it stays empty */
}

void iso_encode_squeeze(const float *restrict directions, uint8_t *restrict bytes, size_t count)
{
    call_once(&table_once, make_table);
    if (table.blocks)
        iso_nearest_encode(&table, directions, bytes, count);
    else
        iso_encode_squeeze_exact(directions, bytes, count);
}

const iso_code_info iso_code_squeeze = {
    .name = "squeeze",
    .summary = "48 regions, half the hole of region48; direction only",
    .bytes = 3,
    .is_textured = true,
    .decoder = ISO_DECODER_SQUEEZE,
    .encode = iso_encode_squeeze,
    .hole = iso_code_hole_of_unsigned,
};

/* SPDX-License-Identifier: MIT */
#include "lab/codes/hole.h"

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>

static const double degree = 0.017453292519943295;

/* Members in buckets of the plane x = 1 (gnomonic), in which the chamber is the
 * triangle 0 <= z <= y <= 1. */
typedef struct bucket_grid {
    size_t size;      /* buckets along y and along z */
    uint32_t *first;  /* first member of each bucket; size^2 + 1 */
    iso_vec3 *sorted; /* unit vectors, bucket by bucket */
} bucket_grid;

typedef struct search {
    bucket_grid grid;
    double best; /* chord length */
    iso_vec3 where;
    double tolerance; /* rad */
} search;

static size_t bucket_along(const bucket_grid *g, double t)
{
    double at = t * (double)g->size;
    return at >= (double)g->size ? g->size - 1 : (size_t)at;
}

static size_t bucket_of(const bucket_grid *g, iso_vec3 d)
{
    return bucket_along(g, d.z / d.x) * g->size + bucket_along(g, d.y / d.x);
}

static iso_status grid_build(bucket_grid *g, const iso_vec3 *directions, size_t count, iso_error *err)
{
    g->size = (size_t)fmin(fmax(sqrt((double)count * 0.5), 1), 2048); /* about four members per bucket */
    g->first = calloc(g->size * g->size + 2, sizeof *g->first);
    g->sorted = malloc(count * sizeof *g->sorted);
    if (!g->first || !g->sorted || count > UINT32_MAX)
        return iso_fail(err, ISO_E_MEMORY, "hole: no memory for %zu directions", count);
    for (size_t i = 0; i < count; ++i) {
        iso_vec3 d = directions[i];
        if (!(d.x > 0 && d.x >= d.y && d.y >= d.z && d.z >= 0))
            return iso_fail(err, ISO_E_RANGE, "hole: direction %zu is (%g, %g, %g), must be x >= y >= z >= 0", i, d.x,
                            d.y, d.z);
        ++g->first[bucket_of(g, d) + 2];
    }
    for (size_t b = 2; b < g->size * g->size + 2; ++b)
        g->first[b] += g->first[b - 1];
    /* first[b + 1] is the next free place of bucket b; in the end it is the beginning of b + 1. */
    for (size_t i = 0; i < count; ++i)
        g->sorted[g->first[bucket_of(g, directions[i]) + 1]++] = iso_normalize(directions[i]);
    return ISO_OK;
}

static void scan_bucket(const bucket_grid *g, size_t y, size_t z, iso_vec3 q, double *nearest)
{
    size_t b = z * g->size + y;
    for (uint32_t i = g->first[b]; i < g->first[b + 1]; ++i) {
        iso_vec3 off = iso_sub(g->sorted[i], q);
        *nearest = fmin(*nearest, iso_dot(off, off));
    }
}

/* Returns the chord to the nearest member, searching rings of buckets around q's own.
 * Beyond ring k all members are at least k / size away in the plane. An angle is at least
 * that distance / (1 + r^2), with r the largest distance from the axis on the path. */
static double nearest_chord(const bucket_grid *g, iso_vec3 q)
{
    double y = q.y / q.x, z = q.z / q.x, from_axis = sqrt(y * y + z * z), nearest = INFINITY;
    long at_y = (long)bucket_along(g, y), at_z = (long)bucket_along(g, z), size = (long)g->size;
    for (long ring = 0; ring <= size; ++ring) {
        for (long bz = at_z - ring; bz <= at_z + ring; ++bz) {
            if (bz < 0 || bz >= size)
                continue;
            bool whole_row = bz == at_z - ring || bz == at_z + ring;
            for (long by = at_y - ring; by <= at_y + ring; by += whole_row || ring == 0 ? 1 : 2 * ring)
                if (by >= 0 && by < size)
                    scan_bucket(g, (size_t)by, (size_t)bz, q, &nearest);
        }
        double beyond = (double)ring / (double)size, r = from_axis + beyond;
        double angle = beyond / (1 + r * r);
        if (nearest <= 4 * sin(angle / 2) * sin(angle / 2))
            break;
    }
    return sqrt(nearest);
}

static double chord_to_angle(double chord)
{
    return 2 * asin(fmin(chord / 2, 1));
}

static void visit(search *s, iso_vec3 a, iso_vec3 b, iso_vec3 c, int depth, int until)
{
    iso_vec3 q = iso_normalize(iso_add(iso_add(a, b), c));
    double chord = nearest_chord(&s->grid, q);
    if (chord > s->best) {
        s->best = chord;
        s->where = q;
    }
    double radius = fmax(iso_norm(iso_sub(a, q)), fmax(iso_norm(iso_sub(b, q)), iso_norm(iso_sub(c, q))));
    if (depth >= until || chord_to_angle(chord) + chord_to_angle(radius) <= chord_to_angle(s->best) + s->tolerance)
        return;
    iso_vec3 ab = iso_normalize(iso_add(a, b)), bc = iso_normalize(iso_add(b, c)), ca = iso_normalize(iso_add(c, a));
    visit(s, ab, bc, ca, depth + 1, until);
    visit(s, a, ab, ca, depth + 1, until);
    visit(s, b, bc, ab, depth + 1, until);
    visit(s, c, ca, bc, depth + 1, until);
}

iso_status iso_hole_measure(const iso_vec3 *directions, size_t count, double tolerance_deg, iso_hole *hole,
                            iso_error *err)
{
    search s = {.tolerance = fmax(tolerance_deg, 1e-7) * degree};
    if (count == 0)
        return iso_fail(err, ISO_E_RANGE, "hole: 0 directions, must be at least 1");
    iso_status status = grid_build(&s.grid, directions, count, err);
    if (status == ISO_OK) {
        const iso_vec3 face = {1, 0, 0}, edge = iso_normalize(iso_v3(1, 1, 0)), corner = iso_normalize(iso_v3(1, 1, 1));
        visit(&s, face, edge, corner, 0, 6); /* a coarse pass, so that the bound is tight early */
        visit(&s, face, edge, corner, 0, 40);
        *hole = (iso_hole){chord_to_angle(s.best) / degree, s.where};
    }
    free(s.grid.first);
    free(s.grid.sorted);
    return status;
}

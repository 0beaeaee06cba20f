/* SPDX-License-Identifier: MIT */
#include "pbrt/pbrt.h"

#include <limits.h>
#include <math.h>

static bool shows(const float *point)
{
    return point && (point[ISO_BAKE_EXTINCTION] > 0 || point[ISO_BAKE_COLOR] >= 0);
}

/* Finds the range [lo, hi) of visible points; a single point if there is none. */
static void find_box(const iso_baked *b, size_t lo[3], size_t hi[3])
{
    const size_t *n = b->geometry.size;
    for (int a = 0; a < 3; ++a) {
        lo[a] = n[a];
        hi[a] = 0;
    }
    for (size_t z = 0; z < n[2]; ++z)
        for (size_t y = 0; y < n[1]; ++y)
            for (size_t x = 0; x < n[0]; ++x) {
                const size_t at[3] = {x, y, z};
                for (int a = 0; a < 3 && shows(iso_baked_point(b, x, y, z)); ++a) {
                    lo[a] = at[a] < lo[a] ? at[a] : lo[a];
                    hi[a] = at[a] + 1 > hi[a] ? at[a] + 1 : hi[a];
                }
            }
    for (int a = 0; a < 3; ++a) {
        lo[a] = lo[a] < hi[a] ? (lo[a] > 0 ? lo[a] - 1 : 0) : 0;
        hi[a] = hi[a] == 0 ? 1 : hi[a] < n[a] ? hi[a] + 1 : n[a];
    }
}

static bool is_inside(const iso_geometry *g, iso_vec3 world)
{
    const iso_vec3 p = iso_geometry_to_index(g, world);
    const double at[3] = {p.x, p.y, p.z};
    bool inside = true;
    for (int a = 0; a < 3; ++a)
        inside = inside && at[a] > 0 && at[a] < (double)g->size[a];
    return inside;
}

/* Returns a power of ten that scales small and huge volumes: pbrt starts rays about 1e-4 units off a surface. */
static double units_per_mm(double radius_mm)
{
    const double least = 0.1, most = 1e5;
    return radius_mm >= least && radius_mm <= most ? 1 : pow(10, 2 - ceil(log10(radius_mm)));
}

static void take_units(iso_medium *m, double units)
{
    m->units_per_mm = units;
    snprintf(m->unit, sizeof m->unit, units == 1 ? "mm" : "%.9g mm", 1 / units);
    m->geometry.index_to_world = iso_mat3_scale(m->geometry.index_to_world, units);
    m->geometry.origin_mm = iso_scale(m->geometry.origin_mm, units);
    m->camera.position = iso_scale(m->camera.position, units);
    m->camera.half_height *= m->camera.orthographic ? units : 1;
}

iso_status iso_medium_create(const iso_baked *b, const char *made_from, iso_medium *out, iso_error *err)
{
    size_t hi[3];
    *out = (iso_medium){.baked = b, .geometry = b->geometry, .camera = b->view->camera, .made_from = made_from};
    find_box(b, out->first, hi);
    iso_geometry *g = &out->geometry;
    const iso_vec3 first = iso_v3((double)out->first[0], (double)out->first[1], (double)out->first[2]);
    g->origin_mm = iso_geometry_to_world(&b->geometry, first);
    for (int a = 0; a < 3; ++a) {
        g->size[a] = hi[a] - out->first[a];
        g->box_index[a] = (double)g->size[a];
        out->background[a] = b->view->background[a];
    }
    out->camera_is_inside = is_inside(g, b->view->camera.position);
    take_units(out, units_per_mm(iso_geometry_box_radius_mm(&b->geometry)));
    if (iso_geometry_voxel_count(g) > INT_MAX / 3)
        return iso_fail(err, ISO_E_RANGE, "the grid has %zu x %zu x %zu points, limit %d; use a coarser --level",
                        g->size[0], g->size[1], g->size[2], INT_MAX / 3);
    return ISO_OK;
}

void iso_medium_point(const iso_medium *m, size_t x, size_t y, size_t z, float *extinction, float color[3])
{
    const float *point = iso_baked_point(m->baked, m->first[0] + x, m->first[1] + y, m->first[2] + z);
    const bool any = point && point[ISO_BAKE_COLOR] >= 0;
    *extinction = any ? (float)((double)point[ISO_BAKE_EXTINCTION] / m->units_per_mm) : 0;
    for (int c = 0; c < 3; ++c)
        color[c] = any ? point[ISO_BAKE_COLOR + c] : 0;
}

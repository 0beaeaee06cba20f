/* SPDX-License-Identifier: MIT */
#include "volume/geometry.h"

#include <stdint.h>

iso_geometry iso_geometry_axis_aligned(const size_t size[3], const double spacing_mm[3])
{
    iso_geometry g = {.size = {size[0], size[1], size[2]}};
    for (int a = 0; a < 3; ++a) {
        g.index_to_world.m[a][a] = spacing_mm[a];
        g.box_index[a] = (double)size[a];
    }
    g.origin_mm = iso_scale(iso_v3(g.box_index[0] * spacing_mm[0], g.box_index[1] * spacing_mm[1],
                                   g.box_index[2] * spacing_mm[2]),
                            -0.5);
    return g;
}

iso_status iso_geometry_check(const iso_geometry *g, const char *name, iso_error *err)
{
    /* 32 bytes per voxel: the largest element that any stage allocates for one. */
    const size_t limit = SIZE_MAX / 2 / 32;
    size_t count = 1;
    for (int a = 0; a < 3; ++a) {
        if (g->size[a] == 0)
            return iso_fail(err, ISO_E_RANGE, "%s: size %zu x %zu x %zu, each must be at least 1", name, g->size[0],
                            g->size[1], g->size[2]);
        if (g->size[a] > limit / count)
            return iso_fail(err, ISO_E_RANGE, "%s: size %zu x %zu x %zu, at most %zu voxels can be addressed", name,
                            g->size[0], g->size[1], g->size[2], limit);
        count *= g->size[a];
    }
    double spacing[3];
    iso_geometry_spacing_mm(g, spacing);
    const double coarsest = ldexp(ISO_MOST_MM, 32); /* levels of a volume of the largest voxels */
    for (int a = 0; a < 3; ++a)
        if (!(spacing[a] >= ISO_LEAST_MM && spacing[a] <= coarsest))
            return iso_fail(err, ISO_E_RANGE, "%s: a voxel's edge is %g mm, must be %g to %g", name, spacing[a],
                            ISO_LEAST_MM, ISO_MOST_MM);
    double det = iso_mat3_det(g->index_to_world);
    if (!(fabs(det) > 1e-9 * spacing[0] * spacing[1] * spacing[2]) || !isfinite(det))
        return iso_fail(err, ISO_E_RANGE, "%s: the axes (spacings %g, %g, %g mm) span no volume", name, spacing[0],
                        spacing[1], spacing[2]);
    if (!(iso_norm(g->origin_mm) <= ISO_MOST_PLACE_MM))
        return iso_fail(err, ISO_E_RANGE, "%s: the origin is (%g, %g, %g) mm, must be within %g", name, g->origin_mm.x,
                        g->origin_mm.y, g->origin_mm.z, ISO_MOST_PLACE_MM);
    return ISO_OK;
}

iso_geometry iso_geometry_coarser(const iso_geometry *g)
{
    iso_geometry c = *g;
    c.index_to_world = iso_mat3_scale(g->index_to_world, 2);
    for (int a = 0; a < 3; ++a) {
        c.size[a] = (g->size[a] + 1) / 2;
        c.box_index[a] = g->box_index[a] / 2;
    }
    return c;
}

iso_vec3 iso_geometry_to_world(const iso_geometry *g, iso_vec3 index)
{
    return iso_add(g->origin_mm, iso_mul(g->index_to_world, index));
}

iso_vec3 iso_geometry_to_index(const iso_geometry *g, iso_vec3 world_mm)
{
    return iso_mul(iso_mat3_inverse(g->index_to_world), iso_sub(world_mm, g->origin_mm));
}

void iso_geometry_spacing_mm(const iso_geometry *g, double spacing_mm[3])
{
    for (int a = 0; a < 3; ++a)
        spacing_mm[a] = iso_norm(iso_column(g->index_to_world, a));
}

double iso_geometry_min_spacing_mm(const iso_geometry *g)
{
    double s[3];
    iso_geometry_spacing_mm(g, s);
    return fmin(s[0], fmin(s[1], s[2]));
}

double iso_geometry_mean_spacing_mm(const iso_geometry *g)
{
    return cbrt(fabs(iso_mat3_det(g->index_to_world)));
}

static iso_vec3 box_half_mm(const iso_geometry *g, double sx, double sy, double sz)
{
    return iso_mul(g->index_to_world,
                   iso_v3(0.5 * sx * g->box_index[0], 0.5 * sy * g->box_index[1], 0.5 * sz * g->box_index[2]));
}

iso_vec3 iso_geometry_box_center_mm(const iso_geometry *g)
{
    return iso_add(g->origin_mm, box_half_mm(g, 1, 1, 1));
}

double iso_geometry_box_radius_mm(const iso_geometry *g)
{
    double radius = 0; /* a sheared box has diagonals of different lengths */
    for (int corner = 0; corner < 4; ++corner)
        radius = fmax(radius, iso_norm(box_half_mm(g, 1, corner & 1 ? 1 : -1, corner & 2 ? 1 : -1)));
    return radius;
}

iso_mat3 iso_geometry_gradient_to_world(const iso_geometry *g)
{
    return iso_mat3_transpose(iso_mat3_inverse(g->index_to_world));
}


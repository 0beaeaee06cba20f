/* SPDX-License-Identifier: MIT */
/* fields.c - closed-form fields in a box from -1 to 1 mm, each with its unit normals. */
#include <math.h>

#include "atlas/atlas.h"

static double gauss(double x)
{
    return exp(-0.5 * x * x);
}

double iso_atlas_ball(iso_vec3 p, iso_vec3 *n)
{
    *n = iso_scale(iso_normalize(p), -1);
    return fmax(1 - iso_norm(p), 0);
}

/* Returns a solid, gently curved roof with a surface 0.06 mm thick: one or two fine voxels, as in a well-taken scan. */
double iso_atlas_dome(iso_vec3 p, iso_vec3 *n)
{
    const iso_vec3 center = {0.15, 0.1, -2};
    iso_vec3 q = iso_sub(p, center);
    *n = iso_scale(iso_normalize(q), -1);
    return fmin(fmax(0.5 + (2.3 - iso_norm(q)) / 0.06, 0), 1);
}

double iso_atlas_plate(iso_vec3 p, iso_vec3 *n)
{
    *n = iso_normalize(iso_v3(0.3, 0.8, 0.5));
    return gauss(iso_dot(p, *n) / 0.04);
}

/* Returns a shell about 0.1 mm thick. */
double iso_atlas_shell(iso_vec3 p, iso_vec3 *n)
{
    *n = iso_normalize(p);
    return gauss((iso_norm(p) - 0.7) / 0.04);
}

/* Returns a helical vessel, about 0.1 mm across. Searches the nearest turn at the point's own azimuth. */
double iso_atlas_vessel(iso_vec3 p, iso_vec3 *n)
{
    const double turns = 7, tau = 6.283185307179586, radius = 0.5,
                 horizontal = turns * radius / hypot(turns * radius, 1);
    const double azimuth = atan2(p.y, p.x), r = hypot(p.x, p.y), turn = round((p.z * turns - azimuth) / tau);
    const double out = r - radius, up = (p.z - (azimuth + tau * turn) / turns) * horizontal;
    const iso_vec3 outwards = {p.x / r, p.y / r, 0}, along = {-p.y / r, p.x / r, 0};
    const iso_vec3 across = iso_add(iso_scale(along, -sqrt(1 - horizontal * horizontal)), iso_v3(0, 0, horizontal));
    *n = iso_normalize(iso_add(iso_scale(outwards, out), iso_scale(across, up)));
    return fabs(p.z) < 0.8 ? gauss(hypot(out, up) / 0.045) : 0;
}

double iso_atlas_shells(iso_vec3 p, iso_vec3 *n)
{
    double r = iso_norm(p);
    *n = iso_normalize(p);
    return gauss((r - 0.75) / 0.035) + 0.8 * gauss((r - 0.55) / 0.035);
}

/* Returns small balls next to each other: near every surface another one faces it. */
double iso_atlas_balls(iso_vec3 p, iso_vec3 *n)
{
    const double cell = 0.4;
    iso_vec3 q = {p.x - cell * round(p.x / cell), p.y - cell * round(p.y / cell), p.z - cell * round(p.z / cell)};
    *n = iso_scale(iso_normalize(q), -1);
    return fmax(fabs(p.x), fmax(fabs(p.y), fabs(p.z))) < 0.8 ? fmax(1 - iso_norm(q) / 0.2, 0) : 0;
}

/* Returns a homogeneous block of 115/255, and next to it plates of twice that value, two fine voxels thick: one in each
 * pair of coarse voxels, whose mean is the block's value. For 48 voxels. */
double iso_atlas_block_and_plates(iso_vec3 p, iso_vec3 *n)
{
    const long voxel = (long)floor((p.x + 1) * 24), in_turn = voxel % 8;
    *n = iso_v3(1, 0, 0);
    return voxel < 30 ? 115.0 / 255 : in_turn == 1 || in_turn == 2 ? 230.0 / 255 : 0;
}

/* Returns two textures of the same mean: gray, and alternating black and white cells of one fine voxel. For 48
 * voxels. */
double iso_atlas_two_textures(iso_vec3 p, iso_vec3 *n)
{
    const double voxels_per_mm = 24;
    *n = iso_v3(0, 0, 0);
    const long cell = (long)(floor(p.x * voxels_per_mm) + floor(p.y * voxels_per_mm) + floor(p.z * voxels_per_mm));
    return p.x < 0 ? 0.5 : (double)(cell & 1);
}

double iso_atlas_ripples(iso_vec3 p, iso_vec3 *n)
{
    *n = iso_v3(0, 0, 0);
    return 0.5 + 0.25 * sin(19 * p.x + 9 * p.y) + 0.25 * cos(21 * p.y - 5 * p.z);
}

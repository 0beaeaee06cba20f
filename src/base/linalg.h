/* SPDX-License-Identifier: MIT */
/* linalg.h - 3-vectors and 3x3 matrices in double precision, by value. */
#pragma once

#include <math.h>

typedef struct iso_vec3 {
    double x, y, z;
} iso_vec3;

/* Row-major: m[row][column]. The columns of an index-to-world matrix are the
 * world steps of one voxel along x, y and z. */
typedef struct iso_mat3 {
    double m[3][3];
} iso_mat3;

static inline iso_vec3 iso_v3(double x, double y, double z)
{
    return (iso_vec3){x, y, z};
}
static inline iso_vec3 iso_add(iso_vec3 a, iso_vec3 b)
{
    return iso_v3(a.x + b.x, a.y + b.y, a.z + b.z);
}
static inline iso_vec3 iso_sub(iso_vec3 a, iso_vec3 b)
{
    return iso_v3(a.x - b.x, a.y - b.y, a.z - b.z);
}
static inline iso_vec3 iso_scale(iso_vec3 a, double s)
{
    return iso_v3(a.x * s, a.y * s, a.z * s);
}
static inline iso_vec3 iso_madd(iso_vec3 a, iso_vec3 b, double s)
{
    return iso_add(a, iso_scale(b, s));
}
static inline double iso_dot(iso_vec3 a, iso_vec3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
static inline double iso_norm(iso_vec3 a)
{
    return sqrt(iso_dot(a, a));
}
static inline iso_vec3 iso_cross(iso_vec3 a, iso_vec3 b)
{
    return iso_v3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}
/* Scales a vector to length 1. Zero stays zero. */
static inline iso_vec3 iso_normalize(iso_vec3 a)
{
    double n = iso_norm(a);
    return n > 0 ? iso_scale(a, 1 / n) : a;
}
static inline iso_vec3 iso_mul(iso_mat3 a, iso_vec3 v)
{
    return iso_v3(a.m[0][0] * v.x + a.m[0][1] * v.y + a.m[0][2] * v.z,
                  a.m[1][0] * v.x + a.m[1][1] * v.y + a.m[1][2] * v.z,
                  a.m[2][0] * v.x + a.m[2][1] * v.y + a.m[2][2] * v.z);
}
static inline iso_vec3 iso_column(iso_mat3 a, int c)
{
    return iso_v3(a.m[0][c], a.m[1][c], a.m[2][c]);
}
static inline iso_mat3 iso_mat3_scale(iso_mat3 a, double s)
{
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c)
            a.m[r][c] *= s;
    return a;
}
static inline iso_mat3 iso_mat3_transpose(iso_mat3 a)
{
    iso_mat3 t;
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c)
            t.m[c][r] = a.m[r][c];
    return t;
}
static inline double iso_mat3_det(iso_mat3 a)
{
    return iso_dot(iso_column(a, 0), iso_cross(iso_column(a, 1), iso_column(a, 2)));
}
/* Returns the inverse. The caller has checked that the determinant is not zero. */
static inline iso_mat3 iso_mat3_inverse(iso_mat3 a)
{
    iso_vec3 c0 = iso_column(a, 0), c1 = iso_column(a, 1), c2 = iso_column(a, 2);
    double s = 1 / iso_mat3_det(a);
    iso_vec3 r0 = iso_scale(iso_cross(c1, c2), s);
    iso_vec3 r1 = iso_scale(iso_cross(c2, c0), s);
    iso_vec3 r2 = iso_scale(iso_cross(c0, c1), s);
    return (iso_mat3){{{r0.x, r0.y, r0.z}, {r1.x, r1.y, r1.z}, {r2.x, r2.y, r2.z}}};
}

/* SPDX-License-Identifier: MIT */
#include "lab/codes/code_hole.h"

#include <math.h>
#include <stdlib.h>

#include "encode/decode_double.h"
#include "encode/fit.h"

/* The points of a code in one of the 48 regions: (a, b, c) / limit with a >= b >= c >= first, in steps of `step`, of a
 * length from min_length to max_length. a > limit / 3, since longer multiples of a vector have the same direction. */
typedef struct iso_code_points {
    int limit, first, step;
    double min_length, max_length;
} iso_code_points;

static const double degree = 0.017453292519943295;

typedef iso_vec3 decode_function(const void *user, iso_vec3 e);

/* Measures the hole of a lattice. Leaves out vectors up to a third of the limit: longer multiples have the same
 * direction. */
static iso_status hole_of_lattice(const iso_code_points *l, decode_function *decode, const void *user,
                                  double tolerance_deg, iso_hole *hole, iso_error *err)
{
    const size_t side = (size_t)(l->limit / l->step + 1), most = side * (side + 1) * (side + 2) / 6;
    FREED iso_vec3 *directions = malloc(most * sizeof *directions);
    NEED_MEMORY(directions, err, "hole: no memory for %zu directions", most);
    size_t count = 0;
    const double scale = 1.0 / l->limit;
    for (int a = l->limit; 3 * a > l->limit; a -= l->step)
        for (int b = l->first; b <= a; b += l->step)
            for (int c = l->first; c <= b; c += l->step) {
                double length = sqrt((double)a * a + (double)b * b + (double)c * c);
                if (length >= l->min_length && length <= l->max_length)
                    directions[count++] = decode(user, iso_v3(a * scale, b * scale, c * scale));
            }
    return iso_hole_measure(directions, count, tolerance_deg, hole, err);
}

static iso_vec3 decode_by_code(const void *user, iso_vec3 e)
{
    return iso_decode(*(const int *)user, e);
}

static iso_vec3 decode_with_lambda(const void *user, iso_vec3 e)
{
    const double lambda = *(const double *)user;
    double t[3] = {1 - e.y / e.x, (e.y - e.z) / e.x, e.z / e.x};
    for (int i = 0; i < 3; ++i)
        t[i] = lambda * t[i] * t[i] + (1 - lambda) * t[i];
    return iso_v3(t[0] + t[1] + t[2], t[1] + t[2], t[2]);
}

static const iso_code_points odd_points = {255, 1, 2, 0, INFINITY};

iso_status iso_region48_hole(double lambda, double tolerance_deg, iso_hole *hole, iso_error *err)
{
    return hole_of_lattice(&odd_points, decode_with_lambda, &lambda, tolerance_deg, hole, err);
}

static iso_vec3 oct_corner(int u, int v)
{
    return iso_decode_oct(iso_v3(u / 4095.0, v / 4095.0, 0));
}

/* Returns the angular radius of the circle through three unit vectors. */
static double circle_deg(iso_vec3 a, iso_vec3 b, iso_vec3 c)
{
    iso_vec3 ab = iso_sub(b, a), bc = iso_sub(c, b), ca = iso_sub(a, c);
    double area2 = iso_norm(iso_cross(ab, ca));
    return area2 > 0 ? asin(fmin(iso_norm(ab) * iso_norm(bc) * iso_norm(ca) / (2 * area2), 1)) / degree : 0;
}

/* Cuts each cell of the square lattice along the better diagonal. One eighth of the
 * square, u >= v >= -1, has an image of every cell. Cells at the square's edge have
 * duplicate corners (the fold), for which circle_deg returns no area and no hole. */
static iso_hole oct24_hole(void)
{
    iso_hole hole = {0, {0, 0, 1}};
    for (int u = -1; u < 4095; u += 2)
        for (int v = -1; v <= u; v += 2) {
            iso_vec3 p = oct_corner(u, v), q = oct_corner(u + 2, v), r = oct_corner(u, v + 2),
                     s = oct_corner(u + 2, v + 2);
            double one = fmax(circle_deg(p, q, r), circle_deg(q, r, s)),
                   other = fmax(circle_deg(p, q, s), circle_deg(p, r, s));
            if (fmin(one, other) > hole.radius_deg)
                hole = (iso_hole){fmin(one, other), iso_normalize(iso_add(iso_add(p, q), iso_add(r, s)))};
        }
    return hole;
}

/* The points of a lattice code. Fit: lengths within its window. Cube: the hole of the surface is that of all unsigned
 * points, as the largest is at the axes. */
static iso_code_points points_of(iso_code code)
{
    switch (code) {
    case ISO_CODE_FIT: return (iso_code_points){127, 0, 1, 127 - ISO_FIT_REACH, 127 + ISO_FIT_REACH};
    case ISO_CODE_SHELL: return (iso_code_points){127, 0, 1, 127 * ISO_SHELL_MIN, 127};
    case ISO_CODE_FREE: return (iso_code_points){127, 0, 1, 0, INFINITY};
    default: return odd_points;
    }
}

iso_status iso_code_hole(iso_code code, double tolerance_deg, iso_hole *hole, const char **how, iso_error *err)
{
    const iso_code_points points = points_of(code);
    *hole = (iso_hole){0, {1, 0, 0}};
    *how = code == ISO_CODE_OCT24 ? "circles" : code == ISO_CODE_SNORM || code == ISO_CODE_HALF ? "bound" : "exact";
    switch (code) {
    case ISO_CODE_SNORM: /* half a step in each component, all of it across */
        hole->radius_deg = asin(sqrt(3) / 254) / degree;
        return ISO_OK;
    case ISO_CODE_HALF: /* 2^-11 of each component */ hole->radius_deg = asin(0x1p-11) / degree; return ISO_OK;
    case ISO_CODE_OCT24: *hole = oct24_hole(); return ISO_OK;
    default:
        return hole_of_lattice(&points, decode_by_code, &iso_code_describe(code)->decoder, tolerance_deg, hole, err);
    }
}

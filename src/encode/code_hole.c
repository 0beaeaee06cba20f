/* SPDX-License-Identifier: MIT */
#include "encode/code_hole.h"

#include <math.h>
#include <stdlib.h>

#include "encode/decode_double.h"
#include "encode/fit.h"

static const double degree = 0.017453292519943295;

/* Odd or whole (a, b, c), a >= b >= c >= 0, up to `limit`, in lattice steps. */
typedef struct lattice {
    int limit, first, step;
    double min_length, max_length;
} lattice;

typedef iso_vec3 decode_function(const void *user, iso_vec3 e);

/* Longer multiples of a vector hold the same direction, so shorter thirds are left out. */
static iso_status hole_of_lattice(const lattice *l, decode_function *decode, const void *user, double tolerance_deg,
                                  iso_hole *hole, iso_error *err)
{
    const size_t side = (size_t)(l->limit / l->step + 1), most = side * (side + 1) * (side + 2) / 6;
    iso_vec3 *directions = malloc(most * sizeof *directions);
    if (!directions)
        return iso_fail(err, ISO_E_MEMORY, "hole: no memory for %zu directions", most);
    size_t count = 0;
    const double scale = 1.0 / l->limit;
    for (int a = l->limit; 3 * a > l->limit; a -= l->step)
        for (int b = l->first; b <= a; b += l->step)
            for (int c = l->first; c <= b; c += l->step) {
                double length = sqrt((double)a * a + (double)b * b + (double)c * c);
                if (length >= l->min_length && length <= l->max_length)
                    directions[count++] = decode(user, iso_v3(a * scale, b * scale, c * scale));
            }
    iso_status status = iso_hole_measure(directions, count, tolerance_deg, hole, err);
    free(directions);
    return status;
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

static const lattice odd_lattice = {255, 1, 2, 0, INFINITY};

iso_status iso_region48_hole(double lambda, double tolerance_deg, iso_hole *hole, iso_error *err)
{
    return hole_of_lattice(&odd_lattice, decode_with_lambda, &lambda, tolerance_deg, hole, err);
}

/* ---- oct24 ---- */

static iso_vec3 oct_corner(int u, int v)
{
    return iso_decode_oct(iso_v3(u / 4095.0, v / 4095.0, 0));
}

/* The angular radius of the circle through three unit vectors. */
static double circle_deg(iso_vec3 a, iso_vec3 b, iso_vec3 c)
{
    iso_vec3 ab = iso_sub(b, a), bc = iso_sub(c, b), ca = iso_sub(a, c);
    double area2 = iso_norm(iso_cross(ab, ca));
    return area2 > 0 ? asin(fmin(iso_norm(ab) * iso_norm(bc) * iso_norm(ca) / (2 * area2), 1)) / degree : 0;
}

/* Each cell of the square lattice is cut along the better diagonal. One eighth of
 * the square, u >= v >= -1, has an image of every cell. Cells at the square's edge
 * have corners twice (the fold), which circle_deg gives no area and no hole. */
static void oct_hole(iso_hole *hole)
{
    *hole = (iso_hole){0, {0, 0, 1}};
    for (int u = -1; u < 4095; u += 2)
        for (int v = -1; v <= u; v += 2) {
            iso_vec3 p = oct_corner(u, v), q = oct_corner(u + 2, v), r = oct_corner(u, v + 2), s = oct_corner(u + 2, v + 2);
            double one = fmax(circle_deg(p, q, r), circle_deg(q, r, s)), other = fmax(circle_deg(p, q, s), circle_deg(p, r, s));
            if (fmin(one, other) > hole->radius_deg)
                *hole = (iso_hole){fmin(one, other), iso_normalize(iso_add(iso_add(p, q), iso_add(r, s)))};
        }
}

iso_status iso_code_hole(iso_code code, double tolerance_deg, iso_hole *hole, const char **how, iso_error *err)
{
    const int decoder = iso_code_describe(code)->decoder;
    lattice l = {127, 0, 1, 0, INFINITY};
    *how = "exact";
    *hole = (iso_hole){0, {1, 0, 0}};
    switch (code) {
    case ISO_CODE_SNORM: /* half a step in each component, all of it across */
        hole->radius_deg = asin(sqrt(3) / 254) / degree;
        *how = "bound";
        return ISO_OK;
    case ISO_CODE_HALF: /* 2^-11 of each component */
        hole->radius_deg = asin(0x1p-11) / degree;
        *how = "bound";
        return ISO_OK;
    case ISO_CODE_OCT24:
        oct_hole(hole);
        *how = "circles";
        return ISO_OK;
    case ISO_CODE_FIT: /* lengths that the window reaches */
        l.min_length = 127 - ISO_FIT_REACH;
        l.max_length = 127 + ISO_FIT_REACH;
        break;
    case ISO_CODE_SHELL:
        l.min_length = 127 * ISO_SHELL_MIN;
        l.max_length = 127;
        break;
    case ISO_CODE_FREE:
        break;
    case ISO_CODE_CUBE: /* the surface alone has the hole of the whole lattice: at the axes */
    default:
        l = odd_lattice;
    }
    return hole_of_lattice(&l, decode_by_code, &decoder, tolerance_deg, hole, err);
}

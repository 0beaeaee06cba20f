/* SPDX-License-Identifier: MIT */
#include "encode/code_hole.h"

#include <math.h>
#include <stdlib.h>

#include "encode/code_kernel.h"

static const double degree = 0.017453292519943295;

typedef iso_vec3 decode_function(const void *user, iso_vec3 e);

/* Measures the hole of a lattice. Leaves out vectors up to a third of the limit: longer multiples have the same
 * direction. */
static iso_status hole_of_lattice(const iso_code_points *l, decode_function *decode, const void *user,
                                  double tolerance_deg, iso_hole *hole, iso_error *err)
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

static const iso_code_points odd_points = {255, 1, 2, 0, INFINITY};

iso_status iso_region48_hole(double lambda, double tolerance_deg, iso_hole *hole, iso_error *err)
{
    return hole_of_lattice(&odd_points, decode_with_lambda, &lambda, tolerance_deg, hole, err);
}

iso_status iso_code_hole_of_points(const iso_code_info *code, const iso_code_points *points, double tolerance_deg,
                                   iso_hole *hole, const char **how, iso_error *err)
{
    *how = "exact";
    return hole_of_lattice(points, decode_by_code, &code->decoder, tolerance_deg, hole, err);
}

iso_status iso_code_hole_of_signed(const iso_code_info *code, double tolerance_deg, iso_hole *hole, const char **how,
                                   iso_error *err)
{
    const iso_code_points points = {127, 0, 1, 0, INFINITY};
    return iso_code_hole_of_points(code, &points, tolerance_deg, hole, how, err);
}

iso_status iso_code_hole_of_unsigned(const iso_code_info *code, double tolerance_deg, iso_hole *hole, const char **how,
                                     iso_error *err)
{
    return iso_code_hole_of_points(code, &odd_points, tolerance_deg, hole, how, err);
}

iso_status iso_code_hole_of_rounding(double most, iso_hole *hole, const char **how)
{
    hole->radius_deg = asin(most) / degree;
    *how = "bound";
    return ISO_OK;
}

iso_status iso_code_hole(iso_code code, double tolerance_deg, iso_hole *hole, const char **how, iso_error *err)
{
    const iso_code_info *info = iso_code_describe(code);
    *hole = (iso_hole){0, {1, 0, 0}};
    return info->hole(info, tolerance_deg, hole, how, err);
}

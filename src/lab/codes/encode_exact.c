/* SPDX-License-Identifier: MIT */
/* encode_exact.c - exhaustive searches for the best codes in double precision. */
#include "lab/codes/encode_exact.h"

#include <math.h>

#include "encode/decode_double.h"
#include "encode/fit.h"
#include "lab/codes/region48.h"

/* ---- fit ---- */

static double fit_cost(const double e[3], const double u[3], double aim, double mu)
{
    double rr = 0, along = 0;
    for (int a = 0; a < 3; ++a) {
        double r = e[a] - aim * u[a];
        rr += r * r;
        along += r * u[a];
    }
    return rr - along * along + mu * mu * along * along;
}

/* Finds the best fit of one direction. mu < 0: mu of the code, which depends on the length. */
static void fit_one(const float *direction, double mu, uint8_t *bytes)
{
    double u[3] = {direction[0], direction[1], direction[2]}, best = INFINITY, best_e[3] = {0};
    double length = sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2]), aim = 127 * length;
    mu = mu >= 0 ? mu : fmin(ISO_FIT_MU + ISO_FIT_MU_SHORT * fmax(1 - length, 0), 1);
    int order[3];
    for (int a = 0; a < 3 && length > 0; ++a)
        u[a] /= length;
    iso_rank(u, order);
    for (int m = -127; m <= 127 && length > 0; ++m) { /* m: largest component */
        double e[3], at = m / u[order[0]], middle = rint(at * u[order[1]]), low = rint(at * u[order[2]]);
        e[order[0]] = m;
        for (int i = 0; i < 9; ++i) {
            e[order[1]] = fmin(fmax(middle + i % 3 - 1, -127), 127);
            e[order[2]] = fmin(fmax(low + i / 3 - 1, -127), 127);
            double cost = fit_cost(e, u, aim, mu);
            if (cost < best) {
                best = cost;
                best_e[0] = e[0], best_e[1] = e[1], best_e[2] = e[2];
            }
        }
    }
    for (int a = 0; a < 3; ++a)
        bytes[a] = (uint8_t)(int)best_e[a];
}

void iso_encode_fit_exact(const float *restrict directions, uint8_t *restrict bytes, size_t count)
{
    for (size_t i = 0; i < count; ++i)
        fit_one(directions + 3 * i, -1, bytes + 3 * i);
}

void iso_encode_fit_with_mu(double mu, const float *restrict directions, uint8_t *restrict bytes, size_t count)
{
    for (size_t i = 0; i < count; ++i)
        fit_one(directions + 3 * i, mu, bytes + 3 * i);
}

/* ---- region48: the transform T inverts Eq. 2 of [diaz-garcia-2017]. Three quadratic
 * equations and a table are replaced by one monotone equation: the decoded
 * barycentrics U sum to 1 and are f(u_i) / S with S = sum f(u_i), so that
 * u_i(S) = f^-1(S U_i) and sum u_i(S) = 1 has one root. ---- */

static double inverse_f(double y)
{
    const double l = ISO_REGION48_LAMBDA, k = 1 - l;
    return 2 * y / (k + sqrt(k * k + 4 * l * y));
}

iso_vec3 iso_region48_transform(iso_vec3 U)
{
    double lo = 0, hi = 1; /* f(t) <= t, so S <= 1 */
    for (int i = 0; i < 50; ++i) {
        double s = 0.5 * (lo + hi);
        if (inverse_f(s * U.x) + inverse_f(s * U.y) + inverse_f(s * U.z) < 1)
            lo = s;
        else
            hi = s;
    }
    return iso_v3(inverse_f(hi * U.x), inverse_f(hi * U.y), inverse_f(hi * U.z));
}

/* Finds odd (a, b, c), a >= b >= c > 0, whose decoded direction is nearest to the sorted
 * unit vector d. Tries all neighbors of the rounding at each length. Lengths up to 1/3
 * add no direction: three times the vector is on the lattice, too. */
static iso_vec3 region48_search(iso_vec3 d)
{
    iso_vec3 t = iso_region48_transform(iso_v3((d.x - d.y) / d.x, (d.y - d.z) / d.x, d.z / d.x));
    iso_vec3 best = {0, 0, 0};
    double best_distance = INFINITY;
    for (double a = 255; a > 85; a -= 2)
        for (int i = 0; i < 9; ++i) {
            double b = iso_nearest_odd(a * (t.y + t.z)) + 2 * (i % 3) - 2,
                   c = iso_nearest_odd(a * t.z) + 2 * (i / 3) - 2;
            if (b > a || c > b || c < 1)
                continue;
            iso_vec3 e = {a, b, c}, off = iso_sub(iso_normalize(iso_decode_region48(e)), d);
            double distance = iso_dot(off, off);
            if (distance < best_distance) {
                best_distance = distance;
                best = e;
            }
        }
    return best;
}

static void region48_one(const float *direction, uint8_t *bytes)
{
    double v[3] = {direction[0], direction[1], direction[2]};
    int order[3];
    iso_rank(v, order);
    iso_vec3 sorted = {fabs(v[order[0]]), fabs(v[order[1]]), fabs(v[order[2]])};
    if (!(sorted.x > 0)) {
        bytes[0] = bytes[1] = bytes[2] = 128;
        return;
    }
    iso_vec3 e = region48_search(iso_normalize(sorted));
    iso_region48_bytes(v, order, e, bytes);
}

void iso_encode_region48_exact(const float *restrict directions, uint8_t *restrict bytes, size_t count)
{
    for (size_t i = 0; i < count; ++i)
        region48_one(directions + 3 * i, bytes + 3 * i);
}

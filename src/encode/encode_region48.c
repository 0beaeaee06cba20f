/* encode_region48.c - gradients-2017 section 4.3: transform T, then a search
 * along the transformed direction for the lattice point that decodes nearest.
 *
 * T inverts Eq. 2. In place of three quadratic equations and a table it is one
 * monotone equation: the decoded barycentrics U sum to 1 and are f(u_i) / S with
 * S = sum f(u_i), so u_i(S) = f^-1(S U_i) and sum u_i(S) = 1 has one root. */
#include <math.h>

#include "encode/decode_double.h"
#include "encode/encode_kernel.h"

static double inverse_f(double y)
{
    const double l = ISO_REGION48_LAMBDA, k = 1 - l;
    return 2 * y / (k + sqrt(k * k + 4 * l * y));
}

/* Barycentrics before the decoder from those behind it. */
static iso_vec3 transform(iso_vec3 U)
{
    double lo = 0, hi = 1; /* f(t) <= t, so S <= 1 */
    for (int i = 0; i < 40; ++i) {
        double s = 0.5 * (lo + hi);
        if (inverse_f(s * U.x) + inverse_f(s * U.y) + inverse_f(s * U.z) < 1)
            lo = s;
        else
            hi = s;
    }
    return iso_v3(inverse_f(hi * U.x), inverse_f(hi * U.y), inverse_f(hi * U.z));
}

static double nearest_odd(double x)
{
    return 2 * floor(0.5 * x) + 1;
}

/* Odd (a, b, c), a >= b >= c > 0, whose decoded direction is nearest to the
 * sorted unit vector d. Lengths below 1/3 add no direction: three times the
 * vector is on the lattice too. */
static iso_vec3 search(iso_vec3 d)
{
    iso_vec3 t = transform(iso_v3((d.x - d.y) / d.x, (d.y - d.z) / d.x, d.z / d.x));
    iso_vec3 best = {0, 0, 0};
    double best_distance = INFINITY;
    for (double a = 255; a > 85; a -= 2) {
        iso_vec3 e = {a, nearest_odd(a * (t.y + t.z)), nearest_odd(a * t.z)};
        iso_vec3 off = iso_sub(iso_normalize(iso_decode_region48(e)), d);
        double distance = iso_dot(off, off);
        if (distance < best_distance) {
            best_distance = distance;
            best = e;
        }
    }
    return best;
}

static uint8_t to_byte(double odd)
{
    return (uint8_t)((odd + 255) / 2);
}

static void encode_one(const float *direction, uint8_t *bytes)
{
    double v[3] = {direction[0], direction[1], direction[2]};
    int order[3] = {0, 1, 2}; /* largest |component| first */
    if (fabs(v[order[0]]) < fabs(v[order[1]]))
        order[0] = 1, order[1] = 0;
    if (fabs(v[order[1]]) < fabs(v[2])) {
        order[2] = order[1], order[1] = 2;
        if (fabs(v[order[0]]) < fabs(v[2]))
            order[1] = order[0], order[0] = 2;
    }
    iso_vec3 sorted = {fabs(v[order[0]]), fabs(v[order[1]]), fabs(v[order[2]])};
    if (!(sorted.x > 0)) {
        bytes[0] = bytes[1] = bytes[2] = 128;
        return;
    }
    iso_vec3 e = search(iso_normalize(sorted));
    double ranked[3] = {e.x, e.y, e.z};
    for (int a = 0; a < 3; ++a)
        bytes[order[a]] = to_byte(v[order[a]] < 0 ? -ranked[a] : ranked[a]);
}

void iso_encode_region48(const float *restrict directions, uint8_t *restrict bytes, size_t count)
{
    for (size_t i = 0; i < count; ++i)
        encode_one(directions + 3 * i, bytes + 3 * i);
}

/* SPDX-License-Identifier: MIT */
#include "lab/figure/paper_dots.h"

#include <stdlib.h>

#include "lab/codes/hole.h"

/* Returns m, the largest component of lattice points: -m to m for signed codes, only odd numbers for unsigned ones. */
static long largest(bool is_signed, int bits)
{
    return is_signed ? (1L << (bits - 1)) - 1 : (1L << bits) - 1;
}

static long divisor(long a, long b)
{
    while (b) {
        const long rest = a % b;
        a = b, b = rest;
    }
    return labs(a);
}

/* Returns the Moebius function: 0 if a prime divides n twice, else -1 to the power of the number of its primes. */
static int moebius(long n)
{
    int sign = 1;
    for (long p = 2; p <= n; ++p)
        if (n % p == 0) {
            n /= p;
            if (n % p == 0)
                return 0;
            sign = -sign;
        }
    return sign;
}

size_t iso_dots_formula(bool is_signed, int bits)
{
    const long m = largest(is_signed, bits);
    long sum = 0;
    for (long d = 1; d <= m; d += is_signed ? 1 : 2) {
        const long side = is_signed ? 2 * (m / d) + 1 : 2 * ((m / d + 1) / 2);
        sum += moebius(d) * (side * side * side - (is_signed ? 1 : 0));
    }
    return (size_t)sum;
}

static void fill(iso_dots *dots, bool is_signed, long m)
{
    const long step = is_signed ? 1 : 2;
    for (long z = -m; z <= m; z += step)
        for (long y = -m; y <= m; y += step)
            for (long x = -m; x <= m; x += step) {
                const long common = divisor(divisor(x, y), z);
                dots->places += common > 0;
                if (common != 1)
                    continue;
                const double e[3] = {(double)x / (double)m, (double)y / (double)m, (double)z / (double)m};
                double longest[3], d[3];
                const double peak = fmax(fabs(e[0]), fmax(fabs(e[1]), fabs(e[2])));
                for (int c = 0; c < 3; ++c)
                    longest[c] = e[c] / peak; /* far from the middle, where lengths fade */
                iso_code_decode(dots->code, longest, d);
                dots->lattice[dots->count] = iso_v3(e[0], e[1], e[2]);
                dots->unit[dots->count++] = iso_normalize(iso_v3(d[0], d[1], d[2]));
            }
}

iso_status iso_dots_create(iso_code code, int bits, iso_dots *dots, iso_error *err)
{
    const iso_code_info *info = iso_code_describe(code);
    *dots = (iso_dots){.code = code, .bits = bits};
    if (!info->is_textured)
        return iso_fail(err, ISO_E_RANGE, "--code %s has no lattice of three components to draw", info->name);
    if (bits < ISO_DOTS_FEWEST_BITS || bits > ISO_DOTS_MOST_BITS)
        return iso_fail(err, ISO_E_RANGE, "--bits is %d, must be %d to %d: more dots would hide each other", bits,
                        (int)ISO_DOTS_FEWEST_BITS, (int)ISO_DOTS_MOST_BITS);
    const size_t count = iso_dots_formula(info->is_signed, bits);
    dots->lattice = malloc(count * sizeof *dots->lattice);
    dots->unit = malloc(count * sizeof *dots->unit);
    if (!dots->lattice || !dots->unit) {
        iso_dots_destroy(dots);
        return iso_fail(err, ISO_E_MEMORY, "figure: no memory for %zu directions", count);
    }
    fill(dots, info->is_signed, largest(info->is_signed, bits));
    return ISO_OK;
}

void iso_dots_destroy(iso_dots *dots)
{
    if (!dots)
        return;
    free(dots->lattice);
    free(dots->unit);
    *dots = (iso_dots){0};
}

iso_status iso_dots_hole_deg(const iso_dots *dots, double *across_deg, iso_error *err)
{
    iso_vec3 *chamber = malloc(dots->count * sizeof *chamber);
    size_t count = 0;
    iso_hole hole;
    NEED_MEMORY(chamber, err, "figure: no memory for %zu directions", dots->count);
    /* Lattice vectors are sorted exactly, and decoders keep the order. */
    for (size_t i = 0; i < dots->count; ++i) {
        const iso_vec3 e = dots->lattice[i], d = dots->unit[i];
        if (e.x >= e.y && e.y >= e.z && e.z >= 0) {
            chamber[count] = iso_v3(d.x, fmin(d.y, d.x), 0);
            chamber[count].z = fmin(d.z, chamber[count].y);
            ++count;
        }
    }
    const iso_status status = iso_hole_measure(chamber, count, 1e-4, &hole, err);
    free(chamber);
    *across_deg = 2 * hole.radius_deg;
    return status;
}

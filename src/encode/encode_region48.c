/* SPDX-License-Identifier: MIT */
/* encode_region48.c - [diaz-garcia-2017] section 4.3, transform and search, for eight
 * directions at a time: the transform by Newton's method instead of a table, the search
 * over every length that adds directions.
 *
 * At a length a (the largest component, odd) the candidate's cube-dot (b, c) / a is
 * (ry, rz) away from the transformed direction's, at most 1/87. f of Eq. 2 is
 * quadratic, so the decoded candidate follows from (ry, rz) to second order without
 * decoding; the third order changes a distance by 1e-4. */
#include "encode/code_kernel.h"
#include "encode/encode_kernel.h"
#include "encode/simd.h"

#define LAMBDA 0.61f /* ISO_REGION48_LAMBDA; tests compare with the decoder */
#define KAPPA (1 - LAMBDA)

/* The lengths a = 255, 253 .. 87: three times a shorter vector is on the lattice, too.
 * 1 / (a / 2) for each, four per line. */
enum { LENGTHS = 85 };
#define P1(a) 2.0f / (a)
#define P4(a) P1(a), P1((a)-2), P1((a)-4), P1((a)-6)
#define P16(a) P4(a), P4((a)-8), P4((a)-16), P4((a)-24)
static const float per_half[LENGTHS] = {P16(255), P16(223), P16(191), P16(159), P16(127), P4(95), P1(87)};
#undef P16
#undef P4
#undef P1

/* Returns f^-1(y); *slope: its derivative. */
ISO_INLINE v8f inverse_f(v8f y, v8f *slope)
{
    v8f root = v8_sqrt(KAPPA * KAPPA + 4 * LAMBDA * y);
    *slope = 1.0f / root;
    return 2.0f * y / (root + KAPPA);
}

/* Converts decoded barycentrics to those before the decoder, in place, by the S with
 * sum f^-1(S U_i) = 1 (lab/codes/encode_exact.c). Returns S. */
ISO_INLINE v8f transform(v8f *u, v8f *v, v8f *w)
{
    v8f s = KAPPA + LAMBDA * (*u * *u + *v * *v + *w * *w), a, b, c;
    for (int i = 0; i < 4; ++i) {
        v8f sum = inverse_f(s * *u, &a) + inverse_f(s * *v, &b) + inverse_f(s * *w, &c);
        s -= (sum - 1.0f) / (*u * a + *v * b + *w * c);
    }
    *u = inverse_f(s * *u, &a), *v = inverse_f(s * *v, &b), *w = inverse_f(s * *w, &c);
    return s;
}

/* The target direction as its transformed cube-dot (y, z), and the decoded position of a
 * candidate that is off by (ry, rz), in the tangent plane of the direction:
 *     p_k = ry (y[k] + yy[k] ry + yz[k] rz) + rz (z[k] + zz[k] rz),  k = 0, 1 */
typedef struct target {
    v8f at_y, at_z;
    v8f y[2], z[2], yy[2], yz[2], zz[2];
} target;

/* Expands component k of the tangent plane. The decoded vector moves by dU, dV, dW along
 * (1,0,0), (1,1,0), (1,1,1), with
 *     dU = -fu ry + L ry^2, dV = fv (ry - rz) + L (ry - rz)^2, dW = fw rz + L rz^2.
 * across: effect of unit changes of U, V, W across the direction; to first order the
 * effect along it (y, z) divides. */
ISO_INLINE void expand(target *t, int k, const v8f across[3], const v8f f[3], const v8f along[2])
{
    v8f u = across[0], v = across[1], w = across[2], fu = f[0], fv = f[1], fw = f[2], along_y = along[0],
        along_z = along[1];
    v8f y = v * fv - u * fu, z = w * fw - v * fv;
    t->y[k] = y;
    t->z[k] = z;
    t->yy[k] = LAMBDA * (u + v) - y * along_y;
    t->yz[k] = -2 * LAMBDA * v - y * along_z - z * along_y;
    t->zz[k] = LAMBDA * (v + w) - z * along_z;
}

/* Prepares the target for |components| high >= middle >= low of a unit vector. */
ISO_INLINE target prepare(v8f high, v8f middle, v8f low)
{
    target t;
    v8f per_high = 1.0f / high;
    v8f u = (high - middle) * per_high, v = (middle - low) * per_high, w = low * per_high;
    v8f s = transform(&u, &v, &w);
    t.at_y = v + w, t.at_z = w;
    v8f fu = KAPPA + 2 * LAMBDA * u, fv = KAPPA + 2 * LAMBDA * v, fw = KAPPA + 2 * LAMBDA * w;
    /* Across: (-middle, high, 0) / q and (-low high, -low middle, q^2) / q. Unit: the
     * decoded vector's length, s / high. */
    v8f q = v8_sqrt(high * high + middle * middle), unit = high / s, per_q = unit / q;
    v8f u_along = high * unit, v_along = (high + middle) * unit, w_along = (high + middle + low) * unit;
    v8f along_y = v_along * fv - u_along * fu, along_z = w_along * fw - v_along * fv;
    v8f v0 = (high - middle) * per_q, v1 = -low * (high + middle) * per_q;
    const v8f f[3] = {fu, fv, fw}, along[2] = {along_y, along_z};
    expand(&t, 0, (const v8f[3]){-middle * per_q, v0, v0}, f, along);
    expand(&t, 1, (const v8f[3]){-low * high * per_q, v1, v1 + q * unit}, f, along);
    return t;
}

/* Returns the squared distance of the candidate at length a = 2 half. */
ISO_INLINE v8f distance(const target *t, v8f half, float inverse)
{
    v8f y = half * t->at_y - 0.5f, z = half * t->at_z - 0.5f; /* odd b = 2 j + 1 */
    v8f ry = (v8_round(y) - y) * inverse, rz = (v8_round(z) - z) * inverse;
    v8f p = ry * (t->y[0] + t->yy[0] * ry + t->yz[0] * rz) + rz * (t->z[0] + t->zz[0] * rz);
    v8f q = ry * (t->y[1] + t->yy[1] * ry + t->yz[1] * rz) + rz * (t->z[1] + t->zz[1] * rz);
    return p * p + q * q;
}

/* Returns the byte of a component: j of its rank, with its sign. */
ISO_INLINE v8f to_byte(v8f component, v8f high, v8f low, const v8f j[3])
{
    v8f size = v8_abs(component);
    v8f value = v8_select(size >= high, j[0], v8_select(size <= low, j[2], j[1]));
    return v8_select(component < 0.0f, 127.0f - value, 128.0f + value);
}

ISO_INLINE void region48_lanes(float *px, float *py, float *pz)
{
    v8f x = v8_load(px), y = v8_load(py), z = v8_load(pz);
    v8f norm = 1.0f / v8_sqrt(v8_max(x * x + y * y + z * z, v8_set(1e-30f)));
    x *= norm, y *= norm, z *= norm;
    v8f ax = v8_abs(x), ay = v8_abs(y), az = v8_abs(z);
    v8f high = v8_max(ax, v8_max(ay, az)), low = v8_min(ax, v8_min(ay, az));
    v8f middle = v8_max(v8_min(ax, ay), v8_min(v8_max(ax, ay), az));
    v8i undefined = high <= 0.0f;
    target t = prepare(v8_max(high, v8_set(1e-9f)), middle, low);
    v8f best = v8_set(INFINITY), best_half = v8_set(0.5f);
    v8f half = v8_set(127.5f);
    for (int k = 0; k < LENGTHS; ++k, half -= 1.0f) {
        v8f d = distance(&t, half, per_half[k]);
        v8i better = d < best;
        best = v8_select(better, d, best);
        best_half = v8_select(better, half, best_half);
    }
    v8f j[3] = {best_half - 0.5f, v8_round(best_half * t.at_y - 0.5f), v8_round(best_half * t.at_z - 0.5f)};
    v8f center = v8_set(128);
    v8_store(px, v8_select(undefined, center, to_byte(x, high, low, j)));
    v8_store(py, v8_select(undefined, center, to_byte(y, high, low, j)));
    v8_store(pz, v8_select(undefined, center, to_byte(z, high, low, j)));
}

/* This file is compiled with fused products (Makefile), which make the search a third
 * faster. Bytes differ only if two candidates are equally near up to 1e-5. */
ISO_SIMD_ENCODER_FOR(iso_encode_region48, region48_lanes, "avx2,fma", "fma")

const iso_code_info iso_code_region48 = {
    .name = "region48",
    .summary = "48 regions, lambda 0.61 [diaz-garcia-2017]; direction only",
    .bytes = 3,
    .is_textured = true,
    .decoder = ISO_DECODER_REGION48,
    .encode = iso_encode_region48,
};

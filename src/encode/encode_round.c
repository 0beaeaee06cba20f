/* SPDX-License-Identifier: MIT */
/* encode_round.c - codes by rounding: of the vector itself, its cube-dot or the
 * octahedral map; and half floats. */
#include "encode/code_kernel.h"
#include "encode/encode_kernel.h"
#include "encode/simd.h"

/* ---- snorm: 127 d, rounded ---- */

ISO_INLINE void snorm_lanes(float *px, float *py, float *pz)
{
    const v8f limit = v8_set(127);
    float *planes[3] = {px, py, pz};
    for (int a = 0; a < 3; ++a) {
        v8f scaled = 127.0f * v8_load(planes[a]);
        v8_store(planes[a], v8_round(v8_max(v8_min(scaled, limit), -limit)));
    }
}

ISO_SIMD_ENCODER(iso_encode_snorm, snorm_lanes)

const iso_code_info iso_code_snorm = {
    .name = "snorm",
    .summary = "signed bytes of the vector itself, rounded",
    .bytes = 3,
    .is_textured = true,
    .is_signed = true,
    .keeps_length = true,
    .is_linear = true,
    .decoder = ISO_DECODER_LINEAR,
    .encode = iso_encode_snorm,
    .encode_rows = iso_snorm_rows,
};

/* ---- cube: projected on the cube's surface, rounded to odd 255ths. Zero becomes 127.5,
 * rounded to the even 128. ---- */

ISO_INLINE void cube_lanes(float *px, float *py, float *pz)
{
    v8f x = v8_load(px), y = v8_load(py), z = v8_load(pz);
    v8f largest = v8_max(v8_max(v8_abs(x), v8_abs(y)), v8_max(v8_abs(z), v8_set(1e-30f)));
    v8f scale = 127.5f / largest;
    v8_store(px, v8_round(scale * x + 127.5f));
    v8_store(py, v8_round(scale * y + 127.5f));
    v8_store(pz, v8_round(scale * z + 127.5f));
}

ISO_SIMD_ENCODER(iso_encode_cube, cube_lanes)

const iso_code_info iso_code_cube = {
    .name = "cube",
    .summary = "projected on the cube and rounded; direction only",
    .bytes = 3,
    .is_textured = true,
    .decoder = ISO_DECODER_UNIT,
    .encode = iso_encode_cube,
};

/* ---- oct24: 12 + 12 bits of the octahedral map, the best of the cell's four
 * corners ---- */

/* Returns the squared distance of the unit vectors of the decoded (u, v) and of d, which
 * is scaled to |x|+|y|+|z| = 1. */
ISO_INLINE v8f oct_distance(v8f u, v8f v, v8f x, v8f y, v8f z)
{
    v8f au = v8_abs(u), av = v8_abs(v), h = 1.0f - au - av;
    v8f fold = v8_max(-h, v8_set(0));
    v8f du = v8_select(u < 0.0f, fold - au, au - fold), dv = v8_select(v < 0.0f, fold - av, av - fold);
    v8f scale = 1.0f / v8_sqrt(du * du + dv * dv + h * h);
    v8f ox = du * scale - x, oy = dv * scale - y, oz = h * scale - z;
    return ox * ox + oy * oy + oz * oz;
}

ISO_INLINE void oct24_lanes(float *px, float *py, float *pz)
{
    v8f x = v8_load(px), y = v8_load(py), z = v8_load(pz), zero = v8_set(0);
    v8f sum = v8_abs(x) + v8_abs(y) + v8_abs(z);
    v8i undefined = sum <= zero;
    v8f norm = 1.0f / v8_sqrt(v8_max(x * x + y * y + z * z, v8_set(1e-30f)));
    v8f flat = 1.0f / v8_max(sum, v8_set(1e-30f));
    v8f au = v8_abs(x) * flat, av = v8_abs(y) * flat;
    v8f out_u = v8_select(z < zero, 1.0f - av, au), out_v = v8_select(z < zero, 1.0f - au, av);
    v8f u = v8_select(x < zero, -out_u, out_u), v = v8_select(y < zero, -out_v, out_v);
    x *= norm, y *= norm, z *= norm;
    v8f low_u = v8_min(v8_round((u + 1.0f) * 2047.5f - 0.5f), v8_set(4094));
    v8f low_v = v8_min(v8_round((v + 1.0f) * 2047.5f - 0.5f), v8_set(4094));
    low_u = v8_max(low_u, zero), low_v = v8_max(low_v, zero);
    v8f best = v8_set(INFINITY), best_u = zero, best_v = zero;
    for (int corner = 0; corner < 4; ++corner) {
        v8f qu = low_u + (float)(corner & 1), qv = low_v + (float)(corner >> 1);
        v8f distance = oct_distance(qu * (2 / 4095.0f) - 1.0f, qv * (2 / 4095.0f) - 1.0f, x, y, z);
        v8i better = (distance < best) & ((qu + qv) > 0.0f); /* (0,0) is "undefined" */
        best = v8_select(better, distance, best);
        best_u = v8_select(better, qu, best_u);
        best_v = v8_select(better, qv, best_v);
    }
    best_u = v8_select(undefined, zero, best_u);
    best_v = v8_select(undefined, zero, best_v);
    /* Low byte of u; high nibble of u and low nibble of v; high byte of v. */
    v8f u_high = v8_round(best_u * (1 / 256.0f) - 0.498f), v_high = v8_round(best_v * (1 / 16.0f) - 0.48f);
    v8_store(px, best_u - 256.0f * u_high);
    v8_store(py, u_high + 16.0f * (best_v - 16.0f * v_high));
    v8_store(pz, v_high);
}

ISO_SIMD_ENCODER(iso_encode_oct24, oct24_lanes)

static void oct24_lattice(const uint8_t *bytes, double e[3])
{
    e[0] = 2 * (bytes[0] | (bytes[1] & 15) << 8) / 4095.0 - 1;
    e[1] = 2 * (bytes[1] >> 4 | bytes[2] << 4) / 4095.0 - 1;
    e[2] = 0;
}

const iso_code_info iso_code_oct24 = {
    .name = "oct24",
    .summary = "octahedral map, 12 + 12 bits, for nearest fetches; direction only",
    .bytes = 3,
    .decoder = ISO_DECODER_OCT,
    .encode = iso_encode_oct24,
    .lattice = oct24_lattice,
};

/* ---- half: three half floats, little endian ---- */

static uint16_t to_half(float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    uint32_t sign = bits >> 16 & 0x8000, size = bits & 0x7fffffff;
    if (size < 0x38800000) { /* below 2^-14: in steps of 2^-24 */
        float steps;
        memcpy(&steps, &size, sizeof steps);
        return (uint16_t)(sign | (uint32_t)lrintf(steps * 0x1p24f));
    }
    size += 0xfff + (size >> 13 & 1); /* rounds to nearest, ties to even */
    return (uint16_t)(sign | ((size - 0x38000000) >> 13));
}

void iso_encode_half(const float *restrict directions, uint8_t *restrict bytes, size_t count)
{
    for (size_t i = 0; i < 3 * count; ++i) {
        uint16_t half = to_half(directions[i]);
        bytes[2 * i] = (uint8_t)(half & 0xff);
        bytes[2 * i + 1] = (uint8_t)(half >> 8);
    }
}

static double from_half(const uint8_t *bytes)
{
    int bits = bytes[0] | bytes[1] << 8, exponent = bits >> 10 & 31, fraction = bits & 1023;
    double size = exponent ? ldexp(1024 + fraction, exponent - 25) : ldexp(fraction, -24);
    return bits & 0x8000 ? -size : size;
}

static void half_lattice(const uint8_t *bytes, double e[3])
{
    for (int a = 0; a < 3; ++a)
        e[a] = from_half(bytes + 2 * a);
}

const iso_code_info iso_code_half = {
    .name = "half",
    .summary = "three half floats",
    .bytes = 6,
    .is_signed = true,
    .keeps_length = true,
    .is_linear = true,
    .decoder = ISO_DECODER_LINEAR,
    .encode = iso_encode_half,
    .lattice = half_lattice,
};

/* SPDX-License-Identifier: MIT */
/* encode_fit.c - best fits: instead of the nearest lattice point, one with a nearer
 * direction among those of acceptable length. Candidates along the direction: one for
 * each whole number of the largest component, with the other two rounded. */
#include "encode/code_kernel.h"
#include "encode/encode_kernel.h"
#include "encode/fit.h"
#include "encode/simd.h"

typedef struct ray {
    v8f x, y, z; /* unit; zero stays zero */
    v8f aim;     /* intended length in lattice steps */
    v8f largest; /* |component| */
    v8f at;      /* length at which the ray is rounded to the best candidate */
    v8f best;    /* cost of that candidate */
} ray;

ISO_INLINE ray ray_through(const float *px, const float *py, const float *pz)
{
    ray r = {.x = v8_load(px), .y = v8_load(py), .z = v8_load(pz), .at = v8_set(0), .best = v8_set(INFINITY)};
    v8f length = v8_sqrt(r.x * r.x + r.y * r.y + r.z * r.z);
    v8f scale = 1.0f / v8_max(length, v8_set(1e-30f));
    r.x *= scale, r.y *= scale, r.z *= scale;
    r.aim = 127.0f * length;
    r.largest = v8_max(v8_max(v8_abs(r.x), v8_abs(r.y)), v8_max(v8_abs(r.z), v8_set(1e-30f)));
    return r;
}

/* Returns the squared distance from the ray of the candidate near its point at length
 * `at`; *along: position of the candidate beyond that point. */
ISO_INLINE v8f off_ray(const ray *r, v8f at, v8f *along)
{
    v8f ex = at * r->x, ey = at * r->y, ez = at * r->z;
    v8f rx = v8_round(ex) - ex, ry = v8_round(ey) - ey, rz = v8_round(ez) - ez;
    *along = rx * r->x + ry * r->y + rz * r->z;
    return rx * rx + ry * ry + rz * rz - *along * *along;
}

ISO_INLINE void take_better(ray *r, v8f cost, v8f at)
{
    v8i better = cost < r->best;
    r->best = v8_select(better, cost, r->best);
    r->at = v8_select(better, at, r->at);
}

ISO_INLINE void store_rounded(const ray *r, float *px, float *py, float *pz)
{
    v8_store(px, v8_round(r->at * r->x));
    v8_store(py, v8_round(r->at * r->y));
    v8_store(pz, v8_round(r->at * r->z));
}

/* ---- fit: encoder of a block ---- */

ISO_INLINE void fit_triples(const float *restrict directions, uint8_t *restrict bytes, size_t count,
                            void (*rows)(const float *restrict, const float *restrict, const float *restrict, size_t,
                                         uint32_t *restrict))
{
    for (size_t start = 0; start < count; start += ISO_BLOCK) {
        const size_t n = count - start < ISO_BLOCK ? count - start : ISO_BLOCK;
        uint32_t words[ISO_BLOCK];
        iso_block b;
        iso_block_load(&b, directions + 3 * start, n);
        rows(b.x, b.y, b.z, ISO_BLOCK, words);
        for (size_t i = 0; i < n; ++i)
            for (size_t a = 0; a < 3; ++a)
                bytes[3 * (start + i) + a] = (uint8_t)(words[i] >> 8 * a);
    }
}

void iso_encode_fit(const float *restrict directions, uint8_t *restrict bytes, size_t count)
{
    fit_triples(directions, bytes, count, iso_fit_rows);
}

void iso_encode_fit_baseline(const float *restrict directions, uint8_t *restrict bytes, size_t count)
{
    fit_triples(directions, bytes, count, iso_fit_rows_baseline);
}

/* ---- shell: the nearest direction among lengths in [0.95, 1] ---- */

enum { SHELL_CANDIDATES = 8 }; /* 0.05 * 127 + 1, rounded up */

ISO_INLINE void shell_lanes(float *px, float *py, float *pz)
{
    ray r = ray_through(px, py, pz);
    v8i undefined = r.aim <= 0.0f;
    v8f step = 1.0f / r.largest;
    v8f last = v8_round(127.0f * r.largest);
    r.at = last * step;
    for (int k = 0; k < SHELL_CANDIDATES; ++k) {
        v8f at = (last - (float)k) * step, along;
        v8f cost = off_ray(&r, at, &along);
        v8f length = at + along;
        v8i inside = (length >= 127 * (float)ISO_SHELL_MIN) & (length <= 127.0f);
        take_better(&r, v8_select(inside, cost, v8_set(INFINITY)), at);
    }
    r.at = v8_select(undefined, v8_set(0), r.at);
    store_rounded(&r, px, py, pz);
}

ISO_SIMD_ENCODER(iso_encode_shell, shell_lanes)

/* ---- free: the nearest direction at any length. The multiples of a vector have the same
 * direction, so the upper half of the lengths has all directions. ---- */

ISO_INLINE void free_lanes(float *px, float *py, float *pz)
{
    ray r = ray_through(px, py, pz);
    v8i undefined = r.aim <= 0.0f;
    v8f step = 1.0f / r.largest;
    for (int m = 127; m > 63; --m) {
        v8f at = (float)m * step, along;
        v8f cost = off_ray(&r, at, &along);
        v8f length = at + along;
        take_better(&r, cost / (length * length), at);
    }
    r.at = v8_select(undefined, v8_set(0), r.at);
    store_rounded(&r, px, py, pz);
}

ISO_SIMD_ENCODER(iso_encode_free, free_lanes)

/* ---- rows of the table of codes ------------------------------------------------------ */

const iso_code_info iso_code_fit = {
    .name = "fit",
    .summary = "signed bytes near the vector, with the best direction at almost its length",
    .bytes = 3,
    .is_textured = true,
    .is_signed = true,
    .keeps_length = true,
    .is_linear = true,
    .decoder = ISO_DECODER_LINEAR,
    .encode = iso_encode_fit,
    .encode_rows = iso_fit_rows,
};

const iso_code_info iso_code_shell = {
    .name = "shell",
    .summary = "the best direction at a length of 0.95 to 1; direction only",
    .bytes = 3,
    .is_textured = true,
    .is_signed = true,
    .is_linear = true,
    .decoder = ISO_DECODER_LINEAR,
    .encode = iso_encode_shell,
};

const iso_code_info iso_code_free = {
    .name = "free",
    .summary = "the best direction at any length; direction only",
    .bytes = 3,
    .is_textured = true,
    .is_signed = true,
    .decoder = ISO_DECODER_UNIT,
    .encode = iso_encode_free,
};

/* encode_fit.c - best fit: in place of the nearest lattice point one whose
 * direction is nearer, among those whose length is about right.
 *
 * Along the direction u, one candidate for each whole number of the largest
 * component: the other two rounded. With r = candidate - aim u and
 * along = r . u the fit takes the least
 *     |r|^2 - along^2 + mu^2 along^2,
 * the distance to the wanted vector with lengths counted 1/mu times less. */
#include "encode/encode_kernel.h"
#include "encode/fit.h"
#include "encode/simd.h"

typedef struct ray {
    v8f x, y, z;  /* unit; zero stays zero */
    v8f aim;      /* the wanted length in lattice steps */
    v8f largest;  /* |component| */
    v8f at;       /* of the best candidate: where the ray is rounded */
    v8f best;     /* its cost */
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

/* The candidate round the ray's point at length `at`: its squared distance from
 * the ray; *along, how far behind that point it lies. */
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

/* ---- fit: aims at |d|; the shorter, the less its direction is worth, since
 * neighbours then differ: mu grows (fit.h) ---- */

ISO_INLINE void fit_lanes(float *px, float *py, float *pz)
{
    ray r = ray_through(px, py, pz);
    v8f mu = (float)ISO_FIT_MU + (float)ISO_FIT_MU_SHORT * v8_max(1.0f - r.aim * (1 / 127.0f), v8_set(0));
    v8f weight = mu * mu, step = 1.0f / r.largest;
    v8f first = v8_min(v8_round(r.aim * r.largest), v8_set(127 - ISO_FIT_WINDOW)) - (float)ISO_FIT_WINDOW;
    for (int k = 0; k <= 2 * ISO_FIT_WINDOW; ++k) {
        v8f at = (first + (float)k) * step, along;
        v8f cost = off_ray(&r, at, &along);
        v8f radial = at + along - r.aim;
        take_better(&r, cost + weight * (radial * radial), at);
    }
    store_rounded(&r, px, py, pz);
}

ISO_SIMD_ENCODER(iso_encode_fit, fit_lanes)

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

/* ---- free: the nearest direction of all. The multiples of a vector share its
 * direction, so the upper half of the lengths has them all. ---- */

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

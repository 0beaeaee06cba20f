/* SPDX-License-Identifier: MIT */
#include "render/cell_ray.h"

#include <math.h>
#include <stdlib.h>

#include "encode/code.h"
#include "encode/decode_double.h"
#include "render/cell_ray_kernel.h"

/* ---- cubics ---- */

int iso_cubic_extremes(const double p[4], double u[2])
{
    const double a = 3 * p[3], b = p[2], c = p[1], root = b * b - a * c; /* a u^2 + 2 b u + c */
    int count = 0;
    if (!(root > 0))
        return 0;
    const double q = -(b + copysign(sqrt(root), b));
    const double at[2] = {q / a, c / q};
    for (int i = 0; i < 2; ++i)
        if (at[i] > 0 && at[i] < 1)
            u[count++] = at[i];
    if (count == 2 && u[0] > u[1]) {
        const double swap = u[0];
        u[0] = u[1];
        u[1] = swap;
    }
    return count;
}

double iso_cubic_solve(const double p[4], double value, double a, double b)
{
    const double fa = cubic_at(p, a) - value, fb = cubic_at(p, b) - value;
    const bool rises = fa < fb;
    if ((rises ? fa : -fa) >= 0)
        return a;
    if ((rises ? fb : -fb) <= 0)
        return b;
    double u = a - fa * (b - a) / (fb - fa);
    for (int i = 0; i < 60; ++i) {
        if (!(u > a && u < b))
            u = 0.5 * (a + b);
        const double f = cubic_at(p, u) - value, slope = (3 * p[3] * u + 2 * p[2]) * u + p[1];
        if ((f < 0) == rises)
            a = u;
        else
            b = u;
        const double to = u - f / slope;
        if (fabs(to - u) < 1e-15 || !(b - a > 1e-15))
            return to >= a && to <= b ? to : u;
        u = to;
    }
    return u;
}

int iso_cubic_zeros(const double p[4], double u[3])
{
    const double b[4] = {p[0], p[0] + p[1] / 3, p[0] + (2 * p[1] + p[2]) / 3, p[0] + p[1] + p[2] + p[3]};
    const double lo = fmin(fmin(b[0], b[1]), fmin(b[2], b[3])), hi = fmax(fmax(b[0], b[1]), fmax(b[2], b[3]));
    if (!(lo < 0 && hi > 0))
        return 0;
    double at[4] = {0};
    int ends = 1 + iso_cubic_extremes(p, at + 1), count = 0;
    at[ends] = 1;
    for (int i = 0; i < ends; ++i)
        if ((cubic_at(p, at[i]) < 0) != (cubic_at(p, at[i + 1]) < 0))
            u[count++] = iso_cubic_solve(p, 0, at[i], at[i + 1]);
    return count;
}

/* ---- directions ---- */

/* Returns the index of the next voxel along an axis, clamped to the level. */
static size_t beside(const size_t n[3], const int at[3], int axis, int by)
{
    size_t voxel = 0;
    for (int a = 2; a >= 0; --a) {
        const int i = at[a] + (a == axis ? by : 0), last = (int)n[a] - 1;
        voxel = voxel * n[a] + (size_t)(i < 0 ? 0 : i > last ? last : i);
    }
    return voxel;
}

/* Returns the scalar of the next voxel, or the voxel's own if that has no data. */
static double value_beside(const float *scalar, const size_t n[3], const int at[3], int axis, int by)
{
    const float value = scalar[beside(n, at, axis, by)];
    return (double)(iso_is_no_data(value) ? scalar[beside(n, at, axis, 0)] : value);
}

/* Writes the gradients at a cell's corners. Filtered central differences equal those of the filtered scalar. */
static void gradients(const iso_cell_scene *c, const int cell[3], four corner[8])
{
    const float *scalar = c->sampler->level->scalar;
    const size_t *n = c->sampler->level->geometry.size;
    for (int i = 0; i < 8; ++i) {
        const int at[3] = {cell[0] - 1 + (i & 1), cell[1] - 1 + (i >> 1 & 1), cell[2] - 1 + (i >> 2)};
        double g[3];
        for (int a = 0; a < 3; ++a)
            g[a] = 0.5 * (value_beside(scalar, n, at, a, 1) - value_beside(scalar, n, at, a, -1));
        const iso_vec3 world = iso_mul(c->sampler->gradient_to_world, iso_v3(g[0], g[1], g[2]));
        corner[i][1] = world.x;
        corner[i][2] = world.y;
        corner[i][3] = world.z;
    }
}

void iso_cell_directions(const iso_cell_scene *c, const size_t voxel[8], const int cell[3], four corner[8])
{
    if (c->sampler->source == ISO_FROM_ON_THE_FLY) {
        gradients(c, cell, corner);
        return;
    }
    for (int i = 0; i < 8; ++i) {
        float v[3];
        iso_sampler_vector(c->sampler, voxel[i], v);
        for (int a = 0; a < 3; ++a)
            corner[i][a + 1] = (double)v[a];
    }
}

/* ---- a scene ---- */

bool iso_cell_scene_is_for(const iso_sampler *s, const iso_view *view)
{
    if (s->bricks || view->roi || view->tf_2d || view->extinction_scale)
        return false;
    if (!iso_view_is_lit(view))
        return true;
    if (s->source == ISO_FROM_ON_THE_FLY && s->level->labels) /* differences of labels: constant in a voxel */
        return false;
    const bool linear = s->source != ISO_FROM_CODES || iso_code_describe(s->code)->is_linear;
    return linear && s->source != ISO_FROM_FLIPPED && s->source != ISO_FROM_PALETTE_NEAREST;
}

/* True if a component's slope changes at an entry, and the entry or a neighboring one is visible. */
static bool bends_at(const iso_tf_table *tf, size_t i)
{
    const float *here = tf->entries + 4 * i, *before = i > 0 ? here - 4 : here,
                *after = i + 1 < tf->count ? here + 4 : here;
    if (!(before[3] > 0 || here[3] > 0 || after[3] > 0))
        return false;
    for (int c = 0; c < 4; ++c)
        if ((double)after[c] - (double)here[c] != (double)here[c] - (double)before[c])
            return true;
    return false;
}

static double brightest(const iso_tf_table *tf, const iso_view *view)
{
    double color = 0, light = view->shading.ambient;
    for (size_t i = 0; i < tf->count; ++i)
        for (int c = 0; c < 3; ++c)
            color = fmax(color, fabs((double)tf->entries[4 * i + c]));
    for (size_t i = 0; i < view->light_count; ++i)
        light += view->lights[i].intensity * (view->shading.diffuse + view->shading.specular);
    return fmax(color * light, 1); /* 1: of the opacity */
}

iso_status iso_cell_scene_create(iso_cell_scene *c, const iso_sampler *s, const iso_view *view, const iso_shown *shown,
                                 const iso_empty_space *empty, iso_error *err)
{
    const iso_tf_table *tf = &view->tf;
    const double power = view->shading.power;
    const double eps = s->source == ISO_FROM_ON_THE_FLY ? s->on_the_fly_eps : ISO_DIRECTION_EPS;
    *c = (iso_cell_scene){.sampler = s,
                          .view = view,
                          .tf = tf,
                          .shown = shown,
                          .empty = empty,
                          .lit = iso_view_is_lit(view),
                          .power = power > 0 && power <= 4096 && power == floor(power) ? (int)power : -1,
                          .whole_power = (int)fmin(floor(power), 1 << 20),
                          .eps_2 = eps * eps,
                          .brightest = brightest(tf, view)};
    c->bends = calloc(tf->count + 1, sizeof *c->bends);
    NEED_MEMORY(c->bends, err, "reference: no memory for %zu entries", tf->count);
    for (size_t i = 0; i < tf->count; ++i)
        c->bends[i + 1] = c->bends[i] + bends_at(tf, i);
    return ISO_OK;
}

void iso_cell_scene_destroy(iso_cell_scene *c)
{
    free(c->bends);
    *c = (iso_cell_scene){0};
}

/* ---- instruction sets ---- */

static stretch integrate_plain(const iso_cell_scene *c, const iso_cell_ray *ray, double *error)
{
    return integrate_cells(c, ray, error);
}

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
__attribute__((target("avx2"))) static stretch integrate_avx2(const iso_cell_scene *c, const iso_cell_ray *ray,
                                                              double *error)
{
    return integrate_cells(c, ray, error);
}
__attribute__((target("avx2,avx512f,avx512dq,avx512vl,prefer-vector-width=512"))) static stretch integrate_avx512(
    const iso_cell_scene *c, const iso_cell_ray *ray, double *error)
{
    return integrate_cells(c, ray, error);
}
static bool has_avx512(void)
{
    return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
           __builtin_cpu_supports("avx512vl");
}
#define HAS_AVX2 __builtin_cpu_supports("avx2")
#else
#define integrate_avx2 integrate_plain
#define integrate_avx512 integrate_plain
#define HAS_AVX2 false
static bool has_avx512(void)
{
    return false;
}
#endif

size_t iso_cell_ray_variants(iso_cell_ray_variant v[4])
{
    v[0] = (iso_cell_ray_variant){"plain", true, integrate_plain};
    v[1] = (iso_cell_ray_variant){"avx2", HAS_AVX2, integrate_avx2};
    v[2] = (iso_cell_ray_variant){"avx512", has_avx512(), integrate_avx512};
    return 3;
}

stretch iso_cell_ray_integrate(const iso_cell_scene *c, const iso_cell_ray *ray, double *error)
{
    if (has_avx512())
        return integrate_avx512(c, ray, error);
    return HAS_AVX2 ? integrate_avx2(c, ray, error) : integrate_plain(c, ray, error);
}

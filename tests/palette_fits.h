/* SPDX-License-Identifier: MIT */
/* palette_fits.h - palettes fitted to the ellipsoid of the paper. */
#pragma once

#include <math.h>
#include <stdlib.h>

#include "base/linalg.h"
#include "base/random.h"
#include "palette/palette.h"
#include "test.h"

#define ELLIPSOID 5000

/* Gradients of x^2 + 15 y^2 + 15 z^2 at random points in the unit ball. */
static inline float *ellipsoid(size_t count)
{
    float *v = malloc(3 * count * sizeof *v);
    iso_random random = {1};
    for (size_t i = 0; i < count; ++i) {
        double p[3], r2;
        do {
            for (int c = 0; c < 3; ++c)
                p[c] = 2 * iso_random_unit(&random) - 1;
            r2 = p[0] * p[0] + p[1] * p[1] + p[2] * p[2];
        } while (r2 > 1 || r2 < 1e-12);
        const iso_vec3 g = iso_normalize(iso_v3(p[0], 15 * p[1], 15 * p[2]));
        v[3 * i] = (float)g.x;
        v[3 * i + 1] = (float)g.y;
        v[3 * i + 2] = (float)g.z;
    }
    return v;
}

static inline iso_direction_set set_of(const float *vectors, const double *weights, size_t count)
{
    iso_direction_set set;
    assert_ok(iso_direction_set_create(&set, vectors, weights, count, &err));
    return set;
}

static inline iso_palette fit(const iso_direction_set *set, iso_palette_method method, size_t directions)
{
    iso_palette_options opt = iso_palette_defaults();
    iso_palette p;
    opt.method = method;
    opt.directions = directions;
    opt.swap_trials = 4;
    assert_ok(iso_palette_fit(set, &opt, &p, NULL, &err));
    return p;
}

static inline double norm1_of(const iso_direction_set *set, const iso_palette *p)
{
    iso_palette_error e;
    assert_ok(iso_palette_measure(set, p, &e, &err));
    return e.norm1;
}

static inline void random_unit(iso_random *random, float *v)
{
    double z = 2 * iso_random_unit(random) - 1, a = 2 * acos(-1) * iso_random_unit(random), r = sqrt(1 - z * z);
    v[0] = (float)(r * cos(a));
    v[1] = (float)(r * sin(a));
    v[2] = (float)z;
}

/* Unit entries, the zero vector first, and no direction farther away than a covering of its size may leave: the
 * equal-area cap's angle is 2 asin(sqrt(1 / n)); a good table stays within twice of it. */
static inline void expect_a_cover(const iso_direction_set *set, const iso_palette *p)
{
    iso_palette_error e;
    assert_true(p->xyz[0] == 0 && p->xyz[1] == 0 && p->xyz[2] == 0);
    for (size_t i = 1; i < p->count; ++i) {
        const float *n = p->xyz + 3 * i;
        assert_within(n[0] * n[0] + n[1] * n[1] + n[2] * n[2], 1, 1e-6); /* rounding of floats */
    }
    assert_ok(iso_palette_measure(set, p, &e, &err));
    const double cap = 2 * asin(sqrt(1.0 / (double)(p->count - 1))) * 180 / acos(-1);
    assert_at_most(e.max_deg, 2 * cap);
}

/* Random directions, for expect_a_cover(). */
static inline iso_direction_set random_directions(void)
{
    enum { COUNT = 4000 };
    iso_random random = {7};
    FREED float *v = malloc(3 * COUNT * sizeof *v);
    for (size_t i = 0; i < COUNT; ++i)
        random_unit(&random, v + 3 * i);
    return set_of(v, NULL, COUNT);
}

/* Without any direction all entries are the zero vector's. */
static inline void expect_the_zero_vector(const iso_direction_set *none, const iso_palette *p, const float *v,
                                          size_t count)
{
    iso_palette_lookup *lookup;
    uint16_t index[4];
    assert_ok(iso_palette_lookup_create(p, &lookup, &err));
    iso_palette_assign(lookup, v, index, count);
    for (size_t i = 0; i < count; ++i)
        assert_int_equal(index[i], 0);
    assert_within(norm1_of(none, p), 0, 0);
    iso_palette_lookup_destroy(lookup);
}

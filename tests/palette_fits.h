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

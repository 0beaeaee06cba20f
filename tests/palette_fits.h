/* SPDX-License-Identifier: MIT */
/* palette_fits.h - palettes fitted to the ellipsoid of the paper. */
#ifndef ISO_TESTS_PALETTE_FITS_H
#define ISO_TESTS_PALETTE_FITS_H

#include <math.h>
#include <stdlib.h>

#include "base/random.h"
#include "palette/palette.h"
#include "test.h"

#define ELLIPSOID 5000

static inline float *ellipsoid(size_t count)
{
    float *v = malloc(3 * count * sizeof *v);
    iso_ellipsoid_gradients(v, count, false, 1);
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
    opt.anneal.cycles = 40;
    opt.anneal.steps = 400;
    opt.anneal.temp_fac = 0.85;
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

#endif

/* SPDX-License-Identifier: MIT */
/* sampled.h - pyramids of sampled fields. */
#pragma once

#include "pyramid/pyramid.h"
#include "test.h"
#include "volume/synthetic.h"

static inline iso_pyramid sampled_pyramid(const iso_field *field, iso_type type, const iso_pyramid_options *opt)
{
    OWNED(iso_volume) v;
    iso_pyramid p;
    assert_ok(iso_field_sample(field, type, &v, &err));
    assert_ok(iso_pyramid_build(&v, "field", opt, &p, NULL, &err));
    return p;
}

/* A grid that is rotated by unequal angles round z, then x, with spacings 1, 0.8, 1.7. */
static inline iso_geometry rotated_geometry(size_t nx, size_t ny, size_t nz)
{
    const double c = cos(0.5), s = sin(0.5), d = cos(0.3), e = sin(0.3), h[3] = {1, 0.8, 1.7};
    const double rotation[3][3] = {{c, -s, 0}, {d * s, d * c, -e}, {e * s, e * c, d}};
    iso_geometry g = {.size = {nx, ny, nz},
                      .origin_mm = {-17, 5, 40},
                      .box_index = {(double)nx, (double)ny, (double)nz}};
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column)
            g.index_to_world.m[row][column] = rotation[row][column] * h[column];
    return g;
}

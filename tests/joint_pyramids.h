/* SPDX-License-Identifier: MIT */
/* joint_pyramids.h - pyramids of random values. */
#pragma once

#include "test.h"

#include <stdlib.h>

#include "base/random.h"
#include "pyramid/pyramid.h"
#include "tf/adapt.h"

static inline iso_pyramid random_pyramid(size_t nx, size_t ny, size_t nz, iso_type type, size_t levels)
{
    iso_geometry g = iso_geometry_axis_aligned((size_t[]){nx, ny, nz}, (double[]){1, 1.5, 2});
    OWNED(iso_volume) v;
    iso_pyramid p;
    iso_random random = {3};
    assert_ok(iso_volume_create(&v, &g, type, "v", &err));
    for (size_t i = 0; i < nx * ny * nz; ++i)
        if (type == ISO_U8)
            ((uint8_t *)v.data)[i] = (uint8_t)iso_random_next(&random);
        else
            ((uint16_t *)v.data)[i] = (uint16_t)(iso_random_below(&random, 3000) + 500);
    iso_pyramid_options opt = iso_pyramid_defaults();
    opt.level_count = levels;
    assert_ok(iso_pyramid_build(&v, "v", &opt, &p, NULL, &err));
    return p;
}

static inline uint64_t count_of(const iso_joint *j, size_t s, size_t z)
{
    for (size_t i = j->row_start[s]; i < j->row_start[s + 1]; ++i)
        if (j->entry_z[i] == z)
            return j->entry_count_of[i];
    return 0;
}

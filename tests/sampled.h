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

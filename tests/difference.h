/* SPDX-License-Identifier: MIT */
/* difference.h - how far two pictures of one size are apart, over all channels; NaN is the largest difference. */
#pragma once

#include "image/image.h"
#include "test.h"

typedef struct difference {
    double max_abs, rmse;
} difference;

static inline difference difference_of(const iso_image *a, const iso_image *b)
{
    difference d = {0, 0};
    const size_t count = 4 * a->width * a->height;
    assert_true(a->width == b->width && a->height == b->height);
    for (size_t i = 0; i < count; ++i) {
        const double e = fabs((double)a->rgba[i] - (double)b->rgba[i]);
        d.max_abs = e <= d.max_abs ? d.max_abs : e;
        d.rmse += e * e;
    }
    d.rmse = sqrt(d.rmse / (double)count);
    return d;
}

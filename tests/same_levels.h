/* SPDX-License-Identifier: MIT */
/* same_levels.h - the levels of two pyramids, compared. */
#pragma once

#include <string.h>

#include "pyramid/pyramid.h"
#include "test.h"

static inline bool same_levels(const iso_pyramid *p, const iso_pyramid *q)
{
    bool same = p->level_count == q->level_count;
    for (size_t k = 0; same && k < p->level_count; ++k) {
        const iso_level *a = &p->levels[k], *b = &q->levels[k];
        const size_t n = iso_geometry_voxel_count(&a->geometry);
        same = memcmp(&a->geometry, &b->geometry, sizeof a->geometry) == 0 && a->stored_type == b->stored_type &&
               a->min == b->min && a->max == b->max && memcmp(a->scalar, b->scalar, n * sizeof(float)) == 0 &&
               memcmp(a->codes, b->codes, 3 * n) == 0 && !a->directions == !b->directions &&
               !a->magnitude == !b->magnitude &&
               (!a->directions || memcmp(a->directions, b->directions, 3 * n * sizeof(float)) == 0) &&
               (!a->magnitude || memcmp(a->magnitude, b->magnitude, n * sizeof(float)) == 0);
    }
    return same;
}

/* SPDX-License-Identifier: MIT */
/* pyramid_verify.h - checks that a pyramid's levels are made from its own level 0.
 *
 * Checksums only show that files are unchanged, not that they belong together. A build is deterministic: neither
 * threads, slabs nor ranks change a byte. So all levels are made again from the values of level 0, by the pyramid's own
 * options, and compared bit by bit. Compared are values, directions (level 0's too), kept floats and magnitudes, and
 * each level's geometry and range. Values and range of levels that were made for a scene (pyramid.h) are left out:
 * fit/level_scalar.h has them; of optimized levels directions, too, which nothing makes again. */
#pragma once

#include "pyramid/pyramid.h"

typedef struct iso_level_check {
    size_t voxels, differing; /* differing: voxels of which any stored quantity differs */
    bool is_not_remade;       /* True for an optimized level */
    size_t first[3];          /* the first voxel that differs, and the first thing that does there: */
    const char *
        what; /* "values", "directions", ...; "geometry", "range", "direction filter" of the whole level; NULL: nothing */
} iso_level_check;

/* Fills checks[0 .. p->level_count - 1]. ISO_OK if all levels were compared, with any result. ISO_E_RANGE: level 0
 * holds values that no pyramid is built from; ISO_E_MEMORY. */
iso_status iso_pyramid_verify(const iso_pyramid *p, int threads, iso_level_check *checks, const iso_progress *progress,
                              iso_error *err);

/* Describes a check for people: "level 1: 160 of 600 voxels are not made from level 0, the first is (3, 0, 0), by its
 * directions". Returns text, truncated if it is too long. */
const char *iso_level_check_text(const iso_level_check *check, size_t level, char *text, size_t size);

/* SPDX-License-Identifier: MIT */
/* screen_reach.h - the pixels that can show anything, and the range of distances along their rays: by tiles of
 * ISO_SCREEN_TILE x ISO_SCREEN_TILE pixels, from the blocks that a transfer function shows (brick/occupancy.h).
 *
 *     image    +----+----+----+----+       each block that shows is drawn as a rectangle around its projection,
 *              |    | ## | ## |    |       and the tiles that the rectangle touches widen their distances by
 *              |    | ## | ## |    |       the block's nearest and farthest point
 *              +----+----+----+----+
 *
 * Ranges may be too wide, never too narrow: outside its distances a tile's rays meet only empty space. So leaving it
 * out changes no sample that shows (tests/test_screen_reach.c). Blocks that others surround on all six sides are passed
 * over, because a ray enters and leaves the visible part through a block that is not, or begins in a visible block:
 * blocks around the camera count always. */
#pragma once

#include <stdint.h>

#include "scene/scene.h"

enum { ISO_SCREEN_TILE = 8 };

/* Blocks of `voxels` a side, x fastest; block b begins at voxels * b + first in index coordinates. distance is 0 where
 * a block shows. */
typedef struct iso_screen_blocks {
    const uint8_t *distance;
    size_t count[3];
    double voxels, first;
} iso_screen_blocks;

typedef struct iso_screen_reach {
    size_t columns, rows; /* of tiles */
    /* Two per tile, owned: millimeters along a ray, from the camera or, if it is orthographic, from its plane. The
     * first is the larger one if the tile shows nothing. */
    float *mm;
} iso_screen_reach;

/* Finds the reach of the blocks on the screen. ISO_E_MEMORY. */
iso_status iso_screen_reach_create(iso_screen_reach *r, const iso_geometry *g, const iso_view *view,
                                   const iso_screen_blocks *blocks, iso_error *err);
void iso_screen_reach_destroy(iso_screen_reach *r); /* accepts empty and NULL */

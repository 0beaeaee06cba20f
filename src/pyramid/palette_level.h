/* SPDX-License-Identifier: MIT */
/* palette_level.h - palettes for the levels of a pyramid. */
#pragma once

#include "pyramid/pyramid.h"

/* Gets the level's directions before encoding. If the level does not keep them, *owned gets the decoded codes,
 * otherwise NULL. Free *owned in either case. */
iso_status iso_level_directions(const iso_level *level, iso_code code, const float **directions, float **owned,
                                iso_error *err);

/* Gives the level the palette, which must outlive it, and the index of each voxel's nearest entry. */
iso_status iso_level_attach_palette(iso_level *level, iso_code code, const iso_palette *palette, iso_error *err);
void iso_level_detach_palette(iso_level *level); /* frees the indices; accepts a level without */

/* Fits a palette of `directions` entries to the level's directions, each of which counts 1. */
iso_status iso_level_fit_palette(const iso_level *level, iso_code code, size_t directions, size_t swap_trials,
                                 int threads, iso_palette *palette, iso_error *err);

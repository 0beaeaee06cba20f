/* SPDX-License-Identifier: MIT */
/* narrow.h - a pyramid without the floats of level 0, whose scalars are read from the volume itself: a quarter of the memory
 * where samples are bytes. For what reads scalars a few at a time, such as exports. */
#ifndef ISO_PYRAMID_NARROW_H
#define ISO_PYRAMID_NARROW_H

#include "pyramid/pyramid.h"

/* As iso_pyramid_build(), but levels[0].scalar is NULL. */
iso_status iso_pyramid_build_narrow(const iso_volume *v, const char *source, const iso_pyramid_options *opt,
                                    iso_pyramid *out, const iso_progress *progress, iso_error *err);

/* The scalars of `count` voxels from number `first` on: the level's own, or where it has none the volume's. */
void iso_level_scalars(const iso_level *level, const iso_volume *volume, size_t first, size_t count,
                       float *restrict out);

#endif

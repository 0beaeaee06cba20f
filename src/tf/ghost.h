/* SPDX-License-Identifier: MIT */
/* ghost.h - opacity that a coarse level shows in places where level 0 shows nothing.
 *
 * An adapted transfer function is right in the mean over all voxels of one value (adapt.h). If a thin structure in air
 * and the skin have the same mean at a level, both get the same opacity. The skin, invisible at level 0, then appears
 * as a haze around the visible object. This is its ghost, measured and kept small.
 *
 * A voxel of the level is empty if level 0 shows nothing in it and half a voxel around it: no value between those of
 * the fine voxels there has an opacity of ISO_GHOST_TRANSPARENT or more over the spacing of level 0. So the rim that
 * any coarse level draws around a surface mostly does not count as ghost. In small views (small_views.h)
 *
 *     ghost = opacity seen in empty voxels / opacity that level 0 shows,
 *
 * both summed over all pixels, the first weighted by the transmittance in front of it. The original transfer function
 * shows almost nothing in empty voxels, since a mean lies between its values. */
#pragma once

#include <stdint.h>

#include "pyramid/pyramid.h"
#include "tf/small_views.h"
#include "tf/tf.h"

#define ISO_GHOST_TRANSPARENT 1e-3
/* Largest ghost that is drawn unless requested. Of the 45 cases used to choose it two exceeded it, with 4 and 6
 * percent; the others had at most half of it (doc/results/adaptive-tf.md). */
#define ISO_GHOST_LIMIT 0.01
/* Share of ghost from which on an entry is reset; entries of surfaces have none. */
#define ISO_GHOST_SHARE 0.05

/* Sets *empty: one byte per voxel of coarse, 0 or as in small_views.h, to be freed. Both levels need scalars; level: halvings between
 * them. ISO_E_MEMORY. */
iso_status iso_ghost_mask(const iso_level *fine, const iso_level *coarse, size_t level, const iso_tf_table *original,
                          int threads, uint8_t **empty, iso_error *err);

/* Measures the ghost of `level` as it is shown: through `tf`, or through `tf_2d` unless it is NULL. 0 if the pyramid
 * has no scalars, or if level 0 has more voxels than small views accept. ISO_E_MEMORY. */
iso_status iso_ghost_measure(const iso_pyramid *p, size_t level, const iso_tf_table *original, const iso_tf_table *tf,
                             const iso_tf_2d *tf_2d, int threads, double *ghost, iso_error *err);

/* Resets entries of `adapted` with a ghost share of ISO_GHOST_SHARE or more to the extinction of `original`, if that is
 * less. Repeats it, as a removed ghost uncovers others, until hardly any is left. in: with `empty`; its transfer
 * functions are not used. *given_back: number of entries. ISO_E_MEMORY. */
iso_status iso_ghost_remove(const iso_small_views_input *in, iso_tf_table *adapted, size_t *given_back, iso_error *err);

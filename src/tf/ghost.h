/* SPDX-License-Identifier: MIT */
/* ghost.h - what a coarse level shows where level 0 shows nothing.
 *
 * An adapted transfer function is right in the mean over all voxels of one value (adapt.h). Where a thin structure in
 * air and the skin have the same mean at a level, both get the same opacity: of the skin, which level 0 does not show, a
 * haze is drawn round all that is seen. This is its ghost, measured and kept small.
 *
 * A voxel of the level is empty where level 0 shows nothing in it and half a voxel of the level around it: no value between
 * those of fine voxels there has an opacity of ISO_GHOST_TRANSPARENT or more over the spacing of level 0. So the rim that any
 * coarse level draws round a surface is mostly no ghost. In small views (small_views.h)
 *
 *     ghost = what is seen in empty voxels / what level 0 shows,
 *
 * both as sums of opacity over all pixels, the first by the transmittance in front of it. The original transfer function
 * shows next to nothing in empty voxels, as means lie between the values that they are of. */
#ifndef ISO_TF_GHOST_H
#define ISO_TF_GHOST_H

#include <stdint.h>

#include "pyramid/pyramid.h"
#include "tf/small_views.h"
#include "tf/tf.h"

#define ISO_GHOST_TRANSPARENT 1e-3
/* More ghost than this is not drawn without being asked for: of 45 cases of the volumes that it was chosen by two showed
 * more, 4 and 6 percent, and the others at most half of it (doc/results/adaptive-tf.md). */
#define ISO_GHOST_LIMIT 0.01
/* An entry is given back of which this part of what is seen is ghost: surfaces' entries show none. */
#define ISO_GHOST_SHARE 0.05

/* *empty: a byte a voxel of coarse, 1 or 0, to be freed. Both levels have scalars; level: halvings between them. ISO_E_MEMORY. */
iso_status iso_ghost_mask(const iso_level *fine, const iso_level *coarse, size_t level, const iso_tf_table *original,
                          int threads, uint8_t **empty, iso_error *err);

/* The ghost of `level` as it is shown: through `tf`, or `tf_2d` unless it is NULL. 0 where the pyramid has no scalars, or a
 * level 0 of more voxels than small views look at. ISO_E_MEMORY. */
iso_status iso_ghost_measure(const iso_pyramid *p, size_t level, const iso_tf_table *original, const iso_tf_table *tf,
                             const iso_tf_2d *tf_2d, int threads, double *ghost, iso_error *err);

/* Gives entries of `adapted` of which ISO_GHOST_SHARE is ghost the extinction of `original` at their values, where that is
 * less; round after round, as what is taken away uncovers what is behind it, until hardly a ghost is left. in: with `empty`;
 * its transfer functions are not used. *given_back: how many entries. ISO_E_MEMORY. */
iso_status iso_ghost_remove(const iso_small_views_input *in, iso_tf_table *adapted, size_t *given_back, iso_error *err);

#endif

/* SPDX-License-Identifier: MIT */
/* extinction_scale.h - one byte per voxel of a coarse level that scales its extinction. The level is then as opaque as
 * the fine voxels are, place by place:
 *
 *     sigma(x) = q(x) sigma_TF(s(x)),    q(x) = 2^((b(x) - 168) / 28)
 *
 * b(x) is the bytes' trilinear interpolation between voxel centers, clamped at the edge, as the scalar's is; the power
 * is taken after it. Colors are the transfer function's own. Bytes are 0 to 252: q is 2^-6 to 2^3 in steps of 2.5 %,
 * and the byte 168 is 1 exactly. All renderers follow this definition: texture units, OpenVDB and DF3 files filter the
 * byte.
 *
 * A transfer function adapted to a level (tf/adapt.h) is right in the mean over all voxels of one value; q is right in
 * each neighborhood. It is made for one transfer function, by rounds over the fine voxels that it shows:
 *
 *     q_j <- q_j  sum_x hat_j(x) a_0(x) / sum_x hat_j(x) a(x),    a(x) = 1 - exp(-q(x) m_k(x) h)
 *
 *     hat_j   weight of coarse voxel j at the fine voxel's center x (interpolation.h)
 *     a_0     opacity of the fine voxel under the original transfer function
 *     h       spacing of level 0
 *     m_k     mean extinction under the level's transfer function of the values within half a gradient's length of
 *             s(x): the mean over a fine voxel's content, as a_0 is for level 0
 *
 * Sums that are nearly 0 leave q as it is.
 *
 * In: the scalars of level 0 and of the level, in memory. Out: the bytes, x fastest. They depend on no thread count.
 * Cost: doc/results/extinction-scale.md. */
#pragma once

#include <math.h>

#include "pyramid/pyramid.h"
#include "tf/tf.h"

/* The part that does not depend on the transfer function, made once per level: an edit then costs rounds over the
 * visible voxels. */
typedef struct iso_extinction_scaler iso_extinction_scaler;

/* Prepares a level. level: halvings from fine to coarse, at least 1. Both must keep their scalars while the scaler
 * lives. ISO_E_RANGE: a size that is not that of the level; a level without scalars. ISO_E_MEMORY. */
iso_status iso_extinction_scaler_create(const iso_level *fine, const iso_level *coarse, size_t level, int threads,
                                        iso_extinction_scaler **out, iso_error *err);
void iso_extinction_scaler_destroy(iso_extinction_scaler *s); /* accepts NULL */

typedef struct iso_extinction_scale_cost {
    size_t seen;      /* fine voxels in runs of which the transfer functions show anything */
    double error_one; /* over them: rms of a - a_0 with q = 1 */
    double error;     /* with the bytes */
} iso_extinction_scale_cost;

/* Makes the bytes, one per voxel of the level. original: of level 0; own: of the level, adapted or not. If they bring
 * the fine voxels' opacities no nearer (rms), all are 168. cost may be NULL. ISO_E_MEMORY. */
iso_status iso_extinction_scaler_apply(iso_extinction_scaler *s, const iso_tf_table *original, const iso_tf_table *own,
                                       uint8_t *bytes, iso_extinction_scale_cost *cost, iso_error *err);

/* Returns the byte of the geometric mean of `count` scales from the sum of their bytes. */
static inline uint8_t iso_extinction_scale_mean(size_t sum, size_t count)
{
    return (uint8_t)((2 * sum + count) / (2 * count));
}

/* Does all of it for one level of a pyramid: *bytes is allocated, to be freed; NULL for level 0. Copies the scale of a
 * level that was made for `original` (tf/level_look.h), or is optimized: 168 if it has none, or if `own` is adapted to an optimized one, unless its
 * edits are scaled. */
iso_status iso_extinction_scale_level(const iso_pyramid *p, size_t level, const iso_tf_table *original,
                                      const iso_tf_table *own, int threads, uint8_t **bytes, iso_error *err);

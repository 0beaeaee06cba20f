/* SPDX-License-Identifier: MIT */
/* agreement.h - how far the gradients below a level's voxels agree, and the direction filter that follows from it.
 *
 * Over the voxels of a level, with N, S and T of filter_kernel.h (N = mean of m g, S = mean of m^2, T = mean of g g^T):
 *
 *   mean agreement L = sum |N| / sum S        1 where gradients point one way, 0 where they cancel
 *   axis agreement F = sum |T| / sum S        1 where they lie on one axis, whatever their sense; .58 where on none
 *                                             (|T|: the root of the sum of its squared elements)
 *
 * Sums are weighted by the squared magnitude as the filters are, so that it is the surfaces that count. F - L is what the
 * main axis of T holds together and the mean loses: opposite faces that lie closer than a voxel. From
 * ISO_AGREEMENT_GAIN on a level gets the tensor filter, else moments (doc/method/gradients.md has how the limit was
 * found, and why neither naive nor eq1 is ever chosen).
 *
 * Sums are integers of 2^-36, a row at a time, so that neither threads, slabs nor ranks change them. */
#ifndef ISO_PYRAMID_AGREEMENT_H
#define ISO_PYRAMID_AGREEMENT_H

#include <stdint.h>

#include "base/progress.h"
#include "gradient/gradient_kernel.h"
#include "pyramid/pyramid.h"

/* F - L from which on the tensor filter is chosen. */
#define ISO_AGREEMENT_GAIN 0.4

enum { ISO_AGREEMENT_SUMS = 3 }; /* of |N|, |T|, S */

/* Exact sums. */
__extension__ typedef unsigned __int128 iso_exact_sum;
typedef struct iso_agreement {
    iso_exact_sum of[ISO_AGREEMENT_SUMS];
} iso_agreement;

/* Adds a row of n voxels in the state of ISO_DIRECTION_AUTO. */
void iso_agreement_add_row(iso_agreement *a, const float *state, size_t stride, size_t n);
void iso_agreement_add(iso_agreement *a, const iso_agreement *more);

/* The choice for all coarse levels from what was summed up over levels 1 to `measured`; levels above get that of the last
 * one that was measured. */
void iso_agreement_choose(const iso_agreement levels[], size_t measured, iso_direction_choice *choice);

/* opt for a cascade that only sums up; and what it has summed up. */
iso_pyramid_options iso_agreement_options(const iso_pyramid_options *opt);
/* Of a volume in memory: sets opt->choice where opt->direction_filter is ISO_DIRECTION_AUTO, else does nothing. scale: of
 * the cascade. */
iso_status iso_agreement_choose_for(const iso_planes *planes, const iso_geometry *g, double scale,
                                    iso_pyramid_options *opt, const iso_progress *progress, iso_error *err);

/* "tensor: its gradients agree by .27 in direction and by .92 on an axis". Returns text, cut where it is too long. */
const char *iso_direction_choice_text(const iso_direction_choice *choice, size_t level, char *text, size_t size);

#endif

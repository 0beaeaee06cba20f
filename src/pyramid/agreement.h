/* SPDX-License-Identifier: MIT */
/* agreement.h - agreement of the gradients below a level's voxels, and the direction filter chosen by it.
 *
 * Over the voxels of a level, with N, S and T of filter_kernel.h (N = mean of m g, S = mean of m^2, T = mean of g g^T):
 *
 *   mean agreement L = sum |N| / sum S        1 if gradients point one way, 0 if they cancel
 *   axis agreement F = sum |T| / sum S        1 if they lie on one axis, in either sense; .58 if on none
 *                                             (|T|: the root of the sum of its squared elements)
 *
 * Like the filters, the sums are weighted by the squared magnitude, so that surfaces count most. F - L grows with
 * opposite faces that are closer than a voxel: T keeps their axis, the mean cancels. A level with F - L of at least
 * ISO_AGREEMENT_GAIN gets the tensor filter, any other level moments. doc/method/gradients.md derives the limit and
 * gives the reason why naive and eq1 are never chosen.
 *
 * Sums are integers of 2^-36 per row, so that they do not depend on threads, slabs or ranks. */
#pragma once

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

/* Chooses for all coarse levels from the sums of levels 1 to `measured`. Higher levels get the choice of the last
 * measured level. */
void iso_agreement_choose(const iso_agreement levels[], size_t measured, iso_direction_choice *choice);

/* Returns options for a cascade that only sums the agreement. */
iso_pyramid_options iso_agreement_options(const iso_pyramid_options *opt);
/* Sets opt->choice from a volume in memory if opt->direction_filter is ISO_DIRECTION_AUTO, otherwise does nothing.
 * scale: of the cascade. */
iso_status iso_agreement_choose_for(const iso_planes *planes, const iso_geometry *g, double scale,
                                    iso_pyramid_options *opt, const iso_progress *progress, iso_error *err);

/* Formats "tensor: its gradients agree by .27 in direction and by .92 on an axis". Returns text, truncated if it is too
 * long. */
const char *iso_direction_choice_text(const iso_direction_choice *choice, size_t level, char *text, size_t size);

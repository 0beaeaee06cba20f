/* SPDX-License-Identifier: MIT */
/* palette_fit.h - interface of the fitted methods; private to src/palette. */
#ifndef ISO_PALETTE_FIT_H
#define ISO_PALETTE_FIT_H

#include "palette/palette.h"

/* Fits by the k-means family; the options have been checked. */
iso_status iso_palette_fit_kmeans(const iso_direction_set *set, const iso_palette_options *opt, iso_palette *palette,
                                  const iso_progress *progress, iso_error *err);
/* Checks the options. ISO_E_RANGE: outside their limits. */
iso_status iso_palette_check(const iso_palette_options *opt, iso_error *err);

#endif

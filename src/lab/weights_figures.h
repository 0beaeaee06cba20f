/* SPDX-License-Identifier: MIT */
/* weights_figures.h - Figures 8 and 9 of [diaz-garcia-2016] from the cases of isoshade-lab consistency. */
#pragma once

#include "base/json.h"

/* Draws the figures of the first renderer. cases: objects with renderer, volume, level, method and ssim_dissimilarity.
 * DIR/figure9.svg: each volume's levels, original and default; DIR/figure8.svg: each volume, by method. Means over the
 * transfer functions (and the levels). ISO_E_MISSING without gnuplot. */
iso_status iso_lab_figures(const json_t *cases, const char *dir, iso_error *err);

/* SPDX-License-Identifier: MIT */
/* ciede2000.h - ParaView's color space "Lab/CIEDE2000": between two colors VTK takes the shortest path through a grid
 * of 17 x 17 x 17 display colors, by the color difference CIEDE2000 [sharma-2005], and interpolates in Lab along it. */
#pragma once

#include "tf/curves.h"

/* Returns the CIEDE2000 difference of two colors in CIE L*a*b*. */
double iso_ciede2000(const double lab1[3], const double lab2[3]);

/* Inserts the paths into a color curve, which becomes one of ISO_SPACE_LAB. ISO_E_RANGE: too many nodes;
 * ISO_E_MEMORY. */
iso_status iso_ciede2000_expand(iso_tf_curve *color, const char *path, iso_error *err);

/* SPDX-License-Identifier: MIT */
/* primaries.h - linear colors of other primaries and white points as those of Rec. 709.
 *
 * White stays white: a color is taken from one white point to the other by the Bradford transform (ISO 15076-1,
 * annex E), as color management does. */
#pragma once

#ifdef __cplusplus
extern "C" {
#endif

#include "image/image.h"

/* Chromaticities x, y of red, green, blue and white. */
typedef struct iso_primaries {
    double xy[4][2];
} iso_primaries;

/* Computes the matrix to Rec. 709; for Rec. 709 itself the identity, within the digits of its standards. False: the
 * primaries span no colors. */
bool iso_primaries_matrix(const iso_primaries *from, double matrix[3][3]);

/* Converts an image's colors to Rec. 709; those of Rec. 709 keep each bit. path: for the message. ISO_E_FORMAT: the
 * primaries span no colors. */
iso_status iso_primaries_convert(const char *path, const iso_primaries *from, iso_image *image, iso_error *err);

#ifdef __cplusplus
}
#endif

/* SPDX-License-Identifier: MIT */
/* picture_plain.h - pictures as plain floats: NumPy arrays and PFM.
 *
 * NAME.npy       shape (rows, columns, 4), the top row first; floats of 16, 32 or 64 bits, any byte and axis order
 * NAME.pfm       "PF": red, green, blue; floats of 32 bits, the bottom row first, byte order by the scale's sign; and
 * NAME-alpha.pfm "Pf": alpha, which PFM lacks */
#pragma once

#include "image/image.h"
#include "scene/scene.h"

/* Returns NAME-alpha.pfm for NAME.pfm, to be freed; NULL: no memory, or another ending. */
char *iso_picture_alpha(const char *path);

/* Load a picture of the view's size, with 4 channels. name: the file in messages. ISO_E_PROGRAM: another size, shape
 * or type, or a damaged file; ISO_E_MEMORY; ISO_E_IO. */
iso_status iso_picture_load_npy(const char *path, const char *name, const iso_view *view, iso_image *image,
                                iso_error *err);
iso_status iso_picture_load_pfm(const char *path, const char *name, const iso_view *view, iso_image *image,
                                iso_error *err);

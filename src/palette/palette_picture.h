/* SPDX-License-Identifier: MIT */
/* palette_picture.h - pictures of palettes. */
#pragma once

#include "palette/palette.h"

/* Writes a PNG: the sphere from both sides, each point in the color of its nearest entry (x, y, z as red, green, blue),
 * with outlined regions and the set's directions as dots; set may be NULL. */
iso_status iso_palette_picture_png(const iso_palette *palette, const iso_direction_set *set, const char *path,
                                   iso_error *err);
/* Writes an EXR: count x 1 floats, entry i in pixel i as R, G, B. */
iso_status iso_palette_picture_exr(const iso_palette *palette, const char *path, const char *note, iso_error *err);

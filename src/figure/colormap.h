/* SPDX-License-Identifier: MIT */
/* colormap.h - color maps by name, for numbers. Lightness rises evenly, so that maps can be read in gray prints and
 * by people with color blindness. */
#pragma once

#include <stdint.h>

#include "base/names.h"

enum { ISO_COLORMAP_POINTS = 52, ISO_COLORMAP_COUNT = 4 };

typedef struct iso_colormap {
    const char *name, *summary;
    const uint32_t *points; /* 0xRRGGBB of sRGB, equally spaced */
} iso_colormap;

extern const iso_colormap iso_colormaps[ISO_COLORMAP_COUNT];
extern const iso_names iso_colormap_names;

/* Finds a map. ISO_E_USAGE, with the names that there are. */
iso_status iso_colormap_from_name(const char *name, const iso_colormap **map, iso_error *err);
/* Looks up t from 0 to 1, clamped; sRGB. */
void iso_colormap_lookup(const iso_colormap *map, double t, unsigned char rgb[3]);

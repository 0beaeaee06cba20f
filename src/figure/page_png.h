/* SPDX-License-Identifier: MIT */
/* page_png.h - composes the PNG of a page: pictures, and gnuplot's drawing over them. */
#pragma once

#include <stddef.h>

#include "base/status.h"

/* Pixels in sRGB, 3 bytes each, in a box of wide x high dots that starts at x, y. */
typedef struct iso_page_pixels {
    unsigned char *rgb;
    size_t width, height, x, y, wide, high;
} iso_page_pixels;

/* Replaces the transparent PNG of wide x high dots at path by an opaque one, over the pictures on white, with its
 * resolution. ISO_E_FORMAT: it has another size. */
iso_status iso_page_png_compose(const char *path, const iso_page_pixels *pictures, size_t count, size_t wide,
                                size_t high, double dpi, iso_error *err);

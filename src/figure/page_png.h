/* SPDX-License-Identifier: MIT */
/* page_png.h - the PNG of a page: its pictures as they are, and what gnuplot draws over them. */
#ifndef ISO_FIGURE_PAGE_PNG_H
#define ISO_FIGURE_PAGE_PNG_H

#include <stddef.h>

#include "base/status.h"

/* sRGB, 3 bytes a pixel, in a place of wide x high dots whose first one is x, y. */
typedef struct iso_page_pixels {
    unsigned char *rgb;
    size_t width, height, x, y, wide, high;
} iso_page_pixels;

/* path holds a transparent PNG of wide x high dots: it becomes that PNG over the pictures over white, opaque, with its
 * resolution. ISO_E_FORMAT where it has another size. */
iso_status iso_page_png_compose(const char *path, const iso_page_pixels *pictures, size_t count, size_t wide,
                                size_t high, double dpi, iso_error *err);

#endif

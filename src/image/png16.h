/* SPDX-License-Identifier: MIT */
/* png16.h - PNG files of 16 bits a channel. libpng's short way reads those by a power of 2.2, which is not sRGB. */
#ifndef ISO_PNG16_H
#define ISO_PNG16_H

#include "image/image.h"

/* sRGB, 0 to 1, to linear light. */
double iso_png_linear(double encoded);

bool iso_png_has_16_bits(const char *data, size_t size);
/* Creates *image. Samples are sRGB unless the file says that they are linear. */
iso_status iso_png16_take(const char *path, const char *data, size_t size, iso_image *image, iso_error *err);

#endif

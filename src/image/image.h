/* SPDX-License-Identifier: MIT */
/* image.h - float images: RGBA, linear light, premultiplied alpha, row 0 on top. iso_image, and how it is created, saved
 * as OpenEXR and PNG and loaded, stand in the library's header. */
#ifndef ISO_IMAGE_H
#define ISO_IMAGE_H

#include <stdbool.h>
#include <stddef.h>

#include "base/status.h"

/* POV-Ray writes 16-bit PPM (P6, maxval 65535): linear values / 65535, A = 1. */
iso_status iso_image_load_ppm(const char *path, iso_image *image, iso_error *err);

/* colour += (1 - alpha) * background: for images of renderers that do not draw the background. */
void iso_image_add_background(iso_image *image, const double background[3]);

/* The share of the pixels that show something of what was rendered: whose alpha is at least 1/255. */
double iso_image_shown_share(const iso_image *image);

/* Are all values numbers? */
bool iso_image_is_finite(const iso_image *image);

#endif

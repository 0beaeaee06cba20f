/* SPDX-License-Identifier: MIT */
/* image.h - float images: RGBA, linear light, premultiplied alpha, row 0 on top. iso_image, and how it is created, saved
 * as OpenEXR and PNG and loaded, stand in the library's header. */
#ifndef ISO_IMAGE_H
#define ISO_IMAGE_H

#include <stdbool.h>
#include <stddef.h>

#include "base/status.h"

/* An image is OpenEXR (floats, linear) or PNG (8 bits, sRGB) by its name's end, .exr or .png in either case.
 * ISO_E_USAGE for another end; option: what named it, such as "-o". */
iso_status iso_image_check_name(const char *option, const char *path, iso_error *err);
/* As the name says. notes: for OpenEXR, or NULL. */
iso_status iso_image_save(const iso_image *image, const char *path, const iso_image_note *notes, iso_error *err);

/* POV-Ray writes 16-bit PPM (P6, maxval 65535): linear values / 65535, A = 1. */
iso_status iso_image_load_ppm(const char *path, iso_image *image, iso_error *err);

/* What an OpenEXR file says of itself before its pixels are read. */
typedef struct iso_exr_header {
    size_t width, height; /* of the data */
    bool is_cropped;      /* the picture is another window than the data */
    unsigned channels;    /* 1, 2, 4 and 8 for R, G, B and A that have a value a pixel */
} iso_exr_header;
iso_status iso_image_read_exr_header(const char *path, iso_exr_header *header, iso_error *err);

/* color += (1 - alpha) * background: for images of renderers that do not draw the background. */
void iso_image_add_background(iso_image *image, const double background[3]);

/* The share of the pixels that show something of what was rendered: whose alpha is at least 1/255. */
double iso_image_shown_share(const iso_image *image);

/* Values above it become `most`. Returns whether there were any. */
bool iso_image_clip(iso_image *image, float most);

/* Are all values numbers? */
bool iso_image_is_finite(const iso_image *image);

#endif

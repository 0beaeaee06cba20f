/* SPDX-License-Identifier: MIT */
/* image.h - float images: RGBA, linear light, premultiplied alpha, row 0 on top. */
#ifndef ISO_IMAGE_H
#define ISO_IMAGE_H

#include <stdbool.h>
#include <stddef.h>

#include "base/status.h"

typedef struct iso_image {
    size_t width, height;
    float *rgba; /* owned; 4 * width * height */
    int origin[2]; /* first column and row of an EXR's display window; else 0, 0 */
} iso_image;

/* A text that travels in the header of the file: command, versions, step. */
typedef struct iso_image_note {
    const char *key, *value;
} iso_image_note;

iso_status iso_image_create(iso_image *image, size_t width, size_t height, iso_error *err);
void iso_image_destroy(iso_image *image); /* accepts empty and NULL */

/* OpenEXR, 32-bit float, channels A B G R. notes end with a NULL key; may be NULL. */
iso_status iso_image_save_exr(const iso_image *image, const char *path, const iso_image_note *notes, iso_error *err);
/* Any scan-line or tiled single-part EXR with R, G, B (A = 1 where it has none), half or float. The picture is the
 * file's display window: pixels of it that are outside the data window are 0 in all channels, and data outside it are
 * left out. */
iso_status iso_image_load_exr(const char *path, iso_image *image, iso_error *err);

/* 8-bit sRGB for people, opaque. exposure scales the linear colour first. */
iso_status iso_image_save_png(const iso_image *image, const char *path, double exposure, iso_error *err);

/* 8 bits a channel, decoded from sRGB to linear and premultiplied by alpha (A = 1 where it has none). 16 bits are
 * refused. */
iso_status iso_image_load_png(const char *path, iso_image *image, iso_error *err);

/* POV-Ray writes 16-bit PPM (P6, maxval 65535): linear values / 65535, A = 1. */
iso_status iso_image_load_ppm(const char *path, iso_image *image, iso_error *err);

/* colour += (1 - alpha) * background: for images of renderers that do not draw the background. */
void iso_image_add_background(iso_image *image, const double background[3]);

#endif

/* SPDX-License-Identifier: MIT */
/* image.h - float images: RGBA, linear light, premultiplied alpha, row 0 on top. iso_image, and how it is created,
 * saved as OpenEXR and PNG and loaded, stand in the library's header. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

#include "base/status.h"

/* Checks an image's name: OpenEXR (floats, linear) or PNG (8 bits, sRGB) by its end, .exr or .png in either case.
 * ISO_E_USAGE for another end; option: the option with the name, such as "-o". */
iso_status iso_image_check_name(const char *option, const char *path, iso_error *err);
/* Saves in the format of the name. notes: for OpenEXR, or NULL. */
iso_status iso_image_save(const iso_image *image, const char *path, const iso_image_note *notes, iso_error *err);

/* Loads POV-Ray's 16-bit PPM (P6, maxval 65535): linear values / 65535, A = 1. */
iso_status iso_image_load_ppm(const char *path, iso_image *image, iso_error *err);

/* The picture to take from OpenEXR files that hold several. Zeros: the only part, its channels R, G, B and A. */
typedef struct iso_image_choice {
    const char *part;           /* a name, or a number from 1 */
    const char *layer;          /* the channels' names before ".R" */
    bool used_part, used_layer; /* outputs: true if a loaded file had parts, had the layer */
    bool has_alpha;             /* output: true if the file loaded last has an alpha channel, else alpha is 1 */
} iso_image_choice;

/* Loads OpenEXR, PNG or PPM by the file's content, under any name. choice: may be NULL. */
iso_status iso_image_load(const char *path, iso_image_choice *choice, iso_image *image, iso_error *err);

/* Header of an OpenEXR file, read before its pixels. */
typedef struct iso_exr_header {
    size_t width, height; /* of the data */
    bool is_cropped;      /* true if the picture is another window than the data */
    unsigned channels;    /* 1, 2, 4 and 8 for R, G, B and A that have a value per pixel */
} iso_exr_header;
iso_status iso_image_read_exr_header(const char *path, iso_exr_header *header, iso_error *err);

/* Compares an OpenEXR file with the image that was written to it, bit by bit. ISO_E_IO: they differ. */
iso_status iso_exr_verify(const char *path, const iso_image *image, iso_error *err);

/* Adds (1 - alpha) * background to the color, for images of renderers that do not draw the background. */
void iso_image_add_background(iso_image *image, const double background[3]);

/* Returns the share of the pixels that show the volume: those with an alpha of at least 1/255. */
double iso_image_shown_share(const iso_image *image);

/* Lowers values above `most` to it. True if there were any. */
bool iso_image_clip(iso_image *image, float most);

/* True if all values are finite. */
bool iso_image_is_finite(const iso_image *image);

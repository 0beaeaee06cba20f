/* SPDX-License-Identifier: MIT */
/* picture_bytes.h - the kind of a picture's file by its first bytes, and readers of bytes in memory; private to this
 * folder. */
#pragma once

#include "image/image.h"

typedef enum iso_picture_kind { ISO_PICTURE_OTHER, ISO_PICTURE_EXR, ISO_PICTURE_PNG, ISO_PICTURE_PPM } iso_picture_kind;

/* Reads a whole file; a folder is refused by name. */
iso_status iso_picture_read_file(const char *path, char **data, size_t *size, iso_error *err);
/* Reads a file that must be of the given kind, called `wanted` in messages. */
iso_status iso_picture_read_kind(const char *path, iso_picture_kind kind, const char *wanted, char **data, size_t *size,
                                 iso_error *err);

/* Creates *image from a file's data. path: for messages. */
iso_status iso_png_decode(const char *path, const char *data, size_t size, bool *has_alpha, iso_image *image,
                          iso_error *err);
iso_status iso_ppm_decode(const char *path, const char *data, size_t size, iso_image *image, iso_error *err);

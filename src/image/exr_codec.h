/* SPDX-License-Identifier: MIT */
/* exr_codec.h - OpenEXR files as bytes. A C interface to OpenEXR's C++ library; no exception leaves it.
 *
 * The C library of Debian 12 (OpenEXRCore 3.1.5) decodes four half channels in reverse order and B44 wrongly, and
 * refuses DWAA and DWAB. It writes a ZIP chunk wrongly if its compressed size is its raw size. The C++ library does
 * none of that: tests/pictures_in.py holds its results against other programs, over all forms. */
#pragma once

#ifdef __cplusplus
extern "C" {
#endif

#include "image/image.h"

/* Decodes OpenEXR data. path: for messages, which begin with it. */
iso_status iso_exr_decode(const char *path, const char *data, size_t size, iso_image_choice *choice, iso_image *image,
                          iso_error *err);
iso_status iso_exr_decode_header(const char *path, const char *data, size_t size, iso_exr_header *header, iso_error *err);
/* Encodes an image. The caller frees *data. */
iso_status iso_exr_encode(const char *path, const iso_image *image, const iso_image_note *notes, char **data, size_t *size,
                          iso_error *err);

#ifdef __cplusplus
}
#endif

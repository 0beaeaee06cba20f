/* SPDX-License-Identifier: MIT */
/* picture_file.h - loads a picture that another program wrote. */
#ifndef ISO_RENDERERS_PICTURE_FILE_H
#define ISO_RENDERERS_PICTURE_FILE_H

#include "image/image.h"
#include "scene/scene.h"

/* Loads an OpenEXR picture of the view's size with finite values in the channels R, G, B and A; else ISO_E_PROGRAM,
 * with the cause. name: the file in messages. */
iso_status iso_picture_load(const char *path, const char *name, const iso_view *view, iso_image *image, iso_error *err);

#endif

/* SPDX-License-Identifier: MIT */
/* picture_file.h - loads a picture that another program wrote. */
#pragma once

#include "image/image.h"
#include "scene/scene.h"

/* Finds the picture in place of NAME.exr: it, or NAME.npy or NAME.pfm (picture_plain.h). *path, to be freed, is NAME.exr
 * if there is none. ISO_E_PROGRAM: there are several; ISO_E_MEMORY. shown: NAME.exr in messages. */
iso_status iso_picture_find(const char *exr, const char *shown, char **path, iso_error *err);
/* Loads a picture by its ending: OpenEXR, NumPy or PFM, of the view's size with finite values in the channels R, G, B and A; else ISO_E_PROGRAM,
 * with the cause. name: the file in messages. */
iso_status iso_picture_load(const char *path, const char *name, const iso_view *view, iso_image *image, iso_error *err);

/* SPDX-License-Identifier: MIT */
/* pictures.h - a renderer that is a folder of pictures, which somebody made elsewhere.
 *
 *     DIR/SCENE-level-K/picture.exr       at the request's step; or DIR/SCENE-level-K.exr
 *                       step-0.25.exr     at that step, in voxels; or DIR/SCENE-level-K-step-0.25.exr
 *                       request.json ...  what was asked (request.h), which has to be what is asked now; or nothing
 *         calibration-CHECK-level-0/      the same of a calibration
 *         pictures.json                   what they are held to: tier, steps, bits, limits; or nothing: "samples"
 *
 * `isoshade scenes --write DIR` writes all but the pictures. A picture that is not there, has another size, lacks a
 * channel or has values that are no numbers is refused by name. */
#ifndef ISO_RENDERERS_PICTURES_H
#define ISO_RENDERERS_PICTURES_H

#include "renderers/renderers.h"

#define ISO_PICTURES_INDEX "pictures.json"
#define ISO_PICTURES_SCHEMA "isoshade.pictures/1"

enum { ISO_PICTURE_NAME_BYTES = 240 };
/* "SCENE-level-K": spaces and slashes of the scene become "-". */
void iso_picture_folder(const char *scene, size_t level, char name[ISO_PICTURE_NAME_BYTES]);
/* "picture.exr", or "step-0.25.exr"; step_voxels 0: that of the request. */
void iso_picture_file(double step_voxels, char name[ISO_PICTURE_NAME_BYTES]);

/* Registers the renderer of "NAME=DIR". ISO_E_USAGE: no such words, or a name that is taken; ISO_E_IO, ISO_E_FORMAT. */
iso_status iso_pictures_register(const char *name_and_dir, const iso_renderer_info **r, iso_error *err);

#endif

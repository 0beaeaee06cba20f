/* SPDX-License-Identifier: MIT */
/* pictures.h - a renderer that is a folder of pictures made elsewhere.
 *
 *     DIR/SCENE-level-K/picture.exr       at the request's step; or DIR/SCENE-level-K.exr
 *                       step-0.25.exr     at that step, in voxels; or DIR/SCENE-level-K-step-0.25.exr
 *                       request.json ...  the request (request.h), which must equal the current one; or nothing
 *         calibration-CHECK-level-0/      the same of a calibration
 *         pictures.json                   tier, steps, bits and limits; or nothing: "samples"
 *
 * `isoshade scenes --write DIR` writes all but the pictures. A picture that is missing, has another size, lacks a
 * channel or has values that are not finite is refused by name. */
#pragma once

#include "renderers/renderers.h"

#define ISO_PICTURES_INDEX "pictures.json"
#define ISO_PICTURES_SCHEMA "isoshade.pictures/1"

enum { ISO_PICTURE_NAME_BYTES = 240 };
/* Writes "SCENE-level-K"; spaces and slashes of the scene become "-". */
void iso_picture_folder(const char *scene, size_t level, char name[ISO_PICTURE_NAME_BYTES]);
/* Writes "picture.exr" if step_voxels is 0 (the step of the request), otherwise a name such as "step-0.25.exr". */
void iso_picture_file(double step_voxels, char name[ISO_PICTURE_NAME_BYTES]);

/* Registers the renderer of "NAME=DIR". ISO_E_USAGE: other words, or a name that is taken; ISO_E_IO, ISO_E_FORMAT. */
iso_status iso_pictures_register(const char *name_and_dir, const iso_renderer_info **r, iso_error *err);

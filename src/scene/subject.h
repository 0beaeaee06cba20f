/* SPDX-License-Identifier: MIT */
/* subject.h - what a command works on: a pyramid, or a volume that becomes one
 * in memory; and a scene resolved for it. */
#ifndef ISO_SCENE_SUBJECT_H
#define ISO_SCENE_SUBJECT_H

#include "volume/input.h"
#include "pyramid/pyramid.h"
#include "scene/scene.h"

/* path: NAME.iso, or any volume that iso_volume_input_load() reads. A volume is
 * built with `opt`; a pyramid keeps what it was built with. */
iso_status iso_subject_load_pyramid(const char *path, const iso_volume_input *input, const iso_pyramid_options *opt,
                                    const iso_progress *progress, iso_pyramid *p, iso_error *err);

/* Loads a scene and resolves it for the pyramid; size "WxH" or "N" replaces the scene's when not NULL. */
iso_status iso_subject_load_view(const char *scene_path, const iso_pyramid *p, const char *size, iso_view *view,
                                 iso_error *err);

/* "320x200", or one number for both, as --size has it. */
iso_status iso_subject_parse_image_size(const char *text, size_t *width, size_t *height, iso_error *err);

#endif

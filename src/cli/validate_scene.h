/* SPDX-License-Identifier: MIT */
/* validate_scene.h - the scene that validate writes beside its report, where there is no file of it: DIR.scene.json.
 *
 * Its comment has a checksum of all else, so that the next run replaces it only while it is what was written: people
 * edit scenes. */
#ifndef ISO_CLI_VALIDATE_SCENE_H
#define ISO_CLI_VALIDATE_SCENE_H

#include "scene/scene.h"

/* "DIR.scene.json" of the report's folder, to be freed; announced as an output (base/inputs.h). */
iso_status iso_validate_scene_name(const char *report, char **path, iso_error *err);

/* Once the inputs are known, of which it may be one. ISO_E_IO: what stands there is not as validate wrote it. */
iso_status iso_validate_scene_guard(const char *path, iso_error *err);

iso_status iso_validate_scene_save(const iso_scene *scene, const char *path, iso_error *err);

#endif

/* SPDX-License-Identifier: MIT */
/* validate_scene.h - DIR.scene.json, which validate writes next to its report if the scene has no file.
 *
 * Its comment has a checksum of the rest, so that the next run replaces it only if it is unchanged. */
#pragma once

#include "scene/scene.h"

/* Returns the name "DIR.scene.json" for the report's folder, to be freed, and announces it as an output
 * (base/inputs.h). */
iso_status iso_validate_scene_name(const char *report, char **path, iso_error *err);

/* Guards an existing file. Call it once the inputs are known, as it may be one. ISO_E_IO: validate did not write it. */
iso_status iso_validate_scene_guard(const char *path, iso_error *err);

iso_status iso_validate_scene_save(const iso_scene *scene, const char *path, iso_error *err);

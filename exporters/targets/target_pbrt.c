/* SPDX-License-Identifier: MIT */
/* target_pbrt.c - a level as a folder with a scene of pbrt-v4. */
#include "targets/target_medium.h"

static iso_status write_pbrt(const iso_export_job *job, iso_error *err)
{
    static const iso_target_medium medium = {"pbrt", "scene.pbrt", true, iso_medium_write_pbrt};
    return iso_target_medium_write(job, &medium, err);
}

const iso_export_target iso_export_target_pbrt = {
    .name = "pbrt",
    .title = "pbrt-v4",
    .stages = {"baking", "pbrt"},
    .summary = "a folder for pbrt-v4: a medium of baked grids that emits and absorbs, shaded for the scene's camera",
    .output = "a folder",
    .options = ISO_TARGET_MEDIUM_OPTIONS,
    .write = write_pbrt,
    .suffix = "",
};

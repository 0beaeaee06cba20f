/* SPDX-License-Identifier: MIT */
/* target_mitsuba.c - a level as a folder with a scene of Mitsuba 3. */
#include "targets/target_medium.h"

static iso_status write_mitsuba(const iso_export_job *job, iso_error *err)
{
    static const iso_target_medium medium = {"mitsuba", "scene.xml", false, iso_medium_write_mitsuba};
    return iso_target_medium_write(job, &medium, err);
}

const iso_export_target iso_export_target_mitsuba = {
    .name = "mitsuba",
    .title = "Mitsuba 3",
    .stages = {"baking", "mitsuba"},
    .summary = "a folder for Mitsuba 3: a medium of baked grids that only absorbs",
    .output = "a folder",
    .options = ISO_TARGET_MEDIUM_OPTIONS,
    .write = write_mitsuba,
    .suffix = "",
};

/* SPDX-License-Identifier: MIT */
/* target_paraview.c - a level and a scene as a folder for ParaView. */
#include "paraview/paraview.h"
#include "targets/targets.h"

static iso_status write_paraview(const iso_export_job *job, iso_error *err)
{
    if (job->planned)
        return iso_fail(err, ISO_E_USAGE, "--plan has no meaning for --to paraview");
    OWNED(iso_view) view = {0};
    NEED(job->view_of_level(job, job->level, &view, err));
    return iso_paraview_export(job->pyramid, job->level, &view, job->output, err);
}

const iso_export_target iso_export_target_paraview = {
    .name = "paraview",
    .title = "ParaView",
    .summary = "a folder with a .vti, and a state for ParaView and pvbatch",
    .output = "a folder",
    .options = ISO_EXPORT_TAKES(ISO_EXPORT_SCENE) | ISO_EXPORT_TAKES(ISO_EXPORT_SIZE) |
               ISO_EXPORT_TAKES(ISO_EXPORT_ADAPT),
    .write = write_paraview,
    .suffix = "",
};

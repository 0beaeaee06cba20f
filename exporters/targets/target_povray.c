/* SPDX-License-Identifier: MIT */
/* target_povray.c - a level, or what a plan leaves, as a folder that POV-Ray renders. */
#include "povray/povray.h"
#include "targets/targets.h"

static iso_status write_planned(const iso_export_job *job, iso_povray_options *o, iso_error *err)
{
    iso_planned_crop crop;
    iso_status status = iso_planned_crop_create(job->planned, &job->pyramid->levels[0], job->pyramid->options.code,
                                                job->threads, &crop, err);
    if (status != ISO_OK)
        return status;
    const iso_pyramid cropped = {.options = job->pyramid->options,
                                 .source = job->pyramid->source,
                                 .level_count = 1,
                                 .levels = &crop.level};
    o->box = (const double(*)[3])crop.box;
    status = iso_povray_export(&cropped, 0, job->view, job->output, o, job->progress, err);
    iso_planned_crop_destroy(&crop);
    return status;
}

static iso_status write_povray(const iso_export_job *job, iso_error *err)
{
    iso_povray_options o = iso_povray_defaults();
    /* A person looks at it: one pass without cutting planes, 16-bit files. */
    o.planes = 0;
    o.extrapolate = false;
    o.df3_bits = 16;
    if (job->planned)
        return write_planned(job, &o, err);
    iso_view view;
    iso_status status = job->view_of_level(job, job->level, &view, err);
    if (status != ISO_OK)
        return status;
    o.isosurface = job->isosurface;
    o.iso = job->iso;
    status = iso_povray_export(job->pyramid, job->level, &view, job->output, &o, job->progress, err);
    iso_view_destroy(&view);
    return status;
}

const iso_export_target iso_export_target_povray = {
    .name = "povray",
    .title = "POV-Ray",
    .summary = "a folder with .pov, .inc, .ini and DF3 files",
    .output = "a folder",
    .options = ISO_EXPORT_TAKES(ISO_EXPORT_ISOSURFACE) | ISO_EXPORT_TAKES(ISO_EXPORT_SCENE) |
               ISO_EXPORT_TAKES(ISO_EXPORT_SIZE) | ISO_EXPORT_TAKES(ISO_EXPORT_ROI) |
               ISO_EXPORT_TAKES(ISO_EXPORT_ADAPT),
    .write = write_povray,
};

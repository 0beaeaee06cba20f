/* SPDX-License-Identifier: MIT */
/* target_povray.c - a level, or the bricks of a plan, as a folder for POV-Ray. */
#define _GNU_SOURCE
#include <stdio.h>
#include <stdlib.h>

#include "base/file.h"
#include "base/process.h"
#include "povray/povray.h"
#include "targets/targets.h"

static iso_status write_planned(const iso_export_job *job, iso_povray_options o, iso_error *err)
{
    OWNED(iso_planned_crop) crop = {0};
    NEED(iso_planned_crop_create(job->planned, &job->pyramid->levels[0], job->threads, &crop, err));
    const iso_pyramid cropped = {.options = job->pyramid->options,
                                 .source = job->pyramid->source,
                                 .level_count = 1,
                                 .levels = &crop.level};
    o.box = (const double(*)[3])crop.box;
    o.quantum = crop.quantum;
    o.lattice = &crop.lattice;
    return iso_povray_export(&cropped, 0, job->view, job->output, &o, job->progress, err);
}

static double step_of(double asked_voxels, const iso_view *view)
{
    return asked_voxels > 0 ? asked_voxels : view->step_voxels;
}

static void samples(const iso_geometry *level, const iso_view *view, double step_voxels, size_t *intervals,
                    size_t *planes)
{
    iso_povray_options o = iso_povray_defaults();
    iso_povray_set_step(level, view, step_voxels, &o);
    *intervals = o.intervals;
    *planes = o.planes;
}

static iso_status write_povray(const iso_export_job *job, iso_error *err)
{
    iso_povray_options o = iso_povray_defaults();
    /* The same samples of the same files, to the last bit. */
    const double step = step_of(job->step_voxels, job->view);
    iso_povray_set_step(&job->pyramid->levels[job->level].geometry, job->view, step, &o);
    o.threads = job->threads;
    o.volume = job->volume;
    if (job->planned)
        return write_planned(job, o, err);
    OWNED(iso_view) view = {0};
    NEED(job->view_of_level(job, job->level, &view, err));
    o.isosurface = job->isosurface;
    o.iso = job->iso;
    return iso_povray_export(job->pyramid, job->level, &view, job->output, &o, job->progress, err);
}

/* Runs "povray NAME.ini" in the folder (doc/guide/povray.md). */
static iso_status open_povray(const char *output, iso_image *picture, iso_error *err)
{
    const char *name = iso_path_base(output);
    FREED char *program = NULL, *ini = NULL, *png = NULL;
    NEED(iso_process_find("povray", "povray", &program, err));
    if (asprintf(&ini, "%s.ini", name) < 0 || asprintf(&png, "%s/%s.png", output, name) < 0)
        return iso_fail(err, ISO_E_MEMORY, "out of memory");
    const char *argv[] = {program, ini, NULL};
    const iso_process_options options = {.directory = output, .timeout_seconds = 600};
    NEED(iso_povray_run_program(argv, &options, err));
    return iso_image_load_png(png, picture, err);
}

const iso_export_target iso_export_target_povray = {
    .name = "povray",
    .title = "POV-Ray",
    .stages = {"povray: writing DF3"},
    .summary = "a folder with .pov, .inc, .ini and DF3 files",
    .output = "a folder",
    .options = ISO_EXPORT_TAKES(ISO_EXPORT_PLAN) | ISO_EXPORT_TAKES(ISO_EXPORT_STEP) |
               ISO_EXPORT_TAKES(ISO_EXPORT_ISOSURFACE) | ISO_EXPORT_TAKES(ISO_EXPORT_SCENE) |
               ISO_EXPORT_TAKES(ISO_EXPORT_SIZE) | ISO_EXPORT_TAKES(ISO_EXPORT_ROI) |
               ISO_EXPORT_TAKES(ISO_EXPORT_ADAPT) | ISO_EXPORT_TAKES(ISO_EXPORT_EXTINCTION_SCALE),
    .narrow = true,
    .write = write_povray,
    .suffix = "",
    .open = open_povray,
    .renderer = "povray",
    .example = "scene",
    .samples = samples,
    .clipped = true,
    .limit = 5e-5,
    .why = "the same samples; half a step of the 16-bit PNG is up to 1.7e-5 in linear light",
};

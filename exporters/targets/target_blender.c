/* SPDX-License-Identifier: MIT */
/* target_blender.c - levels, or the bricks of a plan, as a .blend that is ready to render. */
#define _GNU_SOURCE
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/process.h"
#include "blender/blender.h"
#include "targets/targets.h"

static json_t *ramp_json(const iso_color_ramp *r, size_t level)
{
    return json_pack("{sI sI sb sf sf sf sf sf sf}", "level", (json_int_t)level, "stops", (json_int_t)r->count,
                     "own_points", r->own_points, "opacity_of_mm", r->unit_mm, "max_color_difference", r->color_loss,
                     "max_opacity_difference", r->opacity_loss, "max_extinction_difference", r->extinction_loss,
                     "worst_value", r->worst_value, "entries_off", r->off);
}

static bool is_same_ramp(const iso_color_ramp *a, const iso_color_ramp *b)
{
    return a->count == b->count && a->lo == b->lo && a->hi == b->hi && a->worst_value == b->worst_value &&
           memcmp(a->position, b->position, sizeof a->position) == 0 && memcmp(a->rgba, b->rgba, sizeof a->rgba) == 0;
}

/* Prints the ramp that levels [first, last] share. */
static void print_ramp(FILE *notes, const iso_color_ramp *r, size_t first, size_t last)
{
    char levels[64];
    snprintf(levels, sizeof levels, first == last ? "level %zu" : "levels %zu to %zu", first, last);
    fprintf(
        notes,
        "%s: color map exact as an image; as a ColorRamp of %zu stops%s within %.2g in color and %.2g in opacity of "
        "%.4g mm (worst at %.6g; %.1f %% of the entries by more than 1/255)\n",
        levels, r->count, r->own_points ? ", the transfer function's points," : "", r->color_loss, r->opacity_loss,
        r->unit_mm, r->worst_value, 100 * r->off);
}

/* Reports the ramps. views: of `count` levels. */
static void report_ramps(const iso_export_job *job, const iso_view *views, size_t count)
{
    if (job->pyramid && job->pyramid->levels[job->level].labels) {
        if (job->notes)
            fprintf(job->notes,
                    "label map: exact, as an image of class numbers and a color map with one entry per class\n");
        return;
    }
    json_auto_t *list = json_array();
    iso_color_ramp ramp = {0}, next;
    for (size_t k = 0, first = 0; k < count; ++k) {
        iso_color_ramp_fit(&views[k].tf, &next);
        if (k > 0 && job->notes && !is_same_ramp(&next, &ramp)) {
            print_ramp(job->notes, &ramp, job->level + first, job->level + k - 1);
            first = k;
        }
        ramp = next;
        json_array_append_new(list, ramp_json(&ramp, job->level + k));
        if (k + 1 == count && job->notes)
            print_ramp(job->notes, &ramp, job->level + first, job->level + k);
    }
    if (job->results)
        json_object_set(job->results, "color_ramps", list);
}

static iso_status write_planned(const iso_export_job *job, const iso_blender_options *o, iso_error *err)
{
    const iso_node_levels *n = &job->planned->nodes;
    OWNED(iso_planned_lattices) lattices = {0};
    /* Merges the bricks: for overlapping volumes Cycles evaluates all materials at each step, which took several times
     * as long. */
    NEED(iso_planned_lattices_create(job->planned, true, true, job->threads, &lattices, err));
    const iso_blender_plan plan = {.geometry = &n->geometry,
                                   .lattice = &lattices.items[0],
                                   .source = job->pyramid->source,
                                   .unit = job->pyramid->unit.name};
    NEED(iso_blender_export_plan(&plan, job->view, job->output, o, job->progress, err));
    report_ramps(job, job->view, 1);
    return ISO_OK;
}

static void take_grid_options(const iso_export_job *job, iso_blender_options *o)
{
    o->threads = job->threads;
    o->dense = job->dense;
    o->half = job->half_float;
    o->command = job->command;
    o->volume = job->volume;
}

static iso_status write_blender(const iso_export_job *job, iso_error *err)
{
    const size_t count = job->level_count;
    iso_blender_options o = iso_blender_defaults();
    o.step_voxels = job->step_voxels > 0 ? job->step_voxels : job->view->step_voxels;
    take_grid_options(job, &o);
    o.physical = job->physical;
    if (job->planned)
        return write_planned(job, &o, err);
    FREED iso_view *views = calloc(count, sizeof *views);
    iso_status status = views ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "export: out of memory");
    for (size_t k = 0; k < count && status == ISO_OK; ++k)
        status = job->view_of_level(job, job->level + k, &views[k], err);
    if (status == ISO_OK)
        status = iso_blender_export_levels(job->pyramid, &(iso_blender_levels){job->level, count, views}, job->output,
                                           &o, job->progress, err);
    if (status == ISO_OK)
        report_ramps(job, views, count);
    for (size_t k = 0; views && k < count; ++k)
        iso_view_destroy(&views[k]);
    return status;
}

static iso_status write_blender_frames(const iso_export_job *job, iso_error *err)
{
    iso_blender_options o = iso_blender_defaults();
    o.step_voxels = job->step_voxels > 0 ? job->step_voxels : job->view->step_voxels;
    take_grid_options(job, &o);
    o.physical = job->physical;
    const iso_blender_sequence all = {job->level, job->level_count, job->frame_count, job->view, job->load_frame, job->frame_user,
                                      job->force};
    NEED(iso_blender_export_sequence(&all, job->output, &o, job->progress, err));
    report_ramps(job, job->view, 1);
    return ISO_OK;
}

static iso_status write_blender_volumes(const iso_export_job *job, iso_error *err)
{
    iso_blender_options o = iso_blender_defaults();
    o.step_voxels = job->step_voxels;
    take_grid_options(job, &o);
    o.physical = job->physical;
    const iso_blender_several all = {job->level, job->level_count, job->volume_count, job->load_volume, job->volume_user,
                                     job->force};
    return iso_blender_export_several(&all, job->output, &o, job->progress, err);
}

/* Renders the first frame of the file, with the agreement settings of its text block, to a picture next to it. */
static iso_status open_blender(const char *output, iso_image *picture, iso_error *err)
{
    FREED char *program = NULL, *exr = NULL;
    const int stem = (int)(strlen(output) - strlen(".blend"));
    NEED(iso_process_find("blender", "blender", &program, err));
    NEED_MEMORY(asprintf(&exr, "%.*s_0001.exr", stem, output) >= 0, err, "out of memory");
    const char *argv[] = {program, "-b", output, "--python-text", "isoshade agreement", "-f", "1", NULL};
    FREED char *folder = iso_path_dir(exr);
    const iso_process_options options = {.sandbox = {.output = folder}, .timeout_seconds = 600};
    NEED(folder ? iso_process_run(argv, &options, err) : iso_fail(err, ISO_E_MEMORY, "out of memory"));
    return iso_image_load_exr(exr, picture, err);
}

const iso_export_target iso_export_target_blender = {
    .name = "blender",
    .title = "Blender",
    .stages = {"OpenVDB grids", "Blender"},
    .summary = "a .blend that is ready to render, and its OpenVDB grids",
    .output = "NAME.blend",
    .options = ISO_EXPORT_TAKES(ISO_EXPORT_PLAN) | ISO_EXPORT_TAKES(ISO_EXPORT_LEVELS) |
               ISO_EXPORT_TAKES(ISO_EXPORT_STEP) | ISO_EXPORT_TAKES(ISO_EXPORT_SCENE) |
               ISO_EXPORT_TAKES(ISO_EXPORT_SIZE) | ISO_EXPORT_TAKES(ISO_EXPORT_ROI) |
               ISO_EXPORT_TAKES(ISO_EXPORT_ADAPT) | ISO_EXPORT_TAKES(ISO_EXPORT_EXTINCTION_SCALE) |
               ISO_EXPORT_TAKES(ISO_EXPORT_MATERIAL) | ISO_EXPORT_TAKES(ISO_EXPORT_HALF) |
               ISO_EXPORT_TAKES(ISO_EXPORT_DENSE),
    .narrow = true,
    .write = write_blender,
    .write_frames = write_blender_frames,
    .write_volumes = write_blender_volumes,
    .open = open_blender,
    .renderer = "cycles",
    .stamped = true,
    .guard = iso_blender_guard_grids,
    .example = "scene.blend",
    .limit = 5e-4,
    .why = "the same steps and random numbers; steep tables amplify rounding to single precision",
};

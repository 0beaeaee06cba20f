/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/provenance.h"
#include "blender/blender_scene.h"
#include "vdb/vdb.h"

static iso_status check_plan(const iso_blender_plan *plan, const iso_view *view, const iso_blender_options *opt,
                             iso_error *err)
{
    iso_level box = {.geometry = *plan->geometry};
    const iso_pyramid p = {.level_count = 1, .levels = &box};
    if (view->tf_2d || view->extinction_scale || view->roi)
        return iso_fail(err, ISO_E_RANGE,
                        "blender: a plan cannot have a 2D transfer function, extinction scale or region of interest");
    return iso_blender_check(&p, 0, 1, opt, err);
}

static char *plan_vdb_path(const iso_blender_plan *plan, const char *blend_path)
{
    return iso_blender_vdb_path(blend_path, plan->lattice->level, 1, false);
}

static iso_status save_lattice(const iso_blender_plan *plan, const char *path, iso_vdb_options options,
                               const iso_progress *progress, iso_error *err)
{
    const iso_blender_space space = iso_blender_space_of(plan->geometry);
    iso_lattice lattice = *plan->lattice;
    iso_blender_note_space(&space, &options);
    lattice.geometry = iso_blender_in_space(&lattice.geometry, &space);
    return iso_vdb_save_lattices(&lattice, 1, plan->source, path, &options, progress, err);
}

/* Output of a plan: a picture, or a .blend whose grids have paths relative to it. */
typedef struct plan_job {
    const iso_blender_plan *plan;
    const iso_view *view;
    const char *blend_path;
    bool relative;
    const iso_blender_options *opt;
} plan_job;

static json_t *describe_plan(const plan_job *job, const char *name)
{
    const iso_blender_plan *plan = job->plan;
    const iso_view *view = job->view;
    const iso_blender_space space = iso_blender_space_of(plan->geometry);
    const double step = job->opt->step_voxels * space.units * iso_geometry_min_spacing_mm(plan->geometry);
    json_t *about = iso_blender_describe_scene(view, &space, plan->geometry, name, job->opt), *levels = json_array();
    const iso_geometry g = iso_blender_in_space(&plan->lattice->geometry, &space);
    char *path = plan_vdb_path(plan, job->blend_path), text[PATH_MAX];
    snprintf(text, sizeof text, "%s%s", job->relative ? "//" : "", job->relative ? iso_path_base(path) : path);
    json_array_append_new(levels, iso_blender_describe_level(&g, plan->lattice->level, 0, text, step));
    free(path);
    json_object_set_new(about, "levels", levels);
    json_object_set_new(about, "planned", json_true());
    json_object_set_new(about, "tf", iso_blender_describe_tf(view, 0, 1, space.units));
    json_object_set_new(about, "film_transparent", json_boolean(!job->relative));
    json_object_set_new(about, "source", iso_blender_text(iso_provenance_name(plan->source), 1000));
    json_object_set_new(about, "unit", json_string(plan->unit ? plan->unit : ""));
    return about;
}

iso_status iso_cycles_render_plan(const iso_blender_plan *plan, const iso_view *view, const iso_blender_options *opt,
                                  iso_image *image, const iso_progress *progress, iso_error *err)
{
    *image = (iso_image){0};
    NEED(check_plan(plan, view, opt, err));
    FREED char *folder = iso_blender_folder(opt), *stem = folder ? iso_path_join(folder, "volume.blend") : NULL;
    if (!stem)
        return iso_temp_dir_fail(err);
    const iso_blender_space space = iso_blender_space_of(plan->geometry);
    FREED char *path = plan_vdb_path(plan, stem);
    iso_status status = save_lattice(plan, path, iso_vdb_defaults(), progress, err);
    if (status == ISO_OK) {
        const plan_job job = {plan, view, stem, false, opt};
        json_t *about = describe_plan(&job, "isoshade");
        json_object_set_new(about, "frames",
                            iso_blender_describe_frames(space.units * iso_geometry_min_spacing_mm(plan->geometry),
                                                        folder, opt, 1));
        status = iso_blender_run(about, folder, opt, progress, err);
    }
    TRY(status, iso_blender_load_pictures(folder, view, 1, image, err));
    iso_remove_tree(folder);
    return status;
}

/* Writes the grids, then the .blend. */
static iso_status write_plan(const plan_job *job, const char *folder, iso_output outs[2], const iso_progress *progress,
                             iso_error *err)
{
    const iso_blender_plan *plan = job->plan;
    const char *blend_path = job->blend_path;
    const char *base = iso_path_base(blend_path);
    char name[NAME_MAX + 1];
    iso_vdb_options options = iso_vdb_defaults();
    iso_vdb_shown shown; /* unused for lattices, which are sparse */
    iso_blender_grid_options(job->opt, &job->view->tf, NULL, &shown, &options);
    FREED char *path = plan_vdb_path(plan, blend_path);
    NEED(iso_output_begin(&outs[0], path, err));
    NEED(save_lattice(plan, outs[0].temp_path, options, progress, err));
    snprintf(name, sizeof name, "%.*s", (int)(strlen(base) - strlen(".blend")), base);
    json_t *about = describe_plan(job, name);
    iso_blender_scale_directions(about, job->opt, ISO_VDB_LINEAR_SCALE);
    return iso_blender_save(about, blend_path, &outs[1], folder, job->opt, progress, err);
}

iso_status iso_blender_export_plan(const iso_blender_plan *plan, const iso_view *view, const char *blend_path,
                                   const iso_blender_options *opt, const iso_progress *progress, iso_error *err)
{
    NEED(check_plan(plan, view, opt, err));
    NEED(iso_blender_check_path(blend_path, err));
    iso_blender_started blender;
    iso_output outs[2] = {0};
    iso_status status = iso_blender_begin(opt, &blender, err);
    const plan_job job = {plan, view, blend_path, true, &blender.options};
    TRY(status, write_plan(&job, blender.folder, outs, progress, err));
    TRY(status, iso_output_commit_all(outs, 2, err));
    for (size_t i = 0; i < 2; ++i)
        iso_output_abandon(&outs[i]);
    iso_blender_end(&blender);
    return status;
}

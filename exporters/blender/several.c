/* SPDX-License-Identifier: MIT */
/* several.c - several pyramids in one .blend, loaded one after the other, with a grid file for each and its levels:
 * the frames of a series share a material; volumes have a box, a material, a transfer function and a collection each,
 * and camera, lights and background of the first. */
#define _GNU_SOURCE
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/file.h"
#include "base/provenance.h"
#include "blender/blender_scene.h"

typedef struct several_job {
    const iso_blender_sequence *series; /* or */
    const iso_blender_several *volumes;
    size_t level, level_count, count;
    bool force;
    const char *blend_path, *folder;
    iso_blender_options opt;
    const iso_progress *progress;
    iso_blender_space space; /* of the first, used for all */
    iso_output *outs;        /* files of each, level by level, then the .blend */
    json_t *about, *more;    /* first volume or series; other volumes */
} several_job;

static size_t file_count(const several_job *job)
{
    return job->count * job->level_count;
}

/* Writes the name of the .blend without its suffix. */
static void blend_name(const several_job *job, char name[NAME_MAX + 1])
{
    const char *base = iso_path_base(job->blend_path);
    snprintf(name, NAME_MAX + 1, "%.*s", (int)(strlen(base) - strlen(".blend")), base);
}

/* name: a volume's, or a frame's number, which Blender expects last. */
static char *grid_path(const several_job *job, const char *name, size_t level)
{
    const int stem = (int)(strlen(job->blend_path) - strlen(".blend"));
    char *path = NULL, which[40] = "";
    if (job->level_count > 1)
        snprintf(which, sizeof which, "_level_%zu", level);
    return asprintf(&path, "%.*s%s_%s%s.vdb", stem, job->blend_path, job->series ? which : "", name,
                    job->series ? "" : which) < 0
               ? NULL
               : path;
}

static void describe_level(const several_job *job, const iso_pyramid *p, const iso_view *view, const char *name,
                           size_t k, json_t *levels)
{
    const size_t number = job->level + k;
    char relative[NAME_MAX + 48], *path = grid_path(job, name, number);
    snprintf(relative, sizeof relative, "//%s", iso_path_base(path ? path : ""));
    free(path);
    const blender_level level = {&p->levels[number].geometry, number, {k, 0}, relative, "", p->levels[number].is_optimized};
    iso_blender_append_level(levels, &level, view, &job->space, &job->opt);
}

/* Describes a volume with its own step; Cycles uses the shortest step of overlapping volumes. title: of its box. */
static json_t *describe(const several_job *job, const iso_pyramid *p, const iso_view *view, const char *title,
                        const char *name)
{
    const iso_geometry *g = &p->levels[job->level].geometry;
    json_t *about = iso_blender_describe_scene(view, &job->space, g, title, &job->opt), *levels = json_array();
    for (size_t k = 0; k < job->level_count; ++k)
        describe_level(job, p, view, name, k, levels);
    json_object_set_new(about, "levels", levels);
    json_object_set_new(about, "tf", iso_blender_describe_one_tf(view, job->level, job->level_count, job->space.units));
    json_object_set_new(about, "extinction_scale", json_boolean(g->has_no_data));
    json_object_set_new(about, "film_transparent", json_false());
    json_object_set_new(about, "source", iso_blender_text(iso_provenance_name(p->source), 1000));
    json_object_set_new(about, "unit", json_string(p->unit.name));
    return about;
}

static iso_status write_grid(several_job *job, const iso_pyramid *p, const char *name, size_t level, iso_output *out,
                             iso_error *err)
{
    iso_pyramid scaled = {0};
    iso_vdb_options options = iso_vdb_defaults();
    iso_vdb_shown shown;
    FREED char *path = grid_path(job, name, level);
    options.pad_voxels = 1;
    if (job->series)
        iso_blender_grid_options(&job->opt, &job->series->view->tf, job->series->view->tf_2d, &shown, &options);
    iso_blender_note_space(&job->space, &options);
    iso_status status = path ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "blender: out of memory");
    if (job->volumes)
        TRY(status, iso_blender_guard_grid(path, job->force, err));
    TRY(status, iso_output_begin(out, path, err));
    TRY(status, iso_blender_pyramid_in_space(p, &job->space, &scaled, err));
    TRY(status, iso_vdb_save(&scaled, level, 1, out->temp_path, &options, job->series ? NULL : job->progress, err));
    free(scaled.levels);
    return status;
}

static iso_status write_grids(several_job *job, size_t i, const iso_pyramid *p, const char *name, iso_error *err)
{
    for (size_t k = 0; k < job->level_count; ++k)
        NEED(write_grid(job, p, name, job->level + k, &job->outs[i * job->level_count + k], err));
    return ISO_OK;
}

/* ---- frames of a series ---- */

static void frame_name(size_t frame, char name[24])
{
    snprintf(name, 24, "%04zu", frame);
}

/* Describes the scene with the first frame; its volume is the first file. */
static void describe_series(several_job *job, const iso_pyramid *p)
{
    char title[NAME_MAX + 1], name[24];
    blend_name(job, title);
    frame_name(0, name);
    job->about = describe(job, p, job->series->view, title, name);
    json_object_set_new(job->about, "sequence", json_integer((json_int_t)job->count));
    iso_blender_scale_directions(job->about, &job->opt, iso_vdb_direction_scale(p->options.code));
}

static iso_status write_frame(several_job *job, size_t frame, iso_error *err)
{
    iso_pyramid p = {0};
    char name[24];
    frame_name(frame, name);
    iso_status status = job->series->load(job->series->user, frame, &p, err);
    TRY(status, iso_blender_check(&p, job->level, job->level_count, &job->opt, err));
    if (status == ISO_OK && p.levels[0].labels)
        status = iso_fail(
            err, ISO_E_USAGE,
            "blender: cannot play a series of label maps; use --frame K for one, or --no-labels to interpolate");
    if (status == ISO_OK && frame == 0) {
        job->space = iso_blender_space_of(&p.levels[0].geometry);
        describe_series(job, &p);
    }
    if (status == ISO_OK && p.levels[0].geometry.has_no_data) /* of this frame alone: others have no such grid */
        json_object_set_new(job->about, "extinction_scale", json_true());
    TRY(status, write_grids(job, frame, &p, name, err));
    iso_pyramid_destroy(&p);
    return status;
}

/* Refuses foreign files before the first frame is loaded. */
static iso_status guard_frames(const several_job *job, iso_error *err)
{
    for (size_t i = 0; i < file_count(job); ++i) {
        char name[24];
        frame_name(i / job->level_count, name);
        FREED char *path = grid_path(job, name, job->level + i % job->level_count);
        NEED(path ? iso_blender_guard_grid(path, job->force, err)
                  : iso_fail(err, ISO_E_MEMORY, "blender: out of memory"));
    }
    return ISO_OK;
}

/* ---- volumes ---- */

/* Writes the image of a label map to a folder of its own, since all images have the same name. */
static iso_status describe_labels(const several_job *job, json_t *about, const iso_pyramid *p, const iso_view *view,
                                  const char *name, iso_error *err)
{
    if (!p->levels[job->level].labels)
        return ISO_OK;
    FREED iso_view *views = calloc(job->level_count, sizeof *views);
    for (size_t k = 0; views && k < job->level_count; ++k)
        views[k] = *view;
    FREED char *own = iso_path_join(job->folder, name);
    if (!views || !own || mkdir(own, 0777) != 0)
        return iso_fail(err, ISO_E_IO, "blender: no folder for labels");
    return iso_blender_describe_labels(about, p, &(iso_blender_levels){job->level, job->level_count, views},
                                       job->space.units, own, err);
}

static iso_status write_volume(several_job *job, size_t i, iso_error *err)
{
    OWNED(iso_pyramid) p = {0};
    OWNED(iso_view) view = {0};
    char name[ISO_BLENDER_VOLUME_NAME] = "";
    iso_status status = job->volumes->load(job->volumes->user, i, &p, &view, name, err);
    if (status == ISO_OK && !(job->opt.step_voxels > 0))
        job->opt.step_voxels = view.step_voxels;
    TRY(status, iso_blender_check(&p, job->level, job->level_count, &job->opt, err));
    if (status == ISO_OK && i == 0)
        job->space = iso_blender_space_of(&p.levels[0].geometry);
    TRY(status, write_grids(job, i, &p, name, err));
    json_auto_t *about = status == ISO_OK ? describe(job, &p, &view, name, name) : NULL;
    TRY(status, describe_labels(job, about, &p, &view, name, err));
    if (status == ISO_OK && i == 0)
        job->about = json_incref(about);
    else if (status == ISO_OK)
        json_array_append(job->more, about);
    return status;
}

/* ---- both ---- */

static iso_status write_blend(several_job *job, iso_error *err)
{
    json_t *about = job->about;
    job->about = NULL; /* taken */
    if (job->volumes) {
        char scene[NAME_MAX + 1];
        blend_name(job, scene);
        json_object_set_new(about, "scene", iso_blender_text(scene, 50));
        json_object_set(about, "more", job->more);
    }
    return iso_blender_save(about, job->blend_path, &job->outs[file_count(job)], job->folder, &job->opt, job->progress,
                            err);
}

/* job: what is exported. */
static iso_status export_all(several_job job, const char *blend_path, const iso_blender_options *opt,
                             const iso_progress *progress, iso_error *err)
{
    iso_blender_started blender;
    job.blend_path = blend_path;
    job.progress = progress;
    NEED(iso_blender_check_path(blend_path, err));
    if (job.series)
        NEED(guard_frames(&job, err));
    job.outs = calloc(file_count(&job) + 1, sizeof *job.outs);
    NEED_MEMORY(job.outs, err, "%s: out of memory", blend_path);
    job.more = json_array();
    iso_status status = iso_blender_begin(opt, &blender, err);
    job.opt = blender.options;
    job.folder = blender.folder;
    for (size_t i = 0; i < job.count && status == ISO_OK; ++i)
        status = job.series ? write_frame(&job, i, err) : write_volume(&job, i, err);
    TRY(status, write_blend(&job, err));
    TRY(status, iso_output_commit_all(job.outs, file_count(&job) + 1, err));
    for (size_t i = 0; i <= file_count(&job); ++i)
        iso_output_abandon(&job.outs[i]);
    json_decref(job.about);
    json_decref(job.more);
    iso_blender_end(&blender);
    free(job.outs);
    return status;
}

iso_status iso_blender_export_sequence(const iso_blender_sequence *s, const char *blend_path,
                                       const iso_blender_options *opt, const iso_progress *progress, iso_error *err)
{
    const several_job job = {
        .series = s, .level = s->level, .level_count = s->level_count, .count = s->count, .force = s->force};
    return export_all(job, blend_path, opt, progress, err);
}

iso_status iso_blender_export_several(const iso_blender_several *s, const char *blend_path,
                                      const iso_blender_options *opt, const iso_progress *progress, iso_error *err)
{
    const several_job job = {
        .volumes = s, .level = s->level, .level_count = s->level_count, .count = s->count, .force = s->force};
    return export_all(job, blend_path, opt, progress, err);
}

/* SPDX-License-Identifier: MIT */
/* several.c - several volumes in one .blend: per volume a box, a grid file, a material, a transfer function and a
 * collection. Camera, lights and background are the first volume's. */
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
    const iso_blender_several *several;
    const char *blend_path, *folder;
    iso_blender_options opt;
    const iso_progress *progress;
    iso_blender_space space; /* of the first volume, used for all */
    iso_output *outs;        /* files of the volumes, level by level for each, then the .blend */
    json_t *about, *more;    /* first volume; other volumes */
} several_job;

static char *grid_path(const several_job *job, const char *name, size_t level)
{
    const int stem = (int)(strlen(job->blend_path) - strlen(".blend"));
    char *path = NULL, which[40] = "";
    if (job->several->level_count > 1)
        snprintf(which, sizeof which, "_level_%zu", level);
    return asprintf(&path, "%.*s_%s%s.vdb", stem, job->blend_path, name, which) < 0 ? NULL : path;
}

static size_t file_count(const iso_blender_several *s)
{
    return s->count * s->level_count;
}

static void describe_level(const several_job *job, const iso_pyramid *p, const iso_view *view, const char *name,
                           size_t k, json_t *levels)
{
    const size_t number = job->several->level + k;
    char relative[NAME_MAX + 48], *path = grid_path(job, name, number);
    snprintf(relative, sizeof relative, "//%s", iso_path_base(path ? path : ""));
    free(path);
    const blender_level level = {&p->levels[number].geometry, number, {k, 0}, relative, ""};
    iso_blender_append_level(levels, &level, view, &job->space, &job->opt);
}

/* Describes a volume with its own step; Cycles uses the shortest step of overlapping volumes. */
static json_t *describe(const several_job *job, const iso_pyramid *p, const iso_view *view, const char *name)
{
    const iso_blender_several *s = job->several;
    const iso_geometry *g = &p->levels[s->level].geometry;
    json_t *about = iso_blender_describe_scene(view, &job->space, g, name, &job->opt), *levels = json_array();
    for (size_t k = 0; k < s->level_count; ++k)
        describe_level(job, p, view, name, k, levels);
    json_object_set_new(about, "levels", levels);
    json_object_set_new(about, "tf", iso_blender_describe_one_tf(view, s->level, s->level_count, job->space.units));
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
    options.pad_voxels = 1;
    iso_blender_note_space(&job->space, &options);
    char *path = grid_path(job, name, level);
    iso_status status = path ? iso_blender_guard_grid(path, job->several->force, err)
                             : iso_fail(err, ISO_E_MEMORY, "blender: out of memory");
    TRY(status, iso_output_begin(out, path, err));
    TRY(status, iso_blender_pyramid_in_space(p, &job->space, &scaled, err));
    TRY(status, iso_vdb_save(&scaled, level, 1, out->temp_path, &options, job->progress, err));
    free(scaled.levels);
    free(path);
    return status;
}

/* Writes the image of a label map to a folder of its own, since all images have the same name. */
static iso_status describe_labels(const several_job *job, json_t *about, const iso_pyramid *p, const iso_view *view,
                                  const char *name, iso_error *err)
{
    const iso_blender_several *s = job->several;
    if (!p->levels[s->level].labels)
        return ISO_OK;
    iso_view *views = calloc(s->level_count, sizeof *views);
    for (size_t k = 0; views && k < s->level_count; ++k)
        views[k] = *view;
    char *own = iso_path_join(job->folder, name);
    iso_status status = views && own && mkdir(own, 0777) == 0
                            ? ISO_OK
                            : iso_fail(err, ISO_E_IO, "blender: no folder for labels");
    if (status == ISO_OK)
        status = iso_blender_describe_labels(about, p, &(iso_blender_levels){s->level, s->level_count, views},
                                             job->space.units, own, err);
    free(views);
    free(own);
    return status;
}

static iso_status write_volume(several_job *job, size_t i, iso_error *err)
{
    const iso_blender_several *s = job->several;
    iso_pyramid p = {0};
    iso_view view = {0};
    char name[ISO_BLENDER_VOLUME_NAME] = "";
    iso_status status = s->load(s->user, i, &p, &view, name, err);
    if (status == ISO_OK && !(job->opt.step_voxels > 0))
        job->opt.step_voxels = view.step_voxels;
    TRY(status, iso_blender_check(&p, s->level, s->level_count, &job->opt, err));
    if (status == ISO_OK && i == 0)
        job->space = iso_blender_space_of(&p.levels[0].geometry);
    for (size_t k = 0; k < s->level_count; ++k)
        TRY(status, write_grid(job, &p, name, s->level + k, &job->outs[i * s->level_count + k], err));
    json_t *about = status == ISO_OK ? describe(job, &p, &view, name) : NULL;
    TRY(status, describe_labels(job, about, &p, &view, name, err));
    if (status == ISO_OK && i == 0)
        job->about = json_incref(about);
    else if (status == ISO_OK)
        json_array_append(job->more, about);
    json_decref(about);
    iso_view_destroy(&view);
    iso_pyramid_destroy(&p);
    return status;
}

static iso_status write_blend(several_job *job, iso_error *err)
{
    const char *base = iso_path_base(job->blend_path);
    char scene[NAME_MAX + 1];
    json_t *about = job->about;
    job->about = NULL; /* taken */
    snprintf(scene, sizeof scene, "%.*s", (int)(strlen(base) - strlen(".blend")), base);
    json_object_set_new(about, "scene", iso_blender_text(scene, 50));
    json_object_set(about, "more", job->more);
    return iso_blender_save(about, job->blend_path, &job->outs[file_count(job->several)], job->folder, &job->opt,
                            job->progress, err);
}

iso_status iso_blender_export_several(const iso_blender_several *s, const char *blend_path,
                                      const iso_blender_options *opt, const iso_progress *progress, iso_error *err)
{
    iso_status status = iso_blender_check_path(blend_path, err);
    if (status != ISO_OK)
        return status;
    char *folder = iso_make_temp_dir();
    several_job job = {.several = s,
                       .blend_path = blend_path,
                       .folder = folder,
                       .opt = *opt,
                       .progress = progress,
                       .outs = calloc(file_count(s) + 1, sizeof *job.outs),
                       .more = json_array()};
    if (!folder || !job.outs)
        status = iso_temp_dir_fail(err);
    for (size_t i = 0; i < s->count && status == ISO_OK; ++i)
        status = write_volume(&job, i, err);
    TRY(status, write_blend(&job, err));
    TRY(status, iso_output_commit_all(job.outs, file_count(s) + 1, err));
    for (size_t i = 0; job.outs && i <= file_count(s); ++i)
        iso_output_abandon(&job.outs[i]);
    json_decref(job.about);
    json_decref(job.more);
    if (folder)
        iso_remove_tree(folder);
    free(job.outs);
    free(folder);
    return status;
}

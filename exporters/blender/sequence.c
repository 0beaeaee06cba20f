/* SPDX-License-Identifier: MIT */
/* sequence.c - the frames of a series in one .blend: a grid file per frame, one material, one transfer function. */
#define _GNU_SOURCE
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/provenance.h"
#include "blender/blender_scene.h"

typedef struct sequence_job {
    const iso_blender_sequence *sequence;
    const char *blend_path;
    const iso_blender_options *opt;
    const iso_progress *progress;
    iso_blender_space space; /* of the first frame, used for all */
    iso_output *outs;        /* files of the frames, level by level for each, then the .blend */
    json_t *about;
} sequence_job;

static char *grid_path(const sequence_job *job, size_t frame, size_t level)
{
    const int stem = (int)(strlen(job->blend_path) - strlen(".blend"));
    char *path = NULL, which[40] = "";
    if (job->sequence->level_count > 1)
        snprintf(which, sizeof which, "_level_%zu", level);
    return asprintf(&path, "%.*s%s_%04zu.vdb", stem, job->blend_path, which, frame) < 0 ? NULL : path;
}

static size_t file_count(const iso_blender_sequence *s)
{
    return s->count * s->level_count;
}

/* Describes a level; its volume is the file of the first frame. */
static void describe_level(const sequence_job *job, const iso_pyramid *p, size_t k, json_t *levels)
{
    const iso_blender_sequence *s = job->sequence;
    const size_t number = s->level + k;
    char relative[NAME_MAX + 48], *path = grid_path(job, 0, number);
    snprintf(relative, sizeof relative, "//%s", iso_path_base(path ? path : ""));
    free(path);
    const blender_level level = {&p->levels[number].geometry, number, {k, 0}, relative, ""};
    iso_blender_append_level(levels, &level, s->view, &job->space, job->opt);
}

/* Describes the scene with the first frame; its volume is the first file. */
static void describe(sequence_job *job, const iso_pyramid *p)
{
    const iso_blender_sequence *s = job->sequence;
    const iso_geometry *g = &p->levels[s->level].geometry;
    const char *base = iso_path_base(job->blend_path);
    char name[NAME_MAX + 1];
    snprintf(name, sizeof name, "%.*s", (int)(strlen(base) - strlen(".blend")), base);
    job->about = iso_blender_describe_scene(s->view, &job->space, g, name, job->opt);
    json_t *levels = json_array();
    for (size_t k = 0; k < s->level_count; ++k)
        describe_level(job, p, k, levels);
    json_object_set_new(job->about, "levels", levels);
    json_object_set_new(job->about, "sequence", json_integer((json_int_t)s->count));
    json_object_set_new(job->about, "tf",
                        iso_blender_describe_one_tf(s->view, s->level, s->level_count, job->space.units));
    json_object_set_new(job->about, "extinction_scale", json_boolean(g->has_no_data));
    iso_blender_scale_directions(job->about, job->opt, iso_vdb_direction_scale(p->options.code));
    json_object_set_new(job->about, "film_transparent", json_false());
    json_object_set_new(job->about, "source", iso_blender_text(iso_provenance_name(p->source), 1000));
    json_object_set_new(job->about, "unit", json_string(p->unit.name));
}

static iso_status write_grid(sequence_job *job, const iso_pyramid *p, size_t level, iso_output *out, iso_error *err)
{
    iso_pyramid scaled = {0};
    iso_vdb_options options = iso_vdb_defaults();
    options.pad_voxels = 1;
    iso_vdb_shown shown;
    iso_blender_grid_options(job->opt, &job->sequence->view->tf, job->sequence->view->tf_2d, &shown, &options);
    iso_blender_note_space(&job->space, &options);
    iso_status status = iso_blender_pyramid_in_space(p, &job->space, &scaled, err);
    TRY(status, iso_vdb_save(&scaled, level, 1, out->temp_path, &options, NULL, err));
    free(scaled.levels);
    return status;
}

static iso_status write_file(sequence_job *job, const iso_pyramid *p, size_t frame, size_t k, iso_error *err)
{
    const size_t level = job->sequence->level + k;
    iso_output *out = &job->outs[frame * job->sequence->level_count + k];
    char *path = grid_path(job, frame, level);
    iso_status status = path ? iso_output_begin(out, path, err) : iso_fail(err, ISO_E_MEMORY, "blender: out of memory");
    TRY(status, write_grid(job, p, level, out, err));
    free(path);
    return status;
}

static iso_status write_frame(sequence_job *job, size_t frame, iso_error *err)
{
    const iso_blender_sequence *s = job->sequence;
    iso_pyramid p = {0};
    iso_status status = s->load(s->user, frame, &p, err);
    TRY(status, iso_blender_check(&p, s->level, s->level_count, job->opt, err));
    if (status == ISO_OK && p.levels[0].labels)
        status = iso_fail(
            err, ISO_E_USAGE,
            "blender: cannot play a series of label maps; use --frame K for one, or --no-labels to interpolate");
    if (status == ISO_OK && frame == 0) {
        job->space = iso_blender_space_of(&p.levels[0].geometry);
        describe(job, &p);
    }
    for (size_t k = 0; k < s->level_count; ++k)
        TRY(status, write_file(job, &p, frame, k, err));
    iso_pyramid_destroy(&p);
    return status;
}

static iso_status guard_frames(const sequence_job *job, iso_error *err)
{
    iso_status status = ISO_OK;
    const iso_blender_sequence *s = job->sequence;
    for (size_t i = 0; i < file_count(s) && status == ISO_OK; ++i) {
        char *path = grid_path(job, i / s->level_count, s->level + i % s->level_count);
        status = path ? iso_blender_guard_grid(path, s->force, err)
                      : iso_fail(err, ISO_E_MEMORY, "blender: out of memory");
        free(path);
    }
    return status;
}

static iso_status write_blend(sequence_job *job, const char *folder, iso_error *err)
{
    json_t *about = job->about;
    job->about = NULL; /* taken */
    iso_output *out = &job->outs[file_count(job->sequence)];
    return iso_blender_save(about, job->blend_path, out, folder, job->opt, job->progress, err);
}

iso_status iso_blender_export_sequence(const iso_blender_sequence *s, const char *blend_path,
                                       const iso_blender_options *opt, const iso_progress *progress, iso_error *err)
{
    sequence_job job = {.sequence = s, .blend_path = blend_path, .opt = opt, .progress = progress};
    iso_status status = iso_blender_check_path(blend_path, err);
    TRY(status, guard_frames(&job, err));
    if (status != ISO_OK)
        return status;
    char *folder = iso_make_temp_dir();
    job.outs = calloc(file_count(s) + 1, sizeof *job.outs);
    if (!folder || !job.outs)
        status = iso_temp_dir_fail(err);
    for (size_t k = 0; k < s->count && status == ISO_OK; ++k)
        status = write_frame(&job, k, err);
    TRY(status, write_blend(&job, folder, err));
    TRY(status, iso_output_commit_all(job.outs, file_count(s) + 1, err));
    for (size_t i = 0; job.outs && i <= file_count(s); ++i)
        iso_output_abandon(&job.outs[i]);
    json_decref(job.about);
    if (folder)
        iso_remove_tree(folder);
    free(job.outs);
    free(folder);
    return status;
}

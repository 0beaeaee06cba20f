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
    iso_output *outs;        /* files of the frames, then the .blend */
    json_t *about;
} sequence_job;

static char *grid_path(const char *blend_path, size_t frame)
{
    char *path = NULL;
    return asprintf(&path, "%.*s_%04zu.vdb", (int)(strlen(blend_path) - strlen(".blend")), blend_path, frame) < 0
               ? NULL
               : path;
}

/* Describes the scene with the first frame; its volume is the first file. */
static void describe(sequence_job *job, const iso_pyramid *p)
{
    const iso_blender_sequence *s = job->sequence;
    const iso_geometry *g = &p->levels[s->level].geometry;
    const char *base = iso_path_base(job->blend_path);
    char name[NAME_MAX + 1], relative[NAME_MAX + 48];
    char *path = grid_path(job->blend_path, 0);
    snprintf(name, sizeof name, "%.*s", (int)(strlen(base) - strlen(".blend")), base);
    snprintf(relative, sizeof relative, "//%s", iso_path_base(path ? path : ""));
    free(path);
    job->about = iso_blender_describe_scene(s->view, &job->space, g, name, job->opt);
    json_t *levels = json_array();
    iso_blender_append_level(levels, &(blender_level){g, s->level, {0, 1}, relative, ""}, s->view, &job->space,
                             job->opt);
    json_object_set_new(job->about, "levels", levels);
    json_object_set_new(job->about, "sequence", json_integer((json_int_t)s->count));
    json_object_set_new(job->about, "tf", iso_blender_describe_tf(s->view, s->level, 1, job->space.units));
    json_object_set_new(job->about, "extinction_scale", json_false());
    iso_blender_scale_directions(job->about, job->opt, iso_vdb_direction_scale(p->options.code));
    json_object_set_new(job->about, "film_transparent", json_false());
    json_object_set_new(job->about, "source", iso_blender_text(iso_provenance_name(p->source), 1000));
    json_object_set_new(job->about, "unit", json_string(p->unit.name));
}

static iso_status write_grid(sequence_job *job, const iso_pyramid *p, iso_output *out, iso_error *err)
{
    iso_pyramid scaled = {0};
    iso_vdb_options options = iso_vdb_defaults();
    options.pad_voxels = 1;
    iso_vdb_shown shown;
    iso_blender_grid_options(job->opt, &job->sequence->view->tf, job->sequence->view->tf_2d, &shown, &options);
    iso_blender_note_space(&job->space, &options);
    iso_status status = iso_blender_pyramid_in_space(p, &job->space, &scaled, err);
    TRY(status, iso_vdb_save(&scaled, job->sequence->level, 1, out->temp_path, &options, NULL, err));
    free(scaled.levels);
    return status;
}

static iso_status write_frame(sequence_job *job, size_t frame, iso_error *err)
{
    const iso_blender_sequence *s = job->sequence;
    iso_pyramid p = {0};
    char *path = grid_path(job->blend_path, frame);
    iso_status status = path ? s->load(s->user, frame, &p, err) : iso_fail(err, ISO_E_MEMORY, "blender: out of memory");
    TRY(status, iso_blender_check(&p, s->level, 1, job->opt, err));
    if (status == ISO_OK && p.levels[0].labels)
        status = iso_fail(
            err, ISO_E_USAGE,
            "blender: cannot play a series of label maps; use --frame K for one, or --no-labels to interpolate");
    if (status == ISO_OK && frame == 0) {
        job->space = iso_blender_space_of(&p.levels[0].geometry);
        describe(job, &p);
    }
    TRY(status, iso_output_begin(&job->outs[frame], path, err));
    TRY(status, write_grid(job, &p, &job->outs[frame], err));
    iso_pyramid_destroy(&p);
    free(path);
    return status;
}

static iso_status guard_frames(const sequence_job *job, iso_error *err)
{
    iso_status status = ISO_OK;
    for (size_t k = 0; k < job->sequence->count && status == ISO_OK; ++k) {
        char *path = grid_path(job->blend_path, k);
        status = path ? iso_blender_guard_grid(path, job->sequence->force, err)
                      : iso_fail(err, ISO_E_MEMORY, "blender: out of memory");
        free(path);
    }
    return status;
}

static iso_status write_blend(sequence_job *job, const char *folder, iso_error *err)
{
    json_t *about = job->about;
    job->about = NULL; /* taken */
    return iso_blender_save(about, job->blend_path, &job->outs[job->sequence->count], folder, job->opt, job->progress, err);
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
    job.outs = calloc(s->count + 1, sizeof *job.outs);
    if (!folder || !job.outs)
        status = iso_temp_dir_fail(err);
    for (size_t k = 0; k < s->count && status == ISO_OK; ++k)
        status = write_frame(&job, k, err);
    TRY(status, write_blend(&job, folder, err));
    TRY(status, iso_output_commit_all(job.outs, s->count + 1, err));
    for (size_t i = 0; job.outs && i <= s->count; ++i)
        iso_output_abandon(&job.outs[i]);
    json_decref(job.about);
    if (folder)
        iso_remove_tree(folder);
    free(job.outs);
    free(folder);
    return status;
}

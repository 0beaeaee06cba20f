/* SPDX-License-Identifier: MIT */
/* suite.c - a folder of scenes that say how their volumes are made: the scenes that break renderers. */
#define _GNU_SOURCE
#include <ctype.h>
#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/parallel.h"
#include "base/provenance.h"
#include "scene/subject.h"
#include "validate/validate.h"

static int is_scene(const struct dirent *entry)
{
    return entry->d_name[0] != '.' && iso_path_ends_with(entry->d_name, ".scene.json");
}

enum { most_levels = 16 }; /* of a scene, whose rows stand together */

/* Data shared by the scenes. */
typedef struct suite_run {
    const iso_suite_options *options;
    const char *scratch;
    struct dirent **entries;
    size_t count;
} suite_run;

static iso_status validate_scene(iso_validation *v, const iso_suite_options *opt, iso_scene *scene, const char *volume,
                                 iso_error *err)
{
    const iso_volume_input plain = {0};
    iso_pyramid_options build = iso_pyramid_defaults();
    iso_pyramid pyramid = {0};
    iso_view view = {0};
    char prefix[64], *file = NULL;
    snprintf(prefix, sizeof prefix, "%.48s-", v->scene_name);
    for (char *c = prefix; *c; ++c) /* a name of a file may have more characters than that of a picture */
        *c = isalnum((unsigned char)*c) || strchr("-_.", *c) ? *c : '-';
    build.level_count = opt->level_count;
    build.code = opt->code;
    build.threads = v->threads;
    if (opt->width)
        scene->width = opt->width, scene->height = opt->height;
    iso_status status = opt->make_volume(scene->suite_make, volume, err);
    TRY(status, iso_subject_load_pyramid(volume, &plain, &build, NULL, &pyramid, err));
    TRY(status, iso_scene_resolve(scene, &pyramid.levels[0].geometry, iso_pyramid_lo(&pyramid),
                                  iso_pyramid_hi(&pyramid), &view, err));
    if (status == ISO_OK && asprintf(&file, "%s.nrrd", v->scene_name) < 0)
        status = iso_fail(err, ISO_E_MEMORY, "out of memory");
    if (status == ISO_OK) {
        v->pyramid = &pyramid, v->scene = scene, v->view = &view;
        v->make = scene->suite_make, v->volume_path = file, v->image_prefix = prefix;
        iso_validate_assume(&pyramid.levels[0], &view, &scene->agreement);
        iso_validate_report_asked(v);
        status = iso_validate_agreement(v, err);
        if (status == ISO_OK && v->save_viewer)
            status = v->save_viewer(v, err);
    }
    v->pyramid = NULL, v->scene = NULL, v->view = NULL, v->make = v->volume_path = NULL, v->image_prefix = "";
    free(file);
    iso_view_destroy(&view);
    iso_pyramid_destroy(&pyramid);
    return status;
}

static iso_status load_and_validate(iso_validation *v, const suite_run *run, size_t i, iso_error *err)
{
    OWNED(iso_scene) scene = {0};
    const char *file = run->entries[i]->d_name;
    FREED char *name = iso_provenance_scene(file, i + 1), *path = iso_path_join(run->options->folder, file),
               *volume = NULL;
    double start = iso_clock_seconds();
    if (asprintf(&volume, "%s/volume-%zu.nrrd", run->scratch, i) < 0)
        volume = NULL;
    iso_status status = name && path && volume ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "out of memory");
    TRY(status, iso_scene_load(path, &scene, err));
    if (status == ISO_OK && !scene.suite_make)
        status = iso_fail(err, ISO_E_FORMAT, "%s: has no \"suite\", so nothing says what volume it is of", path);
    v->scene_name = name, v->scene_path = path;
    if (status == ISO_OK && (status = validate_scene(v, run->options, &scene, volume, err)) != ISO_OK)
        status = iso_fail_in(err, status, "%s", path);
    if (status == ISO_OK)
        iso_report_put(v->report, "seconds", name, json_real(iso_clock_seconds() - start));
    v->scene_name = v->scene_path = NULL;
    return status;
}

/* Validates a scene as one step: progress within a scene is not shown. */
static iso_status one_scene(iso_validation *mine, size_t i, void *user, iso_error *err)
{
    const suite_run *run = user;
    const iso_progress *progress = mine->progress;
    iso_progress_line *line = mine->line;
    const char *name = run->entries[i]->d_name;
    char stage[100];
    snprintf(stage, sizeof stage, "scene %.*s", (int)(strlen(name) - strlen(".scene.json")), name);
    iso_progress_report(progress, stage, 0);
    mine->progress = NULL;
    mine->line = NULL;
    mine->order = i * most_levels;
    iso_status status = load_and_validate(mine, run, i, err);
    mine->progress = progress;
    mine->line = line;
    iso_progress_line_add(line, 1 / (double)run->count);
    return status;
}

iso_status iso_validate_suite(iso_validation *v, const iso_suite_options *opt, iso_error *err)
{
    suite_run run = {.options = opt};
    int count = scandir(opt->folder, &run.entries, is_scene, alphasort);
    if (count < 0)
        return iso_fail(err, iso_errno_status(), "%s: cannot be listed: %s", opt->folder, strerror(errno));
    FREED char *scratch = iso_make_temp_dir();
    iso_status status = ISO_OK;
    run.scratch = scratch;
    if (count == 0)
        status = iso_fail(err, ISO_E_USAGE, "%s: holds no .scene.json", opt->folder);
    else if (!scratch)
        status = iso_temp_dir_fail(err);
    run.count = (size_t)count;
    iso_progress_report(v->progress, "scenes", 0);
    TRY(status, iso_validate_each(v, (size_t)count, one_scene, &run, err));
    for (int i = 0; i < count; ++i)
        free(run.entries[i]);
    free(run.entries);
    if (scratch)
        iso_remove_tree(scratch);
    return status;
}

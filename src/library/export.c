/* SPDX-License-Identifier: MIT */
/* export.c - export of the library's interface, by the table of targets. */
#include <stdlib.h>
#include <string.h>

#include "library/shared.h"
#include "targets/targets.h"

iso_export_options iso_export_defaults(void)
{
    return (iso_export_options){.level_count = 1};
}

/* Copies the job's view, which all levels share, with a table of its own. */
static iso_status view_of_level(const iso_export_job *job, size_t level, iso_view *view, iso_error *err)
{
    (void)level;
    const size_t bytes = 4 * job->view->tf.count * sizeof *job->view->tf.entries;
    *view = *job->view;
    view->tf.entries = malloc(bytes);
    if (!view->tf.entries) {
        *view = (iso_view){0};
        return iso_fail(err, ISO_E_MEMORY, "export: out of memory");
    }
    memcpy(view->tf.entries, job->view->tf.entries, bytes);
    return ISO_OK;
}

static iso_status check_levels(const iso_pyramid *p, const iso_export_options *o, iso_error *err)
{
    if (o->level_count < 1)
        return iso_fail(err, ISO_E_RANGE, "export of 0 levels, must be at least 1");
    iso_status status = iso_pyramid_check_level(p, NULL, o->level, err);
    if (status == ISO_OK && o->level_count > p->level_count - o->level)
        status = iso_fail(err, ISO_E_RANGE, "export of %zu levels from %zu on: the pyramid has levels 0 to %zu",
                          o->level_count, o->level, p->level_count - 1);
    return status;
}

/* Refuses an option that the target would ignore: its user would rely on it. */
static iso_status check_options(const iso_export_target *t, const iso_scene *scene, const iso_export_options *o,
                                iso_error *err)
{
    if (iso_export_takes(t, ISO_EXPORT_SCENE) && !scene)
        return iso_fail(err, ISO_E_USAGE, "export to %s needs a scene", t->name);
    if (o->level_count > 1 && !iso_export_takes(t, ISO_EXPORT_LEVELS))
        return iso_fail(err, ISO_E_USAGE, "export to %s takes one level, not %zu", t->name, o->level_count);
    if (o->half_float && !iso_export_takes(t, ISO_EXPORT_HALF))
        return iso_fail(err, ISO_E_USAGE, "export to %s has no half floats", t->name);
    return ISO_OK;
}

iso_status iso_export(const iso_pyramid *pyramid, const iso_scene *scene, const char *target, const char *path,
                      const iso_export_options *options, iso_error *err)
{
    const iso_export_options given = options ? *options : iso_export_defaults();
    const iso_progress progress = iso_progress_of(given.progress, given.progress_user);
    iso_view view = {0};
    size_t row = 0;
    iso_status status = iso_names_find(&iso_export_target_names, target, &row, err);
    if (status != ISO_OK)
        return status;
    const iso_export_target *t = iso_export_target_at(row);
    const iso_export_job job = {.pyramid = pyramid,
                                .level = given.level,
                                .level_count = given.level_count,
                                .output = path,
                                .view = &view,
                                .half_float = given.half_float,
                                .threads = given.threads,
                                .progress = &progress,
                                .view_of_level = view_of_level};
    status = check_options(t, scene, &given, err);
    TRY(status, check_levels(pyramid, &given, err));
    if (status == ISO_OK && iso_export_takes(t, ISO_EXPORT_SCENE))
        status = iso_scene_view(scene, pyramid, given.tf, given.width, given.height, &view, err);
    TRY(status, t->write(&job, err));
    iso_view_destroy(&view);
    return status;
}

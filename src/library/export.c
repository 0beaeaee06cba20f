/* SPDX-License-Identifier: MIT */
/* export.c - export of the library's interface, by the table of targets. */
#include "library/shared.h"
#include "targets/targets.h"

iso_export_options iso_export_defaults(void)
{
    return (iso_export_options){.level_count = 1};
}

/* Scene and options, for the views of levels. */
typedef struct look {
    const iso_scene *scene;
    const iso_export_options *given;
} look;

static iso_status view_of_level(const iso_export_job *job, size_t level, iso_view *view, iso_error *err)
{
    const look *l = job->user;
    const iso_export_options *o = l->given;
    const iso_library_look shown = {l->scene, o->tf, o->width, o->height, o->adapt};
    return iso_library_view(&shown, job->pyramid, level, view, err);
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
    if (o->adapt && !(iso_export_takes(t, ISO_EXPORT_SCENE) && iso_export_takes(t, ISO_EXPORT_ADAPT)))
        return iso_fail(err, ISO_E_USAGE, "export to %s adapts no transfer function", t->name);
    return ISO_OK;
}

iso_status iso_export(const iso_pyramid *pyramid, const iso_scene *scene, const char *target, const char *path,
                      const iso_export_options *options, iso_error *err)
{
    const iso_export_options given = options ? *options : iso_export_defaults();
    const look l = {scene, &given};
    iso_call call;
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
                                .progress = &call.progress,
                                .user = &l,
                                .view_of_level = view_of_level};
    iso_call_begin(&call, given.progress, given.progress_user);
    status = check_options(t, scene, &given, err);
    TRY(status, check_levels(pyramid, &given, err));
    if (status == ISO_OK && iso_export_takes(t, ISO_EXPORT_SCENE))
        status = iso_scene_view(scene, pyramid, given.tf, given.width, given.height, &view, err);
    TRY(status, t->write(&job, err));
    iso_view_destroy(&view);
    return iso_call_end(&call, status, err);
}

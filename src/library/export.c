/* SPDX-License-Identifier: MIT */
/* export.c - export of the library's interface, by the table of targets. */
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/temporary.h"
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
    /* Levels as fine as the region do not need it, except the last, which it is checked for. */
    const bool has_region = o->region && (level > o->region->level || level + 1 == o->level + o->level_count);
    const iso_library_look shown = {
        l->scene, o->tf, o->width, o->height, o->adapt, o->extinction_scale, has_region ? o->region : NULL, o->threads};
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
    const bool takes_scene = iso_export_takes(t, ISO_EXPORT_SCENE);
    const struct {
        bool given, taken;
        const char *what;
    } rules[] = {{o->half_float, iso_export_takes(t, ISO_EXPORT_HALF), "has no half floats"},
                 {o->adapt, takes_scene && iso_export_takes(t, ISO_EXPORT_ADAPT), "adapts no transfer function"},
                 {o->region, iso_export_takes(t, ISO_EXPORT_ROI), "has no region of interest"},
                 {o->extinction_scale, iso_export_takes(t, ISO_EXPORT_EXTINCTION_SCALE), "has no extinction scale"},
                 {o->plan, iso_export_takes(t, ISO_EXPORT_PLAN), "takes no plan"},
                 {o->tf || o->width > 0 || o->height > 0, takes_scene || o->extinction_scale || o->plan,
                  "has no scene, and takes no tf, width or height"}};
    if (takes_scene && !scene)
        return iso_fail(err, ISO_E_USAGE, "export to %s needs a scene", t->name);
    if (o->level_count > 1 && !iso_export_takes(t, ISO_EXPORT_LEVELS))
        return iso_fail(err, ISO_E_USAGE, "export to %s takes one level, not %zu", t->name, o->level_count);
    for (size_t i = 0; i < sizeof rules / sizeof *rules; ++i)
        if (rules[i].given && !rules[i].taken)
            return iso_fail(err, ISO_E_USAGE, "export to %s %s", t->name, rules[i].what);
    if ((o->extinction_scale || o->plan) && !scene)
        return iso_fail(err, ISO_E_USAGE, "%s is made for a scene, and there is none",
                        o->plan ? "a plan" : "an extinction scale");
    if (o->plan && (o->level > 0 || o->level_count > 1 || o->adapt || o->extinction_scale || o->region))
        return iso_fail(err, ISO_E_USAGE,
                        "a plan fixes the levels: it excludes level, level_count, adapt, "
                        "extinction_scale and region");
    return ISO_OK;
}

/* Reduces the volume by the plan of the options, if there is one. */
static iso_status make_planned(const iso_export_options *o, const iso_pyramid *p, const iso_view *view,
                               iso_planned *planned, iso_error *err)
{
    json_auto_t *root = NULL;
    iso_plan_file plan = {0};
    if (!o->plan)
        return ISO_OK;
    NEED(iso_json_of_text(o->plan, "the plan", &root, err));
    NEED(iso_plan_file_from_json(root, "the plan", &plan, err));
    return iso_planned_create_of(&plan, "the plan",
                                 &(iso_planned_subject){&p->levels[0], p->options.code, &view->tf, 1}, o->threads,
                                 planned, err);
}

iso_status iso_export(const iso_pyramid *pyramid, const iso_scene *scene, const char *target, const char *path,
                      const iso_export_options *options, iso_error *err)
{
    const iso_export_options given = options ? *options : iso_export_defaults();
    const look l = {scene, &given};
    iso_call call;
    iso_view view = {0};
    iso_planned planned = {0};
    size_t row = 0;
    NEED(iso_names_find(&iso_export_target_names, target, &row, err));
    const iso_export_target *t = iso_export_target_at(row);
    const iso_export_job job = {.pyramid = pyramid,
                                .level = given.level,
                                .level_count = given.level_count,
                                .output = path,
                                .view = &view,
                                .planned = given.plan ? &planned : NULL,
                                .merged = true,
                                .half_float = given.half_float,
                                .is_shown = given.extinction_scale && iso_export_takes(t, ISO_EXPORT_SHOWN),
                                .threads = given.threads,
                                .progress = &call.progress,
                                .user = &l,
                                .view_of_level = view_of_level};
    iso_call_begin(&call, given.progress, given.progress_user);
    iso_status status = check_options(t, scene, &given, err);
    TRY(status, check_levels(pyramid, &given, err));
    if (status == ISO_OK && (iso_export_takes(t, ISO_EXPORT_SCENE) || given.extinction_scale || given.plan))
        status = iso_scene_view(scene, pyramid, given.tf, given.width, given.height, &view, err);
    TRY(status, make_planned(&given, pyramid, &view, &planned, err));
    TRY(status, t->write(&job, err));
    iso_planned_destroy(&planned);
    iso_view_destroy(&view);
    return iso_call_end(&call, status, err);
}

iso_status iso_export_bytes(const iso_pyramid *pyramid, const iso_scene *scene, const char *target,
                            const iso_export_options *options, unsigned char **bytes, size_t *size, iso_error *err)
{
    *bytes = NULL;
    *size = 0;
    if (strcmp(target, "vdb") != 0 && strcmp(target, "nanovdb") != 0)
        return iso_fail(err, ISO_E_USAGE, "target is \"%s\", must be vdb or nanovdb, which are one file", target);
    ENDED_BY(iso_end_temp_dir) char *dir = iso_make_temp_dir();
    if (!dir)
        return iso_temp_dir_fail(err);
    FREED char *path = iso_path_join(dir, target[0] == 'v' ? "grids.vdb" : "grids.nvdb");
    char *data = NULL;
    NEED(path ? iso_export(pyramid, scene, target, path, options, err) : iso_fail(err, ISO_E_MEMORY, "out of memory"));
    NEED(iso_file_read(path, &data, size, err));
    *bytes = (unsigned char *)data;
    return ISO_OK;
}

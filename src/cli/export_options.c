/* SPDX-License-Identifier: MIT */
#include "cli/export_options.h"

#include <string.h>

#include "bake/grids.h"
#include "base/file.h"
#include "base/stamp.h"
#include "blender/blender.h"

bool iso_export_wants_merged(const iso_export_arguments *a)
{
    return !a->grids || strcmp(a->grids, "merged") == 0;
}

/* Checks options with --plan, which fixes the levels and the transfer function. */
static iso_status check_plan(const iso_export_arguments *a, iso_error *err)
{
    if (!a->plan)
        return a->grids ? iso_fail(err, ISO_E_USAGE, "--grids needs --plan") : ISO_OK;
    if (!a->look.scene)
        return iso_fail(err, ISO_E_USAGE, "--plan needs its --scene");
    if (a->level != 0 || a->level_count != 1 || a->adapted.wanted || a->adapted.extinction_scale || a->isosurface ||
        a->roi.box)
        return iso_fail(
            err, ISO_E_USAGE,
            "--plan fixes the levels: it excludes --level, --levels, --adapt, --extinction-scale, --roi and --isosurface");
    return ISO_OK;
}

bool iso_export_is_shown(const iso_export_arguments *a, const iso_export_target *target)
{
    return iso_export_takes(target, ISO_EXPORT_SHOWN) && !a->plan &&
           (a->look.scene || a->look.tf || a->adapted.extinction_scale);
}

/* Refuses options that have no effect for the target. */
static iso_status check_options(const iso_export_arguments *a, const iso_export_target *target, iso_error *err)
{
    const bool alone = !iso_export_takes(target, ISO_EXPORT_SCENE) &&
                       (iso_export_is_shown(a, target) || a->bake.wanted);
    const bool given[ISO_EXPORT_OPTION_COUNT] = {[ISO_EXPORT_LEVELS] = a->level_count > 1,
                                                 [ISO_EXPORT_STEP] = a->step != ISO_STEP_OF_SCENE,
                                                 [ISO_EXPORT_HALF] = a->half,
                                                 [ISO_EXPORT_ISOSURFACE] = a->isosurface != NULL,
                                                 [ISO_EXPORT_SCENE] = a->look.scene && !a->plan &&
                                                                      !alone, /* with a plan the scene has an effect */
                                                 [ISO_EXPORT_SIZE] = a->look.size != NULL && !alone,
                                                 [ISO_EXPORT_ROI] = a->roi.box != NULL,
                                                 [ISO_EXPORT_ADAPT] = a->adapted.wanted && !alone,
                                                 [ISO_EXPORT_EXTINCTION_SCALE] = a->adapted.extinction_scale,
                                                 [ISO_EXPORT_GRIDS] = a->grids != NULL,
                                                 [ISO_EXPORT_BAKE] = a->bake.wanted,
                                                 [ISO_EXPORT_MATERIAL] = a->material != NULL,
                                                 [ISO_EXPORT_PLAN] = a->plan != NULL,
                                                 [ISO_EXPORT_DENSE] = a->dense,
                                                 [ISO_EXPORT_BACKGROUND] = a->has_background};
    const char *const looks[] = {a->look.tf && !alone ? "--tf" : NULL, a->look.view ? "--view" : NULL,
                                 a->look.zoom ? "--zoom" : NULL};
    if (a->dense && (a->has_background || a->plan))
        return iso_fail(err, ISO_E_USAGE, "--dense and %s exclude each other", a->plan ? "--plan" : "--background");
    if (a->has_background && a->plan)
        return iso_fail(err, ISO_E_USAGE, "--background and --plan exclude each other: the plan sets the background");
    if (a->look.tf && a->plan && iso_export_takes(target, ISO_EXPORT_SHOWN))
        return iso_fail(err, ISO_E_USAGE,
                        "--tf and --plan exclude each other: the plan is for the scene's transfer function");
    for (size_t i = 0; i < sizeof looks / sizeof *looks; ++i)
        if (looks[i] && !iso_export_takes(target, ISO_EXPORT_SCENE) && !a->bake.wanted)
            return iso_fail(err, ISO_E_USAGE, "%s cannot be used with --to %s", looks[i], target->name);
    for (int i = 0; i < ISO_EXPORT_OPTION_COUNT; ++i)
        if (given[i] && !iso_export_takes(target, (iso_export_option)i))
            return iso_fail(err, ISO_E_USAGE, "%s cannot be used with --to %s",
                            iso_export_option_text((iso_export_option)i), target->name);
    return ISO_OK;
}

/* Checks options for baked grids: one whole level, with the scene's transfer function. */
static iso_status check_bake(const iso_export_arguments *a, iso_error *err)
{
    const char *other = a->plan              ? "--plan"
                        : a->level_count > 1 ? "--levels"
                        : a->roi.box         ? "--roi"
                        : a->frames          ? "--frames"
                                             : NULL;
    if (a->bake.wanted && other)
        return iso_fail(err, ISO_E_USAGE, "%s cannot be used with baked grids, which hold one whole level", other);
    return ISO_OK;
}

/* Checks --frames: all frames share one scene and one transfer function, so options for a single volume are refused. */
static iso_status check_frames(const iso_export_arguments *a, iso_error *err)
{
    const char *other = a->plan                       ? "--plan"
                        : a->adapted.wanted           ? "--adapt"
                        : a->adapted.extinction_scale ? "--extinction-scale"
                        : a->roi.box                  ? "--roi"
                                                      : NULL;
    if (!a->frames)
        return ISO_OK;
    if (strcmp(a->frames, "all") != 0)
        return iso_fail(err, ISO_E_USAGE, "--frames is \"%s\", must be all; export one with --frame K", a->frames);
    if (other)
        return iso_fail(err, ISO_E_USAGE, "--frames all excludes %s: a series has one scene and one transfer function",
                        other);
    return ISO_OK;
}

/* Guards the files next to the output. Files of frames and of several volumes have names that are known only later. The
 * target knows whether it writes a .usda. */
static iso_status guard_other_files(const iso_export_arguments *a, const iso_export_target *target, iso_error *err)
{
    if (a->bake.wanted && a->bake.usd && iso_path_ends_with(a->output, ".vdb"))
        return iso_bake_guard_usda(a->output, a->force, err);
    if (!target->guard || a->frames || a->channels || a->cli->argument_count > 1)
        return ISO_OK;
    return target->guard(a->output, (size_t)a->level, (size_t)a->level_count, a->roi.box != NULL, a->force, err);
}

/* Refuses an output whose ending belongs to another target. */
static iso_status check_ending(const iso_export_target *target, const char *output, iso_error *err)
{
    const char *own = strchr(target->output, '.');
    if (own && !iso_path_ends_with(output, own))
        return iso_fail(err, ISO_E_USAGE, "%s: the name for --to %s must end in %s", output, target->name, own);
    for (size_t row = 0; !own && row < iso_export_target_names.count; ++row) {
        const iso_export_target *other = iso_export_target_at(row);
        const char *ending = strchr(other->output, '.');
        if (ending && iso_path_ends_with(output, ending))
            return iso_fail(err, ISO_E_USAGE, "%s: ends in %s as for --to %s, but --to %s writes a folder", output,
                            ending, other->name, target->name);
    }
    return ISO_OK;
}

iso_status iso_export_check(iso_export_arguments *a, const iso_export_target **target, iso_error *err)
{
    char names[256];
    size_t row = 0;
    if (!a->to)
        return iso_fail(err, ISO_E_USAGE, "--to is missing: %s",
                        iso_names_join(&iso_export_target_names, "or", names, sizeof names));
    iso_status status = iso_names_find(&iso_export_target_names, a->to, &row, err);
    if (status != ISO_OK)
        return iso_fail_in(err, status, "--to");
    *target = iso_export_target_at(row);
    if (!a->output)
        return iso_fail(err, ISO_E_USAGE, "-o is missing: %s", (*target)->summary);
    TRY(status, check_ending(*target, a->output, err));
    TRY(status, check_options(a, *target, err));
    if (status == ISO_OK && a->material)
        status = iso_names_find(&iso_blender_material_names, a->material, &a->material_row, err);
    TRY(status, check_bake(a, err));
    TRY(status, check_frames(a, err));
    TRY(status, check_plan(a, err));
    if (status == ISO_OK && (*target)->stamped)
        status = iso_stamp_guard(a->output, a->force, err);
    return status == ISO_OK ? guard_other_files(a, *target, err) : status;
}

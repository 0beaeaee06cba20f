/* SPDX-License-Identifier: MIT */
/* cmd_export.c - exports levels to other programs, by the table of exporters/targets. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bake/grids.h"
#include "base/file.h"
#include "base/stamp.h"
#include "blender/blender.h"
#include "cli/export.h"
#include "options/visible.h"
#include "scene/subject_frames.h"
#include "scene/subject.h"
#include "scene/viewpoint.h"
#include "tf/presets.h"
#include "volume/frames_all.h"

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

/* True if a transfer function is given that decides which voxels the grids hold; grids themselves need none. */
static bool is_shown(const iso_export_arguments *a, const iso_export_target *target)
{
    return iso_export_takes(target, ISO_EXPORT_SHOWN) && !a->plan &&
           (a->look.scene || a->look.tf || a->adapted.extinction_scale);
}

/* Refuses options that have no effect for the target. */
static iso_status check_options(const iso_export_arguments *a, const iso_export_target *target, iso_error *err)
{
    const bool alone = !iso_export_takes(target, ISO_EXPORT_SCENE) && (is_shown(a, target) || a->bake.wanted);
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

/* Finds the target, and checks the options before the work. ISO_E_USAGE, ISO_E_RANGE: options that exclude each other
 * or have no effect; ISO_E_IO: a file was changed by hand. */
static iso_status check(iso_export_arguments *a, const iso_export_target **target, iso_error *err)
{
    char names[256];
    size_t row = 0;
    if (!a->to)
        return iso_fail(err, ISO_E_USAGE, "--to is missing: %s",
                        iso_names_join(&iso_export_target_names, "or", names, sizeof names));
    const iso_status status = iso_names_find(&iso_export_target_names, a->to, &row, err);
    if (status != ISO_OK)
        return iso_fail_in(err, status, "--to");
    *target = iso_export_target_at(row);
    if (!a->output)
        return iso_fail(err, ISO_E_USAGE, "-o is missing: %s", (*target)->summary);
    NEED(check_ending(*target, a->output, err));
    NEED(check_options(a, *target, err));
    if (a->material)
        NEED(iso_names_find(&iso_blender_material_names, a->material, &a->material_row, err));
    NEED(check_bake(a, err));
    NEED(check_frames(a, err));
    NEED(check_plan(a, err));
    if ((*target)->stamped)
        NEED(iso_stamp_guard(a->output, a->force, err));
    return guard_other_files(a, *target, err);
}

/* Makes the view of a level: the scene's with its own copy of the table, adapted and with a region of interest if
 * requested. */
static iso_status view_of_level(const iso_export_job *job, size_t k, iso_view *view, iso_error *err)
{
    const iso_export_arguments *a = job->user;
    *view = *job->view;
    size_t bytes = 4 * view->tf.count * sizeof *view->tf.entries;
    view->tf.entries = malloc(bytes);
    if (!view->tf.entries) {
        *view = (iso_view){0};
        return iso_fail(err, ISO_E_MEMORY, "export: out of memory");
    }
    memcpy(view->tf.entries, job->view->tf.entries, bytes);
    /* Levels as fine as the region of interest do not need it. */
    iso_status status = a->roi.box && a->roi.level >= 0 && k <= (size_t)a->roi.level &&
                                k < (size_t)(a->level + a->level_count - 1)
                            ? ISO_OK
                            : iso_cli_roi_view(&a->roi,
                                               &(iso_cli_roi_place){&a->adapted, a->cli->arguments[0], job->pyramid, k,
                                                                    a->cli->threads},
                                               view, err);
    TRY(status, iso_cli_adapt_view(&a->adapted, a->cli->arguments[0], job->pyramid, k, view, a->cli->threads, err));
    if (status != ISO_OK)
        iso_view_destroy(view);
    return status;
}

/* True if the target reads a level's scalars a few planes at a time, and no option or plan needs all of them. */
static bool is_narrow(const iso_export_arguments *a, const iso_export_target *target)
{
    return target->narrow && !a->roi.box && !a->adapted.wanted && !a->adapted.extinction_scale && !a->isosurface &&
           !a->bake.wanted;
}

static iso_status load(iso_export_arguments *a, const iso_export_target *target, const iso_subject_look *look,
                       const double *iso, const iso_progress *progress, iso_pyramid *p, iso_volume *v, iso_view *view,
                       iso_error *err)
{
    const char *path = a->cli->arguments[0];
    const bool wants_view = iso_export_takes(target, ISO_EXPORT_SCENE) || a->plan || is_shown(a, target) ||
                            a->bake.wanted;
    const bool narrow = is_narrow(a, target);
    iso_pyramid_options build = iso_pyramid_defaults();
    iso_subject_sight sight = {0};
    build.threads = a->cli->threads;
    build.level_count = (size_t)(a->level + a->level_count);
    const iso_status status = narrow ? iso_subject_load_narrow(path, &a->input, &build, wants_view ? look : NULL,
                                                               progress, p, v, &sight, err)
                                     : iso_subject_load_pyramid(path, &a->input, &build, progress, p, err);
    *view = sight.view;
    NEED(status);
    NEED(iso_pyramid_check_level(p, path, build.level_count - 1, err));
    if (a->plan || a->roi.box || a->isosurface)
        NEED(iso_subject_refuse_labels(p, path, a->plan ? "--plan" : a->roi.box ? "--roi" : "--isosurface", err));
    if (!narrow && wants_view)
        NEED(iso_subject_make_view(look, p, view, err));
    if (view->width > 0 && narrow) /* a scene is given */
        iso_cli_warn_visible(a->cli, &sight.visible);
    else if (view->width > 0)
        iso_cli_warn_view(a->cli, p, view, a->isosurface ? iso : NULL, &(bool){false});
    return ISO_OK;
}

/* Checks the command line before reading. iso: value of the surface; unchanged without one. */
static iso_status check_arguments(iso_export_arguments *a, const iso_export_target **target, iso_subject_look *look,
                                  double iso[3], iso_error *err)
{
    NEED(check(a, target, err));
    NEED(iso_cli_look_check(&a->look, a->cli->threads, look, err));
    return a->isosurface ? iso_words_parse_numbers(a->isosurface, "--isosurface", iso, err) : ISO_OK;
}

/* Makes the parts of a job that one volume and a series share. root: for --json, or NULL. */
static iso_export_job job_of(iso_export_arguments *a, const iso_export_target *target, iso_view *view, double iso,
                             const iso_progress *progress, const char *command, json_t *root)
{
    return (iso_export_job){.level = (size_t)a->level,
                            .level_count = (size_t)a->level_count,
                            .output = a->output,
                            .view = view,
                            .step_voxels = a->step == ISO_STEP_OF_SCENE ? 0 : a->step,
                            .half_float = a->half,
                            .physical = a->material_row == 1,
                            .dense = a->dense,
                            .force = a->force,
                            .is_shown = is_shown(a, target),
                            .background = a->has_background ? &a->background : NULL,
                            .command = command,
                            .isosurface = a->isosurface != NULL,
                            .iso = iso,
                            .threads = a->cli->threads,
                            .progress = progress,
                            .view_of_level = view_of_level,
                            .user = a,
                            .results = root,
                            .notes = root ? NULL : stdout};
}

/* Loads a plan, whose nodes are made from level 0, or from the volume's samples if level 0 has no scalars. */
static iso_status load_plan(const iso_export_arguments *a, const iso_pyramid *p, const iso_volume *v,
                            const iso_view *view, iso_planned *planned, iso_error *err)
{
    iso_level level0 = p->levels[0];
    if (!level0.scalar)
        level0.samples = v;
    return iso_planned_create(a->plan, &(iso_planned_subject){&level0, p->options.code, &view->tf, 1}, a->cli->threads,
                              planned, err);
}

static iso_status export_it(iso_export_arguments *a, iso_error *err)
{
    const iso_export_target *target = NULL;
    double iso[3] = {0};
    iso_progress progress = iso_cli_progress(a->cli);
    OWNED(iso_pyramid) pyramid = {0};
    OWNED(iso_volume) volume = {0};
    OWNED(iso_view) view = {0};
    OWNED(iso_planned) planned = {0};
    iso_subject_look look;
    NEED(check_arguments(a, &target, &look, iso, err));
    iso_cli_expect_names(a->cli, !iso_pyramid_is_one(a->cli->arguments[0]), target->stages, target->name);
    NEED(load(a, target, &look, iso, &progress, &pyramid, &volume, &view, err));
    if (a->plan)
        NEED(load_plan(a, &pyramid, &volume, &view, &planned, err));
    json_auto_t *root = a->cli->json ? iso_cli_json(a->cli) : NULL;
    FREED char *command = iso_cli_command_line(a->cli);
    iso_export_job job = job_of(a, target, &view, iso[0], &progress, command, root);
    job.pyramid = &pyramid;
    job.volume = volume.data ? &volume : NULL;
    job.planned = a->plan ? &planned : NULL;
    job.merged = !a->grids || strcmp(a->grids, "merged") == 0;
    job.bake = a->bake.wanted ? &a->bake : NULL;
    job.lattice = a->bake.lattice;
    NEED(target->write(&job, err));
    if (root) {
        json_object_update_new(root, json_pack("{s:s, s:s, s:i, s:i}", "to", a->to, "output", a->output, "level",
                                               a->level, "levels", a->level_count));
        iso_cli_print_json(json_incref(root));
    } else {
        printf("%s: %s\n", a->output, a->bake.wanted ? target->baked : target->summary);
    }
    return ISO_OK;
}

/* ---- series ---- */

static iso_status load_frame(void *user, size_t frame, iso_pyramid *p, iso_error *err)
{
    return iso_subject_frames_load(user, frame, p, err);
}

static iso_status check_level(const iso_export_arguments *a, const iso_pyramid *p, iso_error *err)
{
    return iso_pyramid_check_level(p, a->cli->arguments[0], (size_t)(a->level + a->level_count - 1), err);
}

/* Makes the view of a series, from the scene and the first frame. */
static iso_status make_series_view(const iso_export_arguments *a, const iso_subject_frames *frames, const double iso[3],
                                   iso_view *view, iso_error *err)
{
    OWNED(iso_pyramid) first = {0};
    NEED(iso_subject_frames_load(frames, frames->widest, &first, err));
    NEED(check_level(a, &first, err));
    if (frames->has_scene)
        NEED(iso_subject_frames_view(frames, &first, view, err));
    if (frames->has_scene)
        iso_cli_warn_view(a->cli, &first, view, a->isosurface ? iso : NULL, &(bool){false});
    return ISO_OK;
}

/* Writes one numbered output per frame. */
static iso_status write_each(const iso_export_arguments *a, const iso_export_target *target,
                             const iso_subject_frames *frames, const iso_export_job *of_all, iso_error *err)
{
    for (size_t k = 0; k < frames->count; ++k) {
        OWNED(iso_pyramid) p = {0};
        iso_export_job job = *of_all;
        FREED char *name = iso_frames_name(a->output, target->suffix, k);
        NEED(name ? iso_subject_frames_load(frames, k, &p, err) : iso_fail(err, ISO_E_MEMORY, "out of memory"));
        job.pyramid = &p;
        job.output = name;
        NEED(target->write(&job, err));
    }
    return ISO_OK;
}

static iso_status export_series(iso_export_arguments *a, iso_error *err)
{
    const iso_export_target *target = NULL;
    double iso[3] = {0};
    const iso_progress progress = iso_cli_progress(a->cli);
    iso_pyramid_options build = iso_pyramid_defaults();
    OWNED(iso_subject_frames) frames = {0};
    OWNED(iso_view) view = {0};
    iso_subject_look look;
    NEED(check_arguments(a, &target, &look, iso, err));
    build.threads = a->cli->threads;
    build.level_count = (size_t)(a->level + a->level_count);
    const bool has_look = iso_export_takes(target, ISO_EXPORT_SCENE) || is_shown(a, target);
    NEED(iso_subject_frames_create(a->cli->arguments[0], &a->input, &build, has_look ? &look : NULL, &progress, &frames,
                                   err));
    NEED(make_series_view(a, &frames, iso, &view, err));
    json_auto_t *root = a->cli->json ? iso_cli_json(a->cli) : NULL;
    FREED char *command = iso_cli_command_line(a->cli);
    iso_export_job job = job_of(a, target, &view, iso[0], &progress, command, root);
    job.frame_count = frames.count;
    job.load_frame = load_frame;
    job.frame_user = &frames;
    NEED(target->write_frames ? target->write_frames(&job, err) : write_each(a, target, &frames, &job, err));
    const double *range = frames.build.value_range;
    if (root) {
        json_object_update_new(root, json_pack("{s:s, s:s, s:i, s:i, s:I, s:o}", "to", a->to, "output", a->output,
                                               "level", a->level, "levels", a->level_count, "frames",
                                               (json_int_t)frames.count, "value_range", iso_json_numbers(range, 2)));
        iso_cli_print_json(json_incref(root));
    } else {
        printf("%s: %zu frame%s, values %.9g to %.9g: %s\n", a->output, frames.count, iso_words_plural(frames.count),
               range[0], range[1], target->summary);
    }
    return ISO_OK;
}

/* ---- several volumes ---- */

static iso_status export_volumes(iso_export_arguments *a, iso_error *err)
{
    const iso_export_target *target = NULL;
    iso_subject_look look;
    const char *other = a->plan                       ? "--plan"
                        : a->frames                   ? "--frames"
                        : a->adapted.wanted           ? "--adapt"
                        : a->adapted.extinction_scale ? "--extinction-scale"
                        : a->roi.box                  ? "--roi"
                        : a->isosurface               ? "--isosurface"
                                                      : NULL;
    NEED(check(a, &target, err));
    if (other)
        return iso_fail(err, ISO_E_USAGE, "%s needs a single volume, without --add and --channels", other);
    if (a->channels && a->input.channel)
        return iso_fail(err, ISO_E_USAGE, "--channel and --channels exclude each other");
    NEED(iso_cli_look_check(&a->look, a->cli->threads, &look, err));
    iso_cli_expect_names(a->cli, true, target->stages, target->name);
    return iso_export_several_volumes(a, target, &look, err);
}

static iso_status make_bake_request(iso_export_arguments *a, iso_error *err)
{
    size_t row = 0;
    a->bake_words.lattice_alone = a->to && iso_names_find(&iso_export_target_names, a->to, &row, NULL) == ISO_OK &&
                                  iso_export_takes(iso_export_target_at(row), ISO_EXPORT_LATTICE);
    return iso_bake_request_make(&a->bake_words, a->half, &a->bake, err);
}

static const iso_option bake_options[] = {
    {"bake", 0, "vdb, nanovdb: grids of extinction and color, with the transfer function applied", "density,Cd,...",
     ISO_IN(iso_bake_words, grids)},
    {"for", 0, "vdb, nanovdb: target program; sets --bake, --scene-unit, --up, --half, --usd", "PROGRAM",
     ISO_IN(iso_bake_words, program)},
    {"scene-unit", 0, "vdb, nanovdb, baked: length of one scene unit (mm)", "m|cm|mm|...",
     ISO_IN(iso_bake_words, unit)},
    {"up", 0, "vdb, nanovdb, baked: vertical axis of the scene (z)", "z|y", ISO_IN(iso_bake_words, up)},
    {"points", 0, "vdb, nanovdb, baked; pbrt: grid points along a voxel's side (1)", "N",
     ISO_IN(iso_bake_words, points)},
    {"supersample", 0, "vdb, nanovdb, baked; pbrt: averaged samples along a point's cell (2)", "N",
     ISO_IN(iso_bake_words, samples)},
    {"usd", 0, "vdb, baked: also write a .usda with the grids", NULL, ISO_IN(iso_bake_words, usd)},
    ISO_OPTIONS_END,
};

static const iso_option options[] = {
    {"to", 0, "export target of the list below", "TARGET", ISO_IN(iso_export_arguments, to)},
    {"output", 'o', "NAME.vdb, NAME.nvdb, NAME.blend, or a folder for other targets", "PATH",
     ISO_IN(iso_export_arguments, output)},
    ISO_OPTIONS_OF(iso_export_arguments, look, iso_look_rows),
    {"level", 0, "level of the pyramid; 0 is the finest", "K", ISO_IN(iso_export_arguments, level), .flags = ISO_SHOWN,
     .most = 63},
    {"levels", 0, "vdb, nanovdb, blender: number of levels from K on in one file", "N",
     ISO_IN(iso_export_arguments, level_count), .flags = ISO_SHOWN, .least = 1, .most = 32},
    {"frames", 0, "export all frames of a series, with one range and transfer function", "all",
     ISO_IN(iso_export_arguments, frames)},
    {"add", 0, "blender: add a volume with its transfer function (suggested); repeatable", "VOLUME[,TF]",
     ISO_IN(iso_export_arguments, added)},
    {"channels", 0, "blender: export channels as volumes of one scene, in different colors", "all|LIST",
     ISO_IN(iso_export_arguments, channels)},
    {"step", 0, "blender, povray: ray step in voxels of the level (the scene's)", "STEP",
     ISO_IN(iso_export_arguments, step), .least = 1e-3, .most = 16},
    {"isosurface", 0, "povray: export the surface of this value instead of the volume", "VALUE",
     ISO_IN(iso_export_arguments, isosurface)},
    {"plan", 0, "export only the bricks of this plan, with its --scene", "PLAN.json",
     ISO_IN(iso_export_arguments, plan)},
    {"grids", 0, "vdb, nanovdb with --plan: merged (default) grid, or one per level: levels", "merged|levels",
     ISO_IN(iso_export_arguments, grids), .flags = ISO_ONE_OF},
    {"force", 0, "replace changed or foreign files, kept as NAME.blend1 and so on", NULL,
     ISO_IN(iso_export_arguments, force)},
    {"material", 0, "blender: material that the file opens with", "MATERIAL", ISO_IN(iso_export_arguments, material)},
    ISO_CLI_CYCLES_OPTIONS(iso_export_arguments, cycles, "blender: Blender program to use, a path or a name in PATH",
                           "PROGRAM"),
    {"half", 0, "vdb, blender: write half floats, smaller and less exact", NULL, ISO_IN(iso_export_arguments, half)},
    {"dense", 0, "vdb, nanovdb, blender: keep invisible voxels, to edit the transfer function later", NULL,
     ISO_IN(iso_export_arguments, dense)},
    {"background", 0, "vdb, nanovdb: value of omitted voxels; without a scene omits these", "VALUE",
     ISO_IN(iso_export_arguments, background_text)},
    ISO_OPTIONS_OF(iso_export_arguments, bake_words, bake_options),
    ISO_OPTIONS_OF(iso_export_arguments, adapted, iso_adapted_rows),
    ISO_OPTIONS_OF(iso_export_arguments, roi, iso_roi_rows),
    ISO_OPTIONS_OF(iso_export_arguments, input, iso_input_rows),
    ISO_OPTIONS_END,
};

static iso_status run(const iso_cli *cli, void *values, iso_error *err)
{
    iso_export_arguments *a = values;
    a->cli = cli;
    a->adapted.cli = cli;
    NEED(iso_cli_take_cycles(&a->cycles, NULL, err));
    if (a->background_text) {
        double numbers[3] = {0};
        NEED(iso_words_parse_numbers(a->background_text, "--background", numbers, err));
        a->background = numbers[0];
        a->has_background = true;
    }
    NEED(make_bake_request(a, err));
    a->bake.error_pixels = a->look.size ? 0 : a->bake.error_pixels;
    return a->added || a->channels ? export_volumes(a, err) : a->frames ? export_series(a, err) : export_it(a, err);
}

const iso_command iso_command_export = {
    .name = "export",
    .summary = "export a level to OpenVDB, NanoVDB, Blender, POV-Ray, pbrt or ParaView",
    .min_arguments = 1,
    .max_arguments = 1,
    .usage = "VOLUME|PYRAMID.iso --to TARGET -o PATH [options]",
    .details =
        "vdb: grids density (float) and gradient (vec3s, shading directions in world axes). blender: a scene that is ready to\n"
        "render; with a packed color map, grids next to it by relative paths, and a property that switches levels. Its material is\n"
        "exact, or physical (lit by lamps and world, with shadows), switched by a property (doc/guide/blender.md).\n"
        "vdb with --bake, or --for PROGRAM: extinction and color for other programs. The change of the picture is measured in\n"
        "the scene. (build --for SCENE is different: it makes levels for a scene.)\n"
        "nanovdb: the same grids as vdb, baked or not, in NanoVDB files.\n"
        "pbrt: a medium of baked grids that emits and absorbs, its colors shaded for the scene's camera and lights; run\n"
        "`pbrt scene.pbrt` in the folder.\n"
        "paraview: a .vti and a state that ParaView loads and `pvbatch NAME.py` renders (see\n"
        "doc/guide/other-programs.md).\n"
        "povray: run `povray NAME.ini` in the folder. Without --scene you get a first picture, as with\n"
        "render. Grids hold the visible voxels and those that filtering needs; for vdb this takes --scene\n"
        "or --tf. To edit the transfer function later, export with --dense. With --plan only the bricks that the scene\n"
        "needs are written: active voxels and a transparent background, a volume of one grid for blender, cropped DF3 files.\n"
        "Other programs filter directions themselves, without a flipped fetch (render --shading-from flipped).",
    .common =
        "to output scene tf view size level levels adapt frames add material step isosurface plan spacing threads",
    .examples =
        "  isoshade make shells --size 48 -o shells.nrrd\n"
        "  isoshade export shells.nrrd --to blender -o first.blend\n"
        "  isoshade export shells.nrrd --to vdb --levels 3 -o shells.vdb\n"
        "  isoshade export shells.nrrd --to blender --scene refscenes/shells.scene.json -o shells.blend\n"
        "  isoshade export shells.nrrd --to blender --scene refscenes/shells.scene.json --levels 3 --adapt -o levels.blend\n"
        "  isoshade export shells.nrrd --to blender --scene refscenes/shells.scene.json --material physical -o lit.blend\n"
        "  isoshade export shells.nrrd --to blender --scene refscenes/shells.scene.json --level 1 --adapt --roi 8,8,8,32,32,32 -o roi.blend\n"
        "  isoshade export shells.nrrd --to povray --scene refscenes/shells.scene.json --level 1 -o shells-pov\n"
        "  isoshade export shells.nrrd --to vdb --scene refscenes/shells.scene.json --level 1 --adapt --extinction-scale -o scaled.vdb\n"
        "  isoshade export shells.nrrd --to vdb --scene refscenes/shells.scene.json --bake density,Cd --scene-unit cm -o baked.vdb\n"
        "  isoshade export shells.nrrd --to vdb --scene refscenes/shells.scene.json --for karma -o karma.vdb\n"
        "  isoshade export shells.nrrd --to nanovdb -o shells.nvdb\n"
        "  isoshade export shells.nrrd --to pbrt --scene refscenes/shells.scene.json --level 1 -o shells-pbrt\n"
        "  isoshade export shells.nrrd --to paraview --scene refscenes/shells.scene.json -o shells-paraview\n"
        "  isoshade make shells --size 16 -o step_1.nrrd\n"
        "  isoshade make noise --size 16 -o step_2.nrrd\n"
        "  isoshade export step_%d.nrrd --frames all --to vdb -o steps.vdb\n"
        "  isoshade plan shells.nrrd --scene refscenes/shells.scene.json --size 96 --brick 8 --levels 3 -o shells.plan.json\n"
        "  isoshade export shells.nrrd --to vdb --plan shells.plan.json --scene refscenes/shells.scene.json -o planned.vdb\n",
    .lists = (const iso_names *const[]){&iso_export_target_names, &iso_blender_material_names, &iso_bake_grid_names,
                                        &iso_grid_program_names, &iso_tf_preset_names, &iso_viewpoint_names, NULL},
    ISO_COMMAND_OPTIONS(iso_export_arguments, options, .level_count = 1, .step = ISO_STEP_OF_SCENE,
                        .adapted = ISO_CLI_ADAPTED_DEFAULTS, .roi = ISO_CLI_ROI_DEFAULTS),
    .run = run,
};

/* SPDX-License-Identifier: MIT */
/* cmd_export.c - a level for other programs: OpenVDB, Blender, POV-Ray. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "options/cli.h"
#include "options/input.h"
#include "options/look.h"
#include "options/roi.h"
#include "options/visible.h"
#include "scene/subject.h"
#include "scene/viewpoint.h"
#include "tf/presets.h"
#include "targets/targets.h"

typedef struct export_arguments {
    iso_volume_input input;
    iso_cli_adapted adapted;
    iso_cli_roi roi;
    iso_cli_look look;
    char *to, *output, *isosurface, *plan, *grids;
    int level, level_count, half;
    double step;
    const iso_cli *cli;
} export_arguments;

static bool wants_merged(const export_arguments *a)
{
    return !a->grids || strcmp(a->grids, "merged") == 0;
}

/* The scene's view with a copy of its table, and in it what is asked for: full resolution in a box, an adapted table. */
static iso_status view_of_level(const iso_export_job *job, size_t k, iso_view *view, iso_error *err)
{
    const export_arguments *a = job->user;
    *view = *job->view;
    size_t bytes = 4 * view->tf.count * sizeof *view->tf.entries;
    view->tf.entries = malloc(bytes);
    if (!view->tf.entries) {
        *view = (iso_view){0};
        return iso_fail(err, ISO_E_MEMORY, "export: out of memory");
    }
    memcpy(view->tf.entries, job->view->tf.entries, bytes);
    /* levels that are no coarser than the region of interest need none */
    iso_status status = a->roi.box && a->roi.level >= 0 && k <= (size_t)a->roi.level &&
                                k < (size_t)(a->level + a->level_count - 1)
                            ? ISO_OK
                            : iso_cli_roi_view(&a->roi,
                                               &(iso_cli_roi_place){&a->adapted, a->cli->arguments[0], job->pyramid, k,
                                                                    a->cli->threads},
                                               view, err);
    if (status == ISO_OK)
        status = iso_cli_adapt_view(&a->adapted, a->cli->arguments[0], job->pyramid, k, view, a->cli->threads, err);
    if (status != ISO_OK)
        iso_view_destroy(view);
    return status;
}

/* With a plan the levels are the plan's, and so is the transfer function. */
static iso_status check_plan(const export_arguments *a, iso_error *err)
{
    if (!a->plan)
        return a->grids ? iso_fail(err, ISO_E_USAGE, "--grids needs --plan") : ISO_OK;
    if (!a->look.scene)
        return iso_fail(err, ISO_E_USAGE, "--plan needs the --scene that it was made for");
    if (!wants_merged(a) && strcmp(a->grids, "levels") != 0)
        return iso_fail(err, ISO_E_USAGE, "--grids is \"%s\", wanted merged or levels", a->grids);
    if (a->level != 0 || a->level_count != 1 || a->adapted.wanted || a->adapted.extinction_scale || a->isosurface ||
        a->roi.box)
        return iso_fail(
            err, ISO_E_USAGE,
            "--plan chooses the levels itself: --level, --levels, --adapt, --extinction-scale, --roi and --isosurface have no "
            "meaning");
    return ISO_OK;
}

/* An option that would change nothing is a mistake. */
static iso_status check_options(const export_arguments *a, const iso_export_target *target, iso_error *err)
{
    /* Grids alone have no transfer function, but for the one that an extinction scale is made for. */
    const bool alone = !iso_export_takes(target, ISO_EXPORT_SCENE) && a->adapted.extinction_scale;
    const bool given[ISO_EXPORT_OPTION_COUNT] = {[ISO_EXPORT_LEVELS] = a->level_count > 1,
                                                 [ISO_EXPORT_STEP] = a->step != 0,
                                                 [ISO_EXPORT_HALF] = a->half,
                                                 [ISO_EXPORT_ISOSURFACE] = a->isosurface != NULL,
                                                 [ISO_EXPORT_SCENE] = a->look.scene && !a->plan &&
                                                                      !alone, /* a plan is made for one */
                                                 [ISO_EXPORT_SIZE] = a->look.size != NULL,
                                                 [ISO_EXPORT_ROI] = a->roi.box != NULL,
                                                 [ISO_EXPORT_ADAPT] = a->adapted.wanted && !alone,
                                                 [ISO_EXPORT_EXTINCTION_SCALE] = a->adapted.extinction_scale,
                                                 [ISO_EXPORT_GRIDS] = a->grids != NULL};
    const char *const looks[] = {a->look.tf ? "--tf" : NULL, a->look.view ? "--view" : NULL,
                                 a->look.zoom != 0 ? "--zoom" : NULL};
    for (size_t i = 0; i < sizeof looks / sizeof *looks; ++i)
        if (looks[i] && !iso_export_takes(target, ISO_EXPORT_SCENE) && !alone)
            return iso_fail(err, ISO_E_USAGE, "%s has no meaning for --to %s", looks[i], target->name);
    for (int i = 0; i < ISO_EXPORT_OPTION_COUNT; ++i)
        if (given[i] && !iso_export_takes(target, (iso_export_option)i))
            return iso_fail(err, ISO_E_USAGE, "%s has no meaning for --to %s",
                            iso_export_option_text((iso_export_option)i), target->name);
    return ISO_OK;
}

static iso_status check(const export_arguments *a, const iso_export_target **target, iso_error *err)
{
    char names[256];
    size_t row = 0;
    if (!a->to || iso_names_find(&iso_export_target_names, a->to, &row, NULL) != ISO_OK)
        return iso_fail(err, ISO_E_USAGE, "--to is \"%s\", wanted %s", a->to ? a->to : "",
                        iso_names_join(&iso_export_target_names, "or", names, sizeof names));
    *target = iso_export_target_at(row);
    if (!a->output)
        return iso_fail(err, ISO_E_USAGE, "-o is missing: %s", (*target)->summary);
    iso_status status = iso_words_check_range("--level", a->level, 0, 63, err);
    if (status == ISO_OK)
        status = iso_words_check_range("--levels", a->level_count, 1, 64, err);
    if (status == ISO_OK && a->step != 0)
        status = iso_words_check_range("--step", a->step, 1e-3, 16, err);
    if (status == ISO_OK)
        status = check_options(a, *target, err);
    return status == ISO_OK ? check_plan(a, err) : status;
}

static iso_status export_it(const export_arguments *a, iso_error *err)
{
    const iso_export_target *target = NULL;
    double iso[3] = {0};
    iso_progress progress = iso_cli_progress(a->cli);
    iso_pyramid_options build = iso_pyramid_defaults();
    iso_pyramid pyramid = {0};
    iso_view view = {0};
    iso_planned planned = {0};
    const iso_subject_look look = iso_cli_look_request(&a->look, a->cli->threads);
    iso_status status = check(a, &target, err);
    if (status == ISO_OK)
        status = iso_subject_check_look(&look, err);
    if (status != ISO_OK)
        return status;
    if (a->isosurface)
        status = iso_words_parse_numbers(a->isosurface, "--isosurface", iso, err);
    if (status != ISO_OK)
        return status;
    iso_cli_expect_names(a->cli, !iso_pyramid_is_one(a->cli->arguments[0]), target->stages, target->name);
    build.threads = a->cli->threads;
    build.level_count = (size_t)(a->level + a->level_count);
    status = iso_subject_load_pyramid(a->cli->arguments[0], &a->input, &build, &progress, &pyramid, err);
    if (status == ISO_OK && (size_t)(a->level + a->level_count) > pyramid.level_count)
        status = iso_fail(err, ISO_E_RANGE, "%s: level %d, the pyramid has levels 0 to %zu", a->cli->arguments[0],
                          a->level + a->level_count - 1, pyramid.level_count - 1);
    if (status == ISO_OK && (a->plan || a->roi.box || a->isosurface))
        status = iso_subject_refuse_labels(&pyramid, a->cli->arguments[0],
                                           a->plan ? "--plan" : a->roi.box ? "--roi" : "--isosurface", err);
    if (status == ISO_OK && (iso_export_takes(target, ISO_EXPORT_SCENE) || a->plan || a->adapted.extinction_scale))
        status = iso_subject_make_view(&look, &pyramid, &view, err);
    if (status == ISO_OK && view.width > 0) /* there is a scene */
        iso_cli_warn_of_view(a->cli, &pyramid, &view, a->isosurface ? iso : NULL, &(bool){false});
    if (status == ISO_OK && a->plan)
        status = iso_planned_create(a->plan,
                                    &(iso_planned_subject){&pyramid.levels[0], pyramid.options.code, &view.tf, 1},
                                    a->cli->threads, &planned, err);
    json_t *root = a->cli->json ? iso_cli_json(a->cli) : NULL;
    const iso_export_job job = {.pyramid = &pyramid,
                                .level = (size_t)a->level,
                                .level_count = (size_t)a->level_count,
                                .output = a->output,
                                .view = &view,
                                .planned = a->plan ? &planned : NULL,
                                .merged = wants_merged(a),
                                .step_voxels = a->step,
                                .half_float = a->half,
                                .extinction_scale = a->adapted.extinction_scale,
                                .isosurface = a->isosurface != NULL,
                                .iso = iso[0],
                                .threads = a->cli->threads,
                                .progress = &progress,
                                .view_of_level = view_of_level,
                                .user = a,
                                .results = root,
                                .notes = root ? NULL : stdout};
    if (status == ISO_OK)
        status = target->write(&job, err);
    if (status == ISO_OK && root) {
        json_object_update_new(root, json_pack("{s:s, s:s, s:i, s:i}", "to", a->to, "output", a->output, "level",
                                               a->level, "levels", a->level_count));
        iso_cli_print_json(root);
    } else {
        json_decref(root);
        if (status == ISO_OK)
            printf("%s: %s\n", a->output, target->summary);
    }
    iso_planned_destroy(&planned);
    iso_view_destroy(&view);
    iso_pyramid_destroy(&pyramid);
    return status;
}

static iso_status run(const iso_command *self, int argc, const char **argv, iso_error *err)
{
    export_arguments a = {.level_count = 1};
    iso_volume_input_defaults(&a.input);
    iso_cli_adapted_defaults(&a.adapted);
    iso_cli_roi_defaults(&a.roi);
    struct poptOption options[] = {
        {"to", 0, POPT_ARG_STRING, &a.to, 0, "export target of the list below", "TARGET"},
        {"output", 'o', POPT_ARG_STRING, &a.output, 0, "NAME.vdb, NAME.blend, or a folder for povray", "PATH"},
        ISO_CLI_LOOK_OPTIONS(&a.look),
        {"level", 0, POPT_ARG_INT | POPT_ARGFLAG_SHOW_DEFAULT, &a.level, 0, "level of the pyramid, 0 is the finest",
         "K"},
        {"levels", 0, POPT_ARG_INT | POPT_ARGFLAG_SHOW_DEFAULT, &a.level_count, 0,
         "vdb: this many levels from K on in one file, as density_level_N; blender: to be switched in one .blend", "N"},
        {"step", 0, POPT_ARG_DOUBLE, &a.step, 0, "blender: ray step in voxels of the level (the scene's)", "STEP"},
        {"isosurface", 0, POPT_ARG_STRING, &a.isosurface, 0, "povray: the surface of this value instead of the volume",
         "VALUE"},
        {"plan", 0, POPT_ARG_STRING, &a.plan, 0,
         "only the part of the volume that this plan (isoshade plan -o) keeps; with its --scene", "PLAN.json"},
        {"grids", 0, POPT_ARG_STRING, &a.grids, 0,
         "vdb of a plan: merged (default), one plain grid; or levels, one a level", "GRIDS"},
        {"half", 0, POPT_ARG_NONE, &a.half, 0, "vdb: half floats, smaller and less exact", NULL},
        ISO_CLI_ADAPTED_OPTIONS(&a.adapted),
        ISO_CLI_ROI_OPTIONS(&a.roi),
        ISO_CLI_INPUT_OPTIONS(&a.input),
        POPT_TABLEEND,
    };
    iso_cli cli;
    iso_cli_next next;
    a.cli = &cli;
    iso_status status = iso_cli_parse(&cli, self, argc, argv, options, &next, err);
    if (status == ISO_OK && next == ISO_CLI_RUN)
        status = export_it(&a, err);
    iso_cli_end(&cli);
    return status;
}

const iso_command iso_command_export = {
    .name = "export",
    .summary = "write a level for OpenVDB, Blender or POV-Ray",
    .min_arguments = 1,
    .max_arguments = 1,
    .usage = "VOLUME|PYRAMID.iso --to TARGET -o PATH [options]",
    .details =
        "vdb: grids density (float) and gradient (vec3s, shading directions in world axes). blender: a scene that renders as\n"
        "it opens; colour map packed, the grids beside it by relative paths, levels switched by a property; doc/blender.md.\n"
        "povray: run `povray NAME.ini` in the folder. Without --scene the camera frames the box and the transfer function is\n"
        "suggested; vdb takes a scene only for --extinction-scale and --plan. With --plan only what the scene\n"
        "needs is written: active voxels and a transparent background, a volume a level for blender, cropped DF3 files.\n"
        "Other programs filter directions themselves: there is no flipped fetch (render --shading-from flipped) in what is exported.",
    .examples =
        "  isoshade make shells --size 48 -o shells.nrrd\n"
        "  isoshade export shells.nrrd --to blender -o first.blend\n"
        "  isoshade export shells.nrrd --to vdb --levels 3 -o shells.vdb\n"
        "  isoshade export shells.nrrd --to blender --scene refscenes/shells.scene.json -o shells.blend\n"
        "  isoshade export shells.nrrd --to blender --scene refscenes/shells.scene.json --levels 3 --adapt -o levels.blend\n"
        "  isoshade export shells.nrrd --to blender --scene refscenes/shells.scene.json --level 1 --adapt --roi 8,8,8,32,32,32 -o roi.blend\n"
        "  isoshade export shells.nrrd --to povray --scene refscenes/shells.scene.json --level 1 -o shells-pov\n"
        "  isoshade export shells.nrrd --to vdb --scene refscenes/shells.scene.json --level 1 --adapt --extinction-scale -o scaled.vdb\n"
        "  isoshade plan shells.nrrd --scene refscenes/shells.scene.json --size 96 --brick 8 --levels 3 -o shells.plan.json\n"
        "  isoshade export shells.nrrd --to vdb --plan shells.plan.json --scene refscenes/shells.scene.json -o planned.vdb\n",
    .lists = (const iso_names *const[]){&iso_export_target_names, &iso_tf_preset_names, &iso_viewpoint_names, NULL},
    .run = run,
};

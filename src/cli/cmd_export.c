/* SPDX-License-Identifier: MIT */
/* cmd_export.c - a level for other programs: OpenVDB, Blender, POV-Ray. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "blender/blender.h"
#include "options/cli.h"
#include "options/input.h"
#include "plan/planned.h"
#include "options/roi.h"
#include "scene/subject.h"
#include "povray/povray.h"
#include "vdb/vdb.h"

typedef struct export_arguments {
    iso_volume_input input;
    iso_cli_adapted adapted;
    iso_cli_roi roi;
    char *to, *output, *scene, *size, *isosurface, *plan, *grids;
    int level, level_count, half;
    double step;
    const iso_cli *cli;
} export_arguments;

/* What the targets get: a pyramid, and a view where they need a scene. */
typedef struct export_job {
    const export_arguments *arguments;
    const iso_pyramid *pyramid;
    iso_view *view; /* with the scene's own transfer function */
    const iso_planned *planned; /* what a plan leaves, or NULL: whole levels */
    const iso_progress *progress;
    json_t *results; /* with --json: what a target has to say */
} export_job;

static bool wants_merged(const export_arguments *a) { return !a->grids || strcmp(a->grids, "merged") == 0; }

static iso_status planned_to_vdb(const export_job *job, const iso_vdb_options *o, iso_error *err)
{
    const export_arguments *a = job->arguments;
    iso_planned_lattices lattices;
    iso_status status = iso_planned_lattices_create(job->planned, wants_merged(a), false, a->cli->threads, &lattices, err);
    if (status != ISO_OK)
        return status;
    status = iso_vdb_save_lattices(lattices.items, lattices.count, job->pyramid->source, a->output, o, job->progress, err);
    iso_planned_lattices_destroy(&lattices);
    return status;
}

static iso_status to_vdb(const export_job *job, iso_error *err)
{
    iso_vdb_options o = iso_vdb_defaults();
    o.half_float = job->arguments->half;
    if (job->planned)
        return planned_to_vdb(job, &o, err);
    return iso_vdb_save(job->pyramid, (size_t)job->arguments->level, (size_t)job->arguments->level_count,
                        job->arguments->output, &o, job->progress, err);
}

/* The view of level k: the scene's with a copy of its table, adapted where that is asked for. Destroy it. */
static iso_status level_view(const export_job *job, size_t k, iso_view *view, iso_error *err)
{
    const export_arguments *a = job->arguments;
    *view = *job->view;
    size_t bytes = 4 * view->tf.count * sizeof *view->tf.entries;
    view->tf.entries = malloc(bytes);
    if (!view->tf.entries) {
        *view = (iso_view){0};
        return iso_fail(err, ISO_E_MEMORY, "export: out of memory");
    }
    memcpy(view->tf.entries, job->view->tf.entries, bytes);
    /* levels that are no coarser than the region of interest need none */
    iso_status status = a->roi.box && a->roi.level >= 0 && k <= (size_t)a->roi.level && k < (size_t)(a->level + a->level_count - 1)
                            ? ISO_OK
                            : iso_cli_roi_view(&a->roi, &a->adapted, a->cli->arguments[0], job->pyramid, k, view, a->cli->threads, err);
    return status != ISO_OK ? status : iso_cli_adapt_view(&a->adapted, a->cli->arguments[0], job->pyramid, k, view, a->cli->threads, err);
}

static void tell_ramp(const export_job *job, const iso_tf_table *table)
{
    iso_color_ramp ramp;
    iso_color_ramp_fit(table, &ramp);
    if (job->results)
        json_object_set_new(job->results, "color_ramp",
                            json_pack("{sI sf sf}", "stops", (json_int_t)ramp.count, "max_color_difference",
                                      ramp.color_loss, "max_opacity_difference", ramp.alpha_loss));
    else
        printf("colour map: exact as an image; as a ColorRamp of %zu stops within %.2g in colour, %.2g of the largest opacity\n",
               ramp.count, ramp.color_loss, ramp.alpha_loss);
}

static iso_status planned_to_blender(const export_job *job, const iso_blender_options *o, iso_error *err)
{
    const export_arguments *a = job->arguments;
    const iso_node_levels *n = &job->planned->nodes;
    iso_planned_lattices lattices;
    iso_status status = iso_planned_lattices_create(job->planned, false, true, a->cli->threads, &lattices, err);
    if (status != ISO_OK)
        return status;
    uint8_t *pieces = iso_planned_pieces(job->planned, &lattices);
    const iso_blender_plan plan = {.geometry = &n->geometry, .bricks = {n->count[0], n->count[1], n->count[2]},
                                   .brick_voxels = n->brick_voxels, .piece = pieces, .lattices = lattices.items,
                                   .count = lattices.count, .source = job->pyramid->source};
    status = pieces ? iso_blender_export_plan(&plan, job->view, a->output, o, job->progress, err)
                    : iso_fail(err, ISO_E_MEMORY, "export: out of memory");
    if (status == ISO_OK)
        tell_ramp(job, &job->view->tf);
    free(pieces);
    iso_planned_lattices_destroy(&lattices);
    return status;
}

static iso_status to_blender(const export_job *job, iso_error *err)
{
    const export_arguments *a = job->arguments;
    size_t first = (size_t)a->level, count = (size_t)a->level_count;
    iso_blender_options o = iso_blender_defaults();
    o.step_voxels = a->step > 0 ? a->step : job->view->step_voxels;
    o.threads = a->cli->threads;
    if (job->planned)
        return planned_to_blender(job, &o, err);
    iso_view *views = calloc(count, sizeof *views);
    iso_status status = views ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "export: out of memory");
    for (size_t k = 0; k < count && status == ISO_OK; ++k)
        status = level_view(job, first + k, &views[k], err);
    if (status == ISO_OK)
        status = iso_blender_export_levels(job->pyramid, first, count, views, a->output, &o, job->progress, err);
    if (status == ISO_OK)
        tell_ramp(job, &views[0].tf);
    for (size_t k = 0; views && k < count; ++k)
        iso_view_destroy(&views[k]);
    free(views);
    return status;
}

static iso_status planned_to_povray(const export_job *job, iso_povray_options *o, iso_error *err)
{
    const export_arguments *a = job->arguments;
    iso_planned_crop crop;
    iso_status status = iso_planned_crop_create(job->planned, &job->pyramid->levels[0], job->pyramid->options.code,
                                                a->cli->threads, &crop, err);
    if (status != ISO_OK)
        return status;
    const iso_pyramid cropped = {.options = job->pyramid->options, .source = job->pyramid->source, .level_count = 1,
                                 .levels = &crop.level};
    o->box = (const double(*)[3])crop.box;
    status = iso_povray_export(&cropped, 0, job->view, a->output, o, job->progress, err);
    iso_planned_crop_destroy(&crop);
    return status;
}

static iso_status to_povray(const export_job *job, iso_error *err)
{
    iso_povray_options o = iso_povray_defaults();
    /* A person looks at it: one pass without cutting planes, 16-bit files. */
    o.planes = 0;
    o.extrapolate = false;
    o.df3_bits = 16;
    double value[3] = {0};
    iso_status status = ISO_OK;
    if (job->planned)
        return planned_to_povray(job, &o, err);
    if (job->arguments->isosurface)
        status = iso_words_parse_numbers(job->arguments->isosurface, "--isosurface", value, err);
    if (status == ISO_OK)
        status = iso_cli_roi_view(&job->arguments->roi, &job->arguments->adapted, job->arguments->cli->arguments[0], job->pyramid,
                                  (size_t)job->arguments->level, job->view, job->arguments->cli->threads, err);
    if (status == ISO_OK)
        status = iso_cli_adapt_view(&job->arguments->adapted, job->arguments->cli->arguments[0], job->pyramid,
                                    (size_t)job->arguments->level, job->view, job->arguments->cli->threads, err);
    if (status != ISO_OK)
        return status;
    o.isosurface = job->arguments->isosurface != NULL;
    o.iso = value[0];
    return iso_povray_export(job->pyramid, (size_t)job->arguments->level, job->view, job->arguments->output, &o,
                             job->progress, err);
}

static const struct target {
    const char *name, *makes;
    bool needs_scene, takes_levels, takes_step, takes_half, takes_isosurface;
    iso_status (*run)(const export_job *job, iso_error *err);
} targets[] = {
    {.name = "vdb", .makes = "an OpenVDB file: float grid density, vec3s grid gradient", .takes_levels = true,
     .takes_half = true, .run = to_vdb},
    {.name = "blender", .makes = "a .blend that renders as it opens, and its OpenVDB grids", .needs_scene = true,
     .takes_levels = true, .takes_step = true, .run = to_blender},
    {.name = "povray", .makes = "a folder with .pov, .inc, .ini and DF3 files", .needs_scene = true,
     .takes_isosurface = true, .run = to_povray},
};
enum { target_count = sizeof targets / sizeof *targets };

/* With a plan the levels are the plan's, and so is the transfer function. */
static iso_status check_plan(const export_arguments *a, iso_error *err)
{
    if (!a->plan)
        return a->grids ? iso_fail(err, ISO_E_USAGE, "--grids needs --plan") : ISO_OK;
    if (!a->scene)
        return iso_fail(err, ISO_E_USAGE, "--plan needs the --scene that it was made for");
    if (!wants_merged(a) && strcmp(a->grids, "levels") != 0)
        return iso_fail(err, ISO_E_USAGE, "--grids is \"%s\", wanted merged or levels", a->grids);
    if (a->level != 0 || a->level_count != 1 || a->adapted.wanted || a->isosurface || a->roi.box)
        return iso_fail(err, ISO_E_USAGE, "--plan chooses the levels itself: --level, --levels, --adapt, --roi and --isosurface have no meaning");
    return ISO_OK;
}

static iso_status check(const export_arguments *a, const struct target **target, iso_error *err)
{
    *target = NULL;
    for (size_t i = 0; a->to && i < target_count; ++i)
        if (strcmp(targets[i].name, a->to) == 0)
            *target = &targets[i];
    if (!*target)
        return iso_fail(err, ISO_E_USAGE, "--to is \"%s\", wanted vdb, blender or povray", a->to ? a->to : "");
    if (!a->output)
        return iso_fail(err, ISO_E_USAGE, "-o is missing: %s", (*target)->makes);
    iso_status status = iso_words_check_range("--level", a->level, 0, 63, err);
    if (status == ISO_OK)
        status = iso_words_check_range("--levels", a->level_count, 1, 64, err);
    if (status == ISO_OK && a->step != 0)
        status = iso_words_check_range("--step", a->step, 1e-3, 16, err);
    /* An option that would change nothing is a mistake. */
    const struct target *t = *target;
    const struct {
        const char *option;
        bool given, taken;
    } uses[] = {{"--levels", a->level_count > 1, t->takes_levels},
                {"--step", a->step != 0, t->takes_step},
                {"--half", a->half, t->takes_half},
                {"--isosurface", a->isosurface != NULL, t->takes_isosurface},
                {"--scene", a->scene != NULL, t->needs_scene || a->plan},
                {"--size", a->size != NULL, t->needs_scene},
                {"--roi", a->roi.box != NULL, t->needs_scene},
                {"--adapt", a->adapted.wanted, t->needs_scene}};
    for (size_t i = 0; i < sizeof uses / sizeof *uses && status == ISO_OK; ++i)
        if (uses[i].given && !uses[i].taken)
            status = iso_fail(err, ISO_E_USAGE, "%s has no meaning for --to %s", uses[i].option, t->name);
    return status == ISO_OK ? check_plan(a, err) : status;
}


static iso_status export_it(const export_arguments *a, iso_error *err)
{
    const struct target *target;
    iso_progress progress = iso_cli_progress(a->cli);
    iso_pyramid_options build = iso_pyramid_defaults();
    iso_pyramid pyramid = {0};
    iso_view view = {0};
    iso_planned planned = {0};
    iso_status status = check(a, &target, err);
    if (status != ISO_OK)
        return status;
    build.threads = a->cli->threads;
    build.level_count = (size_t)(a->level + a->level_count);
    status = iso_subject_load_pyramid(a->cli->arguments[0], &a->input, &build, &progress, &pyramid, err);
    if (status == ISO_OK && (size_t)(a->level + a->level_count) > pyramid.level_count)
        status = iso_fail(err, ISO_E_RANGE, "%s: level %d, the pyramid has levels 0 to %zu", a->cli->arguments[0],
                          a->level + a->level_count - 1, pyramid.level_count - 1);
    if (status == ISO_OK && (target->needs_scene || a->plan))
        status = iso_subject_load_view(a->scene, &pyramid, a->size, &view, err);
    if (status == ISO_OK && a->plan)
        status =
            iso_planned_create(a->plan, &(iso_planned_subject){&pyramid.levels[0], pyramid.options.code, &view.tf, 1},
                               a->cli->threads, &planned, err);
    json_t *root = a->cli->json ? iso_cli_json(a->cli) : NULL;
    const export_job job = {a, &pyramid, &view, a->plan ? &planned : NULL, &progress, root};
    if (status == ISO_OK)
        status = target->run(&job, err);
    if (status == ISO_OK && root) {
        json_object_update_new(root, json_pack("{s:s, s:s, s:i, s:i}", "to", a->to, "output", a->output, "level", a->level,
                                               "levels", a->level_count));
        iso_cli_print_json(root);
    } else {
        json_decref(root);
        if (status == ISO_OK)
            printf("%s: %s\n", a->output, target->makes);
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
        {"to", 0, POPT_ARG_STRING, &a.to, 0, "vdb, blender or povray", "TARGET"},
        {"output", 'o', POPT_ARG_STRING, &a.output, 0, "NAME.vdb, NAME.blend, or a folder for povray", "PATH"},
        {"scene", 0, POPT_ARG_STRING, &a.scene, 0, "camera, lights, shading and transfer function; blender and povray", "SCENE.scene.json"},
        {"level", 0, POPT_ARG_INT | POPT_ARGFLAG_SHOW_DEFAULT, &a.level, 0, "level of the pyramid, 0 is the finest", "K"},
        {"levels", 0, POPT_ARG_INT | POPT_ARGFLAG_SHOW_DEFAULT, &a.level_count, 0, "vdb: this many levels from K on in one file, as density_level_N; blender: to be switched in one .blend", "N"},
        {"step", 0, POPT_ARG_DOUBLE, &a.step, 0, "blender: ray step in voxels of the level (the scene's)", "STEP"},
        {"size", 0, POPT_ARG_STRING, &a.size, 0, "image size instead of the scene's", "WxH"},
        {"isosurface", 0, POPT_ARG_STRING, &a.isosurface, 0, "povray: the surface of this value instead of the volume", "VALUE"},
        {"plan", 0, POPT_ARG_STRING, &a.plan, 0, "only what this plan leaves of the volume (isoshade plan -o), with its --scene", "PLAN.json"},
        {"grids", 0, POPT_ARG_STRING, &a.grids, 0, "vdb of a plan: merged (default), one plain grid; or levels, one a level", "GRIDS"},
        {"half", 0, POPT_ARG_NONE, &a.half, 0, "vdb: half floats, smaller and less exact", NULL},
        ISO_CLI_ADAPTED_OPTIONS(&a.adapted),
        ISO_CLI_ROI_OPTIONS(&a.roi),
        ISO_CLI_INPUT_OPTIONS(&a.input),
        POPT_TABLEEND,
    };
    iso_cli cli;
    iso_cli_next next;
    a.cli = &cli;
    iso_status status = iso_cli_parse(&cli, self, argc, argv, options, 1, 1, &next, err);
    if (status == ISO_OK && next == ISO_CLI_RUN)
        status = export_it(&a, err);
    iso_cli_end(&cli);
    return status;
}

const iso_command iso_command_export = {
    .name = "export",
    .summary = "write a level for OpenVDB, Blender or POV-Ray",
    .usage = "VOLUME|PYRAMID.iso --to vdb|blender|povray -o PATH [options]",
    .details = "vdb: grids density (float) and gradient (vec3s, shading directions in world axes). blender: a scene that renders as\n"
               "it opens; colour map packed, the grids beside it by relative paths, levels switched by a property; doc/blender.md.\n"
               "povray: run `povray NAME.ini` in the folder. Scenes under refscenes/ fit any volume. With --plan only what the scene\n"
               "needs is written: active voxels and a transparent background, a volume a level for blender, cropped DF3 files.\n"
               "Other programs filter directions themselves: there is no flipped fetch (render --shading-from flipped) in what is exported.",
    .examples = "  isoshade make shells --size 48 -o shells.nrrd\n"
                "  isoshade export shells.nrrd --to vdb --levels 3 -o shells.vdb\n"
                "  isoshade export shells.nrrd --to blender --scene refscenes/shells.scene.json -o shells.blend\n"
                "  isoshade export shells.nrrd --to blender --scene refscenes/shells.scene.json --levels 3 --adapt -o levels.blend\n"
                "  isoshade export shells.nrrd --to blender --scene refscenes/shells.scene.json --level 1 --adapt --roi 8,8,8,32,32,32 -o roi.blend\n"
                "  isoshade export shells.nrrd --to povray --scene refscenes/shells.scene.json --level 1 -o shells-pov\n"
                "  isoshade plan shells.nrrd --scene refscenes/shells.scene.json --size 96 --brick 8 --levels 3 -o shells.plan.json\n"
                "  isoshade export shells.nrrd --to vdb --plan shells.plan.json --scene refscenes/shells.scene.json -o planned.vdb\n",
    .run = run,
};

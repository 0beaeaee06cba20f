/* SPDX-License-Identifier: MIT */
/* cmd_view.c - writes a volume as a page to look at, and to choose transfer function, camera and level. */
#define _GNU_SOURCE
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/json.h"
#include "base/provenance.h"
#include "options/cli.h"
#include "options/input.h"
#include "options/look.h"
#include "options/visible.h"
#include "plan/planned.h"
#include "scene/viewpoint.h"
#include "tf/presets.h"
#include "tf/small_views.h"
#include "view/viewer.h"
#include "volume/value_unit.h"

enum { LEVELS = 5, COARSEST = 16 }; /* COARSEST: stop at this many voxels along the longest side */

typedef struct view_arguments {
    iso_volume_input input;
    iso_cli_look look;
    char *output, *codes, *plan, *overlay;
    int level, levels, floats, adapted, errors, compact;
    double most;
} view_arguments;

/* The plan file of --plan. */
typedef struct view_plan {
    iso_planned planned;
    iso_view view; /* view of the scene; the plan must be for its transfer function */
    iso_viewer_plan page;
} view_plan;

/* Reads the planner's predicted and measured errors, which other plans may omit. */
static iso_status read_errors(const char *path, iso_viewer_plan *page, iso_error *err)
{
    json_auto_t *root = NULL;
    const iso_status status = iso_json_load(path, &root, err);
    const char *const keys[] = {"predicted_rmse", "measured_rmse"};
    double *const values[] = {&page->predicted_rmse, &page->measured_rmse};
    for (int i = 0; i < 2; ++i) {
        const json_t *value = json_object_get(root, keys[i]);
        *values[i] = json_is_number(value) ? json_number_value(value) : NAN;
    }
    return status;
}

/* Opens a plan. ISO_E_RANGE: it is for another volume or transfer function. Destroy it in any case. */
static iso_status open_plan(view_plan *plan, const char *path, const iso_viewer *v, iso_error *err)
{
    *plan = (view_plan){.page = {.name = iso_provenance_title(path)}};
    const iso_level *level0 = &v->pyramid->levels[0];
    NEED(iso_scene_resolve(v->scene, &level0->geometry, iso_pyramid_lo(v->pyramid), iso_pyramid_hi(v->pyramid),
                           &plan->view, err));
    NEED(iso_planned_create(path, &(iso_planned_subject){level0, v->codes[0], &plan->view.tf, 1}, v->threads,
                            &plan->planned, err));
    plan->page.nodes = &plan->planned.nodes;
    plan->page.levels = plan->planned.plan.levels;
    plan->page.drawn = plan->planned.plan.drawn;
    return read_errors(path, &plan->page, err);
}

static void view_plan_destroy(view_plan *plan)
{
    iso_planned_destroy(&plan->planned);
    iso_view_destroy(&plan->view);
}

static iso_status take_codes(const view_arguments *a, const iso_pyramid_options *build, iso_viewer *v, iso_error *err)
{
    FREED char *list = strdup(a->codes ? a->codes : iso_code_describe(build->code)->name);
    char *rest = list;
    NEED_MEMORY(list, err, "out of memory");
    v->code_count = 0;
    for (char *name; (name = strsep(&rest, ","));) {
        if (strcmp(name, "none") == 0 && !rest && v->code_count == 0)
            break;
        if (v->code_count == ISO_VIEWER_CODES)
            return iso_fail(err, ISO_E_USAGE, "--code: more than %d codes", ISO_VIEWER_CODES);
        else if (iso_code_from_name(name, &v->codes[v->code_count], err) != ISO_OK)
            return iso_fail_in(err, ISO_E_USAGE, "--code");
        else if (!iso_code_describe(v->codes[v->code_count])->is_textured)
            return iso_fail(err, ISO_E_USAGE, "--code %s: a page needs a code that textures can filter", name);
        else
            ++v->code_count;
    }
    return ISO_OK;
}

/* Chooses the levels of the page: from the finest that is small enough, or the requested one, to a thumbnail. */
static iso_status choose_levels(const view_arguments *a, const iso_pyramid *p, iso_viewer *v, iso_error *err)
{
    if (a->level >= 0)
        NEED(iso_pyramid_check_level(p, NULL, (size_t)a->level, err));
    v->first = a->level >= 0 ? (size_t)a->level : iso_viewer_finest_level(p, a->most);
    if (a->plan && v->first == 0)
        v->first = 1; /* the plan replaces level 0 */
    if (a->plan && v->first >= p->level_count)
        return iso_fail(err, ISO_E_RANGE, "--plan: the pyramid has level 0 alone; build coarse levels with --levels");
    const double voxels = (double)iso_geometry_voxel_count(&p->levels[v->first].geometry);
    if (voxels > a->most)
        return iso_fail(
            err, ISO_E_RANGE,
            "level %zu has %.3g voxels, the page's limit is %.3g; raise --most-voxels or take a coarser --level",
            v->first, voxels, a->most);
    v->last = v->first;
    while (v->last + 1 < p->level_count && v->last + 1 < v->first + (size_t)a->levels) {
        const size_t *size = p->levels[v->last + 1].geometry.size;
        if (size[0] < COARSEST && size[1] < COARSEST && size[2] < COARSEST)
            break;
        ++v->last;
    }
    return ISO_OK;
}

static void report(const view_arguments *a, const iso_cli *cli, const iso_viewer *v, const iso_viewer_size *size)
{
    const size_t *n = v->pyramid->levels[v->first].geometry.size;
    if (cli->json) {
        json_t *root = iso_cli_json(cli);
        json_object_update_new(root,
                               json_pack("{s:s, s:I, s:I, s:I, s:I, s:[I,I,I], s:I, s:f}", "page", a->output,
                                         "page_bytes", (json_int_t)size->page_bytes, "data_bytes",
                                         (json_int_t)size->data_bytes, "voxel_bytes", (json_int_t)size->voxel_bytes,
                                         "level", (json_int_t)v->first, "level_size", (json_int_t)n[0],
                                         (json_int_t)n[1], (json_int_t)n[2], "level_count",
                                         (json_int_t)(v->last - v->first + 1), "quantum", size->quantum));
        if (v->plan)
            json_object_set_new(root, "plan",
                                json_pack("{s:s, s:I, s:I, s:I, s:o, s:o}", "name", v->plan->name, "drawn",
                                          (json_int_t)size->plan_bricks, "bricks",
                                          (json_int_t)iso_brick_count(v->plan->nodes), "texels",
                                          (json_int_t)size->plan_texels, "predicted_rmse",
                                          iso_json_number(v->plan->predicted_rmse), "measured_rmse",
                                          iso_json_number(v->plan->measured_rmse)));
        iso_cli_print_json(root);
        return;
    }
    if (cli->quiet)
        return;
    char levels[48];
    snprintf(levels, sizeof levels, v->first == v->last ? "level %zu" : "levels %zu to %zu", v->first, v->last);
    printf("%s: %s, the finest %zu x %zu x %zu, %.3g MB (%.3g kB of it the page itself)\n", a->output, levels, n[0],
           n[1], n[2], (double)size->page_bytes / 1e6, (double)(size->page_bytes - size->data_bytes) / 1e3);
    if (v->plan) {
        printf("%s: %zu of %zu bricks in %.3g million texels, of %.3g million voxels\n", v->plan->name,
               size->plan_bricks, iso_brick_count(v->plan->nodes), 1e-6 * (double)size->plan_texels,
               1e-6 * (double)iso_geometry_voxel_count(&v->pyramid->levels[0].geometry));
        printf("RMSE %.3g predicted, %.3g measured, against pictures of level 0 in the views of the plan\n",
               v->plan->predicted_rmse, v->plan->measured_rmse);
        return;
    }
    if (a->level < 0 && v->first > 0)
        printf("level 0 has more than %.3g voxels and is left out; include it with --most-voxels\n", a->most);
}

static iso_status check(const view_arguments *a, iso_error *err)
{
    if (!a->output)
        return iso_fail(err, ISO_E_USAGE, "-o is missing: page to write, .html");
    if (a->plan && a->level == 0)
        return iso_fail(err, ISO_E_USAGE, "--plan and --level 0 exclude each other: the plan replaces level 0");
    return ISO_OK;
}

/* Returns the volume's file and the options that read it, as words of a command line. NULL: out of memory. */
static char *input_line(const char *path, const iso_volume_input *input)
{
    char *line = NULL;
    FREED char *options = iso_volume_input_line(input), *names = options ? iso_provenance_line(options) : NULL;
    size_t size = 0;
    FILE *f = names ? open_memstream(&line, &size) : NULL;
    if (f) {
        if (iso_provenance_kept() == ISO_PROVENANCE_NONE)
            iso_words_put_quoted(f, iso_provenance_title(path));
        else
            iso_provenance_put_word(f, path);
        fputs(names, f);
        fclose(f);
    }
    return line;
}

/* Reports that the page does not have the levels' own transfer functions and extinction scales. */
static void note_levels(const iso_cli *cli, const char *path)
{
    if (cli->quiet)
        return;
    iso_progress_line_hide(cli->progress);
    fprintf(stderr,
            "isoshade view: note: %s: levels that were made for a scene are shown under its transfer function, "
            "not under their own\n",
            path);
}

/* Loads the pyramid, but only the page's levels if level 0 has more voxels than the errors of levels are measured from
 * (tf/small_views.h), and if no option needs it. */
static iso_status load(const view_arguments *a, const char *path, const iso_pyramid_options *build,
                       const iso_progress *progress, iso_viewer *v, iso_pyramid *p, iso_error *err)
{
    const double most = fmax(a->most, (double)ISO_SMALL_VIEWS_MAX_VOXELS);
    OWNED(iso_pyramid) outline = {0};
    OWNED(iso_subject_coarse) coarse = {0};
    if (a->plan || a->adapted || a->errors || a->level == 0)
        return iso_subject_load_pyramid(path, &a->input, build, progress, p, err);
    NEED(iso_subject_load_coarse(path, &a->input, build, most, progress, p, &coarse, err));
    if (!coarse.folder)
        return ISO_OK;
    NEED(choose_levels(a, p, v, err));
    outline = *p;
    return iso_pyramid_load_from(coarse.folder, v->first, p, err);
}

/* Loads the second volume as a pyramid of one level. */
static iso_status load_overlay(const view_arguments *a, const iso_progress *progress, iso_viewer *v, iso_pyramid *p,
                               iso_error *err)
{
    iso_pyramid_options build = iso_pyramid_defaults();
    const iso_volume_input input = {0};
    build.threads = v->threads;
    build.level_count = 1;
    iso_status status = iso_subject_load_pyramid(a->overlay, &input, &build, progress, p, err);
    const double voxels = status == ISO_OK ? (double)iso_geometry_voxel_count(&p->levels[0].geometry) : 0;
    if (voxels > a->most)
        status = iso_fail(err, ISO_E_RANGE, "%s: %.3g voxels, the page's limit is %.3g; raise --most-voxels",
                          a->overlay, voxels, a->most);
    if (status != ISO_OK)
        return iso_fail_in(err, status, "--overlay");
    v->overlay = &p->levels[0];
    v->overlay_title = iso_provenance_title(a->overlay);
    return ISO_OK;
}

static iso_status view(const view_arguments *a, const iso_cli *cli, iso_error *err)
{
    const char *path = cli->arguments[0];
    char value_unit[ISO_VALUE_UNIT_BYTES] = "";
    FREED char *input = input_line(path, &a->input);
    const bool is_pyramid = iso_pyramid_is_one(path);
    const iso_cli_stage stages[] = {{"pyramid", 1}, {"pack", 3}};
    iso_progress progress = iso_cli_progress(cli);
    iso_pyramid_options build = iso_pyramid_defaults();
    OWNED(iso_pyramid) pyramid = {0}, overlay = {0};
    OWNED(iso_scene) scene = {0};
    OWNED(view_plan) plan = {.page = {.name = NULL}};
    iso_subject_look look;
    iso_viewer v = {.pyramid = &pyramid,
                    .scene = &scene,
                    .floats = a->floats,
                    .adapted = a->adapted,
                    .errors = a->errors,
                    .compact = a->compact,
                    .threads = cli->threads,
                    .title = iso_provenance_title(path),
                    .input = input,
                    .value_unit = value_unit,
                    .folder = is_pyramid ? path : NULL};
    iso_viewer_size size;
    NEED(check(a, err));
    iso_cli_expect(cli, stages, sizeof stages / sizeof *stages);
    build.threads = cli->threads;
    build.level_count = (size_t)(a->level > 0 ? a->level : 0) + (size_t)a->levels;
    NEED(take_codes(a, &build, &v, err));
    if (a->plan && v.code_count == 0)
        return iso_fail(err, ISO_E_USAGE, "--plan and --code none exclude each other: bricks are shaded by codes");
    build.code = v.code_count > 0 ? v.codes[0] : build.code;
    build.keep_float = v.code_count > 1;
    NEED(iso_cli_look_check(&a->look, cli->threads, &look, err));
    NEED(load(a, path, &build, &progress, &v, &pyramid, err));
    if (is_pyramid && !a->codes)
        v.codes[0] = pyramid.options.code;
    iso_value_unit_read(path, &a->input, value_unit);
    NEED(choose_levels(a, &pyramid, &v, err));
    NEED(iso_subject_make_scene(&look, &pyramid, &scene, err));
    if (pyramid.made_for)
        note_levels(cli, path);
    if (a->plan) {
        NEED(iso_subject_refuse_labels(&pyramid, path, "a plan", err));
        NEED(open_plan(&plan, a->plan, &v, err));
        v.plan = &plan.page;
    }
    if (a->overlay)
        NEED(load_overlay(a, &progress, &v, &overlay, err));
    NEED(iso_viewer_save(&v, a->output, &progress, &size, err));
    report(a, cli, &v, &size);
    return ISO_OK;
}

static const iso_option options[] = {
    {"output", 'o', "page to write", "VIEW.html", ISO_IN(view_arguments, output)},
    ISO_OPTIONS_OF(view_arguments, look, iso_look_rows),
    {"overlay", 0, "second volume or label map, at its place in the same picture", "VOLUME|PYRAMID.iso",
     ISO_IN(view_arguments, overlay)},
    {"level", 0, "finest level in the page (the finest that is small enough)", "K", ISO_IN(view_arguments, level),
     .most = 31},
    {"levels", 0, "number of levels in the page", "N", ISO_IN(view_arguments, levels), .flags = ISO_SHOWN, .least = 1,
     .most = 16},
    {"most-voxels", 0, "largest voxel count of the finest level (32e6)", "N", ISO_IN(view_arguments, most), .least = 1,
     .most = 1e9},
    {"plan", 0, "bricks of isoshade plan instead of level 0, for large volumes", "PLAN.json",
     ISO_IN(view_arguments, plan)},
    {"code", 0, "direction codes of the page; none: only gradients on the fly, smaller", "CODE,..",
     ISO_IN(view_arguments, codes)},
    {"float", 0, "keep float levels as floats, not as 16 bits; doubles the page's size", NULL,
     ISO_IN(view_arguments, floats)},
    {"errors", 0, "measure the error of each coarse level, not only of the finest", NULL,
     ISO_IN(view_arguments, errors)},
    {"compact", 0, "start with the picture alone, for frames in other pages", NULL, ISO_IN(view_arguments, compact)},
    {"adapt", 0, "start with transfer functions adapted to coarse levels", NULL, ISO_IN(view_arguments, adapted)},
    ISO_OPTIONS_OF(view_arguments, input, iso_input_rows),
    ISO_OPTIONS_END,
};

static iso_status run(const iso_cli *cli, void *values, iso_error *err)
{
    return view(values, cli, err);
}

const iso_command iso_command_view = {
    .name = "view",
    .summary = "write a volume as a page for a browser: choose transfer function, camera and level, save the scene",
    .min_arguments = 1,
    .max_arguments = 1,
    .usage = "VOLUME|PYRAMID.iso -o VIEW.html [--scene SCENE.scene.json] [options]",
    .details =
        "The page needs no network, no server and no other file. It draws with WebGL2 and the shaders of the ray caster\n"
        "(render --with gl), and saves scene.json and tf.json, which every other command takes. Levels are drawn as they are\n"
        "read, the coarsest first; --plan adds level 0 in the bricks that a scene needs. Shading is by the pyramid's direction\n"
        "codes or by gradients on the fly.",
    .common = "output scene tf view zoom level levels plan adapt spacing threads",
    .examples =
        "  isoshade make shells --size 48x44x40 -o shells.nrrd\n"
        "  isoshade view shells.nrrd -o shells.html\n"
        "  isoshade view shells.nrrd --scene refscenes/shells.scene.json --code fit,region48 --adapt -o shells.html\n"
        "  isoshade plan shells.nrrd --scene refscenes/shells.scene.json --size 96 --brick 8 --levels 3 -o shells.plan.json\n"
        "  isoshade view shells.nrrd --scene refscenes/shells.scene.json --plan shells.plan.json -o planned.html\n",
    .lists = (const iso_names *const[]){&iso_code_names, &iso_tf_preset_names, &iso_viewpoint_names, NULL},
    ISO_COMMAND_OPTIONS(view_arguments, options, .level = -1, .levels = LEVELS, .most = ISO_VIEWER_MOST_VOXELS),
    .run = run,
};

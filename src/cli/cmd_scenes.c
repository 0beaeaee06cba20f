/* SPDX-License-Identifier: MIT */
/* cmd_scenes.c - draws a contact sheet: a volume with several transfer functions and views, and their commands. */
#define _GNU_SOURCE
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/inputs.h"
#include "base/json.h"
#include "base/provenance.h"
#include "base/stamp.h"
#include "cli/contact_sheet.h"
#include "cli/scenes_write.h"
#include "options/cli.h"
#include "options/input.h"
#include "options/look.h"
#include "renderers/renderers.h"
#include "report/gnuplot.h"
#include "scene/subject.h"
#include "scene/viewpoint.h"
#include "scene/visible.h"
#include "tf/presets.h"

enum { MOST_CHOICES = 32, LEVELS = 4, USUAL_PIXELS = 192 };

typedef struct scenes_arguments {
    iso_volume_input input;
    iso_cli_look look; /* only its scene and zoom */
    char *output, **tfs, **views, *write, *suite, *tier;
    int size, levels, steps;
    const iso_cli *cli;
} scenes_arguments;

/* A sheet of one volume. NULL in tfs and views: the scene's own. */
typedef struct sheet {
    const scenes_arguments *arguments;
    const char *tfs[MOST_CHOICES], *views[MOST_CHOICES];
    size_t tf_count, view_count;
    iso_pyramid pyramid;
    iso_survey *survey;
    iso_scene_part visible; /* of the current transfer function */
    iso_renderers renderers;
    iso_contact_sheet pictures;
    json_t *left_out;
} sheet;

/* Copies the values of an option, a list that ends with NULL. ISO_E_USAGE if they are too many. */
static iso_status take(const char *option, char *const *given, const char *kept[MOST_CHOICES], size_t *count,
                       iso_error *err)
{
    size_t all = 0;
    while (given && given[all])
        ++all;
    if (all > MOST_CHOICES)
        return iso_fail(err, ISO_E_USAGE, "%s is given %zu times, at most %d", option, all, MOST_CHOICES);
    for (*count = 0; *count < all; ++*count)
        kept[*count] = given[*count];
    return ISO_OK;
}

/* Returns the options in a picture's command. */
static iso_cli_look look_of(const sheet *s, size_t tf, size_t view, char size[16])
{
    const scenes_arguments *a = s->arguments;
    snprintf(size, 16, "%d", a->size);
    return (iso_cli_look){.scene = a->look.scene,
                          .tf = (char *)s->tfs[tf],
                          .view = (char *)s->views[view],
                          .size = size,
                          .zoom = a->look.zoom};
}

static iso_status check_choice(const sheet *s, size_t tf, size_t view, iso_error *err)
{
    char size[16];
    iso_subject_look look;
    const iso_cli_look asked = look_of(s, tf, view, size);
    return iso_cli_look_check(&asked, s->arguments->cli->threads, &look, err);
}

static iso_status choose(sheet *s, iso_error *err)
{
    static const char *const usual_views[] = {"front", "left", "top", "iso"};
    const scenes_arguments *a = s->arguments;
    iso_status status = take("--view", a->views, s->views, &s->view_count, err);
    TRY(status, take("--tf", a->tfs, s->tfs, &s->tf_count, err));
    if (a->look.scene && !a->views)
        s->views[s->view_count++] = NULL;
    if (a->look.scene && !a->tfs)
        s->tfs[s->tf_count++] = NULL;
    for (size_t i = 0; !a->views && i < sizeof usual_views / sizeof *usual_views; ++i)
        s->views[s->view_count++] = usual_views[i];
    for (size_t i = 0; !a->tfs && i < iso_tf_preset_names.count; ++i)
        s->tfs[s->tf_count++] = iso_names_name(&iso_tf_preset_names, i);
    for (size_t i = 0; i < s->view_count && status == ISO_OK; ++i)
        status = check_choice(s, 0, i, err);
    for (size_t i = 1; i < s->tf_count && status == ISO_OK; ++i)
        status = check_choice(s, i, 0, err);
    return status;
}

static const char *name_of_tf(const sheet *s, size_t tf)
{
    return s->tfs[tf] ? iso_path_base(s->tfs[tf]) : "scene";
}

static const char *name_of_view(const sheet *s, size_t view)
{
    return s->views[view] ? s->views[view] : "scene";
}

/* Returns the command of a picture, for the reader to copy; to be freed. */
static char *command_of(const sheet *s, size_t tf, size_t view, size_t level)
{
    const scenes_arguments *a = s->arguments;
    char number[16], *text = NULL;
    FREED char *input = iso_volume_input_line(&a->input);
    const iso_cli_look asked = look_of(s, tf, view, number);
    FREED char *look = iso_cli_look_line(&asked);
    size_t size = 0;
    FILE *f = look ? open_memstream(&text, &size) : NULL;
    if (f) {
        char name[256];
        fputs("isoshade render ", f);
        iso_words_put_quoted(f, a->cli->arguments[0]);
        fprintf(f, "%s%s", input ? input : "", look);
        if (level > 0)
            fprintf(f, " --level %zu", level);
        fputs(" -o ", f);
        snprintf(name, sizeof name, "%.120s-%.60s.png", name_of_tf(s, tf), name_of_view(s, view));
        iso_words_put_quoted(f, name);
        fclose(f);
    }
    return text;
}

static iso_status view_of(sheet *s, size_t tf, size_t view, iso_view *out, iso_error *err)
{
    char size[16];
    iso_subject_look look;
    const iso_cli_look asked = look_of(s, tf, view, size);
    *out = (iso_view){0};
    const iso_status status = iso_cli_look_take(&asked, s->arguments->cli->threads, &look, err);
    look.survey = s->survey;
    look.visible = &s->visible;
    return status == ISO_OK ? iso_subject_make_view(&look, &s->pyramid, out, err) : status;
}

/* Returns the coarsest level whose voxels are at most 1.5 pixels wide in the middle of the box: finer ones look the
 * same. */
static size_t level_for(const iso_pyramid *p, const iso_view *v)
{
    static const double most_pixels = 1.5;
    const iso_camera *c = &v->camera;
    const iso_vec3 away = iso_sub(iso_geometry_box_center_mm(&p->levels[0].geometry), c->position);
    const double distance = c->orthographic ? 1 : fmax(iso_dot(away, c->forward), 0),
                 pixel_mm = 2 * c->half_height * distance / (double)v->height;
    size_t level = 0;
    while (level + 1 < p->level_count &&
           iso_geometry_min_spacing_mm(&p->levels[level + 1].geometry) <= most_pixels * pixel_mm)
        ++level;
    return level;
}

static iso_status draw_one(sheet *s, size_t tf, size_t view, const iso_view *v, iso_error *err)
{
    iso_render_options opt = iso_render_defaults(iso_renderers_usual());
    iso_progress silent = {0};
    OWNED(iso_image) image = {0};
    opt.threads = s->arguments->cli->threads;
    opt.once = true;
    iso_renderers_choose(&s->pyramid, v, &opt);
    const size_t level = level_for(&s->pyramid, v);
    const iso_render_request request = {&s->renderers, &s->pyramid, level, v, &opt, &silent};
    NEED(iso_render_with(&request, &image, NULL, err));
    FREED char *command = command_of(s, tf, view, level), *label = NULL;
    if (asprintf(&label, "%s, %s", name_of_tf(s, tf), name_of_view(s, view)) < 0)
        label = NULL;
    return command && label ? iso_contact_sheet_add(&s->pictures, &image, label, command, err)
                            : iso_fail(err, ISO_E_MEMORY, "scenes: out of memory");
}

/* Draws one transfer function from all sides. One that shows nothing is left out, and noted. */
static iso_status draw_tf(sheet *s, size_t tf, iso_error *err)
{
    char why[1024];
    s->visible = (iso_scene_part){0};
    for (size_t i = 0; i < s->view_count; ++i) {
        OWNED(iso_view) view = {0};
        NEED(view_of(s, tf, i, &view, err));
        if (i == 0) {
            const iso_visible visible = iso_visible_measure(&s->pyramid.levels[0], &view, NULL,
                                                            s->arguments->cli->threads);
            if (iso_visible_complaint(&visible, s->arguments->cli->arguments[0], why, sizeof why)) {
                json_array_append_new(s->left_out, json_pack("{s:s, s:s}", "tf", name_of_tf(s, tf), "why", why));
                return ISO_OK;
            }
        }
        NEED(draw_one(s, tf, i, &view, err));
    }
    return ISO_OK;
}

static iso_status draw_all(sheet *s, const iso_progress *progress, iso_error *err)
{
    for (size_t t = 0; t < s->tf_count; ++t) {
        iso_progress_report(progress, "pictures", (double)t / (double)s->tf_count);
        NEED(draw_tf(s, t, err));
    }
    if (s->pictures.count == 0)
        return iso_fail(err, ISO_E_RANGE, "none of the transfer functions shows anything; %s: %s", name_of_tf(s, 0),
                        json_string_value(json_object_get(json_array_get(s->left_out, 0), "why")));
    return ISO_OK;
}

/* Returns "sheet.json" for "sheet.png"; to be freed. */
static char *json_path(const char *output)
{
    char *path = NULL;
    return asprintf(&path, "%.*s.json", (int)(strrchr(output, '.') - output), output) < 0 ? NULL : path;
}

static iso_status save_json(const sheet *s, const json_t *root, iso_error *err)
{
    FREED char *path = json_path(s->arguments->output);
    return path ? iso_json_save(path, root, err) : iso_fail(err, ISO_E_MEMORY, "scenes: out of memory");
}

/* True if a file lists the pictures of a sheet, as report() writes it. */
static bool is_of_a_sheet(const char *path)
{
    json_auto_t *root = NULL;
    const bool found = iso_json_load(path, &root, NULL) == ISO_OK && json_object_get(root, "sheet") &&
                       json_object_get(root, "pictures");
    return found;
}

static iso_status guard_json(const char *output, iso_error *err)
{
    FREED char *path = json_path(output);
    NEED(path ? iso_inputs_announce(path, err) : iso_fail(err, ISO_E_MEMORY, "scenes: out of memory"));
    return iso_stamp_guard_adjacent(path, is_of_a_sheet(path), err);
}

static iso_status report(const sheet *s, iso_error *err)
{
    const scenes_arguments *a = s->arguments;
    json_t *left_out;
    json_auto_t *root = iso_cli_json(a->cli);
    size_t i;
    json_object_set_new(root, "sheet", json_string(a->output));
    json_object_set_new(root, "pictures", iso_contact_sheet_to_json(&s->pictures));
    json_object_set(root, "left_out", s->left_out);
    NEED(save_json(s, root, err));
    if (a->cli->json) {
        iso_cli_print_json(json_incref(root));
        return ISO_OK;
    }
    for (i = 0; i < s->pictures.count; ++i)
        printf("%2zu  %s\n", i + 1, s->pictures.panels[i].command);
    json_array_foreach (s->left_out, i, left_out)
        printf("left out: %s: %s\n", json_string_value(json_object_get(left_out, "tf")),
               json_string_value(json_object_get(left_out, "why")));
    printf("%s: %zu picture%s; without --size and --level a command makes a larger and finer one\n", a->output,
           s->pictures.count, iso_words_plural(s->pictures.count));
    return ISO_OK;
}

static iso_status draw_sheet(const scenes_arguments *a, iso_error *err)
{
    iso_progress progress = iso_cli_progress(a->cli);
    iso_pyramid_options build = iso_pyramid_defaults();
    sheet s = {.arguments = a, .left_out = json_array()};
    iso_cli_expect(a->cli, (const iso_cli_stage[]){{"pyramid", 2}, {"pictures", 3}}, 2);
    build.threads = a->cli->threads;
    build.level_count = LEVELS;
    iso_status status = a->output ? iso_words_check_range("--size", a->size, 32, 1024, err)
                                  : iso_fail(err, ISO_E_USAGE, "-o is missing: picture to write, .png, .svg or .pdf");
    if (status == ISO_OK && !iso_gnuplot_ending(a->output))
        status = iso_fail(err, ISO_E_USAGE, "%s: must end in .png, .svg or .pdf", a->output);
    TRY(status, choose(&s, err));
    if (status == ISO_OK) /* after reading the options: an input must be known before the check */
        status = guard_json(a->output, err);
    TRY(status, iso_subject_load_pyramid(a->cli->arguments[0], &a->input, &build, &progress, &s.pyramid, err));
    TRY(status, iso_survey_make(&s.pyramid.levels[0], a->cli->threads, &s.survey, err));
    TRY(status, draw_all(&s, &progress, err));
    if (status == ISO_OK) {
        char title[256];
        snprintf(title, sizeof title, "%.200s", iso_provenance_title(a->cli->arguments[0]));
        status = iso_contact_sheet_draw(&s.pictures, s.view_count, title, a->output, err);
    }
    TRY(status, report(&s, err));
    iso_contact_sheet_destroy(&s.pictures);
    iso_renderers_end(&s.renderers);
    iso_pyramid_destroy(&s.pyramid);
    free(s.survey);
    json_decref(s.left_out);
    return status;
}

/* Writes requests for one scene: with at most one transfer function and one view. */
static iso_status write_requests(const scenes_arguments *a, iso_error *err)
{
    char size[16];
    if (a->output)
        return iso_fail(err, ISO_E_USAGE, "-o and --write exclude each other: a sheet, or requests");
    if ((a->tfs && a->tfs[0] && a->tfs[1]) || (a->views && a->views[0] && a->views[1]))
        return iso_fail(err, ISO_E_USAGE, "--write takes one --tf and one --view");
    snprintf(size, sizeof size, "%d", a->size);
    iso_status status = a->size ? iso_words_check_range("--size", a->size, 1, 16384, err) : ISO_OK;
    const iso_scenes_write w = {.cli = a->cli,
                                .input = &a->input,
                                .look = {.scene = a->look.scene,
                                         .tf = a->tfs ? a->tfs[0] : NULL,
                                         .view = a->views ? a->views[0] : NULL,
                                         .zoom = a->look.zoom,
                                         .size = a->size ? size : NULL},
                                .dir = a->write,
                                .suite = a->suite,
                                .tier = a->tier,
                                .levels = a->levels,
                                .steps = a->steps};
    return status == ISO_OK ? iso_scenes_write_all(&w, err) : status;
}

static iso_status check_sheet(scenes_arguments *a, iso_error *err)
{
    if (a->suite || a->tier || a->levels || a->steps != -1)
        return iso_fail(err, ISO_E_USAGE, "--suite, --tier, --levels and --steps need --write");
    if (a->cli->argument_count != 1)
        return iso_fail(err, ISO_E_USAGE, "a volume or a pyramid is missing");
    a->size = a->size ? a->size : USUAL_PIXELS;
    return ISO_OK;
}

static const iso_option options[] = {
    {"output", 'o', "sheet to write: .png, .svg or .pdf, and commands in a .json", "FILE",
     ISO_IN(scenes_arguments, output)},
    ISO_OPTIONS_OF(scenes_arguments, look, iso_scene_rows),
    {"tf", 0, "transfer function: a file or preset; repeatable (the scene's and all presets)", "FILE|PRESET",
     ISO_IN(scenes_arguments, tfs)},
    {"view", 0, "view direction: a name or degrees; repeatable (the scene's; front, left, top, iso)", "NAME|AZ,EL",
     ISO_IN(scenes_arguments, views)},
    ISO_OPTIONS_OF(scenes_arguments, look, iso_zoom_rows),
    {"size", 0, "pixels per side of a picture (192; --write: the scene's)", "N", ISO_IN(scenes_arguments, size),
     .flags = ISO_NOT_ZERO},
    {"write", 0, "write requests to render elsewhere, for validate --images, instead of a sheet", "DIR",
     ISO_IN(scenes_arguments, write)},
    {"suite", 0, "--write: use the scenes of a folder, with their volumes", "DIR", ISO_IN(scenes_arguments, suite)},
    {"levels", 0, "--write: number of levels, including the finest (4; suites 1)", "N",
     ISO_IN(scenes_arguments, levels), .flags = ISO_NOT_ZERO, .least = 1, .most = 16},
    {"steps", 0, "--write: number of smaller steps, each half the one before; 0: none (4)", "N",
     ISO_IN(scenes_arguments, steps), .most = 12},
    {"tier", 0, "--write: agreement of the pictures: samples, limit or \"8 bits\" (samples)", "TIER",
     ISO_IN(scenes_arguments, tier)},
    ISO_OPTIONS_OF(scenes_arguments, input, iso_input_rows),
    ISO_OPTIONS_END,
};

static iso_status run(const iso_cli *cli, void *values, iso_error *err)
{
    scenes_arguments *a = values;
    a->cli = cli;
    iso_status status = a->write ? write_requests(a, err) : check_sheet(a, err);
    return status == ISO_OK && !a->write ? draw_sheet(a, err) : status;
}

const iso_command iso_command_scenes = {
    .name = "scenes",
    .summary = "draw a contact sheet of a volume: presets and views to choose from, each with its command",
    .max_arguments = 1,
    .usage =
        "VOLUME|PYRAMID.iso -o SHEET.png [--tf PRESET ...] [--view NAME ...] [options] | [VOLUME] --write DIR [options]",
    .details =
        "Every picture has a number; its command is printed, and stored with the picture's place in SHEET.json.\n"
        "The command makes the same picture; without its --size, a larger one. Large volumes are drawn at a level whose voxels are\n"
        "about a pixel wide: --level in the command. Transfer functions that show almost nothing of the volume, or only an opaque\n"
        "box, are listed as left out, with the reason.\n"
        "--write DIR writes requests for one scene or a suite instead: one folder per scene, level and calibration, with\n"
        "request.json, volume.nrrd and directions.nrrd, and DIR/README.txt, which lists the requested pictures with their\n"
        "sizes and steps. Put the pictures of your renderer there; isoshade validate --images NAME=DIR compares them.",
    .common = "output tf view size write suite levels spacing threads",
    .examples =
        "  isoshade make shells --size 48 -o shells.nrrd\n"
        "  isoshade scenes shells.nrrd --size 96 -o sheet.png\n"
        "  isoshade scenes shells.nrrd --tf auto --tf simulation --view front --view 30,20 --size 64 -o two.png\n"
        "  isoshade scenes shells.nrrd --scene refscenes/shells.scene.json --view top --zoom 1.5 --size 64 -o lit.png\n"
        "  isoshade scenes shells.nrrd --scene refscenes/shells.scene.json --size 24 --levels 1 --write elsewhere\n",
    .lists = (const iso_names *const[]){&iso_tf_preset_names, &iso_viewpoint_names, NULL},
    ISO_COMMAND_OPTIONS(scenes_arguments, options, .steps = -1),
    .run = run,
};

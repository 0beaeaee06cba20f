/* SPDX-License-Identifier: MIT */
/* cmd_scenes.c - draws a contact sheet: a volume with several transfer functions and views, and their commands. */
#define _GNU_SOURCE
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/inputs.h"
#include "base/json.h"
#include "base/provenance.h"
#include "base/stamp.h"
#include "cli/scenes_write.h"
#include "compare/srgb.h"
#include "image/image.h"
#include "options/cli.h"
#include "options/input.h"
#include "options/look.h"
#include "renderers/renderers.h"
#include "report/gnuplot.h"
#include "scene/subject.h"
#include "scene/viewpoint.h"
#include "scene/visible.h"
#include "tf/presets.h"

/* A sheet of many small pictures with numbers and names, drawn by gnuplot:
 *
 *     +---------+---------+--------  columns: a multiple of `group`, so that a group stays in one row
 *     | picture | picture |
 *     | 1 label | 2 label | */
typedef struct contact_sheet {
    size_t count, room;
    struct contact_panel {
        unsigned char *rgb; /* display colors; row 0 is the top */
        size_t left, top;   /* position in the sheet's pixels, set by contact_sheet_draw() */
        char *label, *command;
    } * panels;
    size_t side; /* of each square picture, in pixels */
} contact_sheet;

/* Distances in pixels of a PNG; all even, because gnuplot gets their halves. */
enum { GAP = 10, LABEL = 24, HEAD = 40 };

/* Adds a square picture of the same size as the others. ISO_E_RANGE, ISO_E_MEMORY. */
static iso_status contact_sheet_add(contact_sheet *s, const iso_image *image, const char *label, const char *command,
                                    iso_error *err)
{
    const size_t pixels = image->width * image->height;
    if (image->width != image->height || (s->count > 0 && image->width != s->side))
        return iso_fail(err, ISO_E_RANGE,
                        "sheet: a picture has %zu x %zu pixels, must be a square of the same size as the others",
                        image->width, image->height);
    if (s->count == s->room) {
        const size_t room = s->room ? 2 * s->room : 16;
        void *panels = realloc(s->panels, room * sizeof *s->panels);
        NEED_MEMORY(panels, err, "sheet: out of memory");
        s->panels = panels, s->room = room;
    }
    struct contact_panel *p = &s->panels[s->count];
    *p = (struct contact_panel){.rgb = malloc(3 * pixels), .label = strdup(label), .command = strdup(command)};
    s->side = image->width;
    ++s->count;
    NEED_MEMORY(p->rgb && p->label && p->command, err, "sheet: out of memory");
    for (size_t i = 0; i < 3 * pixels; ++i)
        p->rgb[i] = (unsigned char)(iso_srgb_encode((double)image->rgba[4 * (i / 3) + i % 3]) * 255 + 0.5);
    return ISO_OK;
}

typedef struct mosaic {
    const contact_sheet *sheet;
    const char *title, *raw;
    size_t columns, width, height;
    unsigned char *rgb;
} mosaic;

/* Returns the number of columns: whole groups, so that the sheet is about 1.5 times as wide as high. */
static size_t choose_columns(const contact_sheet *s, size_t group)
{
    const size_t groups = (s->count + group - 1) / group;
    size_t best = 1;
    double least = INFINITY;
    for (size_t k = 1; k <= groups; ++k) {
        const double shape = (double)(k * group) / ceil((double)groups / (double)k), off = fabs(log(shape / 1.5));
        if (off < least)
            least = off, best = k;
    }
    return best * group;
}

static void place(contact_sheet *s, mosaic *m)
{
    const size_t rows = (s->count + m->columns - 1) / m->columns, side = s->side + s->side % 2;
    m->width = m->columns * (side + GAP) + GAP;
    m->height = HEAD + rows * (side + LABEL + GAP);
    memset(m->rgb, 255, 3 * m->width * m->height);
    for (size_t i = 0; i < s->count; ++i) {
        struct contact_panel *p = &s->panels[i];
        p->left = GAP + i % m->columns * (side + GAP);
        p->top = HEAD + i / m->columns * (side + LABEL + GAP);
        for (size_t y = 0; y < s->side; ++y)
            memcpy(m->rgb + 3 * ((p->top + y) * m->width + p->left), p->rgb + 3 * y * s->side, 3 * s->side);
    }
}

static iso_status write_sheet(FILE *gp, void *user, iso_error *err)
{
    const mosaic *m = user;
    const contact_sheet *s = m->sheet;
    /* font size at which the longest names of presets and views fit below a picture */
    const double points = 5.5 * fmin(1, (double)s->side / 176);
    (void)err;
    fprintf(gp,
            "set lmargin 0\nset rmargin 0\nset tmargin 0\nset bmargin 0\nunset border\nunset tics\nunset key\n"
            "set xrange [-0.5:%zu.5]\nset yrange [-0.5:%zu.5]\n",
            m->width - 1, m->height - 1);
    fputs("set label ", gp);
    iso_gnuplot_put_quoted(gp, m->title);
    fprintf(gp, " at %d,%zu left front noenhanced font ',8'\n", GAP, m->height - HEAD / 2 - 2);
    for (size_t i = 0; i < s->count; ++i) {
        char text[160];
        snprintf(text, sizeof text, "%zu  %.120s", i + 1, s->panels[i].label);
        fputs("set label ", gp);
        iso_gnuplot_put_quoted(gp, text);
        fprintf(gp, " at %zu,%zu left front noenhanced font ',%.2f'\n", s->panels[i].left,
                m->height - (s->panels[i].top + s->side + LABEL / 2 + 1), points);
    }
    fputs("plot ", gp);
    iso_gnuplot_put_quoted(gp, m->raw);
    fprintf(gp, " binary array=(%zu,%zu) flip=y format='%%3uchar' using 1:2:3 with rgbimage\n", m->width, m->height);
    return ISO_OK;
}

/* Draws the sheet. group: number of pictures that stay in one row. Errors as of iso_gnuplot_picture(). A PNG has the
 * pictures pixel by pixel. */
static iso_status contact_sheet_draw(contact_sheet *s, size_t group, const char *title, const char *output,
                                     iso_error *err)
{
    const size_t columns = choose_columns(s, group), rows = (s->count + columns - 1) / columns;
    ENDED_BY(iso_end_temp_dir) char *dir = iso_make_temp_dir();
    FREED char *raw = dir ? iso_path_join(dir, "sheet.raw") : NULL;
    FREED unsigned char *rgb = malloc(3 * (columns * (s->side + 1 + GAP) + GAP) *
                                      (HEAD + rows * (s->side + 1 + LABEL + GAP)));
    mosaic m = {.sheet = s, .title = title, .columns = columns, .raw = raw, .rgb = rgb};
    if (!dir)
        return iso_temp_dir_fail(err);
    NEED_MEMORY(raw && rgb, err, "sheet: out of memory");
    place(s, &m);
    NEED(iso_file_write(raw, m.rgb, 3 * m.width * m.height, err));
    return iso_gnuplot_picture(output, (double)m.width / 2, (double)m.height / 2, write_sheet, &m, err);
}

/* Returns [{"number": 1, "label", "command", "left", "top", "size"}]. */
static json_t *contact_sheet_to_json(const contact_sheet *s)
{
    json_t *list = json_array();
    for (size_t i = 0; i < s->count; ++i) {
        const struct contact_panel *p = &s->panels[i];
        FREED char *command = iso_provenance_line(p->command);
        json_array_append_new(list, json_pack("{s:I, s:s, s:s, s:I, s:I, s:I}", "number", (json_int_t)(i + 1), "label",
                                              p->label, "command", command ? command : "", "left", (json_int_t)p->left,
                                              "top", (json_int_t)p->top, "size", (json_int_t)s->side));
    }
    return list;
}

static void contact_sheet_destroy(contact_sheet *s)
{
    for (size_t i = 0; i < s->count; ++i) {
        free(s->panels[i].rgb);
        free(s->panels[i].label);
        free(s->panels[i].command);
    }
    free(s->panels);
    *s = (contact_sheet){0};
}

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
    contact_sheet pictures;
    json_t *left_out;
} sheet;

static void sheet_destroy(sheet *s)
{
    contact_sheet_destroy(&s->pictures);
    iso_renderers_end(&s->renderers);
    iso_pyramid_destroy(&s->pyramid);
    free(s->survey);
    json_decref(s->left_out);
}

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
    NEED(take("--view", a->views, s->views, &s->view_count, err));
    NEED(take("--tf", a->tfs, s->tfs, &s->tf_count, err));
    if (a->look.scene && !a->views)
        s->views[s->view_count++] = NULL;
    if (a->look.scene && !a->tfs)
        s->tfs[s->tf_count++] = NULL;
    for (size_t i = 0; !a->views && i < sizeof usual_views / sizeof *usual_views; ++i)
        s->views[s->view_count++] = usual_views[i];
    for (size_t i = 0; !a->tfs && i < iso_tf_preset_names.count; ++i)
        s->tfs[s->tf_count++] = iso_names_name(&iso_tf_preset_names, i);
    for (size_t i = 0; i < s->view_count; ++i)
        NEED(check_choice(s, 0, i, err));
    for (size_t i = 1; i < s->tf_count; ++i)
        NEED(check_choice(s, i, 0, err));
    return ISO_OK;
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
    return command && label ? contact_sheet_add(&s->pictures, &image, label, command, err)
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
    json_object_set_new(root, "pictures", contact_sheet_to_json(&s->pictures));
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
    OWNED(sheet) s = {.arguments = a, .left_out = json_array()};
    char title[256];
    iso_cli_expect(a->cli, (const iso_cli_stage[]){{"pyramid", 2}, {"pictures", 3}}, 2);
    build.threads = a->cli->threads;
    build.level_count = LEVELS;
    if (!a->output)
        return iso_fail(err, ISO_E_USAGE, "-o is missing: picture to write, .png, .svg or .pdf");
    NEED(iso_words_check_range("--size", a->size, 32, 1024, err));
    if (!iso_gnuplot_ending(a->output))
        return iso_fail(err, ISO_E_USAGE, "%s: must end in .png, .svg or .pdf", a->output);
    NEED(choose(&s, err));
    NEED(guard_json(a->output, err)); /* after reading the options: an input must be known before the check */
    NEED(iso_subject_load_pyramid(a->cli->arguments[0], &a->input, &build, &progress, &s.pyramid, err));
    NEED(iso_survey_make(&s.pyramid.levels[0], a->cli->threads, &s.survey, err));
    NEED(draw_all(&s, &progress, err));
    snprintf(title, sizeof title, "%.200s", iso_provenance_title(a->cli->arguments[0]));
    NEED(contact_sheet_draw(&s.pictures, s.view_count, title, a->output, err));
    return report(&s, err);
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
    if (a->write)
        return write_requests(a, err);
    NEED(check_sheet(a, err));
    return draw_sheet(a, err);
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

/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "cli/scenes_write.h"

#include <dirent.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/file.h"
#include "base/json.h"
#include "base/provenance.h"
#include "base/words.h"
#include "cli/made_volume.h"
#include "pyramid/pyramid.h"
#include "renderers/external.h"
#include "renderers/pictures.h"
#include "renderers/request.h"
#include "scene/scene.h"
#include "scene/subject.h"
#include "validate/calibrate.h"
#include "validate/validate.h"

/* ---- requests ---- */

/* Requests for a renderer on another machine (renderers/request.h): a folder for each scene and level and
 * for each calibration, and an index and a text that list the wanted pictures (renderers/pictures.h). */
typedef struct iso_elsewhere {
    const char *dir;  /* an existing folder */
    const char *tier; /* "samples", "limit" or "8 bits" */
    size_t steps;     /* number of pictures, each at half the step of the one before, for the limit; 0: none */
    json_t *pictures; /* requested pictures, as in pictures.json; owned by the caller that began it */
    json_t *left_out; /* scenes for which a request has no words: each "scene", "why" */
} iso_elsewhere;

enum { MOST_FRAMES = 13 };

/* The pictures of one scene and level. */
typedef struct wanted {
    iso_request_frame frames[MOST_FRAMES];
    char names[MOST_FRAMES][ISO_PICTURE_NAME_BYTES];
    size_t count;
} wanted;

static void want(wanted *w, double step_voxels)
{
    iso_picture_file(step_voxels, w->names[w->count]);
    w->frames[w->count] = (iso_request_frame){.step_voxels = step_voxels, .file = w->names[w->count]};
    ++w->count;
}

static json_t *wanted_json(const wanted *w, const iso_view *view, const iso_level *level)
{
    json_t *files = json_array();
    const double voxel_mm = iso_geometry_min_spacing_mm(&level->geometry);
    for (size_t i = 0; i < w->count; ++i) {
        const double step = w->frames[i].step_voxels > 0 ? w->frames[i].step_voxels : view->step_voxels;
        json_array_append_new(files, json_pack("{s:s, s:f, s:f}", "file", w->names[i], "step_voxels", step, "step_mm",
                                               step * voxel_mm));
    }
    return files;
}

/* Writes the folder of a scene's level, with its request. */
static iso_status write_request(const iso_elsewhere *e, const iso_pyramid *p, size_t level, const iso_view *view,
                                const char *scene, const wanted *w, iso_error *err)
{
    char folder[ISO_PICTURE_NAME_BYTES];
    const iso_request request = {
        .scene = scene, .pyramid = p, .level = level, .view = view, .frames = w->frames, .frame_count = w->count};
    iso_picture_folder(scene, level, folder);
    FREED char *path = iso_path_join(e->dir, folder);
    if (!path || mkdir(path, 0777) != 0)
        return iso_fail(err, iso_errno_status(), "%s/%s: cannot be created: %s", e->dir, folder, strerror(errno));
    NEED(iso_request_write(&request, path, err));
    json_array_append_new(e->pictures,
                          json_pack("{s:s, s:s, s:I, s:[I,I], s:o}", "folder", folder, "scene", scene, "level",
                                    (json_int_t)level, "size", (json_int_t)view->width, (json_int_t)view->height,
                                    "files", wanted_json(w, view, &p->levels[level])));
    return ISO_OK;
}

/* Requests steps, each half the one before. The first two are those with which the search for a limit begins. */
static void want_steps(const iso_elsewhere *e, const iso_scene_agreement *asked, wanted *w)
{
    const iso_renderer_info any = {.step_count = e->steps};
    const double first = 2 * iso_validate_limit_options(asked, &any, 2, 1).step_voxels;
    for (size_t i = 0; i < e->steps && w->count < MOST_FRAMES; ++i)
        want(w, ldexp(first, -(int)i));
}

static const char *why_left_out(const iso_scene *scene, const iso_view *view)
{
    return scene->agreement.tier == ISO_TIER_FIRST_HIT ? "it asks for first hits, a request for volumes"
           : view->tf_2d                               ? "a request has no words for its 2D transfer function"
           : view->extinction_scale                    ? "a request has no words for its extinction scales"
           : view->roi                                 ? "a request has no words for its region of interest"
                                                       : NULL;
}

/* Writes the levels of a scene. view: the scene resolved for the pyramid. */
static iso_status elsewhere_write_scene(const iso_elsewhere *e, const iso_pyramid *p, const iso_scene *scene,
                                        const iso_view *view, const char *name, iso_error *err)
{
    iso_scene_agreement asked = scene->agreement;
    const char *why = why_left_out(scene, view);
    wanted w = {.count = 0};
    if (why) {
        json_array_append_new(e->left_out, json_pack("{s:s, s:s}", "scene", name, "why", why));
        return ISO_OK;
    }
    iso_validate_assume(&p->levels[0], view, &asked);
    if (strcmp(e->tier, "limit") != 0)
        want(&w, 0);
    want_steps(e, &asked, &w);
    for (size_t level = 0; level < p->level_count; ++level)
        NEED(write_request(e, p, level, view, name, &w, err));
    return ISO_OK;
}

/* ---- calibrations: a renderer that writes requests and draws nothing ---- */

static iso_status write_instead(const iso_render_request *q, iso_image *image, iso_render_stats *stats, iso_error *err)
{
    const iso_elsewhere *e = q->options->renderer->data;
    wanted w = {.count = 0};
    (void)stats;
    want(&w, q->options->step_voxels);
    iso_status status = write_request(e, q->pyramid, q->level, q->view, q->renderers->scene, &w, err);
    return status == ISO_OK ? iso_image_create(image, q->view->width, q->view->height, err) : status;
}

static iso_status elsewhere_write_calibrations(const iso_elsewhere *e, iso_error *err)
{
    const iso_renderer_info writer = {.name = "elsewhere",
                                      .title = "requests",
                                      .traits = ISO_EXTERNAL_TRAITS | ISO_HAS_ALL_SCENES | ISO_HAS_LABELS,
                                      .data = e,
                                      .render = write_instead};
    iso_calibration unused;
    iso_renderers renderers = {0};
    for (int i = 0; i < ISO_CALIBRATION_COUNT; ++i)
        NEED(iso_calibrate_check(&renderers, &writer, NULL, i, &unused, err));
    return ISO_OK;
}

/* ---- the index, and the text for people ---- */

static iso_status write_index(const iso_elsewhere *e, const char *command, iso_error *err)
{
    FREED char *path = iso_path_join(e->dir, ISO_PICTURES_INDEX);
    json_auto_t *root = json_pack("{s:s, s:s, s:s, s:I, s:O}", "schema", ISO_PICTURES_SCHEMA, "command", command,
                                  "tier", e->tier, "steps", (json_int_t)e->steps, "pictures", e->pictures);
    return path && root ? iso_json_save(path, root, err) : iso_fail(err, ISO_E_MEMORY, "out of memory");
}

static void put_wanted(FILE *f, const json_t *pictures)
{
    size_t i, k;
    json_t *one, *file;
    json_array_foreach ((json_t *)pictures, i, one) {
        const json_t *size = json_object_get(one, "size");
        json_array_foreach (json_object_get(one, "files"), k, file)
            fprintf(f, "    %s/%s  %lld x %lld pixels, step %.9g mm (%.9g voxels)\n",
                    json_string_value(json_object_get(one, "folder")), json_string_value(json_object_get(file, "file")),
                    (long long)json_integer_value(json_array_get(size, 0)),
                    (long long)json_integer_value(json_array_get(size, 1)),
                    json_number_value(json_object_get(file, "step_mm")),
                    json_number_value(json_object_get(file, "step_voxels")));
    }
}

static void put_readme(FILE *f, const iso_elsewhere *e, const char *validate)
{
    size_t i;
    json_t *one;
    fputs("Requested pictures\n"
          "==================\n\n"
          "Each folder holds one request: request.json describes the picture, volume.nrrd has the values and\n"
          "directions.nrrd, if a light is visible, their directions. isoshade's doc/reference/files-request.md\n"
          "has the keys, doc/guide/numpy_renderer.py is a short renderer that reads them.\n\n"
          "Draw these, and leave each where its request lies: OpenEXR, 32-bit float, channels R G B A, linear light,\n"
          "color multiplied by alpha, background included, of exactly that size; or as .npy or .pfm, by that page:\n\n",
          f);
    put_wanted(f, e->pictures);
    fprintf(
        f,
        "\npicture.exr takes the midpoints of the steps as samples, step-H.exr is the same at a step of H voxels%s\n"
        "calibration-* are tiny scenes whose pictures are known by a formula. Without them the validation cannot find the\n"
        "faults that each of them detects. Pictures of one level may be missing; each is then named.\n\n"
        "A renderer of that interface draws all of it:\n\n"
        "    for request in */request.json; do (cd \"${request%%/*}\" && RENDERER \"$PWD/request.json\"); done\n\n"
        "Then, in the volume's folder:\n\n    %s\n\n"
        "pictures.json may be edited to set the limits of the pictures: \"tier\" (\"samples\", \"limit\" or \"8 bits\"),\n"
        "\"bits\", \"half\", \"limits\" ({\"rmse\", \"max_abs\"}) with \"why\", and \"title\", as in renderers.json\n"
        "(doc/reference/files-request.md).\n",
        e->steps ? ",\nfor the limit of small steps." : ".", validate);
    json_array_foreach (e->left_out, i, one)
        fprintf(f, "\nLeft out: %s: %s.\n", json_string_value(json_object_get(one, "scene")),
                json_string_value(json_object_get(one, "why")));
}

/* Writes pictures.json and README.txt. command: the line that made them; validate: the line that compares the
 * pictures. */
static iso_status elsewhere_finish(const iso_elsewhere *e, const char *command, const char *validate, iso_error *err)
{
    FREED char *path = iso_path_join(e->dir, "README.txt"), *text = NULL;
    size_t size = 0;
    FILE *f = path ? open_memstream(&text, &size) : NULL;
    iso_status status = f ? write_index(e, command, err) : iso_fail(err, ISO_E_MEMORY, "out of memory");
    if (f) {
        put_readme(f, e, validate);
        if (fclose(f) != 0 && status == ISO_OK)
            status = iso_fail(err, ISO_E_MEMORY, "out of memory");
    }
    TRY(status, iso_file_write(path, text, size, err));
    return status;
}

enum { USUAL_STEPS = 4, USUAL_LEVELS = 4 };
static const char scene_ending[] = ".scene.json";

/* State of writing requests. */
typedef struct writing {
    const iso_scenes_write *asked;
    iso_output out;
    iso_elsewhere elsewhere;
} writing;

static void writing_destroy(writing *w)
{
    iso_output_abandon(&w->out);
    json_decref(w->elsewhere.pictures);
    json_decref(w->elsewhere.left_out);
}

static char *name_of_scene(const char *path)
{
    const char *base = iso_path_base(path);
    const size_t length = strlen(base), ending = strlen(scene_ending);
    return strndup(base, length > ending && iso_path_ends_with(base, scene_ending) ? length - ending : length);
}

/* Writes the request of a scene for a pyramid, in the size that the options give. */
static iso_status write_scene(const writing *w, iso_scene *scene, const iso_pyramid *p, const char *name,
                              iso_error *err)
{
    OWNED(iso_view) view = {0};
    if (w->asked->look.size)
        NEED(iso_subject_parse_image_size(w->asked->look.size, &scene->width, &scene->height, err));
    NEED(iso_scene_resolve(scene, &p->levels[0].geometry, iso_pyramid_lo(p), iso_pyramid_hi(p), &view, err));
    return elsewhere_write_scene(&w->elsewhere, p, scene, &view, name, err);
}

static iso_pyramid_options options_of(const iso_scenes_write *a, size_t usual_levels)
{
    iso_pyramid_options build = iso_pyramid_defaults();
    build.threads = a->cli->threads;
    build.level_count = a->levels > 0 ? (size_t)a->levels : usual_levels;
    return build;
}

/* ---- a volume ---- */

static bool has_own_scene(const iso_cli_look *look)
{
    return !look->scene || look->tf || look->view || look->zoom;
}

/* Saves a scene without a file as DIR/scene.scene.json, and reads it again so that both are equal. */
static iso_status keep_scene(const writing *w, iso_scene *scene, iso_error *err)
{
    json_auto_t *root = iso_scene_to_json(scene);
    FREED char *path = iso_path_join(w->out.temp_path, "scene.scene.json");
    iso_scene_destroy(scene);
    NEED(root && path ? iso_scene_save_json(root, path, err) : iso_fail(err, ISO_E_MEMORY, "out of memory"));
    return iso_scene_load(path, scene, err);
}

static iso_status write_volume(const writing *w, iso_error *err)
{
    const iso_scenes_write *a = w->asked;
    const iso_pyramid_options build = options_of(a, USUAL_LEVELS);
    iso_progress progress = iso_cli_progress(a->cli);
    OWNED(iso_pyramid) pyramid = {0};
    OWNED(iso_scene) scene = {0};
    iso_subject_look look;
    const bool own = has_own_scene(&a->look);
    FREED char *name = own ? strdup("scene") : name_of_scene(a->look.scene);
    NEED(name ? iso_cli_look_check(&a->look, a->cli->threads, &look, err)
              : iso_fail(err, ISO_E_MEMORY, "out of memory"));
    NEED(iso_subject_load_pyramid(a->cli->arguments[0], a->input, &build, &progress, &pyramid, err));
    NEED(iso_subject_make_scene(&look, &pyramid, &scene, err));
    if (own)
        NEED(keep_scene(w, &scene, err));
    return write_scene(w, &scene, &pyramid, name, err);
}

/* ---- a suite ---- */

static int is_scene(const struct dirent *entry)
{
    return entry->d_name[0] != '.' && iso_path_ends_with(entry->d_name, scene_ending);
}

static iso_status write_suite_scene(const writing *w, const char *file, const char *volume, iso_error *err)
{
    const iso_volume_input plain = {0};
    const iso_pyramid_options build = options_of(w->asked, 1);
    OWNED(iso_scene) scene = {0};
    OWNED(iso_pyramid) pyramid = {0};
    FREED char *path = iso_path_join(w->asked->suite, file), *name = name_of_scene(file);
    NEED(path && name ? iso_scene_load(path, &scene, err) : iso_fail(err, ISO_E_MEMORY, "out of memory"));
    if (!scene.suite_make)
        return iso_fail(err, ISO_E_FORMAT, "%s: has no \"suite\", which names its volume", path);
    const iso_status status = iso_cli_make_volume(scene.suite_make, volume, err);
    if (status != ISO_OK)
        return iso_fail_in(err, status, "%s", path);
    NEED(iso_subject_load_pyramid(volume, &plain, &build, NULL, &pyramid, err));
    return write_scene(w, &scene, &pyramid, name, err);
}

static iso_status write_suite(const writing *w, iso_error *err)
{
    struct dirent **entries;
    const int count = scandir(w->asked->suite, &entries, is_scene, alphasort);
    if (count < 0)
        return iso_fail(err, iso_errno_status(), "%s: cannot be listed: %s", w->asked->suite, strerror(errno));
    ENDED_BY(iso_end_temp_dir) char *scratch = iso_make_temp_dir();
    FREED char *volume = scratch ? iso_path_join(scratch, "volume.nrrd") : NULL;
    iso_status status = volume ? ISO_OK : iso_temp_dir_fail(err);
    if (status == ISO_OK && count == 0)
        status = iso_fail(err, ISO_E_USAGE, "%s: the folder has no .scene.json", w->asked->suite);
    for (int i = 0; i < count; ++i) {
        TRY(status, write_suite_scene(w, entries[i]->d_name, volume, err));
        free(entries[i]);
    }
    free(entries);
    return status;
}

/* ---- all requests ---- */

/* Returns the command that compares the pictures; to be freed. */
static char *validate_line(const iso_scenes_write *a)
{
    char *line = NULL;
    size_t size = 0;
    FILE *f = open_memstream(&line, &size);
    if (!f)
        return NULL;
    fputs("isoshade validate ", f);
    if (a->suite) {
        fputs("--suite ", f);
        iso_provenance_put_word(f, a->suite);
    } else {
        iso_provenance_put_word(f, a->cli->arguments[0]);
        fputs(" --scene ", f);
        if (has_own_scene(&a->look)) {
            iso_provenance_put_word(f, a->dir);
            fputs("/scene.scene.json", f);
        } else {
            iso_provenance_put_word(f, a->look.scene);
        }
    }
    if (a->levels > 0)
        fprintf(f, " --levels %d", a->levels);
    if (a->look.size)
        fprintf(f, " --size %s", a->look.size);
    fputs(" --images NAME=", f);
    iso_provenance_put_word(f, a->dir);
    fputs(" -o report", f);
    fclose(f);
    return line;
}

static iso_status check(const iso_scenes_write *a, iso_error *err)
{
    static const char *const tiers[] = {"samples", "limit", "8 bits"};
    bool known = !a->tier;
    for (size_t i = 0; a->tier && i < sizeof tiers / sizeof *tiers; ++i)
        known = known || strcmp(a->tier, tiers[i]) == 0;
    if (!known)
        return iso_fail(err, ISO_E_USAGE, "--tier is \"%s\", must be samples, limit or \"8 bits\"", a->tier);
    if (a->tier && strcmp(a->tier, "limit") == 0 && a->steps >= 0 && a->steps < 2)
        return iso_fail(err, ISO_E_USAGE, "--steps is %d, a limit needs at least 2", a->steps);
    if (a->tier && strcmp(a->tier, "8 bits") == 0 && a->steps > 0)
        return iso_fail(err, ISO_E_USAGE,
                        "--steps has no effect for --tier \"8 bits\", which has no limit of small steps");
    if ((a->suite ? 0 : 1) != a->cli->argument_count)
        return iso_fail(err, ISO_E_USAGE,
                        a->suite ? "--suite makes its own volumes" : "a volume, a pyramid or --suite is missing");
    if (a->suite && (a->look.scene || a->look.tf || a->look.view || a->look.zoom))
        return iso_fail(err, ISO_E_USAGE, "--scene and --suite exclude each other, --tf, --view and --zoom too");
    return ISO_OK;
}

static void print_summary(const writing *w)
{
    const iso_cli *cli = w->asked->cli;
    size_t i, k, count = 0;
    json_t *one, *file;
    json_array_foreach (w->elsewhere.pictures, i, one)
        json_array_foreach (json_object_get(one, "files"), k, file)
            ++count;
    if (cli->json) {
        iso_cli_print_results(cli, json_pack("{s:s, s:O, s:O}", "output", w->asked->dir, "pictures",
                                             w->elsewhere.pictures, "left_out", w->elsewhere.left_out));
        return;
    }
    json_array_foreach (w->elsewhere.left_out, i, one)
        printf("left out: %s: %s\n", json_string_value(json_object_get(one, "scene")),
               json_string_value(json_object_get(one, "why")));
    const size_t requests = json_array_size(w->elsewhere.pictures);
    printf("%s: %zu picture%s to render for %zu request%s; %s/README.txt lists them\n", w->asked->dir, count,
           iso_words_plural(count), requests, iso_words_plural(requests), w->asked->dir);
}

iso_status iso_scenes_write_all(const iso_scenes_write *a, iso_error *err)
{
    const bool bits = a->tier && strcmp(a->tier, "8 bits") == 0;
    OWNED(writing) w = {.asked = a};
    NEED(check(a, err));
    NEED(iso_output_begin_dir(&w.out, a->dir, ISO_PICTURES_INDEX, err));
    FREED char *line = iso_cli_command_line(a->cli), *validate = validate_line(a);
    w.elsewhere = (iso_elsewhere){.dir = w.out.temp_path,
                                  .tier = a->tier ? a->tier : "samples",
                                  .steps = bits           ? 0
                                           : a->steps < 0 ? USUAL_STEPS
                                                          : (size_t)a->steps,
                                  .pictures = json_array(),
                                  .left_out = json_array()};
    NEED_MEMORY(line && validate, err, "out of memory");
    NEED(a->suite ? write_suite(&w, err) : write_volume(&w, err));
    NEED(elsewhere_write_calibrations(&w.elsewhere, err));
    NEED(elsewhere_finish(&w.elsewhere, line, validate, err));
    NEED(iso_output_commit(&w.out, err));
    print_summary(&w);
    return ISO_OK;
}

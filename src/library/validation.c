/* SPDX-License-Identifier: MIT */
/* validation.c - validation of the library's interface, by the program `isoshade`.
 *
 * A renderer of the caller draws the requests that `isoshade scenes --write` makes; `isoshade validate --images`
 * compares its pictures. So a caller sees the same checks and limits as a user of the command line. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <glob.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/process.h"
#include "base/temporary.h"
#include "library/shared.h"

enum { QUICK_PIXELS = 96, STEPS = 4, MOST_ARGUMENTS = 64, MOST_RENDERERS = 8, TEXT_BYTES = 96 };

iso_validate_options iso_validate_defaults(void)
{
    return (iso_validate_options){.quick = true, .levels = 1};
}

/* One validation: its folder, and the words that both commands share. */
typedef struct job {
    const iso_validate_options *given;
    const iso_progress *progress;
    char *program, *folder, *volume, *scene;
    char levels[TEXT_BYTES], size[TEXT_BYTES], steps[TEXT_BYTES];
    char sentence[1024], complaint[1024]; /* the program's first line of results; its last message */
} job;

/* Finds the program: next to the library in a build or an installation, or on PATH. */
static iso_status find_program(char **program, iso_error *err)
{
    static const char *const places[] = {"isoshade", "../bin/isoshade"};
    Dl_info here;
    char *dir = dladdr((void *)(size_t)find_program, &here) && here.dli_fname ? iso_path_dir(here.dli_fname) : NULL;
    *program = NULL;
    for (size_t i = 0; dir && i < sizeof places / sizeof *places && !*program; ++i) {
        *program = iso_path_join(dir, places[i]);
        if (*program && !iso_path_is_file(*program)) {
            free(*program);
            *program = NULL;
        }
    }
    free(dir);
    return *program ? ISO_OK : iso_process_find("isoshade", "isoshade", program, err);
}

static void take_line(void *user, const char *line)
{
    job *j = user;
    const bool is_message = strncmp(line, "isoshade ", strlen("isoshade ")) == 0;
    if (is_message || !j->sentence[0])
        snprintf(is_message ? j->complaint : j->sentence, sizeof j->sentence, "%s", line);
}

/* Runs the program. *code: its exit code; codes of failures become statuses. The list ends with NULL. */
static iso_status run(job *j, const char *const *arguments, int *code, iso_error *err)
{
    iso_process_outcome outcome = {.exit_code = -1};
    const iso_process_options options = {.sandbox = {.kind = ISO_SANDBOX_NONE},
                                         .line = take_line,
                                         .user = j,
                                         .outcome = &outcome};
    iso_error why = {""};
    j->sentence[0] = j->complaint[0] = 0;
    const iso_status status = iso_process_run(arguments, &options, &why);
    *code = outcome.exit_code;
    if (status == ISO_OK || (status == ISO_E_PROGRAM && (*code == ISO_E_DIFFERS || *code == ISO_E_UNTRUSTED)))
        return ISO_OK;
    const char *text = strstr(j->complaint, ": ");
    if (status == ISO_E_PROGRAM && *code >= ISO_E_USAGE && *code < ISO_E_UNTRUSTED)
        return iso_fail(err, (iso_status)*code, "%s", text ? text + 2 : why.text);
    return iso_fail(err, status, "%s", why.text);
}

static bool is_name(const char *name)
{
    static const char allowed[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-";
    return name && *name && strspn(name, allowed) == strlen(name);
}

static iso_status check(const iso_validate_options *o, iso_error *err)
{
    if (o->renderer_count > MOST_RENDERERS)
        return iso_fail(err, ISO_E_RANGE, "%zu renderers, must be at most %d", o->renderer_count, MOST_RENDERERS);
    for (size_t i = 0; i < o->renderer_count; ++i)
        if (!is_name(o->renderers[i].name) || !o->renderers[i].render)
            return iso_fail(err, ISO_E_USAGE, "renderer %zu needs a name of letters, digits and \"-\", and a function",
                            i);
    if (o->levels > 32)
        return iso_fail(err, ISO_E_RANGE, "%zu levels, must be at most 32", o->levels);
    return ISO_OK;
}

/* ---- the requests of a renderer ---- */

/* Reads `count` floats of an NRRD file as isoshade writes it: raw, after an empty line. *all is to be freed. */
static iso_status read_floats(const char *folder, const char *name, size_t count, char **all, const float **floats,
                              iso_error *err)
{
    FREED char *path = iso_path_join(folder, name), *text = NULL;
    size_t size = 0;
    NEED(path ? iso_file_read(path, &text, &size, err) : iso_fail(err, ISO_E_MEMORY, "out of memory"));
    const char *end = memmem(text, size, "\n\n", 2);
    if (!end || (size_t)(text + size - end) - 2 != count * sizeof **floats)
        return iso_fail(err, ISO_E_PROGRAM, "%s: does not hold %zu floats", path, count);
    float *copy = malloc(count * sizeof *copy); /* aligned */
    NEED_MEMORY(copy, err, "out of memory");
    memcpy(copy, end + 2, count * sizeof *copy);
    *all = (char *)copy;
    *floats = copy;
    return ISO_OK;
}

static iso_status unpack_grid(const json_t *volume, iso_grid *grid, iso_error *err)
{
    json_int_t n[3];
    double(*m)[4] = grid->index_to_world, lo;
    json_error_t why;
    *grid = (iso_grid){.size = {0}};
    if (json_unpack_ex((json_t *)volume, &why, 0, "{s:[I,I,I], s:[[F,F,F,F],[F,F,F,F],[F,F,F,F]], s:[[F,F,F],[F,F,F]]}",
                       "size", &n[0], &n[1], &n[2], "index_to_world", &m[0][0], &m[0][1], &m[0][2], &m[0][3], &m[1][0],
                       &m[1][1], &m[1][2], &m[1][3], &m[2][0], &m[2][1], &m[2][2], &m[2][3], "box_index", &lo, &lo, &lo,
                       &grid->box_index[0], &grid->box_index[1], &grid->box_index[2]) != 0)
        return iso_fail(err, ISO_E_PROGRAM, "request.json: %s", why.text);
    for (int a = 0; a < 3; ++a)
        grid->size[a] = (size_t)n[a];
    return ISO_OK;
}

/* Draws one picture and writes it next to its request. */
static iso_status draw(const iso_own_renderer *own, const iso_frame_request *request, const char *folder,
                       const char *file, iso_error *err)
{
    OWNED(iso_image) image = {0};
    FREED char *path = iso_path_join(folder, file);
    NEED(path ? iso_image_create(&image, request->width, request->height, err)
              : iso_fail(err, ISO_E_MEMORY, "out of memory"));
    if (!own->render(own->user, request, image.rgba))
        return iso_fail(err, ISO_E_PROGRAM, "renderer %s did not draw %s at level %zu", own->name, request->scene,
                        request->level);
    return iso_image_save_exr(&image, path, NULL, err);
}

/* Draws all pictures of a request. */
static iso_status draw_frames(job *j, const iso_own_renderer *own, const json_t *root, const char *folder,
                              iso_frame_request *request, iso_error *err)
{
    const json_t *frames = json_object_get(root, "frames"), *image = json_object_get(root, "image");
    request->width = (size_t)json_integer_value(json_object_get(image, "width"));
    request->height = (size_t)json_integer_value(json_object_get(image, "height"));
    request->scene = json_string_value(json_object_get(root, "scene"));
    request->level = (size_t)json_integer_value(json_object_get(root, "level"));
    for (size_t i = 0; i < json_array_size(frames); ++i) {
        const json_t *frame = json_array_get(frames, i);
        request->step_mm = json_number_value(json_object_get(frame, "step_mm"));
        NEED(iso_progress_check(j->progress, err));
        NEED(draw(own, request, folder, json_string_value(json_object_get(frame, "file")), err));
    }
    return ISO_OK;
}

static iso_status draw_request(job *j, const iso_own_renderer *own, const char *path, iso_error *err)
{
    FREED char *folder = iso_path_dir(path), *text = NULL, *values = NULL, *directions = NULL;
    size_t size = 0;
    json_auto_t *root = NULL;
    iso_frame_request request = {0};
    NEED(folder ? iso_file_read(path, &text, &size, err) : iso_fail(err, ISO_E_MEMORY, "out of memory"));
    NEED(iso_json_of_text(text, path, &root, err));
    NEED(unpack_grid(json_object_get(root, "volume"), &request.grid, err));
    const size_t count = request.grid.size[0] * request.grid.size[1] * request.grid.size[2];
    NEED(read_floats(folder, "volume.nrrd", count, &values, &request.values, err));
    if (json_is_object(json_object_get(root, "directions")))
        NEED(read_floats(folder, "directions.nrrd", 3 * count, &directions, &request.directions, err));
    request.json = text;
    return draw_frames(j, own, root, folder, &request, err);
}

/* Draws all requests below a folder, in the order of their names. */
static iso_status draw_all(job *j, const iso_own_renderer *own, const char *folder, iso_error *err)
{
    FREED char *pattern = iso_path_join(folder, "*/request.json");
    glob_t found = {0};
    iso_status status = pattern && glob(pattern, 0, NULL, &found) == 0
                            ? ISO_OK
                            : iso_fail(err, ISO_E_PROGRAM, "isoshade scenes made no requests");
    for (size_t i = 0; i < found.gl_pathc && status == ISO_OK; ++i) {
        iso_progress_report(j->progress, own->name, (double)i / (double)found.gl_pathc);
        status = draw_request(j, own, found.gl_pathv[i], err);
    }
    globfree(&found);
    return status;
}

static iso_status make_pictures(job *j, const iso_own_renderer *own, const char *folder, iso_error *err)
{
    int code;
    const char *const arguments[] = {j->program, "scenes", j->volume, "--scene", j->scene,  "--levels", j->levels,
                                     "--steps",  j->steps, "--write", folder,    "--quiet", NULL};
    NEED(run(j, arguments, &code, err));
    return draw_all(j, own, folder, err);
}

/* ---- the report ---- */

static iso_status read_result(const job *j, const char *folder, iso_validation_result *result, iso_error *err)
{
    FREED char *json = iso_path_join(folder, "report.json"), *html = iso_path_join(folder, "index.html");
    size_t size;
    iso_status status = json && html ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "out of memory");
    TRY(status, iso_file_read(json, &result->json, &size, err));
    TRY(status, iso_file_read(html, &result->html, &size, err));
    snprintf(result->summary, sizeof result->summary, "%s", j->sentence);
    return status;
}

/* The texts NAME=FOLDER of the renderers' pictures, and the list of the others. */
typedef struct words {
    char *images[MOST_RENDERERS], *with;
} words;

static iso_status validate(job *j, words *w, iso_validation_result *result, iso_error *err)
{
    const iso_validate_options *o = j->given;
    FREED char *own = iso_path_join(j->folder, "report");
    const char *folder = o->folder ? o->folder : own;
    const char *arguments[MOST_ARGUMENTS] = {j->program, "validate", j->volume, "--scene", j->scene,
                                             "--levels", j->levels,  "--size",  j->size,   "--with",
                                             w->with,    "-o",       folder};
    size_t n = 13;
    int code = 0;
    if (o->quick)
        arguments[n++] = "--quick";
    for (size_t i = 0; i < o->renderer_count; ++i) {
        arguments[n++] = "--images";
        arguments[n++] = w->images[i];
    }
    iso_progress_report(j->progress, "validation", 0);
    iso_status status = own ? run(j, arguments, &code, err) : iso_fail(err, ISO_E_MEMORY, "out of memory");
    TRY(status, read_result(j, folder, result, err));
    result->agrees = status == ISO_OK && code == 0;
    return status;
}

static iso_status make_all_pictures(job *j, words *w, iso_error *err)
{
    const iso_validate_options *o = j->given;
    if (asprintf(&w->with, "reference%s%s", o->with ? "," : "", o->with ? o->with : "") < 0)
        return iso_fail(err, ISO_E_MEMORY, "out of memory");
    for (size_t i = 0; i < o->renderer_count; ++i) {
        const char *name = o->renderers[i].name;
        if (asprintf(&w->images[i], "%s=%s/pictures-%s", name, j->folder, name) < 0)
            return iso_fail(err, ISO_E_MEMORY, "out of memory");
        NEED(make_pictures(j, &o->renderers[i], w->images[i] + strlen(name) + 1, err));
    }
    return ISO_OK;
}

/* Writes the scene with the size of the pictures. */
static iso_status write_scene(job *j, const iso_scene *scene, iso_error *err)
{
    const iso_validate_options *o = j->given;
    size_t width = o->width ? o->width : scene->width, height = o->height ? o->height : scene->height;
    const size_t longest = width > height ? width : height;
    if (o->quick && !o->width && !o->height && longest > QUICK_PIXELS) {
        width = (width * QUICK_PIXELS + longest / 2) / longest;
        height = (height * QUICK_PIXELS + longest / 2) / longest;
    }
    width = width > 0 ? width : 1;
    height = height > 0 ? height : 1;
    snprintf(j->size, sizeof j->size, "%zux%zu", width, height);
    json_auto_t *root = iso_json_of_scene(scene);
    if (root)
        json_object_set_new(root, "image",
                            json_pack("{s:I, s:I}", "width", (json_int_t)width, "height", (json_int_t)height));
    return iso_scene_save_json(root, j->scene, err);
}

/* Writes the volume and its scene. */
static iso_status write_input(job *j, const iso_volume *volume, iso_error *err)
{
    const iso_validate_options *o = j->given;
    iso_build_options build = iso_build_defaults();
    iso_pyramid *pyramid = NULL;
    iso_scene *automatic = NULL;
    build.levels = 1;
    iso_status status = iso_volume_save(volume, j->volume, false, err);
    if (status == ISO_OK && !o->scene)
        status = iso_build(volume, &build, &pyramid, err);
    if (pyramid)
        status = iso_scene_automatic(pyramid, NULL, &automatic, err);
    const iso_scene *scene = o->scene ? o->scene : automatic;
    TRY(status, write_scene(j, scene, err));
    iso_scene_free(automatic);
    iso_pyramid_free(pyramid);
    return status;
}

static iso_status begin(job *j, iso_error *err)
{
    const size_t levels = j->given->levels ? j->given->levels : j->given->quick ? 3 : 4;
    snprintf(j->levels, sizeof j->levels, "%zu", levels);
    snprintf(j->steps, sizeof j->steps, "%d", STEPS);
    NEED(find_program(&j->program, err));
    if (!(j->folder = iso_make_temp_dir()))
        NEED(iso_temp_dir_fail(err));
    j->volume = iso_path_join(j->folder, "volume.nrrd");
    j->scene = iso_path_join(j->folder, "volume.scene.json");
    return j->volume && j->scene ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "out of memory");
}

iso_status iso_validate(const iso_volume *volume, const iso_validate_options *options, iso_validation_result *result,
                        iso_error *err)
{
    const iso_validate_options given = options ? *options : iso_validate_defaults();
    iso_call call;
    words w = {.with = NULL};
    iso_call_begin(&call, given.progress, given.progress_user);
    job j = {.given = &given, .progress = &call.progress};
    *result = (iso_validation_result){0};
    iso_status status = check(&given, err);
    TRY(status, begin(&j, err));
    TRY(status, write_input(&j, volume, err));
    TRY(status, make_all_pictures(&j, &w, err));
    TRY(status, validate(&j, &w, result, err));
    if (status != ISO_OK)
        iso_validation_result_destroy(result);
    if (j.folder)
        iso_remove_tree(j.folder);
    for (size_t i = 0; i < MOST_RENDERERS; ++i)
        free(w.images[i]);
    free(w.with);
    free(j.program);
    free(j.folder);
    free(j.volume);
    free(j.scene);
    return iso_call_end(&call, status, err);
}

void iso_validation_result_destroy(iso_validation_result *result)
{
    if (!result)
        return;
    free(result->json);
    free(result->html);
    *result = (iso_validation_result){0};
}

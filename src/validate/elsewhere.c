/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "validate/elsewhere.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/file.h"
#include "renderers/external.h"
#include "renderers/pictures.h"
#include "renderers/request.h"
#include "validate/calibrate.h"
#include "validate/validate.h"

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

iso_status iso_elsewhere_write_scene(const iso_elsewhere *e, const iso_pyramid *p, const iso_scene *scene,
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

iso_status iso_elsewhere_write_calibrations(const iso_elsewhere *e, iso_error *err)
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

iso_status iso_elsewhere_finish(const iso_elsewhere *e, const char *command, const char *validate, iso_error *err)
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

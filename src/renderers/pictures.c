/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "renderers/pictures.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/json.h"
#include "base/provenance.h"
#include "renderers/external.h"
#include "renderers/picture_file.h"
#include "renderers/request.h"

/* The folder of one renderer, until the process ends. */
typedef struct pictures {
    char *dir;
    size_t hidden;   /* length of the start of dir that reports omit (base/provenance.h) */
    json_t *checked; /* folders whose request equals the current one */
    pthread_mutex_t lock;
} pictures;

void iso_picture_folder(const char *scene, size_t level, char name[ISO_PICTURE_NAME_BYTES])
{
    snprintf(name, ISO_PICTURE_NAME_BYTES, "%.200s-level-%zu", scene, level);
    for (char *c = name; *c; ++c)
        *c = *c == ' ' || *c == '/' ? '-' : *c;
}

void iso_picture_file(double step_voxels, char name[ISO_PICTURE_NAME_BYTES])
{
    if (step_voxels > 0)
        snprintf(name, ISO_PICTURE_NAME_BYTES, "step-%g.exr", step_voxels);
    else
        snprintf(name, ISO_PICTURE_NAME_BYTES, "picture.exr");
}

/* ---- comparison with the request ---- */

/* Loads a request without the frames, the number of threads and the scene's name. */
static iso_status load_subject(const char *dir, json_t **root, iso_error *err)
{
    FREED char *path = iso_path_join(dir, "request.json");
    NEED(path ? iso_json_load(path, root, err) : iso_fail(err, ISO_E_MEMORY, "out of memory"));
    json_object_del(*root, "frames");
    json_object_del(*root, "threads");
    json_object_del(*root, "scene");
    return ISO_OK;
}

static const char *differing_key(const json_t *asked, const json_t *there)
{
    const char *key;
    json_t *value;
    json_object_foreach ((json_t *)asked, key, value)
        if (!json_equal(value, json_object_get(there, key)))
            return key;
    return NULL;
}

/* Compares a file that is in both folders. A file that was left out to save space counts as the same. */
static iso_status compare_file(const char *asked, const char *there, const char *file, bool *same, iso_error *err)
{
    FREED char *a = iso_path_join(asked, file), *b = iso_path_join(there, file), *of_a = NULL, *of_b = NULL;
    size_t size_a = 0, size_b = 0;
    *same = true;
    NEED_MEMORY(a && b, err, "out of memory");
    if (!iso_path_exists(a) || !iso_path_exists(b))
        return ISO_OK;
    NEED(iso_file_read(a, &of_a, &size_a, err));
    NEED(iso_file_read(b, &of_b, &size_b, err));
    *same = size_a == size_b && memcmp(of_a, of_b, size_a) == 0;
    return ISO_OK;
}

/* Compares the requests of two folders. shown: the folder `there` in messages. */
static iso_status compare_requests(const char *name, const char *asked, const char *there, const char *shown,
                                   iso_error *err)
{
    static const char *const files[] = {"volume.nrrd", "directions.nrrd"};
    json_auto_t *now = NULL, *then = NULL;
    bool same = true;
    NEED(load_subject(asked, &now, err));
    NEED(load_subject(there, &then, err));
    const char *key = differing_key(now, then);
    if (key)
        return iso_fail(err, ISO_E_PROGRAM, "%s: pictures in %s are for another request: its \"%s\" differs", name,
                        shown, key);
    for (size_t i = 0; i < sizeof files / sizeof *files; ++i) {
        NEED(compare_file(asked, there, files[i], &same, err));
        if (!same)
            return iso_fail(err, ISO_E_PROGRAM, "%s: pictures in %s are for another request: its %s differs", name,
                            shown, files[i]);
    }
    return ISO_OK;
}

/* Checks the request next to the pictures, if there is one. */
static iso_status check_request(const pictures *p, const iso_render_request *q, const char *there, iso_error *err)
{
    FREED char *json = iso_path_join(there, "request.json");
    const iso_request_frame frame = {.file = "picture.exr"};
    const iso_request request = {.pyramid = q->pyramid,
                                 .level = q->level,
                                 .view = q->view,
                                 .frames = &frame,
                                 .frame_count = 1,
                                 .threads = q->options->threads};
    NEED_MEMORY(json, err, "out of memory");
    if (!iso_path_exists(json))
        return ISO_OK;
    ENDED_BY(iso_end_temp_dir) char *dir = iso_make_temp_dir();
    NEED(dir ? iso_request_write(&request, dir, err) : iso_temp_dir_fail(err));
    return compare_requests(q->options->renderer->name, dir, there, there + p->hidden, err);
}

/* Checks the request once for each scene and level. */
static iso_status check_once(pictures *p, const iso_render_request *q, const char *there, iso_error *err)
{
    pthread_mutex_lock(&p->lock);
    const bool known = json_object_get(p->checked, there) != NULL;
    pthread_mutex_unlock(&p->lock);
    iso_status status = known ? ISO_OK : check_request(p, q, there, err);
    pthread_mutex_lock(&p->lock);
    if (status == ISO_OK)
        json_object_set_new(p->checked, there, json_true());
    pthread_mutex_unlock(&p->lock);
    return status;
}

/* ---- a picture ---- */

/* Finds the picture in the folder of its scene and level, or next to that folder. */
static iso_status find_picture(const pictures *p, const char *there, double step_voxels, char **path, iso_error *err)
{
    char file[ISO_PICTURE_NAME_BYTES];
    FREED char *inside = NULL, *beside = NULL, *found = NULL;
    iso_picture_file(step_voxels, file);
    const bool named = asprintf(&inside, "%s/%s", there, file) >= 0 &&
                       asprintf(&beside, "%s%s%s", there, step_voxels > 0 ? "-" : "",
                                step_voxels > 0 ? file : ".exr") >= 0;
    iso_status status = named ? iso_picture_find(inside, inside + p->hidden, path, err)
                              : iso_fail(err, ISO_E_MEMORY, "out of memory");
    if (status == ISO_OK && !iso_path_exists(*path))
        status = iso_picture_find(beside, beside + p->hidden, &found, err);
    if (found && iso_path_exists(found)) {
        free(*path);
        *path = found;
        found = NULL;
    }
    return status;
}

static iso_status render(const iso_render_request *q, iso_image *image, iso_render_stats *stats, iso_error *err)
{
    const iso_renderer_info *self = q->options->renderer;
    pictures *p = (pictures *)self->data;
    char folder[ISO_PICTURE_NAME_BYTES];
    FREED char *there = NULL;
    iso_error why = {""};
    (void)stats;
    if (!q->renderers->scene)
        return iso_fail(err, ISO_E_USAGE, "%s: has only pictures of scenes; render a scene by name", self->name);
    iso_picture_folder(q->renderers->scene, q->level, folder);
    there = iso_path_join(p->dir, folder);
    FREED char *path = NULL;
    iso_status status = there ? find_picture(p, there, q->options->step_voxels, &path, err)
                              : iso_fail(err, ISO_E_MEMORY, "out of memory");
    TRY(status, check_once(p, q, there, err));
    if (status == ISO_OK && !iso_path_exists(path))
        status = iso_fail(err, ISO_E_MISSING, "%s: there is no picture %s", self->name, path + p->hidden);
    else if (status == ISO_OK && (status = iso_picture_load(path, path + p->hidden, q->view, image, &why)) != ISO_OK)
        status = iso_fail(err, status, "%s: %s", self->name, why.text);
    return status;
}

static iso_status version(const iso_renderer_info *self, iso_renderers *r, char *text, size_t size, iso_error *err)
{
    const pictures *p = self->data;
    (void)r, (void)err;
    snprintf(text, size, "pictures in %.200s", p->dir + p->hidden);
    return ISO_OK;
}

/* ---- the row ---- */

/* Makes a row of renderers.json from pictures.json. A folder of pictures has all features. */
static iso_status make_row(const char *name, const char *index, json_t **row, size_t *steps, iso_error *err)
{
    static const char *const keys[] = {"schema", "command", "tier",  "title",    "bits", "half",
                                       "limits", "why",     "steps", "pictures", NULL},
                             *const kept[] = {"tier", "title", "bits", "half", "limits", "why"};
    json_auto_t *root = NULL;
    const char *schema = "";
    *row = json_pack("{s:s, s:[s], s:s, s:[s,s,s,s]}", "name", name, "command", "pictures", "tier", "samples", "can",
                     "lights", "orthographic", "clip planes", "labels");
    *steps = 0;
    if (!iso_path_exists(index))
        return ISO_OK;
    iso_status status = iso_json_load(index, &root, err);
    iso_json_reader r = {.path = index, .status = status, .err = err};
    if (status == ISO_OK) {
        iso_json_only_keys(&r, root, "the file", keys);
        iso_json_get_string(&r, root, "schema", true, &schema);
        iso_json_get_size(&r, root, "steps", false, 0, 12, steps);
        if (r.status == ISO_OK && strcmp(schema, ISO_PICTURES_SCHEMA) != 0)
            r.status = iso_fail(err, ISO_E_FORMAT, "%s: \"schema\" is \"%s\", must be \"" ISO_PICTURES_SCHEMA "\"",
                                index, schema);
        for (size_t i = 0; i < sizeof kept / sizeof *kept; ++i)
            if (json_object_get(root, kept[i]))
                json_object_set(*row, kept[i], json_object_get(root, kept[i]));
    }
    return r.status;
}

iso_status iso_pictures_register(const char *name_and_dir, const iso_renderer_info **r, iso_error *err)
{
    const char *equals = strchr(name_and_dir, '=');
    if (!equals || equals == name_and_dir || !equals[1])
        return iso_fail(err, ISO_E_USAGE, "--images is \"%s\", must be NAME=DIR", name_and_dir);
    FREED pictures *p = calloc(1, sizeof *p);
    FREED char *name = strndup(name_and_dir, (size_t)(equals - name_and_dir)),
               *index = iso_path_join(equals + 1, ISO_PICTURES_INDEX);
    json_auto_t *row = NULL;
    size_t steps;
    NEED_MEMORY(p && name && index, err, "out of memory");
    if (!iso_path_is_dir(equals + 1))
        return iso_fail(err, ISO_E_IO, "--images %s: there is no folder %s", name_and_dir, equals + 1);
    NEED(make_row(name, index, &row, &steps, err));
    *p = (pictures){.dir = strdup(equals + 1),
                    .hidden = strlen(equals + 1) - strlen(iso_provenance_name(equals + 1)),
                    .checked = json_object()};
    pthread_mutex_init(&p->lock, NULL);
    const iso_external_stand_in instead = {.data = p, .version = version, .render = render, .steps = steps};
    NEED(iso_external_register(row, index, equals + 1, &instead, r, err));
    p = NULL; /* the registered row owns it from now on */
    return ISO_OK;
}

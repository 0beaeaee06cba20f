/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "cli/validate.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

#include "base/file.h"
#include "base/inputs.h"

/* Returns the comment of a scene that a file holds, to be freed: a hash of all but the comment. NULL: out of memory. */
static char *comment_of(const json_t *scene)
{
    json_auto_t *rest = json_copy((json_t *)scene);
    json_object_del(rest, "comment");
    FREED char *text = rest ? json_dumps(rest, JSON_COMPACT | JSON_SORT_KEYS | JSON_REAL_PRECISION(17)) : NULL;
    char *comment = NULL;
    if (text && asprintf(&comment, "As isoshade validate wrote it: xxh3_64 %016" PRIx64,
                         (uint64_t)XXH3_64bits(text, strlen(text))) < 0)
        comment = NULL;
    return comment;
}

/* Returns the scene with the numbers that a file of it gives when read, which may have fewer digits. */
static json_t *as_read(json_t *scene)
{
    FREED char *text = scene ? iso_json_text(scene, JSON_COMPACT) : NULL;
    json_t *read = text ? json_loads(text, 0, NULL) : NULL;
    json_decref(scene);
    return read;
}

/* The scene file at path, or NULL; its comment, and the comment that an unchanged file has. */
typedef struct standing {
    json_t *scene;
    char *wanted; /* owned */
    const char *found;
} standing;

static standing look_at(const char *path)
{
    standing s = {NULL};
    if (iso_json_load(path, &s.scene, NULL) != ISO_OK)
        return (standing){NULL};
    s.wanted = comment_of(s.scene);
    s.found = json_string_value(json_object_get(s.scene, "comment"));
    return s;
}

static void forget(standing *s)
{
    free(s->wanted);
    json_decref(s->scene);
}

static iso_status refuse(const char *path, iso_error *err)
{
    return iso_fail(err, ISO_E_IO,
                    "%s: was changed since isoshade wrote it, or is not from isoshade, and the report's scene would "
                    "replace it; move it away, or choose another output",
                    path);
}

iso_status iso_validate_scene_name(const char *report, char **path, iso_error *err)
{
    if (asprintf(path, "%s.scene.json", report) < 0) {
        *path = NULL;
        return iso_fail(err, ISO_E_MEMORY, "out of memory");
    }
    return iso_inputs_announce(*path, err);
}

iso_status iso_validate_scene_guard(const char *path, iso_error *err)
{
    if (!iso_path_exists(path))
        return ISO_OK;
    standing s = look_at(path);
    const bool ours = s.wanted && s.found && strcmp(s.wanted, s.found) == 0;
    forget(&s);
    return ours ? ISO_OK : refuse(path, err);
}

iso_status iso_validate_scene_save(const iso_scene *scene, const char *path, iso_error *err)
{
    json_auto_t *root = as_read(iso_scene_to_json(scene));
    FREED char *comment = root ? comment_of(root) : NULL;
    if (!comment || json_object_set_new(root, "comment", json_string(comment)) != 0)
        return iso_fail(err, ISO_E_MEMORY, "%s: out of memory", path);
    NEED(iso_validate_scene_guard(path, err));
    return iso_scene_save_json(root, path, err);
}

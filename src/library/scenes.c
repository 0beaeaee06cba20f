/* SPDX-License-Identifier: MIT */
/* scenes.c - scenes of the library's interface. */
#include <stdlib.h>
#include <string.h>

#include "library/shared.h"

/* Where messages and the names of files start from, for a scene that has no file. */
static const char no_file[] = "the scene";

static iso_status parse(const char *text, json_t **root, iso_error *err)
{
    json_error_t where;
    *root = json_loads(text, JSON_REJECT_DUPLICATES, &where);
    if (!*root)
        return iso_fail(err, ISO_E_FORMAT, "%s:%d:%d: not JSON: %s", no_file, where.line, where.column, where.text);
    if (json_is_object(*root))
        return ISO_OK;
    json_decref(*root);
    *root = NULL;
    return iso_fail(err, ISO_E_FORMAT, "%s: holds no JSON object", no_file);
}

static iso_status scene_or_nothing(iso_status status, iso_scene **scene)
{
    if (status != ISO_OK) {
        free(*scene);
        *scene = NULL;
    }
    return status;
}

iso_status iso_scene_open(const char *path, iso_scene **scene, iso_error *err)
{
    *scene = calloc(1, sizeof **scene);
    if (!*scene)
        return iso_fail(err, ISO_E_MEMORY, "out of memory");
    return scene_or_nothing(iso_scene_load(path, *scene, err), scene);
}

iso_status iso_scene_from_text(const char *json, iso_scene **scene, iso_error *err)
{
    json_t *root = NULL;
    *scene = calloc(1, sizeof **scene);
    if (!*scene)
        return iso_fail(err, ISO_E_MEMORY, "out of memory");
    iso_status status = parse(json, &root, err);
    TRY(status, iso_scene_from_json(root, no_file, *scene, err));
    json_decref(root);
    return scene_or_nothing(status, scene);
}

const iso_tf *iso_scene_tf(const iso_scene *scene)
{
    return &scene->tf;
}

static iso_status check_size(const char *what, size_t given, size_t *size, iso_error *err)
{
    const size_t most = 16384;
    if (given > most)
        return iso_fail(err, ISO_E_RANGE, "%s is %zu, must be at most %zu", what, given, most);
    *size = given > 0 ? given : *size;
    return ISO_OK;
}

iso_status iso_scene_view(const iso_scene *scene, const iso_pyramid *p, const iso_tf *tf, size_t width, size_t height,
                          iso_view *view, iso_error *err)
{
    iso_scene changed = *scene; /* borrows all that it points to */
    const iso_level *level0 = &p->levels[0];
    *view = (iso_view){0};
    if (tf)
        changed.tf = *tf;
    iso_status status = check_size("width", width, &changed.width, err);
    TRY(status, check_size("height", height, &changed.height, err));
    return status == ISO_OK
               ? iso_scene_resolve(&changed, &level0->geometry, iso_pyramid_lo(p), iso_pyramid_hi(p), view, err)
               : status;
}

void iso_scene_free(iso_scene *scene)
{
    if (scene)
        iso_scene_destroy(scene);
    free(scene);
}

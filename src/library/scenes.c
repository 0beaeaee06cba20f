/* SPDX-License-Identifier: MIT */
/* scenes.c - scenes of the library's interface. */
#include <stdio.h>
#include <stdlib.h>

#include "fit/extinction_scale.h"
#include "library/shared.h"
#include "scene/level_view.h"
#include "scene/roi.h"
#include "scene/subject.h"
#include "tf/adapt.h"

/* Where messages and the names of files start from, for a scene that has no file. */
static const char no_file[] = "the scene";

iso_status iso_json_of_text(const char *text, const char *what, json_t **root, iso_error *err)
{
    json_error_t where;
    *root = json_loads(text, JSON_REJECT_DUPLICATES, &where);
    if (!*root)
        return iso_fail(err, ISO_E_FORMAT, "%s:%d:%d: not JSON: %s", what, where.line, where.column, where.text);
    if (json_is_object(*root))
        return ISO_OK;
    json_decref(*root);
    *root = NULL;
    return iso_fail(err, ISO_E_FORMAT, "%s: holds no JSON object", what);
}

iso_status iso_text_of_json(json_t *root, char **text, iso_error *err)
{
    *text = root ? iso_json_text(root, JSON_INDENT(2)) : NULL;
    json_decref(root);
    return *text ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "out of memory");
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
    NEED_MEMORY(*scene, err, "out of memory");
    return scene_or_nothing(iso_scene_load(path, *scene, err), scene);
}

iso_status iso_scene_from_text(const char *json, iso_scene **scene, iso_error *err)
{
    json_auto_t *root = NULL;
    *scene = calloc(1, sizeof **scene);
    NEED_MEMORY(*scene, err, "out of memory");
    iso_status status = iso_json_of_text(json, no_file, &root, err);
    TRY(status, iso_scene_from_json(root, no_file, *scene, err));
    return scene_or_nothing(status, scene);
}

iso_status iso_scene_automatic(const iso_pyramid *pyramid, const iso_look_options *look, iso_scene **scene,
                               iso_error *err)
{
    static const iso_look_options none;
    const iso_look_options *o = look ? look : &none;
    char size[64];
    snprintf(size, sizeof size, "%zux%zu", o->width ? o->width : (size_t)ISO_SUBJECT_PIXELS,
             o->height ? o->height : (size_t)ISO_SUBJECT_PIXELS);
    const iso_subject_look wanted = {.tf = o->tf, .view = o->view, .zoom = o->zoom, .size = size};
    *scene = calloc(1, sizeof **scene);
    NEED_MEMORY(*scene, err, "out of memory");
    iso_status status = iso_subject_check_look(&wanted, err);
    TRY(status, iso_subject_make_scene(&wanted, pyramid, *scene, err));
    return scene_or_nothing(status, scene);
}

json_t *iso_json_of_scene(const iso_scene *scene)
{
    const struct {
        const char *key;
        const iso_scene_level_limits *limits;
    } levels[] = {{"ssim_dissimilarity", &scene->levels.ssim_dissimilarity},
                  {"flip", &scene->levels.flip},
                  {"rmse", &scene->levels.rmse}};
    json_t *root = iso_scene_to_json(scene), *list = json_object();
    for (size_t i = 0; i < sizeof levels / sizeof *levels; ++i)
        if (levels[i].limits->count > 0)
            json_object_set_new(list, levels[i].key,
                                iso_json_numbers(levels[i].limits->limits, levels[i].limits->count));
    if (root && json_object_size(list) > 0)
        json_object_set(root, "levels", list);
    json_decref(list);
    return root;
}

/* Replaces keys of an object by those of another; null removes a key. */
static void change(json_t *object, json_t *by)
{
    const char *key;
    json_t *value;
    json_object_foreach (by, key, value)
        if (json_is_null(value))
            json_object_del(object, key);
        else
            json_object_set(object, key, value);
}

iso_status iso_scene_set(iso_scene *scene, const char *json, iso_error *err)
{
    json_auto_t *by = NULL;
    iso_scene changed = {0};
    NEED(iso_json_of_text(json, no_file, &by, err));
    json_auto_t *root = iso_json_of_scene(scene);
    NEED_MEMORY(root, err, "out of memory");
    change(root, by);
    NEED(iso_scene_from_json(root, no_file, &changed, err));
    iso_scene_destroy(scene);
    *scene = changed;
    return ISO_OK;
}

iso_status iso_scene_set_tf(iso_scene *scene, const iso_tf *tf, iso_error *err)
{
    iso_tf copy;
    NEED(iso_tf_copy(tf, &copy, err));
    iso_tf_destroy(&scene->tf);
    scene->tf = copy;
    return ISO_OK;
}

iso_status iso_scene_text(const iso_scene *scene, char **json, iso_error *err)
{
    return iso_text_of_json(iso_json_of_scene(scene), json, err);
}

iso_status iso_scene_save(const iso_scene *scene, const char *path, iso_error *err)
{
    json_auto_t *root = iso_json_of_scene(scene);
    return root ? iso_scene_save_json(root, path, err) : iso_fail(err, ISO_E_MEMORY, "%s: out of memory", path);
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

iso_status iso_scene_borrow(const iso_scene *scene, const iso_tf *tf, size_t width, size_t height, iso_scene *copy,
                            iso_error *err)
{
    *copy = *scene;
    if (tf)
        copy->tf = *tf;
    NEED(check_size("width", width, &copy->width, err));
    return check_size("height", height, &copy->height, err);
}

iso_status iso_scene_view(const iso_scene *scene, const iso_pyramid *p, const iso_tf *tf, size_t width, size_t height,
                          iso_view *view, iso_error *err)
{
    iso_scene shown;
    *view = (iso_view){0};
    NEED(iso_scene_borrow(scene, tf, width, height, &shown, err));
    return iso_scene_resolve(&shown, &p->levels[0].geometry, iso_pyramid_lo(p), iso_pyramid_hi(p), view, err);
}

iso_region iso_region_of(const double lo[3], const double hi[3])
{
    return (iso_region){.lo = {lo[0], lo[1], lo[2]}, .hi = {hi[0], hi[1], hi[2]}, .band = ISO_ROI_BAND};
}

/* Replaces the view's TF by one adapted to the level. With an extinction scale that is always better (fit/). */
static iso_status adapt(const iso_library_look *look, const iso_pyramid *p, size_t level, iso_view *view,
                        iso_error *err)
{
    iso_adapt_options o = iso_adapt_defaults();
    iso_tf_table table = {0};
    o.threads = look->threads;
    o.fall_back = o.fall_back && !look->extinction_scale;
    NEED(iso_adapt_level(p, level, &view->tf, &o, &table, NULL, err));
    iso_tf_table_destroy(&view->tf);
    view->tf = table;
    return ISO_OK;
}

static iso_status add_region(const iso_library_look *look, const iso_pyramid *p, size_t level, iso_view *view,
                             iso_error *err)
{
    const iso_region *r = look->region;
    const iso_roi_options o = {.lo = {r->lo[0], r->lo[1], r->lo[2]},
                               .hi = {r->hi[0], r->hi[1], r->hi[2]},
                               .level = r->level,
                               .band = r->band};
    iso_library_look within = *look;
    OWNED(iso_view) inside = {0};
    within.region = NULL;
    within.extinction_scale = false;
    if (!(r->band >= 0 && r->band <= 64))
        return iso_fail(err, ISO_E_RANGE, "the region's band is %g, must be 0 to 64 voxels", r->band);
    if (r->level >= level)
        return iso_fail(err, ISO_E_RANGE, "the region has level %zu, must be finer than level %zu around it", r->level,
                        level);
    NEED(iso_library_view(&within, p, r->level, &inside, err));
    if (inside.extinction_scale)
        return iso_fail(err, ISO_E_USAGE, "the region's level %zu has an extinction scale; use level 0", r->level);
    if (!(view->roi = calloc(1, sizeof *view->roi)))
        return iso_fail(err, ISO_E_MEMORY, "out of memory");
    return iso_roi_create(p, level, &inside.tf, &o, view->roi, err);
}

iso_status iso_library_view(const iso_library_look *look, const iso_pyramid *p, size_t level, iso_view *view,
                            iso_error *err)
{
    OWNED(iso_tf_table) original = {0};
    bool found = false;
    NEED(iso_scene_view(look->scene, p, look->tf, look->width, look->height, view, err));
    NEED(iso_view_take_level(view, p, level, &found, err));
    if (look->region)
        NEED(add_region(look, p, level, view, err));
    const bool has_own = level > 0 && p->levels[level].is_optimized && p->levels[level].scale;
    const bool scales = (look->extinction_scale || has_own) && !found && level > 0;
    if (scales && p->levels[level].geometry.has_no_data)
        return iso_fail(err, ISO_E_RANGE,
                        "some voxels have no data, and the share that has scales the extinction of "
                        "coarse levels; ask for no extinction scale");
    if (scales)
        NEED(iso_tf_table_copy(&view->tf, &original, err));
    if (look->adapt && !found && level > 0)
        NEED(adapt(look, p, level, view, err));
    if (scales)
        NEED(iso_extinction_scale_level(p, level, &original, &view->tf, look->threads, &view->extinction_scale, err));
    return ISO_OK;
}

void iso_scene_free(iso_scene *scene)
{
    if (scene)
        iso_scene_destroy(scene);
    free(scene);
}

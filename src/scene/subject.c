/* SPDX-License-Identifier: MIT */
#include "scene/subject.h"

#include <stdlib.h>

#include "pyramid/narrow.h"
#include "scene/viewpoint.h"
#include "tf/presets.h"

static iso_status load(const char *path, const iso_volume_input *input, const iso_pyramid_options *opt, bool begin_only,
                       const iso_progress *progress, iso_pyramid *p, iso_error *err)
{
    *p = (iso_pyramid){0};
    if (iso_pyramid_is_one(path))
        return iso_pyramid_load(path, p, err);
    iso_volume v;
    iso_status status = iso_volume_input_load(path, input, &v, err);
    if (status != ISO_OK)
        return status;
    if (begin_only && !v.notes.label_count && iso_type_bytes(v.type) <= sizeof(float))
        return iso_pyramid_begin(&v, path, opt, p, err);
    iso_pyramid_options own = *opt;
    if (v.notes.label_count)
        own.scalar_filter = ISO_SCALAR_MAJORITY;
    status = iso_pyramid_build(&v, path, &own, p, progress, err);
    iso_volume_destroy(&v);
    return status;
}

iso_status iso_subject_load_pyramid(const char *path, const iso_volume_input *input, const iso_pyramid_options *opt,
                                    const iso_progress *progress, iso_pyramid *p, iso_error *err)
{
    return load(path, input, opt, false, progress, p, err);
}

iso_status iso_subject_begin_pyramid(const char *path, const iso_volume_input *input, const iso_pyramid_options *opt,
                                     const iso_progress *progress, iso_pyramid *p, iso_error *err)
{
    return load(path, input, opt, true, progress, p, err);
}

iso_status iso_subject_refuse_labels(const iso_pyramid *p, const char *path, const char *what, iso_error *err)
{
    return p->levels[0].labels
               ? iso_fail(err, ISO_E_USAGE, "%s: is a label map, which %s would interpolate; --no-labels allows it",
                          path, what)
               : ISO_OK;
}

iso_status iso_subject_parse_image_size(const char *text, size_t *width, size_t *height, iso_error *err)
{
    char *end;
    unsigned long w = strtoul(text, &end, 10), h = w;
    bool good = end != text && text[0] != '-';
    if (good && *end == 'x') {
        const char *second = end + 1;
        h = strtoul(second, &end, 10);
        good = end != second && *second != '-';
    }
    if (!good || *end || w < 1 || h < 1 || w > 16384 || h > 16384)
        return iso_fail(err, ISO_E_USAGE, "--size is \"%s\", must be WxH such as 320x200, each 1 to 16384", text);
    *width = w;
    *height = h;
    return ISO_OK;
}

iso_status iso_subject_check_look(const iso_subject_look *look, iso_error *err)
{
    iso_scene scene = {0};
    iso_viewpoint viewpoint;
    size_t width, height;
    iso_status status = ISO_OK;
    if (look->scene)
        status = iso_scene_load(look->scene, &scene, err);
    iso_scene_destroy(&scene);
    TRY(status, iso_tf_check_name(look->tf, &look->request, err));
    if (status == ISO_OK && look->view)
        status = iso_viewpoint_parse(look->view, &viewpoint, err);
    if (status == ISO_OK && !(look->zoom == 0 || (look->zoom >= 0.01 && look->zoom <= 1000)))
        status = iso_fail(err, ISO_E_USAGE, "--zoom is %g, must be .01 to 1000", look->zoom);
    if (status == ISO_OK && look->size)
        status = iso_subject_parse_image_size(look->size, &width, &height, err);
    return status;
}

bool iso_subject_look_needs_values(const iso_subject_look *look)
{
    size_t row;
    return look->tf ? iso_tf_preset_find(look->tf, &row) : !look->scene;
}

static iso_status first_scene(const iso_subject_look *look, const iso_geometry *g, iso_scene *scene, iso_error *err)
{
    size_t width = ISO_SUBJECT_PIXELS, height = ISO_SUBJECT_PIXELS;
    iso_viewpoint viewpoint;
    iso_status status = iso_viewpoint_parse(look->view ? look->view : iso_viewpoint_usual(g), &viewpoint, err);
    if (status == ISO_OK && look->size)
        status = iso_subject_parse_image_size(look->size, &width, &height, err);
    if (status == ISO_OK)
        *scene = iso_scene_first(g, &viewpoint, width, height);
    return status;
}

/* Replaces parts of the scene; the size first, since the camera frames the box in it. */
static iso_status change_scene(const iso_subject_look *look, const iso_geometry *g, iso_scene *scene, iso_error *err)
{
    iso_viewpoint viewpoint;
    iso_status status = ISO_OK;
    if (look->size)
        status = iso_subject_parse_image_size(look->size, &scene->width, &scene->height, err);
    if (status == ISO_OK && look->view && (status = iso_viewpoint_parse(look->view, &viewpoint, err)) == ISO_OK)
        iso_scene_look_from(scene, g, &viewpoint);
    return status;
}

static iso_status frame_visible(const iso_subject_look *look, const iso_pyramid *p, iso_scene *scene, iso_error *err)
{
    const iso_level *level0 = &p->levels[0];
    iso_tf_table table = {0};
    iso_status status = iso_tf_tabulate(&scene->tf, iso_pyramid_lo(p), iso_pyramid_hi(p), &level0->geometry, &table,
                                        err);
    TRY(status, iso_scene_frame_visible(scene, level0, &table, look->threads, look->visible, err));
    iso_tf_table_destroy(&table);
    return status;
}

iso_status iso_subject_make_scene(const iso_subject_look *look, const iso_pyramid *p, iso_scene *scene, iso_error *err)
{
    const iso_level *level0 = &p->levels[0];
    *scene = (iso_scene){0};
    iso_status status = look->scene ? iso_scene_load(look->scene, scene, err)
                                    : first_scene(look, &level0->geometry, scene, err);
    if (status == ISO_OK && look->scene)
        status = change_scene(look, &level0->geometry, scene, err);
    if (look->zoom > 0)
        scene->zoom = look->zoom;
    if (status == ISO_OK && (look->tf || !look->scene)) {
        iso_tf_destroy(&scene->tf);
        status = iso_tf_of_level(look->tf, &look->request, look->survey, level0, look->threads, &scene->tf, err);
    }
    if (status == ISO_OK && !look->scene && !look->frames_box && (level0->scalar || level0->samples))
        status = frame_visible(look, p, scene, err);
    if (status != ISO_OK)
        iso_scene_destroy(scene);
    return status;
}

iso_status iso_subject_make_view(const iso_subject_look *look, const iso_pyramid *p, iso_view *view, iso_error *err)
{
    const iso_level *level0 = &p->levels[0];
    iso_scene scene;
    *view = (iso_view){0};
    iso_status status = iso_subject_make_scene(look, p, &scene, err);
    TRY(status, iso_scene_resolve(&scene, &level0->geometry, iso_pyramid_lo(p), iso_pyramid_hi(p), view, err));
    iso_scene_destroy(&scene);
    return status;
}

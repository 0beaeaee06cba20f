/* SPDX-License-Identifier: MIT */
#include "scene/subject.h"

#include <stdlib.h>

iso_status iso_subject_load_pyramid(const char *path, const iso_volume_input *input, const iso_pyramid_options *opt,
                                    const iso_progress *progress, iso_pyramid *p, iso_error *err)
{
    *p = (iso_pyramid){0};
    if (iso_pyramid_is_one(path))
        return iso_pyramid_load(path, p, err);
    iso_volume v;
    iso_status status = iso_volume_input_load(path, input, &v, err);
    if (status != ISO_OK)
        return status;
    status = iso_pyramid_build(&v, path, opt, p, progress, err);
    iso_volume_destroy(&v);
    return status;
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
        return iso_fail(err, ISO_E_USAGE, "--size is \"%s\", wanted WxH such as 320x200, each 1 to 16384", text);
    *width = w;
    *height = h;
    return ISO_OK;
}

iso_status iso_subject_load_view(const char *scene_path, const iso_pyramid *p, const char *size, iso_view *view,
                                 iso_error *err)
{
    iso_scene scene;
    *view = (iso_view){0};
    if (!scene_path)
        return iso_fail(err, ISO_E_USAGE, "--scene is missing; refscenes/ holds some that fit any volume");
    iso_status status = iso_scene_load(scene_path, &scene, err);
    if (status != ISO_OK)
        return status;
    if (size)
        status = iso_subject_parse_image_size(size, &scene.width, &scene.height, err);
    const iso_level *level0 = &p->levels[0];
    if (status == ISO_OK)
        status = iso_scene_resolve(&scene, &level0->geometry, iso_pyramid_lo(p), iso_pyramid_hi(p), view, err);
    iso_scene_destroy(&scene);
    return status;
}

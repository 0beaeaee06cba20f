/* SPDX-License-Identifier: MIT */
#include <math.h>

#include "scene/scene.h"

static json_t *vector(iso_vec3 v)
{
    return iso_json_numbers((const double[]){v.x, v.y, v.z}, 3);
}

static json_t *camera_of(const iso_scene *s)
{
    json_t *camera = json_pack("{s:s, s:o}", "projection", s->orthographic ? "orthographic" : "perspective", "up",
                               vector(s->camera_up));
    if (s->camera_fit)
        json_object_update_new(camera, json_pack("{s:b, s:o, s:f}", "fit", 1, "direction", vector(s->camera_direction),
                                                 "margin", s->margin));
    else
        json_object_update_new(camera, json_pack("{s:o, s:o}", "position", vector(s->camera_position), "look_at",
                                                 vector(s->camera_look_at)));
    if (!s->orthographic)
        json_object_set_new(camera, "fov_y_deg", json_real(s->fov_y_deg));
    else if (!s->camera_fit)
        json_object_set_new(camera, "height_mm", json_real(s->height_mm));
    if (s->zoom > 0)
        json_object_set_new(camera, "zoom", json_real(s->zoom));
    return camera;
}

static json_t *lights_of(const iso_scene *s)
{
    json_t *list = json_array();
    for (size_t i = 0; i < s->light_count; ++i)
        json_array_append_new(list, json_pack("{s:o, s:s, s:f}", "direction", vector(s->lights[i].direction), "space",
                                              s->lights[i].in_camera_space ? "camera" : "world", "intensity",
                                              s->lights[i].intensity));
    return list;
}

static json_t *clips_of(const iso_scene *s)
{
    json_t *list = json_array();
    for (size_t i = 0; i < s->clip_count; ++i) {
        const struct iso_scene_clip *c = &s->clips[i];
        json_array_append_new(list,
                              json_pack("{s:o, s:o}", "normal", vector(c->normal), isnan(c->at) ? "point_mm" : "at",
                                        isnan(c->at) ? vector(c->point_mm) : json_real(c->at)));
    }
    return list;
}

json_t *iso_scene_to_json(const iso_scene *s)
{
    const iso_shading *h = &s->shading;
    json_t *root = json_pack("{s:s, s:{s:I, s:I}, s:o, s:o, s:{s:f, s:f, s:f, s:f}, s:o, s:f, s:o}", "schema",
                             "isoshade.scene/1", "image", "width", (json_int_t)s->width, "height",
                             (json_int_t)s->height, "camera", camera_of(s), "lights", lights_of(s), "shading",
                             "ambient", h->ambient, "diffuse", h->diffuse, "specular", h->specular, "power", h->power,
                             "background", iso_json_numbers(s->background, 3), "step_voxels", s->step_voxels, "tf",
                             iso_tf_to_json(&s->tf));
    if (s->clip_count > 0)
        json_object_set_new(root, "clip_planes", clips_of(s));
    if (!s->agreement.assumed)
        json_object_set_new(root, "agreement",
                            json_pack("{s:s, s:s, s:s}", "tier", iso_tier_name(s->agreement.tier), "tf",
                                      s->agreement.sharp ? "sharp" : "smooth", "why", s->agreement.why));
    return root;
}

iso_status iso_scene_save_json(const json_t *root, const char *path, iso_error *err)
{
    OWNED(iso_scene) read = {0};
    NEED(root ? iso_scene_from_json(root, path, &read, err)
              : iso_fail(err, ISO_E_MEMORY, "%s: no memory for a scene", path));
    return iso_json_save(path, root, err);
}

json_t *iso_view_lights_to_json(const iso_view *view)
{
    json_t *list = json_array();
    for (size_t i = 0; i < view->light_count; ++i)
        json_array_append_new(list, json_pack("{s:o, s:f}", "direction", vector(view->lights[i].direction), "intensity",
                                              view->lights[i].intensity));
    return list;
}

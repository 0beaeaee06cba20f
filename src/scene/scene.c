/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "scene/scene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/inputs.h"
#include "scene/roi.h"

static iso_vec3 vec3_of(const double v[3])
{
    return iso_v3(v[0], v[1], v[2]);
}

static void get_direction(iso_json_reader *r, const json_t *object, const char *key, bool required, iso_vec3 *out)
{
    double v[3] = {out->x, out->y, out->z};
    iso_json_get_numbers(r, object, key, required, &(iso_json_list){v, 3, -1e9, 1e9});
    if (r->status == ISO_OK && !(iso_norm(vec3_of(v)) > 1e-12))
        r->status = iso_fail(r->err, ISO_E_RANGE, "%s: \"%s\" is [%g, %g, %g], a direction must not be zero", r->path,
                             key, v[0], v[1], v[2]);
    *out = iso_normalize(vec3_of(v));
}

static void read_camera(iso_json_reader *r, const json_t *root, iso_scene *s)
{
    static const char *const keys[] = {"projection", "fit",     "direction", "up",   "margin", "fov_y_deg",
                                       "position",   "look_at", "height_mm", "zoom", NULL};
    static const char *const projections[] = {"perspective", "orthographic", NULL};
    json_t *camera = iso_json_get_object(r, root, "camera", true);
    if (!camera)
        return;
    int projection = 0;
    iso_json_only_keys(r, camera, "\"camera\"", keys);
    iso_json_get_word(r, camera, "projection", true, projections, &projection);
    s->orthographic = projection == 1;
    iso_json_get_bool(r, camera, "fit", false, &s->camera_fit);
    get_direction(r, camera, "up", false, &s->camera_up);
    iso_json_get_number(r, camera, "fov_y_deg", false, 0.01, 175, &s->fov_y_deg);
    iso_json_get_number(r, camera, "zoom", false, 0.01, 1000, &s->zoom);
    if (s->camera_fit) {
        get_direction(r, camera, "direction", true, &s->camera_direction);
        iso_json_get_number(r, camera, "margin", false, 0.01, 100, &s->margin);
    } else {
        double position[3] = {0}, look_at[3] = {0};
        iso_json_get_numbers(r, camera, "position", true,
                             &(iso_json_list){position, 3, -ISO_MOST_PLACE_MM, ISO_MOST_PLACE_MM});
        iso_json_get_numbers(r, camera, "look_at", true,
                             &(iso_json_list){look_at, 3, -ISO_MOST_PLACE_MM, ISO_MOST_PLACE_MM});
        iso_json_get_number(r, camera, "height_mm", s->orthographic, ISO_LEAST_MM, ISO_MOST_PLACE_MM, &s->height_mm);
        s->camera_position = vec3_of(position);
        s->camera_look_at = vec3_of(look_at);
        s->camera_direction = iso_normalize(iso_sub(s->camera_look_at, s->camera_position));
        if (r->status == ISO_OK && iso_norm(s->camera_direction) == 0)
            r->status = iso_fail(r->err, ISO_E_RANGE, "%s: \"position\" and \"look_at\" of the camera coincide",
                                 r->path);
    }
    if (r->status == ISO_OK && iso_norm(iso_cross(s->camera_direction, s->camera_up)) < 1e-6)
        r->status = iso_fail(r->err, ISO_E_RANGE, "%s: the camera looks along its \"up\"", r->path);
}

static void read_lights(iso_json_reader *r, const json_t *root, iso_scene *s)
{
    static const char *const keys[] = {"direction", "space", "intensity", NULL};
    static const char *const spaces[] = {"world", "camera", NULL};
    json_t *list = iso_json_get_array(r, root, "lights", true);
    if (!list)
        return;
    s->light_count = json_array_size(list);
    if (s->light_count < 1 || s->light_count > ISO_MAX_LIGHTS) {
        r->status = iso_fail(r->err, ISO_E_RANGE, "%s: the scene has %zu lights, must have 1 to %d", r->path,
                             s->light_count, ISO_MAX_LIGHTS);
        return;
    }
    for (size_t i = 0; i < s->light_count; ++i) {
        json_t *item = json_array_get(list, i);
        iso_light *light = &s->lights[i];
        int space = 0;
        *light = (iso_light){.intensity = 1};
        iso_json_only_keys(r, item, "a light", keys);
        get_direction(r, item, "direction", true, &light->direction);
        iso_json_get_word(r, item, "space", false, spaces, &space);
        iso_json_get_number(r, item, "intensity", false, 0, 1, &light->intensity);
        light->in_camera_space = space == 1;
    }
}

static void read_clips(iso_json_reader *r, const json_t *root, iso_scene *s)
{
    static const char *const keys[] = {"normal", "at", "point_mm", NULL};
    json_t *list = json_object_get(root, "clip_planes") ? iso_json_get_array(r, root, "clip_planes", true) : NULL;
    s->clip_count = list ? json_array_size(list) : 0;
    if (s->clip_count > ISO_MAX_CLIP_PLANES) {
        r->status = iso_fail(r->err, ISO_E_RANGE, "%s: the scene has %zu clip planes, at most %d", r->path,
                             s->clip_count, ISO_MAX_CLIP_PLANES);
        s->clip_count = 0;
    }
    for (size_t i = 0; i < s->clip_count; ++i) {
        json_t *item = json_array_get(list, i);
        struct iso_scene_clip *clip = &s->clips[i];
        double point[3] = {0};
        bool has_at = json_object_get(item, "at"), has_point = json_object_get(item, "point_mm");
        iso_json_only_keys(r, item, "a clip plane", keys);
        get_direction(r, item, "normal", true, &clip->normal);
        iso_json_get_number(r, item, "at", !has_point, -1, 2, &clip->at);
        iso_json_get_numbers(r, item, "point_mm", !has_at,
                             &(iso_json_list){point, 3, -ISO_MOST_PLACE_MM, ISO_MOST_PLACE_MM});
        if (r->status == ISO_OK && has_at && has_point)
            r->status = iso_fail(r->err, ISO_E_RANGE, "%s: a clip plane has both \"at\" and \"point_mm\"; remove one",
                                 r->path);
        clip->point_mm = vec3_of(point);
        if (has_point)
            clip->at = NAN;
    }
}

static void read_shading(iso_json_reader *r, const json_t *root, iso_scene *s)
{
    static const char *const keys[] = {"ambient", "diffuse", "specular", "power", NULL};
    json_t *shading = iso_json_get_object(r, root, "shading", true);
    if (!shading)
        return;
    iso_json_only_keys(r, shading, "\"shading\"", keys);
    iso_json_get_number(r, shading, "ambient", true, 0, 1, &s->shading.ambient);
    iso_json_get_number(r, shading, "diffuse", true, 0, 1, &s->shading.diffuse);
    iso_json_get_number(r, shading, "specular", false, 0, 1, &s->shading.specular);
    iso_json_get_number(r, shading, "power", false, 1, 1000, &s->shading.power);
    double sum = 0;
    for (size_t i = 0; i < s->light_count; ++i)
        sum += s->lights[i].intensity;
    /* POV-Ray's densities wrap around above 1, so the diffuse term is limited. */
    double brightest = s->shading.ambient + s->shading.diffuse * sum;
    if (r->status == ISO_OK && !(brightest <= 1 + 1e-9))
        r->status = iso_fail(r->err, ISO_E_RANGE,
                             "%s: ambient + diffuse * (sum of light intensities) is %g, must be at most 1", r->path,
                             brightest);
}

static const char *const tier_names[] = {
#define ISO_TIER_NAME(name, text) text,
    ISO_TIER_LIST(ISO_TIER_NAME)
#undef ISO_TIER_NAME
        NULL};

const char *iso_tier_name(iso_tier tier)
{
    return tier_names[tier];
}

static void read_agreement(iso_json_reader *r, const json_t *root, iso_scene *s)
{
    static const char *const keys[] = {"tier", "tf", "why", NULL};
    static const char *const kinds[] = {"smooth", "sharp", NULL};
    json_t *agreement = iso_json_get_object(r, root, "agreement", false);
    const char *why = NULL;
    int tier = ISO_TIER_CONVERGENCE, sharp = 0;
    if (!agreement)
        return;
    iso_json_only_keys(r, agreement, "\"agreement\"", keys);
    iso_json_get_word(r, agreement, "tier", true, tier_names, &tier);
    iso_json_get_word(r, agreement, "tf", true, kinds, &sharp);
    iso_json_get_string(r, agreement, "why", true, &why);
    s->agreement.assumed = false;
    s->agreement.tier = (iso_tier)tier;
    s->agreement.sharp = sharp;
    if (why)
        snprintf(s->agreement.why, sizeof s->agreement.why, "%s", why);
}

double iso_scene_level_limit(const iso_scene_level_limits *limits, size_t level)
{
    if (limits->count == 0 || level == 0)
        return NAN;
    return limits->limits[(level < limits->count ? level : limits->count) - 1];
}

static void read_level_limits(iso_json_reader *r, const json_t *levels, const char *key, iso_scene_level_limits *limits)
{
    const double most = 2; /* largest 1 - SSIM; the largest of the other two is 1 */
    const json_t *value = json_object_get(levels, key);
    if (json_is_array(value) && r->status == ISO_OK) {
        limits->count = json_array_size(value);
        if (limits->count == 0 || limits->count > ISO_SCENE_LEVELS) {
            r->status = iso_fail(r->err, ISO_E_FORMAT, "%s: \"%s\" has limits for %zu levels, must have 1 to %d",
                                 r->path, key, limits->count, ISO_SCENE_LEVELS);
            return;
        }
        iso_json_get_numbers(r, levels, key, true, &(iso_json_list){limits->limits, limits->count, 0, most});
    } else if (value) {
        iso_json_get_number(r, levels, key, true, 0, most, &limits->limits[0]);
        limits->count = 1;
    }
}

static void read_levels(iso_json_reader *r, const json_t *root, iso_scene *s)
{
    static const char *const keys[] = {"ssim_dissimilarity", "flip", "rmse", NULL};
    json_t *levels = iso_json_get_object(r, root, "levels", false);
    if (!levels)
        return;
    iso_json_only_keys(r, levels, "\"levels\"", keys);
    read_level_limits(r, levels, "ssim_dissimilarity", &s->levels.ssim_dissimilarity);
    read_level_limits(r, levels, "flip", &s->levels.flip);
    read_level_limits(r, levels, "rmse", &s->levels.rmse);
}

static void read_suite(iso_json_reader *r, const json_t *root, iso_scene *s)
{
    static const char *const keys[] = {"make", "isosurface", NULL};
    json_t *suite = iso_json_get_object(r, root, "suite", false);
    const char *make = NULL;
    if (!suite)
        return;
    iso_json_only_keys(r, suite, "\"suite\"", keys);
    iso_json_get_string(r, suite, "make", true, &make);
    iso_json_get_number(r, suite, "isosurface", false, 0, 1, &s->suite_isosurface);
    if (make && !(s->suite_make = strdup(make)))
        r->status = iso_fail(r->err, ISO_E_MEMORY, "%s: out of memory", r->path);
    if (r->status == ISO_OK && (s->agreement.tier == ISO_TIER_FIRST_HIT) == isnan(s->suite_isosurface))
        r->status = iso_fail(r->err, ISO_E_FORMAT,
                             "%s: tier \"first hit\" needs \"isosurface\", and \"isosurface\" that tier", r->path);
}

/* Reads {"file": "name.xml"} and the settings missing in the file, named like `tf convert`'s options. */
static const char *read_tf_request(iso_json_reader *r, const json_t *tf, iso_tf_request *q)
{
    static const char *const keys[] = {"file", "name", "unit_distance_mm", "opacity", "range", NULL};
    const json_t *range = json_object_get(tf, "range");
    const char *file = NULL, *fit = NULL;
    iso_json_only_keys(r, tf, "\"tf\" with a \"file\"", keys);
    iso_json_get_string(r, tf, "file", true, &file);
    iso_json_get_string(r, tf, "name", false, &q->name);
    iso_json_get_number(r, tf, "unit_distance_mm", false, ISO_TF_LEAST_UNIT, ISO_TF_MOST_UNIT, &q->unit_mm);
    iso_json_get_numbers(r, tf, "opacity", false, &(iso_json_list){q->opacity, 2, 0, 1});
    q->has_opacity = json_object_get(tf, "opacity") != NULL;
    q->has_range = range != NULL;
    if (json_is_string(range))
        iso_json_get_string(r, tf, "range", false, &fit);
    else
        iso_json_get_numbers(r, tf, "range", false,
                             &(iso_json_list){q->range, 2, -ISO_TF_MOST_VALUE, ISO_TF_MOST_VALUE});
    q->fit = fit && strcmp(fit, "fit") == 0;
    if (r->status == ISO_OK && range && !q->fit && (fit || !(q->range[1] > q->range[0])))
        r->status = iso_fail(r->err, ISO_E_FORMAT, "%s: \"range\" must be \"fit\" or two ascending numbers", r->path);
    return file;
}

static void read_tf(iso_json_reader *r, const json_t *root, iso_scene *s)
{
    const json_t *tf = json_object_get(root, "tf");
    iso_tf_request request = {0};
    if (r->status != ISO_OK)
        return;
    const bool has_file = json_is_object(tf) && json_object_get(tf, "file");
    if (json_is_object(tf) && !has_file) {
        r->status = iso_tf_from_json(tf, r->path, &s->tf, r->err);
        return;
    }
    const char *name = NULL;
    if (has_file)
        name = read_tf_request(r, tf, &request);
    else
        iso_json_get_string(r, root, "tf", true, &name);
    if (!name || r->status != ISO_OK)
        return;
    FREED char *dir = iso_path_dir(r->path);
    FREED char *path = dir ? iso_path_join(dir, name) : NULL;
    r->status = path ? iso_tf_load_as(path, &request, &s->tf, r->err)
                     : iso_fail(r->err, ISO_E_MEMORY, "%s: out of memory", r->path);
}

iso_status iso_scene_from_json(const json_t *root, const char *path, iso_scene *scene, iso_error *err)
{
    static const char *const keys[] = {"schema",  "comment",     "image",       "camera", "lights",
                                       "shading", "background",  "step_voxels", "tf",     "agreement",
                                       "suite",   "clip_planes", "levels",      NULL};
    static const char *const image_keys[] = {"width", "height", NULL};
    static const char *const schemas[] = {"isoshade.scene/1", NULL};
    *scene = (iso_scene){.width = 160,
                         .height = 160,
                         .camera_up = {0, 0, 1},
                         .fov_y_deg = 30,
                         .margin = 1.05,
                         .shading = {.power = 20},
                         .step_voxels = 0.5,
                         .suite_isosurface = NAN,
                         .agreement = {ISO_TIER_CONVERGENCE, true,
                                       "the scene states no agreement: its TF is taken for sharp", true}};
    iso_json_reader r = {.path = path, .err = err};
    int schema = 0;
    iso_json_only_keys(&r, root, "the scene", keys);
    iso_json_get_word(&r, root, "schema", true, schemas, &schema);
    json_t *image = iso_json_get_object(&r, root, "image", false);
    if (image) {
        iso_json_only_keys(&r, image, "\"image\"", image_keys);
        iso_json_get_size(&r, image, "width", true, 1, 16384, &scene->width);
        iso_json_get_size(&r, image, "height", true, 1, 16384, &scene->height);
    }
    read_camera(&r, root, scene);
    read_lights(&r, root, scene);
    read_clips(&r, root, scene);
    read_shading(&r, root, scene);
    iso_json_get_numbers(&r, root, "background", false, &(iso_json_list){scene->background, 3, 0, 1});
    iso_json_get_number(&r, root, "step_voxels", false, 1e-3, 100, &scene->step_voxels);
    read_agreement(&r, root, scene);
    read_levels(&r, root, scene);
    read_suite(&r, root, scene);
    read_tf(&r, root, scene);
    if (r.status == ISO_OK && !(scene->path = strdup(path)))
        r.status = iso_fail(err, ISO_E_MEMORY, "%s: out of memory", path);
    if (r.status != ISO_OK)
        iso_scene_destroy(scene);
    return r.status;
}

iso_status iso_scene_load(const char *path, iso_scene *scene, iso_error *err)
{
    json_auto_t *root = NULL;
    *scene = (iso_scene){0};
    NEED(iso_inputs_note(path, err));
    NEED(iso_json_load(path, &root, err));
    return iso_scene_from_json(root, path, scene, err);
}

void iso_scene_destroy(iso_scene *scene)
{
    if (!scene)
        return;
    free(scene->path);
    free(scene->suite_make);
    iso_tf_destroy(&scene->tf);
    *scene = (iso_scene){0};
}

/* Resolves the camera. A fitted one frames the sphere around the box: the scale is the same from all directions, and
 * none cuts anything off. */
static iso_camera resolve_camera(const iso_scene *s, const iso_geometry *g)
{
    iso_camera c = {.orthographic = s->orthographic, .forward = s->camera_direction};
    c.right = iso_normalize(iso_cross(c.forward, s->camera_up));
    c.up = iso_cross(c.right, c.forward);
    double half_fov = 0.5 * s->fov_y_deg * (3.14159265358979323846 / 180);
    c.half_height = s->orthographic ? 0.5 * s->height_mm : tan(half_fov);
    c.position = s->camera_position;
    if (s->camera_fit) {
        double narrow = fmin(1, (double)s->width / (double)s->height);
        double radius = s->margin * iso_geometry_box_radius_mm(g) / narrow;
        double distance = s->orthographic ? 2 * radius : radius / sin(half_fov);
        c.position = iso_madd(iso_geometry_box_center_mm(g), c.forward, -distance);
        if (s->orthographic)
            c.half_height = radius;
    }
    if (s->zoom > 0)
        c.half_height /= s->zoom;
    return c;
}

/* Resolves a clip plane. "at" counts from the box's first corner along the normal. */
static iso_clip_plane resolve_clip(const struct iso_scene_clip *clip, const iso_geometry *g)
{
    double middle = iso_dot(clip->normal, iso_geometry_box_center_mm(g)), extent = 0;
    if (isnan(clip->at))
        return (iso_clip_plane){clip->normal, iso_dot(clip->normal, clip->point_mm)};
    for (int a = 0; a < 3; ++a)
        extent += fabs(iso_dot(clip->normal, iso_column(g->index_to_world, a))) * g->box_index[a];
    return (iso_clip_plane){clip->normal, middle + (clip->at - 0.5) * extent};
}

iso_status iso_scene_resolve(const iso_scene *scene, const iso_geometry *level0, double value_min, double value_max,
                             iso_view *view, iso_error *err)
{
    *view = (iso_view){.width = scene->width,
                       .height = scene->height,
                       .shading = scene->shading,
                       .step_voxels = scene->step_voxels,
                       .light_count = scene->light_count,
                       .camera = resolve_camera(scene, level0)};
    memcpy(view->background, scene->background, sizeof view->background);
    view->clip_count = scene->clip_count;
    for (size_t i = 0; i < scene->clip_count; ++i)
        view->clips[i] = resolve_clip(&scene->clips[i], level0);
    for (size_t i = 0; i < scene->light_count; ++i) {
        iso_light light = scene->lights[i];
        if (light.in_camera_space) {
            const iso_camera *c = &view->camera;
            iso_vec3 d = light.direction;
            light.direction = iso_madd(iso_madd(iso_scale(c->right, d.x), c->up, d.y), c->forward, -d.z);
            light.in_camera_space = false;
        }
        view->lights[i] = light;
    }
    iso_status status = iso_tf_tabulate(&scene->tf, value_min, value_max, level0, &view->tf, err);
    if (status == ISO_OK || scene->tf.of[0]) /* the message already names the file */
        return status;
    return iso_fail_in(err, status, "%s", scene->path ? scene->path : "scene");
}

void iso_view_destroy(iso_view *view)
{
    if (!view)
        return;
    iso_tf_table_destroy(&view->tf);
    iso_tf_2d_destroy(view->tf_2d);
    free(view->tf_2d);
    free(view->extinction_scale);
    iso_roi_destroy(view->roi);
    free(view->roi);
    *view = (iso_view){0};
}

const iso_geometry *iso_view_step_geometry(const iso_view *view, const iso_geometry *level)
{
    return view->roi ? &view->roi->level.geometry : level;
}

double iso_view_mm_per_pixel(const iso_view *view, const iso_geometry *level0)
{
    const iso_camera *c = &view->camera;
    double depth = 1;
    if (!c->orthographic)
        depth = iso_dot(iso_sub(iso_geometry_box_center_mm(level0), c->position), c->forward);
    return depth > 0 ? 2 * c->half_height * depth / (double)view->height : 0;
}

iso_ray iso_camera_ray(const iso_camera *camera, size_t width, size_t height, size_t column, size_t row)
{
    double aspect = (double)width / (double)height;
    double x = (2 * ((double)column + 0.5) / (double)width - 1) * aspect * camera->half_height;
    double y = (1 - 2 * ((double)row + 0.5) / (double)height) * camera->half_height;
    iso_vec3 offset = iso_madd(iso_scale(camera->right, x), camera->up, y);
    if (camera->orthographic)
        return (iso_ray){iso_add(camera->position, offset), camera->forward};
    return (iso_ray){camera->position, iso_normalize(iso_add(camera->forward, offset))};
}

bool iso_ray_box(const iso_ray *ray, const iso_geometry *g, double *t0, double *t1)
{
    iso_mat3 to_index = iso_mat3_inverse(g->index_to_world);
    iso_vec3 o = iso_mul(to_index, iso_sub(ray->origin, g->origin_mm)), d = iso_mul(to_index, ray->direction);
    const double origin[3] = {o.x, o.y, o.z}, direction[3] = {d.x, d.y, d.z};
    *t0 = 0;
    *t1 = INFINITY;
    for (int a = 0; a < 3; ++a) {
        if (direction[a] == 0) {
            if (origin[a] < 0 || origin[a] > g->box_index[a])
                return false;
            continue;
        }
        double near = -origin[a] / direction[a], far = (g->box_index[a] - origin[a]) / direction[a];
        *t0 = fmax(*t0, fmin(near, far));
        *t1 = fmin(*t1, fmax(near, far));
    }
    return *t1 > *t0;
}

bool iso_view_ray(const iso_view *view, const iso_ray *ray, const iso_geometry *g, double *t0, double *t1)
{
    if (!iso_ray_box(ray, g, t0, t1))
        return false;
    for (size_t i = 0; i < view->clip_count; ++i) {
        const iso_clip_plane *clip = &view->clips[i];
        double above = iso_dot(clip->normal, ray->origin) - clip->offset_mm,
               rate = iso_dot(clip->normal, ray->direction);
        if (rate > 0)
            *t0 = fmax(*t0, -above / rate);
        else if (rate < 0)
            *t1 = fmin(*t1, -above / rate);
        else if (above < 0)
            return false;
    }
    return *t1 > *t0;
}

void iso_clip_in_index(const iso_clip_plane *clip, const iso_geometry *g, double plane[4])
{
    for (int a = 0; a < 3; ++a)
        plane[a] = iso_dot(clip->normal, iso_column(g->index_to_world, a));
    plane[3] = clip->offset_mm - iso_dot(clip->normal, g->origin_mm);
}

bool iso_view_keeps(const iso_view *view, const iso_geometry *g, const double lo[3], const double hi[3])
{
    for (size_t i = 0; i < view->clip_count; ++i) {
        double plane[4], highest = 0;
        iso_clip_in_index(&view->clips[i], g, plane);
        for (int a = 0; a < 3; ++a)
            highest += plane[a] * (plane[a] > 0 ? hi[a] : lo[a]);
        if (highest < plane[3])
            return false;
    }
    return true;
}

bool iso_view_is_lit(const iso_view *view)
{
    bool shines = false;
    for (size_t i = 0; i < view->light_count; ++i)
        shines |= view->lights[i].intensity != 0;
    return shines && (view->shading.diffuse != 0 || view->shading.specular != 0);
}

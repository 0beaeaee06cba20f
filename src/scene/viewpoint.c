/* SPDX-License-Identifier: MIT */
#include "scene/viewpoint.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const struct {
    const char *name, *summary;
    iso_vec3 direction, up;
} viewpoints[] = {
    {"iso", "from the front, the left and above: three faces of the box", {0.6, -1, -0.45}, {0, 0, 1}},
    {"front", "along -y: a patient's face", {0, -1, 0}, {0, 0, 1}},
    {"back", "along y", {0, 1, 0}, {0, 0, 1}},
    {"left", "along x: a patient's left side", {1, 0, 0}, {0, 0, 1}},
    {"right", "along -x", {-1, 0, 0}, {0, 0, 1}},
    {"top", "along -z, y up", {0, 0, -1}, {0, 1, 0}},
    {"bottom", "along z, y up", {0, 0, 1}, {0, 1, 0}},
};
const iso_names iso_viewpoint_names = ISO_NAMES_OF_ROWS("view", viewpoints);

static bool parse_angles(const char *text, double *azimuth, double *elevation)
{
    char *end;
    *azimuth = strtod(text, &end);
    if (end == text || *end != ',')
        return false;
    const char *second = end + 1;
    *elevation = strtod(second, &end);
    return end != second && *end == '\0' && fabs(*azimuth) <= 3600 && fabs(*elevation) <= 90;
}

iso_status iso_viewpoint_parse(const char *text, iso_viewpoint *v, iso_error *err)
{
    const double degree = acos(-1) / 180;
    double az, el;
    size_t row;
    char names[128];
    if (iso_names_find(&iso_viewpoint_names, text, &row, NULL) == ISO_OK) {
        *v = (iso_viewpoint){iso_normalize(viewpoints[row].direction), viewpoints[row].up};
        return ISO_OK;
    }
    if (!parse_angles(text, &az, &el))
        return iso_fail(err, ISO_E_USAGE, "--view is \"%s\", wanted %s, or AZ,EL in degrees with EL from -90 to 90",
                        text, iso_names_join(&iso_viewpoint_names, NULL, names, sizeof names));
    const iso_vec3 outward = iso_v3(-sin(az * degree), cos(az * degree), 0);
    const bool upright = fabs(el) < 89.9; /* else up as in "top" and "bottom" */
    v->direction = iso_v3(-outward.x * cos(el * degree), -outward.y * cos(el * degree), -sin(el * degree));
    v->up = upright ? iso_v3(0, 0, 1) : outward;
    return ISO_OK;
}

const char *iso_viewpoint_usual(const iso_geometry *g)
{
    return g->is_patient ? "front" : "iso";
}

/* The margin of a fitted camera with which the box's corners just fit, with a twentieth around them: the sphere round the
 * box, which fitted cameras frame, leaves a cube .58 of the picture. */
static double margin_for_corners(const iso_scene *s, const iso_geometry *g)
{
    const iso_vec3 right = iso_normalize(iso_cross(s->camera_direction, s->camera_up)),
                   up = iso_cross(right, s->camera_direction), center = iso_geometry_box_center_mm(g);
    const double half_fov = 0.5 * s->fov_y_deg * (acos(-1) / 180), high = 0.95 * tan(half_fov),
                 aspect = (double)s->width / (double)s->height;
    double distance = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const iso_vec3 index = iso_v3((corner & 1) * g->box_index[0], (corner >> 1 & 1) * g->box_index[1],
                                      (corner >> 2 & 1) * g->box_index[2]),
                       at = iso_sub(iso_geometry_to_world(g, index), center);
        const double across = fmax(fabs(iso_dot(at, right)) / aspect, fabs(iso_dot(at, up)));
        distance = fmax(distance, across / high - iso_dot(at, s->camera_direction));
    }
    return distance * sin(half_fov) / iso_geometry_box_radius_mm(g) * fmin(1, aspect);
}

void iso_scene_look_from(iso_scene *s, const iso_geometry *level0, const iso_viewpoint *v)
{
    s->camera_fit = true;
    s->orthographic = false;
    s->camera_direction = v->direction;
    s->camera_up = v->up;
    s->margin = margin_for_corners(s, level0);
}

iso_scene iso_scene_first(const iso_geometry *level0, const iso_viewpoint *viewpoint, size_t width, size_t height)
{
    iso_scene s = {
        .width = width,
        .height = height,
        .fov_y_deg = 25,
        .light_count = 1,
        /* from above and the left of the viewer's head */
        .lights = {{.direction = iso_normalize(iso_v3(-0.4, 0.6, 1)), .in_camera_space = true, .intensity = 1}},
        .shading = {.ambient = 0.3, .diffuse = 0.7, .specular = 0.15, .power = 20},
        /* dark blue-gray: what is dark stands out from it as what is bright does */
        .background = {0.012, 0.016, 0.024},
        .step_voxels = 0.5,
        .suite_isosurface = NAN,
        .agreement = {ISO_TIER_CONVERGENCE, true, "there is no scene file: the TF is taken for sharp", true}};
    iso_scene_look_from(&s, level0, viewpoint);
    return s;
}

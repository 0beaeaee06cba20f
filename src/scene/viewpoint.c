/* SPDX-License-Identifier: MIT */
#include "scene/viewpoint.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>

#include "base/parallel.h"
#include "pyramid/value_table.h"

static const struct {
    const char *name, *summary;
    iso_vec3 direction, up;
} viewpoints[] = {
    {"iso", "from the front, left and above: shows three faces of the box", {0.6, -1, -0.45}, {0, 0, 1}},
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
        return iso_fail(err, ISO_E_USAGE, "--view is \"%s\", must be %s, or AZ,EL in degrees with EL from -90 to 90",
                        text, iso_names_join(&iso_viewpoint_names, NULL, names, sizeof names));
    const iso_vec3 outward = iso_v3(-sin(az * degree), cos(az * degree), 0);
    const bool upright = fabs(el) < 89.9; /* otherwise up as in "top" and "bottom" */
    v->direction = iso_v3(-outward.x * cos(el * degree), -outward.y * cos(el * degree), -sin(el * degree));
    v->up = upright ? iso_v3(0, 0, 1) : outward;
    return ISO_OK;
}

/* Returns the shortest axis of a box of which two edges are at least three times as long; -1: it is no slab. */
static int axis_of_slab(const iso_geometry *g)
{
    double edge[3];
    int shortest = 0;
    iso_geometry_spacing_mm(g, edge);
    for (int a = 0; a < 3; ++a) {
        edge[a] *= g->box_index[a];
        shortest = edge[a] < edge[shortest] ? a : shortest;
    }
    for (int a = 0; a < 3; ++a)
        if (a != shortest && !(edge[a] >= 3 * edge[shortest]))
            return -1;
    return shortest;
}

const char *iso_viewpoint_usual(const iso_geometry *g)
{
    const int axis = axis_of_slab(g);
    if (axis >= 0) {
        const iso_vec3 d = iso_column(g->index_to_world, axis);
        const double x = fabs(d.x), y = fabs(d.y), z = fabs(d.z);
        return z >= x && z >= y ? "top" : y >= x ? "front" : "left";
    }
    return g->is_patient ? "front" : "iso";
}

static iso_vec3 center_of(const iso_scene_part *p, const iso_geometry *g)
{
    return iso_geometry_to_world(g, iso_v3((p->lo[0] + p->hi[0]) / 2, (p->lo[1] + p->hi[1]) / 2,
                                           (p->lo[2] + p->hi[2]) / 2));
}

static double half_angle(const iso_scene *s)
{
    return 0.5 * s->fov_y_deg * (acos(-1) / 180);
}

/* Returns the distance from the part's center at which its corners just fit, with a margin of a twentieth. */
static double distance_for(const iso_scene *s, const iso_geometry *g, const iso_scene_part *p)
{
    const iso_vec3 right = iso_normalize(iso_cross(s->camera_direction, s->camera_up)),
                   up = iso_cross(right, s->camera_direction), center = center_of(p, g);
    const double high = 0.95 * tan(half_angle(s)), aspect = (double)s->width / (double)s->height;
    double distance = 0;
    for (int corner = 0; corner < 8; ++corner) {
        double index[3];
        for (int a = 0; a < 3; ++a)
            index[a] = corner >> a & 1 ? p->hi[a] : p->lo[a];
        const iso_vec3 at = iso_sub(iso_geometry_to_world(g, iso_v3(index[0], index[1], index[2])), center);
        const double across = fmax(fabs(iso_dot(at, right)) / aspect, fabs(iso_dot(at, up)));
        distance = fmax(distance, across / high - iso_dot(at, s->camera_direction));
    }
    return distance;
}

static iso_scene_part whole_box(const iso_geometry *g)
{
    return (iso_scene_part){.hi = {g->box_index[0], g->box_index[1], g->box_index[2]}};
}

/* Returns the margin of a fitted camera with which the box's corners just fit. Without it the camera frames the sphere
 * around the box, and a cube fills only .58 of the picture. */
static double margin_for_corners(const iso_scene *s, const iso_geometry *g)
{
    const iso_scene_part box = whole_box(g);
    return distance_for(s, g, &box) * sin(half_angle(s)) / iso_geometry_box_radius_mm(g) *
           fmin(1, (double)s->width / (double)s->height);
}

/* ---- visible part ------------------------------------------------------------------------------------------------ */

/* Returns the sampling stride along each axis: some million voxels give the visible part's ends, up to single planes
 * between them. */
static size_t stride_of(const iso_geometry *g)
{
    const size_t most = 1 << 21;
    size_t stride = 1;
    while (iso_geometry_voxel_count(g) / (stride * stride * stride) > most)
        ++stride;
    return stride;
}

typedef struct summed {
    const iso_tf_table *tf;
    double length_mm;
} summed;

/* Returns the opacity of a voxel in 65535ths. */
static uint32_t opacity_of(const void *user, double value)
{
    const summed *s = user;
    double rgbs[4];
    iso_tf_lookup(s->tf, value, rgbs);
    return rgbs[3] > 0 ? (uint32_t)(65535 * -expm1(-rgbs[3] * s->length_mm)) : 0;
}

/* Sums opacities of voxels in 65535ths along x for each (y, z) and along y for each (x, z): integers, so that the sums
 * do not depend on the number of threads. */
static void sum_opacities(const iso_level *l, const iso_tf_table *tf, int threads, uint64_t *of_y, uint64_t *of_x)
{
    const size_t stride = stride_of(&l->geometry);
    const size_t nx = l->geometry.size[0], ny = l->geometry.size[1], nz = l->geometry.size[2];
    const summed of = {tf, iso_geometry_mean_spacing_mm(&l->geometry)};
    iso_value_table table = iso_value_table_create(l, opacity_of, &of);
#pragma omp parallel for schedule(static) num_threads(iso_threads(threads))
    for (size_t z = 0; z < nz; z += stride)
        for (size_t y = 0; y < ny; y += stride)
            for (size_t x = 0; x < nx; x += stride) {
                const uint64_t opacity = iso_value_table_at(&table, (float)iso_level_value(l, (z * ny + y) * nx + x));
                of_y[z * ny + y] += opacity;
                of_x[z * nx + x] += opacity;
            }
    iso_value_table_destroy(&table);
}

/* Computes the range of planes without those at the ends with up to a thousandth of the sum. */
static void trim(const uint64_t *planes, size_t count, double range[2])
{
    uint64_t all = 0, below = 0, above = 0;
    size_t first = 0, end = count;
    for (size_t i = 0; i < count; ++i)
        all += planes[i];
    while (first < end && (below += planes[first]) <= all / 1000)
        ++first;
    while (end > first && (above += planes[end - 1]) <= all / 1000)
        --end;
    range[0] = (double)first, range[1] = (double)end;
}

/* Finds the visible part; it is empty if nothing is visible. ISO_E_MEMORY. */
static iso_status find_visible(const iso_level *l, const iso_tf_table *tf, int threads, iso_scene_part *p,
                               iso_error *err)
{
    if (p->is_known)
        return ISO_OK;
    const size_t *n = l->geometry.size;
    uint64_t *sums = calloc(n[2] * (n[0] + n[1]) + n[0] + n[1] + n[2], sizeof *sums);
    NEED_MEMORY(sums, err, "no memory for the opacity of %zu planes", n[0] + n[1] + n[2]);
    uint64_t *of_y = sums, *of_x = of_y + n[2] * n[1];
    uint64_t *planes[3] = {of_x + n[2] * n[0], of_x + n[2] * n[0] + n[0], of_x + n[2] * n[0] + n[0] + n[1]};
    sum_opacities(l, tf, threads, of_y, of_x);
    for (size_t z = 0; z < n[2]; ++z) {
        for (size_t x = 0; x < n[0]; ++x)
            planes[0][x] += of_x[z * n[0] + x];
        for (size_t y = 0; y < n[1]; ++y) {
            planes[1][y] += of_y[z * n[1] + y];
            planes[2][z] += of_y[z * n[1] + y];
        }
    }
    for (int a = 0; a < 3; ++a) {
        double range[2];
        trim(planes[a], n[a], range);
        /* The trimmed part is faint but may reach farther. */
        const double around = 0.05 * (range[1] - range[0]) + (double)stride_of(&l->geometry);
        p->lo[a] = range[1] > range[0] ? fmax(range[0] - around, 0) : 0;
        p->hi[a] = range[1] > range[0] ? fmin(range[1] + around, l->geometry.box_index[a]) : 0;
    }
    p->is_known = true;
    free(sums);
    return ISO_OK;
}

iso_status iso_scene_frame_visible(iso_scene *s, const iso_level *level0, const iso_tf_table *tf, int threads,
                                   iso_scene_part *kept, iso_error *err)
{
    const iso_geometry *g = &level0->geometry;
    const iso_scene_part box = whole_box(g);
    iso_scene_part own = {0}, *visible = kept ? kept : &own;
    const iso_status status = find_visible(level0, tf, threads, visible, err);
    if (status != ISO_OK || !(visible->hi[0] > visible->lo[0]))
        return status;
    const double distance = distance_for(s, g, visible);
    if (distance >= ISO_FRAME_VISIBLE_BELOW * distance_for(s, g, &box))
        return ISO_OK;
    s->camera_fit = false;
    s->camera_look_at = center_of(visible, g);
    s->camera_position = iso_madd(s->camera_look_at, s->camera_direction, -distance);
    return ISO_OK;
}

/* ---- scenes ------------------------------------------------------------------------------------------------------ */

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
        /* From above and the left of the viewer's head. */
        .lights = {{.direction = iso_normalize(iso_v3(-0.4, 0.6, 1)), .in_camera_space = true, .intensity = 1}},
        .shading = {.ambient = 0.3, .diffuse = 0.7, .specular = 0.15, .power = 20},
        /* Dark blue-gray, in contrast to both dark and bright objects. */
        .background = {0.012, 0.016, 0.024},
        .step_voxels = 0.5,
        .suite_isosurface = NAN,
        .agreement = {ISO_TIER_CONVERGENCE, true, "there is no scene file: the TF is taken for sharp", true}};
    iso_scene_look_from(&s, level0, viewpoint);
    return s;
}

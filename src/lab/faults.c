/* SPDX-License-Identifier: MIT */
#include "lab/faults.h"

#include <math.h>
#include <string.h>

#include "lab/ray_faults.h"

static const struct {
    const char *name, *check;
} faults[] = {[ISO_FAULT_NONE] = {"nothing", NULL},
#define ISO_FAULT_ROW(value, text, check) [value] = {text, check},
              ISO_FAULT_LIST(ISO_FAULT_ROW)
#undef ISO_FAULT_ROW
};

const char *iso_fault_name(iso_fault fault)
{
    return faults[fault].name;
}
const char *iso_fault_check(iso_fault fault)
{
    return faults[fault].check;
}

static const struct {
    const char *name, *unit, *check;
    double most;
} deviations[] = {[ISO_DEVIATION_NONE] = {"nothing", NULL, NULL, 0},
#define ISO_DEVIATION_ROW(value, text, unit, most, check) [value] = {text, unit, check, most},
                  ISO_DEVIATION_LIST(ISO_DEVIATION_ROW)
#undef ISO_DEVIATION_ROW
};

const char *iso_deviation_name(iso_deviation d)
{
    return deviations[d].name;
}
const char *iso_deviation_unit(iso_deviation d)
{
    return deviations[d].unit;
}
const char *iso_deviation_check(iso_deviation d)
{
    return deviations[d].check;
}
double iso_deviation_most(iso_deviation d)
{
    return deviations[d].most;
}

/* ---- faults of directions --------------------------------------------------- */

typedef iso_vec3 (*direction_change)(const void *user, iso_vec3 d);

static void change_directions(iso_level *level, iso_code code, direction_change change, const void *user)
{
    for (size_t i = 0; i < iso_geometry_voxel_count(&level->geometry); ++i) {
        float d[3];
        iso_code_decode_all(code, level->codes + 3 * i, d, 1);
        const iso_vec3 to = change(user, iso_v3((double)d[0], (double)d[1], (double)d[2]));
        const float out[3] = {(float)to.x, (float)to.y, (float)to.z};
        iso_code_encode(code, out, level->codes + 3 * i, 1);
    }
}

static iso_vec3 swap_xy(const void *user, iso_vec3 d)
{
    (void)user;
    return iso_v3(d.y, d.x, d.z);
}

/* Transforms a direction back to the index, and out again by the wrong matrix. The length stays: it is not at fault. */
static iso_vec3 send_by_the_matrix(const void *user, iso_vec3 d)
{
    const iso_mat3 *m = user;
    iso_vec3 index = iso_mul(iso_mat3_transpose(*m), d);
    return iso_scale(iso_normalize(iso_mul(*m, index)), fmin(iso_norm(d), 1));
}

/* Leaves directions that face away from the light unlit: neither diffuse nor highlight. */
static iso_vec3 unlight(const void *user, iso_vec3 d)
{
    const iso_vec3 *light = user;
    return iso_dot(d, *light) < 0 ? iso_v3(0, 0, 0) : d;
}

typedef struct turn {
    iso_vec3 axis; /* unit */
    double angle;
} turn;

/* Rodrigues. */
static iso_vec3 turn_by(const void *user, iso_vec3 v)
{
    const turn *t = user;
    const double c = cos(t->angle), s = sin(t->angle);
    iso_vec3 out = iso_madd(iso_scale(v, c), iso_cross(t->axis, v), s);
    return iso_madd(out, t->axis, (1 - c) * iso_dot(t->axis, v));
}

/* Returns the world direction of a light. */
static iso_vec3 light_in_world(const iso_view *view, const iso_light *light)
{
    const iso_camera *c = &view->camera;
    const iso_vec3 l = light->direction;
    if (!light->in_camera_space)
        return l;
    return iso_madd(iso_madd(iso_scale(c->right, l.x), c->up, l.y), c->forward, -l.z);
}

/* ---- faults -------------------------------------------------------------------- */

static void reverse_scalar(iso_level *level)
{
    for (size_t i = 0, j = iso_geometry_voxel_count(&level->geometry) - 1; i < j; ++i, --j) {
        float t = level->scalar[i];
        level->scalar[i] = level->scalar[j];
        level->scalar[j] = t;
    }
}

/* Mirrors the grid in its own box, so that it differs only in the order of the voxels. */
static void mirror_x(iso_geometry *g)
{
    g->origin_mm = iso_geometry_to_world(g, iso_v3((double)g->size[0], 0, 0));
    for (int r = 0; r < 3; ++r)
        g->index_to_world.m[r][0] = -g->index_to_world.m[r][0];
}

static void scale_extinction(iso_tf_table *tf, double factor)
{
    for (size_t i = 3; i < tf->count * 4; i += 4)
        tf->entries[i] = (float)(factor * (double)tf->entries[i]);
}

static void raise_colors(iso_tf_table *tf, double exponent)
{
    for (size_t i = 0; i < tf->count * 4; ++i)
        if (i % 4 != 3)
            tf->entries[i] = (float)pow((double)tf->entries[i], exponent);
}

static void lengthen_range(iso_tf_table *tf, double entries)
{
    tf->hi += entries * (tf->hi - tf->lo) / (double)(tf->count - 1);
}

static void shift(iso_geometry *g, double voxels)
{
    g->origin_mm = iso_geometry_to_world(g, iso_v3(voxels, voxels, voxels));
}

void iso_fault_plant(iso_fault fault, iso_pyramid *p, size_t k, iso_view *view)
{
    iso_level *level = &p->levels[k];
    const iso_vec3 light = light_in_world(view, &view->lights[0]);
    switch (fault) {
    case ISO_FAULT_HALF_VOXEL: shift(&level->geometry, 0.5); break;
    case ISO_FAULT_MIRRORED: mirror_x(&level->geometry); break;
    case ISO_FAULT_STALE: reverse_scalar(level); break;
    case ISO_FAULT_UNIT: scale_extinction(&view->tf, 1.1); break;
    case ISO_FAULT_SRGB: raise_colors(&view->tf, 2.2); break;
    case ISO_FAULT_RANGE: lengthen_range(&view->tf, 1); break;
    case ISO_FAULT_AXIS_SWAP: change_directions(level, p->options.code, swap_xy, NULL); break;
    case ISO_FAULT_NOT_INVERSE_TRANSPOSE:
        change_directions(level, p->options.code, send_by_the_matrix, &level->geometry.index_to_world);
        break;
    case ISO_FAULT_LIGHT: view->lights[0].direction.x = -view->lights[0].direction.x; break;
    case ISO_FAULT_ONE_SIDED: change_directions(level, p->options.code, unlight, &light); break;
    default: break;
    }
}

/* ---- deviations ---------------------------------------------------------------- */

static iso_vec3 least_axis(iso_vec3 v)
{
    const double x = fabs(v.x), y = fabs(v.y), z = fabs(v.z);
    return x <= y && x <= z ? iso_v3(1, 0, 0) : y <= z ? iso_v3(0, 1, 0) : iso_v3(0, 0, 1);
}

static void turn_lights(iso_view *view, double angle)
{
    for (size_t i = 0; i < view->light_count; ++i) {
        iso_vec3 *l = &view->lights[i].direction;
        const turn t = {iso_normalize(iso_cross(*l, least_axis(*l))), angle}; /* at right angles: by all of the angle */
        *l = iso_normalize(turn_by(&t, *l));
    }
}

/* Scales about the center of the box, so that the rest keeps its place. */
static void lengthen_x(iso_geometry *g, double factor)
{
    const iso_vec3 center = iso_geometry_box_center_mm(g);
    for (int r = 0; r < 3; ++r)
        g->index_to_world.m[r][0] *= factor;
    g->origin_mm = iso_add(g->origin_mm, iso_sub(center, iso_geometry_box_center_mm(g)));
}

static void deviate(iso_deviation deviation, double amount, iso_level *level, iso_code code, iso_view *view)
{
    const double percent = 1 + amount / 100, angle = amount * acos(-1) / 180;
    const turn oblique = {iso_normalize(iso_v3(1, 2, 3)), angle};
    switch (deviation) {
    case ISO_DEVIATION_SHIFT: shift(&level->geometry, amount); break;
    case ISO_DEVIATION_SPACING: lengthen_x(&level->geometry, percent); break;
    case ISO_DEVIATION_CAMERA: view->camera.half_height *= percent; break;
    case ISO_DEVIATION_UNIT: scale_extinction(&view->tf, percent); break;
    case ISO_DEVIATION_GAMMA: raise_colors(&view->tf, percent); break;
    case ISO_DEVIATION_RANGE: lengthen_range(&view->tf, amount); break;
    case ISO_DEVIATION_DIRECTIONS: change_directions(level, code, turn_by, &oblique); break;
    case ISO_DEVIATION_LIGHT: turn_lights(view, angle); break;
    case ISO_DEVIATION_EXPONENT: view->shading.power *= percent; break;
    default: break;
    }
}

/* Percentages are factors. */
iso_planted iso_planted_inverse(const iso_planted *planted)
{
    iso_planted inverse = *planted;
    const char *unit = iso_deviation_unit(planted->deviation);
    inverse.amount = unit && strcmp(unit, "percent") == 0 ? 100 * (1 / (1 + planted->amount / 100) - 1)
                                                          : -planted->amount;
    return inverse;
}

/* ---- planted changes ---- */

void iso_plant(const iso_planted *planted, iso_pyramid *p, size_t level, iso_view *view)
{
    if (!planted)
        return;
    iso_fault_plant(planted->fault, p, level, view);
    deviate(planted->deviation, planted->amount, &p->levels[level], p->options.code, view);
}

size_t iso_planted_level(const iso_planted *planted, size_t level)
{
    return planted && planted->fault == ISO_FAULT_LEVEL ? level + 1 : level;
}

static iso_status change_image(const void *user, const iso_render_request *request, iso_image *image, iso_error *err)
{
    const iso_planted *planted = user;
    const float gain = planted->deviation == ISO_DEVIATION_GAIN ? (float)(1 + planted->amount / 100) : 1.0f;
    for (size_t i = 0; i < image->width * image->height; ++i) {
        float *p = image->rgba + 4 * i;
        const float weight = planted->fault == ISO_FAULT_PREMULTIPLIED ? p[3] : 1;
        for (int c = 0; c < 3; ++c) {
            p[c] *= weight * gain;
            p[c] = planted->fault == ISO_FAULT_CLIPPED ? fminf(p[c], 1) : p[c];
        }
    }
    if (planted->deviation == ISO_DEVIATION_PIXEL)
        for (int c = 0; c < 3; ++c)
            image->rgba[4 * (image->height / 2 * image->width + image->width / 2) + (size_t)c] += (float)
                                                                                                      planted->amount;
    const iso_ray_fault ray_fault = planted->fault == ISO_FAULT_ORDER           ? ISO_RAY_REVERSED
                                    : planted->fault == ISO_FAULT_VIEW_VECTOR   ? ISO_RAY_OTHER_EYE
                                    : planted->fault == ISO_FAULT_INTERPOLATION ? ISO_RAY_NOT_NORMALIZED
                                                                                : ISO_RAY_RIGHT;
    return ray_fault == ISO_RAY_RIGHT ? ISO_OK : iso_ray_fault_add(request, ray_fault, image, err);
}

iso_image_hook iso_planted_hook(const iso_planted *planted)
{
    return planted ? (iso_image_hook){change_image, planted} : (iso_image_hook){0};
}

static size_t plant_in_calibration(const void *user, iso_pyramid *p, iso_view *view)
{
    iso_plant(user, p, 0, view);
    return iso_planted_level(user, 0);
}

iso_calibration_fault iso_planted_calibration(const iso_planted *planted)
{
    return (iso_calibration_fault){plant_in_calibration, iso_planted_hook(planted)};
}

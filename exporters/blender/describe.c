/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "blender/blender_scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "encode/decode_double.h"
#include "scene/roi.h"
#include "vdb/vdb.h"

/* Single precision has an error of 6e-8 of the distance from the origin. At 64 radii of the volume that is 4e-6 radii:
 * a thousandth of a voxel, for 500 voxels across. */
#define MOST_RADII_AWAY 64

/* Rounds the box's center for readability; the result stays within a radius of it. */
static iso_vec3 near_origin(const iso_geometry *g, double radius)
{
    const iso_vec3 center = iso_geometry_box_center_mm(g);
    if (iso_norm(center) <= MOST_RADII_AWAY * radius)
        return iso_v3(0, 0, 0);
    const double digit = pow(10, floor(log10(radius)));
    return iso_v3(digit * rint(center.x / digit), digit * rint(center.y / digit), digit * rint(center.z / digit));
}

iso_blender_space iso_blender_space_of(const iso_geometry *g)
{
    const double least = 1, most = 1e4, radius = iso_geometry_box_radius_mm(g);
    return (iso_blender_space){.units = radius >= least && radius <= most ? 1 : pow(10, 2 - ceil(log10(radius))),
                               .origin_mm = near_origin(g, radius)};
}

static iso_vec3 place(iso_vec3 world_mm, const iso_blender_space *space)
{
    return iso_scale(iso_sub(world_mm, space->origin_mm), space->units);
}

void iso_blender_note_space(const iso_blender_space *space, iso_vdb_options *options)
{
    options->unit_mm = 1 / space->units;
    options->origin_mm = space->origin_mm;
}

void iso_blender_grid_options(const iso_blender_options *opt, const iso_tf_table *tf, const iso_tf_2d *tf_2d,
                              iso_vdb_shown *shown, iso_vdb_options *options)
{
    *shown = tf_2d ? (iso_vdb_shown){.tfs = tf_2d->rows, .tf_count = ISO_TF_2D_ROWS}
                   : (iso_vdb_shown){.tfs = tf, .tf_count = 1};
    options->shown = opt->dense ? NULL : shown;
    options->half_float = opt->half;
    options->half_directions = !opt->dense;
    options->command = opt->command;
    options->volume = opt->volume;
    options->threads = opt->threads;
}

void iso_blender_scale_directions(json_t *about, const iso_blender_options *opt, double scale)
{
    json_object_set_new(about, "eps", json_real((opt->dense ? 1 : scale) * ISO_DIRECTION_EPS));
    json_object_set_new(about, "dense", json_boolean(opt->dense));
}

iso_geometry iso_blender_in_space(const iso_geometry *mm, const iso_blender_space *space)
{
    iso_geometry g = *mm;
    g.index_to_world = iso_mat3_scale(g.index_to_world, space->units);
    g.origin_mm = place(g.origin_mm, space);
    return g;
}

json_t *iso_blender_text(const char *text, size_t limit)
{
    FREED char *copy = strdup(text);
    size_t n = copy ? strlen(copy) : 0;
    if (n > limit)
        for (n = limit; n > 0 && ((unsigned char)text[n] & 0xC0) == 0x80;)
            --n;
    json_t *json = copy ? json_stringn(copy, n) : NULL;
    for (size_t i = 0; !json && i < n; ++i)
        if ((unsigned char)copy[i] >= 0x80)
            copy[i] = '_';
    if (copy && !json)
        json = json_stringn(copy, n);
    return json;
}

static json_t *vec_json(iso_vec3 v)
{
    return iso_json_numbers((double[]){v.x, v.y, v.z}, 3);
}

static json_t *rows_json(const double rows[][4], size_t count)
{
    json_t *array = json_array();
    for (size_t r = 0; r < count; ++r)
        json_array_append_new(array, iso_json_numbers(rows[r], 4));
    return array;
}

/* Describes the box as an affine image of [0, 1]^3, and the inverse. */
static void describe_box(json_t *about, const iso_geometry *g)
{
    iso_mat3 to_world = g->index_to_world;
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c)
            to_world.m[r][c] *= g->box_index[c];
    iso_mat3 to_box = iso_mat3_inverse(to_world);
    iso_vec3 back = iso_mul(to_box, g->origin_mm);
    const double origin[3] = {g->origin_mm.x, g->origin_mm.y, g->origin_mm.z};
    const double shift[3] = {-back.x, -back.y, -back.z};
    double world[4][4] = {{0}}, box[3][4];
    for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c) {
            world[r][c] = to_world.m[r][c];
            box[r][c] = to_box.m[r][c];
        }
        world[r][3] = origin[r];
        box[r][3] = shift[r];
    }
    world[3][3] = 1;
    json_object_set_new(about, "box_to_world", rows_json((const double(*)[4])world, 4));
    json_object_set_new(about, "world_to_box", rows_json((const double(*)[4])box, 3));
}

/* Computes the depths of the box's nearest and farthest corner in front of the camera; negative behind the camera. */
static void depths_of_box(const iso_camera *c, iso_vec3 position, const iso_geometry *g, double depths[2])
{
    depths[0] = INFINITY;
    depths[1] = -INFINITY;
    for (int corner = 0; corner < 8; ++corner) {
        const iso_vec3 index = iso_v3((corner & 1 ? 1 : 0) * g->box_index[0], (corner & 2 ? 1 : 0) * g->box_index[1],
                                      (corner & 4 ? 1 : 0) * g->box_index[2]);
        const iso_vec3 p = iso_add(g->origin_mm, iso_mul(g->index_to_world, index));
        const double depth = iso_dot(iso_sub(p, position), c->forward);
        depths[0] = fmin(depths[0], depth);
        depths[1] = fmax(depths[1], depth);
    }
}

/* Places the near plane for EEVEE, which computes a sample's position in a volume from its depth as a depth buffer
 * stores it. In single precision that has an error of about 1e-7 z z / near, z away from the camera: ten voxels and
 * more, with rings and holes, if the near plane is a thousandth of a voxel away. So the plane is placed for an error of
 * a quarter voxel at the far side of the box. This leaves space to move the camera closer. It never cuts the volume. */
static double clip_start(const iso_camera *c, iso_vec3 position, const iso_geometry *g)
{
    const double least = 1e-3 * iso_geometry_min_spacing_mm(g);
    double depths[2];
    depths_of_box(c, position, g, depths);
    const double wanted = 1e-7 * depths[1] * depths[1] / (0.25 * iso_geometry_min_spacing_mm(g));
    return fmax(least, fmin(wanted, 0.5 * depths[0]));
}

static json_t *describe_camera(const iso_camera *c, const iso_blender_space *space, const iso_geometry *g)
{
    const iso_vec3 position = place(c->position, space);
    double far = iso_norm(iso_sub(position, iso_geometry_box_center_mm(g))) + 4 * iso_geometry_box_radius_mm(g);
    return json_pack("{sb sf so so so so sf sf}", "orthographic", c->orthographic, "half_height",
                     c->half_height * (c->orthographic ? space->units : 1), "position", vec_json(position), "forward",
                     vec_json(c->forward), "right", vec_json(c->right), "up", vec_json(c->up), "clip_start",
                     clip_start(c, position, g), "clip_end", far);
}

static json_t *describe_ramp(const iso_tf_table *t, double units)
{
    iso_color_ramp ramp;
    iso_color_ramp_fit(t, &ramp);
    json_t *stops = json_array();
    for (size_t i = 0; i < ramp.count; ++i)
        json_array_append_new(stops, iso_json_numbers((double[]){ramp.position[i], ramp.rgba[i][0], ramp.rgba[i][1],
                                                                 ramp.rgba[i][2], ramp.rgba[i][3]},
                                                      5));
    return json_pack("{so sb sf sf sf sf sf sf}", "stops", stops, "own_points", ramp.own_points, "lo", ramp.lo, "hi",
                     ramp.hi, "unit_distance_mm", ramp.unit_mm, "unit_distance", ramp.unit_mm * units, "color_loss",
                     ramp.color_loss, "opacity_loss", ramp.opacity_loss);
}

static void append_entries(json_t *to, const iso_tf_table *t, double units)
{
    for (size_t i = 0; i < 4 * t->count; ++i)
        json_array_append_new(to, json_real((double)t->entries[i] / (i % 4 == 3 ? units : 1)));
}

static bool is_same_table(const iso_tf_table *a, const iso_tf_table *b)
{
    return a->count == b->count && a->lo == b->lo && a->hi == b->hi &&
           memcmp(a->entries, b->entries, 4 * a->count * sizeof *a->entries) == 0;
}

/* The objects' tables, and the ramps of different ones. */
typedef struct described_tf {
    json_t *tables, *ramps;
    const iso_tf_table **owners; /* tables of the ramps */
    double units;
} described_tf;

/* Finds the ramp of an equal table, or adds one. name: of its object. */
static size_t find_ramp(described_tf *d, const iso_tf_table *t, const char *name)
{
    size_t i = 0;
    while (i < json_array_size(d->ramps) && !is_same_table(d->owners[i], t))
        ++i;
    if (i == json_array_size(d->ramps)) {
        d->owners[i] = t;
        json_array_append_new(d->ramps, describe_ramp(t, d->units));
        json_object_set_new(json_array_get(d->ramps, i), "of", json_array());
    }
    json_array_append_new(json_object_get(json_array_get(d->ramps, i), "of"), json_string(name));
    return i;
}

/* Appends a table. rows: those of a 2D transfer function, or a single one; flat: the 1D one, for the ramp. */
static void append_table(described_tf *d, const iso_tf_table *rows, int count, const iso_tf_table *flat,
                         const char *name)
{
    json_t *entries = json_array();
    for (int r = 0; r < count; ++r)
        append_entries(entries, &rows[r], d->units);
    json_array_append_new(d->tables, json_pack("{sf sf si sI so}", "lo", rows->lo, "hi", rows->hi, "rows", count,
                                               "ramp", (json_int_t)find_ramp(d, flat, name), "entries", entries));
}

json_t *iso_blender_describe_tf(const iso_view *views, size_t first, size_t count, double units)
{
    described_tf d = {json_array(), json_array(), calloc(2 * count, sizeof *d.owners), units};
    char name[64];
    for (size_t k = 0; k < count && d.owners; ++k) {
        const iso_view *v = &views[k];
        snprintf(name, sizeof name, "level %zu", first + k);
        append_table(&d, v->tf_2d ? v->tf_2d->rows : &v->tf, v->tf_2d ? ISO_TF_2D_ROWS : 1, &v->tf, name);
    }
    for (size_t k = 0; k < count && d.owners; ++k)
        if (views[k].roi) {
            snprintf(name, sizeof name, "region in level %zu", first + k);
            append_table(&d, &views[k].roi->tf, 1, &views[k].roi->tf, name);
        }
    free(d.owners);
    return json_pack("{so so}", "tables", d.tables, "ramps", d.ramps);
}

json_t *iso_blender_describe_one_tf(const iso_view *view, size_t first, size_t count, double units)
{
    FREED iso_view *views = calloc(count, sizeof *views);
    for (size_t k = 0; views && k < count; ++k)
        views[k] = *view;
    json_t *tf = views ? iso_blender_describe_tf(views, first, count, units) : NULL;
    return tf;
}

static json_t *describe_lights(const iso_view *view)
{
    json_t *lights = json_array();
    for (size_t i = 0; i < view->light_count; ++i)
        json_array_append_new(lights, json_pack("{so sf}", "direction", vec_json(view->lights[i].direction),
                                                "intensity", view->lights[i].intensity));
    return lights;
}

/* Returns the step: the same for all levels, since Cycles uses the shortest step of overlapping volumes. That of the
 * finest. */
static double step_mm(const iso_view *view, const iso_geometry *level, const iso_blender_options *opt)
{
    return opt->step_voxels * iso_geometry_min_spacing_mm(iso_view_step_geometry(view, level));
}

/* Describes box and band of a region of interest in fractions of the volume's box; side: the part of the weight for
 * this volume, as constant and factor. */
static json_t *describe_roi(const iso_roi *f, const iso_geometry *around, bool inside)
{
    double lo[3], hi[3], band[3];
    for (int a = 0; a < 3; ++a) {
        lo[a] = f->lo[a] / around->box_index[a];
        hi[a] = f->hi[a] / around->box_index[a];
        band[a] = fmax(f->band, 1e-6) / around->box_index[a];
    }
    return json_pack("{so so so s[fff]}", "lo", iso_json_numbers(lo, 3), "hi", iso_json_numbers(hi, 3), "band",
                     iso_json_numbers(band, 3), "side", inside ? 0.0 : 1.0, inside ? 1.0 : -1.0, 0.0);
}

json_t *iso_blender_describe_level(const iso_geometry *g, size_t k, size_t table, const char *vdb, double step)
{
    const double x = iso_vdb_reverses_x(g) ? -1 : 1; /* along the axes of the file's grids */
    return json_pack("{sI sI ss sf so}", "level", (json_int_t)k, "table", (json_int_t)table, "vdb", vdb, "step", step,
                     "voxel_diagonal", vec_json(iso_mul(g->index_to_world, iso_v3(x, 1, 1))));
}

void iso_blender_append_level(json_t *levels, const blender_level *l, const iso_view *view,
                              const iso_blender_space *space, const iso_blender_options *opt)
{
    const iso_geometry g = iso_blender_in_space(l->geometry, space);
    const double step = space->units * step_mm(view, l->geometry, opt);
    json_t *around = iso_blender_describe_level(&g, l->number, l->tables[0], l->vdb, step);
    if (l->is_optimized)
        json_object_set_new(around, "values", json_string(ISO_OPTIMIZED_VALUES));
    if (view->roi) {
        const iso_geometry finer = iso_blender_in_space(&view->roi->level.geometry, space);
        json_t *inside = iso_blender_describe_level(&finer, l->number, l->tables[1], l->roi_vdb, step);
        json_object_set_new(around, "roi", describe_roi(view->roi, l->geometry, false));
        json_object_set_new(inside, "roi", describe_roi(view->roi, l->geometry, true));
        json_array_append_new(levels, around);
        json_array_append_new(levels, inside);
        return;
    }
    json_array_append_new(levels, around);
}

/* Describes clip planes in fractions of the box from its center: [x, y, z, w], the kept side is x fx + y fy + z fz >=
 * w. */
static json_t *describe_clips(const iso_view *view, const iso_geometry *g)
{
    json_t *clips = json_array();
    for (size_t i = 0; i < view->clip_count; ++i) {
        double plane[4];
        iso_clip_in_index(&view->clips[i], g, plane);
        for (int a = 0; a < 3; ++a) {
            plane[a] *= g->box_index[a];
            plane[3] -= 0.5 * plane[a];
        }
        json_array_append_new(clips, iso_json_numbers(plane, 4));
    }
    return clips;
}

/* Describes clip planes in the world, in mm: normal, and a point of the plane. */
static json_t *describe_clips_mm(const iso_view *view)
{
    json_t *clips = json_array();
    for (size_t i = 0; i < view->clip_count; ++i) {
        const iso_vec3 n = view->clips[i].normal, p = iso_scale(n, view->clips[i].offset_mm);
        json_array_append_new(clips, iso_json_numbers((double[]){n.x, n.y, n.z, p.x, p.y, p.z}, 6));
    }
    return clips;
}

json_t *iso_blender_describe_scene(const iso_view *view, const iso_blender_space *space, const iso_geometry *mm,
                                   const char *name, const iso_blender_options *opt)
{
    const iso_geometry g = iso_blender_in_space(mm, space);
    json_t *about = json_pack("{ss so si si si s[II] so so so s{sf sf sf sf} sf sf sf so}", "schema",
                              "isoshade.blender/1", "name", iso_blender_text(name, 50), "samples", opt->samples, "seed",
                              iso_blender_seed(opt->seed), "max_steps", ISO_BLENDER_MAX_STEPS, "image",
                              (json_int_t)view->width, (json_int_t)view->height, "background",
                              iso_json_numbers(view->background, 3), "camera",
                              describe_camera(&view->camera, space, &g), "lights", describe_lights(view), "shading",
                              "ambient", view->shading.ambient, "diffuse", view->shading.diffuse, "specular",
                              view->shading.specular, "power", view->shading.power, "eps", ISO_DIRECTION_EPS,
                              "step_voxels", opt->step_voxels, "units_per_mm", space->units, "origin_mm",
                              vec_json(space->origin_mm));
    if (about) {
        describe_box(about, &g);
        json_object_set_new(about, "physical", json_boolean(opt->physical));
        json_object_set_new(about, "clip_planes", describe_clips(view, mm));
        json_object_set_new(about, "clip_planes_mm", describe_clips_mm(view));
    }
    return about;
}

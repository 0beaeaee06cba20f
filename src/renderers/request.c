/* SPDX-License-Identifier: MIT */
#include "renderers/request.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

#include "base/file.h"
#include "base/json.h"
#include "base/parallel.h"
#include "encode/decode_double.h"
#include "volume/stream.h"

static json_t *vector_json(iso_vec3 v)
{
    return json_pack("[f,f,f]", v.x, v.y, v.z);
}

static json_t *numbers_json(const double *values, size_t count)
{
    json_t *list = json_array();
    for (size_t i = 0; i < count; ++i)
        json_array_append_new(list, json_real(values[i]));
    return list;
}

/* ---- the volume ---- */

/* Returns the checksum, which binds a picture to its samples; also of a file that is left out. */
static json_t *checksum_json(const void *values, size_t bytes, uint64_t seed)
{
    char text[17];
    snprintf(text, sizeof text, "%016llx", (unsigned long long)XXH3_64bits_withSeed(values, bytes, seed));
    return json_string(text);
}

static json_t *volume_json(const iso_level *level)
{
    const iso_geometry *g = &level->geometry;
    const double *box = g->box_index;
    json_t *rows = json_array();
    for (int r = 0; r < 3; ++r) {
        const double origin[3] = {g->origin_mm.x, g->origin_mm.y, g->origin_mm.z}, *m = g->index_to_world.m[r];
        json_array_append_new(rows, json_pack("[f,f,f,f]", m[0], m[1], m[2], origin[r]));
    }
    json_t *checksum = checksum_json(level->scalar, iso_geometry_voxel_count(g) * sizeof *level->scalar, 0);
    return json_pack("{s:s, s:o, s:[I,I,I], s:s, s:o, s:[[f,f,f],[f,f,f]]}", "file", "volume.nrrd",
                     ISO_REQUEST_CHECKSUM, checksum, "size", (json_int_t)g->size[0], (json_int_t)g->size[1],
                     (json_int_t)g->size[2], "interpolation", level->labels ? "nearest" : "linear", "index_to_world",
                     rows, "box_index", 0.0, 0.0, 0.0, box[0], box[1], box[2]);
}

static iso_status write_volume(const iso_level *level, const char *path, iso_error *err)
{
    const iso_volume v = {.geometry = level->geometry,
                          .type = ISO_F32,
                          .data = level->scalar,
                          .notes = {.scale_slope = 1}};
    return iso_volume_save(&v, path, false, err);
}

/* Writes an NRRD of four axes, the three components first. The library's own writer has one number per voxel. */
static bool put_directions(FILE *f, const iso_geometry *g, const float *directions)
{
    const size_t *n = g->size, count = 3 * iso_geometry_voxel_count(g);
    fprintf(f,
            "NRRD0004\n# made by isoshade\ntype: float\ndimension: 4\nsizes: 3 %zu %zu %zu\nendian: %s\n"
            "encoding: raw\n\n",
            n[0], n[1], n[2], __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__ ? "little" : "big");
    return fwrite(directions, sizeof *directions, count, f) == count;
}

static iso_status write_directions(const iso_level *level, iso_code code, const char *path, iso_error *err)
{
    const size_t count = iso_geometry_voxel_count(&level->geometry);
    FREED float *directions = malloc(3 * count * sizeof *directions);
    NEED_MEMORY(directions, err, "no memory for %zu directions", count);
    iso_code_decode_all(code, level->codes, directions, count);
    FILE *f = fopen(path, "wb");
    bool good = f && put_directions(f, &level->geometry, directions);
    if (f && fclose(f) != 0)
        good = false;
    return good ? ISO_OK : iso_fail(err, ISO_E_IO, "%s: cannot be written", path);
}

/* ---- the view ---- */

static json_t *tf_json(const iso_tf_table *tf)
{
    json_t *colors = json_array(), *extinctions = json_array();
    for (size_t i = 0; i < tf->count; ++i) {
        const float *e = tf->entries + 4 * i;
        json_array_append_new(colors, json_pack("[f,f,f]", (double)e[0], (double)e[1], (double)e[2]));
        json_array_append_new(extinctions, json_real((double)e[3]));
    }
    return json_pack("{s:f, s:f, s:o, s:o}", "lo", tf->lo, "hi", tf->hi, "color", colors, "extinction_per_mm",
                     extinctions);
}

/* Finds the depths between which the box lies, for renderers that need clip distances. */
static void find_depths(const iso_camera *c, const iso_geometry *g, double *near, double *far)
{
    *near = INFINITY, *far = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const double *b = g->box_index;
        const iso_vec3 at = iso_v3(corner & 1 ? b[0] : 0, corner & 2 ? b[1] : 0, corner & 4 ? b[2] : 0);
        const double depth = iso_dot(iso_sub(iso_geometry_to_world(g, at), c->position), c->forward);
        *near = fmin(*near, depth);
        *far = fmax(*far, depth);
    }
    const double slack = 0.01 * (*far - *near);
    *far = *far > 0 ? *far + slack : 1;
    *near = c->orthographic ? fmax(*near - slack, 0) : fmax(*near - slack, 1e-3 * *far);
}

/* Returns the matrix from world to eye, which looks along -z; row-major. */
static json_t *view_matrix(const iso_camera *c)
{
    const iso_vec3 axes[3] = {c->right, c->up, iso_scale(c->forward, -1)};
    json_t *rows = json_array();
    for (int r = 0; r < 3; ++r)
        json_array_append_new(rows,
                              json_pack("[f,f,f,f]", axes[r].x, axes[r].y, axes[r].z, -iso_dot(axes[r], c->position)));
    json_array_append_new(rows, json_pack("[f,f,f,f]", 0.0, 0.0, 0.0, 1.0));
    return rows;
}

/* Returns the projection matrix of OpenGL, row-major. */
static json_t *projection_matrix(const iso_camera *c, double aspect, double near, double far)
{
    const double x = 1 / (c->half_height * aspect), y = 1 / c->half_height, depth = far - near;
    const double z[2] = {c->orthographic ? -2 / depth : -(far + near) / depth,
                         c->orthographic ? -(far + near) / depth : -2 * far * near / depth};
    const double w[2] = {c->orthographic ? 0.0 : -1.0, c->orthographic ? 1.0 : 0.0};
    return json_pack("[[f,f,f,f],[f,f,f,f],[f,f,f,f],[f,f,f,f]]", x, 0.0, 0.0, 0.0, 0.0, y, 0.0, 0.0, 0.0, 0.0, z[0],
                     z[1], 0.0, 0.0, w[0], w[1]);
}

static json_t *camera_json(const iso_view *view, const iso_geometry *g)
{
    const iso_camera *c = &view->camera;
    double near, far;
    find_depths(c, g, &near, &far);
    return json_pack("{s:s, s:o, s:o, s:o, s:o, s:f, s:o, s:o, s:f, s:f}", "projection",
                     c->orthographic ? "orthographic" : "perspective", "position", vector_json(c->position), "forward",
                     vector_json(c->forward), "right", vector_json(c->right), "up", vector_json(c->up), "half_height",
                     c->half_height, "view", view_matrix(c), "projection_matrix",
                     projection_matrix(c, (double)view->width / (double)view->height, near, far), "near", near, "far",
                     far);
}

static json_t *clip_planes_json(const iso_view *view)
{
    json_t *planes = json_array();
    for (size_t i = 0; i < view->clip_count; ++i)
        json_array_append_new(planes, json_pack("{s:o, s:f}", "normal", vector_json(view->clips[i].normal), "offset_mm",
                                                view->clips[i].offset_mm));
    return planes;
}

static json_t *frames_json(const iso_request *q)
{
    const iso_level *level = &q->pyramid->levels[q->level];
    const double voxel_mm = iso_geometry_min_spacing_mm(&level->geometry);
    json_t *frames = json_array();
    for (size_t i = 0; i < q->frame_count; ++i) {
        const iso_request_frame *f = &q->frames[i];
        const double step = f->step_voxels > 0 ? f->step_voxels : q->view->step_voxels;
        json_array_append_new(frames, json_pack("{s:f, s:f, s:i, s:i, s:s}", "step_mm", step * voxel_mm, "step_voxels",
                                                step, "samples", f->samples, "seed", f->seed, "file", f->file));
    }
    return frames;
}

static json_t *request_json(const iso_request *q, bool lit)
{
    const iso_view *v = q->view;
    const iso_level *level = &q->pyramid->levels[q->level];
    const size_t code_bytes = 3 * iso_geometry_voxel_count(&level->geometry);
    json_t *directions = lit ? json_pack("{s:s, s:o, s:f}", "file", "directions.nrrd", ISO_REQUEST_CHECKSUM,
                                         checksum_json(level->codes, code_bytes, q->pyramid->options.code), "epsilon",
                                         ISO_DIRECTION_EPS)
                             : json_null();
    return json_pack(
        "{s:s, s:o, s:I, s:o, s:o, s:o, s:o, s:o, s:{s:f, s:f, s:f, s:f}, s:o, s:o, s:{s:I, s:I}, s:o, s:i}", "schema",
        "isoshade.request/1", "scene", q->scene ? json_string(q->scene) : json_null(), "level", (json_int_t)q->level,
        "volume", volume_json(level), "directions", directions, "tf", tf_json(&v->tf), "camera",
        camera_json(v, &level->geometry), "lights", iso_view_lights_to_json(v), "shading", "ambient",
        v->shading.ambient, "diffuse", v->shading.diffuse, "specular", v->shading.specular, "power", v->shading.power,
        "background", numbers_json(v->background, 3), "clip_planes", clip_planes_json(v), "image", "width",
        (json_int_t)v->width, "height", (json_int_t)v->height, "frames", frames_json(q), "threads",
        iso_threads(q->threads));
}

/* ---- files ---- */

/* Writes all digits of a double: rounded camera numbers would move the samples. */
static iso_status write_json(const char *path, json_t *root, iso_error *err)
{
    FREED char *text = root ? json_dumps(root, JSON_INDENT(1) | JSON_REAL_PRECISION(17)) : NULL;
    return text ? iso_file_write(path, text, strlen(text), err) : iso_fail(err, ISO_E_MEMORY, "%s: no memory", path);
}

static iso_status check(const iso_request *q, iso_error *err)
{
    const char *what = q->view->tf_2d              ? "2D transfer function"
                       : q->view->extinction_scale ? "extinction scales"
                       : q->view->roi              ? "region of interest"
                                                   : NULL;
    return what ? iso_fail(err, ISO_E_USAGE, "request.json cannot describe the scene's %s", what) : ISO_OK;
}

iso_status iso_request_write(const iso_request *q, const char *dir, iso_error *err)
{
    const iso_level *level = &q->pyramid->levels[q->level];
    const bool lit = level->codes && iso_view_is_lit(q->view);
    FREED char *volume = iso_path_join(dir, "volume.nrrd"), *directions = iso_path_join(dir, "directions.nrrd"),
               *json = iso_path_join(dir, "request.json");
    NEED(volume && directions && json ? check(q, err) : iso_fail(err, ISO_E_MEMORY, "out of memory"));
    NEED(write_volume(level, volume, err));
    if (lit)
        NEED(write_directions(level, q->pyramid->options.code, directions, err));
    json_auto_t *root = request_json(q, lit);
    return write_json(json, root, err);
}

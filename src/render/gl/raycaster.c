/* SPDX-License-Identifier: MIT */
#include "render/gl/raycaster.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "brick/occupancy.h"
#include "fit/extinction_scale.h"
#include "pyramid/narrow.h"
#include "render/gl/gl_context.h"
#include "render/gl/gl_directions.h"
#include "render/gl/gl_uniforms.h"
#include "render/gl/gl_variant.h"
#include "render/sampler.h"
#include "render/screen_reach.h"
#include "scene/roi.h"
#include "tf/integral.h"

/* ---- a palette and its indices as textures ---- */

/* Uploads one index per voxel: 8 bits for at most 256 entries, otherwise 16. Integers are never filtered. */
static iso_status gl_upload_indices(const iso_gl *gl, const iso_level *level, GLuint *texture, iso_error *err)
{
    const size_t *size = level->geometry.size, plane_count = size[0] * size[1];
    if (!level->palette || !level->palette_index)
        return iso_fail(err, ISO_E_RANGE, "gl: the level holds no palette, and directions from one are asked for");
    bool bytes = level->palette->count <= 256;
    NEED(iso_gl_create_texture_3d(gl, bytes ? GL_R8UI : GL_R16UI, size, "palette indices", texture, err));
    glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    uint8_t *plane = bytes ? malloc(plane_count) : NULL;
    if (bytes && !plane)
        return iso_fail(err, ISO_E_MEMORY, "gl: no memory for a plane of %zu indices", plane_count);
    for (size_t z = 0; z < size[2]; ++z) {
        const uint16_t *index = level->palette_index + z * plane_count;
        for (size_t i = 0; bytes && i < plane_count; ++i)
            plane[i] = (uint8_t)index[i];
        glTexSubImage3D(GL_TEXTURE_3D, 0, 0, 0, (GLint)z, (GLsizei)size[0], (GLsizei)size[1], 1, GL_RED_INTEGER,
                        bytes ? GL_UNSIGNED_BYTE : GL_UNSIGNED_SHORT, bytes ? (const void *)plane : index);
    }
    free(plane);
    return iso_gl_check("uploading palette indices", err);
}

/* Uploads a texture of one row: each entry's direction, and its shade as fourth component. The shade is for the view's
 * lights, seen along the camera's axis (palette/palette.h: iso_palette_shade). */
static iso_status gl_upload_palette(const iso_gl *gl, const iso_palette *palette, const iso_view *view, GLuint *texture,
                                    iso_error *err)
{
    iso_palette_light lights[ISO_MAX_LIGHTS];
    const iso_vec3 forward = view->camera.forward;
    const iso_shading *s = &view->shading;
    const iso_palette_shading shading = {
        s->ambient, s->diffuse, s->specular, s->power, lights, view->light_count, {-forward.x, -forward.y, -forward.z}};
    for (size_t i = 0; i < view->light_count; ++i) {
        iso_vec3 d = view->lights[i].direction;
        lights[i] = (iso_palette_light){{d.x, d.y, d.z}, view->lights[i].intensity};
    }
    FREED float *shade = malloc(palette->count * sizeof *shade), *row = malloc(4 * palette->count * sizeof *row);
    if (!shade || !row) {
        return iso_fail(err, ISO_E_MEMORY, "gl: no memory for %zu palette entries", palette->count);
    } else {
        iso_palette_shade(palette, &shading, shade);
        for (size_t i = 0; i < palette->count; ++i) {
            for (size_t c = 0; c < 3; ++c)
                row[4 * i + c] = palette->xyz[3 * i + c];
            row[4 * i + 3] = shade[i];
        }
        NEED(iso_gl_create_texture_rgba32f(gl, palette->count, 1, row, texture, err));
    }
    return ISO_OK;
}

enum {
    UNIT_SCALAR,
    UNIT_TF,
    UNIT_DIRECTIONS,
    UNIT_OCCUPANCY,
    UNIT_PALETTE,
    UNIT_SECOND_VALUE,
    UNIT_TF_SUMS,
    UNIT_EXTINCTION_SCALE,
    UNIT_REACH,
    UNIT_ROI_SCALAR,
    UNIT_ROI_TF,
    UNIT_ROI_DIRECTIONS
};

/* A level on the GPU, and how its texels become values and lattice vectors. */
typedef struct level_textures {
    GLuint scalar, tf, tf_sums, occupancy, palette, tf_2d, extinction_scale;
    iso_gl_directions directions; /* the indices, with a palette */
    bool scalar_with_directions;  /* instead of a texture of its own */
    bool skip_empty;
    iso_screen_reach screen; /* where empty bricks are skipped, of the integral */
    double screen_seconds, screen_processor_seconds;
    GLuint reach;
    double value_per_texel; /* value = min + texel * value_per_texel */
} level_textures;

iso_gl_options iso_gl_defaults(void)
{
    return (iso_gl_options){.source = ISO_FROM_CODES, .brick_voxels = 4, .repeats = 1};
}

/* ---- upload ----------------------------------------------------------------- */

static bool is_small_integer(iso_type type)
{
    return type == ISO_U8 || type == ISO_I8 || type == ISO_U16 || type == ISO_I16;
}

/* True if R16 stores the scalar exactly: integers of at most 16 bits. texel = (value - min) * m with the largest
 * integer m that fits: signed types need no special case, and an offset costs few digits. */
static bool is_whole_in_16_bits(const iso_gl *gl, const iso_level *level)
{
    return is_small_integer(level->stored_type) && level->max - level->min <= 65535 &&
           gl->info.filter_bits_unorm16 >= gl->info.filter_bits_float - 1;
}

static double multiple_of(const iso_level *level)
{
    const double range = level->max - level->min;
    return range > 0 ? floor(65535 / range) : 1;
}

/* Uploads the scalar; other types than small integers become (value - min) / (max - min) in float. Converts plane by
 * plane, without a second copy of the volume. */
static iso_status upload_scalar(const iso_gl *gl, const iso_level *level, level_textures *t, iso_error *err)
{
    const size_t *size = level->geometry.size;
    size_t plane_count = size[0] * size[1];
    const double range = level->max - level->min, multiple = multiple_of(level);
    const bool integers = is_whole_in_16_bits(gl, level);
    NEED(iso_gl_create_texture_3d(gl, integers ? GL_R16 : GL_R32F, size, "a scalar volume", &t->scalar, err));
    if (level->labels) {
        glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
        glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    }
    void *plane = malloc(plane_count * (integers ? sizeof(uint16_t) : sizeof(float)));
    NEED_MEMORY(plane, err, "gl: no memory for a plane of %zu voxels", plane_count);
    uint16_t *codes = plane;
    float *parts = plane;
    for (size_t z = 0; z < size[2]; ++z) {
        const float *from = level->scalar + z * plane_count;
        for (size_t i = 0; i < plane_count; ++i)
            if (integers)
                codes[i] = (uint16_t)lrint(((double)from[i] - level->min) * multiple);
            else
                parts[i] = iso_is_no_data(from[i]) ? (float)-ISO_STAND_IN_DEVICE
                           : range > 0             ? (float)(((double)from[i] - level->min) / range)
                                                   : 0;
        glTexSubImage3D(GL_TEXTURE_3D, 0, 0, 0, (GLint)z, (GLsizei)size[0], (GLsizei)size[1], 1, GL_RED,
                        integers ? GL_UNSIGNED_SHORT : GL_FLOAT, plane);
    }
    free(plane);
    t->value_per_texel = integers ? 65535 / multiple : range;
    return iso_gl_check("uploading the scalar", err);
}

static void destroy_textures(level_textures *t)
{
    const GLuint names[] = {t->scalar, t->directions.texture, t->tf,   t->tf_sums, t->occupancy, t->palette,
                            t->tf_2d,  t->extinction_scale,   t->reach};
    glDeleteTextures(sizeof names / sizeof *names, names);
    iso_screen_reach_destroy(&t->screen);
}

static double bytes_of(const level_textures *t)
{
    const GLuint solid[] = {t->scalar, t->directions.texture, t->occupancy, t->tf_2d, t->extinction_scale},
                 flat[] = {t->tf, t->tf_sums, t->palette, t->reach};
    double bytes = 0;
    for (size_t i = 0; i < sizeof solid / sizeof *solid; ++i)
        bytes += iso_gl_texture_bytes(GL_TEXTURE_3D, solid[i]);
    for (size_t i = 0; i < sizeof flat / sizeof *flat; ++i)
        bytes += iso_gl_texture_bytes(GL_TEXTURE_2D, flat[i]);
    return bytes;
}

/* Uploads the TF's sums as floats, and the rounding errors of these floats: differences of sums then keep a float's
 * digits. */
static iso_status upload_sums(const iso_gl *gl, const iso_tf_table *tf, level_textures *t, iso_error *err)
{
    OWNED(iso_tf_integral) integral = {0};
    NEED(iso_tf_integral_create(&integral, tf, err));
    const size_t count = 4 * tf->count;
    FREED float *rows = malloc(2 * count * sizeof *rows);
    NEED_MEMORY(rows, err, "gl: no memory for the integral of %zu entries", tf->count);
    for (size_t i = 0; i < count; ++i) {
        rows[i] = (float)integral.sums[i];
        rows[count + i] = (float)(integral.sums[i] - (double)rows[i]);
    }
    return iso_gl_create_texture_rgba32f(gl, tf->count, 2, rows, &t->tf_sums, err);
}

/* Uploads the visible range of each tile of pixels. It belongs to a picture, not to the volume: its time counts as
 * drawing. */
static iso_status upload_reach(const iso_gl *gl, const iso_level *level, const iso_view *view,
                               const iso_screen_blocks *blocks, level_textures *t, iso_error *err)
{
    const double start = iso_clock_seconds(), processor = iso_cpu_seconds();
    iso_status status = iso_screen_reach_create(&t->screen, &level->geometry, view, blocks, err);
    const size_t count = t->screen.columns * t->screen.rows;
    float *texels = calloc(count, 4 * sizeof *texels);
    if (status == ISO_OK && !texels)
        status = iso_fail(err, ISO_E_MEMORY, "gl: no memory for %zu tiles", count);
    for (size_t i = 0; i < 2 * count && status == ISO_OK; ++i)
        texels[i / 2 * 4 + i % 2] = t->screen.mm[i];
    glActiveTexture(GL_TEXTURE0 + UNIT_REACH);
    TRY(status, iso_gl_create_texture_rgba32f(gl, t->screen.columns, t->screen.rows, texels, &t->reach, err));
    free(texels);
    t->screen_seconds = iso_clock_seconds() - start;
    t->screen_processor_seconds = iso_cpu_seconds() - processor;
    return status;
}

/* Decides whether empty bricks are skipped, and uploads their distances if so. */
static iso_status upload_occupancy(const iso_gl *gl, const iso_level *level, const iso_gl_options *opt,
                                   const iso_tf_table *tf, const iso_view *view, level_textures *t, iso_error *err)
{
    if (opt->skip == ISO_GL_SKIP_NEVER)
        return ISO_OK;
    OWNED(iso_brick_ranges) r = {0};
    NEED(iso_brick_ranges_create(&r, level->scalar, &level->geometry, opt->brick_voxels, err));
    FREED uint8_t *distance = malloc(iso_brick_ranges_count(&r));
    if (!distance) {
        return iso_fail(err, ISO_E_MEMORY, "gl: no memory for %zu bricks", iso_brick_ranges_count(&r));
    } else {
        double occupied = iso_occupancy_compute(&r, tf, distance);
        t->skip_empty = opt->skip == ISO_GL_SKIP_ALWAYS || opt->surface || occupied <= ISO_GL_SKIP_OCCUPIED;
    }
    /* A segment whose middle is in one brick may begin and end this many further. */
    const size_t reach = opt->preintegrated ? (size_t)ceil(0.5 * opt->step_voxels / (double)opt->brick_voxels) : 0;
    for (size_t i = 0; reach > 0 && i < iso_brick_ranges_count(&r); ++i)
        distance[i] = (uint8_t)(distance[i] > reach ? distance[i] - reach : 0);
    if (t->skip_empty)
        NEED(iso_gl_create_occupancy(gl, r.count, distance, &t->occupancy, err));
    if (t->skip_empty && !opt->surface)
        NEED(upload_reach(
            gl, level, view,
            &(iso_screen_blocks){distance, {r.count[0], r.count[1], r.count[2]}, (double)opt->brick_voxels, 0}, t,
            err));
    return ISO_OK;
}

/* Uploads a 2D transfer function as rows of one texture, and one byte per voxel. The envelope decides which bricks are
 * skipped. */
static iso_status upload_tf_2d(const iso_gl *gl, const iso_level *level, const iso_gl_options *opt,
                               const iso_view *view, level_textures *t, iso_error *err)
{
    const iso_tf_2d *tf_2d = view->tf_2d;
    const iso_tf_table *tables = tf_2d->rows;
    size_t row = 4 * tables[0].count;
    iso_tf_table envelope = {0};
    float *rows = malloc(ISO_TF_2D_ROWS * row * sizeof *rows);
    iso_status status = rows ? iso_tf_2d_envelope(tf_2d, &envelope, err)
                             : iso_fail(err, ISO_E_MEMORY, "gl: no memory for %d tables of %zu entries", ISO_TF_2D_ROWS,
                                        tables[0].count);
    for (size_t c = 0; c < ISO_TF_2D_ROWS && status == ISO_OK; ++c)
        memcpy(rows + c * row, tables[c].entries, row * sizeof *rows);
    glActiveTexture(GL_TEXTURE0 + UNIT_TF);
    TRY(status, iso_gl_create_texture_rgba32f(gl, tables[0].count, ISO_TF_2D_ROWS, rows, &t->tf, err));
    glActiveTexture(GL_TEXTURE0 + UNIT_SECOND_VALUE);
    TRY(status, iso_gl_upload_bytes(gl, level, tf_2d->bytes, "second value", &t->tf_2d, err));
    glActiveTexture(GL_TEXTURE0 + UNIT_OCCUPANCY);
    TRY(status, upload_occupancy(gl, level, opt, &envelope, view, t, err));
    free(rows);
    iso_tf_table_destroy(&envelope);
    return status == ISO_OK ? iso_gl_check("uploading a 2D transfer function", err) : status;
}

static bool is_from_palette(iso_direction_source source)
{
    return source == ISO_FROM_PALETTE || source == ISO_FROM_PALETTE_NEAREST;
}

/* True if the texture unit filters the directions themselves, so that a fourth channel can come with them. */
static bool has_direction_texture(iso_direction_source source)
{
    return source == ISO_FROM_CODES || source == ISO_FROM_DECODED || source == ISO_FROM_FLOAT;
}

/* Uploads the finer level of a region of interest. */
static iso_status upload_roi(const iso_gl *gl, const iso_roi *f, iso_code code, iso_direction_source source,
                             level_textures *t, iso_error *err)
{
    *t = (level_textures){0};
    glActiveTexture(GL_TEXTURE0 + UNIT_ROI_SCALAR);
    iso_status status = upload_scalar(gl, &f->level, t, err);
    glActiveTexture(GL_TEXTURE0 + UNIT_ROI_TF);
    TRY(status, iso_gl_create_texture_rgba32f(gl, f->tf.count, 1, f->tf.entries, &t->tf, err));
    glActiveTexture(GL_TEXTURE0 + UNIT_ROI_DIRECTIONS);
    TRY(status, source == ISO_FROM_CODES
                    ? iso_gl_upload_codes(gl, &f->level, code, NULL, &t->directions, err)
                    : iso_gl_upload_vectors(gl, &f->level, code, source, NULL, &t->directions, err));
    if (status != ISO_OK)
        destroy_textures(t);
    return status;
}

/* True if scalar and code share a texture. If a fetch takes as long as its filter computes, one fetch of four channels
 * is faster than one of the scalar and one of the code. A GPU would fetch four times the bytes in invisible parts. */
static bool holds_scalar_with_codes(const iso_gl *gl, const iso_level *level, const iso_gl_options *opt,
                                    const iso_view *view)
{
    const bool scalar_alone = view->light_count == 0 || opt->surface || opt->preintegrated || opt->exact_lookups ||
                              view->roi || view->extinction_scale || level->labels;
    return gl->is_llvmpipe && opt->source == ISO_FROM_CODES && !scalar_alone && is_whole_in_16_bits(gl, level);
}

static iso_status upload_scalar_with_codes(const iso_gl *gl, const iso_level *level, iso_code code, level_textures *t,
                                           iso_error *err)
{
    const double multiple = multiple_of(level);
    t->scalar_with_directions = true;
    t->value_per_texel = 65535 / multiple;
    glActiveTexture(GL_TEXTURE0 + UNIT_DIRECTIONS);
    return iso_gl_upload_codes_with_scalar(gl, level, code, multiple, &t->directions, err);
}

static iso_status upload(const iso_gl *gl, const iso_level *level, iso_code code, const iso_gl_options *opt,
                         const iso_view *view, level_textures *t, iso_error *err)
{
    const iso_tf_table *tf = &view->tf;
    const uint8_t *scale = opt->surface ? NULL : view->extinction_scale;
    iso_direction_source source = opt->source;
    *t = (level_textures){0};
    glActiveTexture(GL_TEXTURE0 + UNIT_SCALAR);
    iso_status status = holds_scalar_with_codes(gl, level, opt, view)
                            ? upload_scalar_with_codes(gl, level, code, t, err)
                            : upload_scalar(gl, level, t, err);
    glActiveTexture(GL_TEXTURE0 + UNIT_TF);
    if (status == ISO_OK && view->tf_2d)
        status = upload_tf_2d(gl, level, opt, view, t, err);
    else if (status == ISO_OK)
        status = iso_gl_create_texture_rgba32f(gl, tf->count, 1, tf->entries, &t->tf, err);
    glActiveTexture(GL_TEXTURE0 + UNIT_TF_SUMS);
    if (status == ISO_OK && opt->preintegrated)
        status = upload_sums(gl, tf, t, err);
    glActiveTexture(GL_TEXTURE0 + UNIT_DIRECTIONS);
    if (status == ISO_OK && source == ISO_FROM_CODES && !t->scalar_with_directions)
        status = iso_gl_upload_codes(gl, level, code, scale, &t->directions, err);
    else if (status == ISO_OK && is_from_palette(source))
        status = gl_upload_indices(gl, level, &t->directions.texture, err);
    else if (status == ISO_OK && source != ISO_FROM_CODES && source != ISO_FROM_ON_THE_FLY)
        status = iso_gl_upload_vectors(gl, level, code, source, has_direction_texture(source) ? scale : NULL,
                                       &t->directions, err);
    glActiveTexture(GL_TEXTURE0 + UNIT_EXTINCTION_SCALE);
    if (status == ISO_OK && scale && !has_direction_texture(source)) {
        status = iso_gl_upload_bytes(gl, level, scale, "extinction scale", &t->extinction_scale, err);
        t->directions.octaves = 255.0 / ISO_EXTINCTION_SCALE_PER_OCTAVE;
        t->directions.octaves_offset = -(double)ISO_EXTINCTION_SCALE_ONE / ISO_EXTINCTION_SCALE_PER_OCTAVE;
    }
    glActiveTexture(GL_TEXTURE0 + UNIT_PALETTE);
    if (status == ISO_OK && is_from_palette(source))
        status = gl_upload_palette(gl, level->palette, view, &t->palette, err);
    glActiveTexture(GL_TEXTURE0 + UNIT_OCCUPANCY);
    float entries[12];
    iso_tf_table below = opt->surface ? iso_gl_surface_tf(opt->surface, level->min, level->max, entries) : *tf;
    if (status == ISO_OK && !view->tf_2d)
        status = upload_occupancy(gl, level, opt, &below, view, t, err);
    if (status != ISO_OK)
        destroy_textures(t);
    return status;
}

/* ---- uniforms --------------------------------------------------------------- */

static void set_field(GLuint program, const iso_level *level, const level_textures *t, const iso_gl_options *opt,
                      const iso_tf_table *tf)
{
    const iso_geometry *g = &level->geometry;
    iso_gl_set_int(program, "scalar", UNIT_SCALAR);
    iso_gl_set_int(program, "labels", level->labels);
    iso_gl_set_int(program, "tf", UNIT_TF);
    iso_gl_set_int(program, is_from_palette(opt->source) ? "palette_index" : "directions", UNIT_DIRECTIONS);
    iso_gl_set_int(program, "palette", UNIT_PALETTE);
    iso_gl_set_int(program, "second_value", UNIT_SECOND_VALUE);
    iso_gl_set_int(program, "tf_sums", UNIT_TF_SUMS);
    iso_vec3 voxel = {1 / (double)g->size[0], 1 / (double)g->size[1], 1 / (double)g->size[2]};
    iso_gl_set_coordinates(program, voxel, iso_v3(0, 0, 0));
    iso_gl_set_vec3(program, "voxel", voxel);
    iso_gl_set_int(program, "occupancy", UNIT_OCCUPANCY);
    iso_gl_set_int(program, "reach", UNIT_REACH);
    double n = (double)opt->brick_voxels;
    iso_gl_set_vec3(program, "bricks_per_volume",
                    iso_v3((double)g->size[0] / n, (double)g->size[1] / n, (double)g->size[2] / n));
    double min_spacing_mm = iso_geometry_min_spacing_mm(g);
    iso_gl_set_tf(program, tf, level->min, t->value_per_texel);
    if (opt->surface)
        iso_gl_set_surface(program, opt->surface, iso_v3((double)g->size[0], (double)g->size[1], (double)g->size[2]),
                           0.5, level->min, t->value_per_texel);
    iso_gl_set_float(program, "direction_scale", t->directions.scale);
    iso_gl_set_float(program, "direction_offset", t->directions.offset);
    iso_gl_set_int(program, "extinction_scale", UNIT_EXTINCTION_SCALE);
    iso_gl_set_float(program, "octaves_per_texel", t->directions.octaves);
    iso_gl_set_float(program, "octaves_offset", t->directions.octaves_offset);
    /* n = g / sqrt(|g|^2 + e^2), e = ISO_ON_THE_FLY_EPS range / spacing: both are divided by range / spacing. */
    double range = level->max - level->min;
    iso_mat3 m = iso_mat3_scale(iso_geometry_gradient_to_world(g),
                                range > 0 ? 0.5 * t->value_per_texel * min_spacing_mm / range : 0);
    double columns[9];
    float float_columns[9];
    iso_gl_matrix_columns(m, columns);
    for (int i = 0; i < 9; ++i)
        float_columns[i] = (float)columns[i];
    glUniformMatrix3fv(glGetUniformLocation(program, "gradient_to_world"), 1, GL_FALSE, float_columns);
    iso_gl_set_float(program, "on_the_fly_eps", ISO_ON_THE_FLY_EPS);
}

static void set_roi(GLuint program, const iso_roi *f, const iso_geometry *around, const level_textures *t)
{
    const size_t *size = around->size, *own = f->level.geometry.size;
    double scale[3], offset[3];
    for (int a = 0; a < 3; ++a) {
        scale[a] = f->scale * (double)size[a] / (double)own[a];
        offset[a] = -f->offset[a] / (double)own[a];
    }
    iso_gl_set_int(program, "roi_scalar", UNIT_ROI_SCALAR);
    iso_gl_set_int(program, "roi_tf", UNIT_ROI_TF);
    iso_gl_set_int(program, "roi_directions", UNIT_ROI_DIRECTIONS);
    double entries = (double)(f->tf.count - 1) / (f->tf.hi - f->tf.lo);
    iso_gl_set_float(program, "roi_tf_scale", t->value_per_texel * entries);
    iso_gl_set_float(program, "roi_tf_offset", (f->level.min - f->tf.lo) * entries);
    iso_gl_set_int(program, "roi_tf_count", (int)f->tf.count);
    iso_gl_set_vec3(program, "roi_place_scale", iso_v3(scale[0], scale[1], scale[2]));
    iso_gl_set_vec3(program, "roi_place_offset", iso_v3(offset[0], offset[1], offset[2]));
    iso_gl_set_vec3(program, "roi_lo", iso_v3(f->lo[0], f->lo[1], f->lo[2]));
    iso_gl_set_vec3(program, "roi_hi", iso_v3(f->hi[0], f->hi[1], f->hi[2]));
    iso_gl_set_float(program, "roi_band", f->band);
    iso_gl_set_vec3(program, "index_per_p", iso_v3((double)size[0], (double)size[1], (double)size[2]));
}

/* ---- rendering -------------------------------------------------------------- */

static iso_status get_program(iso_gl *gl, iso_code code, const iso_gl_options *opt, const iso_view *view,
                              const level_textures *t, GLuint *program, iso_error *err)
{
    static const int sources[ISO_SOURCE_COUNT] = {
        [ISO_FROM_CODES] = SOURCE_CODES,     [ISO_FROM_DECODED] = SOURCE_VECTORS,
        [ISO_FROM_FLOAT] = SOURCE_VECTORS,   [ISO_FROM_ON_THE_FLY] = SOURCE_ON_THE_FLY,
        [ISO_FROM_PALETTE] = SOURCE_PALETTE, [ISO_FROM_PALETTE_NEAREST] = SOURCE_NEAREST,
        [ISO_FROM_FLIPPED] = SOURCE_FLIPPED};
    const iso_gl_variant variant = {
        .direction_source = sources[opt->source],
        .decoder = opt->source == ISO_FROM_CODES ? iso_code_describe(code)->decoder : 0,
        .output = iso_gl_output(opt->surface),
        .light_count = view->light_count,
        .specular = view->shading.specular > 0,
        .shade_table = is_from_palette(opt->source) && opt->shade_table,
        .scalar_with_directions = t->scalar_with_directions,
        .skip_empty = t->skip_empty,
        .screen_tile = t->skip_empty && !opt->surface ? ISO_SCREEN_TILE : 0,
        .preintegrated = opt->preintegrated,
        .exact = opt->exact_lookups,
        .filtered_by_hand = iso_gl_filters_by_hand(gl, opt->fast_filter),
        .roi = view->roi != NULL,
        .tf_2d_rows = view->tf_2d ? ISO_TF_2D_ROWS : 0,
        .extinction_scale = opt->surface || !view->extinction_scale ? SCALE_NONE
                            : has_direction_texture(opt->source)    ? SCALE_WITH_DIRECTIONS
                                                                    : SCALE_ALONE,
    };
    return iso_gl_get_variant(gl, &variant, program, err);
}

static iso_status check_options(const iso_gl_options *opt, const iso_view *view, iso_error *err)
{
    if (opt->surface && (view->tf_2d || !isfinite(opt->surface->iso)))
        return iso_fail(err, ISO_E_USAGE, "gl: an isosurface has one finite value and no 2D transfer function");
    if (!(opt->step_voxels > 0 && isfinite(opt->step_voxels)))
        return iso_fail(err, ISO_E_RANGE, "gl: step %g voxels, must be above 0", opt->step_voxels);
    if (opt->exact_lookups && (opt->surface || opt->preintegrated || view->roi))
        return iso_fail(err, ISO_E_USAGE,
                        "gl: exact lookups are for the integral by midpoints, without a region of interest");
    if (view->tf_2d && opt->preintegrated)
        return iso_fail(err, ISO_E_USAGE, "gl: a TF over two values is not pre-integrated");
    if (view->roi && (opt->surface || opt->preintegrated || opt->source > ISO_FROM_FLOAT))
        return iso_fail(err, ISO_E_USAGE,
                        "gl: a region of interest takes codes, decoded or float directions, and no surface or "
                        "pre-integration");
    return ISO_OK;
}

iso_status iso_gl_render(iso_gl *gl, const iso_level *level, iso_code code, const iso_view *view,
                         const iso_gl_options *options, iso_image *image, iso_error *err)
{
    iso_gl_options with_step = *options, *opt = &with_step;
    /* A surface's place is counted in segments, so segments are voxels there, for any step. */
    const double step_voxels = opt->step_voxels = opt->surface           ? 1
                                                  : opt->step_voxels > 0 ? opt->step_voxels
                                                                         : view->step_voxels;
    const double step_mm = step_voxels * iso_geometry_min_spacing_mm(iso_view_step_geometry(view, &level->geometry));
    *image = (iso_image){0};
    NEED(check_options(opt, view, err));
    GLuint program;
    level_textures textures, roi_textures = {0};
    iso_gl_stats stats = {0};
    const double start = iso_clock_seconds();
    if (view->roi)
        with_step.skip = ISO_GL_SKIP_NEVER; /* a brick is empty in one level and not in the other */
    iso_status status = iso_gl_bind(gl, err);
    TRY(status, upload(gl, level, code, opt, view, &textures, err));
    if (status != ISO_OK)
        return status;
    if (view->roi)
        status = upload_roi(gl, view->roi, code, opt->source, &roi_textures, err);
    TRY(status, get_program(gl, code, opt, view, &textures, &program, err));
    TRY(status, iso_image_create(image, view->width, view->height, err));
    if (status == ISO_OK) {
        glUseProgram(program);
        iso_gl_set_camera(program, &level->geometry, view, step_mm);
        set_field(program, level, &textures, opt, view->tf_2d ? &view->tf_2d->rows[0] : &view->tf);
        iso_gl_set_light(program, view);
        if (view->roi)
            set_roi(program, view->roi, &level->geometry, &roi_textures);
    }
    double least = INFINITY;
    if (status == ISO_OK) {
        glFinish();
        stats.texture_bytes = bytes_of(&textures) + bytes_of(&roi_textures);
        stats.upload_seconds = iso_clock_seconds() - start;
        const iso_gl_repeats repeats = {opt->repeats,
                                        opt->repeat_seconds,
                                        {textures.reach ? &textures.screen : NULL, view->background,
                                         2 * iso_geometry_box_radius_mm(&level->geometry) / step_mm}};
        status = iso_gl_draw_repeatedly(gl, program, &repeats, image, &least, &stats, err);
        least += gl->times_processor ? textures.screen_processor_seconds : textures.screen_seconds;
    }
    for (size_t i = 0; i < stats.draw_count; ++i) {
        stats.draw_seconds[i] += textures.screen_seconds;
        stats.draw_processor_seconds[i] += textures.screen_processor_seconds;
    }
    if (opt->stats)
        *opt->stats = stats;
    if (opt->seconds)
        *opt->seconds = least;
    destroy_textures(&textures);
    destroy_textures(&roi_textures);
    if (status != ISO_OK)
        iso_image_destroy(image);
    return status;
}

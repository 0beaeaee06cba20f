/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "lab/warp_gl.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/embed.h"
#include "base/parallel.h"
#include "brick/occupancy.h"
#include "render/gl/gl_context.h"
#include "render/gl/gl_uniforms.h"
#include "render/gl/gl_variant.h"

ISO_EMBED(iso_warp_map_glsl, "src/lab/warp_map.h");
ISO_EMBED(iso_transition_glsl, "src/lab/transition.glsl");

enum { UNIT_SCALAR, UNIT_TF, UNIT_DIRECTIONS, UNIT_OCCUPANCY, UNIT_LAYOUT, UNIT_NEIGHBORS, UNIT_POINTS };

typedef struct warp_cache {
    iso_gl *gl;
    const iso_warp_field *field;
    const iso_level *level; /* whose field it is */
    const iso_gl_brick_options *opt;
    size_t count[3]; /* bricks */
    size_t size[3];  /* texels of the cache */
    GLuint scalar, directions, tf, occupancy, layout, neighbors;
    bool skip_empty, shaded;
    double zero, per_texel; /* value = zero + texel * per_texel */
} warp_cache;

static size_t all_bricks(const warp_cache *c)
{
    return c->count[0] * c->count[1] * c->count[2];
}

static void brick_at(const warp_cache *c, size_t i, size_t brick[3])
{
    brick[0] = i % c->count[0];
    brick[1] = i / c->count[0] % c->count[1];
    brick[2] = i / (c->count[0] * c->count[1]);
}

static void destroy_cache(warp_cache *c)
{
    const GLuint names[6] = {c->scalar, c->directions, c->tf, c->occupancy, c->layout, c->neighbors};
    glDeleteTextures(6, names);
}

/* ---- packing (section 3.2) ------------------------------------------------------ */

/* Places each brick's first sample in the cache: one slot per fine brick, then slots of eight coarse ones. */
static void place_bricks(warp_cache *c, const uint8_t *held, size_t (*at)[3])
{
    const iso_warp_field *f = c->field;
    const size_t slot_side = f->brick_voxels + 2;
    size_t fine = 0, coarse = 0;
    for (size_t i = 0; i < all_bricks(c); ++i)
        if (held[i])
            ++*(f->levels[i] ? &coarse : &fine);
    const size_t slot_count = fine + (coarse + 7) / 8 > 0 ? fine + (coarse + 7) / 8 : 1;
    size_t row = (size_t)ceil(cbrt((double)slot_count) - 1e-9), next_fine = 0, next_coarse = 8 * fine;
    const size_t slots[3] = {row, row, (slot_count + row * row - 1) / (row * row)};
    for (int a = 0; a < 3; ++a)
        c->size[a] = slots[a] * slot_side;
    for (size_t i = 0; i < all_bricks(c); ++i) {
        if (!held[i])
            continue;
        const size_t part = f->levels[i] ? next_coarse++ : 8 * next_fine++, slot = part / 8;
        const size_t corner[3] = {slot % row, slot / row % row, slot / (row * row)};
        for (int a = 0; a < 3; ++a)
            at[i][a] = corner[a] * slot_side + (part >> a & 1) * (slot_side / 2);
    }
}

/* ---- upload ---------------------------------------------------------------------- */

typedef struct staging { /* one brick on its way */
    float *baked, *vectors;
    void *scalars;
} staging;

static void upload_brick(const warp_cache *c, size_t i, const size_t at[3], int bits, staging *s)
{
    const iso_warp_field *f = c->field;
    size_t brick[3];
    brick_at(c, i, brick);
    const size_t side = iso_warp_cache_side(f, brick), count = side * side * side;
    const GLint x = (GLint)at[0], y = (GLint)at[1], z = (GLint)at[2];
    const GLsizei m = (GLsizei)side;
    uint16_t *codes = s->scalars;
    float *parts = s->scalars;
    iso_warp_bake(f, brick, s->baked);
    for (size_t k = 0; k < count; ++k) {
        const double part = ((double)s->baked[f->channels * k] - c->zero) / c->per_texel;
        if (bits == 16)
            codes[k] = (uint16_t)lrint(65535 * fmin(fmax(part, 0), 1));
        else
            parts[k] = (float)part;
        for (size_t a = 0; c->shaded && a < 3; ++a)
            s->vectors[3 * k + a] = s->baked[f->channels * k + 1 + a];
    }
    glActiveTexture(GL_TEXTURE0 + UNIT_SCALAR);
    glTexSubImage3D(GL_TEXTURE_3D, 0, x, y, z, m, m, m, GL_RED, bits == 16 ? GL_UNSIGNED_SHORT : GL_FLOAT, s->scalars);
    glActiveTexture(GL_TEXTURE0 + UNIT_DIRECTIONS);
    if (c->shaded)
        glTexSubImage3D(GL_TEXTURE_3D, 0, x, y, z, m, m, m, GL_RGB, GL_FLOAT, s->vectors);
}

static iso_status fill_cache(const iso_gl *gl, warp_cache *c, const uint8_t *held, size_t (*at)[3], int bits,
                             iso_error *err)
{
    const size_t side = c->field->brick_voxels + 2, count = side * side * side;
    staging s = {malloc(count * c->field->channels * sizeof(float)), malloc(3 * count * sizeof(float)),
                 malloc(count * sizeof(float))};
    iso_status status = ISO_OK;
    if (!s.baked || !s.vectors || !s.scalars)
        status = iso_fail(err, ISO_E_MEMORY, "gl: no memory for a brick of %zu voxels", count);
    glActiveTexture(GL_TEXTURE0 + UNIT_SCALAR);
    TRY(status, iso_gl_create_texture_3d(gl, bits == 16 ? GL_R16 : GL_R32F, c->size, "a brick cache", &c->scalar, err));
    TRY(status, iso_gl_clear_texture_3d(c->size, err));
    glActiveTexture(GL_TEXTURE0 + UNIT_DIRECTIONS);
    if (status == ISO_OK && c->shaded)
        status = iso_gl_create_texture_3d(gl, bits == 16 ? GL_RGBA16_SNORM : GL_RGB32F, c->size,
                                          "a brick cache of directions", &c->directions, err);
    if (status == ISO_OK && c->shaded)
        status = iso_gl_clear_texture_3d(c->size, err);
    for (size_t i = 0; status == ISO_OK && i < all_bricks(c); ++i)
        if (held[i])
            upload_brick(c, i, at[i], bits, &s);
    free(s.baked);
    free(s.vectors);
    free(s.scalars);
    return status == ISO_OK ? iso_gl_check("filling the brick cache", err) : status;
}

/* How GL stores a table's texels, and how they are given to it. */
typedef struct texel_format {
    GLenum stored, channels, type;
} texel_format;

/* Uploads one texel per brick, nearest. */
static iso_status upload_table(const iso_gl *gl, const warp_cache *c, texel_format format, const void *texels,
                               GLuint *texture, iso_error *err)
{
    iso_status status = iso_gl_create_texture_3d(gl, format.stored, c->count, "a brick layout", texture, err);
    if (status != ISO_OK)
        return status;
    glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    glTexSubImage3D(GL_TEXTURE_3D, 0, 0, 0, 0, (GLsizei)c->count[0], (GLsizei)c->count[1], (GLsizei)c->count[2],
                    format.channels, format.type, texels);
    return iso_gl_check("uploading the brick layout", err);
}

static iso_status upload_layout(const iso_gl *gl, warp_cache *c, const uint8_t *held, size_t (*at)[3], iso_error *err)
{
    const size_t count = all_bricks(c);
    float *texels = calloc(count, 4 * sizeof *texels);
    uint32_t *bits = malloc(count * sizeof *bits);
    iso_status status = ISO_OK;
    if (!texels || !bits)
        status = iso_fail(err, ISO_E_MEMORY, "gl: no memory for the layout of %zu bricks", count);
    for (size_t i = 0; status == ISO_OK && i < count; ++i) {
        size_t brick[3];
        brick_at(c, i, brick);
        bits[i] = iso_warp_neighbors(c->field, brick);
        /* The low corner of a fine brick is a texel past its border's, that of a coarse one in its first sample. */
        const double corner = c->field->levels[i] ? 0.5 : 1;
        for (size_t a = 0; held[i] && a < 3; ++a)
            texels[4 * i + a] = (float)(((double)at[i][a] + corner) / (double)c->size[a]);
        texels[4 * i + 3] = held[i] ? (c->field->levels[i] ? 0.5f : 1.0f) : 0;
    }
    glActiveTexture(GL_TEXTURE0 + UNIT_LAYOUT);
    if (status == ISO_OK)
        status = upload_table(gl, c, (texel_format){GL_RGBA32F, GL_RGBA, GL_FLOAT}, texels, &c->layout, err);
    glActiveTexture(GL_TEXTURE0 + UNIT_NEIGHBORS);
    if (status == ISO_OK)
        status = upload_table(gl, c, (texel_format){GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT}, bits, &c->neighbors,
                              err);
    free(texels);
    free(bits);
    return status;
}

/* ---- culling ---------------------------------------------------------------------- */

/* Finds the visible bricks. distance: from each brick to the nearest visible one. held: visible bricks and their
 * neighbors, whose samples their transitions fetch. */
static iso_status cull(const warp_cache *c, const iso_level *level, const iso_tf_table *tf, uint8_t *distance,
                       uint8_t *held, double *shown, iso_error *err)
{
    iso_brick_ranges r;
    iso_status status = iso_brick_ranges_create(&r, level->scalar, &level->geometry, c->field->brick_voxels, err);
    if (status != ISO_OK)
        return status;
    *shown = iso_occupancy_compute(&r, tf, distance);
    for (size_t i = 0; i < all_bricks(c); ++i)
        held[i] = distance[i] <= 1;
    iso_brick_ranges_destroy(&r);
    return ISO_OK;
}

/* Creates the cache without the bricks that tf hides. NULL: all bricks. */
static iso_status create_cache(warp_cache *c, const iso_tf_table *tf, iso_gl_brick_stats *stats, iso_error *err)
{
    const iso_gl *gl = c->gl;
    const iso_warp_field *f = c->field;
    const iso_level *level = c->level;
    const iso_gl_brick_options *opt = c->opt;
    c->zero = level->min;
    c->per_texel = level->max > level->min ? level->max - level->min : 1;
    c->shaded = opt->shaded && f->channels == ISO_WARP_CHANNELS;
    for (int a = 0; a < 3; ++a)
        c->count[a] = iso_warp_bricks(f, a);
    const size_t count = all_bricks(c);
    uint8_t *distance = calloc(count, 1), *held = malloc(count);
    size_t(*at)[3] = malloc(count * sizeof *at);
    double shown = 1;
    iso_status status = ISO_OK;
    if (!distance || !held || !at)
        status = iso_fail(err, ISO_E_MEMORY, "gl: no memory for %zu bricks", count);
    else
        memset(held, 1, count);
    if (status == ISO_OK && tf)
        status = cull(c, level, tf, distance, held, &shown, err);
    if (status == ISO_OK) {
        place_bricks(c, held, at);
        status = fill_cache(gl, c, held, at, opt->cache_bits, err);
    }
    TRY(status, upload_layout(gl, c, held, at, err));
    c->skip_empty = opt->skip == ISO_GL_SKIP_ALWAYS || opt->surface ||
                    (opt->skip == ISO_GL_SKIP_AUTO && shown <= ISO_GL_SKIP_OCCUPIED);
    glActiveTexture(GL_TEXTURE0 + UNIT_OCCUPANCY);
    if (status == ISO_OK && c->skip_empty)
        status = iso_gl_create_occupancy(gl, c->count, distance, &c->occupancy, err);
    *stats = (iso_gl_brick_stats){.brick_count = count,
                                  .slot_side = f->brick_voxels + 2,
                                  .texel_count = c->size[0] * c->size[1] * c->size[2]};
    for (size_t i = 0; status == ISO_OK && i < count; ++i)
        stats->shown_count += held[i] != 0;
    free(distance);
    free(held);
    free(at);
    if (status != ISO_OK)
        destroy_cache(c);
    return status;
}

/* ---- drawing ------------------------------------------------------------------ */

static void set_field(GLuint program, const warp_cache *c)
{
    const double side = (double)c->field->brick_voxels;
    const size_t *size = c->level->geometry.size;
    iso_gl_set_int(program, "scalar", UNIT_SCALAR);
    iso_gl_set_int(program, "tf", UNIT_TF);
    iso_gl_set_int(program, "directions", UNIT_DIRECTIONS);
    iso_gl_set_int(program, "occupancy", UNIT_OCCUPANCY);
    iso_gl_set_int(program, "layout_of_bricks", UNIT_LAYOUT);
    iso_gl_set_int(program, "coarse_neighbors", UNIT_NEIGHBORS);
    iso_gl_set_int(program, "points", UNIT_POINTS);
    iso_gl_set_float(program, "brick_side", side);
    iso_gl_set_vec3(program, "bricks_per_volume", iso_v3(1, 1, 1));
    iso_gl_set_vec3(program, "brick_in_cache",
                    iso_v3(side / (double)c->size[0], side / (double)c->size[1], side / (double)c->size[2]));
    iso_gl_set_vec3(program, "last_node",
                    iso_v3((double)size[0] / side, (double)size[1] / side, (double)size[2] / side));
}

/* Returns the program for a view, or without one (NULL) for the field at points. */
static iso_status get_program(const warp_cache *c, const iso_view *view, GLuint *program, iso_error *err)
{
    static const char *const transitions[ISO_WARP_MODE_COUNT] = {[ISO_WARP_NONE] = "ISO_TRANSITION_NONE",
                                                                 [ISO_WARP_WRITTEN] = "ISO_TRANSITION_WRITTEN",
                                                                 [ISO_WARP_CORRECTED] = "ISO_TRANSITION_CORRECTED"};
    const bool lit = c->shaded && view;
    char *text = malloc(strlen(iso_warp_map_glsl) + strlen(iso_transition_glsl) + 1);
    if (!text)
        return iso_fail(err, ISO_E_MEMORY, "gl: no memory for a shader");
    strcpy(stpcpy(text, iso_warp_map_glsl), iso_transition_glsl);
    const iso_gl_variant variant = {
        .direction_source = SOURCE_VECTORS,
        .output = view ? iso_gl_output(c->opt->surface) : OUTPUT_POINTS,
        .light_count = lit ? view->light_count : 0,
        .specular = lit && view->shading.specular > 0,
        .skip_empty = c->skip_empty,
        .bricks = true,
        .filtered_by_hand = iso_gl_filters_by_hand(c->gl, c->opt->fast_filter),
        .transition = transitions[c->field->mode],
    };
    c->gl->transition = text;
    const iso_status status = iso_gl_get_variant(c->gl, &variant, program, err);
    c->gl->transition = NULL;
    free(text);
    return status;
}

static iso_status draw(const warp_cache *c, const iso_view *view, double step_voxels, iso_image *image,
                       iso_gl_brick_stats *stats, iso_error *err)
{
    iso_gl *gl = c->gl;
    const iso_geometry *g = &c->level->geometry;
    GLuint program;
    const double per_brick = 1 / (double)c->field->brick_voxels;
    iso_status status = get_program(c, view, &program, err);
    TRY(status, iso_image_create(image, view->width, view->height, err));
    if (status != ISO_OK)
        return status;
    glUseProgram(program);
    iso_gl_set_camera(program, g, view, step_voxels * iso_geometry_min_spacing_mm(g));
    iso_gl_set_coordinates(program, iso_v3(per_brick, per_brick, per_brick), iso_v3(0, 0, 0));
    set_field(program, c);
    iso_gl_set_tf(program, &view->tf, c->zero, c->per_texel);
    iso_gl_set_light(program, view);
    stats->seconds = INFINITY;
    for (size_t i = 0; status == ISO_OK && i < (c->opt->repeats ? c->opt->repeats : 1); ++i) {
        double once;
        status = iso_gl_draw(gl, program, view->width, view->height, (iso_gl_cover){0}, image->rgba, &once, err);
        stats->seconds = fmin(stats->seconds, once);
    }
    if (status != ISO_OK)
        iso_image_destroy(image);
    return status;
}

iso_status iso_gl_render_warp(iso_gl *gl, const iso_gl_warp *warp, const iso_view *view,
                              const iso_gl_brick_options *opt, iso_image *image, iso_gl_brick_stats *stats,
                              iso_error *err)
{
    const double step_voxels = opt->step_voxels > 0 ? opt->step_voxels : view->step_voxels, start = iso_clock_seconds();
    iso_gl_brick_stats own;
    warp_cache cache = {.gl = gl, .field = warp->field, .level = warp->level, .opt = opt};
    stats = stats ? stats : &own;
    *image = (iso_image){0};
    if (!(step_voxels > 0 && isfinite(step_voxels)) || (opt->cache_bits != 16 && opt->cache_bits != 32) || opt->surface)
        return iso_fail(err, ISO_E_RANGE,
                        "gl: step %g voxels must be above 0, cache of %d bits 16 or 32; no isosurfaces", step_voxels,
                        opt->cache_bits);
    iso_status status = iso_gl_bind(gl, err);
    TRY(status, create_cache(&cache, &view->tf, stats, err));
    if (status != ISO_OK)
        return status;
    glActiveTexture(GL_TEXTURE0 + UNIT_TF);
    status = iso_gl_create_texture_rgba32f(gl, view->tf.count, 1, view->tf.entries, &cache.tf, err);
    glFinish();
    stats->bake_seconds = iso_clock_seconds() - start;
    TRY(status, draw(&cache, view, step_voxels, image, stats, err));
    destroy_cache(&cache);
    return status;
}

iso_status iso_gl_sample_warp(iso_gl *gl, const iso_gl_warp *warp, const double *places, size_t count, float *out,
                              iso_error *err)
{
    enum { width = 256 };
    const iso_gl_brick_options opt = {.shaded = true, .cache_bits = 32, .skip = ISO_GL_SKIP_NEVER};
    const size_t height = (count + width - 1) / width;
    const double side = (double)warp->field->brick_voxels;
    iso_gl_brick_stats stats;
    warp_cache cache = {.gl = gl, .field = warp->field, .level = warp->level, .opt = &opt};
    GLuint program, points = 0;
    iso_status status = iso_gl_bind(gl, err);
    TRY(status, create_cache(&cache, NULL, &stats, err));
    if (status != ISO_OK)
        return status;
    float *texels = calloc(4 * width * height, sizeof *texels), *image = malloc(4 * width * height * sizeof *image);
    if (!texels || !image)
        status = iso_fail(err, ISO_E_MEMORY, "gl: no memory for %zu places", count);
    for (size_t i = 0; status == ISO_OK && i < 4 * count; ++i)
        texels[i] = (float)(i % 4 < 3 ? places[i] / side : places[i]);
    glActiveTexture(GL_TEXTURE0 + UNIT_POINTS);
    TRY(status, iso_gl_create_texture_rgba32f(gl, width, height, texels, &points, err));
    TRY(status, get_program(&cache, NULL, &program, err));
    if (status == ISO_OK) {
        glUseProgram(program);
        set_field(program, &cache);
        status = iso_gl_draw(gl, program, width, height, (iso_gl_cover){0}, image, NULL, err);
    }
    for (size_t i = 0; status == ISO_OK && i < 4 * count; ++i)
        out[i] = i % 4 ? image[i] : (float)(cache.zero + (double)image[i] * cache.per_texel);
    free(texels);
    free(image);
    glDeleteTextures(1, &points);
    destroy_cache(&cache);
    return status;
}

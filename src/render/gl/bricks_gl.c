/* SPDX-License-Identifier: MIT */
#include "render/gl/bricks_gl.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/parallel.h"
#include "brick/occupancy.h"
#include "brick/pack.h"
#include "render/brick_visible.h"
#include "render/gl/gl_context.h"
#include "render/gl/gl_uniforms.h"
#include "render/gl/gl_variant.h"

enum { UNIT_SCALAR, UNIT_TF, UNIT_DIRECTIONS, UNIT_OCCUPANCY, UNIT_LAYOUT, UNIT_PAGES };
enum { MORE_PAGES = ISO_BRICK_MAX_PAGES - 1 };

/* Returns the texture unit of page k; the first page uses that of an unpaged cache. */
static GLenum unit_of_scalar(size_t k)
{
    return (GLenum)(k == 0 ? UNIT_SCALAR : UNIT_PAGES + k - 1);
}
static GLenum unit_of_directions(size_t k)
{
    return (GLenum)(k == 0 ? UNIT_DIRECTIONS : UNIT_PAGES + MORE_PAGES + k - 1);
}

typedef struct brick_textures {
    GLuint scalar[ISO_BRICK_MAX_PAGES], directions[ISO_BRICK_MAX_PAGES], tf, occupancy, layout;
    bool skip_empty, scalar_with_directions; /* instead of textures of its own */
} brick_textures;

iso_gl_brick_options iso_gl_brick_defaults(void)
{
    return (iso_gl_brick_options){.shaded = true, .cache_bits = 16, .repeats = 1};
}

static void destroy_textures(brick_textures *t)
{
    const GLuint names[3] = {t->tf, t->occupancy, t->layout};
    glDeleteTextures(3, names);
    glDeleteTextures(ISO_BRICK_MAX_PAGES, t->scalar);
    glDeleteTextures(ISO_BRICK_MAX_PAGES, t->directions);
}

static double bytes_of(const brick_textures *t)
{
    double bytes = iso_gl_texture_bytes(GL_TEXTURE_2D, t->tf) + iso_gl_texture_bytes(GL_TEXTURE_3D, t->occupancy) +
                   iso_gl_texture_bytes(GL_TEXTURE_3D, t->layout);
    for (size_t k = 0; k < ISO_BRICK_MAX_PAGES; ++k)
        bytes += iso_gl_texture_bytes(GL_TEXTURE_3D, t->scalar[k]) +
                 iso_gl_texture_bytes(GL_TEXTURE_3D, t->directions[k]);
    return bytes;
}

/* ---- the cache ---------------------------------------------------------------- */

typedef struct staging { /* one brick on its way */
    float *baked, *vectors;
    void *scalars;
    int16_t *vectors16;
    uint16_t *texels; /* of four channels, unsigned: the directions from -1 on, the scalar */
} staging;

static void free_staging(staging *s)
{
    free(s->baked);
    free(s->vectors);
    free(s->scalars);
    free(s->vectors16);
    free(s->texels);
}

/* Converts values to parts of the range, in 16 bits or floats; copies directions. */
static void convert(const iso_node_levels *n, int bits, size_t count, staging *s)
{
    uint16_t *codes = s->scalars;
    float *parts = s->scalars;
    for (size_t i = 0; i < count; ++i) {
        const float *node = s->baked + ISO_NODE_CHANNELS * i;
        if (bits == 16)
            codes[i] = iso_node_scalar16(n, node[0]);
        else
            parts[i] = (float)iso_node_part(n, node[0]);
        for (size_t a = 0; a < 3; ++a) {
            s->vectors[3 * i + a] = node[1 + a];
            s->vectors16[3 * i + a] = iso_node_direction16(node[1 + a]);
            s->texels[4 * i + a] = (uint16_t)(s->vectors16[3 * i + a] + 32767);
        }
        s->texels[4 * i + 3] = bits == 16 ? codes[i] : 0;
    }
}

static iso_status upload_brick(const iso_brick_field *f, const iso_brick_pack *pack, size_t i,
                               const iso_gl_brick_options *opt, bool scalar_with_directions, staging *s, iso_error *err)
{
    const iso_node_levels *n = f->nodes;
    const size_t brick[3] = {i % n->count[0], i / n->count[0] % n->count[1], i / (n->count[0] * n->count[1])};
    size_t side = iso_brick_side(n, f->levels[i]);
    const float *at = pack->layout + 4 * i;
    const size_t page = (size_t)at[2] / pack->size[2];
    const GLint x = (GLint)at[0], y = (GLint)at[1], z = (GLint)((size_t)at[2] % pack->size[2]);
    GLsizei m = (GLsizei)side;
    NEED(iso_brick_bake(f, brick, s->baked, err));
    convert(n, opt->cache_bits, side * side * side, s);
    if (scalar_with_directions) {
        glActiveTexture(GL_TEXTURE0 + unit_of_directions(page));
        glTexSubImage3D(GL_TEXTURE_3D, 0, x, y, z, m, m, m, GL_RGBA, GL_UNSIGNED_SHORT, s->texels);
        return ISO_OK;
    }
    glActiveTexture(GL_TEXTURE0 + unit_of_scalar(page));
    glTexSubImage3D(GL_TEXTURE_3D, 0, x, y, z, m, m, m, GL_RED, opt->cache_bits == 16 ? GL_UNSIGNED_SHORT : GL_FLOAT,
                    s->scalars);
    if (!opt->shaded)
        return ISO_OK;
    glActiveTexture(GL_TEXTURE0 + unit_of_directions(page));
    if (opt->cache_bits == 16)
        glTexSubImage3D(GL_TEXTURE_3D, 0, x, y, z, m, m, m, GL_RGB, GL_SHORT, s->vectors16);
    else
        glTexSubImage3D(GL_TEXTURE_3D, 0, x, y, z, m, m, m, GL_RGB, GL_FLOAT, s->vectors);
    return ISO_OK;
}

static iso_status fill_cache(const iso_gl *gl, const iso_brick_field *f, const iso_brick_pack *pack,
                             const iso_gl_brick_options *opt, brick_textures *t, iso_error *err)
{
    const bool small = opt->cache_bits == 16, together = t->scalar_with_directions;
    const GLenum directions = together ? GL_RGBA16 : small ? GL_RGBA16_SNORM : GL_RGB32F;
    size_t side = f->nodes->brick_voxels + 1, count = side * side * side;
    staging s = {malloc(count * ISO_NODE_CHANNELS * sizeof(float)), malloc(3 * count * sizeof(float)),
                 malloc(count * sizeof(float)), malloc(3 * count * sizeof(int16_t)),
                 malloc(4 * count * sizeof(uint16_t))};
    iso_status status = ISO_OK;
    if (!s.baked || !s.vectors || !s.scalars || !s.vectors16 || !s.texels)
        status = iso_fail(err, ISO_E_MEMORY, "gl: no memory for a brick of %zu nodes", count);
    for (size_t k = 0; k < pack->page_count; ++k) {
        glActiveTexture(GL_TEXTURE0 + unit_of_scalar(k));
        if (status == ISO_OK && !together)
            status = iso_gl_create_texture_3d(gl, small ? GL_R16 : GL_R32F, pack->size, "a brick cache", &t->scalar[k],
                                              err);
        if (status == ISO_OK && !together)
            status = iso_gl_clear_texture_3d(pack->size, err);
        glActiveTexture(GL_TEXTURE0 + unit_of_directions(k));
        if (status == ISO_OK && opt->shaded)
            status = iso_gl_create_texture_3d(gl, directions, pack->size, "a brick cache of directions",
                                              &t->directions[k], err);
        if (status == ISO_OK && opt->shaded)
            status = iso_gl_clear_texture_3d(pack->size, err);
    }
    for (size_t i = 0; status == ISO_OK && i < iso_brick_count(f->nodes); ++i)
        if (pack->layout[4 * i + 3] > 0)
            status = upload_brick(f, pack, i, opt, together, &s, err);
    free_staging(&s);
    return status == ISO_OK ? iso_gl_check("filling the brick cache", err) : status;
}

/* Uploads the layout, with offsets as texture coordinates of node centers. */
static iso_status upload_layout(const iso_gl *gl, const iso_node_levels *n, const iso_brick_pack *pack,
                                brick_textures *t, iso_error *err)
{
    size_t count = iso_brick_count(n);
    FREED float *texels = malloc(4 * count * sizeof *texels);
    NEED_MEMORY(texels, err, "gl: no memory for the layout of %zu bricks", count);
    for (size_t i = 0; i < 4 * count; ++i)
        texels[i] = i % 4 == 3 ? pack->layout[i] : (float)(((double)pack->layout[i] + 0.5) / (double)pack->size[i % 4]);
    glActiveTexture(GL_TEXTURE0 + UNIT_LAYOUT);
    NEED(iso_gl_create_texture_3d(gl, GL_RGBA32F, n->count, "a brick layout", &t->layout, err));
    glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    glTexSubImage3D(GL_TEXTURE_3D, 0, 0, 0, 0, (GLsizei)n->count[0], (GLsizei)n->count[1], (GLsizei)n->count[2],
                    GL_RGBA, GL_FLOAT, texels);
    return iso_gl_check("uploading the brick layout", err);
}

/* Uploads the distances to the nearest visible brick; they replace visible[b]. */
static iso_status upload_occupancy(const iso_gl *gl, const iso_node_levels *n, uint8_t *visible, double shown,
                                   const iso_gl_brick_options *opt, brick_textures *t, iso_error *err)
{
    t->skip_empty = opt->skip == ISO_GL_SKIP_ALWAYS || opt->surface ||
                    (opt->skip == ISO_GL_SKIP_AUTO && shown <= ISO_GL_SKIP_OCCUPIED);
    if (!t->skip_empty)
        return ISO_OK;
    for (size_t i = 0; i < iso_brick_count(n); ++i)
        visible[i] = visible[i] ? 0 : 255;
    iso_occupancy_distance(n->count, visible);
    glActiveTexture(GL_TEXTURE0 + UNIT_OCCUPANCY);
    return iso_gl_create_occupancy(gl, n->count, visible, &t->occupancy, err);
}

/* The bricks to draw, and their data on the GPU. */
typedef struct brick_job {
    iso_gl *gl;
    const iso_brick_field *field;
    const iso_view *view;
    const iso_gl_brick_options *opt;
    double step_voxels;
    iso_brick_pack pack;
    brick_textures textures;
} brick_job;

static iso_status upload(brick_job *job, iso_gl_brick_stats *stats, iso_error *err)
{
    const iso_gl *gl = job->gl;
    const iso_brick_field *f = job->field;
    const iso_view *view = job->view;
    const iso_gl_brick_options *opt = job->opt;
    const iso_node_levels *n = f->nodes;
    iso_brick_pack *pack = &job->pack;
    brick_textures *t = &job->textures;
    size_t count = iso_brick_count(n);
    uint8_t *visible = malloc(count);
    NEED_MEMORY(visible, err, "gl: no memory for %zu bricks", count);
    float entries[12];
    iso_tf_table surface = opt->surface ? iso_gl_surface_tf(opt->surface, n->min, n->max, entries) : view->tf;
    double shown = iso_brick_visible(f, view, &surface, opt->wanted, 0, visible);
    size_t largest = (size_t)gl->max_texture_3d_size;
    size_t page_side = opt->page_side && opt->page_side < largest ? opt->page_side : largest;
    iso_status status = iso_brick_pack_create(pack, n, f->levels, opt->keep_hidden ? NULL : visible, page_side,
                                              opt->max_slots, err);
    /* As in raycaster.c: one fetch of four channels is faster there than one of the scalar and one of the direction. */
    t->scalar_with_directions = gl->is_llvmpipe && opt->shaded && view->light_count > 0 && opt->cache_bits == 16 &&
                                !opt->surface;
    glActiveTexture(GL_TEXTURE0 + UNIT_TF);
    TRY(status, iso_gl_create_texture_rgba32f(gl, view->tf.count, 1, view->tf.entries, &t->tf, err));
    TRY(status, fill_cache(gl, f, pack, opt, t, err));
    TRY(status, upload_layout(gl, n, pack, t, err));
    TRY(status, upload_occupancy(gl, n, visible, shown, opt, t, err));
    *stats = (iso_gl_brick_stats){.brick_count = count,
                                  .shown_count = pack->brick_count,
                                  .slot_count = pack->slot_count,
                                  .slot_side = pack->slot_side,
                                  .texel_count = pack->page_count * pack->size[0] * pack->size[1] * pack->size[2],
                                  .page_count = pack->page_count,
                                  .node_count = pack->node_count};
    free(visible);
    if (status != ISO_OK)
        destroy_textures(t);
    return status;
}

/* ---- drawing ------------------------------------------------------------------ */

static void set_uniforms(GLuint program, const iso_brick_field *f, const iso_brick_pack *pack, const iso_view *view,
                         double step_voxels, const iso_surface *surface)
{
    const iso_node_levels *n = f->nodes;
    const iso_geometry *g = &n->geometry;
    double side = (double)n->brick_voxels;
    iso_gl_set_camera(program, g, view, step_voxels * iso_geometry_min_spacing_mm(g));
    iso_gl_set_coordinates(program, iso_v3(1 / side, 1 / side, 1 / side),
                           iso_v3(-0.5 / side, -0.5 / side, -0.5 / side));
    iso_gl_set_int(program, "scalar", UNIT_SCALAR);
    iso_gl_set_int(program, "tf", UNIT_TF);
    iso_gl_set_int(program, "directions", UNIT_DIRECTIONS);
    iso_gl_set_int(program, "occupancy", UNIT_OCCUPANCY);
    iso_gl_set_int(program, "layout_of_bricks", UNIT_LAYOUT);
    for (size_t k = 1; k < pack->page_count; ++k) {
        char name[48];
        snprintf(name, sizeof name, "scalar_pages[%zu]", k - 1);
        iso_gl_set_int(program, name, (int)unit_of_scalar(k));
        snprintf(name, sizeof name, "direction_pages[%zu]", k - 1);
        iso_gl_set_int(program, name, (int)unit_of_directions(k));
    }
    iso_gl_set_float(program, "direction_scale", 65535.0 / 32767);
    iso_gl_set_float(program, "direction_offset", -1);
    iso_gl_set_vec3(program, "bricks_per_volume", iso_v3(1, 1, 1));
    iso_gl_set_vec3(program, "brick_in_cache",
                    iso_v3(side / (double)pack->size[0], side / (double)pack->size[1], side / (double)pack->size[2]));
    iso_gl_set_vec3(program, "last_node",
                    iso_v3((double)(g->size[0] - 1) / side, (double)(g->size[1] - 1) / side,
                           (double)(g->size[2] - 1) / side));
    iso_gl_set_tf(program, &view->tf, n->min, n->max - n->min);
    if (surface)
        iso_gl_set_surface(program, surface, iso_v3(side, side, side), 0, n->min, n->max - n->min);
    iso_gl_set_light(program, view);
}

static iso_status get_program(const brick_job *job, GLuint *program, iso_error *err)
{
    const iso_view *view = job->view;
    const iso_gl_brick_options *opt = job->opt;
    const iso_gl_variant variant = {
        .direction_source = SOURCE_VECTORS,
        .scalar_with_directions = job->textures.scalar_with_directions,
        .output = iso_gl_output(opt->surface),
        .light_count = opt->shaded ? view->light_count : 0,
        .specular = opt->shaded && view->shading.specular > 0,
        .skip_empty = job->textures.skip_empty,
        .bricks = true,
        .filtered_by_hand = iso_gl_filters_by_hand(job->gl, opt->fast_filter),
        .pages = job->pack.page_count,
    };
    return iso_gl_get_variant(job->gl, &variant, program, err);
}

static iso_status draw(const brick_job *job, iso_image *image, iso_gl_brick_stats *stats, iso_error *err)
{
    const iso_gl_brick_options *opt = job->opt;
    const iso_gl_repeats repeats = {.count = opt->repeats, .seconds = opt->repeat_seconds};
    GLuint program;
    NEED(get_program(job, &program, err));
    NEED(iso_image_create(image, job->view->width, job->view->height, err));
    glUseProgram(program);
    set_uniforms(program, job->field, &job->pack, job->view, job->step_voxels, opt->surface);
    iso_status status = iso_gl_draw_repeatedly(job->gl, program, &repeats, image, &stats->seconds, &stats->gl, err);
    if (status != ISO_OK)
        iso_image_destroy(image);
    return status;
}

iso_status iso_gl_render_bricks(iso_gl *gl, const iso_brick_field *f, const iso_view *view,
                                const iso_gl_brick_options *opt, iso_image *image, iso_gl_brick_stats *stats,
                                iso_error *err)
{
    const double start = iso_clock_seconds();
    const double step_voxels = opt->surface ? 1 : opt->step_voxels > 0 ? opt->step_voxels : view->step_voxels;
    brick_job job = {.gl = gl, .field = f, .view = view, .opt = opt, .step_voxels = step_voxels};
    iso_gl_brick_stats own;
    stats = stats ? stats : &own;
    *image = (iso_image){0};
    if (!(step_voxels > 0 && isfinite(step_voxels)) || (opt->cache_bits != 16 && opt->cache_bits != 32))
        return iso_fail(err, ISO_E_RANGE, "gl: step %g voxels must be above 0, cache of %d bits 16 or 32", step_voxels,
                        opt->cache_bits);
    if (view->tf_2d || view->extinction_scale || view->roi)
        return iso_fail(err, ISO_E_RANGE,
                        "gl: bricks have no 2D transfer function, extinction scale or region of interest");
    iso_status status = iso_gl_bind(gl, err);
    TRY(status, upload(&job, stats, err));
    if (status == ISO_OK) {
        glFinish();
        stats->gl.texture_bytes = bytes_of(&job.textures);
        stats->bake_seconds = stats->gl.upload_seconds = iso_clock_seconds() - start;
        status = draw(&job, image, stats, err);
        destroy_textures(&job.textures);
    }
    iso_brick_pack_destroy(&job.pack);
    return status;
}

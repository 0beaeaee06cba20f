/* SPDX-License-Identifier: MIT */
/* palette_images.c - images of a volume by the GL ray caster, from palettes and from codes. */
#include "lab/palette.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/file.h"
#include "base/parallel.h"
#include "pyramid/palette_level.h"
#include "scene/subject.h"
#include "compare/metrics.h"
#include "render/gl/raycaster.h"

/* A volume with the data for its pictures. */
typedef struct stage {
    const palette_bench *bench;
    const char *name;
    iso_gl *gl;
    iso_pyramid pyramid; /* one level, with floats and magnitudes */
    iso_view view;
    iso_image wanted; /* rendered from floats */
    json_t *rows;
} stage;

/* A method's figures besides the image. */
typedef struct method {
    const char *name;
    double bytes;          /* per voxel, as uploaded; 3-byte codes of a texture of 3 components */
    double encode_seconds; /* fit and assign, or encode */
    double rms_deg;
} method;

static const double degrees = 57.29577951308232;

/* Sets the default view: opaque above the middle of the range, with a soft ramp, where most volumes have a surface. */
static iso_status default_view(stage *s, iso_error *err)
{
    static iso_tf_point points[] = {{0, {0.9, 0.6, 0.4}, 0},
                                    {0.18, {0.9, 0.6, 0.4}, 0},
                                    {0.35, {0.9, 0.7, 0.5}, 0.25},
                                    {0.6, {1, 0.95, 0.9}, 0.7},
                                    {1, {1, 1, 1}, 0.9}};
    size_t width = 256, height = 256;
    if (s->bench->look.size)
        NEED(iso_subject_parse_image_size(s->bench->look.size, &width, &height, err));
    const iso_level *level = &s->pyramid.levels[0];
    iso_scene scene = {.path = "bench",
                       .width = width,
                       .height = height,
                       .camera_fit = true,
                       .camera_direction = {0.6, -1, -0.25},
                       .camera_up = {0, 0, 1},
                       .fov_y_deg = 30,
                       .margin = 0.85,
                       .light_count = 1,
                       .lights = {{.direction = {-0.4, 0.6, 1}, .in_camera_space = true, .intensity = 1}},
                       .shading = {.ambient = 0.25, .diffuse = 0.75, .specular = 0.25, .power = 30},
                       .step_voxels = 0.5,
                       .tf = {.fit_range = true,
                              .unit_distance = 1,
                              .unit_is_voxels = true,
                              .table_size = 256,
                              .point_count = sizeof points / sizeof *points,
                              .points = points}};
    return iso_scene_resolve(&scene, &level->geometry, level->min, level->max, &s->view, err);
}

/* The shader's source of directions. */
typedef struct directions_by {
    iso_code code;
    iso_direction_source source;
    bool shade_table;
} directions_by;

static iso_status render(stage *s, const iso_level *level, directions_by by, iso_image *image, double *seconds,
                         iso_error *err)
{
    iso_gl_options opt = iso_gl_defaults();
    opt.source = by.source;
    opt.shade_table = by.shade_table;
    opt.repeats = 4; /* the first one compiles */
    opt.seconds = seconds;
    return iso_gl_render(s->gl, level, by.code, &s->view, &opt, image, err);
}

static iso_status add_row(stage *s, const iso_level *level, directions_by by, const method *m, iso_error *err)
{
    iso_image image;
    iso_metrics metrics;
    double seconds;
    NEED(render(s, level, by, &image, &seconds, err));
    iso_status status = iso_metrics_measure(&s->wanted, &image, &metrics, err);
    iso_image_destroy(&image);
    if (status != ISO_OK)
        return status;
    json_t *row = json_pack("{s:s, s:s, s:f, s:f, s:f, s:f}", "volume", s->name, "gradients", m->name, "bytes",
                            m->bytes, "encode_seconds", m->encode_seconds, "rms_deg", m->rms_deg, "milliseconds",
                            1e3 * seconds);
    json_object_update_new(row, iso_metrics_to_json(&metrics));
    json_array_append_new(s->rows, row);
    if (!s->bench->cli->json) {
        printf("  %-24s %5.4g %9.3f s %8.3f %10.2e %9.4f %9.6f %9.5f %8.1f\n", m->name, m->bytes, m->encode_seconds,
               m->rms_deg, metrics.rmse, metrics.max_abs, metrics.ssim, metrics.flip_mean, 1e3 * seconds);
        fflush(stdout);
    }
    return ISO_OK;
}

/* ---- codes ---------------------------------------------------------------------------------- */

/* Returns the RMS angle over voxels with a direction, at voxel centers. */
static double rms_angle_deg(const float *truth, const float *decoded, size_t count)
{
    double sum = 0;
    size_t used = 0;
    for (size_t i = 0; i < count; ++i) {
        const float *a = truth + 3 * i, *b = decoded + 3 * i;
        double aa = 0, bb = 0, ab = 0;
        for (int c = 0; c < 3; ++c) {
            aa += (double)a[c] * (double)a[c];
            bb += (double)b[c] * (double)b[c];
            ab += (double)a[c] * (double)b[c];
        }
        if (!(aa > 0))
            continue;
        double angle = degrees * atan2(sqrt(fmax(0, aa * bb - ab * ab)), ab);
        sum += angle * angle;
        ++used;
    }
    return used ? sqrt(sum / (double)used) : 0;
}

static iso_status code_row(stage *s, iso_code code, iso_error *err)
{
    iso_level level = s->pyramid.levels[0];
    size_t count = iso_geometry_voxel_count(&level.geometry);
    FREED uint8_t *bytes = malloc(3 * count);
    FREED float *decoded = malloc(3 * count * sizeof *decoded);
    NEED_MEMORY(bytes && decoded, err, "no memory for %zu directions", count);
    double start = iso_clock_seconds();
    iso_code_encode(code, level.directions, bytes, count);
    method m = {iso_code_describe(code)->name, 3, iso_clock_seconds() - start, 0};
    iso_code_decode_all(code, bytes, decoded, count);
    m.rms_deg = rms_angle_deg(level.directions, decoded, count);
    level.codes = bytes;
    return add_row(s, &level, (directions_by){code, ISO_FROM_CODES, false}, &m, err);
}

/* ---- palettes -------------------------------------------------------------------------------- */

/* Samples directions, weighted by opacity over a voxel times the gradient's magnitude, or all equally. */
static iso_status sample_level(stage *s, bool weighted, iso_direction_set *set, iso_error *err)
{
    const iso_level *l = &s->pyramid.levels[0];
    const iso_tf_table *tf = &s->view.tf;
    float *opacity = malloc(tf->count * sizeof *opacity);
    NEED_MEMORY(opacity, err, "no memory for %zu weights", tf->count);
    for (size_t i = 0; i < tf->count; ++i)
        opacity[i] = (float)-expm1(-(double)tf->entries[4 * i + 3] * iso_geometry_mean_spacing_mm(&l->geometry));
    const iso_palette_weighting w = {.by_magnitude = true,
                                     .value_span = l->max - l->min,
                                     .by_value = opacity,
                                     .by_value_count = tf->count,
                                     .by_value_lo = tf->lo,
                                     .by_value_hi = tf->hi};
    iso_direction_pool *pool;
    iso_status status = iso_direction_pool_create(&pool, s->bench->cli->threads, err);
    TRY(status, iso_palette_sample_field(pool, l->directions, l->scalar, l->magnitude,
                                         iso_geometry_voxel_count(&l->geometry), weighted ? &w : NULL, err));
    TRY(status, iso_direction_pool_finish(pool, set, err));
    iso_direction_pool_destroy(pool);
    free(opacity);
    return status;
}

static iso_status palette_rows(stage *s, iso_palette_rival how, size_t directions, bool weighted, bool variants,
                               iso_error *err)
{
    char name[64];
    iso_level level = s->pyramid.levels[0];
    OWNED(iso_direction_set) set = {0};
    OWNED(iso_palette) palette = {0};
    iso_palette_error e = {0};
    iso_rival_options opt = iso_rival_defaults();
    opt.method = how;
    opt.fit.directions = directions;
    double start = iso_clock_seconds();
    iso_status status = sample_level(s, weighted, &set, err);
    TRY(status, iso_rival_palette_fit(&set, &opt, &palette, err));
    TRY(status, iso_level_attach_palette(&level, s->pyramid.options.code, &palette, err));
    double seconds = iso_clock_seconds() - start;
    TRY(status, iso_palette_measure(&set, &palette, &e, err));
    snprintf(name, sizeof name, "%s-%zu%s", how == ISO_RIVAL_KMEANS ? "palette" : iso_palette_rival_name(how),
             directions, weighted ? " for the scene" : "");
    method m = {name, iso_palette_bits(&palette) > 8 ? 2 : 1, seconds, e.rms_deg};
    if (status == ISO_OK)
        status = add_row(s, &level, (directions_by){s->pyramid.options.code, ISO_FROM_PALETTE, false}, &m, err);
    if (variants && status == ISO_OK) {
        snprintf(name, sizeof name, "palette-%zu shades", directions);
        status = add_row(s, &level, (directions_by){s->pyramid.options.code, ISO_FROM_PALETTE, true}, &m, err);
    }
    if (variants && status == ISO_OK) {
        snprintf(name, sizeof name, "palette-%zu nearest", directions);
        status = add_row(s, &level, (directions_by){s->pyramid.options.code, ISO_FROM_PALETTE_NEAREST, false}, &m, err);
    }
    if (variants && status == ISO_OK) {
        snprintf(name, sizeof name, "palette-%zu near. shades", directions);
        status = add_row(s, &level, (directions_by){s->pyramid.options.code, ISO_FROM_PALETTE_NEAREST, true}, &m, err);
    }
    iso_level_detach_palette(&level);
    return status;
}

static iso_status all_rows(stage *s, iso_error *err)
{
    const iso_level *level = &s->pyramid.levels[0];
    iso_status status = render(s, level, (directions_by){s->pyramid.options.code, ISO_FROM_FLOAT, false}, &s->wanted,
                               NULL, err);
    const method floats = {"float", 12, 0, 0};
    if (!s->bench->cli->json)
        printf("  %-24s %5s %11s %8s %10s %9s %9s %9s %8s\n", "gradients", "bytes", "encode", "rms deg", "rmse",
               "max abs", "ssim", "flip", "GL ms");
    if (status == ISO_OK)
        status = add_row(s, level, (directions_by){s->pyramid.options.code, ISO_FROM_FLOAT, false}, &floats, err);
    for (int code = 0; code < ISO_CODE_COUNT && status == ISO_OK; ++code)
        if (iso_code_describe((iso_code)code)->is_textured)
            status = code_row(s, (iso_code)code, err);
    TRY(status, palette_rows(s, ISO_RIVAL_KMEANS, 254, false, true, err));
    TRY(status, palette_rows(s, ISO_RIVAL_KMEANS, 254, true, false, err));
    TRY(status, palette_rows(s, ISO_RIVAL_FACES, 240, false, false, err));
    TRY(status, palette_rows(s, ISO_RIVAL_KMEANS, 1022, false, false, err));
    return status == ISO_OK ? palette_rows(s, ISO_RIVAL_KMEANS, 1022, true, false, err) : status;
}

/* True if any option besides the size is given. */
static bool has_own_look(const palette_bench *b)
{
    iso_cli_look shown = b->look;
    shown.size = NULL;
    return !iso_cli_look_is_empty(&shown);
}

iso_status iso_palette_bench_images(const palette_bench *b, const char *path, json_t *rows, iso_error *err)
{
    stage s = {.bench = b, .name = iso_path_base(path), .rows = rows};
    iso_pyramid_options build = iso_pyramid_defaults();
    iso_volume v = {0};
    build.level_count = 1;
    build.keep_float = build.keep_magnitude = true;
    build.threads = b->cli->threads;
    iso_status status = iso_volume_input_load(path, &b->input, &v, err);
    TRY(status, iso_pyramid_build(&v, path, &build, &s.pyramid, NULL, err));
    iso_volume_destroy(&v);
    TRY(status, has_own_look(b) ? iso_subject_make_view(&b->shown, &s.pyramid, &s.view, err) : default_view(&s, err));
    TRY(status, iso_gl_create(&s.gl, NULL, err));
    TRY(status, all_rows(&s, err));
    iso_gl_destroy(s.gl);
    iso_image_destroy(&s.wanted);
    iso_view_destroy(&s.view);
    iso_pyramid_destroy(&s.pyramid);
    return status;
}

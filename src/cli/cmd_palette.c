/* SPDX-License-Identifier: MIT */
/* cmd_palette.c - fits a palette of directions to a volume or a pyramid, and saves it. */
#define _GNU_SOURCE
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/linalg.h"
#include "base/parallel.h"
#include "image/image.h"
#include "options/cli.h"
#include "options/input.h"
#include "options/transfer.h"
#include "palette/palette.h"
#include "pyramid/palette_level.h"
#include "pyramid/pyramid.h"
#include "tf/presets.h"

/* ---- pictures of palettes ---- */

#define SIDE 512 /* pixels of one hemisphere */
#define MARGIN 16

typedef struct view {
    iso_vec3 right, up, toward;
} view;

/* Returns a view from the front right and above, as in the scenes. */
static view front_view(void)
{
    view v;
    v.toward = iso_normalize(iso_v3(0.6, -1.0, 0.45));
    v.right = iso_normalize(iso_cross(iso_v3(0, 0, 1), v.toward));
    v.up = iso_cross(v.toward, v.right);
    return v;
}

static view back_view(void)
{
    view v = front_view();
    v.toward = iso_scale(v.toward, -1);
    v.right = iso_scale(v.right, -1);
    return v;
}

static double srgb_to_linear(double v)
{
    return v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4);
}

static void set_pixel(iso_image *image, size_t column, size_t row, const double srgb[3])
{
    float *p = image->rgba + 4 * (row * image->width + column);
    for (int c = 0; c < 3; ++c)
        p[c] = (float)srgb_to_linear(srgb[c]);
    p[3] = 1;
}

/* Finds the nearest entry for each pixel of a hemisphere; 0 outside. */
static void index_hemisphere(const iso_palette_lookup *lookup, const view *v, uint16_t *index)
{
    const double radius = SIDE / 2.0 - MARGIN;
    for (size_t row = 0; row < SIDE; ++row)
        for (size_t column = 0; column < SIDE; ++column) {
            double x = ((double)column + 0.5 - SIDE / 2.0) / radius, y = (SIDE / 2.0 - (double)row - 0.5) / radius;
            uint16_t *at = &index[row * SIDE + column];
            *at = 0;
            if (x * x + y * y >= 1)
                continue;
            iso_vec3 n = iso_madd(iso_madd(iso_scale(v->toward, sqrt(1 - x * x - y * y)), v->right, x), v->up, y);
            float d[3] = {(float)n.x, (float)n.y, (float)n.z};
            iso_palette_assign(lookup, d, at, 1);
        }
}

static void draw_regions(iso_image *image, const iso_palette *palette, const uint16_t *index, size_t left)
{
    for (size_t row = 0; row + 1 < SIDE; ++row)
        for (size_t column = 0; column + 1 < SIDE; ++column) {
            size_t at = row * SIDE + column;
            const float *n = palette->xyz + 3 * (size_t)index[at];
            bool edge = index[at] != index[at + 1] || index[at] != index[at + SIDE];
            if (!index[at] && !edge)
                continue;
            double color[3];
            for (int c = 0; c < 3; ++c)
                color[c] = edge ? 0.1 : 0.25 + 0.35 * ((double)n[c] + 1);
            set_pixel(image, left + column, row, color);
        }
}

static void draw_dots(iso_image *image, const iso_direction_set *set, const view *v, size_t left)
{
    static const double black[3] = {0, 0, 0};
    const double radius = SIDE / 2.0 - MARGIN;
    for (size_t i = 0; i < set->count; ++i) {
        iso_vec3 d = iso_v3((double)set->xyz[3 * i], (double)set->xyz[3 * i + 1], (double)set->xyz[3 * i + 2]);
        if (iso_dot(d, v->toward) > 0)
            set_pixel(image, left + (size_t)(SIDE / 2.0 + radius * iso_dot(d, v->right)),
                      (size_t)(SIDE / 2.0 - radius * iso_dot(d, v->up)), black);
    }
}

/* Largest number of dots for the data; more would hide the regions. */
#define MOST_DOTS 20000

/* Writes a PNG: the sphere from both sides, each point in the color of its nearest entry (x, y, z as red, green, blue),
 * with outlined regions and the set's directions as dots; set may be NULL. */
static iso_status palette_picture_png(const iso_palette *palette, const iso_direction_set *set, const char *path,
                                      iso_error *err)
{
    static const double white[3] = {1, 1, 1};
    const view views[2] = {front_view(), back_view()};
    iso_palette_lookup *lookup = NULL;
    OWNED(iso_image) image = {0};
    FREED uint16_t *index = malloc((size_t)SIDE * SIDE * sizeof *index);
    iso_status status = index ? iso_palette_lookup_create(palette, &lookup, err)
                              : iso_fail(err, ISO_E_MEMORY, "%s: no memory for its pixels", path);
    TRY(status, iso_image_create(&image, 2 * SIDE, SIDE, err));
    if (status == ISO_OK) {
        for (size_t i = 0; i < image.width * image.height; ++i)
            set_pixel(&image, i % image.width, i / image.width, white);
        for (size_t side = 0; side < 2; ++side) {
            index_hemisphere(lookup, &views[side], index);
            draw_regions(&image, palette, index, side * SIDE);
            if (set && set->count <= MOST_DOTS)
                draw_dots(&image, set, &views[side], side * SIDE);
        }
        status = iso_image_save_png(&image, path, 1, err);
    }
    iso_palette_lookup_destroy(lookup);
    return status;
}

/* Writes an EXR: count x 1 floats, entry i in pixel i as R, G, B. */
static iso_status palette_picture_exr(const iso_palette *palette, const char *path, const char *note, iso_error *err)
{
    const iso_image_note notes[] = {{"isoshadeCommand", note}, {NULL, NULL}};
    OWNED(iso_image) image = {0};
    NEED(iso_image_create(&image, palette->count, 1, err));
    for (size_t i = 0; i < palette->count; ++i) {
        for (size_t c = 0; c < 3; ++c)
            image.rgba[4 * i + c] = palette->xyz[3 * i + c];
        image.rgba[4 * i + 3] = 1;
    }
    return iso_image_save_exr(&image, path, notes, err);
}

typedef struct palette_arguments {
    const iso_cli *cli;
    iso_volume_input input;
    iso_cli_transfer transfer; /* options for the file of --tf */
    iso_tf_request request;    /* read from them */
    char **outputs;            /* ends with NULL */
    char *method, *tf;
    int entries, seed, level, per_level, by_magnitude;
} palette_arguments;

/* Makes a table of weights, the TF's opacity over one voxel; to be freed. */
static iso_status opacity_weights(const palette_arguments *a, const iso_tf *tf, const iso_geometry *g,
                                  const double range[2], iso_palette_weighting *w, float **table, iso_error *err)
{
    OWNED(iso_tf_table) t = {0};
    NEED(iso_tf_tabulate(tf, range[0], range[1], g, &t, err));
    if (!(*table = malloc(t.count * sizeof **table)))
        return iso_fail(err, ISO_E_MEMORY, "%s: out of memory for %zu weights", a->tf, t.count);
    double length = iso_geometry_mean_spacing_mm(g);
    for (size_t i = 0; i < t.count; ++i)
        (*table)[i] = (float)-expm1(-(double)t.entries[4 * i + 3] * length);
    w->by_value = *table;
    w->by_value_count = t.count;
    w->by_value_lo = t.lo;
    w->by_value_hi = t.hi;
    return ISO_OK;
}

ISO_ENDING(end_pool, iso_direction_pool, iso_direction_pool_destroy)
ISO_ENDING(end_lookup, iso_palette_lookup, iso_palette_lookup_destroy)

/* Gathers the gradients of a volume's file. Plain counts need one pass over the file and little memory; weights first
 * need the volume's range. */
static iso_status gather_volume(const palette_arguments *a, const char *path, iso_direction_set *set, iso_error *err)
{
    iso_gradient_options gradient = iso_gradient_defaults();
    iso_palette_weighting w = {.by_magnitude = a->by_magnitude};
    iso_progress progress = iso_cli_progress(a->cli);
    ENDED_BY(end_pool) iso_direction_pool *pool = NULL;
    OWNED(iso_volume) v = {0};
    OWNED(iso_tf) tf = {0};
    FREED float *table = NULL;
    gradient.threads = a->cli->threads;
    NEED(iso_direction_pool_create(&pool, a->cli->threads, err));
    if (!a->tf && !a->by_magnitude) {
        ENDED_BY(iso_source_close_owned) iso_volume_source *source = NULL;
        NEED(iso_volume_input_open(path, &a->input, &source, err));
        NEED(iso_palette_sample_source(pool, source, &gradient, &w, &progress, err));
        return iso_direction_pool_finish(pool, set, err);
    }
    NEED(iso_volume_input_load(path, &a->input, &v, err));
    const iso_volume_stats stats = iso_volume_measure(&v);
    w.value_span = stats.max - stats.min;
    if (a->tf) {
        NEED(iso_tf_of_volume(a->tf, &a->request, &v, a->cli->threads, &tf, err));
        NEED(opacity_weights(a, &tf, &v.geometry, (double[]){stats.min, stats.max}, &w, &table, err));
    }
    NEED(iso_palette_sample_volume(pool, &v, &gradient, &w, &progress, err));
    return iso_direction_pool_finish(pool, set, err);
}

/* Gathers the directions of levels first to last: floats if the pyramid keeps them, otherwise decoded ones. */
static iso_status gather_pyramid(const palette_arguments *a, const iso_pyramid *p, size_t first, size_t last,
                                 iso_direction_set *set, iso_error *err)
{
    const iso_level *finest = &p->levels[0];
    iso_palette_weighting w = {.by_magnitude = a->by_magnitude, .value_span = finest->max - finest->min};
    ENDED_BY(end_pool) iso_direction_pool *pool = NULL;
    OWNED(iso_tf) tf = {0};
    FREED float *table = NULL;
    NEED(iso_direction_pool_create(&pool, a->cli->threads, err));
    if (a->tf) {
        NEED(iso_tf_of_level(a->tf, &a->request, NULL, finest, a->cli->threads, &tf, err));
        NEED(opacity_weights(a, &tf, &finest->geometry, (double[]){finest->min, finest->max}, &w, &table, err));
    }
    for (size_t k = first; k <= last; ++k) {
        const iso_level *l = &p->levels[k];
        const float *directions;
        FREED float *owned = NULL;
        if (a->by_magnitude && !l->magnitude)
            return iso_fail(err, ISO_E_RANGE,
                            "--by-magnitude: level %zu has no magnitudes; build the pyramid with --keep-magnitude", k);
        NEED(iso_level_directions(l, p->options.code, &directions, &owned, err));
        NEED(iso_palette_sample_field(pool, directions, l->scalar, l->magnitude, iso_geometry_voxel_count(&l->geometry),
                                      &w, err));
    }
    return iso_direction_pool_finish(pool, set, err);
}

/* A fitted palette, with the directions it was fitted to. */
typedef struct fitted {
    iso_direction_set set;
    iso_palette palette;
    iso_palette_error error;
    double sample_seconds, fit_seconds;
    long level; /* level of a pyramid; -1: all levels, or no pyramid */
} fitted;

static void fitted_destroy(fitted *f)
{
    iso_direction_set_destroy(&f->set);
    iso_palette_destroy(&f->palette);
}

/* ---- options ---------------------------------------------------------------------------- */

static iso_status check_outputs(const palette_arguments *a, iso_error *err)
{
    static const char *const endings[] = {".csv", ".png", ".exr", ".inc", ".py", ".nrrd"};
    for (char **path = a->outputs; path && *path; ++path) {
        bool known = false;
        for (size_t i = 0; i < sizeof endings / sizeof *endings; ++i)
            known |= iso_path_ends_with(*path, endings[i]);
        if (!known)
            return iso_fail(err, ISO_E_USAGE, "%s: the ending must be .csv, .png, .exr, .inc, .py or .nrrd", *path);
    }
    return ISO_OK;
}

static iso_status to_options(const palette_arguments *a, iso_palette_options *out, iso_error *err)
{
    *out = iso_palette_defaults();
    if (a->method)
        NEED(iso_palette_method_from_name(a->method, &out->method, err));
    out->directions = (size_t)a->entries;
    out->seed = (uint64_t)a->seed;
    return check_outputs(a, err);
}

/* ---- outputs -------------------------------------------------------------------------------- */

static iso_status save_indices(const iso_palette *palette, const iso_geometry *g, const float *vectors,
                               const char *path, iso_error *err)
{
    const bool bytes = palette->count <= 256;
    ENDED_BY(end_lookup) iso_palette_lookup *lookup = NULL;
    OWNED(iso_volume) index = {0};
    NEED(iso_palette_lookup_create(palette, &lookup, err));
    NEED(iso_volume_create(&index, g, bytes ? ISO_U8 : ISO_U16, path, err));
    if (bytes)
        iso_palette_assign8(lookup, vectors, index.data, iso_geometry_voxel_count(g));
    else
        iso_palette_assign(lookup, vectors, index.data, iso_geometry_voxel_count(g));
    return iso_volume_save(&index, path, false, err);
}

static iso_status save_volume_indices(const palette_arguments *a, const iso_palette *palette, const char *path,
                                      iso_error *err)
{
    iso_gradient_options gradient = iso_gradient_defaults();
    OWNED(iso_volume) v = {0};
    FREED float *vectors = NULL;
    gradient.threads = a->cli->threads;
    NEED(iso_volume_input_load(a->cli->arguments[0], &a->input, &v, err));
    if (!(vectors = malloc(3 * iso_geometry_voxel_count(&v.geometry) * sizeof *vectors)))
        return iso_fail(err, ISO_E_MEMORY, "%s: out of memory for its gradients", path);
    NEED(iso_gradient_compute(&v, &gradient, vectors, err));
    return save_indices(palette, &v.geometry, vectors, path, err);
}

static iso_status save_level_indices(const iso_pyramid *p, size_t k, const iso_palette *palette, const char *path,
                                     iso_error *err)
{
    const iso_level *l = &p->levels[k];
    const float *directions;
    FREED float *owned = NULL;
    NEED(iso_level_directions(l, p->options.code, &directions, &owned, err));
    return save_indices(palette, &l->geometry, directions, path, err);
}

/* Returns "a_level_2.csv" for "a.csv"; to be freed. */
static char *level_path(const char *path, long level)
{
    const char *dot = strrchr(path, '.');
    char *out = NULL;
    if (level < 0)
        return strdup(path);
    return asprintf(&out, "%.*s_level_%ld%s", (int)(dot - path), path, level, dot) < 0 ? NULL : out;
}

/* Saves one output. Indices of a pyramid's levels go to one file per level. */
static iso_status save_one(const palette_arguments *a, const iso_pyramid *p, const fitted *f, const char *path,
                           iso_error *err)
{
    FREED char *note = iso_cli_command_line(a->cli);
    const char *text = note ? note : "";
    if (iso_path_ends_with(path, ".csv"))
        NEED(iso_palette_save_csv(&f->palette, path, err));
    else if (iso_path_ends_with(path, ".inc"))
        NEED(iso_palette_save_povray(&f->palette, path, text, err));
    else if (iso_path_ends_with(path, ".py"))
        NEED(iso_palette_save_python(&f->palette, path, text, err));
    else if (iso_path_ends_with(path, ".exr"))
        NEED(palette_picture_exr(&f->palette, path, text, err));
    else if (iso_path_ends_with(path, ".png"))
        NEED(palette_picture_png(&f->palette, &f->set, path, err));
    else if (!p)
        NEED(save_volume_indices(a, &f->palette, path, err));
    else if (f->level >= 0)
        NEED(save_level_indices(p, (size_t)f->level, &f->palette, path, err));
    for (size_t k = 0; p && f->level < 0 && iso_path_ends_with(path, ".nrrd") && k < p->level_count; ++k) {
        FREED char *name = level_path(path, (long)k);
        NEED(name ? save_level_indices(p, k, &f->palette, name, err) : iso_fail(err, ISO_E_MEMORY, "out of memory"));
    }
    return ISO_OK;
}

static iso_status save_all(const palette_arguments *a, const iso_pyramid *p, const fitted *f, iso_error *err)
{
    for (char **path = a->outputs; path && *path; ++path) {
        FREED char *name = level_path(*path, a->per_level ? f->level : -1);
        NEED(name ? save_one(a, p, f, name, err) : iso_fail(err, ISO_E_MEMORY, "out of memory"));
    }
    return ISO_OK;
}

/* ---- the command ------------------------------------------------------------------------------ */

static iso_status fit(const palette_arguments *a, const iso_palette_options *opt, fitted *f, iso_error *err)
{
    iso_progress progress = iso_cli_progress(a->cli);
    double start = iso_clock_seconds();
    NEED(iso_palette_fit(&f->set, opt, &f->palette, &progress, err));
    f->fit_seconds = iso_clock_seconds() - start;
    return iso_palette_measure(&f->set, &f->palette, &f->error, err);
}

static double total_weight(const iso_direction_set *set)
{
    double sum = 0;
    for (size_t i = 0; i < set->count; ++i)
        sum += set->weight[i];
    return sum;
}

static void report(const palette_arguments *a, const iso_palette_options *opt, const fitted *f, json_t *palettes)
{
    json_t *row = json_pack("{s:s, s:I, s:i, s:I, s:f, s:f, s:f, s:f, s:f, s:f, s:f, s:f, s:f}", "method",
                            iso_palette_method_name(opt->method), "entries", (json_int_t)f->palette.count, "index_bits",
                            iso_palette_bits(&f->palette), "bundles", (json_int_t)f->set.count, "weight",
                            total_weight(&f->set), "undefined_weight", f->set.undefined_weight, "norm1", f->error.norm1,
                            "norm2", f->error.norm2, "norm2_as_printed", f->error.norm2_printed, "rms_deg",
                            f->error.rms_deg, "max_deg", f->error.max_deg, "sample_seconds", f->sample_seconds,
                            "fit_seconds", f->fit_seconds);
    if (f->level >= 0)
        json_object_set_new(row, "level", json_integer(f->level));
    json_array_append_new(palettes, row);
    if (a->cli->json)
        return;
    if (f->level >= 0)
        printf("level %ld\n", f->level);
    printf("%s: %zu entries with the zero vector, %d bits per index\n", iso_palette_method_name(opt->method),
           f->palette.count, iso_palette_bits(&f->palette));
    printf("  fitted to        %.6g directions in %zu bundles, and %.6g without a direction\n", total_weight(&f->set),
           f->set.count, f->set.undefined_weight);
    printf("  error norm 1     %.6g    sum of 1 - cos\n", f->error.norm1);
    printf("  error norm 2     %.6g    (%.6g as the paper prints it)\n", f->error.norm2, f->error.norm2_printed);
    printf("  angle            %.3f rms, %.2f max deg\n", f->error.rms_deg, f->error.max_deg);
    printf("  seconds          %.3f reading and gradients, %.3f fit\n", f->sample_seconds, f->fit_seconds);
}

/* Gathers, fits, saves and reports one palette. */
static iso_status make_one(const palette_arguments *a, const iso_palette_options *opt, const iso_pyramid *p, long level,
                           json_t *palettes, iso_error *err)
{
    const iso_cli_stage stages[] = {{"directions", 1}, {"palette", 3}};
    OWNED(fitted) f = {.level = level};
    double start = iso_clock_seconds();
    iso_cli_expect(a->cli, stages, sizeof stages / sizeof *stages);
    if (!p)
        NEED(gather_volume(a, a->cli->arguments[0], &f.set, err));
    else
        NEED(gather_pyramid(a, p, level < 0 ? 0 : (size_t)level, level < 0 ? p->level_count - 1 : (size_t)level, &f.set,
                            err));
    f.sample_seconds = iso_clock_seconds() - start;
    NEED(fit(a, opt, &f, err));
    NEED(save_all(a, p, &f, err));
    report(a, opt, &f, palettes);
    return ISO_OK;
}

static iso_status make_all(const palette_arguments *a, iso_error *err)
{
    iso_palette_options opt;
    OWNED(iso_pyramid) p = {0};
    NEED(to_options(a, &opt, err));
    const char *path = a->cli->arguments[0];
    bool is_pyramid = iso_pyramid_is_one(path);
    if ((a->per_level || a->level >= 0) && !is_pyramid)
        return iso_fail(err, ISO_E_USAGE, "--level and --per-level need a pyramid");
    if (is_pyramid)
        NEED(iso_pyramid_load(path, &p, err));
    if (is_pyramid && a->level >= (int)p.level_count)
        return iso_fail(err, ISO_E_USAGE, "--level is %d, %s has the levels 0 to %zu", a->level, path,
                        p.level_count - 1);
    json_auto_t *palettes = json_array();
    for (size_t k = 0; k < (a->per_level ? p.level_count : 1); ++k)
        NEED(make_one(a, &opt, is_pyramid ? &p : NULL, a->per_level ? (long)k : a->level, palettes, err));
    if (a->cli->json)
        iso_cli_print_results(a->cli, json_pack("{s:{s:i}, s:O}", "options", "seed", a->seed, "palettes", palettes));
    return ISO_OK;
}

static const iso_option options[] = {
    {"output", 'o',
     "output, repeatable: .csv, .inc (POV-Ray), .py (Blender), .exr (row of floats), "
     ".png, .nrrd (indices)",
     "FILE", ISO_IN(palette_arguments, outputs)},
    {"entries", 0, "number of directions, without the zero vector", "N", ISO_IN(palette_arguments, entries),
     .flags = ISO_SHOWN, .least = 1, .most = ISO_PALETTE_MAX},
    {"method", 0, "kmeans (default), or fibonacci", "NAME", ISO_IN(palette_arguments, method)},
    {"seed", 0, "seed of the random numbers", "N", ISO_IN(palette_arguments, seed), .flags = ISO_SHOWN,
     .most = 2147483647},
    {"by-magnitude", 0, "weight voxels by their gradient magnitude", NULL, ISO_IN(palette_arguments, by_magnitude)},
    {"tf", 0, "weight voxels by opacity under this transfer function, a file or preset", "FILE|PRESET",
     ISO_IN(palette_arguments, tf)},
    ISO_OPTIONS_OF(palette_arguments, transfer, iso_transfer_rows),
    {"level", 0, "pyramids: only this level (one palette for all levels)", "K", ISO_IN(palette_arguments, level),
     .most = 31},
    {"per-level", 0, "pyramids: one palette per level, in files NAME_level_K", NULL,
     ISO_IN(palette_arguments, per_level)},
    ISO_OPTIONS_OF(palette_arguments, input, iso_input_rows),
    ISO_OPTIONS_END,
};

static iso_status run(const iso_cli *cli, void *values, iso_error *err)
{
    palette_arguments *a = values;
    a->cli = cli;
    NEED(iso_cli_transfer_request(&a->transfer, &a->request, err));
    if (a->tf)
        NEED(iso_tf_check_name(a->tf, &a->request, err));
    return make_all(a, err);
}

const iso_command iso_command_palette = {
    .name = "palette",
    .summary = "fit a table of directions to a volume: one byte per voxel instead of three",
    .min_arguments = 1,
    .max_arguments = 1,
    .usage = "VOLUME|PYRAMID.iso [-o FILE ...] [options]",
    .details =
        "Entry 0 is the zero vector. Without --tf and --by-magnitude all voxels with a gradient count the same, and a\n"
        "volume is read slab by slab.",
    .common = "output entries method tf level per-level by-magnitude seed spacing threads",
    .examples = "  isoshade make marschner-lobb --size 40x56x33 -o v.nrrd\n"
                "  isoshade palette v.nrrd -o palette.csv -o palette.png -o index.nrrd\n"
                "  isoshade palette v.nrrd --entries 1022 --by-magnitude -o palette.inc -o palette.py\n",
    .lists = (const iso_names *const[]){&iso_palette_method_names, &iso_tf_preset_names, NULL},
    ISO_COMMAND_OPTIONS(palette_arguments, options, .entries = 254, .seed = 1, .level = -1),
    .run = run,
};

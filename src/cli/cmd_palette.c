/* SPDX-License-Identifier: MIT */
/* cmd_palette.c - fits a palette of directions to a volume or a pyramid, and saves it. */
#define _GNU_SOURCE
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/parallel.h"
#include "cli/palette_sets.h"
#include "pyramid/palette_level.h"
#include "palette/palette_picture.h"
#include "palette/palette.h"
#include "pyramid/pyramid.h"
#include "tf/presets.h"

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

static iso_status check_outputs(const iso_palette_arguments *a, iso_error *err)
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

static iso_status to_options(const iso_palette_arguments *a, iso_palette_options *out, iso_error *err)
{
    *out = iso_palette_defaults();
    iso_status status = ISO_OK;
    if (a->method)
        status = iso_palette_method_from_name(a->method, &out->method, err);
    TRY(status, check_outputs(a, err));
    out->directions = (size_t)a->entries;
    out->seed = (uint64_t)a->seed;
    return status;
}

/* ---- outputs -------------------------------------------------------------------------------- */

/* Writes the indices of count vectors as 1 byte each, or as 2 if 1 is too small. */
static void index_vectors(const iso_palette_lookup *lookup, bool bytes, const float *vectors, void *out, size_t count)
{
    if (bytes)
        iso_palette_assign8(lookup, vectors, out, count);
    else
        iso_palette_assign(lookup, vectors, out, count);
}

static iso_status save_indices(const iso_palette *palette, const iso_geometry *g, const float *vectors,
                               const char *path, iso_error *err)
{
    bool bytes = palette->count <= 256;
    iso_palette_lookup *lookup = NULL;
    iso_volume index = {0};
    iso_status status = iso_palette_lookup_create(palette, &lookup, err);
    TRY(status, iso_volume_create(&index, g, bytes ? ISO_U8 : ISO_U16, path, err));
    if (status == ISO_OK) {
        index_vectors(lookup, bytes, vectors, index.data, iso_geometry_voxel_count(g));
        status = iso_volume_save(&index, path, false, err);
    }
    iso_volume_destroy(&index);
    iso_palette_lookup_destroy(lookup);
    return status;
}

static iso_status save_volume_indices(const iso_palette_arguments *a, const iso_palette *palette, const char *path,
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
static iso_status save_one(const iso_palette_arguments *a, const iso_pyramid *p, const fitted *f, const char *path,
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
        NEED(iso_palette_picture_exr(&f->palette, path, text, err));
    else if (iso_path_ends_with(path, ".png"))
        NEED(iso_palette_picture_png(&f->palette, &f->set, path, err));
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

static iso_status save_all(const iso_palette_arguments *a, const iso_pyramid *p, const fitted *f, iso_error *err)
{
    for (char **path = a->outputs; path && *path; ++path) {
        FREED char *name = level_path(*path, a->per_level ? f->level : -1);
        NEED(name ? save_one(a, p, f, name, err) : iso_fail(err, ISO_E_MEMORY, "out of memory"));
    }
    return ISO_OK;
}

/* ---- the command ------------------------------------------------------------------------------ */

static iso_status fit(const iso_palette_arguments *a, const iso_palette_options *opt, fitted *f, iso_error *err)
{
    iso_progress progress = iso_cli_progress(a->cli);
    double start = iso_clock_seconds();
    iso_status status = iso_palette_fit(&f->set, opt, &f->palette, &progress, err);
    f->fit_seconds = iso_clock_seconds() - start;
    return status == ISO_OK ? iso_palette_measure(&f->set, &f->palette, &f->error, err) : status;
}

static double total_weight(const iso_direction_set *set)
{
    double sum = 0;
    for (size_t i = 0; i < set->count; ++i)
        sum += set->weight[i];
    return sum;
}

static void report(const iso_palette_arguments *a, const iso_palette_options *opt, const fitted *f, json_t *palettes)
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
static iso_status make_one(const iso_palette_arguments *a, const iso_palette_options *opt, const iso_pyramid *p,
                           long level, json_t *palettes, iso_error *err)
{
    const iso_cli_stage stages[] = {{"directions", 1}, {"palette", 3}};
    OWNED(fitted) f = {.level = level};
    double start = iso_clock_seconds();
    iso_cli_expect(a->cli, stages, sizeof stages / sizeof *stages);
    iso_status status;
    if (!p)
        status = iso_palette_volume_set(a, a->cli->arguments[0], &f.set, err);
    else
        status = iso_palette_pyramid_set(a, p, level < 0 ? 0 : (size_t)level,
                                         level < 0 ? p->level_count - 1 : (size_t)level, &f.set, err);
    f.sample_seconds = iso_clock_seconds() - start;
    TRY(status, fit(a, opt, &f, err));
    TRY(status, save_all(a, p, &f, err));
    if (status == ISO_OK)
        report(a, opt, &f, palettes);
    return status;
}

static iso_status make_all(const iso_palette_arguments *a, iso_error *err)
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
    if (a->cli->json) {
        json_t *root = iso_cli_json(a->cli);
        json_object_set_new(json_object_get(root, "options"), "seed", json_integer(a->seed));
        json_object_set(root, "palettes", palettes);
        iso_cli_print_json(root);
    }
    return ISO_OK;
}

static const iso_option options[] = {
    {"output", 'o',
     "output, repeatable: .csv, .inc (POV-Ray), .py (Blender), .exr (row of floats), "
     ".png, .nrrd (indices)",
     "FILE", ISO_IN(iso_palette_arguments, outputs)},
    {"entries", 0, "number of directions, without the zero vector", "N", ISO_IN(iso_palette_arguments, entries),
     .flags = ISO_SHOWN, .least = 1, .most = ISO_PALETTE_MAX},
    {"method", 0, "kmeans (default), or fibonacci", "NAME", ISO_IN(iso_palette_arguments, method)},
    {"seed", 0, "seed of the random numbers", "N", ISO_IN(iso_palette_arguments, seed), .flags = ISO_SHOWN,
     .most = 2147483647},
    {"by-magnitude", 0, "weight voxels by their gradient magnitude", NULL, ISO_IN(iso_palette_arguments, by_magnitude)},
    {"tf", 0, "weight voxels by opacity under this transfer function, a file or preset", "FILE|PRESET",
     ISO_IN(iso_palette_arguments, tf)},
    ISO_OPTIONS_OF(iso_palette_arguments, transfer, iso_transfer_rows),
    {"level", 0, "pyramids: only this level (one palette for all levels)", "K", ISO_IN(iso_palette_arguments, level),
     .most = 31},
    {"per-level", 0, "pyramids: one palette per level, in files NAME_level_K", NULL,
     ISO_IN(iso_palette_arguments, per_level)},
    ISO_OPTIONS_OF(iso_palette_arguments, input, iso_input_rows),
    ISO_OPTIONS_END,
};

static iso_status run(const iso_cli *cli, void *values, iso_error *err)
{
    iso_palette_arguments *a = values;
    a->cli = cli;
    iso_status status = iso_cli_transfer_request(&a->transfer, &a->request, err);
    if (status == ISO_OK && a->tf)
        status = iso_tf_check_name(a->tf, &a->request, err);
    return status == ISO_OK ? make_all(a, err) : status;
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
    ISO_COMMAND_OPTIONS(iso_palette_arguments, options, .entries = 254, .seed = 1, .level = -1),
    .run = run,
};

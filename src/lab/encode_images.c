/* SPDX-License-Identifier: MIT */
/* encode_images.c - image errors of direction codes, against the same directions as floats. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/file.h"
#include "base/json.h"
#include "lab/encode.h"
#include "scene/subject.h"
#include "compare/metrics.h"
#include "render/reference.h"

enum { MAX_LEVELS = 8 };

/* Storage of a level's directions d, where |d| = L^2 is their coherence. */
typedef enum way {
    WAY_CODE,      /* d itself in the code */
    WAY_APART,     /* d / |d| in the code, L^2 in a fourth byte; filtered separately */
    WAY_AT_VOXELS, /* the same with eight fetches, multiplied before filtering */
} way;

static const struct coding {
    const char *name;
    way way;
    iso_code code;
    int bytes;
} codings[] = {
    {"snorm", WAY_CODE, ISO_CODE_SNORM, 3},
    {"fit", WAY_CODE, ISO_CODE_FIT, 3},
    {"fit, byte of L, filtered apart", WAY_APART, ISO_CODE_FIT, 4},
    {"fit, byte of L, 8 fetches", WAY_AT_VOXELS, ISO_CODE_FIT, 4},
    {"half", WAY_CODE, ISO_CODE_HALF, 6},
    {"shell", WAY_CODE, ISO_CODE_SHELL, 3},
    {"cube", WAY_CODE, ISO_CODE_CUBE, 3},
    {"region48", WAY_CODE, ISO_CODE_REGION48, 3},
};
enum { CODING_COUNT = sizeof codings / sizeof *codings, RATIO_TO = 0 };

typedef struct image_error {
    double rmse, dssim;
} image_error;

typedef struct images_run {
    const iso_cli *cli;
    const iso_image_bench *bench;
    json_t *cases;
    double log_ratio[CODING_COUNT][MAX_LEVELS][2]; /* sums of logarithms of error / snorm's error */
    size_t counts[MAX_LEVELS];
} images_run;

/* Normalizes directions; zero stays zero. */
static void to_units(const float *directions, size_t count, float *units)
{
    for (size_t i = 0; i < count; ++i) {
        const float *d = directions + 3 * i, length = sqrtf(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
        for (size_t a = 0; a < 3; ++a)
            units[3 * i + a] = length > 0 ? d[a] / length : 0;
    }
}

static float length_byte(const float *d)
{
    return rintf(255 * sqrtf(d[0] * d[0] + d[1] * d[1] + d[2] * d[2])) / 255;
}

/* Applies the coding to the level: to bytes in level->codes or vectors in level->directions, both owned by the caller.
 * If the length is filtered apart, it only scales the sum of unit vectors and does not change its direction. */
static iso_direction_source apply(const struct coding *c, const iso_level *from, iso_level *level, uint8_t *bytes,
                                  float *vectors)
{
    const size_t count = iso_geometry_voxel_count(&from->geometry);
    *level = *from;
    level->codes = bytes;
    if (c->way == WAY_CODE && iso_code_describe(c->code)->is_textured) {
        iso_code_encode(c->code, from->directions, bytes, count);
        return ISO_FROM_CODES;
    }
    level->directions = vectors;
    if (c->way == WAY_CODE) {
        iso_code_encode(c->code, from->directions, bytes, count);
    } else {
        to_units(from->directions, count, vectors);
        iso_code_encode(c->code, vectors, bytes, count);
    }
    iso_code_decode_all(c->code, bytes, vectors, count);
    for (size_t i = 0; i < count && c->way == WAY_AT_VOXELS; ++i)
        for (size_t a = 0; a < 3; ++a)
            vectors[3 * i + a] *= length_byte(from->directions + 3 * i);
    return ISO_FROM_FLOAT;
}

static iso_status render(const images_run *run, const iso_level *level, iso_code code, iso_direction_source source,
                         const iso_view *view, iso_image *image, iso_error *err)
{
    iso_reference_options opt = iso_reference_defaults();
    opt.quadrature = ISO_QUADRATURE_MIDPOINT;
    opt.source = source;
    opt.threads = run->cli->threads;
    return iso_reference_render(level, code, view, &opt, image, NULL, err);
}

static iso_status measure_level(const images_run *run, const iso_level *level, const iso_view *view,
                                image_error *errors, iso_error *err)
{
    const size_t count = iso_geometry_voxel_count(&level->geometry);
    FREED uint8_t *bytes = malloc(6 * count);
    FREED float *vectors = malloc(3 * count * sizeof *vectors);
    OWNED(iso_image) truth = {0};
    iso_status status = bytes && vectors
                            ? ISO_OK
                            : iso_fail(err, ISO_E_MEMORY, "isoshade-lab encode: no memory for %zu directions", count);
    TRY(status, render(run, level, ISO_CODE_SNORM, ISO_FROM_FLOAT, view, &truth, err));
    for (size_t c = 0; c < CODING_COUNT && status == ISO_OK; ++c) {
        iso_level coded;
        OWNED(iso_image) image = {0};
        iso_metrics m = {0};
        const iso_direction_source source = apply(&codings[c], level, &coded, bytes, vectors);
        status = render(run, &coded, codings[c].code, source, view, &image, err);
        TRY(status, iso_metrics_measure(&truth, &image, &m, err));
        errors[c] = (image_error){m.rmse, 0.5 * (1 - m.ssim)};
    }
    return status;
}

static void note(images_run *run, const char *volume, size_t level, const image_error *errors)
{
    if (!run->cli->json)
        printf("%s, level %zu\n", volume, level);
    for (size_t c = 0; c < CODING_COUNT; ++c) {
        const image_error *e = &errors[c], *base = &errors[RATIO_TO];
        run->log_ratio[c][level][0] += log((e->rmse + 1e-9) / (base->rmse + 1e-9));
        run->log_ratio[c][level][1] += log((e->dssim + 1e-9) / (base->dssim + 1e-9));
        json_array_append_new(run->cases, json_pack("{s:s, s:i, s:s, s:i, s:f, s:f}", "volume", volume, "level",
                                                    (int)level, "method", codings[c].name, "bytes", codings[c].bytes,
                                                    "rmse", e->rmse, "ssim_dissimilarity", e->dssim));
        if (!run->cli->json)
            printf("  %-32s %d  %10.2f %10.2f\n", codings[c].name, codings[c].bytes, 1e5 * e->rmse, 1e5 * e->dssim);
    }
    ++run->counts[level];
    fflush(stdout);
}

static iso_status run_volume(images_run *run, const char *path, iso_error *err)
{
    const iso_image_bench *b = run->bench;
    iso_progress progress = iso_cli_progress(run->cli);
    iso_pyramid_options build = iso_pyramid_defaults();
    OWNED(iso_pyramid) p = {0};
    OWNED(iso_view) view = {0};
    image_error errors[CODING_COUNT] = {{0}};
    build.level_count = b->level_count;
    build.threads = run->cli->threads;
    build.keep_float = true;
    NEED(iso_subject_load_pyramid(path, b->input, &build, &progress, &p, err));
    if (!p.levels[0].directions)
        return iso_fail(err, ISO_E_USAGE, "%s has no float directions; build it with --keep-float", path);
    NEED(iso_subject_make_view(b->look, &p, &view, err));
    for (size_t k = 0; k < p.level_count && k < b->level_count; ++k) {
        NEED(measure_level(run, &p.levels[k], &view, errors, err));
        note(run, iso_path_base(path), k, errors);
    }
    return ISO_OK;
}

static void summarize(const images_run *run, json_t *root)
{
    json_t *list = json_array();
    if (!run->cli->json)
        printf("\nGeometric means of error / error of %s: RMSE, DSSIM of each level\n", codings[RATIO_TO].name);
    for (size_t c = 0; c < CODING_COUNT; ++c) {
        if (!run->cli->json)
            printf("  %-32s %d ", codings[c].name, codings[c].bytes);
        for (size_t k = 0; k < run->bench->level_count && run->counts[k] > 0; ++k) {
            const double n = (double)run->counts[k], rmse = exp(run->log_ratio[c][k][0] / n),
                         dssim = exp(run->log_ratio[c][k][1] / n);
            json_array_append_new(list, json_pack("{s:s, s:i, s:f, s:f}", "method", codings[c].name, "level", (int)k,
                                                  "rmse_ratio", rmse, "dssim_ratio", dssim));
            if (!run->cli->json)
                printf("  %8.3f %8.3f", rmse, dssim);
        }
        if (!run->cli->json)
            putchar('\n');
    }
    json_object_set_new(root, "image_ratios", list);
}

iso_status iso_lab_encode_images(const iso_cli *cli, const iso_image_bench *b, json_t *root, iso_error *err)
{
    images_run run = {.cli = cli, .bench = b, .cases = json_array()};
    json_object_set_new(root, "images", run.cases);
    if (!cli->json)
        printf("In the image, against the same directions as floats: RMSE x 1e-5 and DSSIM x 1e-5\n");
    for (size_t i = 0; i < cli->argument_count; ++i)
        NEED(run_volume(&run, cli->arguments[i], err));
    summarize(&run, root);
    return ISO_OK;
}

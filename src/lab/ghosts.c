/* SPDX-License-Identifier: MIT */
/* ghosts.c - ghosts: structures that levels show and level 0 does not, and the effect of each remedy. */
#include <stdio.h>
#include <stdlib.h>

#include "base/file.h"
#include "lab/lab.h"
#include "lab/volumes.h"
#include "fit/extinction_scale.h"
#include "tf/adapt.h"
#include "tf/ghost.h"

/* Methods to show a level, in the order of the columns. */
enum { ORIGINAL, ADAPTED, GUARDED, TF_2D, SCALED, WAYS };
static const char *const way_names[WAYS] = {"original", "adapted", "default", "tf_2d", "scaled"};

typedef struct ghost_bench {
    const iso_cli *cli;
    iso_volume_input input;
    int levels;
    char *tf_path;
    json_t *rows;
} ghost_bench;

/* A level under one transfer function, and the result of each method. */
typedef struct ghost_case {
    const iso_pyramid *pyramid;
    size_t level;
    const char *volume, *tf_name;
    const iso_tf_table *tf;
    int threads;
    iso_small_views_error seen[WAYS];
    iso_adapt_judgment judgment; /* of the default */
} ghost_case;

static iso_status look(ghost_case *c, size_t way, iso_small_views_input in, iso_error *err)
{
    iso_small_views_error seen[ISO_SMALL_VIEWS_MAX_TFS];
    in.tf_count = 1;
    const iso_status status = iso_small_views_compare(&in, seen, err);
    c->seen[way] = seen[0];
    return status;
}

static iso_status look_at_tables(ghost_case *c, iso_small_views_input in, const iso_tf_table *adapted, iso_error *err)
{
    iso_adapt_options opt = iso_adapt_defaults();
    OWNED(iso_tf_table) table = {0};
    opt.threads = c->threads;
    in.tfs[0] = c->tf;
    NEED(look(c, ORIGINAL, in, err));
    in.tfs[0] = adapted;
    NEED(look(c, ADAPTED, in, err));
    NEED(iso_adapt_level(c->pyramid, c->level, c->tf, &opt, &table, &c->judgment, err));
    in.tfs[0] = &table;
    return look(c, GUARDED, in, err);
}

static iso_status look_at_2d(ghost_case *c, iso_small_views_input in, iso_error *err)
{
    iso_adapt_options opt = iso_adapt_defaults();
    OWNED(iso_tf_2d) tf = {0};
    opt.threads = c->threads;
    iso_status status = iso_adapt_tf_2d(c->pyramid, c->level, ISO_SECOND_VALUE_DEVIATION, c->tf, &opt, &tf, err);
    in.tfs_2d[0] = &tf;
    TRY(status, look(c, TF_2D, in, err));
    return status;
}

static iso_status look_at_scale(ghost_case *c, iso_small_views_input in, const iso_tf_table *adapted, iso_error *err)
{
    const size_t n = iso_geometry_voxel_count(&c->pyramid->levels[c->level].geometry);
    FREED uint8_t *bytes = NULL;
    iso_status status = iso_extinction_scale_level(c->pyramid, c->level, c->tf, adapted, c->threads, &bytes, err);
    FREED float *octaves = malloc(n * sizeof *octaves);
    if (status == ISO_OK && !octaves)
        status = iso_fail(err, ISO_E_MEMORY, "no memory for the scale of %zu voxels", n);
    for (size_t i = 0; i < n && status == ISO_OK; ++i)
        octaves[i] = (float)iso_extinction_scale_log2(bytes[i]);
    in.tfs[0] = adapted;
    in.octaves[0] = octaves;
    TRY(status, look(c, SCALED, in, err));
    return status;
}

static void note(ghost_bench *b, const ghost_case *c)
{
    json_t *row = json_pack("{s:s, s:s, s:i, s:b, s:i}", "volume", c->volume, "tf", c->tf_name, "level", (int)c->level,
                            "kept_original", c->judgment.use_original, "given_back", (int)c->judgment.given_back);
    for (size_t i = 0; i < WAYS; ++i)
        json_object_set_new(row, way_names[i],
                            json_pack("{s:f, s:f, s:f}", "ghost", c->seen[i].ghost, "ssim_dissimilarity",
                                      c->seen[i].ssim_dissimilarity, "rmse", c->seen[i].rmse));
    json_array_append_new(b->rows, row);
    if (!b->cli->json) {
        printf("%-20s %-13s %zu ", c->volume, c->tf_name, c->level);
        for (size_t i = 0; i < WAYS; ++i)
            printf(" %6.2f %5.4f", 100 * c->seen[i].ghost, c->seen[i].ssim_dissimilarity);
        printf("  %s\n", c->judgment.use_original ? "original kept" : c->judgment.given_back > 0 ? "given back" : "");
    }
    fflush(stdout);
}

static iso_status run_case(ghost_bench *b, ghost_case *c, iso_error *err)
{
    const iso_level *fine = &c->pyramid->levels[0], *coarse = &c->pyramid->levels[c->level];
    iso_adapt_options always = iso_adapt_defaults();
    FREED uint8_t *empty = NULL;
    OWNED(iso_tf_table) adapted = {0};
    always.fall_back = false;
    always.threads = c->threads;
    NEED(iso_ghost_mask(fine, coarse, c->level, c->tf, c->threads, &empty, err));
    NEED(iso_adapt_level(c->pyramid, c->level, c->tf, &always, &adapted, NULL, err));
    const iso_small_views_input in = {
        .fine = fine, .coarse = coarse, .level = c->level, .original = c->tf, .empty = empty, .threads = c->threads};
    NEED(look_at_tables(c, in, &adapted, err));
    NEED(look_at_2d(c, in, err));
    NEED(look_at_scale(c, in, &adapted, err));
    note(b, c);
    return ISO_OK;
}

/* Runs the transfer function of --tf once per volume, or the four that all benchmarks of levels use. */
static iso_status run_tf(void *user, const iso_lab_visited *v, iso_error *err)
{
    ghost_bench *b = user;
    const iso_level *level0 = &v->pyramid->levels[0];
    iso_tf tf = iso_level_tf_of(v->tf), loaded = {0};
    iso_tf_table table = {0};
    if (b->tf_path && v->number % ISO_LEVEL_TF_COUNT > 0)
        return ISO_OK;
    iso_status status = b->tf_path ? iso_tf_load(b->tf_path, &loaded, err) : ISO_OK;
    TRY(status, iso_tf_tabulate(b->tf_path ? &loaded : &tf, level0->min, level0->max, &level0->geometry, &table, err));
    for (size_t level = 1; level < v->pyramid->level_count && status == ISO_OK; ++level) {
        ghost_case c = {.pyramid = v->pyramid,
                        .level = level,
                        .volume = v->volume,
                        .tf_name = b->tf_path ? iso_path_base(b->tf_path) : v->tf->name,
                        .tf = &table,
                        .threads = b->cli->threads};
        status = run_case(b, &c, err);
    }
    iso_tf_table_destroy(&table);
    iso_tf_destroy(&loaded);
    return status;
}

static iso_status run_all(ghost_bench *b, iso_error *err)
{
    b->rows = json_array();
    if (!b->cli->json) {
        printf("%-20s %-13s %c ", "ghost in %, 1-SSIM", "", ' ');
        for (size_t i = 0; i < WAYS; ++i)
            printf(" %13s", way_names[i]);
        printf("\n");
    }
    const iso_progress progress = iso_cli_progress(b->cli);
    const iso_status status = iso_lab_visit_volumes(&(iso_lab_volumes){b->cli, &b->input, b->levels, &progress}, run_tf, b, err);
    if (status == ISO_OK && b->cli->json) {
        json_t *root = iso_cli_json(b->cli);
        json_object_set(root, "cases", b->rows);
        iso_cli_print_json(root);
    }
    json_decref(b->rows);
    return status;
}

static const iso_option options[] = {
    {"levels", 0, "use N levels, counting level 0", "N", ISO_IN(ghost_bench, levels), .flags = ISO_SHOWN, .least = 2,
     .most = 8},
    {"tf", 0, "use this transfer function instead of the four", "FILE", ISO_IN(ghost_bench, tf_path)},
    ISO_OPTIONS_OF(ghost_bench, input, iso_input_rows),
    ISO_OPTIONS_END,
};

static iso_status run(const iso_cli *cli, void *values, iso_error *err)
{
    ghost_bench *b = values;
    b->cli = cli;
    return run_all(b, err);
}

const iso_command iso_lab_ghosts = {
    .name = "ghosts",
    .summary = "ghosts: structures in coarse levels that level 0 does not show, by method",
    .min_arguments = 1,
    .max_arguments = 64,
    .usage = "VOLUME|PYRAMID.iso... [options]",
    .details =
        "Four transfer functions, or that of --tf, at each level in twelve small pictures. Methods: the original\n"
        "transfer function, the adapted one, the choice of --adapt, the 2D one with the deviation, and the adapted\n"
        "one with an extinction scale. The ghost is the visible opacity in voxels in and around which level 0 shows\n"
        "nothing, in percent of level 0's. It is printed with 1 - SSIM against level 0.",
    .examples = "  isoshade make shells --size 48 --type uint8 -o shells.nrrd\n"
                "  isoshade-lab ghosts shells.nrrd --levels 3\n",
    ISO_COMMAND_OPTIONS(ghost_bench, options, .levels = 4),
    .run = run,
};

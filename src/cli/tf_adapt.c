/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "cli/tf.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/inputs.h"
#include "base/json.h"
#include "base/stamp.h"
#include "plan/optimize.h"
#include "scene/subject.h"
#include "tf/format.h"
#include "tf/ghost.h"

/* Returns FILE for one level, or NAME_level_K.tf.json for all; to be freed. */
static char *adapted_path(const iso_tf_arguments *a, size_t level)
{
    char *path = NULL;
    if (a->level > 0)
        return strdup(a->output);
    size_t length = strlen(a->output);
    if (iso_path_ends_with(a->output, ".tf.json"))
        length -= strlen(".tf.json");
    return asprintf(&path, "%.*s_level_%zu.tf.json", (int)length, a->output, level) < 0 ? NULL : path;
}

/* True for a transfer function as this command writes it. */
static bool is_tf(const char *path)
{
    OWNED(iso_tf) tf = {0};
    json_auto_t *root = NULL;
    const bool is_one = iso_json_load(path, &root, NULL) == ISO_OK && iso_tf_from_json(root, path, &tf, NULL) == ISO_OK;
    return is_one;
}

/* Refuses to replace a foreign file whose name was made from -o. */
static iso_status guard_level(const iso_tf_arguments *a, size_t level, iso_error *err)
{
    FREED char *path = adapted_path(a, level);
    NEED(path ? iso_inputs_announce(path, err) : iso_fail(err, ISO_E_MEMORY, "out of memory"));
    return iso_stamp_guard_adjacent(path, is_tf(path), err);
}

static json_t *json_of_level(size_t level, const char *path, size_t entry_count, const iso_adapt_judgment *v)
{
    json_t *entry = json_pack("{s:i, s:s, s:i, s:f, s:f, s:b}", "level", (int)level, "tf", path, "entries",
                              (int)entry_count, "rms_original", v->rms_original, "rms_adapted", v->rms_adapted,
                              "kept_original", v->use_original);
    if (v->seen)
        json_object_set_new(entry, "small_views",
                            json_pack("{s:f, s:f, s:f, s:f, s:f, s:f, s:i}", "ssim_dissimilarity_original",
                                      v->seen_original.ssim_dissimilarity, "ssim_dissimilarity_adapted",
                                      v->seen_adapted.ssim_dissimilarity, "rmse_original", v->seen_original.rmse,
                                      "rmse_adapted", v->seen_adapted.rmse, "ghost", v->ghost, "ghost_left",
                                      v->seen_adapted.ghost, "given_back", (int)v->given_back));
    return entry;
}

static void add_optimized(json_t *entry, const iso_level_seen seen[2])
{
    json_object_set_new(entry, "optimized",
                        json_pack("{s:[f, f], s:[f, f]}", "ssim_dissimilarity", seen[0].ssim_dissimilarity,
                                  seen[1].ssim_dissimilarity, "rmse", seen[0].rmse, seen[1].rmse));
}

static void print_level(size_t level, const char *path, const iso_adapt_judgment *v)
{
    printf("level %zu  %s", level, path);
    if (v->seen)
        printf("  small views: 1-SSIM %.4f, adapted %.4f; RMSE %.4f, adapted %.4f", v->seen_original.ssim_dissimilarity,
               v->seen_adapted.ssim_dissimilarity, v->seen_original.rmse, v->seen_adapted.rmse);
    else
        printf("  error at the voxels %.5f, adapted %.5f", v->rms_original, v->rms_adapted);
    printf("%s\n", v->use_original ? "  original kept" : "");
    if (v->given_back > 0)
        printf(
            "         a ghost of %.1f %% is left out with its values; --extinction-scale of render and export avoids ghosts\n",
            100 * v->ghost);
    else if (!v->seen && v->ghost > ISO_GHOST_LIMIT)
        printf(
            "         draws a ghost of %.1f %%; omit --always to leave it out, or avoid ghosts with --extinction-scale of render "
            "and export\n",
            100 * v->ghost);
}

/* A run over the levels of a pyramid. */
typedef struct adapt_run {
    const iso_tf_arguments *a;
    const iso_pyramid *p;
    const iso_tf_table *tf;
    json_t *levels;
    iso_small_views_fine level_0; /* drawn when the first level is adapted */
    const iso_scene *scene;
    iso_level_gate gate; /* open if transfer functions are optimized */
} adapt_run;

static void adapt_run_destroy(adapt_run *run)
{
    iso_level_gate_close(&run->gate);
    iso_small_views_fine_destroy(&run->level_0);
}

/* Replaces a level's transfer function by an optimized one, if that is nearer. */
static iso_status optimize(adapt_run *run, size_t level, iso_tf_table *table, iso_level_seen seen[2], iso_error *err)
{
    const iso_progress progress = iso_cli_progress(run->a->cli);
    const iso_optimize_options opt = {.effort = ISO_EFFORT_FAST, .seed = 1, .threads = run->a->cli->threads};
    iso_tf_table better = {0};
    NEED(iso_optimize_tf(&run->gate, level, run->scene,
                         &(iso_shown_level){&run->p->levels[level], table, run->p->levels[level].scale}, &opt, &better,
                         seen, &progress, err));
    iso_tf_table_destroy(table);
    *table = better;
    return ISO_OK;
}

static iso_status adapt_one(adapt_run *run, size_t level, iso_error *err)
{
    const iso_tf_arguments *a = run->a;
    const char *input = a->cli->arguments[1];
    iso_adapt_options opt = {0};
    iso_adapt_judgment v;
    OWNED(iso_tf_table) table = {0};
    OWNED(iso_tf) file = {0};
    iso_level_seen seen[2];
    FREED char *path = adapted_path(a, level);
    NEED(path ? iso_cli_adapt_options(&a->adapted, a->cli->threads, &opt, err)
              : iso_fail(err, ISO_E_MEMORY, "out of memory"));
    opt.folder = iso_pyramid_is_one(input) ? input : NULL;
    opt.level_0 = &run->level_0;
    NEED(iso_adapt_level(run->p, level, run->tf, &opt, &table, &v, err));
    if (level > 0 && !opt.fall_back) /* not yet measured by small views */
        NEED(iso_ghost_measure(run->p, level, run->tf, &table, NULL, a->cli->threads, &v.ghost, err));
    if (a->optimize)
        NEED(optimize(run, level, &table, seen, err));
    NEED(iso_tf_from_table(&table, &file, err));
    NEED(iso_tf_save(&file, path, err));
    json_t *entry = json_of_level(level, path, table.count, &v);
    if (a->optimize)
        add_optimized(entry, seen);
    json_array_append_new(run->levels, entry);
    if (!a->cli->json)
        print_level(level, path, &v);
    if (!a->cli->json && a->optimize)
        printf("         optimized: 1-SSIM %.4f, before %.4f; RMSE %.4f, before %.4f\n", seen[1].ssim_dissimilarity,
               seen[0].ssim_dissimilarity, seen[1].rmse, seen[0].rmse);
    return ISO_OK;
}

static iso_status tabulate(const iso_scene *scene, const iso_pyramid *p, iso_tf_table *table, iso_error *err)
{
    return iso_tf_tabulate(&scene->tf, iso_pyramid_lo(p), iso_pyramid_hi(p), &p->levels[0].geometry, table, err);
}

/* Loads the pyramid arguments[1], or builds it from a volume. A stored pyramid, which keeps its histograms, is read
 * with samples only for pictures, for transfer functions made from values, and if a histogram is missing. */
static iso_status load(const iso_tf_arguments *a, const iso_subject_look *look, const iso_pyramid_options *build,
                       iso_pyramid *p, iso_error *err)
{
    const char *input = a->cli->arguments[1];
    const iso_progress progress = iso_cli_progress(a->cli);
    if (a->optimize || !iso_pyramid_is_one(input))
        return iso_subject_load_pyramid(input, &a->input, build, &progress, p, err);
    NEED(iso_pyramid_load_outline(input, p, err));
    const bool draws =
        !a->adapted.always && iso_geometry_voxel_count(&p->levels[0].geometry) <= ISO_SMALL_VIEWS_MAX_VOXELS;
    if (!draws && !iso_subject_look_needs_values(look))
        return ISO_OK;
    iso_pyramid_destroy(p);
    return iso_pyramid_load_scalars(input, p, err);
}

void iso_cli_tf_expect_levels(const iso_cli *cli)
{
    const iso_cli_stage stages[] = {{"pyramid", 1}, {ISO_TF_LEVELS_STAGE, 4}};
    const bool is_built = cli->argument_count < 2 || iso_pyramid_is_one(cli->arguments[1]);
    iso_cli_expect(cli, stages + is_built, 2 - (size_t)is_built);
}

/* Refuses an output that leaves no name for the levels' files, such as "", "x/" and ".tf.json". */
static iso_status check_output_name(const iso_tf_arguments *a, iso_error *err)
{
    const char *name = iso_path_base(a->output);
    if (*name && strcmp(name, ".tf.json") != 0)
        return ISO_OK;
    return iso_fail(err, ISO_E_USAGE, "-o is \"%s\", must be the name of a file", a->output);
}

static iso_status adapt_levels(adapt_run *run, iso_error *err)
{
    const iso_tf_arguments *a = run->a;
    const iso_progress progress = iso_cli_progress(a->cli);
    const size_t count = run->p->level_count;
    for (size_t k = 1; k < count; ++k) {
        iso_progress_report(&progress, ISO_TF_LEVELS_STAGE, (double)(k - 1) / (double)(count - 1));
        if (a->level == 0 || (size_t)a->level == k)
            NEED(adapt_one(run, k, err));
    }
    iso_progress_report(&progress, ISO_TF_LEVELS_STAGE, 1);
    return ISO_OK;
}

iso_status iso_cli_tf_adapt(const iso_tf_arguments *a, iso_error *err)
{
    const iso_cli *cli = a->cli;
    iso_pyramid_options build = iso_pyramid_defaults();
    OWNED(iso_pyramid) p = {0};
    iso_subject_look look;
    iso_adapt_options checked;
    OWNED(iso_scene) scene = {0};
    OWNED(iso_tf_table) table = {0};
    json_auto_t *levels = json_array();
    OWNED(adapt_run) run = {.a = a, .p = &p, .tf = &table, .levels = levels, .scene = &scene};
    if (cli->argument_count != 2 || !a->output)
        return iso_fail(err, ISO_E_USAGE, "usage: isoshade tf adapt VOLUME|PYRAMID.iso [--tf FILE|PRESET] -o OUT");
    build.threads = cli->threads;
    build.level_count = (size_t)(a->level > 0 ? a->level + 1 : a->level_count);
    iso_cli_tf_expect_levels(cli);
    NEED(check_output_name(a, err));
    NEED(iso_cli_look_check(&a->look, cli->threads, &look, err));
    NEED(iso_cli_adapt_options(&a->adapted, cli->threads, &checked, err));
    NEED(load(a, &look, &build, &p, err));
    NEED(iso_pyramid_check_level(&p, cli->arguments[1], (size_t)a->level, err));
    for (size_t k = 1; k < p.level_count && a->level == 0; ++k)
        NEED(guard_level(a, k, err));
    NEED(iso_subject_make_scene(&look, &p, &scene, err));
    NEED(tabulate(&scene, &p, &table, err));
    if (a->optimize)
        NEED(iso_level_gate_open(&run.gate, &p, &scene, cli->threads, err));
    NEED(adapt_levels(&run, err));
    if (cli->json)
        iso_cli_print_results(cli, json_pack("{s:O}", "levels", levels));
    return ISO_OK;
}

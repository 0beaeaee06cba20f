/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "cli/tf_adapt.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/inputs.h"
#include "base/json.h"
#include "base/stamp.h"
#include "plan/auto_choice.h"
#include "scene/subject.h"
#include "tf/format.h"
#include "tf/ghost.h"

/* FILE for one level, NAME_level_K.tf.json for all; to be freed. */
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

/* As this command writes them. */
static bool is_tf(const char *path)
{
    iso_tf tf = {0};
    json_t *root = NULL;
    const bool is_one = iso_json_load(path, &root, NULL) == ISO_OK && iso_tf_from_json(root, path, &tf, NULL) == ISO_OK;
    json_decref(root);
    iso_tf_destroy(&tf);
    return is_one;
}

/* A name that was made from -o may be somebody's. */
static iso_status guard_level(const iso_tf_arguments *a, size_t level, iso_error *err)
{
    char *path = adapted_path(a, level);
    iso_status status = path ? iso_inputs_announce(path, err) : iso_fail(err, ISO_E_MEMORY, "out of memory");
    if (status == ISO_OK)
        status = iso_stamp_guard_beside(path, is_tf(path), err);
    free(path);
    return status;
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
        printf("         a ghost of %.1f %% is left out with the values that draw it; --extinction-scale of render and "
               "export shows both in their places\n",
               100 * v->ghost);
    else if (!v->seen && v->ghost > ISO_GHOST_LIMIT)
        printf("         draws a ghost of %.1f %%: --adapt of render and export, without --always, leaves it out, "
               "--extinction-scale shows it in its place\n",
               100 * v->ghost);
}

/* The levels of one pyramid. */
typedef struct adapt_run {
    const iso_tf_arguments *a;
    const iso_pyramid *p;
    const iso_tf_table *tf;
    const iso_auto_choice *choice; /* with --auto, or NULL */
    json_t *levels;
    iso_small_views_fine level_0; /* drawn for the first level that is adapted */
} adapt_run;

/* What --auto chose for a level. */
typedef struct chosen_level {
    const iso_auto_design *design; /* NULL without --auto */
    double gain;
} chosen_level;

static iso_status choose_level(const adapt_run *run, size_t level, chosen_level *chosen, iso_error *err)
{
    size_t design = 0;
    *chosen = (chosen_level){0};
    if (!run->choice)
        return ISO_OK;
    const iso_status status = iso_auto_choose_level(run->choice, level, run->p->options.scalar_filter,
                                                    run->a->budget_bytes, &design, &chosen->gain, err);
    if (status == ISO_OK)
        chosen->design = iso_auto_design_at(design);
    return status;
}

static void add_chosen(json_t *entry, const chosen_level *chosen)
{
    if (chosen->design)
        json_object_set_new(entry, "auto",
                            json_pack("{s:s, s:s, s:i, s:f}", "chosen", chosen->design->name, "options",
                                      iso_auto_options(chosen->design), "bytes_per_voxel", chosen->design->bytes,
                                      "predicted", chosen->gain));
}

static void print_chosen(const chosen_level *chosen)
{
    if (!chosen->design)
        return;
    const char *options = iso_auto_options(chosen->design);
    printf("         chosen: %s (%s), predicted error %.2f of what small views would choose%s%s\n",
           chosen->design->name, chosen->design->summary, chosen->gain, *options ? "; show it with " : "", options);
}

static iso_status adapt_one(adapt_run *run, size_t level, iso_error *err)
{
    const iso_tf_arguments *a = run->a;
    const char *input = a->cli->arguments[1];
    iso_adapt_options opt = {0};
    iso_adapt_judgment v;
    iso_tf_table table = {0};
    iso_tf file = {0};
    chosen_level chosen = {0};
    char *path = adapted_path(a, level);
    iso_status status = path ? iso_cli_adapt_options(&a->adapted, a->cli->threads, &opt, err)
                             : iso_fail(err, ISO_E_MEMORY, "out of memory");
    opt.folder = iso_pyramid_is_one(input) ? input : NULL;
    opt.level_0 = &run->level_0;
    if (status == ISO_OK)
        status = choose_level(run, level, &chosen, err);
    opt.fall_back = opt.fall_back && !(chosen.design && chosen.design->always);
    const bool adapted = !chosen.design || chosen.design->adapted;
    if (status == ISO_OK) /* level 0: the transfer function as it is */
        status = iso_adapt_level(run->p, adapted ? level : 0, run->tf, &opt, &table, &v, err);
    if (status == ISO_OK && adapted && level > 0 && !opt.fall_back) /* no small views have looked for one */
        status = iso_ghost_measure(run->p, level, run->tf, &table, NULL, a->cli->threads, &v.ghost, err);
    if (status == ISO_OK)
        status = iso_tf_from_table(&table, &file, err);
    if (status == ISO_OK)
        status = iso_tf_save(&file, path, err);
    if (status == ISO_OK) {
        json_t *entry = json_of_level(level, path, table.count, &v);
        add_chosen(entry, &chosen);
        json_array_append_new(run->levels, entry);
        if (!a->cli->json) {
            print_level(level, path, &v);
            print_chosen(&chosen);
        }
    }
    iso_tf_destroy(&file);
    iso_tf_table_destroy(&table);
    free(path);
    return status;
}

iso_status iso_cli_tf_load_subject(const iso_tf_arguments *a, const iso_subject_look *look, bool small_views,
                                   const iso_pyramid_options *build, iso_pyramid *p, iso_error *err)
{
    const char *input = a->cli->arguments[1];
    iso_progress progress = iso_cli_progress(a->cli);
    if (iso_pyramid_is_one(input)) {
        const iso_status status = iso_pyramid_load_outline(input, p, err);
        if (status != ISO_OK)
            return status;
        small_views = small_views && iso_geometry_voxel_count(&p->levels[0].geometry) <= ISO_SMALL_VIEWS_MAX_VOXELS;
        if (!small_views && !iso_subject_look_needs_values(look))
            return ISO_OK;
        iso_pyramid_destroy(p);
        return iso_pyramid_load_scalars(input, p, err);
    }
    return iso_subject_load_pyramid(input, &a->input, build, &progress, p, err);
}

iso_status iso_cli_tf_tabulate(const iso_subject_look *look, const iso_pyramid *p, iso_tf_table *table, iso_error *err)
{
    iso_scene scene;
    iso_status status = iso_subject_make_scene(look, p, &scene, err);
    if (status == ISO_OK)
        status = iso_tf_tabulate(&scene.tf, iso_pyramid_lo(p), iso_pyramid_hi(p), &p->levels[0].geometry, table, err);
    iso_scene_destroy(&scene);
    return status;
}

void iso_cli_tf_expect_levels(const iso_cli *cli)
{
    const iso_cli_stage stages[] = {{"pyramid", 1}, {ISO_TF_LEVELS_STAGE, 4}};
    const bool is_built = cli->argument_count < 2 || iso_pyramid_is_one(cli->arguments[1]);
    iso_cli_expect(cli, stages + is_built, 2 - (size_t)is_built);
}

/* Names of levels are made of it: "", "x/" and ".tf.json" leave none. */
static iso_status check_output_name(const iso_tf_arguments *a, iso_error *err)
{
    const char *name = iso_path_base(a->output);
    if (*name && strcmp(name, ".tf.json") != 0)
        return ISO_OK;
    return iso_fail(err, ISO_E_USAGE, "-o is \"%s\", wanted the name of a file", a->output);
}

/* Predictions are of levels of a filter: level 0 is reduced by each again. */
static iso_status measure(const adapt_run *run, iso_auto_choice *choice, iso_error *err)
{
    const iso_pyramid *p = run->p;
    const iso_level *level0 = &p->levels[0];
    const iso_progress progress = iso_cli_progress(run->a->cli);
    iso_pyramid_options opt = p->options;
    opt.threads = run->a->cli->threads;
    opt.level_count = p->level_count;
    if (p->made_for)
        return iso_fail(err, ISO_E_USAGE, "%s: made for a scene, --auto predicts for levels of a scalar filter",
                        run->a->cli->arguments[1]);
    if (!level0->scalar)
        return iso_fail(err, ISO_E_MEMORY, "%s: --auto works in memory, which takes up to %zu voxels",
                        run->a->cli->arguments[1], ISO_SMALL_VIEWS_MAX_VOXELS);
    const iso_volume v = {.geometry = level0->geometry, .type = ISO_F32, .data = level0->scalar};
    return iso_auto_measure(&v, &opt, run->tf, choice, &progress, err);
}

static iso_status adapt_levels(adapt_run *run, iso_error *err)
{
    const iso_tf_arguments *a = run->a;
    const iso_progress progress = iso_cli_progress(a->cli);
    const size_t count = run->p->level_count;
    iso_auto_choice choice = {0};
    iso_status status = ISO_OK;
    if (a->automatic) {
        status = measure(run, &choice, err);
        run->choice = &choice;
    }
    for (size_t k = 1; k < count && status == ISO_OK; ++k) {
        iso_progress_report(&progress, ISO_TF_LEVELS_STAGE, (double)(k - 1) / (double)(count - 1));
        if (a->level == 0 || (size_t)a->level == k)
            status = adapt_one(run, k, err);
    }
    iso_progress_report(&progress, ISO_TF_LEVELS_STAGE, 1);
    run->choice = NULL;
    return status;
}

static iso_status check_auto(const iso_tf_arguments *a, iso_error *err)
{
    if (a->automatic && a->adapted.always)
        return iso_fail(err, ISO_E_USAGE, "--auto chooses whether to adapt, --always says so: one of the two");
    if (a->automatic && a->budget_bytes < ISO_AUTO_LEAST_BYTES)
        return iso_fail(err, ISO_E_USAGE, "--budget is %d, directions alone take %d bytes a voxel", a->budget_bytes,
                        ISO_AUTO_LEAST_BYTES);
    return ISO_OK;
}

iso_status iso_cli_tf_adapt(const iso_tf_arguments *a, iso_error *err)
{
    const iso_cli *cli = a->cli;
    iso_pyramid_options build = iso_pyramid_defaults();
    iso_pyramid p = {0};
    iso_subject_look look;
    iso_adapt_options checked;
    iso_tf_table table = {0};
    json_t *levels = json_array();
    if (cli->argument_count != 2 || !a->output) {
        json_decref(levels);
        return iso_fail(err, ISO_E_USAGE, "wanted: isoshade tf adapt VOLUME|PYRAMID.iso [--tf FILE|PRESET] -o OUT");
    }
    build.threads = cli->threads;
    build.level_count = (size_t)(a->level > 0 ? a->level + 1 : a->level_count);
    iso_cli_tf_expect_levels(cli);
    iso_status status = check_output_name(a, err);
    if (status == ISO_OK)
        status = check_auto(a, err);
    if (status == ISO_OK)
        status = iso_cli_look_check(&a->look, cli->threads, &look, err);
    if (status == ISO_OK)
        status = iso_cli_adapt_options(&a->adapted, cli->threads, &checked, err);
    if (status == ISO_OK)
        status = iso_cli_tf_load_subject(a, &look, !a->adapted.always, &build, &p, err);
    if (status == ISO_OK && (size_t)a->level >= p.level_count)
        status = iso_fail(err, ISO_E_RANGE, "%s: level %d, the pyramid has levels 0 to %zu", cli->arguments[1],
                          a->level, p.level_count - 1);
    for (size_t k = 1; k < p.level_count && status == ISO_OK; ++k)
        if (a->level == 0)
            status = guard_level(a, k, err);
    if (status == ISO_OK)
        status = iso_cli_tf_tabulate(&look, &p, &table, err);
    adapt_run run = {.a = a, .p = &p, .tf = &table, .levels = levels};
    if (status == ISO_OK)
        status = adapt_levels(&run, err);
    iso_small_views_fine_destroy(&run.level_0);
    if (status == ISO_OK && cli->json) {
        json_t *root = iso_cli_json(cli);
        json_object_set(root, "levels", levels);
        iso_cli_print_json(root);
    }
    json_decref(levels);
    iso_tf_table_destroy(&table);
    iso_pyramid_destroy(&p);
    return status;
}

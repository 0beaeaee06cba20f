/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "cli/build_for.h"

#include <signal.h>
#include <stdio.h>

#include "base/json.h"
#include "base/provenance.h"
#include "options/visible.h"
#include "plan/scene_levels.h"
#include "scene/scene.h"

/* Estimates the memory before reading. */
static iso_status check_memory(const iso_build_for *b, iso_error *err)
{
    ENDED_BY(iso_source_close_owned) iso_volume_source *source = NULL;
    NEED(iso_volume_input_open(b->volume, b->input, &source, err));
    const iso_volume *v = iso_source_volume(source);
    const double needed = (double)iso_scene_levels_bytes(&v->geometry, v->type, b->scene_count, b->effort) / 1048576;
    if (needed > b->memory_mb)
        return iso_fail(err, ISO_E_MEMORY, "%s: --for works in memory and needs %.0f MB, --memory is %g", b->volume,
                        needed, b->memory_mb);
    return ISO_OK;
}

static const char *scene_name(const iso_scene *scene)
{
    return scene->path ? iso_provenance_name(scene->path) : ISO_BUILD_FOR_FIRST;
}

/* Prints "level 2: fitted, 1 - SSIM .041 (as-built .063, least-squares .049)", with several scenes for each of them. */
static void print_level(const iso_build_for *b, const iso_scene *scenes, const iso_scene_level *made, size_t level)
{
    const iso_level_way *way = &iso_level_ways[made->chosen];
    for (size_t s = 0; s < b->scene_count; ++s) {
        const iso_level_candidate *chosen = &made->candidates[s][made->chosen];
        const char *before = " (";
        printf("level %zu: %s%s%s, 1 - SSIM %.4f", level, iso_level_scalar_name(way->scalar),
               way->scaled ? ", scaled" : "", chosen->adapted ? ", under its own TF" : "",
               chosen->seen.ssim_dissimilarity);
        if (b->scene_count > 1)
            printf(", %.2f of the best for %s alone", iso_scene_level_ratio(made, s), scene_name(&scenes[s]));
        for (int i = 0; i < ISO_LEVEL_WAY_COUNT; ++i) {
            const iso_level_candidate *c = &made->candidates[s][i];
            if (c == chosen || !c->tried)
                continue;
            printf("%s%s%s %.4f", before, iso_level_scalar_name(iso_level_ways[i].scalar),
                   iso_level_ways[i].scaled ? " scaled" : "", c->seen.ssim_dissimilarity);
            before = ", ";
        }
        printf(")\n");
    }
}

/* Warns of scenes that a level of their own would show better. */
static void warn_of_ratio(const iso_build_for *b, const iso_scene *scenes, const iso_scene_level *made, size_t level)
{
    for (size_t s = 0; s < b->scene_count && !b->cli->quiet; ++s) {
        if (!(iso_scene_level_ratio(made, s) > 1 + ISO_LEVEL_GATE_GAIN))
            continue;
        iso_progress_line_hide(b->cli->progress);
        fprintf(stderr,
                "isoshade build: warning: level %zu has %.2f times the 1 - SSIM of the best level for %s alone; build "
                "a pyramid for it\n",
                level, iso_scene_level_ratio(made, s), scene_name(&scenes[s]));
    }
}

static void print(const iso_build_for *b, const iso_pyramid *p, const iso_scene *scenes, const iso_scene_level *levels)
{
    for (size_t k = 1; k < p->level_count; ++k)
        warn_of_ratio(b, scenes, &levels[k], k);
    if (b->cli->json) {
        json_t *root = iso_cli_json(b->cli), *seconds = json_array();
        for (size_t k = 1; k < p->level_count; ++k)
            json_array_append_new(seconds, json_real(levels[k].seconds));
        json_object_set_new(json_object_get(root, "options"), "for", json_string(b->scenes));
        json_object_set_new(root, "output", json_string(b->output));
        json_object_set(root, "made_for", p->made_for);
        json_object_set_new(root, "seconds_of_levels", seconds);
        iso_cli_print_json(root);
        return;
    }
    for (size_t k = 0; k < p->level_count; ++k) {
        const iso_level *l = &p->levels[k];
        printf("level %zu  %zu x %zu x %zu  %s  %.6g to %.6g\n", k, l->geometry.size[0], l->geometry.size[1],
               l->geometry.size[2], iso_type_name(l->stored_type), l->min, l->max);
    }
    for (size_t k = 1; k < p->level_count; ++k)
        print_level(b, scenes, &levels[k], k);
    printf("%s\n", b->output);
}

/* Warns if the scene shows nothing, since its levels would be useless. */
static iso_status warn(const iso_build_for *b, const iso_pyramid *p, const iso_scene *scene, iso_error *err)
{
    OWNED(iso_view) view = {0};
    const iso_level *level0 = &p->levels[0];
    NEED(iso_scene_resolve(scene, &level0->geometry, level0->min, level0->max, &view, err));
    iso_cli_warn_view(b->cli, p, &view, NULL, &(bool){false});
    return ISO_OK;
}

/* ---- Ctrl-C ends optimizing, and keeps the levels so far ---- */

static volatile sig_atomic_t stop;

static void note_signal(int number)
{
    (void)number;
    stop = 1;
}

static iso_status make_levels(const iso_build_for *b, iso_pyramid *p, const iso_scene *scenes, iso_scene_level *levels,
                              const iso_progress *progress, iso_error *err)
{
    const iso_optimize_options opt = {.effort = b->effort, .seed = 1, .stop = &stop};
    struct sigaction own = {.sa_handler = note_signal, .sa_flags = SA_RESTART | SA_RESETHAND}, before;
    if (b->effort == ISO_EFFORT_NONE)
        return iso_scene_levels_make(p, 1, scenes, b->scene_count, NULL, b->cli->threads, levels, progress, err);
    sigemptyset(&own.sa_mask);
    sigaction(SIGINT, &own, &before);
    const iso_status status = iso_scene_levels_make(p, 1, scenes, b->scene_count, &opt, b->cli->threads, levels,
                                                    progress, err);
    sigaction(SIGINT, &before, NULL);
    if (stop && !b->cli->quiet) {
        iso_progress_line_hide(b->cli->progress);
        fprintf(stderr, "isoshade build: interrupted: the levels are the best so far\n");
    }
    return status;
}

iso_status iso_cli_build_for(const iso_build_for *b, const iso_pyramid_options *opt, iso_error *err)
{
    iso_progress progress = iso_cli_progress(b->cli);
    iso_scene scenes[ISO_SCENES_MOST] = {{.path = NULL}};
    iso_volume volume = {0};
    iso_pyramid p = {0};
    iso_scene_level levels[32];
    iso_cli_expect(b->cli, (const iso_cli_stage[]){{"pyramid", 1}, {"levels for the scene", 4}}, 2);
    iso_status status = check_memory(b, err);
    TRY(status, iso_volume_input_load(b->volume, b->input, &volume, err));
    TRY(status, iso_pyramid_build(&volume, b->volume, opt, &p, &progress, err));
    iso_volume_destroy(&volume);
    for (size_t i = 0; i < b->scene_count; ++i) {
        TRY(status, iso_subject_make_scene(&b->looks[i], &p, &scenes[i], err));
        TRY(status, warn(b, &p, &scenes[i], err));
    }
    TRY(status, make_levels(b, &p, scenes, levels, &progress, err));
    TRY(status, iso_pyramid_save(&p, b->output, err));
    if (status == ISO_OK)
        print(b, &p, scenes, levels);
    iso_pyramid_destroy(&p);
    for (size_t i = 0; i < b->scene_count; ++i)
        iso_scene_destroy(&scenes[i]);
    return status;
}

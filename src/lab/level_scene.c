/* SPDX-License-Identifier: MIT */
#include "lab/level_scene.h"

#include <stdlib.h>
#include <string.h>

#include "fit/extinction_scale.h"
#include "lab/level_tfs.h"
#include "plan/scene_levels.h"
#include "tf/level_look.h"

static void set_range(iso_level *l)
{
    l->min = l->max = (double)l->scalar[0];
    for (size_t i = 1; i < iso_geometry_voxel_count(&l->geometry); ++i) {
        l->min = (double)l->scalar[i] < l->min ? (double)l->scalar[i] : l->min;
        l->max = (double)l->scalar[i] > l->max ? (double)l->scalar[i] : l->max;
    }
}

/* Shows `scalar` under the transfer function that --adapt selects for it; takes ownership of `scalar`. */
static iso_status show(const iso_level_subject *s, float *scalar, iso_level_shown *shown, iso_error *err)
{
    iso_pyramid with = *s->pyramid;
    iso_level levels[32];
    iso_adapt_options opt = iso_adapt_defaults();
    opt.threads = s->threads;
    shown->scalar = shown->level.scalar = scalar;
    set_range(&shown->level);
    memcpy(levels, with.levels, with.level_count * sizeof *levels);
    levels[s->level] = shown->level;
    with.levels = levels;
    iso_tf_table_destroy(&shown->tf);
    return iso_adapt_level(&with, s->level, s->tf, &opt, &shown->tf, &shown->judgment, err);
}

iso_scene iso_level_bench_scene(iso_tf tf)
{
    return (iso_scene){.path = (char *)"bench",
                       .orthographic = true,
                       .light_count = 1,
                       .lights = {{.direction = {0.3, 0.5, 0.8}, .in_camera_space = true, .intensity = 1}},
                       .shading = {.ambient = 0.3, .diffuse = 0.7, .power = 1},
                       .step_voxels = 0.5,
                       .tf = tf};
}

/* Takes the transfer function and the extinction scale that show a level. Under an edited one, or one that it was not
 * made for, these are those of `render --adapt`. */
static iso_status take_look(const iso_pyramid *p, const iso_level_subject *s, bool is_edited, iso_level_shown *shown,
                            iso_error *err)
{
    const iso_level *level = &p->levels[s->level];
    iso_adapt_options opt = iso_adapt_defaults();
    iso_tf_table scene = {0};
    iso_status status = iso_level_scene_tf(p, 0, &scene, err);
    opt.threads = s->threads;
    iso_tf_table_destroy(&shown->tf);
    if (status == ISO_OK && is_edited)
        status = iso_adapt_level(p, s->level, s->tf, &opt, &shown->tf, &shown->judgment, err);
    else
        TRY(status, iso_level_look(p, s->level, &scene, &shown->tf, NULL, err));
    iso_tf_table_destroy(&scene);
    shown->extinction_scale = level->scale;
    if (status == ISO_OK && is_edited) {
        if (level->is_optimized)
            status = iso_extinction_scale_level(p, s->level, s->tf, &shown->tf, s->threads, &shown->extinction_scale,
                                                err);
        else
            shown->extinction_scale = NULL;
        free(level->scale);
    }
    return status;
}

/* Shows the level that pictures of some scenes select, among them an optimized one unless there is no effort.
 * is_edited: under a transfer function that is not the first scene's. */
static iso_status make_for_scenes(const iso_level_subject *s, const iso_scene *scenes, size_t scene_count,
                                  iso_effort effort, bool is_edited, iso_level_shown *shown, iso_error *err)
{
    const size_t count = iso_geometry_voxel_count(&shown->level.geometry);
    const iso_optimize_options opt = {.effort = effort, .seed = 1};
    iso_pyramid with = *s->pyramid;
    iso_level levels[32];
    float *scalar = malloc(count * sizeof *scalar);
    uint8_t *codes = malloc(3 * count);
    iso_status status = scalar && codes ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "no memory for %zu voxels", count);
    if (status == ISO_OK) {
        memcpy(scalar, shown->level.scalar, count * sizeof *scalar);
        memcpy(levels, with.levels, with.level_count * sizeof *levels);
        memcpy(codes, shown->level.codes, 3 * count);
        levels[s->level].scalar = scalar;
        levels[s->level].codes = codes;
        levels[s->level].directions = NULL;
        levels[s->level].scale = NULL;
        with.levels = levels;
        with.level_count = s->level + 1;
        with.made_for = NULL;
        status = iso_scene_levels_make(&with, s->level, scenes, scene_count, &opt, s->threads, NULL, NULL, err);
        TRY(status, take_look(&with, s, is_edited, shown, err));
        scalar = levels[s->level].scalar; /* both are replaced if the first ones were not the best */
        codes = levels[s->level].codes;
        json_decref(with.made_for);
    }
    shown->bytes = shown->level.codes = codes;
    shown->scalar = shown->level.scalar = scalar;
    set_range(&shown->level);
    return status;
}

static iso_status make_for_scene(const iso_level_subject *s, iso_effort effort, iso_level_shown *shown, iso_error *err)
{
    OWNED(iso_tf) tf = {0};
    NEED(iso_tf_from_table(s->before, &tf, err));
    const iso_scene scene = iso_level_bench_scene(tf);
    return make_for_scenes(s, &scene, 1, effort, !iso_tf_table_equals(s->tf, s->before), shown, err);
}

iso_status iso_level_make_for_others(const iso_level_subject *s, iso_level_shown *shown, iso_error *err)
{
    const iso_level *level0 = &s->pyramid->levels[0];
    iso_scene scenes[ISO_LEVEL_TF_COUNT];
    size_t count = 0;
    for (size_t i = 0; i < ISO_LEVEL_TF_COUNT; ++i) {
        OWNED(iso_tf_table) table = {0};
        const iso_tf tf = iso_level_tf_of(&iso_level_tfs[i]);
        NEED(iso_tf_tabulate(&tf, level0->min, level0->max, &level0->geometry, &table, err));
        if (!iso_tf_table_equals(&table, s->before))
            scenes[count++] = iso_level_bench_scene(tf);
    }
    return make_for_scenes(s, scenes, count, ISO_EFFORT_FAST, true, shown, err);
}

iso_status iso_level_make_for_scene(const iso_level_subject *s, iso_level_shown *shown, iso_error *err)
{
    return make_for_scene(s, ISO_EFFORT_NONE, shown, err);
}

iso_status iso_level_make_optimized_fast(const iso_level_subject *s, iso_level_shown *shown, iso_error *err)
{
    return make_for_scene(s, ISO_EFFORT_FAST, shown, err);
}

iso_status iso_level_make_optimized(const iso_level_subject *s, iso_level_shown *shown, iso_error *err)
{
    return make_for_scene(s, ISO_EFFORT_NORMAL, shown, err);
}

iso_status iso_level_make_optimized_best(const iso_level_subject *s, iso_level_shown *shown, iso_error *err)
{
    return make_for_scene(s, ISO_EFFORT_BEST, shown, err);
}

iso_status iso_level_optimize_tf(const iso_level_subject *s, iso_level_shown *shown, iso_error *err)
{
    const iso_optimize_options opt = {.effort = ISO_EFFORT_FAST, .seed = 1, .threads = s->threads};
    iso_level_gate gate = {0};
    iso_level_seen seen[2];
    iso_tf tf = {0};
    iso_tf_table table = {0};
    iso_status status = iso_tf_from_table(s->before, &tf, err);
    const iso_scene scene = iso_level_bench_scene(tf);
    TRY(status, iso_level_gate_open(&gate, s->pyramid, &scene, s->threads, err));
    TRY(status, iso_optimize_tf(&gate, s->level, &scene, &(iso_shown_level){&shown->level, &shown->tf, NULL}, &opt,
                                &table, seen, NULL, err));
    if (status == ISO_OK) {
        iso_tf_table_destroy(&shown->tf);
        shown->tf = table;
    }
    iso_level_gate_close(&gate);
    iso_tf_destroy(&tf);
    return status;
}

iso_status iso_level_make_fitted(const iso_level_subject *s, iso_level_shown *shown, iso_error *err)
{
    const size_t bytes = iso_geometry_voxel_count(&shown->level.geometry) * sizeof(float);
    float *least_squares = malloc(bytes), *fitted = malloc(bytes);
    iso_status status = least_squares && fitted ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "no memory for a level");
    if (status == ISO_OK)
        status = iso_level_scalars_make(&(iso_level_scalar_input){&s->pyramid->levels[0], s->tf, s->level, s->threads},
                                        least_squares, fitted, NULL, err);
    free(least_squares);
    if (status == ISO_OK)
        return show(s, fitted, shown, err);
    free(fitted);
    return status;
}

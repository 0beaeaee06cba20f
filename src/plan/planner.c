/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "plan/planner.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "brick/pack.h"
#include "render/cpu/mixed.h"
#include "scene/subject.h"

/* ---- views --------------------------------------------------------------------- */

static iso_vec3 turned(iso_vec3 v, iso_vec3 axis, double angle)
{
    iso_vec3 along = iso_scale(axis, iso_dot(v, axis)), across = iso_sub(v, along);
    return iso_add(along, iso_add(iso_scale(across, cos(angle)), iso_scale(iso_cross(axis, across), sin(angle))));
}

/* Turns the scene's camera. Lights in camera space turn with it when the scene is resolved. */
static void turn_scene(iso_scene *s, double angle)
{
    iso_vec3 up = iso_normalize(s->camera_up);
    s->camera_direction = turned(s->camera_direction, up, angle);
    if (!s->camera_fit)
        s->camera_position = iso_add(s->camera_look_at,
                                     turned(iso_sub(s->camera_position, s->camera_look_at), up, angle));
}

iso_status iso_planner_add_views(const iso_scene *scene, size_t turns, const iso_pyramid *p, iso_view *views,
                                 size_t *count, iso_error *err)
{
    const iso_level *level0 = &p->levels[0];
    for (size_t i = 0; i < turns; ++i) {
        iso_scene side = *scene; /* copies pointers, whose targets stay the first one's */
        turn_scene(&side, 2 * acos(-1) * (double)i / (double)turns);
        NEED(iso_scene_resolve(&side, &level0->geometry, iso_pyramid_lo(p), iso_pyramid_hi(p), &views[*count], err));
        ++*count;
    }
    return ISO_OK;
}

static iso_status load_scene_views(const iso_subject_look *look, size_t turns, const iso_pyramid *p, iso_view *views,
                                   size_t *count, iso_error *err)
{
    OWNED(iso_scene) scene = {0};
    NEED(iso_subject_make_scene(look, p, &scene, err));
    return iso_planner_add_views(&scene, turns, p, views, count, err);
}

iso_status iso_planner_check_pyramid(const iso_pyramid *p, const char *path, iso_error *err)
{
    NEED(iso_subject_refuse_labels(p, path, "a plan", err));
    for (size_t k = 1; k < p->level_count; ++k)
        if (p->levels[k].is_optimized)
            return iso_fail(
                err, ISO_E_USAGE,
                "%s: level %zu is optimized for a scene, and a plan makes its bricks from level 0; plan the "
                "volume, or build without --for",
                path, k);
    return ISO_OK;
}

/* Returns the number of names between commas; 1 for a look without a scene. */
static size_t count_scenes(const iso_subject_look *look)
{
    size_t count = 1;
    for (const char *c = look->scene; c && *c; ++c)
        count += *c == ',';
    return count;
}

iso_status iso_planner_load_views(const iso_subject_look *look, size_t turns, const iso_pyramid *p, iso_view **views,
                                  size_t *count, iso_error *err)
{
    iso_subject_look one = *look;
    *count = 0;
    char *names = strdup(look->scene ? look->scene : ""), *rest = names;
    *views = calloc(count_scenes(look) * turns, sizeof **views);
    iso_status status = names && *views ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "plan: out of memory");
    for (char *name = strsep(&rest, ","); name && status == ISO_OK; name = strsep(&rest, ",")) {
        one.scene = look->scene ? name : NULL;
        status = load_scene_views(&one, turns, p, *views, count, err);
    }
    free(names);
    if (status != ISO_OK) {
        iso_planner_destroy_views(*views, *count);
        *views = NULL;
        *count = 0;
    }
    return status;
}

iso_status iso_planner_check_views(const iso_subject_look *look, iso_error *err)
{
    iso_subject_look one = *look;
    char *names = strdup(look->scene ? look->scene : ""), *rest = names;
    iso_status status = names ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "plan: out of memory");
    for (char *name = strsep(&rest, ","); name && status == ISO_OK; name = strsep(&rest, ",")) {
        one.scene = look->scene ? name : NULL;
        status = iso_subject_check_look(&one, err);
    }
    free(names);
    return status;
}

void iso_planner_destroy_views(iso_view *views, size_t count)
{
    for (size_t i = 0; i < count; ++i)
        iso_view_destroy(&views[i]);
    free(views);
}

/* ---- rendering ------------------------------------------------------------------- */

iso_status iso_planner_draw(const iso_planner *p, const uint8_t *levels, const uint8_t *wanted, const iso_view *view,
                            iso_image *image, iso_error *err)
{
    const iso_brick_field field = {.nodes = p->nodes, .levels = levels, .faces = p->faces};
    iso_gl_brick_options opt = iso_gl_brick_defaults();
    iso_cpu_brick_options cpu = iso_cpu_brick_defaults();
    opt.wanted = cpu.wanted = wanted;
    cpu.threads = p->threads;
    iso_status status = p->gl ? iso_gl_render_bricks(p->gl, &field, view, &opt, image, NULL, err)
                              : iso_cpu_render_bricks(&field, view, &cpu, image, err);
    TRY(status, iso_progress_check(iso_progress_current(), err)); /* a canceled picture has holes */
    if (status != ISO_OK)
        iso_image_destroy(image);
    return status;
}

static iso_status render_levels(iso_planner *p, const uint8_t *levels, const uint8_t *wanted, size_t view,
                                iso_image *image, iso_error *err)
{
    ++p->render_count;
    return iso_planner_draw(p, levels, wanted, &p->views[view], image, err);
}

/* Measures the error of an image in which nothing is drawn. */
static iso_status measure_blank(const iso_image *full, const iso_view *view, double *rmse, iso_error *err)
{
    OWNED(iso_image) blank = {0};
    iso_metrics measured;
    NEED(iso_image_create(&blank, full->width, full->height, err));
    for (size_t i = 0; i < full->width * full->height; ++i)
        for (size_t c = 0; c < 4; ++c)
            blank.rgba[4 * i + c] = c < 3 ? (float)view->background[c] : 0;
    NEED(iso_metrics_measure_differences(&blank, full, &measured, err));
    *rmse = fmin(*rmse, measured.rmse);
    return ISO_OK;
}

iso_status iso_planner_create(iso_planner *p, iso_node_levels *nodes, const iso_planner_options *opt,
                              const iso_progress *progress, iso_error *err)
{
    const iso_view *views = opt->views;
    const size_t view_count = opt->view_count;
    *p = (iso_planner){.nodes = nodes,
                       .views = views,
                       .view_count = view_count,
                       .faces = opt->faces,
                       .blank_rmse = INFINITY,
                       .threads = opt->threads};
    size_t count = iso_brick_count(nodes), side = iso_brick_side(nodes, 0);
    p->full_node_count = count * side * side * side;
    p->wanted = calloc(count, 1);
    p->full = calloc(view_count, sizeof *p->full);
    iso_status status = p->wanted && p->full ? ISO_OK
                                             : iso_fail(err, ISO_E_MEMORY, "plan: no memory for %zu bricks", count);
    if (status == ISO_OK && !iso_gl_is_software())
        status = iso_gl_create(&p->gl, NULL, err);
    for (size_t v = 0; status == ISO_OK && v < view_count; ++v) {
        status = render_levels(p, p->wanted, NULL, v, &p->full[v], err); /* all 0: the levels of all bricks */
        TRY(status, measure_blank(&p->full[v], &views[v], &p->blank_rmse, err));
    }
    TRY(status, iso_node_levels_complete(nodes, opt->threads, err));
    TRY(status, iso_progress_check(progress, err));
    TRY(status, iso_plan_errors_create(&p->plan, nodes, views, view_count, opt->threads, progress, err));
    for (size_t i = 0; status == ISO_OK && i < count; ++i)
        p->wanted[i] = p->plan.footprints[i] > 0;
    if (status != ISO_OK)
        iso_planner_destroy(p);
    return status;
}

static void drop_trial(iso_plan_trial *t)
{
    free(t->levels);
    free(t->drawn);
    iso_image_destroy(&t->image);
    *t = (iso_plan_trial){0};
}

void iso_planner_destroy(iso_planner *p)
{
    drop_trial(&p->best);
    for (size_t v = 0; p->full && v < p->view_count; ++v)
        iso_image_destroy(&p->full[v]);
    free(p->full);
    free(p->wanted);
    iso_plan_errors_destroy(&p->plan);
    iso_gl_destroy(p->gl);
    *p = (iso_planner){0};
}

/* Finds the bricks that the views' transfer functions show at these levels, and counts their nodes. */
static iso_status count_drawn(const iso_planner *p, iso_plan_trial *t, iso_error *err)
{
    const iso_brick_field field = {.nodes = p->nodes, .levels = t->levels, .faces = p->faces};
    size_t count = p->plan.brick_count;
    FREED uint8_t *visible = malloc(count);
    NEED_MEMORY(visible, err, "plan: no memory for %zu bricks", count);
    for (size_t v = 0; v < p->view_count; ++v) {
        const iso_tf_table *tf = &p->views[v].tf, *before = v > 0 ? &p->views[v - 1].tf : NULL;
        if (before && before->count == tf->count && before->lo == tf->lo && before->hi == tf->hi &&
            memcmp(before->entries, tf->entries, 4 * tf->count * sizeof *tf->entries) == 0)
            continue; /* the same scene from another side */
        iso_brick_cull(&field, tf, p->wanted, p->threads, visible);
        for (size_t i = 0; i < count; ++i)
            t->drawn[i] = t->drawn[i] || visible[i];
    }
    for (size_t i = 0; i < count; ++i) {
        size_t side = iso_brick_side(p->nodes, t->levels[i]);
        t->drawn_count += t->drawn[i];
        t->node_count += t->drawn[i] ? side * side * side : 0;
    }
    return ISO_OK;
}

/* Renders the levels that the plan has, and measures. Once the RMSE of a view is above `limit` the others do not
 * matter. */
static iso_status try_levels(iso_planner *p, double predicted_rmse, double limit, iso_plan_trial *t, iso_error *err)
{
    size_t count = p->plan.brick_count;
    *t = (iso_plan_trial){.predicted_rmse = predicted_rmse};
    t->levels = malloc(count);
    t->drawn = calloc(count, 1);
    iso_status status = t->levels && t->drawn ? ISO_OK
                                              : iso_fail(err, ISO_E_MEMORY, "plan: no memory for %zu bricks", count);
    if (status == ISO_OK) {
        memcpy(t->levels, p->plan.levels, count);
        status = count_drawn(p, t, err);
    }
    for (size_t v = 0; v < p->view_count && status == ISO_OK && t->measured.rmse <= limit; ++v) {
        iso_image image = {0};
        iso_metrics measured;
        status = render_levels(p, t->levels, t->drawn, v, &image, err);
        TRY(status, iso_metrics_measure_differences(&image, &p->full[v], &measured, err));
        if (status == ISO_OK && (v == 0 || measured.rmse > t->measured.rmse))
            t->measured = measured;
        if (v == 0)
            t->image = image;
        else
            iso_image_destroy(&image);
    }
    if (status != ISO_OK)
        drop_trial(t);
    return status;
}

/* Chooses for a predicted error. */
static iso_status try_rmse(iso_planner *p, double rmse, double limit, iso_plan_trial *t, iso_error *err)
{
    return try_levels(p, iso_plan_choose(&p->plan, p->nodes, rmse), limit, t, err);
}

/* Tries level 0 everywhere, without invisible bricks: a coarse brick may make a larger error than predicted. Bricks
 * that no view was found to see may still show a little, through nearly opaque ones or between the sampled rays. If so,
 * they stay, too. */
static iso_status try_finest(iso_planner *p, double error, iso_plan_trial *t, iso_error *err)
{
    memset(p->plan.levels, 0, p->plan.brick_count);
    iso_status status = try_levels(p, 0, INFINITY, t, err);
    if (status == ISO_OK && t->measured.rmse > error) {
        drop_trial(t);
        memset(p->wanted, 1, p->plan.brick_count);
        status = try_levels(p, 0, INFINITY, t, err);
    }
    if (status == ISO_OK && !(t->measured.rmse <= error))
        status = iso_fail(err, ISO_E_RANGE, "the RMSE may be %g, but is %g with all bricks at level 0; allow more",
                          error, t->measured.rmse);
    return status;
}

/* ---- the search ------------------------------------------------------------------ */

/* True if the trial meets the requested error and memory. A model that draws nothing does not count, unless the full
 * one draws nothing either. */
static bool is_good(const iso_planner *p, double error, double memory, const iso_plan_trial *t)
{
    if (memory <= 0)
        return t->measured.rmse <= error;
    return iso_plan_trial_bytes(t) <= memory && (t->drawn_count > 0 || p->blank_rmse == 0);
}

/* Finds the largest predicted error that is still good, by bisection of its logarithm. Measured error and bytes follow
 * the prediction except for small steps, so it keeps the best good trial, not the last one. */
iso_status iso_planner_search(iso_planner *p, double error, double memory, const iso_progress *progress, iso_error *err)
{
    enum { steps = 9 };
    double low = -8, high = 0, least = INFINITY; /* decades; bytes of the visible bricks */
    if (memory <= 0) {                           /* the prediction is about right: start around it */
        low = log10(error) - 2;
        high = log10(error) + 2;
    }
    drop_trial(&p->best);
    for (int i = 0; i < steps; ++i) {
        double middle = 0.5 * (low + high);
        iso_plan_trial t;
        NEED(iso_progress_check(progress, err));
        NEED(try_rmse(p, pow(10, middle), memory > 0 ? INFINITY : error, &t, err));
        bool good = is_good(p, error, memory, &t);
        bool finer = memory > 0 ? iso_plan_trial_bytes(&t) <= memory : !good;
        *(finer ? &high : &low) = middle;
        bool better = !p->best.levels ||
                      (memory > 0 ? t.measured.rmse < p->best.measured.rmse : t.node_count < p->best.node_count);
        least = t.drawn_count > 0 ? fmin(least, iso_plan_trial_bytes(&t)) : least;
        if (good && better) {
            drop_trial(&p->best);
            p->best = t;
        } else {
            drop_trial(&t);
        }
        iso_progress_report(progress, "verify", (double)(i + 1) / steps);
    }
    if (p->best.levels)
        return ISO_OK;
    if (memory > 0)
        return iso_fail(err, ISO_E_RANGE,
                        "the bricks may have %g bytes, but the coarsest plan that shows anything needs %g; allow more "
                        "levels",
                        memory, least);
    return try_finest(p, error, &p->best, err);
}

/* ---- the result ------------------------------------------------------------------ */

json_t *iso_planner_json(const iso_planner *p, double error)
{
    size_t by_level[ISO_BRICK_MAX_LEVELS] = {0};
    const iso_plan_trial *t = &p->best;
    const double full_bytes = ISO_BYTES_A_NODE * (double)p->full_node_count;
    json_t *counts = json_array();
    for (size_t i = 0; i < p->plan.brick_count; ++i)
        by_level[t->levels[i]] += t->drawn[i];
    for (size_t l = 0; l < p->plan.level_count; ++l)
        json_array_append_new(counts, json_integer((json_int_t)by_level[l]));
    json_t *plan = json_pack(
        "{s:s, s:f, s:i, s:f, s:f, s:f, s:f, s:f, s:I, s:I, s:I, s:f, s:f, s:f, s:i, s:o, s:[iii], s:i, s:i}", "schema",
        "isoshade.plan/1", "error", error, "views", (int)p->view_count, "predicted_rmse", t->predicted_rmse,
        "measured_rmse", t->measured.rmse, "measured_max_abs", t->measured.max_abs, "measured_p99_abs",
        t->measured.p99_abs, "blank_rmse", p->blank_rmse, "brick_count", (json_int_t)p->plan.brick_count, "shown_count",
        (json_int_t)t->drawn_count, "voxel_count", (json_int_t)t->node_count, "bytes", iso_plan_trial_bytes(t),
        "full_bytes", full_bytes, "bytes_part", iso_plan_trial_bytes(t) / full_bytes, "renders", p->render_count,
        "bricks_by_level", counts, "bricks", (int)p->nodes->count[0], (int)p->nodes->count[1], (int)p->nodes->count[2],
        "brick_voxels", (int)p->nodes->brick_voxels, "level_count", (int)p->nodes->level_count);
    json_auto_t *bricks = iso_plan_file_bricks(t->levels, t->drawn, p->wanted, p->plan.brick_count);
    const bool complete = plan && bricks && json_object_update(plan, bricks) == 0;
    if (complete)
        return plan;
    json_decref(plan);
    return NULL;
}

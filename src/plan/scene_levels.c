/* SPDX-License-Identifier: MIT */
#include "plan/scene_levels.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "base/provenance.h"
#include "fit/extinction_scale.h"
#include "tf/adapt.h"
#include "tf/level_look.h"

enum { WAYS = ISO_LEVEL_WAY_COUNT };

const iso_level_way iso_level_ways[ISO_LEVEL_WAY_COUNT] = {
    {ISO_LEVEL_AS_BUILT, false}, {ISO_LEVEL_AS_BUILT, true}, {ISO_LEVEL_LEAST_SQUARES, false},
    {ISO_LEVEL_DAMPED, false},   {ISO_LEVEL_DAMPED, true},   {ISO_LEVEL_FITTED, false},
    {ISO_LEVEL_FITTED, true},    {ISO_LEVEL_OPTIMIZED, true}};

int iso_scene_level_choose(const iso_level_candidate c[WAYS])
{
    int best = ISO_LEVEL_WAY_BUILT;
    for (int i = 1; i < ISO_LEVEL_WAY_OPTIMIZED; ++i)
        if (c[i].tried && iso_level_gate_is_better(&c[0].seen, &c[i].seen) &&
            c[i].seen.ssim_dissimilarity < c[best].seen.ssim_dissimilarity)
            best = i;
    return c[ISO_LEVEL_WAY_OPTIMIZED].tried && iso_level_gate_is_nearer(&c[best].seen, &c[ISO_LEVEL_WAY_OPTIMIZED].seen)
               ? ISO_LEVEL_WAY_OPTIMIZED
               : best;
}

/* ---- ways to show a level --------------------------------------------------------------------------------------- */

/* A level as a way shows it. */
typedef struct look {
    iso_level level; /* borrowed */
    iso_tf_table tf;
    uint8_t *scale;
    bool adapted;
} look;

static void forget(look *l)
{
    iso_tf_table_destroy(&l->tf);
    free(l->scale);
    *l = (look){0};
}

static void set_scalar(iso_level *l, float *scalar)
{
    l->scalar = scalar;
    l->min = INFINITY;
    l->max = -INFINITY;
    for (size_t i = 0; i < iso_geometry_voxel_count(&l->geometry); ++i) {
        l->min = fmin(l->min, (double)scalar[i]);
        l->max = fmax(l->max, (double)scalar[i]);
    }
}

/* Makes the transfer function that shows a scalar in place of a level, and its extinction scale. */
static iso_status make_look(const iso_level_gate *gate, size_t level, float *scalar, bool scaled, look *l,
                            iso_error *err)
{
    const iso_tf_table *original = &gate->views[0].tf;
    iso_pyramid with = *gate->p;
    iso_level levels[32];
    iso_adapt_options opt = iso_adapt_defaults();
    iso_adapt_judgment judgment = {0};
    *l = (look){.level = gate->p->levels[level]};
    set_scalar(&l->level, scalar);
    opt.threads = gate->threads;
    opt.fall_back = !scaled;
    memcpy(levels, with.levels, with.level_count * sizeof *levels);
    levels[level] = l->level;
    with.levels = levels;
    with.made_for = NULL;
    iso_status status = iso_adapt_level(&with, level, original, &opt, &l->tf, &judgment, err);
    l->adapted = !judgment.use_original;
    if (status == ISO_OK && scaled)
        status = iso_extinction_scale_level(&with, level, original, &l->tf, gate->threads, &l->scale, err);
    return status;
}

/* Judges all ways but the last; *best gets the look of the nearest one. */
static iso_status judge_all(iso_level_gate *gate, size_t level, float *const scalars[ISO_LEVEL_SCALAR_COUNT],
                            iso_level_candidate candidates[WAYS], look *best, iso_error *err)
{
    iso_status status = ISO_OK;
    for (int i = 0; i < ISO_LEVEL_WAY_OPTIMIZED && status == ISO_OK; ++i) {
        const iso_level_way *way = &iso_level_ways[i];
        look l;
        if (!scalars[way->scalar])
            continue;
        status = make_look(gate, level, scalars[way->scalar], way->scaled, &l, err);
        candidates[i].adapted = l.adapted;
        TRY(status,
            iso_level_gate_look(gate, level, &(iso_shown_level){&l.level, &l.tf, l.scale}, &candidates[i].seen, err));
        candidates[i].tried = status == ISO_OK;
        if (status == ISO_OK && iso_scene_level_choose(candidates) == i) {
            forget(best);
            *best = l;
        } else {
            forget(&l);
        }
    }
    return status;
}

iso_status iso_scene_level_judge(const iso_pyramid *p, size_t level, const iso_scene *scene,
                                 float *const scalars[ISO_LEVEL_SCALAR_COUNT], int threads,
                                 iso_level_candidate candidates[WAYS], iso_error *err)
{
    iso_level_gate gate;
    look best = {0};
    memset(candidates, 0, WAYS * sizeof *candidates);
    iso_status status = iso_level_gate_open(&gate, p, scene, threads, err);
    TRY(status, judge_all(&gate, level, scalars, candidates, &best, err));
    forget(&best);
    iso_level_gate_close(&gate);
    return status;
}

/* ---- making ------------------------------------------------------------------------------------------------------ */

/* Makes the scalars of each kind that the pyramid does not have already. */
static iso_status make_scalars(const iso_level_gate *gate, size_t level, float *scalars[ISO_LEVEL_SCALAR_COUNT],
                               iso_fit_report *fit, iso_error *err)
{
    const iso_pyramid *p = gate->p;
    const size_t bytes = iso_geometry_voxel_count(&p->levels[level].geometry) * sizeof(float);
    const iso_level_scalar_input in = {&p->levels[0], &gate->views[0].tf, level, gate->threads};
    const iso_scalar_filter built = p->options.scalar_filter;
    bool complete = true;
    for (int i = ISO_LEVEL_LEAST_SQUARES; i <= ISO_LEVEL_FITTED; ++i)
        if (i != ISO_LEVEL_FITTED || level >= ISO_SCENE_FITTED_FROM)
            complete = (scalars[i] = malloc(bytes)) && complete;
    if (!complete)
        return iso_fail(err, ISO_E_MEMORY, "no memory for level %zu", level);
    NEED(iso_level_scalars_make(&in, scalars[ISO_LEVEL_LEAST_SQUARES], scalars[ISO_LEVEL_FITTED], fit, err));
    memcpy(scalars[ISO_LEVEL_DAMPED], scalars[ISO_LEVEL_LEAST_SQUARES], bytes);
    iso_level_scalar_damp(&in, scalars[ISO_LEVEL_DAMPED]);
    const int same = built == ISO_SCALAR_LEAST_SQUARES ? ISO_LEVEL_LEAST_SQUARES
                     : built == ISO_SCALAR_DAMPED      ? ISO_LEVEL_DAMPED
                                                       : 0;
    if (same) {
        free(scalars[same]);
        scalars[same] = NULL;
    }
    return ISO_OK;
}

/* Judges all ways but the last, and lets the level have the scalar and the scale of the nearest. */
static iso_status make_level(iso_pyramid *p, size_t level, iso_level_gate *gate, iso_scene_level *made, look *best,
                             iso_error *err)
{
    iso_level *l = &p->levels[level];
    float *scalars[ISO_LEVEL_SCALAR_COUNT] = {l->scalar};
    *made = (iso_scene_level){0};
    iso_status status = make_scalars(gate, level, scalars, &made->fit, err);
    TRY(status, judge_all(gate, level, scalars, made->candidates, best, err));
    made->chosen = status == ISO_OK ? iso_scene_level_choose(made->candidates) : ISO_LEVEL_WAY_BUILT;
    const iso_level_scalar kind = iso_level_ways[made->chosen].scalar;
    if (kind != ISO_LEVEL_AS_BUILT) {
        set_scalar(l, scalars[kind]);
        l->made_for_scene = true;
        scalars[kind] = NULL;
    } else {
        scalars[ISO_LEVEL_AS_BUILT] = NULL; /* the level keeps it */
    }
    l->scale = best->scale;
    for (int i = 0; i < ISO_LEVEL_SCALAR_COUNT; ++i)
        free(scalars[i]);
    return status;
}

/* Replaces a level's arrays by those of the optimized one. */
static void take(iso_level *l, iso_optimized *o, look *best)
{
    free(l->scalar);
    free(l->codes);
    free(l->scale);
    l->codes = o->codes;
    l->scale = best->scale = o->scale;
    if (l->directions) {
        free(l->directions);
        l->directions = o->directions;
        o->directions = NULL;
    }
    l->made_for_scene = l->is_optimized = true;
    set_scalar(l, o->scalar);
    iso_tf_table_destroy(&best->tf);
    best->tf = o->tf;
    o->scalar = NULL;
    o->codes = o->scale = NULL;
    o->tf = (iso_tf_table){0};
}

/* Compares the optimized level with the best other one; takes it if it is nearer. */
static iso_status compare(iso_pyramid *p, size_t level, iso_level_gate *gate, iso_optimized *o, iso_scene_level *made,
                          look *best, iso_error *err)
{
    iso_level_candidate *c = &made->candidates[ISO_LEVEL_WAY_OPTIMIZED];
    iso_level shown = p->levels[level];
    set_scalar(&shown, o->scalar);
    shown.codes = o->codes;
    const iso_status status = iso_level_gate_look(gate, level, &(iso_shown_level){&shown, &o->tf, o->scale}, &c->seen,
                                                  err);
    c->tried = c->adapted = status == ISO_OK;
    if (status == ISO_OK && iso_scene_level_choose(made->candidates) == ISO_LEVEL_WAY_OPTIMIZED) {
        take(&p->levels[level], o, best);
        made->chosen = ISO_LEVEL_WAY_OPTIMIZED;
    }
    return status;
}

/* Tries long steps, and if the level is not nearer, short ones: noise asks for them. */
static iso_status optimize_level(iso_pyramid *p, size_t level, const iso_scene *scene, iso_level_gate *gate,
                                 const iso_optimize_options *opt, iso_scene_level *made, look *best,
                                 const iso_progress *progress, iso_error *err)
{
    static const double rates[] = ISO_OPTIMIZE_RATES;
    iso_optimize_options own = *opt;
    iso_status status = ISO_OK;
    own.seed += level;
    own.threads = gate->threads;
    for (size_t i = 0; i < sizeof rates / sizeof *rates && status == ISO_OK; ++i) {
        const iso_shown_level start = {&p->levels[level], &best->tf, best->scale};
        iso_optimized o;
        own.rate = rates[i];
        status = iso_optimize_level(p, level, scene, &start, &own, &o, progress, err);
        if (status == ISO_E_RANGE) /* it shows nothing, or its code is not linear: the other candidates stay */
            return ISO_OK;
        made->optimized = (struct iso_scene_level_optimized){true,     o.views,       o.pixels, o.steps,
                                                             rates[i], o.error_first, o.error};
        TRY(status, compare(p, level, gate, &o, made, best, err));
        iso_optimized_destroy(&o);
        if (made->chosen == ISO_LEVEL_WAY_OPTIMIZED || (opt->stop && *opt->stop))
            break;
    }
    return status;
}

static json_t *candidates_to_json(const iso_level_candidate candidates[WAYS])
{
    json_t *list = json_array();
    for (int i = 0; i < WAYS; ++i) {
        const iso_level_candidate *c = &candidates[i];
        if (c->tried)
            json_array_append_new(list, json_pack("{s:s, s:b, s:b, s:f, s:f, s:f, s:f}", "scalar",
                                                  iso_level_scalar_name(iso_level_ways[i].scalar), "adapted_tf",
                                                  c->adapted, "scaled", iso_level_ways[i].scaled, "ssim_dissimilarity",
                                                  c->seen.ssim_dissimilarity, "rmse", c->seen.rmse,
                                                  "minified_ssim_dissimilarity", c->seen.small_ssim_dissimilarity,
                                                  "minified_rmse", c->seen.small_rmse));
    }
    return list;
}

/* Describes a level: how it is shown, and how it was made and judged. */
static json_t *level_to_json(const iso_scene_level *made, size_t level, const look *best, uint64_t seed)
{
    json_t *o = json_pack("{s:I, s:s, s:o}", "level", (json_int_t)level, "scalar",
                          iso_level_scalar_name(iso_level_ways[made->chosen].scalar), "candidates",
                          candidates_to_json(made->candidates));
    if (made->candidates[made->chosen].adapted)
        json_object_set_new(o, "tf", iso_level_look_to_json(&best->tf));
    if (made->optimized.tried)
        json_object_set_new(o, "optimized",
                            json_pack("{s:I, s:I, s:I, s:I, s:f, s:f, s:f}", "seed", (json_int_t)seed, "views",
                                      (json_int_t)made->optimized.views, "pixels", (json_int_t)made->optimized.pixels,
                                      "steps", (json_int_t)made->optimized.steps, "rate", made->optimized.rate,
                                      "error_first", made->optimized.error_first, "error", made->optimized.error));
    return o;
}

/* Makes a level and appends its description. */
static iso_status make_and_describe(iso_pyramid *p, size_t level, const iso_scene *scene, iso_level_gate *gate,
                                    const iso_optimize_options *optimize, iso_scene_level *made, json_t *list,
                                    const iso_progress *progress, iso_error *err)
{
    const double began = iso_clock_seconds();
    look best = {0};
    iso_status status = make_level(p, level, gate, made, &best, err);
    if (status == ISO_OK && optimize && optimize->effort != ISO_EFFORT_NONE && !(optimize->stop && *optimize->stop))
        status = optimize_level(p, level, scene, gate, optimize, made, &best, progress, err);
    if (status == ISO_OK)
        json_array_append_new(list, level_to_json(made, level, &best, optimize ? optimize->seed + level : 0));
    best.scale = NULL; /* the level's */
    forget(&best);
    made->seconds = iso_clock_seconds() - began;
    return status;
}

iso_status iso_scene_levels_make(iso_pyramid *p, size_t first, const iso_scene *scene,
                                 const iso_optimize_options *optimize, int threads, iso_scene_level *levels,
                                 const iso_progress *progress, iso_error *err)
{
    iso_scene_level own[32];
    iso_level_gate gate;
    if (p->levels[0].geometry.has_no_data)
        return iso_fail(err, ISO_E_RANGE,
                        "some voxels have no data: levels cannot be made for a scene; leave out --for");
    json_t *list = json_array();
    levels = levels ? levels : own;
    iso_status status = iso_level_gate_open(&gate, p, scene, threads, err);
    for (size_t k = first; k < p->level_count && status == ISO_OK; ++k) {
        iso_progress_report(progress, "levels for the scene", (double)(k - first) / (double)(p->level_count - first));
        status = make_and_describe(p, k, scene, &gate, optimize, &levels[k], list, progress, err);
    }
    iso_progress_report(progress, "levels for the scene", 1);
    iso_level_gate_close(&gate);
    if (status == ISO_OK) {
        json_decref(p->made_for);
        p->made_for = json_pack("{s:s, s:O, s:o}", "scene", scene->path ? iso_provenance_name(scene->path) : "first",
                                "levels", list, "tf", iso_tf_to_json(&scene->tf));
        status = p->made_for ? ISO_OK
                             : iso_fail(err, ISO_E_MEMORY, "no memory for the description of the levels' scene");
    }
    json_decref(list);
    return status;
}

size_t iso_scene_levels_bytes(const iso_geometry *level0, iso_type type, iso_effort effort)
{
    const size_t fine = iso_geometry_voxel_count(level0), pyramid = 7 * fine + fine; /* floats, codes; coarse levels */
    const size_t drawing = 12 * fine;                                                /* lattice directions of level 0 */
    const size_t fit = iso_level_scalar_bytes(level0->size),
                 optimize = iso_optimize_bytes(level0->size, effort) + drawing;
    const size_t both = drawing > fit ? drawing : fit;
    return iso_type_bytes(type) * fine + pyramid + (both > optimize ? both : optimize);
}

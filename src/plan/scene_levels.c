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
    return best;
}

double iso_scene_level_ratio(const iso_scene_level *made, size_t scene)
{
    const double best = made->best[scene].ssim_dissimilarity;
    return best > 0 ? made->candidates[scene][made->chosen].seen.ssim_dissimilarity / best : 1;
}

bool iso_scene_level_stands_edits(const iso_scene_level *made, size_t scene_count)
{
    bool good = true;
    for (size_t i = 0; i < scene_count; ++i)
        for (int k = 0; k < ISO_LEVEL_GATE_EDITS; ++k)
            good = good &&
                   iso_level_gate_stands(made->edited_built[i][k], made->edited[i][k], made->edited_rounding[i][k]);
    return good;
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
    NEED(iso_adapt_level(&with, level, original, &opt, &l->tf, &judgment, err));
    l->adapted = !judgment.use_original;
    return scaled ? iso_extinction_scale_level(&with, level, original, &l->tf, gate->threads, &l->scale, err) : ISO_OK;
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
    NEED_MEMORY(complete, err, "no memory for level %zu", level);
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

/* Frees all but the level's own. */
static void free_scalars(float *scalars[ISO_LEVEL_SCALAR_COUNT])
{
    for (int i = ISO_LEVEL_AS_BUILT + 1; i < ISO_LEVEL_SCALAR_COUNT; ++i) {
        free(scalars[i]);
        scalars[i] = NULL;
    }
}

/* A level in all scenes. */
typedef struct making {
    iso_pyramid *p;
    size_t level, scene_count;
    const iso_scene *scenes;
    iso_level_gate *gates;                         /* of each scene */
    iso_level_gate (*edits)[ISO_LEVEL_GATE_EDITS]; /* or NULL: nothing is optimized */
    look best[ISO_SCENES_MOST];
    iso_scene_level *made;
} making;

static void forget_all(const making *m, look *looks)
{
    for (size_t i = 0; i < m->scene_count; ++i)
        forget(&looks[i]);
}

/* Gives all looks the mean of their scales. */
static void share_scale(const making *m, look *looks)
{
    for (size_t v = 0; v < iso_geometry_voxel_count(&looks->level.geometry); ++v) {
        size_t sum = 0;
        for (size_t i = 0; i < m->scene_count; ++i)
            sum += looks[i].scale[v];
        for (size_t i = 0; i < m->scene_count; ++i)
            looks[i].scale[v] = iso_extinction_scale_mean(sum, m->scene_count);
    }
}

/* Judges a way in all scenes. */
static iso_status judge_shared(const making *m, int way, float *scalar, look *looks, iso_error *err)
{
    for (size_t i = 0; i < m->scene_count; ++i)
        NEED(make_look(&m->gates[i], m->level, scalar, iso_level_ways[way].scaled, &looks[i], err));
    if (iso_level_ways[way].scaled)
        share_scale(m, looks);
    for (size_t i = 0; i < m->scene_count; ++i) {
        m->made->candidates[i][way].adapted = looks[i].adapted;
        NEED(iso_level_gate_look(&m->gates[i], m->level,
                                 &(iso_shown_level){&looks[i].level, &looks[i].tf, looks[i].scale},
                                 &m->made->candidates[i][way].seen, err));
    }
    return ISO_OK;
}

/* Chooses the way that several scenes can share. A fitted level is of one scene. */
static iso_status choose_shared(making *m, float *const scalars[ISO_LEVEL_SCALAR_COUNT], iso_error *err)
{
    iso_status status = ISO_OK;
    int chosen = ISO_LEVEL_WAY_BUILT;
    double least = INFINITY;
    for (int way = 0; way < ISO_LEVEL_WAY_OPTIMIZED && status == ISO_OK; ++way) {
        const iso_level_scalar kind = iso_level_ways[way].scalar;
        look looks[ISO_SCENES_MOST] = {{.scale = NULL}};
        double worst = 0;
        if (kind == ISO_LEVEL_FITTED || !scalars[kind])
            continue;
        status = judge_shared(m, way, scalars[kind], looks, err);
        m->made->chosen = way;
        for (size_t i = 0; i < m->scene_count; ++i)
            worst = fmax(worst, iso_scene_level_ratio(m->made, i));
        if (status == ISO_OK && worst < least) {
            least = worst;
            chosen = way;
            forget_all(m, m->best);
            memcpy(m->best, looks, sizeof looks);
        } else {
            forget_all(m, looks);
        }
    }
    m->made->chosen = chosen;
    return status;
}

/* Shows a level after each edit as commands do with --adapt. scaled: adapted and with a new extinction scale; else
 * adapted if that is nearer, or as it is, with `scale`. */
static iso_status judge_edits(const making *m, const uint8_t *codes, float *scalar, const uint8_t *scale, bool scaled,
                              double edited[][ISO_LEVEL_GATE_EDITS], iso_error *err)
{
    iso_status status = ISO_OK;
    for (size_t i = 0; i < ISO_LEVEL_GATE_EDITS * m->scene_count && status == ISO_OK; ++i) {
        iso_level_gate *gate = &m->edits[i / ISO_LEVEL_GATE_EDITS][i % ISO_LEVEL_GATE_EDITS];
        look l = {.scale = NULL};
        iso_level_seen seen = {{0}, 0, 0, 0, 0};
        if (gate->view_count == 0)
            continue;
        status = make_look(gate, m->level, scalar, scaled, &l, err);
        l.level.codes = (uint8_t *)(uintptr_t)codes; /* borrowed */
        const iso_shown_level shown = {&l.level, &l.tf, l.adapted ? l.scale : scale};
        TRY(status, iso_level_gate_look(gate, m->level, &shown, &seen, err));
        edited[i / ISO_LEVEL_GATE_EDITS][i % ISO_LEVEL_GATE_EDITS] = seen.ssim_dissimilarity;
        m->made->edited_rounding[i / ISO_LEVEL_GATE_EDITS][i % ISO_LEVEL_GATE_EDITS] = gate->rounding;
        forget(&l);
    }
    return status;
}

/* Judges all ways but the last, and lets the level have the scalar and the scale of the nearest. */
static iso_status make_level(making *m, iso_error *err)
{
    iso_level *l = &m->p->levels[m->level];
    iso_scene_level *made = m->made;
    float *scalars[ISO_LEVEL_SCALAR_COUNT] = {l->scalar};
    iso_status status = ISO_OK;
    *made = (iso_scene_level){0};
    for (size_t i = 0; i < m->scene_count; ++i) {
        free_scalars(scalars);
        TRY(status, make_scalars(&m->gates[i], m->level, scalars, &made->fit, err));
        TRY(status, judge_all(&m->gates[i], m->level, scalars, made->candidates[i], &m->best[i], err));
        made->chosen = status == ISO_OK ? iso_scene_level_choose(made->candidates[i]) : ISO_LEVEL_WAY_BUILT;
        made->best[i] = made->candidates[i][made->chosen].seen;
    }
    if (m->edits)
        TRY(status, judge_edits(m, l->codes, l->scalar, NULL, false, made->edited_built, err));
    if (status == ISO_OK && m->scene_count > 1)
        status = choose_shared(m, scalars, err);
    const iso_level_scalar kind = iso_level_ways[made->chosen].scalar;
    if (kind != ISO_LEVEL_AS_BUILT) {
        free(l->scalar);
        set_scalar(l, scalars[kind]);
        l->made_for_scene = true;
        scalars[kind] = NULL;
    }
    free_scalars(scalars);
    l->scale = m->best->scale;
    return status;
}

/* Replaces a level's arrays by those of the optimized one. */
static void take(making *m, iso_optimized *o)
{
    iso_level *l = &m->p->levels[m->level];
    free(l->scalar);
    free(l->codes);
    free(l->scale);
    l->codes = o->codes;
    l->scale = m->best->scale = o->scale;
    if (l->directions) {
        free(l->directions);
        l->directions = o->directions;
        o->directions = NULL;
    }
    l->made_for_scene = l->is_optimized = true;
    l->edits_are_scaled = m->made->edits_are_scaled;
    set_scalar(l, o->scalar);
    for (size_t i = 0; i < m->scene_count; ++i) {
        iso_tf_table_destroy(&m->best[i].tf);
        m->best[i].tf = o->tfs[i];
        o->tfs[i] = (iso_tf_table){0};
    }
    o->scalar = NULL;
    o->codes = o->scale = NULL;
}

/* Compares the optimized level in each scene with the best other one for it; takes it if it is nearer. */
static iso_status compare(making *m, iso_optimized *o, iso_error *err)
{
    iso_level shown = m->p->levels[m->level];
    iso_level_seen seen[ISO_SCENES_MOST];
    iso_status status = ISO_OK;
    set_scalar(&shown, o->scalar);
    shown.codes = o->codes;
    for (size_t i = 0; i < m->scene_count; ++i) {
        TRY(status, iso_level_gate_look(&m->gates[i], m->level, &(iso_shown_level){&shown, &o->tfs[i], o->scale},
                                        &seen[i], err));
        if (status == ISO_OK)
            m->made->candidates[i][ISO_LEVEL_WAY_OPTIMIZED] = (iso_level_candidate){true, true, seen[i]};
    }
    if (status != ISO_OK || !iso_level_gate_is_nearer(m->made->best, seen, m->scene_count))
        return status;
    bool stands = false;
    for (int i = 0; i < 2 && status == ISO_OK && !stands; ++i) {
        m->made->edits_are_scaled = i == 0; /* the nearer way with most volumes, but not with soft surfaces */
        status = judge_edits(m, o->codes, o->scalar, o->scale, i == 0, m->made->edited, err);
        m->made->judged_edits = status == ISO_OK;
        stands = m->made->judged_edits && iso_scene_level_stands_edits(m->made, m->scene_count);
    }
    if (stands) {
        take(m, o);
        m->made->chosen = ISO_LEVEL_WAY_OPTIMIZED;
    }
    return status;
}

/* Tries long steps, and if the level is not nearer, short ones: noise asks for them. */
static iso_status optimize_level(making *m, const iso_optimize_options *opt, const iso_progress *progress,
                                 iso_error *err)
{
    static const double rates[] = ISO_OPTIMIZE_RATES;
    iso_optimize_options own = *opt;
    iso_status status = ISO_OK;
    own.seed += m->level;
    own.threads = m->gates->threads;
    own.scene_count = m->scene_count;
    for (size_t i = 0; i < sizeof rates / sizeof *rates && status == ISO_OK; ++i) {
        iso_shown_level starts[ISO_SCENES_MOST];
        iso_optimized o;
        for (size_t k = 0; k < m->scene_count; ++k)
            starts[k] = (iso_shown_level){&m->p->levels[m->level], &m->best[k].tf, m->best->scale};
        own.rate = rates[i];
        status = iso_optimize_level(m->p, m->level, m->scenes, starts, &own, &o, progress, err);
        if (status == ISO_E_RANGE) /* it shows nothing, or its code is not linear: the other candidates stay */
            return ISO_OK;
        m->made->optimized = (struct iso_scene_level_optimized){true,     o.views,       o.pixels, o.steps,
                                                                rates[i], o.error_first, o.error};
        TRY(status, compare(m, &o, err));
        iso_optimized_destroy(&o);
        if (m->made->chosen == ISO_LEVEL_WAY_OPTIMIZED || (opt->stop && *opt->stop))
            break;
    }
    return status;
}

/* Returns the list of what is of further scenes. */
static json_t *others_of(json_t *object)
{
    json_t *list = json_object_get(object, "others");
    if (!list) {
        list = json_array();
        json_object_set_new(object, "others", list);
    }
    return list;
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

/* Adds a level's own transfer function in a scene, and its figures. */
static void add_scene(json_t *o, const making *m, size_t scene)
{
    const iso_level_candidate *c = m->made->candidates[scene];
    json_object_set_new(o, "candidates", candidates_to_json(c));
    json_object_set_new(o, "ratio", json_real(iso_scene_level_ratio(m->made, scene)));
    if (c[m->made->chosen].adapted)
        json_object_set_new(o, "tf", iso_level_look_to_json(&m->best[scene].tf));
    if (!m->made->judged_edits)
        return;
    double ratios[ISO_LEVEL_GATE_EDITS];
    for (int k = 0; k < ISO_LEVEL_GATE_EDITS; ++k) {
        const double built = m->made->edited_built[scene][k];
        ratios[k] = built > 0 ? m->made->edited[scene][k] / built : 1;
    }
    json_object_set_new(o, "edit_ratios", iso_json_numbers(ratios, ISO_LEVEL_GATE_EDITS));
}

/* Describes a level: how it is shown, and how it was made and judged. */
static json_t *level_to_json(const making *m, uint64_t seed)
{
    const iso_scene_level *made = m->made;
    json_t *o = json_pack("{s:I, s:s}", "level", (json_int_t)m->level, "scalar",
                          iso_level_scalar_name(iso_level_ways[made->chosen].scalar));
    add_scene(o, m, 0);
    for (size_t i = 1; i < m->scene_count; ++i) {
        json_t *other = json_object();
        add_scene(other, m, i);
        json_array_append_new(others_of(o), other);
    }
    if (made->chosen == ISO_LEVEL_WAY_OPTIMIZED)
        json_object_set_new(o, "edits_are_scaled", json_boolean(made->edits_are_scaled));
    if (made->optimized.tried)
        json_object_set_new(o, "optimized",
                            json_pack("{s:I, s:I, s:I, s:I, s:f, s:f, s:f}", "seed", (json_int_t)seed, "views",
                                      (json_int_t)made->optimized.views, "pixels", (json_int_t)made->optimized.pixels,
                                      "steps", (json_int_t)made->optimized.steps, "rate", made->optimized.rate,
                                      "error_first", made->optimized.error_first, "error", made->optimized.error));
    if (made->optimized.tried && iso_provenance_kept() != ISO_PROVENANCE_NONE) /* so that equal builds can be equal */
        json_object_set_new(json_object_get(o, "optimized"), "seconds", json_real(made->seconds));
    return o;
}

/* Makes a level and appends its description. */
static iso_status make_and_describe(making *m, const iso_optimize_options *optimize, json_t *list,
                                    const iso_progress *progress, iso_error *err)
{
    const double began = iso_clock_seconds();
    iso_status status = make_level(m, err);
    if (status == ISO_OK && m->edits && !(optimize->stop && *optimize->stop))
        status = optimize_level(m, optimize, progress, err);
    m->made->seconds = iso_clock_seconds() - began;
    if (status == ISO_OK)
        json_array_append_new(list, level_to_json(m, optimize ? optimize->seed + m->level : 0));
    m->best->scale = NULL; /* the level's */
    forget_all(m, m->best);
    return status;
}

/* Describes the scenes and the levels that were made for them; takes the list of levels. */
static json_t *describe(const iso_scene *scenes, size_t scene_count, json_t *list)
{
    json_t *o = NULL;
    for (size_t i = 0; i < scene_count; ++i) {
        const char *name = scenes[i].path ? iso_provenance_name(scenes[i].path) : "first";
        json_t *scene = json_pack("{s:s, s:o}", "scene", name, "tf", iso_tf_to_json(&scenes[i].tf));
        if (i == 0)
            o = scene;
        else
            json_array_append_new(others_of(o), scene);
    }
    if (json_object_set_new(o, "levels", list) == 0)
        return o;
    json_decref(o);
    return NULL;
}

/* Opens the gates. A level tells scenes by their transfer functions. */
static iso_status open_gates(iso_level_gate *gates, const iso_pyramid *p, const iso_scene *scenes, size_t count,
                             int threads, iso_error *err)
{
    for (size_t i = 0; i < count; ++i) {
        NEED(iso_level_gate_open(&gates[i], p, &scenes[i], threads, err));
        for (size_t k = 0; k < i; ++k)
            if (iso_tf_table_equals(&gates[k].views->tf, &gates[i].views->tf))
                return iso_fail(err, ISO_E_USAGE,
                                "scenes %zu and %zu of --for have the same transfer function: name one of them", k + 1,
                                i + 1);
    }
    return ISO_OK;
}

iso_status iso_scene_levels_make(iso_pyramid *p, size_t first, const iso_scene *scenes, size_t scene_count,
                                 const iso_optimize_options *optimize, int threads, iso_scene_level *levels,
                                 const iso_progress *progress, iso_error *err)
{
    iso_scene_level own[32];
    iso_level_gate gates[ISO_SCENES_MOST] = {{.p = NULL}},
                   edits[ISO_SCENES_MOST][ISO_LEVEL_GATE_EDITS] = {{{.p = NULL}}};
    const bool optimizes = optimize && optimize->effort != ISO_EFFORT_NONE;
    if (p->levels[0].geometry.has_no_data)
        return iso_fail(err, ISO_E_RANGE,
                        "some voxels have no data: levels cannot be made for a scene; leave out --for");
    json_t *list = json_array();
    levels = levels ? levels : own;
    iso_status status = open_gates(gates, p, scenes, scene_count, threads, err);
    for (size_t i = 0; i < scene_count && optimizes; ++i)
        TRY(status, iso_level_gate_open_edits(edits[i], p, &scenes[i], threads, err));
    for (size_t k = first; k < p->level_count && status == ISO_OK; ++k) {
        making m = {p, k, scene_count, scenes, gates, optimizes ? edits : NULL, {{.scale = NULL}}, &levels[k]};
        iso_progress_report(progress, "levels for the scene", (double)(k - first) / (double)(p->level_count - first));
        status = make_and_describe(&m, optimize, list, progress, err);
    }
    iso_progress_report(progress, "levels for the scene", 1);
    for (size_t i = 0; i < scene_count; ++i)
        iso_level_gate_close(&gates[i]);
    for (size_t i = 0; i < ISO_LEVEL_GATE_EDITS * scene_count; ++i)
        iso_level_gate_close(&edits[i / ISO_LEVEL_GATE_EDITS][i % ISO_LEVEL_GATE_EDITS]);
    if (status == ISO_OK) {
        json_decref(p->made_for);
        p->made_for = describe(scenes, scene_count, list);
        return p->made_for ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "no memory for the description of the levels' scene");
    }
    json_decref(list);
    return status;
}

size_t iso_scene_levels_bytes(const iso_geometry *level0, iso_type type, size_t scene_count, iso_effort effort)
{
    const size_t fine = iso_geometry_voxel_count(level0), pyramid = 7 * fine + fine; /* floats, codes; coarse levels */
    const size_t drawing = 12 * fine;                                                /* lattice directions of level 0 */
    const size_t fit = iso_level_scalar_bytes(level0->size), optimize = iso_optimize_bytes(level0, effort) + drawing,
                 gates = scene_count * iso_level_gate_bytes(level0, effort != ISO_EFFORT_NONE);
    const size_t both = drawing > fit ? drawing : fit;
    return iso_type_bytes(type) * fine + pyramid + gates + (both > optimize ? both : optimize);
}

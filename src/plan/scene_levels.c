/* SPDX-License-Identifier: MIT */
#include "plan/scene_levels.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "base/provenance.h"
#include "compare/metrics.h"
#include "compare/ssim.h"
#include "render/reference.h"
#include "scene/views.h"
#include "tf/adapt.h"

enum { VIEWS = ISO_SMALL_VIEWS_COUNT, PIXELS = ISO_SCENE_LEVELS_PIXELS };

iso_level_scalar iso_scene_level_choose(const iso_level_candidate c[ISO_LEVEL_SCALAR_COUNT])
{
    iso_level_scalar best = ISO_LEVEL_AS_BUILT;
    for (int i = 1; i < ISO_LEVEL_SCALAR_COUNT; ++i) {
        double worst = -INFINITY; /* a candidate is compared with the built level, and with the best so far */
        for (int v = 0; v < VIEWS; ++v)
            worst = fmax(worst, c[i].of_view[v] - c[0].of_view[v]);
        const bool nearer = c[i].ssim_dissimilarity < (1 - ISO_SCENE_LEVELS_GAIN) * c[best].ssim_dissimilarity;
        if (c[i].tried && nearer && worst <= ISO_ADAPT_WORST_VIEW && c[i].rmse <= (1 + ISO_SCENE_RMSE_LOSS) * c[0].rmse)
            best = (iso_level_scalar)i;
    }
    return best;
}

/* ---- looking ----------------------------------------------------------------------------------------------------- */

/* Views of a scene along the lines of small views, and what level 0 shows in them. */
typedef struct looks {
    iso_view views[VIEWS];
    iso_image finest[VIEWS];
} looks;

static iso_status draw(const iso_pyramid *p, const iso_level *level, iso_view *view, const iso_tf_table *tf,
                       int threads, iso_image *image, iso_error *err)
{
    iso_reference_options opt = iso_reference_defaults();
    const iso_tf_table own = view->tf;
    opt.quadrature = ISO_QUADRATURE_MIDPOINT;
    opt.threads = threads;
    view->tf = *tf;
    const iso_status status = iso_reference_render(level, p->options.code, view, &opt, image, NULL, err);
    view->tf = own;
    return status;
}

static void forget(looks *l)
{
    for (int i = 0; i < VIEWS; ++i) {
        iso_view_destroy(&l->views[i]);
        iso_image_destroy(&l->finest[i]);
    }
}

static iso_status look(const iso_pyramid *p, const iso_scene *scene, int threads, looks *l, iso_error *err)
{
    const iso_level *level0 = &p->levels[0];
    iso_status status = ISO_OK;
    *l = (looks){0};
    for (int i = 0; i < VIEWS && status == ISO_OK; ++i) {
        iso_scene s = *scene; /* copies pointers, whose targets stay the scene's */
        s.width = s.height = PIXELS;
        s.camera_fit = s.orthographic = true;
        s.camera_direction = iso_small_views_direction(i);
        s.camera_up = iso_view_up(s.camera_direction);
        s.margin = 1;
        status = iso_scene_resolve(&s, &level0->geometry, iso_pyramid_lo(p), iso_pyramid_hi(p), &l->views[i], err);
        TRY(status, draw(p, level0, &l->views[i], &l->views[i].tf, threads, &l->finest[i], err));
    }
    return status;
}

/* Makes the transfer function that shows `shown` in place of a level. */
static iso_status adapt(const iso_pyramid *p, size_t level, const iso_level *shown, looks *l, int threads,
                        iso_tf_table *tf, bool *adapted, iso_error *err)
{
    iso_pyramid with = *p;
    iso_level levels[32];
    iso_adapt_options opt = iso_adapt_defaults();
    iso_adapt_judgment judgment;
    opt.threads = threads;
    memcpy(levels, p->levels, p->level_count * sizeof *levels);
    levels[level] = *shown;
    with.levels = levels;
    const iso_status status = iso_adapt_level(&with, level, &l->views[0].tf, &opt, tf, &judgment, err);
    *adapted = !judgment.use_original;
    return status;
}

/* Judges a candidate, which is shown in place of the level. */
static iso_status judge(const iso_pyramid *p, size_t level, looks *l, const iso_level *shown, int threads,
                        iso_level_candidate *c, iso_error *err)
{
    iso_tf_table tf = {0};
    *c = (iso_level_candidate){.tried = true};
    iso_status status = adapt(p, level, shown, l, threads, &tf, &c->adapted, err);
    for (int i = 0; i < VIEWS && status == ISO_OK; ++i) {
        iso_image image = {0};
        iso_metrics m;
        double ssim = 1;
        status = draw(p, shown, &l->views[i], &tf, threads, &image, err);
        TRY(status, iso_ssim_foreground(&l->finest[i], &image, &ssim, err));
        TRY(status, iso_metrics_measure(&l->finest[i], &image, &m, err));
        c->of_view[i] = 1 - ssim;
        c->ssim_dissimilarity += (1 - ssim) / VIEWS;
        c->rmse += status == ISO_OK ? m.rmse / VIEWS : 0;
        iso_image_destroy(&image);
    }
    iso_tf_table_destroy(&tf);
    return status;
}

static iso_status judge_all(const iso_pyramid *p, size_t level, looks *l, float *const scalars[ISO_LEVEL_SCALAR_COUNT],
                            int threads, iso_level_candidate candidates[ISO_LEVEL_SCALAR_COUNT], iso_error *err)
{
    iso_status status = ISO_OK;
    iso_level shown = p->levels[level];
    for (int i = 0; i < ISO_LEVEL_SCALAR_COUNT && status == ISO_OK; ++i)
        if ((shown.scalar = scalars[i]))
            status = judge(p, level, l, &shown, threads, &candidates[i], err);
    return status;
}

iso_status iso_scene_level_judge(const iso_pyramid *p, size_t level, const iso_scene *scene,
                                 float *const scalars[ISO_LEVEL_SCALAR_COUNT], int threads,
                                 iso_level_candidate candidates[ISO_LEVEL_SCALAR_COUNT], iso_error *err)
{
    looks l;
    memset(candidates, 0, ISO_LEVEL_SCALAR_COUNT * sizeof *candidates);
    iso_status status = look(p, scene, threads, &l, err);
    TRY(status, judge_all(p, level, &l, scalars, threads, candidates, err));
    forget(&l);
    return status;
}

/* ---- making ------------------------------------------------------------------------------------------------------ */

static void set_scalar(iso_level *l, float *scalar)
{
    l->scalar = scalar;
    l->made_for_scene = true;
    l->min = INFINITY;
    l->max = -INFINITY;
    for (size_t i = 0; i < iso_geometry_voxel_count(&l->geometry); ++i) {
        l->min = fmin(l->min, (double)scalar[i]);
        l->max = fmax(l->max, (double)scalar[i]);
    }
}

static iso_status make_level(iso_pyramid *p, size_t level, looks *l, int threads, iso_scene_level *made, iso_error *err)
{
    const size_t bytes = iso_geometry_voxel_count(&p->levels[level].geometry) * sizeof(float);
    const bool fits = level >= ISO_SCENE_FITTED_FROM;
    const bool built = p->options.scalar_filter == ISO_SCALAR_LEAST_SQUARES;
    float *scalars[ISO_LEVEL_SCALAR_COUNT] = {p->levels[level].scalar, malloc(bytes), fits ? malloc(bytes) : NULL};
    iso_status status = scalars[1] && (scalars[2] || !fits)
                            ? ISO_OK
                            : iso_fail(err, ISO_E_MEMORY, "no memory for level %zu", level);
    *made = (iso_scene_level){0};
    if (status == ISO_OK)
        status = iso_level_scalars_make(&(iso_level_scalar_input){&p->levels[0], &l->views[0].tf, level, threads},
                                        scalars[ISO_LEVEL_LEAST_SQUARES], scalars[ISO_LEVEL_FITTED], &made->fit, err);
    if (status == ISO_OK)
        status = judge_all(p, level, l,
                           (float *[ISO_LEVEL_SCALAR_COUNT]){scalars[0],
                                                             built ? NULL : scalars[ISO_LEVEL_LEAST_SQUARES],
                                                             scalars[2]},
                           threads, made->candidates, err);
    made->chosen = status == ISO_OK ? iso_scene_level_choose(made->candidates) : ISO_LEVEL_AS_BUILT;
    if (made->chosen != ISO_LEVEL_AS_BUILT) {
        set_scalar(&p->levels[level], scalars[made->chosen]);
        scalars[made->chosen] = scalars[ISO_LEVEL_AS_BUILT];
        free(scalars[made->chosen]);
        scalars[made->chosen] = NULL;
    }
    free(scalars[ISO_LEVEL_LEAST_SQUARES]);
    free(scalars[ISO_LEVEL_FITTED]);
    return status;
}

/* Replaces a level's arrays by those of the optimized one. */
static void take(iso_level *l, iso_optimized *o)
{
    free(l->scalar);
    free(l->codes);
    l->codes = o->codes;
    if (l->directions) {
        free(l->directions);
        l->directions = o->directions;
        o->directions = NULL;
    }
    l->is_optimized = true;
    set_scalar(l, o->scalar);
    o->scalar = NULL;
    o->codes = NULL;
}

/* Compares the optimized level with the best one so far; takes it if both kinds of pictures are nearer. */
static iso_status compare(iso_pyramid *p, size_t level, const iso_scene *scene, looks *l, iso_optimized *o, int threads,
                          iso_scene_level *made, iso_error *err)
{
    iso_tf_table tf = {0};
    bool adapted;
    iso_level shown = p->levels[level];
    shown.is_optimized = true;
    set_scalar(&shown, o->scalar);
    shown.codes = o->codes;
    iso_status status = judge(p, level, l, &shown, threads, &made->candidates[ISO_LEVEL_OPTIMIZED], err);
    TRY(status, adapt(p, level, &p->levels[level], l, threads, &tf, &adapted, err));
    TRY(status, iso_level_gate_judge(p, level, scene, &(iso_level_with_tf){&p->levels[level], &tf}, &shown, threads,
                                     &made->optimized.gate, err));
    iso_tf_table_destroy(&tf);
    if (status != ISO_OK || !made->optimized.gate.accepts ||
        iso_scene_level_choose(made->candidates) != ISO_LEVEL_OPTIMIZED)
        return status;
    take(&p->levels[level], o);
    made->chosen = ISO_LEVEL_OPTIMIZED;
    return ISO_OK;
}

static iso_status optimize_level(iso_pyramid *p, size_t level, const iso_scene *scene, looks *l,
                                 const iso_optimize_options *opt, int threads, iso_scene_level *made,
                                 const iso_progress *progress, iso_error *err)
{
    iso_optimize_options own = *opt;
    iso_optimized o;
    own.seed += level;
    own.threads = threads;
    iso_status status = iso_optimize_level(p, level, scene, &own, &o, progress, err);
    if (status == ISO_E_RANGE) /* it shows nothing, or its code is not linear: the other candidates stay */
        return ISO_OK;
    made->optimized = (struct iso_scene_level_optimized){true,          o.views, o.pixels,          o.steps,
                                                         o.error_first, o.error, {.accepts = false}};
    TRY(status, compare(p, level, scene, l, &o, threads, made, err));
    iso_optimized_destroy(&o);
    return status;
}

static json_t *candidates_to_json(const iso_level_candidate candidates[ISO_LEVEL_SCALAR_COUNT])
{
    json_t *list = json_array();
    for (int i = 0; i < ISO_LEVEL_SCALAR_COUNT; ++i)
        if (candidates[i].tried)
            json_array_append_new(list, json_pack("{s:s, s:b, s:f, s:f}", "scalar",
                                                  iso_level_scalar_name((iso_level_scalar)i), "adapted_tf",
                                                  candidates[i].adapted, "ssim_dissimilarity",
                                                  candidates[i].ssim_dissimilarity, "rmse", candidates[i].rmse));
    return list;
}

/* Describes how an optimized level was made and judged. */
static json_t *optimized_to_json(const iso_scene_level *made, uint64_t seed)
{
    const iso_level_seen *seen[2] = {&made->optimized.gate.today, &made->optimized.gate.optimized};
    json_t *o = json_pack("{s:I, s:I, s:I, s:I, s:f, s:f}", "seed", (json_int_t)seed, "views",
                          (json_int_t)made->optimized.views, "pixels", (json_int_t)made->optimized.pixels, "steps",
                          (json_int_t)made->optimized.steps, "error_first", made->optimized.error_first, "error",
                          made->optimized.error);
    for (int i = 0; i < 2; ++i)
        json_object_set_new(o, i == 0 ? "before" : "after",
                            json_pack("{s:f, s:f, s:f, s:f}", "ssim_dissimilarity", seen[i]->ssim_dissimilarity, "rmse",
                                      seen[i]->rmse, "minified_ssim_dissimilarity", seen[i]->small_ssim_dissimilarity,
                                      "minified_rmse", seen[i]->small_rmse));
    return o;
}

static json_t *made_for(const iso_scene *scene, size_t first, size_t count, const iso_scene_level *levels,
                        const iso_optimize_options *opt)
{
    json_t *list = json_array();
    for (size_t k = first; k < count; ++k) {
        json_array_append_new(list, json_pack("{s:I, s:s, s:o}", "level", (json_int_t)k, "scalar",
                                              iso_level_scalar_name(levels[k].chosen), "candidates",
                                              candidates_to_json(levels[k].candidates)));
        if (levels[k].optimized.tried)
            json_object_set_new(json_array_get(list, k - first), "optimized",
                                optimized_to_json(&levels[k], opt->seed + k));
    }
    return json_pack("{s:s, s:o, s:o}", "scene", scene->path ? iso_provenance_name(scene->path) : "first", "levels",
                     list, "tf", iso_tf_to_json(&scene->tf));
}

iso_status iso_scene_levels_make(iso_pyramid *p, size_t first, const iso_scene *scene,
                                 const iso_optimize_options *optimize, int threads, iso_scene_level *levels,
                                 const iso_progress *progress, iso_error *err)
{
    iso_scene_level own[32];
    looks l;
    levels = levels ? levels : own;
    iso_status status = look(p, scene, threads, &l, err);
    for (size_t k = first; k < p->level_count && status == ISO_OK; ++k) {
        iso_progress_report(progress, "levels for the scene", (double)(k - first) / (double)(p->level_count - first));
        const double began = iso_clock_seconds();
        status = make_level(p, k, &l, threads, &levels[k], err);
        if (status == ISO_OK && optimize && optimize->effort != ISO_EFFORT_NONE && !(optimize->stop && *optimize->stop))
            status = optimize_level(p, k, scene, &l, optimize, threads, &levels[k], progress, err);
        levels[k].seconds = iso_clock_seconds() - began;
    }
    iso_progress_report(progress, "levels for the scene", 1);
    forget(&l);
    if (status != ISO_OK)
        return status;
    json_decref(p->made_for);
    p->made_for = made_for(scene, first, p->level_count, levels, optimize);
    return p->made_for ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "no memory for the description of the levels' scene");
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

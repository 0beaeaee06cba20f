/* SPDX-License-Identifier: MIT */
/* agreement_limits.c - every renderer's extrapolated limit against the closed form or the reference, level by level. */
#include <math.h>
#include <stdio.h>

#include "validate/agreement_rows.h"
#include "validate/limits.h"

/* A limit that stays until the versions of its program are compared. */
typedef struct iso_version_limit_kept {
    iso_version_limit about;
    iso_extrapolated limit;
} version_limit;

/* Takes the limit. */
static void keep_limit(const iso_validation *v, size_t level, const iso_renderer_info *renderer,
                       iso_extrapolated *limit, const iso_compared *with, version_limit *kept)
{
    kept->limit = *limit;
    *limit = (iso_extrapolated){0};
    kept->about = (iso_version_limit){.renderer = renderer, .limit = &kept->limit};
    iso_validate_name_image(v, level, with->what, kept->about.image_name);
    snprintf(kept->about.options, sizeof kept->about.options, "%s", with->options);
}

/* Compares a renderer's limit with the reference. kept: takes the limit, if it is compared; or NULL. */
iso_status iso_validate_compare_limit(iso_validation *v, size_t level, const iso_renderer_info *renderer,
                                      const iso_level_truths *t, version_limit *kept, iso_error *err)
{
    const iso_truth *a = t->differ && iso_renderer_has(renderer, ISO_IS_PROGRAM) ? &t->exported : &t->main;
    const iso_scene_agreement *asked = &v->scene->agreement;
    char what[64], options[64], why[512];
    iso_extrapolated limit = {0};
    iso_report_agreement row = {.comparison = ISO_COMPARISON_LIMIT,
                                .tier = iso_tier_name(asked->tier == ISO_TIER_TIGHT ? ISO_TIER_CONVERGENCE
                                                                                    : asked->tier),
                                .why = asked->why};
    if (iso_validate_cannot_compare(v, renderer, &row, why))
        return iso_validate_add_without_images(v, level, row, a->name, renderer, err);
    iso_error reason = {""};
    if (iso_validate_has_no_formula(v, level, &reason)) {
        snprintf(why, sizeof why, "the scene's formula does not hold for this level: %.400s", reason.text);
        row.uncompared = ISO_UNCOMPARED_FORMULA;
        row.uncompared_why = why;
        return iso_validate_add_without_images(v, level, row, a->name, renderer, err);
    }
    snprintf(what, sizeof what, "%s-limit", renderer->name);
    iso_validate_begin_row(v, level, what);
    iso_limit_options opt = iso_validate_limit_options(asked, renderer, v->seeds, v->threads);
    iso_render_options reference = iso_render_defaults(iso_renderers_reference());
    reference.source = a == &t->exported ? ISO_FROM_DECODED : ISO_FROM_CODES;
    reference.threads = v->threads;
    opt.truth = &reference;
    opt.deadline = v->deadline;
    opt.keep = kept != NULL;
    iso_signal signal;
    iso_status status = iso_signal_of(&a->image, v->view->background, 0, ISO_SIGNAL_RMS, &signal, err);
    opt.wanted_held_to = fmin(signal.color, signal.alpha) / ISO_SIGNAL_FACTOR;
    if (status != ISO_OK)
        return status;
    iso_error failure = {""};
    status = iso_limit_find(&(iso_render_request){&v->renderers, v->pyramid, level, v->view, NULL, v->progress},
                            &a->image, renderer, &opt, &limit, &failure);
    if (status != ISO_OK)
        return iso_validate_refuse_failed(v, level, row, a->name, renderer, status, &failure, err);
    if (limit.unfinished) {
        snprintf(why, sizeof why,
                 "the budget of %g s was over at a step of %g voxel: the error bar is %.2g, the RMSE %.2g",
                 v->budget_seconds, limit.step_voxels, limit.bar, limit.rmse);
        row.uncompared = ISO_UNCOMPARED_BUDGET;
        row.uncompared_why = why;
        iso_extrapolated_destroy(&limit);
        return iso_validate_add_without_images(v, level, row, a->name, renderer, err);
    }
    if (limit.intervals)
        snprintf(options, sizeof options, " --limit --planes %zu --intervals %zu", limit.planes, limit.intervals);
    else if (limit.seeds > 1)
        snprintf(options, sizeof options, " --limit --step %g --seeds %zu", limit.step_voxels, limit.seeds);
    else
        snprintf(options, sizeof options, " --limit --step %g", limit.step_voxels);
    iso_validate_limit_row(asked, &limit, &row);
    row.statistics = iso_validate_limit_to_json(&limit);
    json_object_set_new(row.statistics, "pixels",
                        json_pack("[I,I]", (json_int_t)v->view->width, (json_int_t)v->view->height));
    status = iso_validate_add_row(v, level, &row, a,
                                  &(iso_compared){what, &limit.image, renderer, options,
                                                  iso_extrapolated_held_to(&limit)},
                                  err);
    json_decref(row.statistics);
    if (kept && status == ISO_OK)
        keep_limit(v, level, renderer, &limit, &(iso_compared){.what = what, .options = options}, kept);
    iso_extrapolated_destroy(&limit);
    return status;
}

/* Compares every wanted renderer that has a limit; then the versions of one with each other. */
static iso_status compare_limits(iso_validation *v, size_t level, const iso_level_truths *t, iso_error *err)
{
    version_limit kept[ISO_MAX_RENDERERS] = {{.about.renderer = NULL}};
    iso_status status = ISO_OK;
    for (size_t i = 0; i < iso_renderer_count() && status == ISO_OK; ++i) {
        const iso_renderer_info *renderer = iso_renderer_at(i);
        if (!v->wanted[i] || !iso_renderer_has(renderer, ISO_HAS_LIMIT))
            continue;
        status = iso_validate_compare_limit(v, level, renderer, t,
                                            iso_validate_has_versions(v, renderer) ? &kept[i] : NULL, err);
        iso_validate_end_row(v, renderer, true);
    }
    for (size_t i = 0; i < iso_renderer_count() && status == ISO_OK; ++i) {
        const iso_renderer_info *first = iso_renderer_at(i)->beside;
        const version_limit *a = first ? &kept[iso_renderer_index(first)] : NULL;
        if (a && a->limit.kept && kept[i].limit.kept)
            status = iso_validate_versions(v, level, &a->about, &kept[i].about, err);
    }
    for (size_t i = 0; i < iso_renderer_count(); ++i)
        iso_extrapolated_destroy(&kept[i].limit);
    return status;
}

/* Limits take most of the time: they render several steps, with only as many pixels as they need. */
iso_status iso_validate_limits_at(iso_validation *v, size_t level, iso_error *err)
{
    const iso_view *whole = v->view, small = iso_validate_small_view(whole, v->limit_size);
    OWNED(iso_level_truths) t = {.differ = false};
    v->view = &small;
    t.main.name = t.exported.name = "reference";
    iso_status status = iso_validate_is_out_of_time(v) ? ISO_OK : iso_validate_find_truths(v, level, &t, err);
    TRY(status, compare_limits(v, level, &t, err));
    v->view = whole;
    return status;
}

/* SPDX-License-Identifier: MIT */
/* agreement.c - every renderer against the closed form or the reference, level by level: by the same samples and by
 * first hits here, by limits in agreement_limits.c. */
#include <math.h>
#include <stdio.h>

#include "validate/agreement_rows.h"
#include "validate/rounding.h"

/* Tolerances for the same samples with exact lookups, for any transfer function. */
static iso_tolerances exact_lock_step_tolerances(const iso_renderer_info *renderer)
{
    const iso_sample_error *e = &renderer->lock_step->exact;
    return (iso_tolerances){.rmse = e->rmse, .max_abs = e->max_abs};
}

/* ---- lock-step: the same samples ---- */

/* Compares a renderer that has exact lookups once more, without the usual rounding, if the TF is steep or the usual
 * lookups exceed their tolerances. The remaining error has narrower tolerances than smooth TFs have. *holds: it is
 * within them. */
static iso_status exact_lock_step(iso_validation *v, size_t level, const iso_truth *same, iso_render_options opt,
                                  bool *holds, iso_error *err)
{
    const iso_renderer_info *renderer = opt.renderer;
    OWNED(iso_image) image = {0};
    char what[64];
    iso_report_agreement row = {.comparison = ISO_COMPARISON_EXACT,
                                .tier = "lock-step",
                                .error_bar = NAN,
                                .tolerances = exact_lock_step_tolerances(renderer),
                                .why = renderer->lock_step->exact_why};
    snprintf(what, sizeof what, "%s-lockstep-exact", renderer->name);
    iso_validate_begin_row(v, level, what);
    opt.exact_lookups = true;
    NEED(iso_validate_render(v, level, &opt, &image, err));
    NEED(iso_validate_add_row(v, level, &row, same, &(iso_compared){what, &image, renderer, " --exact-lookups", 0},
                              err));
    *holds = iso_metrics_within(&row.metrics, &row.tolerances);
    return ISO_OK;
}

static iso_status rounding_bound(const iso_validation *v, size_t level, const iso_render_options *opt,
                                 iso_sample_error *most, iso_error *err)
{
    return iso_rounding_bound(&v->pyramid->levels[level], v->pyramid->options.code, v->view, opt->source,
                              opt->renderer->lock_step->float_rays, v->threads, most, err);
}

/* Limits of usual lookups, used only if exact lookups are within theirs: the rest is rounding in texture units. */
static iso_status allow_rounding(const iso_validation *v, size_t level, const iso_render_options *opt,
                                 iso_report_agreement *row, iso_error *err)
{
    const iso_lock_step *lock = opt->renderer->lock_step;
    iso_sample_error most;
    NEED(rounding_bound(v, level, opt, &most, err));
    row->tolerances = (iso_tolerances){.rmse = fmax(lock->rounded.rmse, most.rmse),
                                       .max_abs = fmax(lock->rounded.max_abs, most.max_abs)};
    row->why = lock->rounded_why;
    return ISO_OK;
}

/* Widens the limits that a picture of rays in single precision exceeds by what its rounding may change. The others
 * stay: steep edges move single pixels, not the RMSE. */
static iso_status allow_float_rays(const iso_validation *v, size_t level, const iso_render_options *opt,
                                   const iso_metrics *seen, iso_report_agreement *row, iso_error *err)
{
    iso_sample_error most;
    const iso_status status = rounding_bound(v, level, opt, &most, err);
    iso_tolerances *limits = &row->tolerances;
    if (!(seen->rmse <= limits->rmse))
        limits->rmse = fmax(limits->rmse, most.rmse);
    if (!(seen->max_abs <= limits->max_abs))
        limits->max_abs = fmax(limits->max_abs, most.max_abs);
    row->why = "the same samples, in single precision: where its rounding exceeds the usual limits, the limit is the "
               "bound of its effect under this transfer function";
    return status;
}

/* Adds the row of the usual lookups and, if requested, that of exact ones. If the usual ones exceed their tolerances,
 * the exact ones come first, because they separate rounding from a fault. */
static iso_status add_lock_step(iso_validation *v, size_t level, iso_report_agreement *row, const iso_truth *same,
                                const iso_compared *with, const iso_render_options *opt, iso_error *err)
{
    const iso_lock_step *lock = with->renderer->lock_step;
    const bool has_exact = lock->exact.max_abs > 0;
    const double start = v->row_start;
    iso_metrics seen = {0};
    bool holds = false;
    if (row->refused)
        return iso_validate_add_row(v, level, row, same, with, err);
    NEED(iso_metrics_measure(&same->image, with->image, &seen, err));
    const bool first = has_exact && !iso_metrics_within(&seen, &row->tolerances);
    if (first)
        NEED(exact_lock_step(v, level, same, *opt, &holds, err));
    v->row_start = start;
    if (holds)
        NEED(allow_rounding(v, level, opt, row, err));
    if (lock->float_rays && !iso_metrics_within(&seen, &row->tolerances))
        NEED(allow_float_rays(v, level, opt, &seen, row, err));
    NEED(iso_validate_add_row(v, level, row, same, with, err));
    return has_exact && !first && v->scene->agreement.sharp ? exact_lock_step(v, level, same, *opt, &holds, err)
                                                            : ISO_OK;
}

/* Images rounded to 8 bits are compared if the reference shows ten times the rounding error: a hundred times would be
 * more than most scenes show. */
enum { STATED_SIGNAL = 10 };

/* True if a renderer that failed its calibration is drawn all the same, without a verdict: its picture of level 0 helps
 * to find the cause. */
static bool is_shown(const iso_validation *v, size_t level, const iso_renderer_info *renderer)
{
    return v->refused[iso_renderer_index(renderer)].draws && level == 0 && !v->variant[0] &&
           !iso_renderer_lacks(renderer, v->pyramid, v->view, false) && !iso_validate_is_out_of_time(v);
}

static iso_status lock_step(iso_validation *v, size_t level, const iso_renderer_info *renderer, iso_error *err)
{
    const iso_lock_step *lock = renderer->lock_step;
    const bool exported = iso_renderer_has(renderer, ISO_IS_PROGRAM),
               stated = lock->quadrature == ISO_QUADRATURE_CONVERGED;
    OWNED(iso_truth) same = {.name = stated ? "reference" : "reference, same samples"};
    char what[64], reference[80], options[64] = "", why[512];
    OWNED(iso_image) image = {0};
    iso_error failure = {""};
    iso_render_options opt = iso_render_defaults(renderer);
    iso_report_agreement row = {.comparison = stated ? ISO_COMPARISON_STATED : ISO_COMPARISON_LOCK_STEP,
                                .tier = stated ? "stated limits" : "lock-step",
                                .error_bar = NAN,
                                .why = lock->why,
                                .tolerances = iso_validate_lock_step(renderer, v->view, v->scene->agreement.sharp)};
    if (iso_validate_cannot_compare(v, renderer, &row, why) && !is_shown(v, level, renderer))
        return iso_validate_add_without_images(v, level, row, same.name, renderer, err);
    snprintf(what, sizeof what, stated ? "%s-stated" : "%s-lockstep", renderer->name);
    iso_validate_begin_row(v, level, what);
    opt.threads = v->threads;
    opt.source = exported ? ISO_FROM_CODES : v->source;
    opt.intervals = lock->intervals;
    if (lock->intervals)
        snprintf(options, sizeof options, " --intervals %zu", lock->intervals);
    snprintf(reference, sizeof reference, "reference-%s", what);
    iso_validate_name_image(v, level, reference, same.image_name);
    NEED(iso_validate_render_reference(v, level, lock->quadrature, lock->intervals,
                                       exported ? iso_validate_exported_source(v) : v->source, &same.image, err));
    if (renderer->output.most > 0 && iso_image_clip(&same.image, (float)renderer->output.most))
        same.name = stated ? "reference, clipped" : "reference, same samples, clipped";
    NEED(iso_validate_add_image(v, same.image_name, &same.image, same.name, err));
    const iso_status status = iso_validate_render(v, level, &opt, &image, &failure);
    if (status != ISO_OK)
        return iso_validate_refuse_failed(v, level, row, same.name, renderer, status, &failure, err);
    return add_lock_step(v, level, &row, &same,
                         &(iso_compared){what, &image, renderer, options,
                                         stated ? row.tolerances.rmse * STATED_SIGNAL / ISO_SIGNAL_FACTOR : 0},
                         &opt, err);
}

/* ---- first hits ---- */

static iso_status first_hits(iso_validation *v, size_t level, iso_error *err)
{
    const iso_level *l0 = &v->pyramid->levels[0];
    OWNED(iso_truth) a = {.name = "reference, first hit"};
    iso_render_options opt = iso_render_defaults(iso_renderers_reference());
    char options[64], why[512];
    opt.isosurface = true;
    opt.iso = l0->min + v->scene->suite_isosurface * (l0->max - l0->min);
    opt.threads = v->threads;
    opt.source = iso_validate_exported_source(v);
    iso_validate_name_image(v, level, "reference", a.image_name);
    iso_validate_begin_row(v, level, a.name);
    NEED(iso_validate_render(v, level, &opt, &a.image, err));
    NEED(iso_validate_add_image(v, a.image_name, &a.image, a.name, err));
    snprintf(options, sizeof options, " --isosurface %.9g", opt.iso);
    for (size_t i = 0; i < iso_renderer_count(); ++i) {
        OWNED(iso_image) image = {0};
        /* A ray that grazes the surface hits it in one arithmetic and misses it in another: a few pixels may. */
        const iso_renderer_info *renderer = iso_renderer_at(i);
        iso_report_agreement row = {.comparison = ISO_COMPARISON_FIRST_HIT,
                                    .tier = iso_tier_name(ISO_TIER_FIRST_HIT),
                                    .error_bar = NAN,
                                    .tolerances = {.rmse = 5e-3, .p99_abs = 2e-4},
                                    .why = v->scene->agreement.why};
        if (renderer == iso_renderers_reference() || !v->wanted[i])
            continue;
        if (iso_validate_cannot_compare(v, renderer, &row, why)) {
            NEED(iso_validate_add_without_images(v, level, row, a.name, renderer, err));
            continue;
        }
        iso_error failure = {""};
        opt.renderer = renderer;
        iso_validate_begin_row(v, level, renderer->name);
        const iso_status status = iso_validate_render(v, level, &opt, &image, &failure);
        if (status != ISO_OK)
            NEED(iso_validate_refuse_failed(v, level, row, a.name, renderer, status, &failure, err));
        else
            NEED(iso_validate_add_row(v, level, &row, &a, &(iso_compared){renderer->name, &image, renderer, options, 0},
                                      err));
    }
    return ISO_OK;
}

/* True if renderer i takes part in this row's directions and transfer function. Pictures that were made elsewhere show
 * the scene's own only. */
static bool takes_part(const iso_validation *v, size_t i, bool programs)
{
    const iso_renderer_info *renderer = iso_renderer_at(i);
    return v->wanted[i] && (programs || !iso_renderer_has(renderer, ISO_IS_PROGRAM)) &&
           !(v->variant[0] && iso_renderer_has(renderer, ISO_IS_OF_PICTURES));
}

/* Compares every wanted renderer whose samples are known. programs: false leaves out renderers outside this process. */
static iso_status lock_steps(iso_validation *v, size_t level, bool programs, iso_error *err)
{
    for (size_t i = 0; i < iso_renderer_count(); ++i) {
        if (!iso_renderer_at(i)->lock_step || !takes_part(v, i, programs))
            continue;
        const iso_status status = lock_step(v, level, iso_renderer_at(i), err);
        iso_validate_end_row(v, iso_renderer_at(i), false);
        NEED(status);
    }
    return ISO_OK;
}

static iso_status agree_at(iso_validation *v, size_t level, void *unused, iso_error *err)
{
    (void)unused;
    v->renderers.scene = v->scene_name;
    const bool samples = v->agreement_part != ISO_VALIDATE_LIMITS, limits = v->agreement_part != ISO_VALIDATE_SAMPLES;
    if (v->scene->agreement.tier == ISO_TIER_FIRST_HIT)
        return samples ? first_hits(v, level, err) : ISO_OK;
    const iso_level *l = &v->pyramid->levels[level];
    const iso_view *whole = v->view;
    iso_view shown = *whole;
    if (l->geometry.has_no_data)
        shown.extinction_scale = l->scale;
    v->view = &shown;
    iso_status status = samples ? lock_steps(v, level, true, err) : ISO_OK;
    TRY(status, limits ? iso_validate_limits_at(v, level, err) : ISO_OK);
    v->view = whole;
    return status;
}

/* Compares by the same samples if they are known, otherwise by the limit, which takes many times as long. */
iso_status iso_validate_variant(iso_validation *v, size_t level, iso_error *err)
{
    /* At level 0 all filters store the same directions. */
    const bool programs = v->source == ISO_FROM_CODES && level > 0 && !v->quick;
    OWNED(iso_level_truths) t = {.differ = false};
    NEED(lock_steps(v, level, programs, err));
    for (size_t i = 0; i < iso_renderer_count(); ++i) {
        const iso_renderer_info *renderer = iso_renderer_at(i);
        if (renderer->lock_step || !iso_renderer_has(renderer, ISO_HAS_LIMIT) || !takes_part(v, i, programs))
            continue;
        t.main.name = t.exported.name = "reference";
        if (!t.main.image.rgba && !iso_validate_is_out_of_time(v))
            NEED(iso_validate_find_truths(v, level, &t, err));
        NEED(iso_validate_compare_limit(v, level, renderer, &t, NULL, err));
    }
    return ISO_OK;
}

iso_status iso_validate_agreement(iso_validation *v, iso_error *err)
{
    return iso_validate_each(v, v->pyramid->level_count, agree_at, NULL, err);
}

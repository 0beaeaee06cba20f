/* SPDX-License-Identifier: MIT */
/* agreement_rows.c - the rows of comparisons, the rows that cannot be compared, and the images that a level is compared
 * with. */
#define _GNU_SOURCE
#include "validate/agreement_rows.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/parallel.h"
#include "validate/closed_form.h"

/* Returns the source of exported directions. They are decoded, so the reference takes the same; for linear codes
 * nothing changes. */
iso_direction_source iso_validate_exported_source(const iso_validation *v)
{
    return iso_code_describe(v->pyramid->options.code)->is_linear ? ISO_FROM_CODES : ISO_FROM_DECODED;
}

void iso_validate_name_image(const iso_validation *v, size_t level, const char *what, char name[96])
{
    snprintf(name, 96, "%.50slevel-%zu-%.30s", v->image_prefix, level, what);
}

iso_status iso_validate_add_image(iso_validation *v, const char *name, const iso_image *image, const char *caption,
                                  iso_error *err)
{
    NEED(iso_report_add_image(v->report, name, image, caption, err));
    iso_report_set_scale(v->report, name, iso_view_mm_per_pixel(v->view, &v->pyramid->levels[0].geometry));
    return ISO_OK;
}

/* Starts a row: its name for the progress line, and its clock. */
void iso_validate_begin_row(iso_validation *v, size_t level, const char *what)
{
    char stage[160];
    snprintf(stage, sizeof stage, "%s%slevel %zu: %s", v->variant, v->variant[0] ? ", " : "", level, what);
    iso_progress_report(v->progress, stage, 0);
    v->row_start = iso_clock_seconds();
}

/* Returns the limit for the image as a whole. For first hits it is the difference that 99 % of the pixels stay below,
 * since their RMSE depends on the few rays that graze the surface. Otherwise it is the RMSE, or the largest difference
 * if only that is requested. */
static double limit_of_the_picture(const iso_report_agreement *row, const iso_compared *with,
                                   iso_signal_measure *measure)
{
    const bool first_hit = row->comparison == ISO_COMPARISON_FIRST_HIT;
    *measure = first_hit ? ISO_SIGNAL_P99 : ISO_SIGNAL_RMS;
    return with->held_to > 0          ? with->held_to
           : first_hit                ? row->tolerances.p99_abs
           : row->tolerances.rmse > 0 ? row->tolerances.rmse
                                      : row->tolerances.max_abs;
}

/* Marks a row as uncompared if its images show little compared with their limits, which would prove nothing. But if a
 * formula predicts an empty image, emptiness is the scene's point: then every bit has to equal the background. */
static iso_status ask_for_a_signal(const iso_validation *v, const iso_truth *a, const iso_compared *with,
                                   iso_report_agreement *row, char why[512], iso_error *err)
{
    iso_signal_measure measure;
    const double limit = limit_of_the_picture(row, with, &measure);
    if (v->scene->agreement.tier == ISO_TIER_CLOSED_FORM && iso_image_is_empty(&a->image, v->view->background)) {
        row->tolerances = (iso_tolerances){0};
        row->gate_count = 0;
        row->why = "the formula says that nothing is shown, so the image has to be the background in every bit";
        return ISO_OK;
    }
    NEED(iso_signal_of(&a->image, v->view->background, limit, measure, &row->signal, err));
    if (!iso_signal_suffices(&row->signal)) {
        iso_signal_explain(&row->signal, why, 512);
        row->uncompared = ISO_UNCOMPARED_FAINT;
        row->uncompared_why = why;
    }
    return ISO_OK;
}

/* Adds a row with its image b and the shared data; *row has its comparison, tier, tolerances and gates. */
iso_status iso_validate_add_row(iso_validation *v, size_t level, iso_report_agreement *row, const iso_truth *a,
                                const iso_compared *with, iso_error *err)
{
    const iso_image *b = with->image;
    char name[96], caption[ISO_ROW_NAME_BYTES], faint[512];
    iso_validate_name_image(v, level, with->what, name);
    row->renderer = with->renderer->name;
    row->variant = v->variant;
    iso_row_name(row->renderer, row->comparison, row->variant, caption);
    row->level = level;
    row->order = v->order;
    row->scene = v->scene_name;
    row->a = row->a ? row->a : a->name;
    row->image_a = a->image_name;
    row->image_b = name;
    NEED(iso_validate_add_image(v, name, b, caption, err));
    NEED(iso_metrics_measure(&a->image, b, &row->metrics, err));
    NEED(ask_for_a_signal(v, a, with, row, faint, err));
    FREED char *command = iso_validate_reproduce(v, level, with->renderer, with->options, a->image_name,
                                                 &row->tolerances);
    row->command = command;
    row->seconds = iso_clock_seconds() - v->row_start;
    return iso_report_add_agreement(v->report, row, err);
}

/* True if nothing can be compared: the renderer is missing, failed its calibration or lacks a feature of the scene, or
 * time has run out. Then *row states the reason from `why`. */
bool iso_validate_cannot_compare(const iso_validation *v, const iso_renderer_info *renderer, iso_report_agreement *row,
                                 char why[512])
{
    const iso_refusal *refusal = &v->refused[iso_renderer_index(renderer)];
    const char *lacks = iso_renderer_lacks(renderer, v->pyramid, v->view, row->comparison == ISO_COMPARISON_FIRST_HIT);
    if (refusal->status != ISO_OK) {
        snprintf(why, 512, "%s", refusal->why);
        row->refused = why;
    } else if (lacks) {
        snprintf(why, 512, "%s does not render %s", renderer->name, lacks);
        row->uncompared = ISO_UNCOMPARED_TRAIT;
        row->uncompared_why = why;
    }
    const bool late = refusal->status == ISO_OK && !lacks && iso_validate_is_out_of_time(v);
    if (late) {
        iso_validate_explain_budget(v, why);
        row->uncompared = ISO_UNCOMPARED_BUDGET;
        row->uncompared_why = why;
    }
    return refusal->status != ISO_OK || lacks || late;
}

/* Adds a row without images: *row has its comparison, its tier and the reason of iso_validate_cannot_compare(). */
iso_status iso_validate_add_without_images(iso_validation *v, size_t level, iso_report_agreement row, const char *a,
                                           const iso_renderer_info *renderer, iso_error *err)
{
    row.level = level;
    row.order = v->order;
    row.scene = v->scene_name;
    row.a = a;
    row.renderer = renderer->name;
    row.variant = v->variant;
    row.error_bar = NAN;
    row.tolerances = (iso_tolerances){0};
    return iso_report_add_agreement(v->report, &row, err);
}

/* Refuses a program that failed by itself from here on: one that hangs would take its time limit again. The others go
 * on. */
iso_status iso_validate_refuse_failed(iso_validation *v, size_t level, iso_report_agreement row, const char *a,
                                      const iso_renderer_info *renderer, iso_status status, const iso_error *why,
                                      iso_error *err)
{
    iso_refusal *refusal = &v->refused[iso_renderer_index(renderer)];
    if (!iso_validate_is_its_fault(renderer, status))
        return iso_fail(err, status, "%s", why->text);
    if (iso_validate_is_out_of_time(v)) { /* that ended it */
        char late[512];
        iso_validate_explain_budget(v, late);
        row.uncompared = ISO_UNCOMPARED_BUDGET;
        row.uncompared_why = late;
        return iso_validate_add_without_images(v, level, row, a, renderer, err);
    }
    if (iso_renderer_has(renderer, ISO_IS_OF_PICTURES)) { /* of which another one may be there */
        row.refused = why->text;
        return iso_validate_add_without_images(v, level, row, a, renderer, err);
    }
    *refusal = (iso_refusal){.status = status == ISO_E_MISSING ? status : ISO_E_UNTRUSTED};
    snprintf(refusal->why, sizeof refusal->why, "%.500s", why->text);
    row.refused = refusal->why;
    return iso_validate_add_without_images(v, level, row, a, renderer, err);
}

/* ---- truths ---- */

iso_status iso_validate_render(iso_validation *v, size_t level, const iso_render_options *opt, iso_image *image,
                               iso_error *err)
{
    return iso_render_with(&(iso_render_request){&v->renderers, v->pyramid, level, v->view, opt, v->progress}, image,
                           NULL, err);
}

/* Renders the reference. intervals: of a quadrature that has them. */
iso_status iso_validate_render_reference(iso_validation *v, size_t level, iso_quadrature quadrature, size_t intervals,
                                         iso_direction_source source, iso_image *image, iso_error *err)
{
    iso_render_options opt = iso_render_defaults(iso_renderers_reference());
    iso_render_stats stats = {0};
    opt.quadrature = quadrature;
    opt.source = source;
    opt.intervals = intervals;
    opt.threads = v->threads;
    opt.stats = &stats;
    NEED(iso_validate_render(v, level, &opt, image, err));
    if (stats.error > 0) {
        char name[96];
        iso_validate_name_image(v, level, iso_direction_source_name(source), name);
        iso_report_put(v->report, "reference", name,
                       json_pack("{s:f, s:b}", "error_bound", stats.error, "error_bound_is_proved",
                                 (int)stats.is_proved));
    }
    return ISO_OK;
}

/* Compares the reference, whose own tolerance is 1e-6 per pixel, with the formula. Images are float. */
static iso_status check_reference(iso_validation *v, size_t level, const iso_truth *formula, iso_error *err)
{
    OWNED(iso_image) image = {0};
    iso_report_agreement row = {.comparison = ISO_COMPARISON_CLOSED_FORM,
                                .tier = iso_tier_name(ISO_TIER_CLOSED_FORM),
                                .error_bar = NAN,
                                .tolerances = {.max_abs = 5e-6},
                                .why = v->scene->agreement.why};
    NEED(iso_validate_render_reference(v, level, ISO_QUADRATURE_CONVERGED, 0, ISO_FROM_CODES, &image, err));
    return iso_validate_add_row(v, level, &row, formula,
                                &(iso_compared){"reference", &image, iso_renderers_reference(), "", 0}, err);
}

bool iso_validate_has_no_formula(const iso_validation *v, size_t level, iso_error *why)
{
    return level > 0 && v->scene->agreement.tier == ISO_TIER_CLOSED_FORM &&
           iso_closed_form_check(&v->pyramid->levels[level], v->view, why) != ISO_OK;
}

iso_status iso_validate_find_truths(iso_validation *v, size_t level, iso_level_truths *t, iso_error *err)
{
    const bool formula = v->scene->agreement.tier == ISO_TIER_CLOSED_FORM;
    *t = (iso_level_truths){.main = {.name = formula ? "closed form" : "reference"},
                            .exported = {.name = "reference, decoded"}};
    t->differ = !formula && iso_validate_exported_source(v) != ISO_FROM_CODES;
    if (iso_validate_has_no_formula(v, level, NULL))
        return ISO_OK;
    iso_validate_begin_row(v, level, t->main.name);
    iso_validate_name_image(v, level, formula ? "closed-form" : "reference", t->main.image_name);
    iso_validate_name_image(v, level, "reference-decoded", t->exported.image_name);
    NEED(formula ? iso_closed_form_render(&v->pyramid->levels[level], v->pyramid->options.code, v->view, &t->main.image,
                                          err)
                 : iso_validate_render_reference(v, level, ISO_QUADRATURE_CONVERGED, 0, ISO_FROM_CODES, &t->main.image,
                                                 err));
    NEED(iso_validate_add_image(v, t->main.image_name, &t->main.image, t->main.name, err));
    if (t->differ) {
        NEED(iso_validate_render_reference(v, level, ISO_QUADRATURE_CONVERGED, 0, ISO_FROM_DECODED, &t->exported.image,
                                           err));
        NEED(iso_validate_add_image(v, t->exported.image_name, &t->exported.image, t->exported.name, err));
    }
    return formula ? check_reference(v, level, &t->main, err) : ISO_OK;
}

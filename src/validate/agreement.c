/* SPDX-License-Identifier: MIT */
/* agreement.c - every renderer against the closed form or the reference, level by level. */
#define _GNU_SOURCE
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "renderers/request.h"
#include "validate/closed_form.h"
#include "validate/limits.h"
#include "validate/validate.h"

/* Of the same samples with exact lookups, whatever the transfer function. */
static iso_tolerances exact_lock_step_tolerances(const iso_renderer_info *renderer)
{
    const iso_sample_error *e = &renderer->lock_step->exact;
    return (iso_tolerances){.rmse = e->rmse, .max_abs = e->max_abs};
}

/* What a level is compared with, rendered once. */
typedef struct truth {
    const char *name; /* "closed form", "reference" */
    char image_name[96];
    iso_image image;
} truth;

typedef struct level_truths {
    truth main;     /* closed form, or the reference from the codes */
    truth exported; /* the reference from decoded directions, where that is another image */
    bool differ;
} level_truths;

/* The exports carry decoded directions, so the reference takes the same; for linear codes nothing changes. */
static iso_direction_source exported_source(const iso_validation *v)
{
    return iso_code_describe(v->pyramid->options.code)->is_linear ? ISO_FROM_CODES : ISO_FROM_DECODED;
}

static void name_image(const iso_validation *v, size_t level, const char *what, char name[96])
{
    snprintf(name, 96, "%.50slevel-%zu-%.30s", v->image_prefix, level, what);
}

static iso_status add_image(iso_validation *v, const char *name, const iso_image *image, const char *caption,
                            iso_error *err)
{
    iso_status status = iso_report_add_image(v->report, name, image, caption, NULL, err);
    if (status == ISO_OK)
        iso_report_set_scale(v->report, name, iso_view_mm_per_pixel(v->view, &v->pyramid->levels[0].geometry));
    return status;
}

/* What a row begins with: its name for the progress, and its clock. */
static void begin_row(iso_validation *v, size_t level, const char *what)
{
    char stage[160];
    iso_validate_name_row(stage, sizeof stage, v->variant, level, what);
    iso_progress_report(v->progress, stage, 0);
    v->row_start = iso_clock_seconds();
}

/* An image that is compared with a truth, and what made it. */
typedef struct compared {
    const char *what; /* in the image's name */
    const iso_image *image;
    const iso_renderer_info *renderer;
    const char *options; /* of the command that makes it again */
    double held_to;      /* what holds the image as a whole, of an extrapolated limit; 0: the row's tolerances */
} compared;

/* What holds the image as a whole: for first hits the difference that 99 % of the pixels stay below, since their RMSE is
 * left to the few rays that graze the surface; else RMSE, or the largest difference where that alone is asked. */
static double limit_of_the_picture(const iso_report_agreement *row, const compared *with, iso_signal_measure *measure)
{
    const bool first_hit = row->comparison == ISO_COMPARISON_FIRST_HIT;
    *measure = first_hit ? ISO_SIGNAL_P99 : ISO_SIGNAL_RMS;
    return with->held_to > 0          ? with->held_to
           : first_hit                ? row->tolerances.p99_abs
           : row->tolerances.rmse > 0 ? row->tolerances.rmse
                                      : row->tolerances.max_abs;
}

/* Images that show little beside their limits prove nothing. Where a formula says that nothing is shown, emptiness is the
 * scene's point: then the image has to be the background in every bit. */
static iso_status ask_for_a_signal(const iso_validation *v, const truth *a, const compared *with,
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
    iso_status status = iso_signal_of(&a->image, v->view->background, limit, measure, &row->signal, err);
    if (status == ISO_OK && !iso_signal_suffices(&row->signal)) {
        iso_signal_explain(&row->signal, why, 512);
        row->uncompared = ISO_UNCOMPARED_FAINT;
        row->uncompared_why = why;
    }
    return status;
}

/* A row, its image b and what they have in common; *row has its comparison, tier, tolerances and gates. */
static iso_status add_row(iso_validation *v, size_t level, iso_report_agreement *row, const truth *a,
                          const compared *with, iso_error *err)
{
    const iso_image *b = with->image;
    char name[96], caption[ISO_ROW_NAME_BYTES], faint[512];
    name_image(v, level, with->what, name);
    row->renderer = with->renderer->name;
    row->variant = v->variant;
    iso_row_name(row->renderer, row->comparison, row->variant, caption);
    row->level = level;
    row->order = v->order;
    row->scene = v->scene_name;
    row->a = row->a ? row->a : a->name;
    row->image_a = a->image_name;
    row->image_b = name;
    iso_status status = add_image(v, name, b, caption, err);
    if (status == ISO_OK)
        status = iso_metrics_measure(&a->image, b, &row->metrics, err);
    if (status == ISO_OK)
        status = ask_for_a_signal(v, a, with, row, faint, err);
    char *command = iso_validate_reproduce(v, level, with->renderer, with->options, a->image_name, &row->tolerances);
    row->command = command;
    row->seconds = iso_clock_seconds() - v->row_start;
    if (status == ISO_OK)
        status = iso_report_add_agreement(v->report, row, err);
    free(command);
    return status;
}

/* Is there nothing to compare: the renderer is missing, failed its calibration, or does not have what the scene asks for,
 * or is there no time left?
 * Then *row says so, in the words of why. */
static bool cannot_compare(const iso_validation *v, const iso_renderer_info *renderer, iso_report_agreement *row,
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

/* A row without images: *row has its comparison, its tier and what cannot_compare() said. */
static iso_status add_without_images(iso_validation *v, size_t level, iso_report_agreement row, const char *a,
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

/* A program that failed by itself is refused from here on: one that hangs would take its time limit again. The others go on. */
static iso_status refuse_failed(iso_validation *v, size_t level, iso_report_agreement row, const char *a,
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
        return add_without_images(v, level, row, a, renderer, err);
    }
    if (iso_renderer_has(renderer, ISO_IS_OF_PICTURES)) { /* of which another one may be there */
        row.refused = why->text;
        return add_without_images(v, level, row, a, renderer, err);
    }
    *refusal = (iso_refusal){.status = status == ISO_E_MISSING ? status : ISO_E_UNTRUSTED};
    snprintf(refusal->why, sizeof refusal->why, "%.500s", why->text);
    row.refused = refusal->why;
    return add_without_images(v, level, row, a, renderer, err);
}

/* ---- truths ---- */

/* intervals: of a quadrature that has them. */
static iso_status render_reference(iso_validation *v, size_t level, iso_quadrature quadrature, size_t intervals,
                                   iso_direction_source source, iso_image *image, iso_error *err)
{
    iso_render_options opt = iso_render_defaults(iso_renderers_truth());
    iso_render_stats stats = {0};
    opt.quadrature = quadrature;
    opt.source = source;
    opt.intervals = intervals;
    opt.threads = v->threads;
    opt.stats = &stats;
    const iso_status status = iso_render_with(&(iso_render_request){&v->renderers, v->pyramid, level, v->view, &opt,
                                                                    v->progress},
                                              image, NULL, err);
    if (status == ISO_OK && stats.error > 0) {
        char name[96];
        name_image(v, level, iso_direction_source_name(source), name);
        iso_report_put(v->report, "reference", name,
                       json_pack("{s:f, s:b}", "error_bound", stats.error, "error_bound_is_proved",
                                 (int)stats.is_proved));
    }
    return status;
}

/* The reference itself is held to the formula. Its tolerance is 1e-6 a pixel, and images are float. */
static iso_status check_reference(iso_validation *v, size_t level, const truth *formula, iso_error *err)
{
    iso_image image = {0};
    iso_report_agreement row = {.comparison = ISO_COMPARISON_CLOSED_FORM,
                                .tier = iso_tier_name(ISO_TIER_CLOSED_FORM),
                                .error_bar = NAN,
                                .tolerances = {.max_abs = 5e-6},
                                .why = v->scene->agreement.why};
    iso_status status = render_reference(v, level, ISO_QUADRATURE_CONVERGED, 0, ISO_FROM_CODES, &image, err);
    if (status == ISO_OK)
        status = add_row(v, level, &row, formula, &(compared){"reference", &image, iso_renderers_truth(), "", 0}, err);
    iso_image_destroy(&image);
    return status;
}

static iso_status find_truths(iso_validation *v, size_t level, level_truths *t, iso_error *err)
{
    const bool formula = v->scene->agreement.tier == ISO_TIER_CLOSED_FORM;
    iso_status status;
    *t = (level_truths){.main = {.name = formula ? "closed form" : "reference"},
                        .exported = {.name = "reference, decoded"}};
    t->differ = !formula && exported_source(v) != ISO_FROM_CODES;
    begin_row(v, level, t->main.name);
    name_image(v, level, formula ? "closed-form" : "reference", t->main.image_name);
    name_image(v, level, "reference-decoded", t->exported.image_name);
    if (formula)
        status = iso_closed_form_render(&v->pyramid->levels[level], v->pyramid->options.code, v->view, &t->main.image,
                                        err);
    else
        status = render_reference(v, level, ISO_QUADRATURE_CONVERGED, 0, ISO_FROM_CODES, &t->main.image, err);
    if (status == ISO_OK)
        status = add_image(v, t->main.image_name, &t->main.image, t->main.name, err);
    if (status == ISO_OK && t->differ)
        status = render_reference(v, level, ISO_QUADRATURE_CONVERGED, 0, ISO_FROM_DECODED, &t->exported.image, err);
    if (status == ISO_OK && t->differ)
        status = add_image(v, t->exported.image_name, &t->exported.image, t->exported.name, err);
    return status == ISO_OK && formula ? check_reference(v, level, &t->main, err) : status;
}

/* ---- lock-step: the same samples ---- */

/* Where the TF is steep, or the usual lookups are out of their tolerances, a renderer that has exact lookups is compared
 * once more without what the usual ones round: what is left then is held to narrower tolerances than smooth TFs are.
 * *holds: it is within them. */
static iso_status exact_lock_step(iso_validation *v, size_t level, const truth *same, iso_render_options opt,
                                  bool *holds, iso_error *err)
{
    const iso_renderer_info *renderer = opt.renderer;
    iso_image image = {0};
    char what[64];
    iso_report_agreement row = {.comparison = ISO_COMPARISON_EXACT,
                                .tier = "lock-step",
                                .error_bar = NAN,
                                .tolerances = exact_lock_step_tolerances(renderer),
                                .why = renderer->lock_step->exact_why};
    snprintf(what, sizeof what, "%s-lockstep-exact", renderer->name);
    begin_row(v, level, what);
    opt.exact_lookups = true;
    iso_status status = iso_render_with(&(iso_render_request){&v->renderers, v->pyramid, level, v->view, &opt,
                                                              v->progress},
                                        &image, NULL, err);
    if (status == ISO_OK)
        status = add_row(v, level, &row, same, &(compared){what, &image, renderer, " --exact-lookups", 0}, err);
    *holds = status == ISO_OK && iso_metrics_within(&row.metrics, &row.tolerances);
    iso_image_destroy(&image);
    return status;
}

/* The row of the usual lookups, and where it is asked for that of exact ones: where the usual ones are out of their
 * tolerances the exact ones come first, because they tell rounding from a fault. */
static iso_status add_lock_step(iso_validation *v, size_t level, iso_report_agreement *row, const truth *same,
                                const compared *with, const iso_render_options *opt, iso_error *err)
{
    const iso_lock_step *lock = with->renderer->lock_step;
    const bool has_exact = lock->exact.max_abs > 0;
    const double start = v->row_start;
    iso_metrics seen = {0};
    bool holds = false;
    iso_status status = iso_metrics_measure(&same->image, with->image, &seen, err);
    const bool first = has_exact && !iso_metrics_within(&seen, &row->tolerances);
    if (status == ISO_OK && first)
        status = exact_lock_step(v, level, same, *opt, &holds, err);
    v->row_start = start;
    if (holds) {
        row->tolerances = (iso_tolerances){.rmse = lock->rounded.rmse, .max_abs = lock->rounded.max_abs};
        row->why = lock->rounded_why;
    }
    if (status == ISO_OK)
        status = add_row(v, level, row, same, with, err);
    if (status == ISO_OK && has_exact && !first && v->scene->agreement.sharp)
        status = exact_lock_step(v, level, same, *opt, &holds, err);
    return status;
}

/* What is rounded to 8 bits is compared where the reference shows ten times what that leaves: a hundred times would be more
 * than most scenes show. */
enum { STATED_SIGNAL = 10 };

static iso_status lock_step(iso_validation *v, size_t level, const iso_renderer_info *renderer, iso_error *err)
{
    const iso_lock_step *lock = renderer->lock_step;
    const bool exported = iso_renderer_has(renderer, ISO_IS_PROGRAM),
               stated = lock->quadrature == ISO_QUADRATURE_CONVERGED;
    truth same = {.name = stated ? "reference" : "reference, same samples"};
    char what[64], reference[80], options[64] = "", why[512];
    iso_image image = {0};
    iso_error failure = {""};
    iso_render_options opt = iso_render_defaults(renderer);
    iso_report_agreement row = {.comparison = stated ? ISO_COMPARISON_STATED : ISO_COMPARISON_LOCK_STEP,
                                .tier = stated ? "stated limits" : "lock-step",
                                .error_bar = NAN,
                                .why = lock->why,
                                .tolerances = iso_validate_lock_step(renderer, v->view, v->scene->agreement.sharp)};
    if (cannot_compare(v, renderer, &row, why))
        return add_without_images(v, level, row, same.name, renderer, err);
    snprintf(what, sizeof what, stated ? "%s-stated" : "%s-lockstep", renderer->name);
    begin_row(v, level, what);
    opt.threads = v->threads;
    opt.source = exported ? ISO_FROM_CODES : v->source;
    opt.intervals = lock->intervals;
    if (lock->intervals)
        snprintf(options, sizeof options, " --intervals %zu", lock->intervals);
    snprintf(reference, sizeof reference, "reference-%s", what);
    name_image(v, level, reference, same.image_name);
    iso_status status = render_reference(v, level, lock->quadrature, lock->intervals,
                                         exported ? exported_source(v) : v->source, &same.image, err);
    if (status == ISO_OK && renderer->output.most > 0 && iso_image_clip(&same.image, (float)renderer->output.most))
        same.name = stated ? "reference, clipped" : "reference, same samples, clipped";
    if (status == ISO_OK)
        status = add_image(v, same.image_name, &same.image, same.name, err);
    const bool begun = status == ISO_OK;
    if (begun)
        status = iso_render_with(&(iso_render_request){&v->renderers, v->pyramid, level, v->view, &opt, v->progress},
                                 &image, NULL, &failure);
    if (begun && status != ISO_OK)
        status = refuse_failed(v, level, row, same.name, renderer, status, &failure, err);
    else if (status == ISO_OK)
        status = add_lock_step(v, level, &row, &same,
                               &(compared){what, &image, renderer, options,
                                           stated ? row.tolerances.rmse * STATED_SIGNAL / ISO_SIGNAL_FACTOR : 0},
                               &opt, err);
    iso_image_destroy(&same.image);
    iso_image_destroy(&image);
    return status;
}

/* ---- extrapolated limits ---- */

/* A limit that stays until the versions of its program are compared. */
typedef struct version_limit {
    iso_version_limit about;
    iso_extrapolated limit;
} version_limit;

/* Takes the limit. */
static void keep_limit(const iso_validation *v, size_t level, const iso_renderer_info *renderer, iso_extrapolated *limit,
                       const compared *with, version_limit *kept)
{
    kept->limit = *limit;
    *limit = (iso_extrapolated){0};
    kept->about = (iso_version_limit){.renderer = renderer, .limit = &kept->limit};
    name_image(v, level, with->what, kept->about.image_name);
    snprintf(kept->about.options, sizeof kept->about.options, "%s", with->options);
}

/* kept: takes the limit, if it is compared; or NULL. */
static iso_status compare_limit(iso_validation *v, size_t level, const iso_renderer_info *renderer,
                                const level_truths *t, version_limit *kept, iso_error *err)
{
    const truth *a = t->differ && iso_renderer_has(renderer, ISO_IS_PROGRAM) ? &t->exported : &t->main;
    const iso_scene_agreement *asked = &v->scene->agreement;
    char what[64], options[64], why[512];
    iso_extrapolated limit = {0};
    iso_report_agreement row = {.comparison = ISO_COMPARISON_LIMIT,
                                .tier = iso_tier_name(asked->tier == ISO_TIER_TIGHT ? ISO_TIER_CONVERGENCE
                                                                                    : asked->tier),
                                .why = asked->why};
    if (cannot_compare(v, renderer, &row, why))
        return add_without_images(v, level, row, a->name, renderer, err);
    snprintf(what, sizeof what, "%s-limit", renderer->name);
    begin_row(v, level, what);
    iso_limit_options opt = iso_validate_limit_options(asked, renderer, v->seeds, v->threads);
    iso_render_options reference = iso_render_defaults(iso_renderers_truth());
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
        return refuse_failed(v, level, row, a->name, renderer, status, &failure, err);
    if (limit.unfinished) {
        snprintf(why, sizeof why, "the budget of %g s was over at a step of %g voxel: the error bar is %.2g, the RMSE %.2g",
                 v->budget_seconds, limit.step_voxels, limit.bar, limit.rmse);
        row.uncompared = ISO_UNCOMPARED_BUDGET;
        row.uncompared_why = why;
        iso_extrapolated_destroy(&limit);
        return add_without_images(v, level, row, a->name, renderer, err);
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
    status = add_row(v, level, &row, a,
                     &(compared){what, &limit.image, renderer, options, iso_extrapolated_held_to(&limit)}, err);
    json_decref(row.statistics);
    if (kept && status == ISO_OK)
        keep_limit(v, level, renderer, &limit, &(compared){.what = what, .options = options}, kept);
    iso_extrapolated_destroy(&limit);
    return status;
}

/* Every wanted renderer that has a limit; then what differs between versions of one. */
static iso_status compare_limits(iso_validation *v, size_t level, const level_truths *t, iso_error *err)
{
    version_limit kept[ISO_MAX_RENDERERS] = {{.about.renderer = NULL}};
    iso_status status = ISO_OK;
    for (size_t i = 0; i < iso_renderer_count() && status == ISO_OK; ++i) {
        const iso_renderer_info *renderer = iso_renderer_at(i);
        if (v->wanted[i] && iso_renderer_has(renderer, ISO_HAS_LIMIT))
            status = compare_limit(v, level, renderer, t, iso_validate_has_versions(v, renderer) ? &kept[i] : NULL, err);
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

/* ---- first hits ---- */

static iso_status first_hits(iso_validation *v, size_t level, iso_error *err)
{
    const iso_level *l0 = &v->pyramid->levels[0];
    truth a = {.name = "reference, first hit"};
    iso_render_options opt = iso_render_defaults(iso_renderers_truth());
    char options[64], why[512];
    opt.isosurface = true;
    opt.iso = l0->min + v->scene->suite_isosurface * (l0->max - l0->min);
    opt.threads = v->threads;
    opt.source = exported_source(v);
    name_image(v, level, "reference", a.image_name);
    begin_row(v, level, a.name);
    iso_status status = iso_render_with(&(iso_render_request){&v->renderers, v->pyramid, level, v->view, &opt,
                                                              v->progress},
                                        &a.image, NULL, err);
    if (status == ISO_OK)
        status = add_image(v, a.image_name, &a.image, a.name, err);
    snprintf(options, sizeof options, " --isosurface %.9g", opt.iso);
    for (size_t i = 0; i < iso_renderer_count() && status == ISO_OK; ++i) {
        iso_image image = {0};
        /* A ray that grazes the surface hits it in one arithmetic and misses it in another: a few pixels may. */
        const iso_renderer_info *renderer = iso_renderer_at(i);
        iso_report_agreement row = {.comparison = ISO_COMPARISON_FIRST_HIT,
                                    .tier = iso_tier_name(ISO_TIER_FIRST_HIT),
                                    .error_bar = NAN,
                                    .tolerances = {.rmse = 5e-3, .p99_abs = 2e-4},
                                    .why = v->scene->agreement.why};
        if (renderer == iso_renderers_truth() || !v->wanted[i])
            continue;
        if (cannot_compare(v, renderer, &row, why)) {
            status = add_without_images(v, level, row, a.name, renderer, err);
            continue;
        }
        iso_error failure = {""};
        opt.renderer = renderer;
        begin_row(v, level, renderer->name);
        status = iso_render_with(&(iso_render_request){&v->renderers, v->pyramid, level, v->view, &opt, v->progress},
                                 &image, NULL, &failure);
        if (status != ISO_OK)
            status = refuse_failed(v, level, row, a.name, renderer, status, &failure, err);
        else
            status = add_row(v, level, &row, &a, &(compared){renderer->name, &image, renderer, options, 0}, err);
        iso_image_destroy(&image);
    }
    iso_image_destroy(&a.image);
    return status;
}

/* Is it asked, in this row's directions and transfer function? Pictures that were made elsewhere are of the scene's own. */
static bool takes_part(const iso_validation *v, size_t i, bool programs)
{
    const iso_renderer_info *renderer = iso_renderer_at(i);
    return v->wanted[i] && (programs || !iso_renderer_has(renderer, ISO_IS_PROGRAM)) &&
           !(v->variant[0] && iso_renderer_has(renderer, ISO_IS_OF_PICTURES));
}

/* Every wanted renderer whose samples are known, but for programs where only those of this process are asked. */
static iso_status lock_steps(iso_validation *v, size_t level, bool programs, iso_error *err)
{
    iso_status status = ISO_OK;
    for (size_t i = 0; i < iso_renderer_count() && status == ISO_OK; ++i) {
        if (iso_renderer_at(i)->lock_step && takes_part(v, i, programs))
            status = lock_step(v, level, iso_renderer_at(i), err);
    }
    return status;
}

/* Limits take most of the time: so many pixels as they need, at several steps each. */
static iso_status limits_at(iso_validation *v, size_t level, iso_error *err)
{
    const iso_view *whole = v->view, small = iso_validate_small_view(whole, v->limit_size);
    level_truths t = {.differ = false};
    v->view = &small;
    t.main.name = t.exported.name = "reference";
    iso_status status = iso_validate_is_out_of_time(v) ? ISO_OK : find_truths(v, level, &t, err);
    if (status == ISO_OK)
        status = compare_limits(v, level, &t, err);
    v->view = whole;
    iso_image_destroy(&t.main.image);
    iso_image_destroy(&t.exported.image);
    return status;
}

static iso_status agree_at(iso_validation *v, size_t level, void *unused, iso_error *err)
{
    (void)unused;
    v->renderers.scene = v->scene_name;
    const bool samples = v->agreement_part != ISO_VALIDATE_LIMITS, limits = v->agreement_part != ISO_VALIDATE_SAMPLES;
    if (v->scene->agreement.tier == ISO_TIER_FIRST_HIT)
        return samples ? first_hits(v, level, err) : ISO_OK;
    const iso_status status = samples ? lock_steps(v, level, true, err) : ISO_OK;
    return status == ISO_OK && limits ? limits_at(v, level, err) : status;
}

/* By the same samples where they are known, and only else by the limit, which takes many times as long. */
iso_status iso_validate_variant(iso_validation *v, size_t level, iso_error *err)
{
    /* At level 0 all filters store the same directions. */
    const bool programs = v->source == ISO_FROM_CODES && level > 0 && !v->quick;
    level_truths t = {.differ = false};
    iso_status status = lock_steps(v, level, programs, err);
    for (size_t i = 0; i < iso_renderer_count() && status == ISO_OK; ++i) {
        const iso_renderer_info *renderer = iso_renderer_at(i);
        if (renderer->lock_step || !iso_renderer_has(renderer, ISO_HAS_LIMIT) || !takes_part(v, i, programs))
            continue;
        t.main.name = t.exported.name = "reference";
        if (!t.main.image.rgba && !iso_validate_is_out_of_time(v))
            status = find_truths(v, level, &t, err);
        if (status == ISO_OK)
            status = compare_limit(v, level, renderer, &t, NULL, err);
    }
    iso_image_destroy(&t.main.image);
    iso_image_destroy(&t.exported.image);
    return status;
}

iso_status iso_validate_agreement(iso_validation *v, iso_error *err)
{
    return iso_validate_each(v, v->pyramid->level_count, agree_at, NULL, err);
}

/* SPDX-License-Identifier: MIT */
/* forecast.c - what a validation will do and about how long it takes: the layout of its job (base/job.h).
 *
 * Costs are seconds that a part had two cores of a Xeon of 2.6 GHz for itself, with volumes of 41 to 256 voxels along an
 * axis and pictures of 64 to 256 pixels: `estimate.parts` of a report has them beside what was taken. How fast this
 * machine is, and how far each renderer is from its cost, is learned as rows end; how fine a limit's steps will be, from
 * the limits that are known. A row that is refused, or that nobody foresaw, changes nothing but the estimate. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "targets/targets.h"
#include "validate/calibrate.h"
#include "validate/limits.h"
#include "validate/measured.h"

/* Of a sample of the reference in lock-step. */
static const double REFERENCE_SAMPLE_SECONDS = 1.2e-8;

/* Voxels along the longest axis of a level. */
static double voxels_across(const iso_validation *v, size_t level)
{
    const size_t *n = v->pyramid->levels[level].geometry.size;
    return fmax((double)n[0], fmax((double)n[1], (double)n[2]));
}

static double voxel_count(const iso_validation *v, size_t level)
{
    return (double)iso_geometry_voxel_count(&v->pyramid->levels[level].geometry);
}

/* Without a step. */
static double truth_seconds(double pixels, double across)
{
    return pixels * (1.2e-5 + 1.2e-7 * across);
}

/* The step is that of level 0 at every level, or there are so many intervals. */
static double lock_step_seconds(const iso_validation *v, const iso_renderer_info *r, size_t level, double pixels)
{
    const size_t intervals = r->lock_step->intervals;
    const double of_a_ray = intervals ? (double)intervals : voxels_across(v, 0) / v->view->step_voxels;
    return r->start_seconds + voxel_count(v, level) * ISO_LIMIT_VOXEL_SECONDS +
           pixels * of_a_ray * (r->sample_seconds + REFERENCE_SAMPLE_SECONDS);
}

static iso_limit_options limit_options(const iso_validation *v, const iso_renderer_info *r)
{
    return iso_validate_limit_options(&v->scene->agreement, r, v->seeds, v->threads);
}

/* The step is halved until its error is small, once more for the coarser levels, less smooth from voxel to voxel. */
static double limit_seconds(const iso_validation *v, const iso_renderer_info *r, size_t level, double pixels)
{
    const iso_limit_options opt = limit_options(v, r);
    return iso_limit_seconds(&v->pyramid->levels[level], r, &opt, pixels,
                             v->scene->agreement.sharp ? 1.0 / 16 : level == 0 ? 1.0 / 8 : 1.0 / 16);
}

void iso_validate_name_version(char *text, size_t size, const iso_renderer_info *which)
{
    snprintf(text, size, "version: %s", which->name);
}

void iso_validate_name_checks(char *text, size_t size, const iso_renderer_info *which, const char *check)
{
    snprintf(text, size, "calibration: %s%s%s", which->name, check ? ", " : "", check ? check : "");
}

void iso_validate_name_row(char *text, size_t size, const char *variant, size_t level, const char *what)
{
    snprintf(text, size, "%s%slevel %zu: %s", variant, variant[0] ? ", " : "", level, what);
}

static void add_row(iso_job *job, const char *variant, size_t level, const char *what, const char *kind, double seconds)
{
    char name[160];
    iso_validate_name_row(name, sizeof name, variant, level, what);
    iso_job_add_part(job, name, kind, seconds);
}

/* Rows of a renderer and what they are of, as agreement.c calls them. */
static void add_lock_step(const iso_validation *v, iso_job *job, const char *variant, size_t level,
                          const iso_renderer_info *r, double pixels)
{
    char what[64];
    snprintf(what, sizeof what, "%s-lockstep", r->name);
    add_row(job, variant, level, what, what, lock_step_seconds(v, r, level, pixels));
}

static void name_limit(char *what, size_t size, const iso_renderer_info *r)
{
    snprintf(what, size, "%s-limit", r->name);
}

/* Kinds of limits are related: what makes the one of a volume slow makes others slow. */
static void add_limit(const iso_validation *v, iso_job *job, const char *variant, size_t level,
                      const iso_renderer_info *r, double pixels)
{
    char what[64], kind[64];
    name_limit(what, sizeof what, r);
    snprintf(kind, sizeof kind, "%s/%s", iso_renderer_has(r, ISO_IS_PROGRAM) ? "limit" : "frame", r->name);
    add_row(job, variant, level, what, kind, limit_seconds(v, r, level, pixels));
}

static void add_levels(const iso_validation *v, iso_job *job)
{
    iso_job_add_phase(job, "levels", 1);
    iso_job_add_lane(job);
    iso_job_add_part(job, "levels", "levels", v->loaded ? 3e-8 * voxel_count(v, 0) : 0);
}

/* A part for each check, or one for all by one start. */
static void add_checks(const iso_validation *v, iso_job *job, const iso_renderer_info *r)
{
    const bool apart = iso_validate_checks_apart(v, r);
    const double picture_seconds = iso_renderer_has(r, ISO_IS_PROGRAM) ? 0.08 : 0.005;
    char name[96];
    for (int check = 0; check < (apart ? ISO_CALIBRATION_COUNT : 1); ++check) {
        iso_validate_name_checks(name, sizeof name, r, apart ? iso_calibration_name(check) : NULL);
        iso_job_add_lane(job);
        iso_job_add_part(job, name, r->name,
                         r->start_seconds + (apart ? 1 : ISO_CALIBRATION_COUNT) * picture_seconds);
    }
}

static void add_calibrations(const iso_validation *v, iso_job *job)
{
    char name[64];
    size_t count = 0, parts = 0;
    for (size_t i = 0; i < iso_renderer_count(); ++i)
        if (v->wanted[i])
            ++count, parts += iso_validate_checks_apart(v, iso_renderer_at(i)) ? ISO_CALIBRATION_COUNT : 1;
    iso_job_add_phase(job, "calibration", iso_validate_workers(v, count));
    for (size_t i = 0; i < iso_renderer_count(); ++i) {
        if (!v->wanted[i])
            continue;
        iso_validate_name_version(name, sizeof name, iso_renderer_at(i));
        iso_job_add_lane(job);
        iso_job_add_part(job, name, "version", 0.3 * iso_renderer_at(i)->start_seconds);
    }
    iso_job_add_phase(job, "checks", iso_validate_workers(v, parts));
    for (size_t i = 0; i < iso_renderer_count(); ++i)
        if (v->wanted[i])
            add_checks(v, job, iso_renderer_at(i));
}

static void add_agreement(const iso_validation *v, iso_job *job)
{
    const iso_view limits = iso_validate_small_view(v->view, v->limit_size);
    const double pixels = (double)(v->view->width * v->view->height), few = (double)(limits.width * limits.height);
    iso_job_add_phase(job, "agreement", iso_validate_workers(v, v->pyramid->level_count));
    for (size_t level = 0; level < v->pyramid->level_count; ++level) {
        const double across = voxels_across(v, level);
        iso_job_add_lane(job);
        if (v->scene->agreement.tier == ISO_TIER_FIRST_HIT) {
            add_row(job, "", level, "reference, first hit", "truth", truth_seconds(pixels, across));
            continue;
        }
        const bool formula = v->scene->agreement.tier == ISO_TIER_CLOSED_FORM;
        for (size_t i = 0; i < iso_renderer_count(); ++i)
            if (v->wanted[i] && iso_renderer_at(i)->lock_step)
                add_lock_step(v, job, "", level, iso_renderer_at(i), pixels);
        add_row(job, "", level, formula ? "closed form" : "reference", "truth", truth_seconds(few, across));
        for (size_t i = 0; i < iso_renderer_count(); ++i)
            if (v->wanted[i] && iso_renderer_has(iso_renderer_at(i), ISO_HAS_LIMIT))
                add_limit(v, job, "", level, iso_renderer_at(i), few);
    }
}

/* Histograms of all voxels, and small views of each coarse level. */
static void add_adaptation(const iso_validation *v, iso_job *job)
{
    iso_job_add_phase(job, "adaptation", 1);
    iso_job_add_part(job, "adaptation", "adaptation",
                     0.02 * (double)(v->pyramid->level_count - 1) + 3.5e-8 * voxel_count(v, 0));
}

/* One transfer function of one method at a level: iso_validate_variant() has the same conditions. */
static void add_variant(const iso_validation *v, iso_job *job, const char *variant, size_t level, bool programs)
{
    const double pixels = ISO_VALIDATE_METHOD_PIXELS * ISO_VALIDATE_METHOD_PIXELS;
    bool has_truth = false;
    for (size_t i = 0; i < iso_renderer_count(); ++i) {
        const iso_renderer_info *r = iso_renderer_at(i);
        if (v->wanted[i] && r->lock_step && (programs || !iso_renderer_has(r, ISO_IS_PROGRAM)))
            add_lock_step(v, job, variant, level, r, pixels);
    }
    for (size_t i = 0; i < iso_renderer_count(); ++i) {
        const iso_renderer_info *r = iso_renderer_at(i);
        if (!v->wanted[i] || r->lock_step || !iso_renderer_has(r, ISO_HAS_LIMIT) ||
            (!programs && iso_renderer_has(r, ISO_IS_PROGRAM)))
            continue;
        if (!has_truth)
            add_row(job, variant, level, "reference", "truth", truth_seconds(pixels, voxels_across(v, level)));
        has_truth = true;
        add_limit(v, job, variant, level, r, pixels);
    }
}

/* What a method is shown by, as methods.c has it. Under the original transfer function the pyramid's own directions are
 * part of the agreement; level 0 has no other one. */
enum { ORIGINAL_TF, ADAPTED_TF, TF_COUNT = 5 };
static const char *const tfs[TF_COUNT] = {[ORIGINAL_TF] = "", [ADAPTED_TF] = ", adapted TF", ", extinction scale",
                                          ", 2D TF (deviation)", ", 2D TF (gradient)"};
static bool is_asked(size_t tf, size_t level, bool own)
{
    return tf == ORIGINAL_TF ? !own : level > 0 && (own || tf == ADAPTED_TF);
}

static void add_method(const iso_validation *v, iso_job *job, const iso_method *m)
{
    const bool own = m->source == ISO_FROM_CODES && m->filter == v->pyramid->options.direction_filter;
    iso_job_add_phase(job, m->name, iso_validate_workers(v, v->pyramid->level_count));
    for (size_t level = 0; level < v->pyramid->level_count; ++level) {
        iso_job_add_lane(job);
        for (size_t tf = 0; tf < TF_COUNT; ++tf) {
            char variant[64];
            snprintf(variant, sizeof variant, "%s%s", m->name, tfs[tf]);
            if (is_asked(tf, level, own))
                add_variant(v, job, variant, level, m->source == ISO_FROM_CODES && level > 0 && !v->quick);
        }
    }
}

/* A level in so many views, under either transfer function: to draw it, and to compare what was drawn. */
static double views_seconds(const iso_validation *v, double views)
{
    return (double)(v->consistency_size * v->consistency_size) * views * 3e-6;
}

/* Levels that the views leave open: the finest in twenty views, and each of these levels by two methods. Which these
 * are is known when all else is measured; until then it is taken to be one of three. */
static void add_more_views(const iso_validation *v, iso_job *job)
{
    const double chance = 1.0 / 3;
    for (size_t level = 0; level < v->pyramid->level_count; ++level) {
        char name[64];
        snprintf(name, sizeof name, "consistency: more views, level %zu", level);
        iso_job_add_part(job, name, "more views",
                         chance * views_seconds(v, (level == 0 ? 0.5 : 1) * ISO_FACE_VIEWS));
    }
}

/* Pictures, and what is made of all voxels: levels of another filter, and angles. Then the bounds, by their points. */
static void add_consistency(const iso_validation *v, iso_job *job)
{
    const double voxels = voxel_count(v, 0);
    iso_job_add_phase(job, "consistency", 1);
    iso_job_add_lane(job);
    const iso_direction_filter own = v->pyramid->options.direction_filter;
    const char *more[] = {iso_direction_filter_name(own), "tensor"}; /* consistency.c has both for auto */
    const size_t more_count = own == ISO_DIRECTION_AUTO ? 2 : own == ISO_DIRECTION_TENSOR;
    iso_job_add_part(job, "consistency: views, level 0", "consistency",
                     views_seconds(v, 0.5 * (double)v->consistency_views) + 4e-8 * voxels);
    for (size_t i = 0; i < iso_method_count + more_count; ++i)
        for (size_t level = 1; level < v->pyramid->level_count; ++level) {
            char name[64];
            snprintf(name, sizeof name, "consistency: %s, level %zu",
                     i < iso_method_count ? iso_methods[i].name : more[i - iso_method_count], level);
            iso_job_add_part(job, name, "consistency",
                             views_seconds(v, (double)v->consistency_views) + 1.1e-8 * voxels);
        }
    if (v->pyramid->level_count > 1 && iso_validate_may_add_views(v))
        add_more_views(v, job);
    iso_job_add_part(job, "consistency: verdict", "verdict",
                     2.5e-7 * (double)(v->pyramid->level_count - 1) * iso_validate_bound_points(v));
}

/* Two runs of each program, small. */
static void add_artefacts(const iso_validation *v, iso_job *job)
{
    char name[64];
    iso_job_add_phase(job, "artefacts", 1);
    iso_job_add_lane(job);
    for (size_t i = 0; i < iso_export_target_names.count; ++i) {
        const iso_export_target *target = iso_export_target_at(i);
        for (size_t r = 0; target->open && r < iso_renderer_count(); ++r) {
            if (!v->wanted[r] || strcmp(iso_renderer_at(r)->name, target->renderer) != 0)
                continue;
            snprintf(name, sizeof name, "artefacts: %s", target->name);
            iso_job_add_part(job, name, "artefacts", 2.2 * iso_renderer_at(r)->start_seconds);
        }
    }
}

static void add_report(iso_job *job)
{
    iso_job_add_phase(job, "report", 1);
    iso_job_add_part(job, "report", "report", 0.2);
}

void iso_validate_forecast(const iso_validation *v)
{
    iso_job *job = iso_progress_line_lock(v->line);
    if (job) {
        add_levels(v, job);
        add_calibrations(v, job);
        add_agreement(v, job);
        add_adaptation(v, job);
        for (size_t i = 0; i < iso_method_count; ++i)
            add_method(v, job, &iso_methods[i]);
        add_consistency(v, job);
        add_artefacts(v, job);
        add_report(job);
    }
    iso_progress_line_unlock(v->line);
}

void iso_validate_foresee_limits(const iso_validation *v, size_t level, const iso_renderer_info *by,
                                 const iso_extrapolated *known)
{
    const double pixels = (double)(v->view->width * v->view->height),
                 few = ISO_VALIDATE_METHOD_PIXELS * ISO_VALIDATE_METHOD_PIXELS;
    iso_job *job = iso_progress_line_lock(v->line);
    for (size_t i = 0; job && i < iso_renderer_count(); ++i) {
        const iso_renderer_info *r = iso_renderer_at(i);
        char what[64], name[160];
        if (!v->wanted[i] || !iso_renderer_has(r, ISO_HAS_LIMIT))
            continue;
        const iso_limit_options opt = limit_options(v, r);
        const double last = r == by ? known->step_voxels : iso_limit_foresee_step(known, &opt);
        name_limit(what, sizeof what, r);
        iso_validate_name_row(name, sizeof name, "", level, what);
        iso_job_foresee(job, name, false, iso_limit_seconds(&v->pyramid->levels[level], r, &opt, pixels, last));
        iso_job_foresee(job, name, true, iso_limit_seconds(&v->pyramid->levels[level], r, &opt, few, last));
    }
    iso_progress_line_unlock(v->line);
}

/* Small volumes: about so many samples of each pixel by each renderer, which is started less than once a scene. */
static double scene_seconds(const iso_validation *v, double pixels)
{
    const double samples = 800;
    double seconds = 0.1;
    for (size_t i = 0; i < iso_renderer_count(); ++i) {
        const iso_renderer_info *r = iso_renderer_at(i);
        seconds += v->wanted[i] ? 0.9 * r->start_seconds + pixels * samples * r->sample_seconds : 0;
    }
    return seconds;
}

void iso_validate_forecast_scenes(const iso_validation *v, char (*stages)[100], size_t count, double pixels)
{
    iso_job *job = iso_progress_line_lock(v->line);
    if (job) {
        add_calibrations(v, job);
        iso_job_add_phase(job, "scenes", iso_validate_workers(v, count));
        for (size_t i = 0; i < count; ++i) {
            iso_job_add_lane(job);
            iso_job_add_part(job, stages[i], "scene", scene_seconds(v, pixels));
        }
        add_report(job);
    }
    iso_progress_line_unlock(v->line);
}

/* SPDX-License-Identifier: MIT */
#include "validate/artefact.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/file.h"
#include "base/process.h"
#include "scene/level_view.h"

enum { MOST_PIXELS = 64 }; /* along a side of the picture in a report */

/* ---- an export that moves ---- */

/* Copies a view with its table. Validation has neither 2D transfer functions nor extinction scales nor regions of
 * interest. */
static iso_status copy_view(const iso_view *from, iso_view *to, iso_error *err)
{
    const size_t bytes = from->tf.count * 4 * sizeof(float);
    *to = *from;
    to->tf_2d = NULL;
    to->extinction_scale = NULL;
    to->roi = NULL;
    to->tf.entries = malloc(bytes);
    NEED_MEMORY(to->tf.entries, err, "no memory for a transfer function");
    memcpy(to->tf.entries, from->tf.entries, bytes);
    return ISO_OK;
}

static iso_status view_of_level(const iso_export_job *job, size_t level, iso_view *view, iso_error *err)
{
    const iso_level *l = &job->pyramid->levels[level];
    const iso_status status = copy_view(job->user, view, err);
    return status == ISO_OK && l->geometry.has_no_data ? iso_view_take_scale(view, l, err) : status;
}

static iso_status export_and_open(const iso_artefact *a, const char *here, const char *there, iso_image *picture,
                                  const iso_progress *progress, iso_error *err)
{
    OWNED(iso_view) view = {0};
    NEED(copy_view(a->planted_view ? a->planted_view : a->view, &view, err));
    FREED char *first = iso_path_join(here, a->target->example), *moved = iso_path_join(there, a->target->example);
    const iso_export_job job = {.pyramid = a->pyramid,
                                .level = a->level,
                                .level_count = 1,
                                .output = first,
                                .view = &view,
                                .threads = a->threads,
                                .progress = progress,
                                .view_of_level = view_of_level,
                                .user = &view};
    if (!(first && moved))
        return iso_fail(err, ISO_E_MEMORY, "out of memory");
    NEED(a->target->write(&job, err));
    if (a->tamper)
        a->tamper(first);
    if (rename(here, there) != 0)
        return iso_fail(err, ISO_E_IO, "%s: cannot be moved to %s", here, there);
    return a->target->open(moved, picture, err);
}

/* ---- expected picture ---- */

static iso_status render_expected(iso_renderers *renderers, const iso_artefact *a, iso_image *image,
                                  const iso_progress *progress, iso_error *err)
{
    const iso_lock_step *lock = a->renderer->lock_step;
    iso_render_options opt = iso_render_defaults(lock ? iso_renderers_reference() : a->renderer);
    if (lock) {
        opt.quadrature = lock->quadrature;
        opt.source = iso_code_describe(a->pyramid->options.code)->is_linear ? ISO_FROM_CODES : ISO_FROM_DECODED;
    }
    if (a->target->samples)
        a->target->samples(&a->pyramid->levels[a->level].geometry, a->view, a->view->step_voxels, &opt.intervals,
                           &opt.planes);
    else
        opt.step_voxels = a->view->step_voxels;
    opt.threads = a->threads;
    return iso_render_with(&(iso_render_request){renderers, a->pyramid, a->level, a->view, &opt, progress}, image, NULL,
                           err);
}

iso_status iso_artefact_compare(iso_renderers *renderers, const iso_artefact *a, iso_artefact_result *out,
                                const iso_progress *progress, iso_error *err)
{
    iso_error failed = {""};
    FREED char *base = iso_make_temp_dir(), *here = base ? iso_path_join(base, "here") : NULL,
               *there = base ? iso_path_join(base, "there") : NULL;
    *out = (iso_artefact_result){.value = NAN,
                                 .limit = a->target->limit,
                                 .unit = "RMSE"};
    snprintf(out->why, sizeof out->why, "%s", a->target->why);
    iso_status status = here && there
                            ? (mkdir(here, 0777) == 0 ? ISO_OK : iso_fail(err, ISO_E_IO, "%s: cannot be made", here))
                            : iso_fail(err, ISO_E_IO, "no folder for an export");
    TRY(status, render_expected(renderers, a, &out->expected, progress, err));
    if (status == ISO_OK) {
        status = out->failure = export_and_open(a, here, there, &out->picture, progress, &failed);
        if (status == ISO_OK &&
            (out->picture.width != out->expected.width || out->picture.height != out->expected.height))
            snprintf(out->why, sizeof out->why, "the picture has %zu x %zu pixels instead of %zu x %zu",
                     out->picture.width, out->picture.height, out->expected.width, out->expected.height);
        else if (status == ISO_OK)
            out->value = iso_metrics_rmse_of_colors(&out->expected, &out->picture, /* pictures for people are opaque */
                                                    a->target->clipped ? 1 : INFINITY);
        else if (status == ISO_E_MEMORY)
            iso_fail(err, status, "%s", failed.text);
        else
            snprintf(out->why, sizeof out->why, "%.500s", failed.text);
        status = status == ISO_E_MEMORY ? status : ISO_OK;
    }
    if (base)
        iso_remove_tree(base);
    return status;
}

void iso_artefact_release(iso_artefact_result *result)
{
    iso_image_destroy(&result->expected);
    iso_image_destroy(&result->picture);
}

/* ---- the stage ---- */

/* Returns the renderer that shows the target's exports, if it is compared at all. */
static const iso_renderer_info *renderer_of(const iso_validation *v, const iso_export_target *target)
{
    for (size_t i = 0; target->open && i < iso_renderer_count(); ++i)
        if (strcmp(iso_renderer_at(i)->name, target->renderer) == 0 && v->wanted[i] && v->refused[i].status == ISO_OK)
            return iso_renderer_at(i);
    return NULL;
}

static iso_status add_image(iso_validation *v, const iso_artefact *a, const char *what, const iso_image *image,
                            iso_error *err)
{
    char name[64], caption[128];
    snprintf(name, sizeof name, "artefact-%s-%s", a->target->name, what);
    snprintf(caption, sizeof caption, "what %s shows of an export: %s", a->target->title, what);
    return image->rgba ? iso_report_add_image(v->report, name, image, caption, err) : ISO_OK;
}

static iso_status add_result(iso_validation *v, const iso_artefact *a, const iso_artefact_result *r, iso_error *err)
{
    const iso_report_calibration row = {.renderer = a->renderer->name,
                                        .check = "what is exported",
                                        .value = r->value,
                                        .limit = r->limit,
                                        .unit = r->unit,
                                        .detail = r->why};
    iso_status status = add_image(v, a, "expected", &r->expected, err);
    TRY(status, add_image(v, a, "picture", &r->picture, err));
    return status == ISO_OK ? iso_report_add_calibration(v->report, &row, err) : status;
}

/* Compares an export with the validated picture. *late: the budget ended the program, which proves nothing about the
 * export. */
static iso_status examine(iso_validation *v, const iso_artefact *a, bool *late, iso_error *err)
{
    iso_artefact_result r;
    char text[64];
    snprintf(text, sizeof text, "artefacts: %s", a->target->name);
    iso_progress_report(v->progress, text, 0);
    iso_status status = iso_artefact_compare(&v->renderers, a, &r, v->progress, err);
    if (status == ISO_OK && r.failure != ISO_OK && iso_process_was_stopped())
        status = iso_fail(err, r.failure, "artefacts: %s", r.why);
    *late = status == ISO_OK && r.failure != ISO_OK && iso_validate_is_out_of_time(v);
    if (status == ISO_OK && !*late)
        status = add_result(v, a, &r, err);
    iso_artefact_release(&r);
    return status;
}

/* Uses a small picture of the coarsest level: the faults to find are in every pixel. */
iso_status iso_validate_artefacts(iso_validation *v, iso_error *err)
{
    iso_view view = *v->view;
    const size_t longest = view.width > view.height ? view.width : view.height;
    iso_status status = ISO_OK;
    bool asked = false, late = false;
    const iso_level *coarsest = &v->pyramid->levels[v->pyramid->level_count - 1];
    if (coarsest->geometry.has_no_data)
        view.extinction_scale = coarsest->scale;
    for (size_t i = 0; i < iso_export_target_names.count; ++i)
        asked = asked || renderer_of(v, iso_export_target_at(i));
    if (asked && v->scene->agreement.tier == ISO_TIER_FIRST_HIT)
        return iso_validate_stage_not_run(v, "artefacts",
                                          "exports of volumes are opened, the scene asks for first hits", err);
    if (longest > MOST_PIXELS) {
        view.width = (view.width * MOST_PIXELS + longest - 1) / longest;
        view.height = (view.height * MOST_PIXELS + longest - 1) / longest;
    }
    for (size_t i = 0; i < iso_export_target_names.count && status == ISO_OK; ++i) {
        const iso_export_target *target = iso_export_target_at(i);
        const iso_artefact a = {.target = target,
                                .renderer = renderer_of(v, target),
                                .pyramid = v->pyramid,
                                .level = v->pyramid->level_count - 1,
                                .view = &view,
                                .threads = v->threads};
        late = a.renderer && iso_validate_is_out_of_time(v);
        if (a.renderer && !late)
            status = examine(v, &a, &late, err);
        if (late)
            return iso_validate_stage_left_out(v, "artefacts", err);
    }
    return status;
}

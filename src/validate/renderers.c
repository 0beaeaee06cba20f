/* SPDX-License-Identifier: MIT */
/* renderers.c - which renderers answer, and which may be trusted. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/process.h"
#include "renderers/picture_store.h"
#include "renderers/pictures.h"
#include "validate/calibrate.h"
#include "validate/mistakes.h"
#include "validate/validate.h"

/* Start of the reason of a missing one. */
#define MISSING "missing: "

/* Results of one renderer. */
typedef struct fitness {
    const iso_renderer_info *which;
    char version[320];
    iso_calibration checks[ISO_CALIBRATION_COUNT];
    size_t check_count;
    iso_status failure; /* ISO_OK: it answered all; ISO_E_MISSING; ISO_E_UNTRUSTED: it failed itself */
    char why[512];
} fitness;

/* One check of a renderer, or all by one start. */
enum { ALL_CHECKS = -1 };
typedef struct examination {
    fitness *of;
    int check;
    double part; /* of all examinations */
    iso_status status;
    iso_error why;
} examination;

/* Refuses a renderer that fails itself, with the check in which it did. */
static iso_status note_failure(fitness *f, iso_status status, const iso_error *why, iso_error *err)
{
    if (status == ISO_E_MISSING) {
        snprintf(f->why, sizeof f->why, MISSING "%.500s", why->text);
        snprintf(f->version, sizeof f->version, "missing");
        f->check_count = 0;
    } else if (!iso_validate_is_its_fault(f->which, status)) {
        return iso_fail(err, status, "%s", why->text);
    } else {
        snprintf(f->why, sizeof f->why, "%.500s", why->text);
    }
    f->failure = status == ISO_E_MISSING ? status : ISO_E_UNTRUSTED;
    return ISO_OK;
}

static iso_status ask_version(iso_validation *v, size_t part, void *user, iso_error *err)
{
    fitness *f = (fitness *)user + part;
    char stage[64];
    iso_error why = {""};
    snprintf(stage, sizeof stage, "version: %s", f->which->name);
    iso_progress_report(v->progress, stage, 0);
    const iso_status status = f->which->version(f->which, &v->renderers, f->version, sizeof f->version, &why);
    if (status == ISO_OK)
        iso_picture_store_set_version(v->renderers.store, f->which, f->version);
    return status == ISO_OK ? ISO_OK : note_failure(f, status, &why, err);
}

/* Leaves out the missing ones that nobody named. Returns whether the default renderer is among them. */
static bool leave_out_missing(iso_validation *v, fitness *all, size_t *count)
{
    bool lacks_usual = false;
    size_t kept = 0;
    for (size_t i = 0; i < *count; ++i) {
        const size_t place = iso_renderer_index(all[i].which);
        if (!v->may_lack || all[i].failure != ISO_E_MISSING || iso_renderer_has(all[i].which, ISO_IS_OF_PICTURES)) {
            all[kept++] = all[i];
            continue;
        }
        v->wanted[place] = false;
        snprintf(v->refused[place].why, sizeof v->refused[place].why, "%s", all[i].why);
        iso_report_put(v->report, "left_out", all[i].which->name, json_string(all[i].why + strlen(MISSING)));
        lacks_usual = lacks_usual || all[i].which == iso_renderers_usual();
    }
    *count = kept;
    return lacks_usual;
}

/* Asks the wanted renderers for their versions. */
static iso_status find_renderers(iso_validation *v, fitness *all, size_t *count, iso_error *err)
{
    for (size_t i = 0; i < iso_renderer_count(); ++i)
        if (v->wanted[i])
            all[(*count)++] = (fitness){.which = iso_renderer_at(i)};
    iso_status status = iso_validate_each(v, *count, ask_version, all, err);
    const iso_renderer_info *instead = iso_renderers_instead();
    if (status == ISO_OK && leave_out_missing(v, all, count) && !v->wanted[iso_renderer_index(instead)]) {
        v->wanted[iso_renderer_index(instead)] = true;
        all[*count] = (fitness){.which = instead};
        status = ask_version(v, (*count)++, all, err);
    }
    return status;
}

/* True if the checks of a renderer run at the same time, each by a start of its own, because that ends sooner. */
static bool are_apart(const iso_validation *v, const iso_renderer_info *which)
{
    return iso_renderer_has(which, ISO_WAITS_BETWEEN) && iso_validate_workers(v, ISO_CALIBRATION_COUNT) > 1;
}

static iso_status examine(iso_validation *v, size_t part, void *user, iso_error *err)
{
    examination *e = (examination *)user + part;
    const iso_renderer_info *which = e->of->which;
    char stage[96];
    const bool all = e->check == ALL_CHECKS;
    snprintf(stage, sizeof stage, "calibration: %s%s%s", which->name, all ? "" : ", ",
             all ? "" : iso_calibration_name(e->check));
    iso_progress_report(v->progress, stage, 0);
    if (all)
        e->status = iso_calibrate(&v->renderers, which, NULL, e->of->checks, &e->of->check_count, &e->why);
    else
        e->status = iso_calibrate_check(&v->renderers, which, NULL, e->check, &e->of->checks[e->check], &e->why);
    iso_progress_line_add(v->line, e->part);
    if (e->status != ISO_OK && iso_process_was_stopped())
        return iso_fail(err, e->status, "%s", e->why.text);
    return ISO_OK; /* failures are reported in the order of the checks */
}

/* Lists the checks of each renderer that has a version. Its memory is the caller's. */
static size_t list_examinations(const iso_validation *v, fitness *all, size_t count, examination *list)
{
    size_t n = 0;
    for (size_t i = 0; i < count; ++i) {
        const bool apart = are_apart(v, all[i].which);
        for (int check = apart ? 0 : ALL_CHECKS; all[i].failure == ISO_OK && check < ISO_CALIBRATION_COUNT; ++check) {
            list[n++] = (examination){.of = &all[i],
                                      .check = check,
                                      .part = 1 / (double)(count * (apart ? ISO_CALIBRATION_COUNT : 1))};
            if (!apart)
                break;
        }
    }
    return n;
}

/* Counts each renderer's checks, in their order, up to its first failure, which it notes. */
static iso_status sum_up(const examination *list, size_t count, iso_error *err)
{
    iso_status status = ISO_OK;
    for (size_t i = 0; i < count && status == ISO_OK; ++i) {
        fitness *f = list[i].of;
        if (f->failure != ISO_OK)
            continue;
        if (list[i].status != ISO_OK)
            status = note_failure(f, list[i].status, &list[i].why, err);
        else if (list[i].check != ALL_CHECKS)
            f->check_count++;
    }
    return status;
}

static iso_status add_check(iso_validation *v, const fitness *f, const iso_calibration *c, iso_refusal *refusal,
                            iso_error *err)
{
    char lacks[320], folder[ISO_PICTURE_NAME_BYTES], scene[64];
    iso_report_calibration row = {.renderer = f->which->name,
                                  .check = c->check,
                                  .value = c->value,
                                  .limit = c->limit,
                                  .unit = c->unit,
                                  .detail = c->why};
    if (c->lacks) {
        snprintf(lacks, sizeof lacks, "%s does not render %s", f->which->name, c->lacks);
        row.detail = lacks;
        row.not_asked = true;
    } else if (c->no_picture) {
        snprintf(scene, sizeof scene, "calibration-%s", c->check);
        iso_picture_folder(scene, 0, folder);
        snprintf(lacks, sizeof lacks, "picture %.100s is missing, so that this stays open: %.160s", folder,
                 c->no_picture);
        row.detail = lacks;
        row.not_asked = true;
    } else if (!c->passed && refusal->status == ISO_OK) {
        refusal->status = ISO_E_UNTRUSTED;
        refusal->draws = !isnan(c->value);
        if (isnan(c->value))
            snprintf(refusal->why, sizeof refusal->why, "failed its calibration: %s cannot be measured", c->check);
        else
            snprintf(refusal->why, sizeof refusal->why, "failed its calibration: %s is %.3g %s, at most %g", c->check,
                     c->value, c->unit, c->limit);
    }
    return iso_report_add_calibration(v->report, &row, err);
}

/* Writes the mistake that explains the failed calibrations into the report, with pictures. */
static iso_status name_mistakes(iso_validation *v, const iso_renderer_info *which, iso_error *err)
{
    iso_mistakes m;
    iso_mistake_pictures shown;
    char text[400];
    iso_status status = iso_mistakes_find(&v->renderers, which, v->threads, &m, &shown, err);
    if (status == ISO_OK && m.count > 0) {
        snprintf(text, sizeof text, "as if %s%s%s (explains %.3g %% of the difference)", iso_mistake_name(m.numbers[0]),
                 m.count > 1 ? ", and " : "", m.count > 1 ? iso_mistake_name(m.numbers[1]) : "", 100 * m.explained);
        const iso_report_mistake mistake = {.renderer = which->name,
                                            .text = text,
                                            .check = iso_calibration_name(m.check),
                                            .pictures = {&shown.wanted, &shown.got, &shown.explained}};
        status = iso_report_add_mistake(v->report, &mistake, err);
    }
    iso_image_destroy(&shown.wanted);
    iso_image_destroy(&shown.got);
    iso_image_destroy(&shown.explained);
    return status;
}

static iso_status add_to_report(iso_validation *v, const fitness *f, iso_error *err)
{
    iso_refusal *refusal = &v->refused[iso_renderer_index(f->which)];
    iso_status status = ISO_OK;
    *refusal = (iso_refusal){.status = f->failure};
    snprintf(refusal->why, sizeof refusal->why, "%s", f->why);
    for (size_t i = 0; i < f->check_count && status == ISO_OK; ++i)
        status = add_check(v, f, &f->checks[i], refusal, err);
    if (status == ISO_OK && f->failure == ISO_OK && refusal->status == ISO_E_UNTRUSTED)
        status = name_mistakes(v, f->which, err);
    const bool answered = f->failure != ISO_OK && f->failure != ISO_E_MISSING && f->version[0];
    const iso_report_calibration absent = {.renderer = f->which->name,
                                           .check = answered ? f->checks[f->check_count].check : "answers",
                                           .value = NAN,
                                           .limit = answered ? f->checks[f->check_count].limit : 0,
                                           .detail = f->why};
    if (status == ISO_OK && f->failure != ISO_OK)
        status = iso_report_add_calibration(v->report, &absent, err);
    iso_report_put(v->report, "versions", f->which->title, json_string(f->version));
    iso_report_put(v->report, "renderers", f->which->name,
                   json_pack("{s:s, s:s, s:o, s:o, s:s*}", "title", f->which->title, "version", f->version, "draws",
                             iso_renderer_features(f->which, false), "lacks", iso_renderer_features(f->which, true),
                             "why", f->which->lock_step ? f->which->lock_step->why : NULL));
    return status;
}

iso_status iso_validate_renderers(iso_validation *v, iso_error *err)
{
    fitness all[ISO_MAX_RENDERERS];
    size_t count = 0;
    iso_status status = find_renderers(v, all, &count, err);
    FREED examination *list = calloc(count * ISO_CALIBRATION_COUNT + 1, sizeof *list);
    NEED_MEMORY(list, err, "out of memory");
    const size_t n = status == ISO_OK ? list_examinations(v, all, count, list) : 0;
    TRY(status, iso_validate_each(v, n, examine, list, err));
    TRY(status, sum_up(list, n, err));
    for (size_t i = 0; i < count && status == ISO_OK; ++i)
        status = add_to_report(v, &all[i], err);
    return status;
}

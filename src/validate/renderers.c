/* SPDX-License-Identifier: MIT */
/* renderers.c - which renderers answer, and which may be trusted. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "renderers/picture_store.h"
#include "renderers/pictures.h"
#include "validate/calibrate.h"
#include "validate/validate.h"

/* What one renderer said. */
typedef struct fitness {
    const iso_renderer_info *which;
    char version[320];
    iso_calibration checks[ISO_CALIBRATION_COUNT];
    size_t check_count;
    iso_status failure; /* ISO_OK: it answered all; ISO_E_MISSING; ISO_E_UNTRUSTED: it failed itself */
    char why[512];
} fitness;

/* A renderer that fails itself is refused, with the check in which it did. */
static iso_status note_failure(fitness *f, iso_status status, const iso_error *why, iso_error *err)
{
    if (status == ISO_E_MISSING) {
        snprintf(f->why, sizeof f->why, "missing: %.500s", why->text);
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

static iso_status examine(iso_validation *v, size_t part, void *user, iso_error *err)
{
    fitness *f = (fitness *)user + part;
    char stage[64];
    iso_error why = {""};
    snprintf(stage, sizeof stage, "calibration: %s", f->which->name);
    iso_progress_report(v->progress, stage, 0);
    iso_status status = f->which->version(f->which, &v->renderers, f->version, sizeof f->version, &why);
    if (status == ISO_OK)
        iso_picture_store_set_version(v->renderers.store, f->which, f->version);
    if (status == ISO_OK)
        status = iso_calibrate(&v->renderers, f->which, NULL, f->checks, &f->check_count, v->progress, &why);
    return status == ISO_OK ? ISO_OK : note_failure(f, status, &why, err);
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
        snprintf(lacks, sizeof lacks, "there is no picture %.100s, so that this stays open: %.160s", folder,
                 c->no_picture);
        row.detail = lacks;
        row.not_asked = true;
    } else if (!c->passed && refusal->status == ISO_OK) {
        refusal->status = ISO_E_UNTRUSTED;
        if (isnan(c->value))
            snprintf(refusal->why, sizeof refusal->why, "failed its calibration: %s cannot be measured", c->check);
        else
            snprintf(refusal->why, sizeof refusal->why, "failed its calibration: %s is %.3g %s, at most %g", c->check,
                     c->value, c->unit, c->limit);
    }
    return iso_report_add_calibration(v->report, &row, err);
}

static iso_status add_to_report(iso_validation *v, const fitness *f, iso_error *err)
{
    iso_refusal *refusal = &v->refused[iso_renderer_index(f->which)];
    iso_status status = ISO_OK;
    *refusal = (iso_refusal){.status = f->failure};
    snprintf(refusal->why, sizeof refusal->why, "%s", f->why);
    for (size_t i = 0; i < f->check_count && status == ISO_OK; ++i)
        status = add_check(v, f, &f->checks[i], refusal, err);
    const bool answered = f->failure != ISO_OK && f->failure != ISO_E_MISSING && f->version[0];
    const iso_report_calibration absent = {.renderer = f->which->name,
                                           .check = answered ? f->checks[f->check_count].check : "answers",
                                           .value = NAN,
                                           .limit = answered ? f->checks[f->check_count].limit : 0,
                                           .detail = f->why};
    if (status == ISO_OK && f->failure != ISO_OK)
        status = iso_report_add_calibration(v->report, &absent, err);
    iso_report_put(v->report, "versions", f->which->title, json_string(f->version));
    return status;
}

iso_status iso_validate_renderers(iso_validation *v, iso_error *err)
{
    fitness all[ISO_MAX_RENDERERS];
    size_t count = 0;
    for (size_t i = 0; i < iso_renderer_count(); ++i)
        if (v->wanted[i])
            all[count++] = (fitness){.which = iso_renderer_at(i)};
    iso_status status = iso_validate_each(v, count, examine, all, err);
    for (size_t i = 0; i < count && status == ISO_OK; ++i)
        status = add_to_report(v, &all[i], err);
    return status;
}

/* SPDX-License-Identifier: MIT */
/* renderers.c - which renderers answer, and which may be trusted. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "validate/calibrate.h"
#include "validate/validate.h"

/* What one renderer said. */
typedef struct fitness {
    const iso_renderer_info *which;
    char version[320];
    iso_calibration checks[ISO_CALIBRATION_COUNT];
    size_t check_count;
    char missing[512];
} fitness;

static iso_status examine(iso_validation *v, size_t part, void *user, iso_error *err)
{
    fitness *f = (fitness *)user + part;
    char stage[64];
    iso_error why = {""};
    snprintf(stage, sizeof stage, "calibration: %s", f->which->name);
    iso_progress_report(v->progress, stage, 0);
    iso_status status = f->which->version(f->which, &v->renderers, f->version, sizeof f->version, &why);
    if (status == ISO_OK)
        status = iso_calibrate(&v->renderers, f->which, NULL, f->checks, v->progress, &why);
    if (status == ISO_E_MISSING) {
        snprintf(f->missing, sizeof f->missing, "missing: %.500s", why.text);
        snprintf(f->version, sizeof f->version, "missing");
    } else if (status != ISO_OK) {
        return iso_fail(err, status, "%s", why.text);
    } else {
        f->check_count = ISO_CALIBRATION_COUNT;
    }
    return ISO_OK;
}

static iso_status add_to_report(iso_validation *v, const fitness *f, iso_error *err)
{
    iso_refusal *refusal = &v->refused[iso_renderer_index(f->which)];
    iso_status status = ISO_OK;
    *refusal = (iso_refusal){.status = f->missing[0] ? ISO_E_MISSING : ISO_OK};
    snprintf(refusal->why, sizeof refusal->why, "%s", f->missing);
    for (size_t i = 0; i < f->check_count && status == ISO_OK; ++i) {
        const iso_calibration *c = &f->checks[i];
        const iso_report_calibration row = {.renderer = f->which->name,
                                            .check = c->check,
                                            .value = c->value,
                                            .limit = c->limit,
                                            .unit = c->unit,
                                            .detail = c->why};
        if (!c->passed && refusal->status == ISO_OK) {
            refusal->status = ISO_E_UNTRUSTED;
            snprintf(refusal->why, sizeof refusal->why, "failed its calibration: %s is %.3g %s, at most %g", c->check,
                     c->value, c->unit, c->limit);
        }
        status = iso_report_add_calibration(v->report, &row, err);
    }
    const iso_report_calibration absent = {.renderer = f->which->name,
                                           .check = "answers",
                                           .value = NAN,
                                           .detail = f->missing};
    if (status == ISO_OK && f->missing[0])
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

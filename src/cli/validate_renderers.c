/* validate_renderers.c - which renderers answer, and which may be trusted. */
#include <stdio.h>
#include <string.h>

#include "cli/calibrate.h"
#include "cli/validate.h"

static iso_status calibrate(iso_validation *v, iso_renderer which, iso_error *err)
{
    iso_calibration checks[ISO_CALIBRATION_COUNT];
    iso_status status = iso_calibrate(&v->renderers, which, ISO_FAULT_NONE, checks, v->progress, err);
    for (int i = 0; i < ISO_CALIBRATION_COUNT && status == ISO_OK; ++i) {
        const iso_report_calibration row = {.renderer = iso_renderer_name(which), .check = checks[i].check,
                                            .value = checks[i].value, .limit = checks[i].limit, .unit = checks[i].unit,
                                            .detail = checks[i].why};
        if (!checks[i].passed && !v->refused[which][0])
            snprintf(v->refused[which], sizeof v->refused[which], "failed its calibration: %s is %.3g %s, at most %g",
                     checks[i].check, checks[i].value, checks[i].unit, checks[i].limit);
        status = iso_report_add_calibration(v->report, &row, err);
    }
    return status;
}

iso_status iso_validate_renderers(iso_validation *v, iso_error *err)
{
    for (int i = 0; i < ISO_RENDERER_COUNT; ++i) {
        char version[320], stage[64];
        iso_error why = {""};
        if (!v->wanted[i])
            continue;
        snprintf(stage, sizeof stage, "calibration: %s", iso_renderer_name((iso_renderer)i));
        iso_progress_report(v->progress, stage, 0);
        iso_status status = iso_renderer_version(&v->renderers, (iso_renderer)i, version, sizeof version, &why);
        if (status == ISO_OK)
            status = calibrate(v, (iso_renderer)i, &why);
        if (status == ISO_E_MISSING) {
            snprintf(v->refused[i], sizeof v->refused[i], "missing: %.500s", why.text);
            snprintf(version, sizeof version, "missing");
        } else if (status != ISO_OK) {
            return iso_fail(err, status, "%s", why.text);
        }
        iso_report_put(v->report, "versions", iso_renderer_title((iso_renderer)i), json_string(version));
    }
    return ISO_OK;
}

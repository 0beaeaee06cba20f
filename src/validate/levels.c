/* SPDX-License-Identifier: MIT */
/* levels.c - checks that the levels of a pyramid belong together. All renderers are given the same levels. If these are
 * another volume's, the renderers still agree, so that no other check of a validation can find it. Joint histograms
 * that are kept with them are counted again, too: adapted transfer functions are made from them. */
#include <stdio.h>
#include <stdlib.h>

#include "fit/level_scalar.h"
#include "tf/histogram_verify.h"
#include "validate/validate.h"

static iso_status add_to_report(iso_validation *v, const iso_level_check *check, size_t level, iso_error *err)
{
    char name[64], text[256], detail[512];
    snprintf(name, sizeof name, "level %zu is made from level 0", level);
    iso_level_check_text(check, level, text, sizeof text);
    snprintf(detail, sizeof detail, "%s%s%s", text, check->what ? "; built by " : "",
             check->what ? v->pyramid->built_by : "");
    const iso_report_calibration row = {.renderer = "pyramid",
                                        .check = name,
                                        .value = (double)check->differing,
                                        .limit = 0,
                                        .unit = "voxels that differ",
                                        .detail = detail};
    if (check->what && !v->foreign[0])
        snprintf(v->foreign, sizeof v->foreign, "%s", detail);
    return iso_report_add_calibration(v->report, &row, err);
}

static iso_status add_joint_to_report(iso_validation *v, const iso_joint_check *check, iso_error *err)
{
    static const char *const seconds[] = {"", "", " and deviation", " and gradient"};
    char name[96], text[512];
    snprintf(name, sizeof name, "joint histogram of level %zu, %d bits%s", check->key.level, check->key.bits,
             seconds[check->key.second]);
    iso_joint_check_text(check, text, sizeof text);
    const bool good = iso_joint_check_is_good(check);
    const iso_report_calibration row = {.renderer = "pyramid",
                                        .check = name,
                                        .value = (double)(check->unreadable.text[0] ? check->voxels : check->differing),
                                        .limit = 0,
                                        .unit = "voxels counted elsewhere",
                                        .detail = text};
    if (!good && !v->foreign[0])
        snprintf(v->foreign, sizeof v->foreign, "%s", text);
    return iso_report_add_calibration(v->report, &row, err);
}

static iso_status verify_joints(iso_validation *v, iso_error *err)
{
    FREED iso_joint_check *checks = NULL;
    size_t count = 0;
    NEED(iso_joint_verify(v->pyramid, v->volume_path, v->threads, &checks, &count, v->progress, err));
    for (size_t i = 0; i < count; ++i)
        NEED(add_joint_to_report(v, &checks[i], err));
    return ISO_OK;
}

iso_status iso_validate_levels(iso_validation *v, iso_error *err)
{
    iso_level_check checks[32];
    if (!v->loaded) {
        iso_report_put(v->report, "options", "levels_verified", json_string("no: built for this validation"));
        v->is_as_made = true;
        return ISO_OK;
    }
    iso_progress_report(v->progress, "levels", 0);
    iso_status status = iso_fit_verify(v->pyramid, v->threads, checks, v->progress, err);
    for (size_t k = 0; k < v->pyramid->level_count && status == ISO_OK; ++k)
        status = add_to_report(v, &checks[k], k, err);
    v->is_as_made = status == ISO_OK && !v->foreign[0];
    TRY(status, verify_joints(v, err));
    iso_report_put(v->report, "options", "levels_verified", json_string("yes: built again from level 0"));
    iso_report_put(v->report, "versions", "pyramid", json_string(v->pyramid->built_by));
    return status;
}

/* SPDX-License-Identifier: MIT */
/* stages.c - reports each skipped stage in a row of its own, so that no requested check is missing without a reason. */
#include <math.h>
#include <stdint.h>
#include <stdio.h>

#include "base/parallel.h"
#include "validate/validate.h"

bool iso_validate_is_out_of_time(const iso_validation *v)
{
    return v->deadline > 0 && iso_clock_seconds() >= v->deadline;
}

void iso_validate_explain_budget(const iso_validation *v, char why[512])
{
    snprintf(why, 512, "the budget of %g s was over before it could be asked", v->budget_seconds);
}

static iso_status add_stage(const iso_validation *v, const char *stage, iso_uncompared reason, const char *why,
                            iso_error *err)
{
    const iso_report_agreement row = {.order = SIZE_MAX,
                                      .scene = v->scene_name,
                                      .comparison = ISO_COMPARISON_STAGE,
                                      .variant = stage,
                                      .uncompared = reason,
                                      .uncompared_why = why,
                                      .error_bar = NAN};
    return iso_report_add_agreement(v->report, &row, err);
}

iso_status iso_validate_stage_not_run(const iso_validation *v, const char *stage, const char *why, iso_error *err)
{
    return add_stage(v, stage, ISO_UNCOMPARED_STAGE, why, err);
}

iso_status iso_validate_stage_left_out(const iso_validation *v, const char *stage, iso_error *err)
{
    char why[512];
    iso_validate_explain_budget(v, why);
    return add_stage(v, stage, ISO_UNCOMPARED_BUDGET, why, err);
}

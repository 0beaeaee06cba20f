/* SPDX-License-Identifier: MIT */
/* stages.c - reports each skipped stage in a row of its own, so that no requested check is missing without a reason. */
#include <math.h>
#include <stdint.h>
#include <stdio.h>

#include "base/parallel.h"
#include "base/process.h"
#include "report/rows.h"
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

/* ---- programs may fail by themselves, and a report says how they were run ---- */

/* True if the failure is the program's own. Out of memory, an unsupported request and Ctrl-C in this process are
 * not. */
bool iso_validate_is_its_fault(const iso_renderer_info *which, iso_status status)
{
    return iso_renderer_has(which, ISO_IS_PROGRAM) && status != ISO_OK && status != ISO_E_MEMORY &&
           status != ISO_E_USAGE && !iso_process_was_stopped();
}

iso_status iso_validate_refused_later(const iso_validation *v, iso_error *err)
{
    size_t i;
    json_t *row;
    json_array_foreach (json_object_get(iso_report_json(v->report), "agreement"), i, row) {
        if (iso_row_verdict(row) == ISO_VERDICT_REFUSED)
            return iso_fail(err, ISO_E_UNTRUSTED, "%s failed: %s", iso_row_text(row, "renderer"),
                            iso_row_text(row, "why"));
    }
    return ISO_OK;
}

void iso_validate_describe_programs(const iso_validation *v)
{
    for (size_t i = 0; i < iso_renderer_count(); ++i) {
        const iso_renderer_info *r = iso_renderer_at(i);
        if (v->wanted[i] && r->describe)
            iso_report_put(v->report, "programs", r->name, r->describe(r));
    }
}

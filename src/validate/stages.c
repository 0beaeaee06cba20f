/* SPDX-License-Identifier: MIT */
/* stages.c - what did not run is said in a row of its own, so that nothing that was asked for is missing without a word. */
#include <math.h>
#include <stdint.h>
#include <stdio.h>

#include "validate/validate.h"

iso_status iso_validate_stage_not_run(const iso_validation *v, const char *stage, const char *why, iso_error *err)
{
    const iso_report_agreement row = {.order = SIZE_MAX,
                                      .scene = v->scene_name,
                                      .comparison = ISO_COMPARISON_STAGE,
                                      .variant = stage,
                                      .uncompared = ISO_UNCOMPARED_STAGE,
                                      .uncompared_why = why,
                                      .error_bar = NAN};
    return iso_report_add_agreement(v->report, &row, err);
}

size_t iso_validate_row_count(const iso_validation *v)
{
    return json_array_size(json_object_get(iso_report_json(v->report), "agreement"));
}

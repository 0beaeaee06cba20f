/* SPDX-License-Identifier: MIT */
/* view_plan.h - the plan file of `isoshade view --plan`. */
#ifndef ISO_CLI_VIEW_PLAN_H
#define ISO_CLI_VIEW_PLAN_H

#include "plan/planned.h"
#include "view/viewer.h"

typedef struct iso_view_plan {
    iso_planned planned;
    iso_view view; /* view of the scene; the plan must be for its transfer function */
    iso_viewer_plan page;
} iso_view_plan;

/* Opens a plan. ISO_E_RANGE: it is for another volume or transfer function. Release with iso_view_plan_close() in any
 * case. */
iso_status iso_view_plan_open(iso_view_plan *plan, const char *path, const iso_viewer *v, iso_error *err);
void iso_view_plan_close(iso_view_plan *plan); /* accepts empty */

#endif

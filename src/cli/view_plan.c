/* SPDX-License-Identifier: MIT */
#include "cli/view_plan.h"

#include <math.h>

#include "base/json.h"
#include "base/provenance.h"

/* Reads the planner's predicted and measured errors, which other plans may omit. */
static iso_status read_errors(const char *path, iso_viewer_plan *page, iso_error *err)
{
    json_t *root = NULL;
    const iso_status status = iso_json_load(path, &root, err);
    const char *const keys[] = {"predicted_rmse", "measured_rmse"};
    double *const values[] = {&page->predicted_rmse, &page->measured_rmse};
    for (int i = 0; i < 2; ++i) {
        const json_t *value = json_object_get(root, keys[i]);
        *values[i] = json_is_number(value) ? json_number_value(value) : NAN;
    }
    json_decref(root);
    return status;
}

iso_status iso_view_plan_open(iso_view_plan *plan, const char *path, const iso_viewer *v, iso_error *err)
{
    *plan = (iso_view_plan){.page = {.name = iso_provenance_title(path)}};
    const iso_level *level0 = &v->pyramid->levels[0];
    iso_status status = iso_scene_resolve(v->scene, &level0->geometry, iso_pyramid_lo(v->pyramid),
                                          iso_pyramid_hi(v->pyramid), &plan->view, err);
    if (status == ISO_OK)
        status = iso_planned_create(path, &(iso_planned_subject){level0, v->codes[0], &plan->view.tf, 1}, v->threads,
                                    &plan->planned, err);
    TRY(status, read_errors(path, &plan->page, err));
    plan->page.nodes = &plan->planned.nodes;
    plan->page.levels = plan->planned.plan.levels;
    plan->page.drawn = plan->planned.plan.drawn;
    return status;
}

void iso_view_plan_close(iso_view_plan *plan)
{
    iso_planned_destroy(&plan->planned);
    iso_view_destroy(&plan->view);
}

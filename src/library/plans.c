/* SPDX-License-Identifier: MIT */
/* plans.c - plans of the library's interface. */
#include <stdlib.h>

#include "library/shared.h"
#include "plan/planner.h"

iso_plan_options iso_plan_defaults(void)
{
    return (iso_plan_options){.error = 1.0 / 255, .levels = 4, .brick_voxels = 16, .views = 1};
}

static iso_status check(const iso_plan_options *o, iso_error *err)
{
    const struct {
        const char *name;
        size_t value, least, most;
    } counts[] = {{"levels", o->levels, 1, ISO_BRICK_MAX_LEVELS},
                  {"brick_voxels", o->brick_voxels, 2, ISO_BRICK_MOST_VOXELS},
                  {"views", o->views, 1, 360}};
    if (!(o->error >= 1e-6 && o->error <= 1))
        return iso_fail(err, ISO_E_RANGE, "error is %g, must be 1e-06 to 1", o->error);
    if (!(o->memory_bytes >= 0 && o->memory_bytes <= 1e15))
        return iso_fail(err, ISO_E_RANGE, "memory_bytes is %g, must be 0 to 1e+15", o->memory_bytes);
    for (size_t i = 0; i < sizeof counts / sizeof *counts; ++i)
        if (counts[i].value < counts[i].least || counts[i].value > counts[i].most)
            return iso_fail(err, ISO_E_RANGE, "%s is %zu, must be %zu to %zu", counts[i].name, counts[i].value,
                            counts[i].least, counts[i].most);
    return ISO_OK;
}

static iso_status take_result(const iso_planner *p, double error, iso_plan_result *plan, iso_error *err)
{
    plan->brick_count = p->plan.brick_count;
    plan->drawn_count = p->best.drawn_count;
    plan->bytes = iso_plan_trial_bytes(&p->best);
    plan->full_bytes = ISO_BYTES_A_NODE * (double)p->full_node_count;
    plan->predicted_rmse = p->best.predicted_rmse;
    plan->measured_rmse = p->best.measured.rmse;
    plan->blank_rmse = p->blank_rmse;
    return iso_text_of_json(iso_planner_json(p, error), &plan->json, err);
}

static iso_status search(const iso_pyramid *pyramid, const iso_plan_options *o, const iso_view *views,
                         const iso_progress *progress, iso_plan_result *plan, iso_error *err)
{
    OWNED(iso_node_levels) nodes = {0};
    OWNED(iso_planner) planner = {0};
    NEED(iso_node_levels_begin(&nodes, &pyramid->levels[0], o->brick_voxels, o->levels, o->threads, err));
    NEED(iso_planner_create(&planner, &nodes, &(iso_planner_options){views, o->views, ISO_FACES_BAKED, o->threads},
                            progress, err));
    NEED(iso_planner_search(&planner, o->error, o->memory_bytes, progress, err));
    return take_result(&planner, o->error, plan, err);
}

iso_status iso_plan(const iso_pyramid *pyramid, const iso_scene *scene, const iso_plan_options *options,
                    iso_plan_result *plan, iso_error *err)
{
    const iso_plan_options given = options ? *options : iso_plan_defaults();
    iso_scene shown;
    iso_view *views = NULL;
    size_t view_count = 0;
    iso_call call;
    *plan = (iso_plan_result){0};
    NEED(check(&given, err));
    NEED(iso_scene_borrow(scene, NULL, given.width, given.height, &shown, err));
    iso_call_begin(&call, given.progress, given.progress_user);
    iso_status status = iso_planner_check_pyramid(pyramid, "plan", err);
    if (status == ISO_OK && !(views = calloc(given.views, sizeof *views)))
        status = iso_fail(err, ISO_E_MEMORY, "out of memory");
    TRY(status, iso_planner_add_views(&shown, given.views, pyramid, views, &view_count, err));
    TRY(status, search(pyramid, &given, views, &call.progress, plan, err));
    iso_planner_destroy_views(views, view_count);
    return iso_call_end(&call, status, err);
}

void iso_plan_result_destroy(iso_plan_result *plan)
{
    if (!plan)
        return;
    free(plan->json);
    *plan = (iso_plan_result){0};
}

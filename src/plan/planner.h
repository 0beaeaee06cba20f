/* SPDX-License-Identifier: MIT */
/* planner.h - a plan (plan/plan.h) that is verified by rendering, as commands use it. */
#pragma once

#include "plan/planned.h"
#include "compare/metrics.h"
#include "render/gl/bricks_gl.h"
#include "plan/plan.h"
#include "scene/subject.h"

/* Scalar in 16 bits and a direction of three or four times 16: what bricks_gl.h's cache holds a node. */
enum { ISO_BYTES_A_NODE = 10 };

/* A choice of levels, and the image that it gives. */
typedef struct iso_plan_trial {
    double predicted_rmse;
    iso_metrics measured;    /* of the view in which the RMSE is the largest */
    uint8_t *levels, *drawn; /* owned; one byte per brick */
    size_t drawn_count, node_count;
    iso_image image; /* of the first view */
} iso_plan_trial;

typedef struct iso_planner {
    iso_gl *gl; /* NULL: OpenGL is software alone, and the CPU ray caster draws */
    const iso_node_levels *nodes; /* rounded */
    const iso_view *views;
    size_t view_count;
    iso_brick_faces faces;
    iso_plan_errors plan;
    uint8_t *wanted;   /* bricks that a view sees */
    iso_image *full;   /* a view each, all bricks at level 0 */
    double blank_rmse; /* RMSE of the background alone, in the view with the least */
    size_t full_node_count;
    iso_plan_trial best;
    int render_count, threads;
} iso_planner;

typedef struct iso_planner_options {
    const iso_view *views;
    size_t view_count;
    iso_brick_faces faces;
    int threads; /* 0: all */
} iso_planner_options;
/* Creates a planner, which keeps the views and nodes and does not copy them. Nodes that were only begun are completed
 * after the pictures of level 0. */
iso_status iso_planner_create(iso_planner *p, iso_node_levels *nodes, const iso_planner_options *opt,
                              const iso_progress *progress, iso_error *err);
/* Finds the least model with a measured RMSE of at most `error` in every view, if memory is 0; ISO_E_RANGE: none.
 * Otherwise finds the model of the least RMSE within `memory` bytes. ISO_E_RANGE with the needed size if these are too
 * few to show anything. */
iso_status iso_planner_search(iso_planner *p, double error, double memory, const iso_progress *progress,
                              iso_error *err);
void iso_planner_destroy(iso_planner *p); /* accepts empty */

/* Returns the plan as the object of a plan file (plan/planned.h), with the figures of the model; NULL: no memory. */
json_t *iso_planner_json(const iso_planner *p, double error);

/* Renders the planner's nodes at any levels, only the wanted bricks (NULL: all). */
iso_status iso_planner_draw(const iso_planner *p, const uint8_t *levels, const uint8_t *wanted, const iso_view *view,
                            iso_image *image, iso_error *err);

static inline double iso_plan_trial_bytes(const iso_plan_trial *t)
{
    return ISO_BYTES_A_NODE * (double)t->node_count;
}

/* Refuses a label map, and levels for a scene: a plan's bricks have nodes at other places, and one transfer function
 * for all. ISO_E_USAGE. path: name in messages. */
iso_status iso_planner_check_pyramid(const iso_pyramid *p, const char *path, iso_error *err);
/* Appends the views of a scene from `turns` sides to those that are there. */
iso_status iso_planner_add_views(const iso_scene *scene, size_t turns, const iso_pyramid *p, iso_view *views,
                                 size_t *count, iso_error *err);
/* Loads the views of a look whose scene may be several, "A.scene.json,B.scene.json", each from `turns` sides: turned
 * round its "up" by 360 / turns degrees. *views is released with iso_planner_destroy_views(). */
iso_status iso_planner_load_views(const iso_subject_look *look, size_t turns, const iso_pyramid *p, iso_view **views,
                                  size_t *count, iso_error *err);
/* Checks the views before the volume is read. */
iso_status iso_planner_check_views(const iso_subject_look *look, iso_error *err);
void iso_planner_destroy_views(iso_view *views, size_t count);

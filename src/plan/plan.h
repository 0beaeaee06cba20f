/* SPDX-License-Identifier: MIT */
/* plan.h - the least model that a scene needs: which bricks to leave out, and how coarse the others may be.
 *
 * For each view, brick and level the error in the view's image is estimated from a node's emission towards the camera
 * over one voxel (TF, extinction, ambient and diffuse light). If the average emission on the way to the next node
 * differs more, that is used: a narrow transfer function may show values that occur only between nodes. The difference
 * to level 0 is averaged over the brick and multiplied by the voxels of a ray through it. A brick's footprint is the
 * pixels that see it: rays over the image find which bricks they pass, and count by the square of the transmittance
 * with which they get there. The predicted RMSE over the images of all views is then
 *     sqrt(sum over views and bricks of footprint * error^2 / pixels),
 * and the levels are those of the least number of nodes for it: each brick minimizes nodes + lambda * sum of footprint
 * * error^2, with one lambda for all.
 *
 * A brick that is outside every view or hidden by opaque bricks in all of them has footprint 0. It is left out, as are
 * bricks that no TF shows. Omitted bricks stay at level 0: they cost nothing there, and a coarse level would make the
 * faces of their neighbors coarse too. The prediction has to be verified by rendering: `isoshade plan` lowers or raises
 * it until every view has at most the requested error. All results are deterministic. */
#pragma once

#include "base/progress.h"
#include "brick/bricks.h"
#include "scene/scene.h"

/* A ray's transmittance below which it sees nothing any more. */
#define ISO_PLAN_HIDDEN 1e-3

typedef struct iso_plan_errors {
    size_t brick_count, level_count;
    float *squares;     /* owned; brick_count * level_count: sum over views of footprint * error^2, in pixels */
    float *footprints;  /* owned; pixels of all views, 0 for a brick that none sees */
    uint8_t *shown;     /* owned; by the TF of a view that sees it, at level 0 */
    uint8_t *levels;    /* owned; what iso_plan_choose() chose */
    double pixel_count; /* of all views */
} iso_plan_errors;

/* Estimates errors and footprints; every brick starts at level 0. ISO_E_MEMORY. */
iso_status iso_plan_errors_create(iso_plan_errors *plan, const iso_node_levels *n, const iso_view *views,
                                  size_t view_count, int threads, const iso_progress *progress, iso_error *err);
void iso_plan_errors_destroy(iso_plan_errors *plan); /* accepts empty and NULL */

/* Chooses the levels for a predicted RMSE of at most `rmse`, and returns the prediction. */
double iso_plan_choose(iso_plan_errors *plan, const iso_node_levels *n, double rmse);

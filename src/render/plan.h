/* plan.h - no more model than the scene needs: which bricks to leave out, and how
 * coarse the others may be.
 *
 * For each brick and level the error in this scene's image is estimated: what a
 * node emits towards the camera over one voxel (TF, extinction, ambient and diffuse
 * light), its difference to level 0, averaged over the brick and taken over the
 * voxels of a ray through it. A brick's footprint is the pixels that see it: rays over
 * the image find which bricks they pass, and count by the square of the transmittance
 * with which they get there. The predicted RMSE of an image is then
 *     sqrt(sum over bricks of footprint * error^2 / pixels),
 * and the levels are those of the least number of nodes for it: each brick minimises
 * nodes + lambda * footprint * error^2, with one lambda for all.
 *
 * A brick outside the view, or behind what is opaque, has footprint 0 and is left out,
 * as are those that the TF does not show. Bricks that are left out stay at level 0: there they cost nothing, while
 * at a coarse level they would take the faces of their neighbours with them. The prediction is to be verified by rendering: `isoshade plan`
 * lowers or raises it until the measured error is met. Everything is deterministic. */
#ifndef ISO_PLAN_H
#define ISO_PLAN_H

#include "base/progress.h"
#include "brick/bricks.h"
#include "render/scene.h"

/* A ray's transmittance below which it sees nothing any more. */
#define ISO_PLAN_HIDDEN 1e-3

typedef struct iso_plan {
    size_t brick_count, level_count;
    float *errors;     /* owned; brick_count * level_count, of a pixel's value */
    float *footprints; /* owned; pixels, 0 for a brick that is left out */
    uint8_t *shown;    /* owned; by the TF at level 0 */
    uint8_t *levels;   /* owned; what iso_plan_choose() chose */
    double pixel_count;
} iso_plan;

/* Estimates errors and footprints; every brick starts at level 0. ISO_E_MEMORY. */
iso_status iso_plan_create(iso_plan *plan, const iso_node_levels *n, const iso_view *view, int threads,
                           const iso_progress *progress, iso_error *err);
void iso_plan_destroy(iso_plan *plan); /* accepts empty and NULL */

/* Chooses the levels for a predicted RMSE of at most `rmse`, and returns the prediction. */
double iso_plan_choose(iso_plan *plan, const iso_node_levels *n, double rmse);

#endif

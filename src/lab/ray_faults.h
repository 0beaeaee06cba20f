/* SPDX-License-Identifier: MIT */
/* ray_faults.h - faults along a ray, for renderers that cannot make them on request.
 *
 * A scene has no parameter for the order of compositing, the view vector, or the place of normalization, so a
 * renderer's input cannot hold these faults. So the fault's own share is computed here, with the equation of scene.h in
 * double precision: the picture with one thing wrong, less the picture with nothing wrong, at the same samples of an
 * eighth of a voxel. That difference is added to the renderer's picture, whose own errors stay in it. Step and
 * quadrature hardly matter: errors that both pictures share cancel.
 *
 * Scenes of one level and a TF over the value, as calibrations and random scenes are: no regions of interest, no 2D
 * TFs. */
#pragma once

#include "renderers/renderers.h"

typedef enum iso_ray_fault {
    ISO_RAY_RIGHT,
    ISO_RAY_REVERSED,  /* the samples nearest to the eye are attenuated by all samples farther away */
    ISO_RAY_OTHER_EYE, /* orthographic: highlights as seen from a point; perspective: as seen along one direction */
    ISO_RAY_NOT_NORMALIZED, /* n is the mean of the voxels' normals, which is shorter than 1 if they differ */
} iso_ray_fault;

/* Adds the effect of the fault to an image of the request. ISO_E_MEMORY; ISO_E_USAGE: a scene of another kind. */
iso_status iso_ray_fault_add(const iso_render_request *request, iso_ray_fault fault, iso_image *image, iso_error *err);

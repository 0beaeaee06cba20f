/* SPDX-License-Identifier: MIT */
/* ray_faults.h - faults of what happens along a ray, for renderers that cannot be told to make them.
 *
 * Neither the order of compositing, nor the view vector, nor what is normalized when, can be wrong in what a renderer is
 * given: the scene has no words for them. So the fault's own share is computed here, with the equation of scene.h in
 * double precision: the picture with one thing wrong, less the picture with nothing wrong, at the same samples of an
 * eighth of a voxel. That difference is added to the renderer's picture, whose own errors stay in it. Step and
 * quadrature hardly matter: what both pictures have in common cancels.
 *
 * Scenes of one level and a TF over the value, as calibrations and random scenes are: no regions of interest, no 2D TFs. */
#ifndef ISO_VALIDATE_RAY_FAULTS_H
#define ISO_VALIDATE_RAY_FAULTS_H

#include "renderers/renderers.h"

typedef enum iso_ray_fault {
    ISO_RAY_RIGHT,
    ISO_RAY_REVERSED,  /* what is nearest to the eye is attenuated by all that lies behind it */
    ISO_RAY_OTHER_EYE, /* orthographic: highlights as seen from a point; perspective: as seen along one direction */
    ISO_RAY_NOT_NORMALIZED, /* n is the mean of the voxels' normals, which is shorter than 1 where they differ */
} iso_ray_fault;

/* Adds what the fault changes to an image of the request. ISO_E_MEMORY; ISO_E_USAGE: not a scene as above. */
iso_status iso_ray_fault_add(const iso_render_request *request, iso_ray_fault fault, iso_image *image, iso_error *err);

#endif

/* SPDX-License-Identifier: MIT */
/* closed_form.h - images that are known by a formula, so that renderers can be compared with the truth and not only
 * with each other.
 *
 * Where the voxels are linear in the index (a constant counts) and the TF has one
 * color, shading is one number a ray and only the optical depth is left:
 *     C = c shade (1 - exp(-tau)) + exp(-tau) background,   tau = integral of sigma(s(t)) dt
 * s is linear along the ray but where a coordinate is clamped to the edge, and
 * sigma is piecewise linear in s: each piece is integrated by its antiderivative. */
#ifndef ISO_VALIDATE_CLOSED_FORM_H
#define ISO_VALIDATE_CLOSED_FORM_H

#include "image/image.h"
#include "pyramid/pyramid.h"
#include "scene/scene.h"

/* Does the formula hold for this level? ISO_E_RANGE with the reason: as below. */
iso_status iso_closed_form_check(const iso_level *level, const iso_view *view, iso_error *err);

/* Creates *image. ISO_E_RANGE: the voxels are not linear, or the TF has several colors where it shows something. */
iso_status iso_closed_form_render(const iso_level *level, iso_code code, const iso_view *view, iso_image *image,
                                  iso_error *err);

#endif

/* SPDX-License-Identifier: MIT */
/* closed_form.h - images that are known by a formula, so that renderers can be compared with exact values and not only
 * with each other.
 *
 * If the voxels are linear in the index (constant included) and the TF has one color, shading is one number per ray and
 * only the optical depth varies:
 *     C = c shade (1 - exp(-tau)) + exp(-tau) background,   tau = integral of sigma(s(t)) dt
 * s is linear along the ray except in pieces with a coordinate clamped to the edge. sigma is piecewise linear in s:
 * each piece is integrated by its antiderivative. */
#pragma once

#include "image/image.h"
#include "pyramid/pyramid.h"
#include "scene/scene.h"

/* Checks that the formula holds for this level. ISO_E_RANGE with the reason: as below. */
iso_status iso_closed_form_check(const iso_level *level, const iso_view *view, iso_error *err);

/* Creates *image. ISO_E_RANGE: the voxels are not linear, or the visible part of the TF has several colors. */
iso_status iso_closed_form_render(const iso_level *level, iso_code code, const iso_view *view, iso_image *image,
                                  iso_error *err);

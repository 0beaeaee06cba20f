/* SPDX-License-Identifier: MIT */
/* calibrate.h - checks of each renderer before it is compared: tiny volumes whose images are known in closed form.
 *
 *   placement          a small blob off the center of a rotated, anisotropic grid: the
 *                      centroid of the optical depth is the projection of the centroid
 *                      of the voxels. Half a voxel is about one pixel.
 *   slab               a constant volume, rotated, in perspective: 1 - exp(-sigma chord)
 *                      in every pixel.
 *   transfer function  a ramp seen from the side: every column shows one value, so the
 *                      colors and extinctions of the table appear in order.
 *   light              a linear field has one gradient everywhere: one shade, by the
 *                      inverse transpose of the rotated, anisotropic matrix, from
 *                      the far side, with a highlight above 1.
 *   order              a constant extinction and a color that changes along the ray:
 *                      near samples cover far ones.
 *   view vector        the linear field in perspective from near by: each pixel has
 *                      its own highlight, by its own direction to the eye.
 *   interpolation      two directions of unequal length at right angles, voxel by
 *                      voxel: filtered as they are, then normalized. */
#pragma once

#include "validate/calibration_stage.h"

enum { ISO_CALIBRATION_COUNT = 7 };

typedef struct iso_calibration {
    const char *check;
    const char *unit;
    double value, limit; /* trusted while value <= limit */
    char why[512];       /* the cause of the limit */
    bool passed;
    const char
        *no_picture; /* set if the renderer is a folder of pictures that lacks the check's picture: what stays open; or
                     * NULL */
    const char *lacks; /* feature that the check needs and the renderer lacks: the check is skipped; or NULL */
} iso_calibration;

/* Runs all checks. ISO_OK if all could be made, passed or not. A renderer that fails itself, such as a program that
 * crashes, ends the run: *made checks were made before, and it failed in the next one. fault: NULL: none. */
iso_status iso_calibrate(iso_renderers *r, const iso_renderer_info *which, const iso_calibration_fault *fault,
                         iso_calibration out[ISO_CALIBRATION_COUNT], size_t *made, iso_error *err);

/* Returns the place of a check in the list above. */
int iso_calibration_number(const char *check);
const char *iso_calibration_name(int check);

/* Draws the picture of a check. It stays empty if the renderer lacks a feature for it, or has no such picture. */
iso_status iso_calibration_picture(iso_renderers *r, const iso_renderer_info *which, int check, iso_image *image,
                                   iso_error *err);
/* Makes the volume and view of a check. */
iso_status iso_calibration_prepare(int check, iso_calibration_stage *stage, iso_error *err);

/* Runs one check alone, by its place. */
iso_status iso_calibrate_check(iso_renderers *r, const iso_renderer_info *which, const iso_calibration_fault *fault,
                               int check, iso_calibration *out, iso_error *err);

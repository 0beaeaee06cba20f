/* SPDX-License-Identifier: MIT */
/* calibration_stage.h - the scene of a check of calibrate.h: a tiny volume, its view, and the expected picture. */
#pragma once

#include "renderers/renderers.h"

enum { ISO_CALIBRATION_PIXELS = 32, ISO_CALIBRATION_TF_ENTRIES = 17 };

/* A fault to put into a check's input and its pictures, to show that the check rejects it. */
typedef struct iso_calibration_fault {
    /* Changes the input; returns the level to render. user: that of the hook. */
    size_t (*plant)(const void *user, iso_pyramid *pyramid, iso_view *view);
    iso_image_hook hook;
} iso_calibration_fault;

/* A subject, its view, and the image that it must give. */
typedef struct iso_calibration_stage {
    iso_pyramid pyramid;
    iso_view view;
    iso_image expected, got;
    double centroid[2]; /* of the optical depth, where the picture itself has no formula; in pixels */
} iso_calibration_stage;

/* Returns a grid turned about an oblique axis, with three different spacings. */
iso_geometry iso_calibration_turned_grid(size_t nx, size_t ny, size_t nz);
/* Looks from 60 mm before the origin. */
iso_camera iso_calibration_look(iso_vec3 forward, double half_height, bool orthographic);

/* Makes the volume of value() with two levels, a view of one light and no shading, and an empty picture. Release it
 * with iso_calibration_stage_clear(), also after a failure. */
iso_status iso_calibration_stage_set(iso_calibration_stage *s, const iso_geometry *g,
                                     double (*value)(const iso_geometry *, iso_vec3 index), iso_error *err);
void iso_calibration_stage_clear(iso_calibration_stage *s);

void iso_calibration_set_entry(iso_view *view, size_t i, float r, float g, float b, float extinction);
/* Sets the expected pixel for a constant color and extinction (r, g, b, sigma), shaded by a constant. */
void iso_calibration_expect_pixel(iso_calibration_stage *s, size_t column, size_t row, const double rgbs[4],
                                  double shade);

/* Renders a picture of each stage, by one start if the renderer can. fault: NULL: none. */
iso_status iso_calibration_render(iso_calibration_stage *stages, size_t count, iso_renderers *r,
                                  const iso_renderer_info *which, const iso_calibration_fault *fault, iso_error *err);
/* Returns the largest difference between rendered and expected image. */
double iso_calibration_largest_difference(iso_calibration_stage *s, const iso_renderer_info *which);

/* SPDX-License-Identifier: MIT */
/* mistakes.h - names the mistake of a renderer that failed its calibration.
 *
 * The calibration volumes are drawn with each known mistake, and with pairs of them. The one whose pictures are nearest
 * to those of the renderer is its mistake, if hardly a difference is left. Pictures are drawn at the samples of the
 * request, in double precision; only this module's ray marcher can make mistakes.
 *
 * A picture's difference counts by its part of the same picture's error, so that a small mistake is seen next to a
 * large one in another picture. */
#pragma once

#include "validate/calibrate.h"

enum { ISO_MISTAKES_MOST = 2 };

typedef struct iso_mistakes {
    size_t count; /* 0: none explains the pictures */
    size_t numbers[ISO_MISTAKES_MOST];
    double explained; /* part of the squared difference from the right pictures, 0 to 1 */
    int check;        /* the one that differs most */
} iso_mistakes;

/* Returns the name of a known mistake, such as "the volume stood half a voxel off along x"; NULL after the last. */
const char *iso_mistake_name(size_t number);

/* The check that differs most; empty without mistakes. */
typedef struct iso_mistake_pictures {
    iso_image wanted, got, explained; /* explained: with the mistakes */
} iso_mistake_pictures;
/* Draws the calibrations by `which` again and looks for its mistakes. Pictures that are missing are left out. The
 * caller destroys the images of `shown`. ISO_E_MEMORY; also the failures of the renderer. */
iso_status iso_mistakes_find(iso_renderers *r, const iso_renderer_info *which, int threads, iso_mistakes *found,
                             iso_mistake_pictures *shown, iso_error *err);

/* Draws a check with up to two mistakes, by their numbers; for tests. */
iso_status iso_mistakes_draw(int check, const size_t *mistakes, size_t count, int threads, iso_image *image,
                             iso_error *err);
/* Looks for the mistakes of pictures, one per check; those without pixels are left out. */
iso_status iso_mistakes_of_pictures(const iso_image pictures[ISO_CALIBRATION_COUNT], int threads, iso_mistakes *found,
                                    iso_error *err);

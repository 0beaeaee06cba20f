/* SPDX-License-Identifier: MIT */
/* visible.h - the visible part of a volume and of a picture, so that an empty picture is reported.
 *
 * In:  level 0 of a pyramid and a resolved view.  Out: shares of 0 to 1, and a sentence if they indicate a fault.
 *
 *   voxels   Share of all voxels that could be visible: a box full of such a voxel, as long as the volume's longest
 *            side L, hides at least 1/255 of the light through it: 1 - exp(-sigma L) >= 1/255. From a sample of the rows
 *            of more than ISO_VISIBLE_SAMPLE voxels, unless it is near the limit ISO_VISIBLE_LEAST.
 *   faces    Share of the box's faces, by area, that hide the inside: a tenth of the box's mean side M of such a voxel
 *            hides 9/10: sigma M / 10 >= ln 10. 0 if clip planes open the box, and for volumes of fewer than 4 voxels
 *            along a side, which have no inside.
 *   box      Share of the picture's pixels whose rays meet the unclipped part of the box.
 *   picture  Share of at most 64 x 64 rays, spread over the picture, that lose at least 1/255 of their light in the
 *            nearest voxels of level 0. iso_visible_take_image() replaces it by a rendered image's share.
 *
 * tests/test_visible.c compares them with volumes of known shares. */
#pragma once

#include "image/image.h"
#include "pyramid/pyramid.h"
#include "scene/scene.h"

/* With a smaller share of voxels or pixels a picture shows almost nothing; with a larger one of faces, only a box. */
#define ISO_VISIBLE_LEAST 1e-3
#define ISO_VISIBLE_MOST_FACES 0.98
#define ISO_VISIBLE_SAMPLE ((size_t)1 << 20) /* voxels of the sample */

typedef struct iso_visible {
    double voxels, faces, box, picture;
    double value_min, value_max; /* of level 0 */
    double shown_min,
        shown_max;        /* values that the TF shows; infinite if open-ended, min > max if it shows none */
    double range[2];      /* of the TF's table */
    size_t size[2];       /* of the picture */
    bool is_clipped_away; /* True if the box is in the picture but its unclipped part is not */
    bool from_image;      /* True if `picture` is from a rendered image */
    bool is_isosurface;   /* True if an isosurface is shown, which ignores the TF */
    double isosurface;
    double same_color; /* share of an image's pixels that are opaque but have the background's color */
} iso_visible;

/* Measures all shares. isosurface: value of an opaque first hit, or NULL. */
iso_visible iso_visible_measure(const iso_level *level0, const iso_view *view, const double *isosurface, int threads);

/* Replaces `picture` and same_color by those of an image. A pixel shows something if its alpha is at least 1/255;
 * same_color counts those whose display color differs by less than 1/255 from the background's. */
void iso_visible_take_image(iso_visible *v, const iso_image *image, const double background[3]);

/* Writes one sentence with the fault, the ranges and the remedy. False: no fault. volume: its name on the command
 * line. */
bool iso_visible_complaint(const iso_visible *v, const char *volume, char *text, size_t size);

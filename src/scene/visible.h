/* SPDX-License-Identifier: MIT */
/* visible.h - the visible part of a volume and of a picture, so that an empty picture is reported.
 *
 * In:  level 0 of a pyramid and a resolved view.  Out: shares of 0 to 1, and a sentence if they are wrong.
 *
 *   voxels   Counted, all of them: those that could be seen at all. A box full of such a voxel, as long as the volume's
 *            longest side L, hides 1/255 of the light through it: 1 - exp(-sigma L) >= 1/255.
 *   faces    Of the box's outer voxels, by the area that they show: those that hide what is in the box. A tenth of its mean
 *            side hides 9/10: sigma M / 10 >= ln 10. Nothing is counted (0) if clip planes open the box, and in volumes
 *            of fewer than 4 voxels along a side, which have no inside.
 *   box      Of the picture's pixels: whose rays meet the box, less its clipped parts.
 *   picture  Of at most 64 x 64 rays spread over the picture: those that are hidden by 1/255 on their way through the
 *            voxels of level 0, nearest ones. iso_visible_take_image() replaces it by a rendered image's share.
 *
 * tests/test_visible.c holds them to volumes whose shares are known. */
#ifndef ISO_SCENE_VISIBLE_H
#define ISO_SCENE_VISIBLE_H

#include "image/image.h"
#include "pyramid/pyramid.h"
#include "scene/scene.h"

/* Below this share of voxels or of pixels a picture shows next to nothing; above the other of faces, nothing but a box. */
#define ISO_VISIBLE_LEAST 1e-3
#define ISO_VISIBLE_MOST_FACES 0.98

typedef struct iso_visible {
    double voxels, faces, box, picture;
    double value_min, value_max; /* of level 0 */
    double shown_min,
        shown_max;        /* values that the TF shows; infinite if open-ended, min > max if it shows none */
    double range[2];      /* of the TF's table */
    size_t size[2];       /* of the picture */
    bool is_clipped_away; /* True if the box is in the picture but its unclipped part is not */
    bool from_image;      /* picture is that of a rendered image */
    bool is_isosurface;   /* True if an isosurface is shown, whatever the TF */
    double isosurface;
    double same_color; /* of an image's pixels: opaque, and of the background's color */
} iso_visible;

/* isosurface: NULL, or the value whose first hit is shown, opaque. */
iso_visible iso_visible_measure(const iso_level *level0, const iso_view *view, const double *isosurface, int threads);

/* A pixel shows something where its alpha is at least 1/255; same_color counts those of them whose display color is less
 * than 1/255 from the background's. */
void iso_visible_take_image(iso_visible *v, const iso_image *image, const double background[3]);

/* Writes one sentence with the fault, the ranges and the remedy. False: no fault. `volume`: its name on the command
 * line. */
bool iso_visible_complaint(const iso_visible *v, const char *volume, char *text, size_t size);

#endif

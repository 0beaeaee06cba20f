/* SPDX-License-Identifier: MIT */
/* surface.h - where the surface of a volume is, by one rule for all volumes.
 *
 * The threshold parts the voxels into the two classes of the least variance [otsu-1979], by a histogram of 256 bins.
 * Where no voxel lies between the classes any threshold between them is as good: the middle is taken, for the first one
 * would lie on the lower class itself and show air.
 *
 * A TF that begins to show something at the threshold shows one of the classes. Which one is decided by the box's faces:
 * what they show is a wall before the surface. The values above the threshold are shown, unless they are more than
 * ISO_SURFACE_MOST_BORDER of the border's voxels: then they hold the background, as in a field with negative lobes, and
 * the values below are shown. There is no surface where either side shows that much of the border, or where more than
 * ISO_SURFACE_MOST_RAMP of the voxels have values on the TF's ramp: the threshold then runs through a class, as in
 * noise around one value, and not between two. */
#ifndef ISO_LAB_SURFACE_H
#define ISO_LAB_SURFACE_H

#include "pyramid/pyramid.h"
#include "tf/tf.h"

/* Half of the ramp's width, as a fraction of the range. */
#define ISO_SURFACE_HALF_RAMP 0.05
/* A surface that parts the box evenly (Marschner-Lobb) shows .54 of the border, a background .8 to 1. */
#define ISO_SURFACE_MOST_BORDER (2 / 3.0)
/* Twice what values spread evenly over the range have on the ramp; noise around one value has .27 and more there, the
 * volumes of the tables at most .13. */
#define ISO_SURFACE_MOST_RAMP 0.2

typedef struct iso_otsu_surface {
    double fraction;      /* of the range */
    bool below;           /* the values below it are shown */
    double border, ramp;  /* parts of the border's voxels that are shown, of all voxels that lie on the ramp */
    const char *left_out; /* why it is no surface, else NULL */
} iso_otsu_surface;

iso_otsu_surface iso_surface_find(const iso_level *level);
/* The values above a given fraction of the range; left out by the same rules, except that no side is chosen. */
iso_otsu_surface iso_surface_at(const iso_level *level, double fraction);

/* Opacity rises from 0 to .8 over the ramp, towards the side that is shown. */
typedef struct iso_surface_tf {
    iso_tf_point points[4];
} iso_surface_tf;
iso_tf iso_surface_make_tf(const iso_otsu_surface *surface, iso_surface_tf *storage);

#endif

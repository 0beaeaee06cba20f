/* SPDX-License-Identifier: MIT */
/* surface.h - the surface of a volume, by one rule for all volumes.
 *
 * The threshold splits the voxels into the two classes of least variance [otsu-1979], by a histogram of 256 bins. If no
 * voxel lies between the classes, any threshold between them is as good. The middle is taken: the first one would lie
 * on the lower class and show air.
 *
 * A TF that becomes visible at the threshold shows one of the classes. The box's faces decide which: anything visible
 * there is a wall in front of the surface. By default it shows the values above the threshold. If these are more than
 * ISO_SURFACE_MOST_BORDER of the border's voxels, they hold the background, as in a field with negative lobes, and it
 * shows the values below. There is no surface if either side shows that much of the border. There is none either if
 * more than ISO_SURFACE_MOST_RAMP of the voxels lie on the TF's ramp: the threshold then runs through one class, as in
 * noise around a single value. */
#pragma once

#include "pyramid/pyramid.h"
#include "tf/tf.h"

/* Half of the ramp's width, as a fraction of the range. */
#define ISO_SURFACE_HALF_RAMP 0.05
/* A surface that splits the box evenly (Marschner-Lobb) shows .54 of the border, a background .8 to 1. */
#define ISO_SURFACE_MOST_BORDER (2 / 3.0)
/* Twice the ramp's share of uniformly distributed values. Noise around one value has .27 and more there, the volumes of
 * the tables at most .13. */
#define ISO_SURFACE_MOST_RAMP 0.2

typedef struct iso_otsu_surface {
    double fraction;      /* of the range */
    bool below;           /* true: values below it are shown */
    double border, ramp;  /* share of border voxels that are visible; share of all voxels on the ramp */
    const char *left_out; /* why there is no surface, or NULL */
} iso_otsu_surface;

iso_otsu_surface iso_surface_find(const iso_level *level);
/* Shows the values above a given fraction of the range; left out by the same rules, except that no side is chosen. */
iso_otsu_surface iso_surface_at(const iso_level *level, double fraction);

/* Opacity rises from 0 to .8 over the ramp, towards the visible side. */
typedef struct iso_surface_tf {
    iso_tf_point points[4];
} iso_surface_tf;
iso_tf iso_surface_make_tf(const iso_otsu_surface *surface, iso_surface_tf *storage);

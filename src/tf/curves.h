/* SPDX-License-Identifier: MIT */
/* curves.h - transfer functions as other programs store them: one curve for color and one for opacity, each with its
 * own nodes, a midpoint and a sharpness between two nodes, and a color space.
 *
 * The rules are those of VTK's vtkPiecewiseFunction and vtkColorTransferFunction, which Slicer and ParaView use. Other
 * programs draw lines between display colors: the same with midpoint 1/2, sharpness 0 and RGB. */
#pragma once

#include "tf/color_space.h"
#include "tf/tf.h"

typedef struct iso_tf_node {
    double x;
    double y[3];                /* display color, or opacity in y[0] */
    double midpoint, sharpness; /* up to the next node */
} iso_tf_node;

typedef struct iso_tf_curve {
    size_t count, capacity;
    iso_tf_node *nodes; /* ascending in x; two with the same x make a step */
} iso_tf_curve;

typedef struct iso_tf_curves {
    iso_tf_curve color, opacity; /* opacity has no nodes if the file has none */
    iso_color_space space;
    bool are_fractions;   /* True if x runs from 0, the volume's least value, to 1, its largest */
    double unit_mm;       /* length that opacities are for; 0: not in the file */
    bool unit_is_default; /* True if unit_mm is the program's default: --unit-distance may override it */
    bool unit_is_voxel;   /* True if unit_mm is in voxels */
    const char *unit_is;  /* for messages if unit_mm is 0: "in Inviwo a 150th of the volume's longest side" */
} iso_tf_curves;

void iso_tf_curves_destroy(iso_tf_curves *curves);

/* Appends a node. ISO_E_RANGE: a value is not finite, or a color, opacity, midpoint or sharpness is outside 0 to 1;
 * ISO_E_MEMORY. components: 3 for a color, 1 for an opacity. */
iso_status iso_tf_curve_add(iso_tf_curve *curve, iso_tf_node node, int components, const char *path, iso_error *err);
/* Appends a node with midpoint 1/2 and sharpness 0. */
iso_status iso_tf_curve_add_color(iso_tf_curve *curve, double x, const double rgb[3], const char *path, iso_error *err);
iso_status iso_tf_curve_add_opacity(iso_tf_curve *curve, double x, double opacity, const char *path, iso_error *err);
/* Sorts by x, stable. */
void iso_tf_curve_sort(iso_tf_curve *curve);

/* Returns the curve's value at x. `inside` lies between the same nodes; at a step its side selects the value. */
void iso_tf_curve_color(const iso_tf_curve *curve, iso_color_space space, double x, double inside, double rgb[3]);
double iso_tf_curve_opacity(const iso_tf_curve *curve, double x, double inside);

/* Returns all x at which a curve bends or steps (nodes and sharp midpoints), ascending and distinct; to be freed. */
double *iso_tf_curves_corners(const iso_tf_curves *curves, size_t *count);

/* Fits points whose lines in linear light are as close to the curves as a table can show. The caller has set all fields
 * of `curves`, also those missing in the file. ISO_E_RANGE, ISO_E_MEMORY. */
iso_status iso_tf_resample(const iso_tf_curves *curves, const char *path, iso_tf *tf, iso_error *err);
/* Sets tf->loss, the difference between rendered table and curves. ISO_E_RANGE, ISO_E_MEMORY. */
iso_status iso_tf_measure_loss(const iso_tf_curves *curves, iso_tf *tf, iso_error *err);

/* Converts a table to nodes of display color and opacity (for unit_mm) whose lines are within `most` of the table's
 * entries. grid: number of places at which the table is looked up; 0: its entries. x runs from lo to hi. */
iso_status iso_tf_reduce(const iso_tf_table *table, double unit_mm, size_t grid, double most, iso_tf_curves *curves,
                         iso_error *err);

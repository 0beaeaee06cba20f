/* SPDX-License-Identifier: MIT */
/* curves.h - transfer functions as other programs have them: one curve for color, one for opacity, each with nodes of its
 * own, a midpoint and a sharpness between two nodes, and a color space.
 *
 * The rules are those of VTK's vtkPiecewiseFunction and vtkColorTransferFunction, which Slicer and ParaView stand on; the
 * other programs draw lines between display colors, which is the same with a midpoint of 1/2, no sharpness, and RGB. */
#ifndef ISO_TF_CURVES_H
#define ISO_TF_CURVES_H

#include "tf/color_space.h"
#include "tf/tf.h"

typedef struct iso_tf_node {
    double x;
    double y[3];                /* display color, or opacity in y[0] */
    double midpoint, sharpness; /* up to the next node */
} iso_tf_node;

typedef struct iso_tf_curve {
    size_t count, room;
    iso_tf_node *nodes; /* ascending in x; two of one x make a step */
} iso_tf_curve;

typedef struct iso_tf_curves {
    iso_tf_curve color, opacity; /* opacity without nodes: the file says none */
    iso_color_space space;
    bool are_fractions;   /* x 0 is the volume's least value, 1 its largest */
    double unit_mm;       /* that opacities are for; 0: the file does not say */
    bool unit_is_default; /* of the program where the file is silent: --unit-distance may say another */
    bool unit_is_voxel;   /* unit_mm is in voxels */
    const char *unit_is;  /* in messages where unit_mm is 0: "in Inviwo a 150th of the volume's largest side" */
} iso_tf_curves;

void iso_tf_curves_destroy(iso_tf_curves *curves);

/* Behind the last. ISO_E_RANGE: not finite, a color, an opacity, a midpoint or a sharpness outside 0 to 1; ISO_E_MEMORY.
 * components: 3 of a color, 1 of an opacity. */
iso_status iso_tf_curve_add(iso_tf_curve *curve, iso_tf_node node, int components, const char *path, iso_error *err);
/* The same without midpoint and sharpness. */
iso_status iso_tf_curve_add_color(iso_tf_curve *curve, double x, const double rgb[3], const char *path, iso_error *err);
iso_status iso_tf_curve_add_opacity(iso_tf_curve *curve, double x, double opacity, const char *path, iso_error *err);
/* In order of x; nodes of one x stay as they were. */
void iso_tf_curve_sort(iso_tf_curve *curve);

/* The curves' value at x as seen from `inside`, which lies between the same nodes: at a step the side of `inside`
 * counts. */
void iso_tf_curve_color(const iso_tf_curve *curve, iso_color_space space, double x, double inside, double rgb[3]);
double iso_tf_curve_opacity(const iso_tf_curve *curve, double x, double inside);

/* Where a curve bends or steps: its nodes, and midpoints that are corners. Ascending, each once; to be freed. */
double *iso_tf_curves_corners(const iso_tf_curves *curves, size_t *count);

/* Points whose lines in linear light come as close to the curves as a table can show. What the file does not say has to be
 * in curves. ISO_E_RANGE, ISO_E_MEMORY. */
iso_status iso_tf_resample(const iso_tf_curves *curves, const char *path, iso_tf *tf, iso_error *err);
/* Sets tf->loss: how far what renderers look up is from the curves. ISO_E_RANGE, ISO_E_MEMORY. */
iso_status iso_tf_measure_loss(const iso_tf_curves *curves, iso_tf *tf, iso_error *err);

/* The way back: nodes of display color and opacity (of unit_mm) whose lines are within `most` of a table's entries; at
 * `grid` places the table is looked up, 0: at its entries. x runs from lo to hi. */
iso_status iso_tf_reduce(const iso_tf_table *table, double unit_mm, size_t grid, double most, iso_tf_curves *curves,
                         iso_error *err);

#endif

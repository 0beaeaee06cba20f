/* SPDX-License-Identifier: MIT */
/* slicer.h - what the three forms of 3D Slicer's volume properties share. */
#ifndef ISO_TF_SLICER_H
#define ISO_TF_SLICER_H

#include "tf/format.h"

/* Curves as Slicer writes them in text: "8 x y x y x y x y", or "8 x r g b x r g b". what: in messages. */
iso_status iso_slicer_curve(const char *text, const char *what, int components, const char *path, iso_tf_curve *curve,
                            iso_error *err);

/* What a voxel shows would depend on its gradient, which is nothing that a TF here can say: only 1 is taken.
 * hint: what to do, or "". */
iso_status iso_slicer_check_gradient(const iso_tf_curve *curve, const char *hint, const char *path, iso_error *err);

/* The three curves in text, and Slicer's own length of 1 mm, which these forms do not say. */
typedef struct iso_slicer_texts {
    const char *scalar_opacity, *gradient_opacity, *color;
} iso_slicer_texts;
iso_status iso_slicer_curves(const iso_slicer_texts *texts, const char *path, iso_tf_curves *curves, iso_error *err);

#endif

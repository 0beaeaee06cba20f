/* SPDX-License-Identifier: MIT */
/* slicer.h - parts shared by the readers of 3D Slicer's volume properties. */
#pragma once

#include "tf/format.h"

/* Refuses gradient opacities other than 1, which transfer functions here cannot express. hint: the remedy, or "". */
iso_status iso_slicer_check_gradient(const iso_tf_curve *curve, const char *hint, const char *path, iso_error *err);

/* The three curves in text. Opacities are for Slicer's 1 mm, which these forms do not store. */
typedef struct iso_slicer_texts {
    const char *scalar_opacity, *gradient_opacity, *color;
} iso_slicer_texts;
iso_status iso_slicer_curves(const iso_slicer_texts *texts, const char *path, iso_tf_curves *curves, iso_error *err);

/* SPDX-License-Identifier: MIT */
/* look.h - the benchmarks' view of a volume: an orthographic camera around the box, and one light or none. */
#pragma once

#include "image/image.h"
#include "pyramid/pyramid.h"
#include "scene/scene.h"

typedef struct iso_lab_look {
    size_t image_size;  /* pixels along an edge */
    bool shaded;        /* true: ambient .3, diffuse .7; false: emission only */
    double step_voxels; /* in voxels of the level */
} iso_lab_look;

/* Creates the view. Errors: ISO_E_MEMORY. */
iso_status iso_lab_view(const iso_lab_look *look, const iso_level *level0, const iso_tf *tf, iso_vec3 direction,
                          iso_view *view, iso_error *err);

/* Returns the largest alpha of an image; 0 if it is empty. */
double iso_lab_largest_alpha(const iso_image *image);

/* SPDX-License-Identifier: MIT */
/* look.h - how benchmarks look at a volume: an orthographic camera that frames the box, one light beside the viewer or
 * none. */
#ifndef ISO_LAB_LOOK_H
#define ISO_LAB_LOOK_H

#include "image/image.h"
#include "pyramid/pyramid.h"
#include "scene/scene.h"

typedef struct iso_lab_look {
    size_t image_size;  /* pixels along an edge */
    bool shaded;        /* ambient .3, diffuse .7; else emission alone */
    double step_voxels; /* of the level */
} iso_lab_look;

/* ISO_E_MEMORY. */
iso_status iso_lab_view(const iso_lab_look *look, const iso_level *level0, const iso_tf *tf, iso_vec3 direction,
                          iso_view *view, iso_error *err);

/* The largest alpha of an image: how much it shows at all. */
double iso_lab_largest_alpha(const iso_image *image);

#endif

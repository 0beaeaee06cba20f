/* SPDX-License-Identifier: MIT */
/* shading_error.h - how far a level's shading is from that of the finest: what `isoshade-lab consistency --shading` measures.
 *
 * Level 0 with its own directions is rendered once from each view, and so is
 * every level with every kind of directions, by the ray caster, with one
 * surface-like TF at all levels. An image's error is its structural
 * dissimilarity, DSSIM = (1 - SSIM) / 2, over what either image shows (ssim.h).
 * Angles are taken at the surface that the TF shows on level 0: voxels that it
 * shows beside voxels that it does not; as light is two-sided, so are they. */
#ifndef ISO_LAB_SHADING_ERROR_H
#define ISO_LAB_SHADING_ERROR_H

#include "lab/surface.h"
#include "scene/views.h"
#include "pyramid/pyramid.h"
#include "render/gl/raycaster.h"
#include "volume/synthetic.h"

/* A point of the surface, in index coordinates of level 0. */
typedef struct iso_surface_point {
    iso_vec3 at, finest, truth; /* directions: unit; truth is zero where there is none to know */
} iso_surface_point;

typedef struct iso_shading_subject {
    iso_gl *gl;
    int view_count;
    iso_otsu_surface surface; /* where it is left out, there is nothing below */
    iso_view views[ISO_DIAGONAL_VIEWS];
    iso_image finest[ISO_DIAGONAL_VIEWS]; /* the images of level 0 */
    size_t point_count;
    iso_surface_point *points;
} iso_shading_subject;

typedef struct iso_shading_error {
    double dssim[ISO_DIAGONAL_VIEWS];
    double dssim_mean;
    double alpha_max;                     /* of all pixels and views: how much is shown at all */
    double angle_mean_deg, angle_p95_deg; /* to level 0's directions; NaN: no surface */
    double truth_mean_deg;                /* to the field's gradients; NaN: none known */
    double length_mean; /* of the codes' directions in the voxels that hold the surface: their coherence */
} iso_shading_error;

/* What a subject is looked at with. */
typedef struct iso_shading_look {
    int view_count;    /* at most ISO_DIAGONAL_VIEWS */
    size_t image_size; /* pixels */
    double surface;    /* fraction of the range; 0: iso_surface_find() */
    bool any_surface;  /* what iso_surface_find() would leave out as well: the field was made for that surface */
} iso_shading_look;

/* s->surface.left_out says why there is nothing to measure; iso_shading_end() all the same.
 * level0 stays borrowed for the call alone. field: what the volume was sampled from, or NULL. */
iso_status iso_shading_begin(iso_shading_subject *s, iso_gl *gl, const iso_level *level0, iso_code code,
                             const iso_field *field, const iso_shading_look *look, iso_error *err);
void iso_shading_end(iso_shading_subject *s);

/* A level, and how it is shown. */
typedef struct iso_shading_shown {
    const iso_level *level;
    size_t k; /* the level's number */
    iso_code code;
    iso_direction_source source;
    const iso_tf_table *tf; /* instead of the view's; or NULL */
    double step_voxels;     /* 0: the view's; not looked at by iso_shading_measure() */
} iso_shading_shown;

/* k: the level's number. tf: instead of the views' own, or NULL. */
iso_status iso_shading_measure(const iso_shading_subject *s, const iso_shading_shown *shown, iso_shading_error *e,
                               iso_error *err);

/* What is left when directions are level 0's and the scalar alone is level k's: DSSIM only. */
iso_status iso_shading_floor(const iso_shading_subject *s, const iso_level *level0, const iso_level *level, size_t k,
                             iso_code code, iso_shading_error *e, iso_error *err);

/* One view of a level, as measured. */
iso_status iso_shading_render(const iso_shading_subject *s, int view, const iso_shading_shown *shown, iso_image *image,
                              iso_error *err);

#endif

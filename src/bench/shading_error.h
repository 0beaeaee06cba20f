/* SPDX-License-Identifier: MIT */
/* shading_error.h - how far a level's shading is from that of the finest: what `bench consistency --shading` measures.
 *
 * Level 0 with its own directions is rendered once from each view, and so is
 * every level with every kind of directions, by the ray caster, with one
 * surface-like TF at all levels. An image's error is its structural
 * dissimilarity, DSSIM = (1 - SSIM) / 2, over what either image shows (ssim.h).
 * Angles are taken at the surface that the TF shows on level 0: voxels that it
 * shows beside voxels that it does not; as light is two-sided, so are they. */
#ifndef ISO_BENCH_SHADING_ERROR_H
#define ISO_BENCH_SHADING_ERROR_H

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
    double surface; /* fraction of the range */
    iso_view views[ISO_DIAGONAL_VIEWS];
    iso_image finest[ISO_DIAGONAL_VIEWS]; /* the images of level 0 */
    size_t point_count;
    iso_surface_point *points;
} iso_shading_subject;

typedef struct iso_shading_error {
    double dssim[ISO_DIAGONAL_VIEWS];
    double dssim_mean;
    double angle_mean_deg, angle_p95_deg; /* to level 0's directions; NaN: no surface */
    double truth_mean_deg;                /* to the field's gradients; NaN: none known */
    double length_mean; /* of the codes' directions in the voxels that hold the surface: their coherence */
} iso_shading_error;

/* A surface: opacity rises from 0 to .8 over a tenth of the volume's range about this fraction of it. */
typedef struct iso_shading_tf {
    iso_tf_point points[4];
} iso_shading_tf;
iso_tf iso_shading_make_tf(double fraction, iso_shading_tf *storage);

/* Where a surface is, as a fraction of the range: [otsu-1979]:
 *  the value that separates the voxels into the two classes of the least variance. One rule for
 * all volumes; half-way values keep their place under a mean of eight. */
double iso_otsu_fraction(const iso_level *level);

/* What a subject is looked at with. */
typedef struct iso_shading_look {
    int view_count;    /* at most ISO_DIAGONAL_VIEWS */
    size_t image_size; /* pixels */
    double surface;    /* fraction of the range; 0: iso_otsu_fraction() */
} iso_shading_look;

/* level0 stays borrowed for the call alone. field: what the volume was sampled from, or NULL. */
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

/* SPDX-License-Identifier: MIT */
/* shading_error.h - distance of a level's shading from the finest one's, as `isoshade-lab consistency --shading`
 * measures it.
 *
 * Level 0 with its own directions is rendered once per view, and so is every level with every kind of directions, by
 * the ray caster, with one surface-like TF at all levels. An image's error is its structural dissimilarity DSSIM = (1 -
 * SSIM) / 2 over visible pixels (ssim.h). Angles are taken at the visible surface of level 0: visible voxels next to
 * invisible ones. Opposite directions are equal, since light is two-sided. */
#pragma once

#include "lab/surface.h"
#include "scene/views.h"
#include "pyramid/pyramid.h"
#include "render/gl/raycaster.h"
#include "volume/synthetic.h"

/* A point of the surface, in index coordinates of level 0. */
typedef struct iso_surface_point {
    iso_vec3 at, finest, truth; /* unit directions; truth: exact gradient, zero if unknown */
} iso_surface_point;

typedef struct iso_shading_subject {
    iso_gl *gl;
    int view_count;
    iso_otsu_surface surface; /* if it is left out, all members below are empty */
    iso_view views[ISO_DIAGONAL_VIEWS];
    iso_image finest[ISO_DIAGONAL_VIEWS]; /* level 0, one per view */
    size_t point_count;
    iso_surface_point *points;
} iso_shading_subject;

typedef struct iso_shading_error {
    double dssim[ISO_DIAGONAL_VIEWS];
    double dssim_mean;
    double alpha_max;                     /* largest alpha of all pixels and views; 0 if they are empty */
    double angle_mean_deg, angle_p95_deg; /* to level 0's directions; NaN: no surface */
    double truth_mean_deg;                /* to the field's exact gradients; NaN: unknown */
    double length_mean;                   /* coherence: mean length of the codes' directions in voxels of the surface */
} iso_shading_error;

/* View settings of a subject. */
typedef struct iso_shading_look {
    int view_count;    /* at most ISO_DIAGONAL_VIEWS */
    size_t image_size; /* pixels */
    double surface;    /* fraction of the range; 0: iso_surface_find() */
    bool any_surface;  /* accepts surfaces that iso_surface_find() leaves out: the field was made for this surface */
} iso_shading_look;

/* Renders level 0. If there is nothing to measure, s->surface.left_out is the reason; call iso_shading_end() anyway.
 * level0 is borrowed for this call only. field: exact field of the volume, or NULL. */
iso_status iso_shading_begin(iso_shading_subject *s, iso_gl *gl, const iso_level *level0, iso_code code,
                             const iso_field *field, const iso_shading_look *look, iso_error *err);
void iso_shading_end(iso_shading_subject *s);

/* A level and how it is shown. */
typedef struct iso_shading_shown {
    const iso_level *level;
    size_t k; /* the level's number */
    iso_code code;
    iso_direction_source source;
    const iso_tf_table *tf; /* overrides the view's table; or NULL */
    double step_voxels;     /* 0: the view's; iso_shading_measure() ignores it */
} iso_shading_shown;

/* Renders and measures a level in all views. */
iso_status iso_shading_measure(const iso_shading_subject *s, const iso_shading_shown *shown, iso_shading_error *e,
                               iso_error *err);

/* Measures the DSSIM with level 0's directions and level k's scalar: the error that directions cannot remove. */
iso_status iso_shading_floor(const iso_shading_subject *s, const iso_level *level0, const iso_level *level, size_t k,
                             iso_code code, iso_shading_error *e, iso_error *err);

/* Renders one view of a level. */
iso_status iso_shading_render(const iso_shading_subject *s, int view, const iso_shading_shown *shown, iso_image *image,
                              iso_error *err);

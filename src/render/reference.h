/* SPDX-License-Identifier: MIT */
/* reference.h - the reference renderer: the rendering equation in double precision on the CPU.
 *
 * Proved on closed forms (tests/test_reference.c): a slab, 1 - exp(-sigma d); a linear ramp of extinction; a sphere.
 * Results do not depend on threads.
 *
 * Quadratures:
 *   converged  rays are cut where the trilinear cell changes and where the TF bends; each piece
 *              is integrated by Gauss and Legendre's rule with a proved bound (cell_ray.h), or,
 *              if cell_ray.h does not apply, by Romberg-extrapolated midpoint sums, halved until
 *              the change is below tolerance: no step is left in the result.
 *   midpoint   as the GL ray caster: segments [k ds, (k+1) ds] clipped to
 *              the box, sample in the middle, 1 - exp(-sigma length).
 *   preintegrated  the same segments, with the TF's means between the values at
 *              both ends (tf/integral.h), shaded in the middle.
 *   povray     as POV-Ray's method 2: N equal intervals per ray, weight
 *              tau exp(-tau / 2) (see exporters/povray).
 *   first hit  no quadrature: the first point of the ray inside the box where
 *              the value is at least iso, opaque, C = c(iso) shade(d). */
#pragma once

#include "base/progress.h"
#include "brick/bricks.h"
#include "image/image.h"
#include "scene/field.h"
#include "scene/scene.h"

/* A medium other than a scalar with one transfer function, such as colors stored at the voxels. */
typedef struct iso_emitter_place {
    const iso_view *view;
    const struct iso_sampler *sampler; /* of the level that is rendered */
    iso_vec3 index, to_viewer;         /* index coordinates of the level; world, unit */
} iso_emitter_place;
typedef struct iso_emitter {
    /* Returns the extinction per mm; color: extinction * color * shade. Called from several threads. */
    double (*emit)(const struct iso_emitter *e, const iso_emitter_place *at, double color[3]);
    const void *field; /* what emit looks at */
} iso_emitter;

typedef enum iso_quadrature {
    ISO_QUADRATURE_CONVERGED,
    ISO_QUADRATURE_MIDPOINT,
    ISO_QUADRATURE_PREINTEGRATED,
    ISO_QUADRATURE_POVRAY,
    ISO_QUADRATURE_FIRST_HIT
} iso_quadrature;

typedef struct iso_reference_options {
    iso_quadrature quadrature;
    iso_direction_source source;
    double step_voxels; /* midpoint and preintegrated; 0: the view's */
    size_t intervals;   /* povray */
    size_t planes;      /* povray: that cut the box across the view, each piece of a ray with its own intervals */
    double tolerance;   /* converged, per pixel value: of the parts that are halved until they stay, an estimate */
    double most_error;  /* the same, of the parts with a proved bound */
    bool plain;         /* True to skip nothing and halve every piece: slow, for comparison */
    double iso;         /* first hit: the value of the surface */
    iso_surface_output output; /* first hit: the property of the hit that the image shows */
    /* Converged and midpoint: instead of the level's scalar and the view's transfer function; or NULL. Converged: it is
     * smooth within the cells between the level's voxel centers. */
    const iso_emitter *emitter;
    int threads;
    struct iso_reference_result *result; /* filled if it is not NULL */
} iso_reference_options;
iso_reference_options iso_reference_defaults(void);

/* Results besides the image. */
typedef struct iso_reference_result {
    double *rgba; /* the caller's, or NULL: the pixels before they are rounded to floats, 4 each */
    /* Converged: how far a color or the opacity of any pixel is from the equation, at most. NaN: another quadrature. */
    double error;
    bool
        is_proved; /* True if every piece has its bound (cell_ray.h); otherwise some pieces contribute an estimate, the
                    * change by halving */
} iso_reference_result;

/* Returns the scalar at a point of the sampler's level (index coordinates). rgbs: linear color and extinction per mm,
 * by the view's 1D or 2D transfer function and extinction scale. A region of interest is ignored. */
double iso_reference_classify(const struct iso_sampler *sampler, const iso_view *view, iso_vec3 index, double rgbs[4]);

/* Creates *image (view->width x view->height, RGBA, premultiplied, background
 * included in the color, A = 1 - T_end). */
iso_status iso_reference_render(const iso_level *level, iso_code code, const iso_view *view,
                                const iso_reference_options *opt, iso_image *image, const iso_progress *progress,
                                iso_error *err);

/* Renders bricks of mixed resolution, with their own directions; opt->source is ignored. */
iso_status iso_reference_render_bricks(const iso_brick_field *bricks, const iso_view *view,
                                       const iso_reference_options *opt, iso_image *image, const iso_progress *progress,
                                       iso_error *err);

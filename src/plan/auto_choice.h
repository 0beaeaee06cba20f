/* SPDX-License-Identifier: MIT */
/* auto_choice.h - which levels to build for a volume and a transfer function, and how to show them, within a budget.
 *
 * A design is a scalar filter, what becomes of the transfer function, and whether there is an extinction scale. What its
 * pictures are like is predicted, not looked at. Of each level k and design d is measured over the fine voxels that the
 * transfer function shows
 *
 *     e_d,k = rms of the differences between the fine voxels' opacities and those that the level shows there
 *
 * (fit/extinction_scale.h), and the predicted logarithm of d's DSSIM over the default's is
 *
 *     p_d,k = a_d,k + b_d,k log(e_d,k / e_default,k)
 *
 * a and b were fitted by least squares to measured pictures of five volumes under five transfer functions, and tested on
 * four others (doc/results/auto.md). Most of what is predicted is a, what a design gains on the whole; e tells little more.
 * The default stays unless another is predicted to be ISO_AUTO_GAIN nearer over all levels. */
#ifndef ISO_PLAN_AUTO_CHOICE_H
#define ISO_PLAN_AUTO_CHOICE_H

#include <jansson.h>

#include "pyramid/pyramid.h"
#include "tf/tf.h"

typedef struct iso_auto_design {
    const char *name, *summary;
    iso_scalar_filter scalar;
    bool adapted, scaled, is_2d; /* the transfer function is adapted; an extinction scale; a 2D transfer function */
    bool always;                 /* adapted whatever small views say (tf/adapt.h) */
    int bytes;                   /* a voxel of a coarse level beside its scalar: three of its direction, and more */
    double prior[3], slope[3];   /* a and b, of levels 1, 2, and 3 and above */
} iso_auto_design;

enum { ISO_AUTO_DESIGNS = 11, ISO_AUTO_LEAST_BYTES = 3, ISO_AUTO_MOST_BYTES = 4 };
#define ISO_AUTO_GAIN 0.02

/* The first is the default. */
const iso_auto_design *iso_auto_design_at(size_t index);

typedef struct iso_auto_choice {
    size_t level_count;                 /* with level 0 */
    double error[ISO_AUTO_DESIGNS][32]; /* e, of levels 1 and up */
    double predicted[ISO_AUTO_DESIGNS]; /* DSSIM over the default's, geometric mean over the levels */
    size_t chosen;
} iso_auto_choice;

/* Measures e of all designs: builds the levels with each scalar filter. opt: levels, estimator, threads. ISO_E_MEMORY. */
iso_status iso_auto_measure(const iso_volume *v, const iso_pyramid_options *opt, const iso_tf_table *tf,
                            iso_auto_choice *choice, const iso_progress *progress, iso_error *err);
/* Predicts, and chooses the best of at most so many bytes. ISO_E_RANGE: fewer than ISO_AUTO_LEAST_BYTES. */
iso_status iso_auto_choose(iso_auto_choice *choice, int budget_bytes, iso_error *err);

/* How a level that is there already is shown best: of the designs with this scalar filter and at most so many bytes the one
 * of least p_d,k. The small views' choice between the transfer functions stays unless another is predicted to be
 * ISO_AUTO_GAIN nearer. doc/results/auto.md says how little that gains over one fixed design. *gain: its
 * predicted DSSIM over that of the small views' choice. ISO_E_RANGE: a budget below ISO_AUTO_LEAST_BYTES; a filter that
 * no design has. */
iso_status iso_auto_choose_level(const iso_auto_choice *choice, size_t level, iso_scalar_filter scalar,
                                 int budget_bytes, size_t *design, double *gain, iso_error *err);

/* For pyramid.json (doc/formats.md). tf: its path. */
json_t *iso_auto_to_json(const iso_auto_choice *choice, int budget_bytes, const char *tf);
/* "--adapt --extinction-scale": how a design is shown; "" where nothing is needed. */
const char *iso_auto_options(const iso_auto_design *d);

#endif

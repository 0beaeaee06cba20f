/* SPDX-License-Identifier: MIT */
/* paper_own.h - shared by the figures of the papers: drawings, a default volume by a formula, and its scene. */
#pragma once

#include "figure/paper.h"
#include "pyramid/pyramid.h"

/* Begins a drawing in a panel: gnuplot's script until iso_page_plot_end(), in millimeters from the lower left
 * corner, without axes. The function thick(mm) gives line widths: "lw thick(0.2)". */
FILE *iso_paper_drawing(const iso_paper *p, size_t row, size_t column, const char *title, const char *note);

/* Returns 1, 2 or 5 times a power of ten: three to seven steps per range. */
double iso_paper_tick_step(double range);

/* ---- the volume ---- */

typedef struct iso_paper_own {
    const char *name; /* in captions */
    iso_status (*make)(iso_volume *v, iso_error *err);
} iso_paper_own;

/* Loads the given volume, or the kind's own, as a pyramid. The call sets the threads of `build`. */
iso_status iso_paper_load(const iso_figure_job *job, const iso_paper_own *own, const iso_pyramid_options *build,
                          iso_pyramid *p, iso_error *err);
/* Returns the volume's name for captions. */
const char *iso_paper_volume_name(const iso_figure_job *job, const iso_paper_own *own);

/* The given scene, or the kind's own: its transfer function on white, under one light. */
typedef struct iso_paper_look {
    const char *view; /* syntax of --view */
    const iso_tf_point *points;
    size_t point_count, width, height;
    double zoom; /* for the kind's own volume */
    iso_shading shading;
} iso_paper_look;
iso_status iso_paper_scene(const iso_figure_job *job, const iso_paper_look *own, const iso_pyramid *p, iso_scene *scene,
                           iso_error *err);

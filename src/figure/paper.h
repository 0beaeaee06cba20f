/* SPDX-License-Identifier: MIT */
/* paper.h - what the figures of the papers share: panels in rows, a volume by a formula where no file is named, and its
 * scene. */
#ifndef ISO_FIGURE_PAPER_H
#define ISO_FIGURE_PAPER_H

#include "figure/job.h"
#include "pyramid/pyramid.h"

/* ---- rows of panels ---- */

typedef struct iso_paper_row {
    size_t columns;
    double aspect;            /* height of a panel over its width */
    double left_mm, right_mm; /* free beside the panels: axes, color bars */
    double gap_mm;            /* between panels */
    double foot_mm;           /* below the panels, over the notes: axes */
    double most_mm;           /* of a panel's width */
    double below_mm;          /* left free below the notes */
    bool has_titles, has_notes;
} iso_paper_row;

enum { ISO_PAPER_MOST_ROWS = 8 };
typedef struct iso_paper {
    const iso_figure_job *job;
    iso_page *page;
    size_t row_count;
    iso_paper_row rows[ISO_PAPER_MOST_ROWS];
    double line_mm[ISO_PAGE_ROLES];                                    /* as laid out; texts may become smaller */
    double panel_mm[ISO_PAPER_MOST_ROWS], top_mm[ISO_PAPER_MOST_ROWS]; /* of the panels of each row */
} iso_paper;

/* Sets the page's size: panels as wide as it has room for. ISO_E_RANGE where they would be too small to show
 * anything. */
iso_status iso_paper_lay_out(iso_paper *p, const iso_figure_job *job, iso_page *page, const iso_paper_row *rows,
                             size_t count, iso_error *err);
/* Where a panel stands; its title above and its note below are put on the page. NULL: none. A text that is wider than
 * the panel and the gap beside it becomes smaller, down to 6 points, with all of its role. */
iso_page_box iso_paper_panel(const iso_paper *p, size_t row, size_t column, const char *title, const char *note);
/* Pixels that a picture of the row has along its width, a pixel a dot. */
size_t iso_paper_dots(const iso_paper *p, size_t row);
/* A panel that is a drawing: gnuplot's script until iso_page_plot_end(), in millimeters from its lower left corner,
 * without axes. A line is as thick as the function thick(mm) says: "lw thick(0.2)". */
FILE *iso_paper_drawing(const iso_paper *p, size_t row, size_t column, const char *title, const char *note);
/* A panel that is a picture, a pixel a dot. */
iso_page_box iso_paper_picture(const iso_paper *p, size_t row, size_t column, const char *title, const char *note,
                               const iso_image *image);
/* The box without its size: what is put there stands a pixel a dot. */
iso_page_box iso_paper_corner(iso_page_box box);

/* 1, 2 or 5 times a power of ten, three to seven of them in a range. */
double iso_paper_tick_step(double range);

/* ---- the volume ---- */

typedef struct iso_paper_own {
    const char *name; /* in captions */
    iso_status (*make)(iso_volume *v, iso_error *err);
} iso_paper_own;

/* The volume that is asked for, or the kind's own, as a pyramid; `build` says how, its threads are set here. */
iso_status iso_paper_load(const iso_figure_job *job, const iso_paper_own *own, const iso_pyramid_options *build,
                          iso_pyramid *p, iso_error *err);
/* What a caption calls it. */
const char *iso_paper_volume_name(const iso_figure_job *job, const iso_paper_own *own);

/* The scene that is asked for; else one of the kind's own: its transfer function on white, under one light. */
typedef struct iso_paper_look {
    const char *view; /* as --view has it */
    const iso_tf_point *points;
    size_t point_count, width, height;
    double zoom; /* of the kind's own volume */
    iso_shading shading;
} iso_paper_look;
iso_status iso_paper_scene(const iso_figure_job *job, const iso_paper_look *own, const iso_pyramid *p, iso_scene *scene,
                           iso_error *err);

#endif

/* SPDX-License-Identifier: MIT */
/* paper.h - panels in rows, as the figures of papers have them. */
#pragma once

#include "figure/job.h"

typedef struct iso_paper_row {
    size_t columns;
    double aspect;            /* height divided by width of a panel */
    double left_mm, right_mm; /* free space left and right of the panels: axes, color bars */
    double gap_mm;            /* between panels */
    double foot_mm;           /* free space below the panels, above the notes: axes */
    double most_mm;           /* largest width of a panel */
    double below_mm;          /* free space below the notes */
    bool has_titles, has_notes;
} iso_paper_row;

enum { ISO_PAPER_MOST_ROWS = 8 };
typedef struct iso_paper {
    const iso_figure_job *job;
    iso_page *page;
    size_t row_count;
    iso_paper_row rows[ISO_PAPER_MOST_ROWS];
    double line_mm[ISO_PAGE_ROLES];                                    /* after layout; texts may become smaller */
    double panel_mm[ISO_PAPER_MOST_ROWS], top_mm[ISO_PAPER_MOST_ROWS]; /* of the panels of each row */
} iso_paper;

/* Sets the page's size, with panels as wide as possible. ISO_E_RANGE: they are too small. */
iso_status iso_paper_lay_out(iso_paper *p, const iso_figure_job *job, iso_page *page, const iso_paper_row *rows,
                             size_t count, iso_error *err);
/* Puts a panel's title above it and its note below (NULL: none), and returns its box. If a text is wider than the
 * panel and its gap, all texts of its role become smaller, down to 6 points. */
iso_page_box iso_paper_panel(const iso_paper *p, size_t row, size_t column, const char *title, const char *note);
/* Returns the width of a row's pictures in pixels, one per dot. */
size_t iso_paper_dots(const iso_paper *p, size_t row);
/* Puts a picture into a panel, one pixel per dot. */
iso_page_box iso_paper_picture(const iso_paper *p, size_t row, size_t column, const char *title, const char *note,
                               const iso_image *image);
/* Returns the box without its size, for contents with one pixel per dot. */
iso_page_box iso_paper_corner(iso_page_box box);

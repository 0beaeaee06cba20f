/* SPDX-License-Identifier: MIT */
/* columns.h - several pictures of one subject side by side, rendered for print with one pixel per dot. Below each
 * there may be an inset, and a map of its difference from the first. */
#pragma once

#include "figure/tf_bar.h"

enum { ISO_FIGURE_MOST_COLUMNS = 64 };

typedef struct iso_figure_columns {
    const iso_figure_job *job;
    size_t count, per_row; /* columns, and how many of them per row; 0: all. Maps and insets need a single row */
    char titles[ISO_FIGURE_MOST_COLUMNS][96];
    double aspect;          /* width divided by height of a picture */
    bool compared, in_logs; /* True for maps; on a log scale */
    double foot_mm;         /* free space at the bottom of the page */
    const char *color_text; /* text of the color bar of pictures that show data by colors, or NULL */
    double color_range[2];
    /* Renders a column of width x height pixels. mm_per_pixel: 0 if there is no scale. */
    iso_status (*render)(void *user, size_t column, size_t width, size_t height, iso_image *image, double *mm_per_pixel,
                         iso_error *err);
    void *user;
    const iso_renderer_info *const *drawn_by; /* read after rendering, for the caption; or NULL */
    iso_figure_tf_foot tf;                    /* bar below the pictures */
} iso_figure_columns;

/* Draws pictures and maps, and writes the caption: "Name: RMSE .., ...", scale bar, inset, colors. before: writes
 * the start of the caption, once the size of the pictures is known. */
iso_status iso_figure_draw_columns(const iso_figure_columns *columns, iso_page *page, iso_error *err);

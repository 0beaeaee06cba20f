/* SPDX-License-Identifier: MIT */
/* columns.h - pictures of one thing in several ways side by side: rendered for their places in print, a pixel a dot. Below
 * each an inset where one is asked for, and a map of how far it is from the first. */
#ifndef ISO_FIGURE_COLUMNS_H
#define ISO_FIGURE_COLUMNS_H

#include "figure/tf_bar.h"

enum { ISO_FIGURE_MOST_COLUMNS = 64 };

typedef struct iso_figure_columns {
    const iso_figure_job *job;
    size_t count, a_row; /* columns, and how many stand in a row; 0: all. Maps and insets are of a single row */
    char titles[ISO_FIGURE_MOST_COLUMNS][96];
    double aspect;          /* width over height of a picture */
    bool compared, in_logs; /* with maps, on a linear scale or one of logs */
    double foot_mm;         /* left free at the bottom of the page */
    const char *color_text; /* pictures that show data by colors have a bar of this text, or NULL */
    double color_range[2];
    /* Creates the picture of a column, so many pixels large. mm_per_pixel: 0 where there is no scale. */
    iso_status (*render)(void *user, size_t column, size_t width, size_t height, iso_image *image, double *mm_per_pixel,
                         iso_error *err);
    void *user;
    const iso_renderer_info *const *drawn_by; /* looked at when pictures are there, for the caption; or NULL */
    iso_figure_tf_foot tf;                    /* stands below as a bar */
} iso_figure_columns;

/* Pictures and maps, and what a caption says of them: "Name: RMSE .., ...", scale bar, inset, colors. before: what the caption
 * begins with is written here, when the size of the pictures is known. */
iso_status iso_figure_draw_columns(const iso_figure_columns *columns, iso_page *page, iso_error *err);

#endif

/* SPDX-License-Identifier: MIT */
/* sheet.h - rows and columns of pictures and difference maps on a page. of_report.c fills them from a report,
 * levels.c by rendering for print. */
#pragma once

#include <stdio.h>

#include "compare/metrics.h"
#include "figure/page.h"
#include "image/image.h"

/* One picture, or one difference map (against is set). A '|' in a text is a line break if the text is too wide. */
typedef struct iso_figure_panel {
    size_t row, column;
    const char *image, *against;        /* names in the report; borrowed from it */
    char title[96], note[96], side[96]; /* above, below, and upright on the left */
    iso_image a, b;
    iso_metrics metrics; /* of a difference */
    double mm_per_pixel; /* 0: unknown */
    bool scale_bar;
    double mark[4]; /* framed part of the picture: left, top, width, height; zeroed: none */
    bool framed;    /* True if the picture itself has a frame */
} iso_figure_panel;

typedef struct iso_figure_sheet {
    const iso_figure_panel *panels;
    size_t count, rows, columns;
    size_t rows_per_side; /* rows that share the text on the left, which the first of them has */
    bool in_logs;
    double low, high;           /* of the difference maps; log10 if in_logs */
    double width_mm, height_mm; /* at most */
    bool is_pixel_per_dot;      /* True if pictures have one pixel per dot; otherwise they fill their boxes */
    const iso_colormap *map;
    const char *legend; /* text of a color bar for pictures that show data, low to high; NULL: only maps have one */
    double foot_mm;     /* free space at the bottom */
} iso_figure_sheet;

/* Returns the printed width of a panel; only the sizes of the images are read. ISO_E_RANGE as iso_figure_draw(). */
iso_status iso_figure_panel_width(const iso_figure_sheet *sheet, double *width_mm, iso_error *err);

/* Draws the sheet. ISO_E_RANGE: the panels do not fit with legible texts. */
iso_status iso_figure_draw(const iso_figure_sheet *sheet, iso_page *page, iso_error *err);

/* Returns the end of a color scale for numbers up to this: 1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6 or 8 times a power of
 * ten, not below the number; 1 if the number is not positive. */
double iso_figure_round_up(double number);

/* Writes the colors of maps into a caption. */
void iso_figure_describe(const iso_figure_sheet *sheet, FILE *caption);

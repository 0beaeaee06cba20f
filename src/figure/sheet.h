/* SPDX-License-Identifier: MIT */
/* sheet.h - rows and columns of pictures and difference maps on a page. Who calls it decides what they show: of_report.c
 * from a report, levels.c by rendering for the size of the print. */
#ifndef ISO_FIGURE_SHEET_H
#define ISO_FIGURE_SHEET_H

#include <stdio.h>

#include "compare/metrics.h"
#include "figure/page.h"
#include "image/image.h"

/* One picture, or one difference map (against set). A '|' in a text breaks the line where it does not fit in one. */
typedef struct iso_figure_panel {
    size_t row, column;
    const char *image, *against;        /* names in the report; borrowed from it */
    char title[96], note[96], side[96]; /* above, below, and on the left, upright */
    iso_image a, b;
    iso_metrics metrics; /* of a difference */
    double mm_per_pixel; /* 0: unknown */
    bool scale_bar;
    double mark[4]; /* a part of the picture that is framed: left, top, wide, high; zeroed: none */
    bool framed;    /* the picture itself is */
} iso_figure_panel;

typedef struct iso_figure_sheet {
    const iso_figure_panel *panels;
    size_t count, rows, columns;
    size_t rows_a_side; /* rows that share the text on the left, which stands in the first of them */
    bool in_logs;
    double low, high;           /* of the difference maps; log10 when in_logs */
    double width_mm, height_mm; /* at most */
    bool a_pixel_a_dot;         /* pictures have as many pixels as their places have dots; else they fill these */
    const iso_colormap *map;
    const char *legend; /* text of a color bar for pictures that show data, low to high; NULL: for maps alone */
    double foot_mm;     /* left free below */
} iso_figure_sheet;

/* The width of a panel as it is printed; of the images only the sizes are looked at. ISO_E_RANGE as iso_figure_draw(). */
iso_status iso_figure_panel_width(const iso_figure_sheet *sheet, double *width_mm, iso_error *err);

/* ISO_E_RANGE: the panels do not fit with texts that can be read. */
iso_status iso_figure_draw(const iso_figure_sheet *sheet, iso_page *page, iso_error *err);

/* The end of a scale of colors for numbers up to this: 1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6 or 8 times a power of ten, no
 * less than the number; 1 where that is not above 0. */
double iso_figure_round_up(double number);

/* What a caption says of the colors of maps. */
void iso_figure_describe(const iso_figure_sheet *sheet, FILE *caption);

#endif

/* SPDX-License-Identifier: MIT */
/* page.h - a figure as it is printed: what stands where, in millimeters from the left and the top edge.
 *
 *     figure.pdf        vector text, fonts embedded, pictures as they are, a pixel a dot
 *     figure.svg
 *     figure.png        the same in dots
 *     figure-latex.tex  for \input: text by LaTeX in the fonts of the paper, over figure-latex.pdf
 *     caption.txt
 *
 * With sources the script stays, by which gnuplot draws them, and the pixels of its pictures.
 *
 * Pictures are laid on a grid of dots and never resampled. Calls that put something keep the first error, which
 * iso_page_finish() returns, so that a layout needs no checks. Order: pictures lie below plots, these below texts, lines and
 * rectangles. */
#ifndef ISO_FIGURE_PAGE_H
#define ISO_FIGURE_PAGE_H

#include <stdio.h>

#include "base/status.h"
#include "figure/colormap.h"
#include "image/image.h"

typedef struct iso_page iso_page;

typedef struct iso_page_box {
    double left, top, width, height;
} iso_page_box;

/* Sizes in print: journals ask for 6 points at least. */
typedef enum iso_page_role { ISO_PAGE_TITLE, ISO_PAGE_NOTE, ISO_PAGE_ROLES } iso_page_role;
typedef enum iso_page_align { ISO_PAGE_LEFT, ISO_PAGE_CENTER, ISO_PAGE_RIGHT } iso_page_align;

iso_status iso_page_create(iso_page **page, const char *dir, double dpi, iso_error *err);
void iso_page_destroy(iso_page *page); /* accepts NULL */

/* Before anything is put on it; rounded down to whole dots. */
void iso_page_set_size(iso_page *page, double width_mm, double height_mm);
double iso_page_width(const iso_page *page);
double iso_page_height(const iso_page *page);
/* Dots within a length, at least 1; and the length of so many. */
size_t iso_page_dots(const iso_page *page, double mm);
double iso_page_dots_mm(const iso_page *page, size_t dots);
/* Where the file of the caption is written. */
FILE *iso_page_caption(iso_page *page);
const char *iso_page_folder(const iso_page *page);
/* Another file of the figure, such as an animation: its path in the folder of the page, to be freed. */
char *iso_page_file(const iso_page *page, const char *name);

/* ---- text ---- */

double iso_page_text_pt(const iso_page *page, iso_page_role role);
/* 6 to 9 points; of all texts of that role. */
void iso_page_set_text_pt(iso_page *page, iso_page_role role, double pt);
/* The width of a text, rather too wide than too narrow; the distance between lines. */
double iso_page_text_mm(const iso_page *page, iso_page_role role, const char *text);
double iso_page_line_mm(const iso_page *page, iso_page_role role);

/* One line; y is its middle. The text is UTF-8 and stands as it is, in the form for LaTeX too. upright: reading upwards,
 * x is its middle. color: "#rrggbb", NULL: black. */
typedef struct iso_page_text {
    double x, y;
    iso_page_role role;
    iso_page_align align;
    int upright;
    const char *color;
} iso_page_text;
void iso_page_put_text(iso_page *page, const iso_page_text *where, const char *text);

/* ---- pictures ---- */

/* A picture whose box has width 0 stands at the box's left and top, a pixel a dot; else it fills the box, each pixel so many
 * times as it takes for a dot to be no smaller than a pixel; one that is a pixel wide, a color bar, as it is. */
size_t iso_page_times(const iso_page *page, double width_mm, size_t pixels);

/* Pixels as `render` writes them to a PNG. */
void iso_page_put_picture(iso_page *page, const iso_page_box *box, const iso_image *image);
/* Bytes of sRGB. */
void iso_page_put_colors(iso_page *page, const iso_page_box *box, const unsigned char *rgb, size_t width,
                         size_t height);
/* Numbers by a color map, from low to high. */
void iso_page_put_values(iso_page *page, const iso_page_box *box, const float *values, size_t width, size_t height,
                         const iso_colormap *map, const double range[2]);
/* For numbers of this range: a bar with ticks on its right and a text on its left, reading upwards. In logs the range is of
 * exponents of ten. box is that of the bar alone. */
typedef struct iso_page_color_bar {
    iso_page_box box;
    const iso_colormap *map;
    double range[2];
    int in_logs;
    const char *text; /* a '|' begins a new line; or NULL */
} iso_page_color_bar;
void iso_page_put_color_bar(iso_page *page, const iso_page_color_bar *bar);
/* What stands on the left and the right of the bar. */
double iso_page_color_bar_left_mm(const iso_page *page, const iso_page_color_bar *bar);
double iso_page_color_bar_right_mm(const iso_page *page, const iso_page_color_bar *bar);

/* A bar of a round length in the lower left corner of a picture that stands in `box`, or in another one where that covers
 * less of what the picture shows (its opacity); in black or white, by what is below it. The caption says what it is. mm_per_pixel 0: none. */
void iso_page_put_scale_bar(iso_page *page, const iso_page_box *box, const iso_image *image, double mm_per_pixel);
/* The same without a word in the caption. */
void iso_page_draw_scale_bar(iso_page *page, const iso_page_box *box, const iso_image *image, double mm_per_pixel);
/* 1, 2 or 5 times a power of ten, at most a third of the width. */
double iso_page_bar_mm(double width_mm);

/* Panels get letters, (a) for the first of the top row, in their upper left corners: pictures by themselves, bars of colors
 * not, and what iso_page_add_panel() names. */
void iso_page_letter_panels(iso_page *page);
void iso_page_add_panel(iso_page *page, const iso_page_box *box);

/* ---- lines ---- */

typedef struct iso_page_pen {
    const char *color; /* "#rrggbb" */
    double pt;
    int dashed;
} iso_page_pen;
void iso_page_put_line(iso_page *page, double x0, double y0, double x1, double y1, const iso_page_pen *pen);
/* fill: "#rrggbb" or NULL; pen: or NULL. */
void iso_page_put_rectangle(iso_page *page, const iso_page_box *box, const char *fill, const iso_page_pen *pen);

/* ---- plots ---- */

/* What is written to the file until the plot ends is gnuplot's: ranges, ticks, datablocks, and one "plot" whose axes fill
 * the box; ticks and labels of axes stand around it. Texts go through the functions of page.gp: title('..'), note('..');
 * formats of ticks through ticks('..'), of powers of ten
 * by `powers`. The fonts are note_font and title_font, a width of lines pen(points). The style is set: no key, ticks outwards, a thin border left and below. */
FILE *iso_page_plot_begin(iso_page *page, const iso_page_box *box);
void iso_page_plot_end(iso_page *page);

/* Draws figure.pdf, and of the other forms those that a list names: "svg,png,latex"; NULL: all. What they were drawn from is removed unless it is wanted. ISO_E_MISSING without gnuplot. */
iso_status iso_page_finish(iso_page *page, const char *forms, int with_sources, iso_error *err);
/* ISO_E_USAGE: a list names what is no form. */
iso_status iso_page_check_forms(const char *forms, iso_error *err);

#endif

/* SPDX-License-Identifier: MIT */
/* page.h - a printed figure: contents at positions in millimeters from the left and top edge.
 *
 *     figure.pdf        vector text, fonts embedded, pictures with one pixel per dot
 *     figure.svg
 *     figure.png        the same in dots
 *     figure-latex.tex  for \input: text by LaTeX in the fonts of the paper, over figure-latex.pdf
 *     caption.txt
 *
 * With sources, the gnuplot script and the pixels of its pictures are kept.
 *
 * Pictures are aligned to a grid of dots and never resampled. Calls that put something store the first error, which
 * iso_page_finish() returns, so that a layout needs no checks. Order: pictures are below plots, plots below texts,
 * lines and rectangles. */
#pragma once

#include <stdio.h>

#include "base/status.h"
#include "figure/colormap.h"
#include "image/image.h"

typedef struct iso_page iso_page;

typedef struct iso_page_box {
    double left, top, width, height;
} iso_page_box;

/* Sizes in print: journals require 6 points at least. */
typedef enum iso_page_role { ISO_PAGE_TITLE, ISO_PAGE_NOTE, ISO_PAGE_ROLES } iso_page_role;
typedef enum iso_page_align { ISO_PAGE_LEFT, ISO_PAGE_CENTER, ISO_PAGE_RIGHT } iso_page_align;

iso_status iso_page_create(iso_page **page, const char *dir, double dpi, iso_error *err);
void iso_page_destroy(iso_page *page); /* accepts NULL */

/* Sets the size, rounded down to whole dots; call it before all puts. */
void iso_page_set_size(iso_page *page, double width_mm, double height_mm);
double iso_page_width(const iso_page *page);
double iso_page_height(const iso_page *page);
/* Returns the dots within a length, at least 1; the length of a number of dots. */
size_t iso_page_dots(const iso_page *page, double mm);
double iso_page_dots_mm(const iso_page *page, size_t dots);
/* Returns the file of the caption. */
FILE *iso_page_caption(iso_page *page);
/* Returns the path of another file in the page's folder, such as an animation, to be freed. */
char *iso_page_file(const iso_page *page, const char *name);

/* ---- text ---- */

double iso_page_text_pt(const iso_page *page, iso_page_role role);
/* Sets the size of all texts of a role: 6 to 9 points. */
void iso_page_set_text_pt(iso_page *page, iso_page_role role, double pt);
/* Returns the width of a text, rather too wide than too narrow; the distance between lines. */
double iso_page_text_mm(const iso_page *page, iso_page_role role, const char *text);
double iso_page_line_mm(const iso_page *page, iso_page_role role);

/* One line; y is its middle. The UTF-8 text is used unchanged, also for LaTeX. upright: reading upwards, x is its
 * middle. color: "#rrggbb", NULL: black. */
typedef struct iso_page_text {
    double x, y;
    iso_page_role role;
    iso_page_align align;
    int upright;
    const char *color;
} iso_page_text;
void iso_page_put_text(iso_page *page, const iso_page_text *where, const char *text);

/* ---- pictures ---- */

/* Returns the dots per pixel of a picture. If the width of its box is 0, the picture starts at the box's left and
 * top with one pixel per dot. Otherwise it fills the box, with pixels enlarged to at least one dot; a picture one
 * pixel wide, a color bar, stays unchanged. */
size_t iso_page_times(const iso_page *page, double width_mm, size_t pixels);

/* Puts an image with the pixels that `render` writes to a PNG. */
void iso_page_put_picture(iso_page *page, const iso_page_box *box, const iso_image *image);
/* Puts bytes of sRGB. */
void iso_page_put_colors(iso_page *page, const iso_page_box *box, const unsigned char *rgb, size_t width,
                         size_t height);
/* Puts numbers by a color map, from low to high. */
void iso_page_put_values(iso_page *page, const iso_page_box *box, const float *values, size_t width, size_t height,
                         const iso_colormap *map, const double range[2]);
/* A color bar for a range of numbers, with ticks on its right and a text on its left, reading upwards. in_logs: the
 * range is of exponents of ten. box: that of the bar alone. */
typedef struct iso_page_color_bar {
    iso_page_box box;
    const iso_colormap *map;
    double range[2];
    int in_logs;
    const char *text; /* a '|' begins a new line; or NULL */
} iso_page_color_bar;
void iso_page_put_color_bar(iso_page *page, const iso_page_color_bar *bar);
/* Returns the width of the texts left of the bar, and of the ticks right of it in a size. */
double iso_page_color_bar_left_mm(const iso_page *page, const iso_page_color_bar *bar);
double iso_page_color_bar_ticks_mm(const iso_page_color_bar *bar, double pt);

/* Puts a bar of a round length on a picture in `box`, at most a third of its width, into a corner that shows nothing of
 * the volume; black on bright pixels, white on dark ones. The caption explains it. If none fits, the caption
 * has the width of the picture instead. A slice, opaque everywhere, has it in the corner of least contrast.
 * mm_per_pixel 0: none. */
void iso_page_put_scale_bar(iso_page *page, const iso_page_box *box, const iso_image *image, double mm_per_pixel);
/* Draws the same without text in the caption. */
void iso_page_draw_scale_bar(iso_page *page, const iso_page_box *box, const iso_image *image, double mm_per_pixel);
/* Returns its length: 1, 2 or 5 times a power of ten; 0: none fits. */
double iso_page_scale_bar_mm(const iso_page *page, const iso_page_box *box, const iso_image *image,
                             double mm_per_pixel);

/* Puts letters into the upper left corners of panels, (a) first in the top row. Panels are pictures, except color
 * bars, and boxes given to iso_page_add_panel(). */
void iso_page_letter_panels(iso_page *page);
void iso_page_add_panel(iso_page *page, const iso_page_box *box);

/* ---- lines ---- */

typedef struct iso_page_pen {
    const char *color; /* "#rrggbb" */
    double pt;
    int dashed;
} iso_page_pen;
void iso_page_put_line(iso_page *page, double x0, double y0, double x1, double y1, const iso_page_pen *pen);
/* Draws a rectangle. fill: "#rrggbb" or NULL; pen: or NULL. */
void iso_page_put_rectangle(iso_page *page, const iso_page_box *box, const char *fill, const iso_page_pen *pen);

/* ---- plots ---- */

/* Begins a plot; the file takes gnuplot's commands until the plot ends: ranges, ticks, datablocks, and one "plot".
 * The axes fill the box; ticks and labels are around it. Texts use the functions of page.gp: title('..'),
 * note('..'); formats of ticks use ticks('..'). Fonts are note_font and title_font, line widths pen(points). Preset
 * style: no key, ticks outwards, a thin border left and below. */
FILE *iso_page_plot_begin(iso_page *page, const iso_page_box *box);
void iso_page_plot_end(iso_page *page);
/* Writes ticks of an axis, 'x' or 'y', at round numbers: at most `most` steps. Within a plot. */
void iso_page_plot_ticks(FILE *gp, char axis, const double range[2], int most);
/* Returns their distance: 1, 2 or 5 times a power of ten; a smaller one if there were fewer than two. */
double iso_page_tick_step(const double range[2], int most);

/* Draws figure.pdf and the formats in the list: "svg,png,latex"; NULL: all. Removes the sources unless with_sources.
 * ISO_E_MISSING: gnuplot is not installed. */
iso_status iso_page_finish(iso_page *page, const char *forms, int with_sources, iso_error *err);
/* Checks a list of formats. ISO_E_USAGE: an unknown one. */
iso_status iso_page_check_forms(const char *forms, iso_error *err);

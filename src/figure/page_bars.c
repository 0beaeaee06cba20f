/* SPDX-License-Identifier: MIT */
/* Color bars and scale bars of page.h. */
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "compare/srgb.h"
#include "figure/page.h"

/* ---- the color bar ---- */

enum { TICKS = 3 };

static void tick_text(const iso_page_color_bar *bar, int i, char text[32])
{
    const double value = bar->range[0] + (bar->range[1] - bar->range[0]) * i / (TICKS - 1);
    if (bar->in_logs)
        snprintf(text, 32, value == 0 ? "1" : "1e%g", value);
    else
        snprintf(text, 32, "%.3g", value);
}

static size_t bar_text_lines(const iso_page_color_bar *bar)
{
    size_t lines = bar->text != NULL;
    for (const char *s = bar->text; s && *s; ++s)
        lines += *s == '|';
    return lines;
}

double iso_page_color_bar_left_mm(const iso_page *p, const iso_page_color_bar *bar)
{
    return (double)bar_text_lines(bar) * iso_page_line_mm(p, ISO_PAGE_NOTE) + (bar->text ? 0.3 : 0);
}

static void put_bar_text(iso_page *p, const iso_page_color_bar *bar)
{
    const double line = iso_page_line_mm(p, ISO_PAGE_NOTE);
    iso_page_text at = {.x = bar->box.left - iso_page_color_bar_left_mm(p, bar) + 0.5 * line,
                        .y = bar->box.top + 0.5 * bar->box.height,
                        .role = ISO_PAGE_NOTE,
                        .align = ISO_PAGE_CENTER,
                        .upright = 1};
    for (const char *s = bar->text; s; at.x += line) {
        char part[96];
        snprintf(part, sizeof part, "%.*s", (int)strcspn(s, "|"), s);
        iso_page_put_text(p, &at, part);
        s = strchr(s, '|') ? strchr(s, '|') + 1 : NULL;
    }
}

enum { COLORS = 128 };

void iso_page_put_color_bar(iso_page *p, const iso_page_color_bar *bar)
{
    /* Draws rectangles, each over the lower part of the one above it, so that no seam is visible. A picture one
     * pixel wide is not drawn by gnuplot, and a wider one would count as a picture. */
    for (int i = 0; i < COLORS; ++i) {
        unsigned char rgb[3];
        char color[8];
        iso_colormap_lookup(bar->map, 1 - (i + 0.5) / COLORS, rgb);
        snprintf(color, sizeof color, "#%02x%02x%02x", rgb[0], rgb[1], rgb[2]);
        iso_page_put_rectangle(p,
                               &(iso_page_box){bar->box.left, bar->box.top + bar->box.height * i / COLORS,
                                               bar->box.width, bar->box.height * (COLORS - i) / COLORS},
                               color, NULL);
    }
    for (int i = 0; i < TICKS; ++i) {
        const double y = bar->box.top + bar->box.height * (1 - (double)i / (TICKS - 1)),
                     x = bar->box.left + bar->box.width;
        char text[32];
        tick_text(bar, i, text);
        iso_page_put_line(p, x, y, x + 0.6, y, &(iso_page_pen){"#444444", 0.4, 0});
        iso_page_put_text(p, &(iso_page_text){.x = x + 0.9, .y = y, .role = ISO_PAGE_NOTE}, text);
    }
    if (bar->text)
        put_bar_text(p, bar);
}

/* ---- the scale bar ---- */

double iso_page_bar_mm(double width_mm)
{
    double decade = pow(10, floor(log10(width_mm / 3)));
    return width_mm / 3 >= 5 * decade ? 5 * decade : width_mm / 3 >= 2 * decade ? 2 * decade : decade;
}

typedef struct corner {
    bool right, top;
} corner;

/* The upper left corner is for letters. The first corner wins ties. */
static const corner corners[] = {{false, false}, {true, false}, {true, true}};
enum { CORNERS = sizeof corners / sizeof *corners };

/* Returns the area that the bar and its text cover in a corner, in millimeters on the page. */
static iso_page_box covered(const iso_page_box *picture, corner at, double wide, double high)
{
    const double x = 0.05 * picture->width, y = 0.05 * picture->height;
    return (iso_page_box){picture->left + (at.right ? picture->width - x - wide : x),
                          picture->top + (at.top ? y : picture->height - y - high), wide, high};
}

typedef struct below {
    double opacity, brightness; /* means of the covered part */
} below;

/* Measures the part of a picture under a box on the page. */
static below look_below(const iso_image *image, const iso_page_box *picture, const iso_page_box *box)
{
    const double wide = (double)image->width, high = (double)image->height;
    const double left = (box->left - picture->left) / picture->width * wide,
                 top = (box->top - picture->top) / picture->height * high;
    const double right = left + box->width / picture->width * wide, low = top + box->height / picture->height * high;
    below sum = {0};
    size_t count = 0;
    for (size_t y = (size_t)fmax(top, 0); y < image->height && (double)y < low; ++y)
        for (size_t x = (size_t)fmax(left, 0); x < image->width && (double)x < right; ++x, ++count) {
            const float *rgba = image->rgba + 4 * (y * image->width + x);
            sum.opacity += (double)rgba[3];
            sum.brightness += iso_srgb_encode((double)rgba[1]);
        }
    const double n = fmax((double)count, 1);
    return (below){sum.opacity / n, sum.brightness / n};
}

/* Returns the lower left corner, unless another one covers less of the volume. */
static corner emptiest_corner(const iso_image *image, const iso_page_box *picture, double wide, double high)
{
    const double little = 0.01;
    size_t best = 0;
    double least = INFINITY;
    for (size_t i = 0; i < CORNERS; ++i) {
        const iso_page_box box = covered(picture, corners[i], wide, high);
        const double opacity = look_below(image, picture, &box).opacity;
        if (opacity < least - little)
            least = opacity, best = i;
    }
    return corners[best];
}

void iso_page_draw_scale_bar(iso_page *p, const iso_page_box *box, const iso_image *image, double mm_per_pixel)
{
    char text[32];
    if (!(mm_per_pixel > 0))
        return;
    const double shown_mm = mm_per_pixel * (double)image->width, length = iso_page_bar_mm(shown_mm);
    const double thick = 0.5, gap = 0.4, line = iso_page_line_mm(p, ISO_PAGE_NOTE);
    const double bar = length / shown_mm * box->width;
    snprintf(text, sizeof text, "%g mm", length);
    const double wide = fmax(bar, iso_page_text_mm(p, ISO_PAGE_NOTE, text)), high = line + gap + thick;
    const corner at = emptiest_corner(image, box, wide, high);
    const iso_page_box place = covered(box, at, wide, high);
    /* Dark on bright pixels, bright on dark ones. */
    const char *color = look_below(image, box, &place).brightness > 0.5 ? "#000000" : "#ffffff";
    /* The wider one of bar and text is nearer to the edge, which leaves more of a round volume free. */
    const bool bar_first = at.top == (bar >= wide);
    const double x = place.left + (at.right ? place.width : 0);
    const iso_page_box drawn = {at.right ? x - bar : x, bar_first ? place.top : place.top + line + gap, bar, thick};
    iso_page_put_rectangle(p, &drawn, color, NULL);
    iso_page_put_text(p,
                      &(iso_page_text){.x = x,
                                       .y = place.top + (bar_first ? thick + gap : 0) + 0.5 * line,
                                       .role = ISO_PAGE_NOTE,
                                       .align = at.right ? ISO_PAGE_RIGHT : ISO_PAGE_LEFT,
                                       .color = color},
                      text);
}

void iso_page_put_scale_bar(iso_page *p, const iso_page_box *box, const iso_image *image, double mm_per_pixel)
{
    iso_page_draw_scale_bar(p, box, image, mm_per_pixel);
    if (mm_per_pixel > 0)
        fprintf(iso_page_caption(p), " Scale bar: %g mm, in the plane through the center of the volume.",
                iso_page_bar_mm(mm_per_pixel * (double)image->width));
}

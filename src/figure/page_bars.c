/* SPDX-License-Identifier: MIT */
/* Color bars and scale bars, of what page.h has besides. */
#include <math.h>
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

double iso_page_color_bar_right_mm(const iso_page *p, const iso_page_color_bar *bar)
{
    double widest = 0;
    char text[32];
    for (int i = 0; i < TICKS; ++i) {
        tick_text(bar, i, text);
        widest = fmax(widest, iso_page_text_mm(p, ISO_PAGE_NOTE, text));
    }
    return 1 + widest;
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
    /* Rectangles, each over the lower part of the one above it, so that no seam shows: gnuplot draws no picture that is a
     * pixel wide, and a wider one would be a picture to those who count them. */
    for (int i = 0; i < COLORS; ++i) {
        unsigned char rgb[3];
        char color[8];
        iso_colormap_lookup(bar->map, 1 - (i + 0.5) / COLORS, rgb);
        snprintf(color, sizeof color, "#%02x%02x%02x", rgb[0], rgb[1], rgb[2]);
        iso_page_put_rectangle(p,
                               &(iso_page_box){bar->box.left, bar->box.top + bar->box.height * i / COLORS, bar->box.width,
                                               bar->box.height * (COLORS - i) / COLORS},
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

/* Dark on what is bright in the corner that the bar stands in, bright on what is dark. */
static const char *bar_color(const iso_image *image)
{
    double sum = 0;
    size_t count = 0;
    for (size_t y = image->height * 4 / 5; y < image->height; ++y)
        for (size_t x = 0; x < (image->width + 1) / 2; ++x, ++count)
            sum += iso_srgb_encode((double)image->rgba[4 * (y * image->width + x) + 1]);
    return sum > 0.5 * (double)count ? "#000000" : "#ffffff";
}

void iso_page_put_scale_bar(iso_page *p, const iso_page_box *box, const iso_image *image, double mm_per_pixel)
{
    char text[32];
    if (!(mm_per_pixel > 0))
        return;
    const double shown_mm = mm_per_pixel * (double)image->width, length = iso_page_bar_mm(shown_mm);
    const double x = box->left + 0.05 * box->width, y = box->top + 0.95 * box->height;
    const char *color = bar_color(image);
    snprintf(text, sizeof text, "%g mm", length);
    iso_page_put_rectangle(p, &(iso_page_box){x, y - 0.5, length / shown_mm * box->width, 0.5}, color, NULL);
    iso_page_put_text(p,
                      &(iso_page_text){.x = x,
                                       .y = y - 0.9 - 0.5 * iso_page_line_mm(p, ISO_PAGE_NOTE),
                                       .role = ISO_PAGE_NOTE,
                                       .color = color},
                      text);
    fprintf(iso_page_caption(p), " Scale bar: %g mm, in the plane through the center of the volume.", length);
}

/* SPDX-License-Identifier: MIT */
/* Color bars and scale bars of page.h. */
#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "compare/srgb.h"
#include "figure/page.h"
#include "figure/page_text.h"
#include "volume/unit.h"

/* ---- the color bar ---- */

enum { TICKS = 3 };

/* Returns the rounding of ticks this far apart: a hundredth, as a power of ten. */
static double tick_apart(double step)
{
    return step > 0 ? pow(10, floor(log10(step)) - 2) : 1;
}

static void tick_text(const iso_page_color_bar *bar, int i, char text[64])
{
    const double wide = bar->range[1] - bar->range[0], value = bar->range[0] + wide * i / (TICKS - 1);
    if (bar->in_logs)
        iso_page_power_of_ten((int)lrint(value), text);
    else
        iso_page_number(value, tick_apart(wide / (TICKS - 1)), text);
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

double iso_page_color_bar_ticks_mm(const iso_page_color_bar *bar, double pt)
{
    double most = 0;
    for (int i = 0; i < TICKS; ++i) {
        char text[64];
        tick_text(bar, i, text);
        most = fmax(most, iso_page_text_width_mm(text, strlen(text), pt));
    }
    return 1 + most;
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
        char text[64];
        tick_text(bar, i, text);
        iso_page_put_line(p, x, y, x + 0.6, y, &(iso_page_pen){"#444444", 0.4, 0});
        iso_page_put_text(p, &(iso_page_text){.x = x + 0.9, .y = y, .role = ISO_PAGE_NOTE}, text);
    }
    if (bar->text)
        put_bar_text(p, bar);
}

/* ---- the scale bar ---- */

/* Returns 1, 2 or 5 times a power of ten. */
static double round_length(double most)
{
    const double decade = pow(10, floor(log10(most)));
    return most >= 5 * decade ? 5 * decade : most >= 2 * decade ? 2 * decade : decade;
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
    double contrast;            /* largest difference of brightness */
} below;

/* Measures the part of a picture under a box on the page. */
static below look_below(const iso_image *image, const iso_page_box *picture, const iso_page_box *box)
{
    const double wide = (double)image->width, high = (double)image->height;
    const double left = (box->left - picture->left) / picture->width * wide,
                 top = (box->top - picture->top) / picture->height * high;
    const double right = left + box->width / picture->width * wide, low = top + box->height / picture->height * high;
    below sum = {0};
    double dark = 1, bright = 0;
    size_t count = 0;
    for (size_t y = (size_t)fmax(top, 0); y < image->height && (double)y < low; ++y)
        for (size_t x = (size_t)fmax(left, 0); x < image->width && (double)x < right; ++x, ++count) {
            const float *rgba = image->rgba + 4 * (y * image->width + x);
            sum.opacity += (double)rgba[3];
            const double brightness = iso_srgb_encode((double)rgba[1]);
            sum.brightness += brightness;
            dark = fmin(dark, brightness), bright = fmax(bright, brightness);
        }
    const double n = fmax((double)count, 1);
    return (below){sum.opacity / n, sum.brightness / n, bright - dark};
}

/* True for slices, which show the volume everywhere. */
static bool is_opaque(const iso_image *image)
{
    for (size_t i = 0; i < image->width * image->height; ++i)
        if (image->rgba[4 * i + 3] < 1)
            return false;
    return true;
}

/* A bar in a picture. */
typedef struct scale_bar {
    double length_mm; /* 0: none fits */
    double width;     /* on the page */
    corner at;
    iso_page_box place; /* of bar and text */
    char text[64];
} scale_bar;

static const double bar_thick = 0.5, bar_gap = 0.4;

/* Returns the longest round bar, of at most a third, a sixth or a twelfth of the picture, that fits into a corner
 * without volume; on a slice that of a third, in the corner of least contrast. */
static scale_bar find_place(const iso_page *p, const iso_page_box *box, const iso_image *image, double mm_per_pixel)
{
    const double most_of_width = 0.9, nothing = 0.01;
    const bool opaque = is_opaque(image);
    const double shown_mm = mm_per_pixel * (double)image->width, line = iso_page_line_mm(p, ISO_PAGE_NOTE);
    for (double part = 3; part <= 12 && shown_mm > 0; part *= 2) {
        scale_bar bar = {.length_mm = round_length(shown_mm / part)}, best = {0};
        double least = opaque ? 2 : nothing;
        bar.width = bar.length_mm / shown_mm * box->width;
        double unit_mm;
        const char *unit = iso_unit_fitting(bar.length_mm, &unit_mm);
        iso_page_number(bar.length_mm / unit_mm, bar.length_mm / unit_mm, bar.text);
        strcat(strcat(bar.text, " "), iso_unit_symbol(unit));
        const double wide = fmax(bar.width, iso_page_text_mm(p, ISO_PAGE_NOTE, bar.text));
        for (size_t i = 0; i < CORNERS && wide < most_of_width * box->width; ++i) {
            bar.at = corners[i];
            bar.place = covered(box, bar.at, wide, line + bar_gap + bar_thick);
            const below seen = look_below(image, box, &bar.place);
            const double hidden = opaque ? seen.contrast : seen.opacity;
            if (hidden < least)
                least = hidden, best = bar;
        }
        if (best.length_mm > 0)
            return best;
    }
    return (scale_bar){0};
}

double iso_page_scale_bar_mm(const iso_page *p, const iso_page_box *box, const iso_image *image, double mm_per_pixel)
{
    return find_place(p, box, image, mm_per_pixel).length_mm;
}

void iso_page_draw_scale_bar(iso_page *p, const iso_page_box *box, const iso_image *image, double mm_per_pixel)
{
    const scale_bar bar = find_place(p, box, image, mm_per_pixel);
    const iso_page_box place = bar.place;
    const double line = iso_page_line_mm(p, ISO_PAGE_NOTE);
    if (!(bar.length_mm > 0))
        return;
    /* Dark on bright pixels, bright on dark ones. */
    const char *color = look_below(image, box, &place).brightness > 0.5 ? "#000000" : "#ffffff";
    /* The wider one of bar and text is nearer to the edge, which leaves more of a round volume free. */
    const bool bar_first = bar.at.top == (bar.width >= place.width);
    const double x = place.left + (bar.at.right ? place.width : 0);
    const iso_page_box drawn = {bar.at.right ? x - bar.width : x, bar_first ? place.top : place.top + line + bar_gap,
                                bar.width, bar_thick};
    iso_page_put_rectangle(p, &drawn, color, NULL);
    iso_page_put_text(p,
                      &(iso_page_text){.x = x,
                                       .y = place.top + (bar_first ? bar_thick + bar_gap : 0) + 0.5 * line,
                                       .role = ISO_PAGE_NOTE,
                                       .align = bar.at.right ? ISO_PAGE_RIGHT : ISO_PAGE_LEFT,
                                       .color = color},
                      bar.text);
}

void iso_page_put_scale_bar(iso_page *p, const iso_page_box *box, const iso_image *image, double mm_per_pixel)
{
    const double length = iso_page_scale_bar_mm(p, box, image, mm_per_pixel);
    iso_page_draw_scale_bar(p, box, image, mm_per_pixel);
    char text[32];
    if (length > 0)
        fprintf(iso_page_caption(p), " Scale bar: %s, in the plane through the center of the volume.",
                iso_unit_text(length, 6, text, sizeof text));
    else if (mm_per_pixel > 0)
        fprintf(iso_page_caption(p), " A picture is %s wide, in the plane through the center of the volume.",
                iso_unit_text(mm_per_pixel * (double)image->width, 3, text, sizeof text));
}

/* SPDX-License-Identifier: MIT */
#include "figure/tf_bar.h"

#include <math.h>
#include <stdlib.h>

#include "tf/color_space.h"

static const double foot_mm = 7.5, bar_mm = 2.2, widest_mm = 60, narrowest_mm = 12, edge_mm = 1.5;

double iso_figure_tf_unit_mm(const iso_tf_table *t)
{
    return t->unit_mm > 0 ? t->unit_mm : 1;
}

double iso_figure_opacity(double extinction_per_mm, double length_mm)
{
    return -expm1(-extinction_per_mm * length_mm);
}

void iso_figure_tf_range(const iso_tf_table *t, const iso_level *level0, double range[2])
{
    range[0] = fmin(t->lo, level0->min);
    range[1] = fmax(t->hi, level0->max);
}

/* Puts the colors over squares, which are visible through transparent colors. */
static void put_colors(iso_page *page, const iso_page_box *box, const iso_tf_table *t, const double range[2])
{
    const size_t wide = iso_page_dots(page, box->width), high = iso_page_dots(page, box->height);
    const size_t square = high / 4 > 0 ? high / 4 : 1;
    const double unit_mm = iso_figure_tf_unit_mm(t);
    unsigned char *rgb = malloc(3 * wide * high);
    for (size_t i = 0; i < wide * high && rgb; ++i) {
        double c[4];
        const size_t x = i % wide, y = i / wide;
        iso_tf_lookup(t, range[0] + (range[1] - range[0]) * ((double)x + 0.5) / (double)wide, c);
        const double alpha = iso_figure_opacity(c[3], unit_mm), behind = (x / square + y / square) % 2 ? 0.8 : 0.45;
        for (int k = 0; k < 3; ++k)
            rgb[3 * i + (size_t)k] = (unsigned char)lrint(
                255 * iso_linear_to_srgb(fmin(fmax(alpha * c[k] + (1 - alpha) * behind, 0), 1)));
    }
    if (rgb)
        iso_page_put_colors(page, &(iso_page_box){.left = box->left, .top = box->top}, rgb, wide, high);
    free(rgb);
}

/* Returns 1, 2 or 5 times a power of ten, so that a range has at most `most` steps of it. */
static double tick_step(double range, int most)
{
    const double least = range / most, decade = pow(10, floor(log10(least)));
    return decade >= least ? decade : 2 * decade >= least ? 2 * decade : 5 * decade >= least ? 5 * decade : 10 * decade;
}

void iso_figure_put_tf_bar(iso_page *page, const iso_page_box *box, const iso_tf_table *t, const double range[2],
                           int wanted_ticks)
{
    put_colors(page, box, t, range);
    FILE *gp = iso_page_plot_begin(page, box);
    fprintf(gp, "set xrange [%.9g:%.9g]; set yrange [0:1]; unset ytics; set border 1; set xtics offset 0, 0.4\n",
            range[0], range[1]);
    if (wanted_ticks > 0)
        fprintf(gp, "set xtics %.9g\n", tick_step(range[1] - range[0], wanted_ticks));
    fputs("plot -1\n", gp);
    iso_page_plot_end(page);
}

/* ---- under pictures ---- */

/* Returns the number of marks, about one per centimeter. */
static int foot_ticks(double width_mm)
{
    return (int)fmax(2, width_mm / 10);
}

/* Computes the overhang of the outermost marks' texts over the ends of a bar of this width. */
static void overhangs_mm(const iso_page *page, const double range[2], double step, double width, double over[2])
{
    const double outermost[2] = {ceil(range[0] / step) * step, floor(range[1] / step) * step};
    for (int end = 0; end < 2; ++end) {
        char text[32];
        snprintf(text, sizeof text, "%g", outermost[end] + 0.0);
        const double from_end = fabs(outermost[end] - range[end]) / (range[1] - range[0]) * width;
        over[end] = fmax(0, 0.5 * iso_page_text_mm(page, ISO_PAGE_NOTE, text) - from_end);
    }
}

/* Places the bar at the left, as wide as possible next to a text of this width (0: none), within the page. */
static iso_page_box foot_bar(const iso_page *page, const double range[2], double top, double text_mm)
{
    const double wide = iso_page_width(page) - text_mm;
    double over[2] = {0}, width = fmin(wide - 2 * edge_mm, widest_mm);
    overhangs_mm(page, range, tick_step(range[1] - range[0], foot_ticks(width)), width, over);
    const double left = fmax(edge_mm, over[0]), right = text_mm > 0 ? edge_mm : fmax(edge_mm, over[1]);
    return (iso_page_box){left, top, fmin(wide - left - right, width), bar_mm};
}

iso_figure_tf_foot iso_figure_tf_foot_of(const iso_figure_subject *s)
{
    const iso_level *level0 = &s->pyramid.levels[0];
    iso_figure_tf_foot foot = {.tf = level0->labels ? NULL : &s->tf, .of_level0 = s->job->adapted.wanted};
    iso_figure_tf_range(&s->tf, level0, foot.range);
    return foot;
}

double iso_figure_tf_foot_mm(const iso_figure_tf_foot *foot)
{
    return foot->tf && foot->tf->count > 1 ? foot_mm : 0;
}

void iso_figure_put_tf_foot(const iso_figure_tf_foot *foot, iso_page *page, double above_mm)
{
    char text[64];
    if (!(iso_figure_tf_foot_mm(foot) > 0))
        return;
    const double unit_mm = iso_figure_tf_unit_mm(foot->tf), top = iso_page_height(page) - above_mm - foot_mm + 1;
    snprintf(text, sizeof text, "value (opacity of %.3g mm)", unit_mm);
    const double text_mm = 2 + iso_page_text_mm(page, ISO_PAGE_NOTE, text);
    iso_page_box box = foot_bar(page, foot->range, top, text_mm);
    const bool has_text = box.width >= narrowest_mm;
    if (!has_text)
        box = foot_bar(page, foot->range, top, 0);
    iso_figure_put_tf_bar(page, &box, foot->tf, foot->range, foot_ticks(box.width));
    if (has_text)
        iso_page_put_text(
            page, &(iso_page_text){.x = box.left + box.width + 2, .y = box.top + 0.5 * bar_mm, .role = ISO_PAGE_NOTE},
            text);
    fprintf(iso_page_caption(page),
            " Bar: the transfer function%s, colors over value with the opacity of %.3g mm, over gray squares.",
            foot->of_level0 ? " of level 0" : "", unit_mm);
}

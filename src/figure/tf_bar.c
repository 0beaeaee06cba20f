/* SPDX-License-Identifier: MIT */
#include "figure/tf_bar.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "figure/page_text.h"
#include "tf/color_space.h"
#include "volume/unit.h"
#include "volume/value_unit.h"

static const double foot_mm = 11, bar_mm = 3, widest_mm = 60, edge_mm = 1.5, deep_units = 50;

/* Returns the number of steps between marks: about one per centimeter, so that there are two marks at least. */
static int tick_count(double width_mm)
{
    return (int)fmax(3, width_mm / 10);
}

double iso_figure_tf_unit_mm(const iso_tf_table *t)
{
    return t->unit_mm > 0 ? t->unit_mm : 1;
}

double iso_figure_opacity(double extinction_per_mm, double length_mm)
{
    return -expm1(-extinction_per_mm * length_mm);
}

void iso_figure_value_text(const iso_figure_job *job, char *text, size_t size)
{
    char unit[ISO_VALUE_UNIT_BYTES] = "";
    if (job)
        iso_value_unit_read(job->input, &job->volume, unit);
    snprintf(text, size, "value%s%s", unit[0] ? " in " : "", unit);
}

void iso_figure_tf_range(const iso_tf_table *t, const iso_level *level0, double range[2])
{
    range[0] = fmin(t->lo, level0->min);
    range[1] = fmax(t->hi, level0->max);
}

/* Puts the colors over squares, which are visible through transparent colors: below with the opacity of the table's
 * length, above with that of a long ray, which shows colors that a picture gathers in its depth. */
static void put_colors(iso_page *page, const iso_page_box *box, const iso_tf_table *t, const double range[2])
{
    const size_t wide = iso_page_dots(page, box->width), high = iso_page_dots(page, box->height);
    const size_t square = high / 4 > 0 ? high / 4 : 1;
    const double unit_mm = iso_figure_tf_unit_mm(t);
    FREED unsigned char *rgb = malloc(3 * wide * high);
    for (size_t i = 0; i < wide * high && rgb; ++i) {
        double c[4];
        const size_t x = i % wide, y = i / wide;
        iso_tf_lookup(t, range[0] + (range[1] - range[0]) * ((double)x + 0.5) / (double)wide, c);
        const double alpha = iso_figure_opacity(c[3], 2 * y < high ? deep_units * unit_mm : unit_mm),
                     behind = (x / square + y / square) % 2 ? 0.8 : 0.45;
        for (int k = 0; k < 3; ++k)
            rgb[3 * i + (size_t)k] = (unsigned char)lrint(
                255 * iso_linear_to_srgb(fmin(fmax(alpha * c[k] + (1 - alpha) * behind, 0), 1)));
    }
    if (rgb)
        iso_page_put_colors(page, &(iso_page_box){.left = box->left, .top = box->top}, rgb, wide, high);
}

void iso_figure_put_tf_bar(iso_page *page, const iso_page_box *box, const iso_tf_table *t, const double range[2])
{
    put_colors(page, box, t, range);
    FILE *gp = iso_page_plot_begin(page, box);
    fprintf(gp, "set xrange [%.9g:%.9g]; set yrange [0:1]; unset ytics; set border 1; set xtics offset 0, 0.4\n",
            range[0], range[1]);
    iso_page_plot_ticks(gp, 'x', range, tick_count(box->width));
    fputs("plot -1\n", gp);
    iso_page_plot_end(page);
}

void iso_figure_describe_tf_bar(FILE *caption, double unit_mm)
{
    char unit[32], deep[32];
    fprintf(caption, "colors over value with the opacity of %s, above of %s, over gray squares",
            iso_unit_text(unit_mm, 3, unit, sizeof unit), iso_unit_text(deep_units * unit_mm, 3, deep, sizeof deep));
}

/* ---- under pictures ---- */

/* Places the bar at the left, as wide as possible with the texts of its outermost marks on the page. */
static iso_page_box foot_bar(const iso_page *page, const double range[2], double top)
{
    const double room = iso_page_width(page) - 2 * edge_mm, width = fmin(room, widest_mm);
    const double step = iso_page_tick_step(range, tick_count(width));
    double over[2];
    for (int end = 0; end < 2; ++end) {
        const double mark = end ? floor(range[1] / step) * step : ceil(range[0] / step) * step;
        char text[64];
        iso_page_number(mark, step, text);
        const double from_end = fabs(mark - range[end]) / (range[1] - range[0]) * width;
        over[end] = fmax(0, 0.5 * iso_page_text_mm(page, ISO_PAGE_NOTE, text) - from_end - edge_mm);
    }
    return (iso_page_box){edge_mm + over[0], top, fmin(room - over[0] - over[1], width), bar_mm};
}

iso_figure_tf_foot iso_figure_tf_foot_of(const iso_figure_subject *s)
{
    const iso_level *level0 = &s->pyramid.levels[0];
    iso_figure_tf_foot foot = {.tf = level0->labels ? NULL : &s->tf,
                               .job = s->job,
                               .of_level0 = s->job->adapted.wanted};
    iso_figure_tf_range(&s->tf, level0, foot.range);
    return foot;
}

double iso_figure_tf_foot_mm(const iso_figure_tf_foot *foot)
{
    return foot->tf && foot->tf->count > 1 ? foot_mm : 0;
}

void iso_figure_put_tf_foot(const iso_figure_tf_foot *foot, iso_page *page, double above_mm)
{
    char text[96], value[32], length[32];
    if (!(iso_figure_tf_foot_mm(foot) > 0))
        return;
    const double unit_mm = iso_figure_tf_unit_mm(foot->tf), bottom = iso_page_height(page) - above_mm;
    const iso_page_box box = foot_bar(page, foot->range, bottom - foot_mm + 1);
    iso_figure_put_tf_bar(page, &box, foot->tf, foot->range);
    iso_figure_value_text(foot->job, value, sizeof value);
    snprintf(text, sizeof text, "%s (opacity of %s)", value, iso_unit_text(unit_mm, 3, length, sizeof length));
    iso_page_put_text(page,
                      &(iso_page_text){.x = box.left,
                                       .y = bottom - 0.6 * iso_page_line_mm(page, ISO_PAGE_NOTE),
                                       .role = ISO_PAGE_NOTE},
                      text);
    fprintf(iso_page_caption(page), " Bar: the transfer function%s, ", foot->of_level0 ? " of level 0" : "");
    iso_figure_describe_tf_bar(iso_page_caption(page), unit_mm);
    fputc('.', iso_page_caption(page));
}

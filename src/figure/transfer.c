/* SPDX-License-Identifier: MIT */
/* A transfer function: opacity over value, filled with its colors, over the histogram of the volume. Below it a bar
 * of the colors over a checkerboard, with their opacity. Several levels have one each. */
#include <math.h>

#include "figure/kinds.h"
#include "figure/picture.h"
#include "figure/tf_bar.h"
#include "tf/color_space.h"
#include "volume/unit.h"

enum { COLUMNS = 400, BINS = 256 };

static bool are_whole(const float *values, size_t count)
{
    for (size_t i = 0; i < count; ++i)
        if (values[i] != rintf(values[i]))
            return false;
    return true;
}

/* Writes bars as high as the logarithm of the count; one voxel is above zero. For whole numbers each bin has equally
 * many, since empty bins in between would form a comb. */
static void put_histogram(FILE *gp, const iso_level *level0)
{
    const size_t voxels = iso_geometry_voxel_count(&level0->geometry);
    const double span = level0->max - level0->min;
    const bool whole = are_whole(level0->scalar, voxels);
    const double width = whole ? ceil((span + 1) / BINS) : span / BINS, lo = whole ? level0->min - 0.5 : level0->min;
    const size_t count = whole ? (size_t)ceil((span + 1) / width) : (size_t)BINS;
    size_t bins[BINS] = {0}, most = 1;
    for (size_t i = 0; i < voxels && width > 0; ++i) {
        const size_t b = (size_t)fmin(((double)level0->scalar[i] - lo) / width, (double)count - 1);
        most = ++bins[b] > most ? bins[b] : most;
    }
    fputs("$bins << EOD\n", gp);
    for (size_t b = 0; b < count; ++b)
        fprintf(gp, "%.9g %.5f\n%.9g %.5f\n", fmax(lo + width * (double)b, level0->min),
                log1p((double)bins[b]) / log1p((double)most), fmin(lo + width * (double)(b + 1), level0->max),
                log1p((double)bins[b]) / log1p((double)most));
    fprintf(gp, "EOD\nmost = %zu\n", most);
}

static void put_data(FILE *gp, const iso_tf_table *t, double unit_mm, const double range[2])
{
    const double width = (range[1] - range[0]) / COLUMNS;
    fputs("$colors << EOD\n", gp);
    for (int i = 0; i < COLUMNS; ++i) {
        const double from = range[0] + width * i;
        double c[4];
        int rgb[3];
        iso_tf_lookup(t, from + 0.5 * width, c);
        for (int k = 0; k < 3; ++k)
            rgb[k] = (int)lrint(255 * iso_linear_to_srgb(fmin(fmax(c[k], 0), 1)));
        /* each column extends a little below the next one, to hide seams */
        fprintf(gp, "%.9g %.9g %.6g %d\n", from, fmin(from + 1.5 * width, range[1]), iso_figure_opacity(c[3], unit_mm),
                rgb[0] << 16 | rgb[1] << 8 | rgb[2]);
    }
    fputs("EOD\n$curve << EOD\n", gp);
    fprintf(gp, "%.9g %.6g\n", range[0], iso_figure_opacity((double)t->entries[3], unit_mm));
    for (size_t e = 0; e < t->count; ++e)
        fprintf(gp, "%.9g %.6g\n", t->lo + (t->hi - t->lo) * (double)e / (double)(t->count - 1),
                iso_figure_opacity((double)t->entries[4 * e + 3], unit_mm));
    fprintf(gp, "%.9g %.6g\nEOD\n", range[1], iso_figure_opacity((double)t->entries[4 * t->count - 1], unit_mm));
}

/* Puts the curve; $bins and most are defined. */
static void put_plot(FILE *gp, const iso_tf_table *t, double unit_mm, const double range[2])
{
    put_data(gp, t, unit_mm, range);
    fprintf(
        gp,
        "set xrange [%.9g:%.9g]; set yrange [0:1.02]; set y2range [0:1.02]; set ytics 0.25; set border 11\n"
        "set ytics offset 0.8, 0; set format x ''; set y2tics () out nomirror scale 0.4 offset -0.8, 0\n"
        "do for [k = 0:int(log10(most)):int(log10(most)) / 4 + 1] { set y2tics add ((k < 2 ? note(sprintf('%%d', 10 ** k)) : "
        "power(k)) log(1 + 10.0 ** k) / log(1 + most)) font note_font }\n"
        "plot $bins using 1:2 axes x1y2 with filledcurves y2=0 fs solid noborder lc rgb '#d0d0d0', "
        "$colors using 1:(0):1:2:(0):3:4 with boxxyerror fs solid noborder lc rgb variable, "
        "$bins using 1:2 axes x1y2 with lines lc rgb '#808080' lw pen(0.4), "
        "$curve using 1:2 with lines lc rgb '#202020' lw pen(1)\n",
        range[0], range[1]);
}

/* ---- layout ---- */

static const double side_mm = 11, above_mm = 2, below_mm = 13, bar_mm = 3.5, least_mm = 26, least_wide_mm = 80;

/* One transfer function on the page: a title, if any, the curve, the bar, and labels of the axes. */
typedef struct place {
    iso_page_box box;
    const char *title;
    double range[2]; /* of values */
    const iso_level *level0;
    bool first;     /* True for the first, which has the histogram */
    char value[32]; /* title of the axis of values */
} place;

static void put_upright(iso_page *page, double x, double y, const char *text)
{
    iso_page_put_text(page, &(iso_page_text){x, y, ISO_PAGE_NOTE, ISO_PAGE_CENTER, 1, NULL}, text);
}

static void put_transfer(iso_page *page, const place *at, const iso_tf_table *t)
{
    const double unit_mm = iso_figure_tf_unit_mm(t), right = at->box.left + at->box.width,
                 bottom = at->box.top + at->box.height, wide = at->box.width - 2 * side_mm,
                 title_mm = at->title ? iso_page_line_mm(page, ISO_PAGE_TITLE) + 0.6 : 0,
                 top = at->box.top + above_mm + title_mm;
    const iso_page_box curve = {at->box.left + side_mm, top, wide, bottom - below_mm - top},
                       bar = {curve.left, bottom - below_mm + 1, wide, bar_mm};
    char opacity[48], length[32];
    FILE *gp = iso_page_plot_begin(page, &curve);
    if (at->first)
        put_histogram(gp, at->level0);
    put_plot(gp, t, unit_mm, at->range);
    iso_page_plot_end(page);
    iso_figure_put_tf_bar(page, &bar, t, at->range);
    snprintf(opacity, sizeof opacity, "opacity of %s", iso_unit_text(unit_mm, 3, length, sizeof length));
    put_upright(page, at->box.left + 1.7, curve.top + 0.5 * curve.height, opacity);
    put_upright(page, right - 1.7, curve.top + 0.5 * curve.height, "voxels (log)");
    iso_page_text text = {curve.left + 0.5 * wide, bottom - 1.7, ISO_PAGE_NOTE, ISO_PAGE_CENTER, 0, NULL};
    iso_page_put_text(page, &text, at->value);
    text.y = at->box.top + 0.5 * above_mm + 0.5 * title_mm;
    text.role = ISO_PAGE_TITLE;
    if (at->title) {
        iso_page_put_text(page, &text, at->title);
        iso_page_add_panel(page, &at->box);
    }
}

/* ---- levels ---- */

typedef struct curves {
    iso_figure_subject subject;
    size_t first, count; /* levels */
    iso_view views[ISO_FIGURE_MOST_LEVELS];
} curves;

static void curves_destroy(curves *c)
{
    for (size_t i = 0; i < c->count; ++i)
        iso_view_destroy(&c->views[i]);
    iso_figure_subject_end(&c->subject);
}

/* Makes the view of a level, under its adapted transfer function if requested. */
static iso_status make_view(curves *c, const iso_figure_job *job, size_t level, iso_view *view, iso_error *err)
{
    const iso_pyramid *p = &c->subject.pyramid;
    iso_cli_adapted adapted = job->adapted;
    adapted.wanted = adapted.wanted && level > 0;
    NEED(iso_scene_resolve(&c->subject.scene, &p->levels[0].geometry, iso_pyramid_lo(p), iso_pyramid_hi(p), view, err));
    return iso_cli_adapt_view(&adapted, job->input, p, level, view, job->cli->threads, err);
}

static void name_level(const curves *c, size_t i, char title[64])
{
    const size_t level = c->first + i;
    snprintf(title, 64, "level %zu%s", level,
             level == 0                                              ? ""
             : iso_tf_table_equals(&c->views[0].tf, &c->views[i].tf) ? ", the original is kept"
                                                                     : ", adapted");
}

static iso_status choose(curves *c, const iso_figure_job *job, iso_error *err)
{
    if (job->levels > 1 && job->level)
        return iso_fail(err, ISO_E_USAGE, "--level and --levels exclude each other; give one of them");
    if (job->levels > 1 && !job->adapted.wanted)
        return iso_fail(err, ISO_E_USAGE,
                        "--kind tf --levels goes with --adapt: without it all levels have one transfer function");
    c->first = job->levels > 1 ? 0 : (size_t)job->level;
    c->count = job->levels > 1 ? (size_t)job->levels : 1;
    NEED(iso_figure_subject_load(&c->subject, job, c->first + c->count, NULL, err));
    for (size_t i = 0; i < c->count; ++i)
        NEED(make_view(c, job, c->first + i, &c->views[i], err));
    return ISO_OK;
}

/* Puts all below each other, or two per row if both are wide enough. */
static iso_status put_all(const curves *c, const iso_figure_job *job, iso_page *page, iso_error *err)
{
    const size_t per_row = c->count > 1 && job->width_mm >= 2 * least_wide_mm ? 2 : 1,
                 rows = (c->count + per_row - 1) / per_row;
    const double wide = job->width_mm / (double)per_row,
                 high = fmin((c->count > 1 ? 0.5 : 0.55) * wide, job->height_mm / (double)rows);
    if (high < least_mm)
        return iso_fail(err, ISO_E_RANGE,
                        "figure: --height %g leaves %.1f mm for each of %zu transfer functions, at least %g are needed",
                        job->height_mm, high, c->count, least_mm);
    place at = {.level0 = &c->subject.pyramid.levels[0]};
    /* One axis for all: values of a level are means of those of level 0. */
    iso_figure_tf_range(&c->views[0].tf, at.level0, at.range);
    iso_figure_value_text(job, at.value, sizeof at.value);
    iso_page_set_size(page, job->width_mm, high * (double)rows);
    for (size_t i = 0; i < c->count; ++i) {
        char title[64];
        name_level(c, i, title);
        at.title = c->count > 1 ? title : NULL;
        at.first = i == 0;
        at.box = (iso_page_box){wide * (double)(i % per_row), high * (double)(i / per_row), wide, high};
        put_transfer(page, &at, &c->views[i].tf);
    }
    return ISO_OK;
}

static void write_caption(const curves *c, const iso_figure_job *job, FILE *f)
{
    const double unit_mm = iso_figure_tf_unit_mm(&c->views[0].tf);
    char length[32];
    fputs(c->count > 1 ? "Transfer functions" : "Transfer function", f);
    iso_figure_put_subject(&c->subject, f);
    if (c->count > 1)
        fprintf(f, ", original and adapted to levels 1 to %zu", c->count - 1);
    else if (job->adapted.wanted && c->first > 0)
        fprintf(f, ", adapted to level %zu", c->first);
    fprintf(f, ": opacity of %s over value, filled with its colors, over the histogram of level 0. Below: ",
            iso_unit_text(unit_mm, 3, length, sizeof length));
    iso_figure_describe_tf_bar(f, unit_mm);
    fputc('.', f);
    for (size_t i = 1; i < c->count; ++i)
        if (iso_tf_table_equals(&c->views[0].tf, &c->views[i].tf))
            fprintf(f, " At level %zu adapting does not help in small views, so the original is kept.", c->first + i);
}

static iso_status draw_tf(const iso_figure_job *job, iso_page *page, iso_error *err)
{
    OWNED(curves) c = {.first = 0};
    NEED(choose(&c, job, err));
    NEED(put_all(&c, job, page, err));
    write_caption(&c, job, iso_page_caption(page));
    return ISO_OK;
}

const iso_figure_info iso_figure_tf = {
    .name = "tf",
    .summary = "a transfer function over the volume's histogram, with its colors; or those adapted to levels",
    .takes = ISO_FIGURE_OF_VOLUME | ISO_FIGURE_HAS_LOOK | ISO_FIGURE_HAS_LEVEL | ISO_FIGURE_HAS_LEVELS |
             ISO_FIGURE_HAS_ADAPT,
    .draw = draw_tf,
};

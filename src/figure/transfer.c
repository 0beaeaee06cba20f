/* SPDX-License-Identifier: MIT */
/* A transfer function: opacity over value, filled with its colors, the histogram of the volume behind it, and below a bar of
 * the colors over a checkerboard, as opaque as they are. */
#include <math.h>
#include <stdlib.h>

#include "figure/kinds_of_volume.h"
#include "figure/picture.h"
#include "figure/tf_bar.h"
#include "tf/color_space.h"

enum { COLUMNS = 400, BINS = 256 };

static bool are_whole(const float *values, size_t count)
{
    for (size_t i = 0; i < count; ++i)
        if (values[i] != rintf(values[i]))
            return false;
    return true;
}

/* As high as its logarithm, a single voxel above none. Of whole numbers each bin has as many as the others: else empty ones
 * between them would show a comb. */
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
        /* Each column reaches a little below the next one: no seams are seen between them. */
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

static void put_plot(iso_page *page, const iso_page_box *box, const iso_level *level0, const iso_tf_table *t,
                     double unit_mm, const double range[2])
{
    FILE *gp = iso_page_plot_begin(page, box);
    put_histogram(gp, level0);
    put_data(gp, t, unit_mm, range);
    fprintf(
        gp,
        "set xrange [%.9g:%.9g]; set yrange [0:1.02]; set y2range [0:1.02]; set ytics 0.25; set border 11\n"
        "set ytics offset 0.8, 0; set format x ''; set y2tics () out nomirror scale 0.4 offset -0.8, 0\n"
        "do for [k = 0:int(log10(most)):int(log10(most)) / 4 + 1] { set y2tics add (note(k < 2 ? sprintf('%%d', 10 ** k) : "
        "sprintf('1e%%d', k)) log(1 + 10.0 ** k) / log(1 + most)) font note_font }\n"
        "plot $bins using 1:2 axes x1y2 with filledcurves y2=0 fs solid noborder lc rgb '#d0d0d0', "
        "$colors using 1:(0):1:2:(0):3:4 with boxxyerror fs solid noborder lc rgb variable, "
        "$bins using 1:2 axes x1y2 with lines lc rgb '#808080' lw pen(0.4), "
        "$curve using 1:2 with lines lc rgb '#202020' lw pen(1)\n",
        range[0], range[1]);
    iso_page_plot_end(page);
    char opacity[48];
    const double middle = box->top + 0.5 * box->height;
    snprintf(opacity, sizeof opacity, "opacity of %.3g mm", unit_mm);
    iso_page_put_text(page, &(iso_page_text){1.7, middle, ISO_PAGE_NOTE, ISO_PAGE_CENTER, 1, NULL}, opacity);
    iso_page_put_text(page,
                      &(iso_page_text){iso_page_width(page) - 1.7, middle, ISO_PAGE_NOTE, ISO_PAGE_CENTER, 1, NULL},
                      "voxels (log)");
}

static iso_status draw_tf(const iso_figure_job *job, iso_page *page, iso_error *err)
{
    iso_figure_subject s = {0};
    iso_view view = {0};
    const size_t level = (size_t)job->level;
    iso_cli_adapted adapted = job->adapted;
    adapted.wanted = adapted.wanted && level > 0;
    iso_status status = iso_figure_subject_load(&s, job, level + 1, NULL, err);
    if (status == ISO_OK)
        status = iso_scene_resolve(&s.scene, &s.pyramid.levels[0].geometry, iso_pyramid_lo(&s.pyramid),
                                   iso_pyramid_hi(&s.pyramid), &view, err);
    if (status == ISO_OK)
        status = iso_cli_adapt_view(&adapted, job->input, &s.pyramid, level, &view, job->cli->threads, err);
    if (status == ISO_OK) {
        const iso_level *level0 = &s.pyramid.levels[0];
        const iso_tf_table *t = &view.tf;
        const double unit_mm = iso_figure_tf_unit_mm(t);
        double range[2];
        iso_figure_tf_range(t, level0, range);
        const double width = job->width_mm, height = fmin(0.55 * width, job->height_mm);
        iso_page_set_size(page, width, height);
        const iso_page_box curve = {11, 2, width - 22, height - 15}, bar = {11, height - 12, width - 22, 3.5};
        put_plot(page, &curve, level0, t, unit_mm, range);
        iso_figure_put_tf_bar(page, &bar, t, range, 0);
        iso_page_put_text(page,
                          &(iso_page_text){bar.left + 0.5 * bar.width, iso_page_height(page) - 1.7, ISO_PAGE_NOTE,
                                           ISO_PAGE_CENTER, 0, NULL},
                          "value");
        FILE *f = iso_page_caption(page);
        fputs("Transfer function", f);
        iso_figure_put_subject(&s, f);
        if (adapted.wanted)
            fprintf(f, ", adapted to level %zu", level);
        fprintf(
            f,
            ": opacity of %.3g mm over value, filled with its colors, over the histogram of level 0. Below: colors as "
            "opaque as %.3g mm of them are, over gray squares.",
            unit_mm, unit_mm);
    }
    iso_view_destroy(&view);
    iso_figure_subject_end(&s);
    return status;
}

const iso_figure_info iso_figure_tf = {
    .name = "tf",
    .summary = "a transfer function: its curve over the volume's histogram, and a bar of its colors with their opacity",
    .takes = ISO_FIGURE_OF_VOLUME | ISO_FIGURE_HAS_LOOK | ISO_FIGURE_HAS_LEVEL | ISO_FIGURE_HAS_ADAPT,
    .draw = draw_tf,
};

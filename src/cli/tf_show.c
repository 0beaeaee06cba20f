/* SPDX-License-Identifier: MIT */
/* tf_show.c - draws one panel per TF: opacity over value, filled with the colors, after Figure 4 of [diaz-garcia-2016],
 * in front of the volume's histogram. Panels are gray to make white visible; a strip below also has transparent
 * colors. */
#include "cli/tf.h"

#include <math.h>

#include "base/file.h"
#include "cli/histogram_picture.h"
#include "report/gnuplot.h"
#include "tf/color_space.h"
#include "volume/unit.h"

static const double strip_top = -0.025, strip_bottom = -0.085;
enum { BINS = 256 };

typedef struct show_picture {
    const iso_tf_arguments *arguments;
    const iso_volume *volume; /* or NULL */
    iso_volume_stats stats;
    double unit_mm; /* unit of the first TF, for all panels to be comparable */
} show_picture;

static int srgb_byte(double linear)
{
    return (int)lrint(255 * iso_linear_to_srgb(fmin(fmax(linear, 0), 1)));
}

/* Writes value and opacity of the table's entries, and constant ends beyond them. */
static void put_curve(FILE *gp, size_t panel, const iso_tf_table *t, double unit_mm, const double range[2])
{
    fprintf(gp, "$curve%zu << EOD\n", panel);
    const double width = (t->hi - t->lo) / (double)(t->count - 1);
    fprintf(gp, "%.9g %.6g\n", range[0], -expm1(-(double)t->entries[3] * unit_mm));
    for (size_t e = 0; e < t->count; ++e)
        fprintf(gp, "%.9g %.6g\n", t->lo + width * (double)e, -expm1(-(double)t->entries[4 * e + 3] * unit_mm));
    fprintf(gp, "%.9g %.6g\nEOD\n", range[1], -expm1(-(double)t->entries[4 * t->count - 1] * unit_mm));
}

/* Writes columns of color: from, to, opacity, color. Each overlaps the next to avoid visible seams. */
static void put_colors(FILE *gp, size_t panel, const iso_tf_table *t, double unit_mm, const double range[2])
{
    enum { COLUMNS = 600 };
    const double width = (range[1] - range[0]) / COLUMNS;
    fprintf(gp, "$colors%zu << EOD\n", panel);
    for (int i = 0; i < COLUMNS; ++i) {
        const double from = range[0] + width * i;
        double c[4];
        iso_tf_lookup(t, from + 0.5 * width, c);
        fprintf(gp, "%.9g %.9g %.6g %d\n", from, fmin(from + 1.5 * width, range[1]), -expm1(-c[3] * unit_mm),
                srgb_byte(c[0]) << 16 | srgb_byte(c[1]) << 8 | srgb_byte(c[2]));
    }
    fputs("EOD\n", gp);
}

static iso_status put_histogram(FILE *gp, size_t panel, const show_picture *p, const double range[2], iso_error *err)
{
    char name[32];
    OWNED(iso_value_histogram) h = {0};
    snprintf(name, sizeof name, "bins%zu", panel);
    NEED(iso_value_histogram_count(p->volume, range[0], range[1], BINS, &h, err));
    iso_histogram_put_data(gp, name, &h);
    iso_histogram_put_ticks(gp, "y2", &h);
    fputs("set y2label 'voxels'\n", gp);
    return ISO_OK;
}

static void put_plot(FILE *gp, size_t panel, bool has_volume)
{
    fprintf(gp, "plot ");
    if (has_volume)
        fprintf(gp, "$bins%zu using 1:2 axes x1y2 with filledcurves y2=0 fs solid noborder lc rgb '#b4b4b4', ", panel);
    fprintf(gp,
            "$colors%zu using 1:(0):1:2:(0):3:4 with boxxyerror fs solid noborder lc rgb variable, "
            "'' using 1:(%g):1:2:(%g):(%g):4 with boxxyerror fs solid noborder lc rgb variable, ",
            panel, strip_bottom, strip_bottom, strip_top);
    if (has_volume)
        fprintf(gp, "$bins%zu using 1:2 axes x1y2 with lines lc rgb '#707070' lw 0.5, ", panel);
    fprintf(gp, "$curve%zu using 1:2 with lines lc rgb '#202020' lw 1.4\n", panel);
}

static iso_status put_panel(FILE *gp, size_t panel, show_picture *p, iso_error *err)
{
    OWNED(iso_cli_tf_table) loaded = {0};
    char length[32];
    const char *name = p->arguments->cli->arguments[1 + panel];
    NEED(iso_cli_tf_load_table(p->arguments, name, &loaded, err));
    const iso_tf_table *t = &loaded.table;
    double range[2] = {t->lo, t->hi};
    if (p->volume) {
        range[0] = fmin(range[0], p->stats.min);
        range[1] = fmax(range[1], p->stats.max);
    }
    p->unit_mm = panel == 0 ? loaded.unit_mm : p->unit_mm;
    put_curve(gp, panel, t, p->unit_mm, range);
    put_colors(gp, panel, t, p->unit_mm, range);
    if (p->volume)
        NEED(put_histogram(gp, panel, p, range, err));
    fputs("set title ", gp);
    iso_gnuplot_put_quoted(gp, iso_path_base(name));
    fprintf(gp, " noenhanced offset 0,-0.5\nset ylabel 'opacity of %s'\nset xlabel 'value'\nset xrange [%.9g:%.9g]\n",
            iso_unit_text(p->unit_mm, 3, length, sizeof length), range[0], range[1]);
    put_plot(gp, panel, p->volume != NULL);
    return ISO_OK;
}

static iso_status write_panels(FILE *gp, void *user, iso_error *err)
{
    show_picture *p = user;
    const size_t count = p->arguments->cli->argument_count - 1;
    iso_status status = ISO_OK;
    fprintf(
        gp,
        "set multiplot layout %zu,1\nset key off\nset yrange [%g:1.02]\nset y2range [%g:1.02]\n"
        "set ytics 0,0.2,1\nset tics out nomirror scale 0.7\nset border %d lc rgb '#444444'\nset lmargin 9\n"
        "set tmargin 2\nset bmargin 3.6\nset rmargin %d\nset object 1 rectangle from graph 0,graph 0 to graph 1,graph 1 behind fc rgb '#dcdcdc' "
        "fs solid noborder\n",
        count, strip_bottom - 0.02, strip_bottom - 0.02, p->volume ? 11 : 3, p->volume ? 9 : 3);
    for (size_t i = 0; i < count && status == ISO_OK; ++i)
        status = put_panel(gp, i, p, err);
    fputs("unset multiplot\n", gp);
    return status;
}

iso_status iso_cli_tf_show(const iso_tf_arguments *a, iso_error *err)
{
    OWNED(iso_volume) volume = {0};
    show_picture p = {.arguments = a};
    if (a->cli->argument_count < 2 || !a->output)
        return iso_fail(err, ISO_E_USAGE,
                        "usage: isoshade tf show FILE|PRESET... [--volume VOLUME] -o OUT.png|.svg|.pdf");
    NEED(iso_cli_tf_load_volume(a, &volume, err));
    if (a->volume) {
        p.volume = &volume;
        p.stats = iso_volume_measure(&volume);
    }
    NEED(iso_gnuplot_picture(a->output, 720, 40 + 220 * (double)(a->cli->argument_count - 1), write_panels, &p, err));
    if (a->cli->json)
        iso_cli_print_results(a->cli, json_pack("{s:s}", "output", a->output));
    return ISO_OK;
}

/* SPDX-License-Identifier: MIT */
#include "cli/histogram_picture.h"

#include <math.h>
#include <string.h>

#include "report/gnuplot.h"

/* Height of a single voxel, in decades. */
static const double one_voxel = 0.3;

/* Returns the height of a count, from 0 for none to 1 for the fullest bin; a single voxel stays visible. */
static double histogram_height(const iso_value_histogram *h, size_t count)
{
    return count ? (log10((double)count) + one_voxel) / (log10((double)h->most) + one_voxel) : 0;
}

void iso_histogram_put_data(FILE *gp, const char *name, const iso_value_histogram *h)
{
    fprintf(gp, "$%s << EOD\n", name);
    for (size_t b = 0; b < h->count; ++b) {
        const double from = h->lo + h->width * (double)b, height = histogram_height(h, h->bins[b]);
        fprintf(gp, "%.9g %.5f\n%.9g %.5f\n", from, height, from + h->width, height);
    }
    fputs("EOD\n", gp);
}

void iso_histogram_put_ticks(FILE *gp, const char *axis, const iso_value_histogram *h)
{
    enum { MOST_TICKS = 5 };
    const int decades = h->most ? (int)floor(log10((double)h->most)) : 0, step = decades / MOST_TICKS + 1;
    fprintf(gp, "set %stics (", axis);
    for (int k = 0; k <= decades; k += step) {
        const double at = (k + one_voxel) / (log10(fmax((double)h->most, 1)) + one_voxel);
        if (k < 2)
            fprintf(gp, "%s'%s' %.5f", k > 0 ? ", " : "", k > 0 ? "10" : "1", at);
        else
            fprintf(gp, ", '10^{%d}' %.5f", k, at);
    }
    fputs(")\n", gp);
}

typedef struct picture {
    const iso_value_histogram *histogram;
    const char *title;
} picture;

static iso_status write_picture(FILE *gp, void *user, iso_error *err)
{
    const picture *p = user;
    const iso_value_histogram *h = p->histogram;
    (void)err;
    iso_histogram_put_data(gp, "bins", h);
    fputs("set key off\nset border 3 lc rgb '#444444'\nset tics out nomirror\nset yrange [0:1.04]\n"
          "set xlabel 'value'\nset ylabel 'voxels'\nset title ",
          gp);
    iso_gnuplot_put_quoted(gp, p->title);
    fprintf(gp, " noenhanced offset 0,-0.5\nset tmargin 2\nset rmargin 3\nset xrange [%.9g:%.9g]\n", h->lo,
            h->lo + h->width * (double)h->count);
    iso_histogram_put_ticks(gp, "y", h);
    fputs("plot $bins using 1:2 with filledcurves y1=0 fs solid noborder lc rgb '#9db4c8', "
          "'' using 1:2 with lines lc rgb '#2f4b63' lw 0.8\n",
          gp);
    return ISO_OK;
}

iso_status iso_histogram_draw(const iso_value_histogram *h, const char *title, const char *output, iso_error *err)
{
    return iso_gnuplot_picture(output, 640, 280, write_picture, &(picture){h, title}, err);
}

/* ---- as text ---------------------------------------------------------------------------------------------------- */

enum { ROWS = 8, LABEL = 9 };

/* Returns a tick step of 1, 2 or 5 times a power of ten, for four to ten ticks in the range. */
static double tick_step(double range)
{
    const double decade = pow(10, floor(log10(range / 4)));
    return range / 4 >= 5 * decade ? 5 * decade : range / 4 >= 2 * decade ? 2 * decade : decade;
}

static void print_rows(const iso_value_histogram *h, int indent, FILE *f)
{
    const double top = log10(fmax((double)h->most, 1)) + one_voxel;
    for (int row = ROWS - 1; row >= 0; --row) {
        char label[LABEL + 8] = "";
        /* half a row for a bin that ends in the middle of this row */
        if (row % 2 == 1)
            snprintf(label, sizeof label, "%.2g", pow(10, fmax((row + 1.0) / ROWS * top - one_voxel, 0)));
        fprintf(f, "%*s%*s |", indent, "", LABEL, label);
        for (size_t b = 0; b < h->count; ++b) {
            const double filled = histogram_height(h, h->bins[b]) * ROWS - row;
            fputc(filled >= 0.95 ? '#' : filled >= 0.5 ? ':' : filled > 0 ? '.' : ' ', f);
        }
        fputc('\n', f);
    }
}

void iso_histogram_print(const iso_value_histogram *h, int indent, FILE *f)
{
    enum { WIDEST = 128 };
    const size_t columns = h->count < WIDEST ? h->count : WIDEST;
    const double hi = h->lo + h->width * (double)h->count, step = tick_step(hi - h->lo);
    char axis[WIDEST + 1], labels[WIDEST + 32];
    size_t free_from = 0; /* first column without a label */
    memset(axis, '-', columns);
    memset(labels, ' ', sizeof labels);
    axis[columns] = 0;
    for (double t = ceil(h->lo / step); t * step < hi; ++t) {
        char text[24];
        const size_t at = (size_t)fmin((t * step - h->lo) / h->width, (double)columns - 1);
        const size_t length = (size_t)snprintf(text, sizeof text, "%.6g", t * step + 0.0);
        const size_t from = at >= length / 2 ? at - length / 2 : 0;
        axis[at] = '+';
        if (from < free_from || from + length > sizeof labels)
            continue;
        memcpy(labels + from, text, length);
        free_from = from + length + 1;
    }
    labels[free_from < sizeof labels ? free_from : sizeof labels - 1] = 0;
    print_rows(h, indent, f);
    fprintf(f, "%*s%*s +%s\n%*s%*s  %s\n", indent, "", LABEL, "voxels", axis, indent, "", LABEL, "value", labels);
}

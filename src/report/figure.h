/* SPDX-License-Identifier: MIT */
/* figure.h - a publication figure from a report's own data.
 *
 *     DIR/figure.pdf   vector text, fonts embedded, pictures at 300 dpi or more
 *         figure.svg
 *         caption.txt  what the figure shows, with its numbers
 *         figure.gp    where sources are wanted: how it is drawn, from figure.csv
 *                      and the panels' pixels; style.gp has fonts and colours
 *
 *   levels      columns: levels; for each method, under each TF asked for, the
 *               image and, below, its difference from level 0, on one linear scale
 *   renderers   columns: comparisons at one level; both images and their
 *               difference, on one log scale
 * The scale bar holds in the plane through the centre of the volume's box; it
 * is left out where the report does not know the size of a pixel. */
#ifndef ISO_REPORT_FIGURE_H
#define ISO_REPORT_FIGURE_H

#include <stdbool.h>
#include <stddef.h>

#include "base/status.h"

typedef enum iso_figure_kind { ISO_FIGURE_LEVELS, ISO_FIGURE_RENDERERS, ISO_FIGURE_COUNT } iso_figure_kind;
const char *iso_figure_name(iso_figure_kind kind);
iso_status iso_figure_from_name(const char *name, iso_figure_kind *kind, iso_error *err);

typedef struct iso_figure_options {
    iso_figure_kind kind;
    const char *methods; /* levels: "naive,moments,moments+adapted" (iso_report_consistency_name()), in the report's
                          * order; NULL: the first and the last under the original TF */
    size_t level;        /* renderers */
    const char *scene;   /* renderers: of a suite's report, the scene's name; NULL: it has one */
    const char
        *variant; /* renderers: "naive", "adapted TF": comparisons whose name holds it; NULL: neither method nor TF */
    double width_mm;  /* of the whole figure, at most: 85 fits one column of many journals, 178 both */
    double height_mm; /* the same: panels become smaller */
    double dpi;       /* of the pictures, at least */
    bool with_sources;
    char *notice; /* NULL, or room for notice_size bytes: what a reader should know of the pictures; or "" */
    size_t notice_size;
} iso_figure_options;
iso_figure_options iso_figure_defaults(void);
/* ISO_E_RANGE: a size that cannot be printed. */
iso_status iso_figure_check(const iso_figure_options *opt, iso_error *err);

/* report_dir: what validate wrote. An existing out_dir is replaced only if it holds a figure.pdf.
 * ISO_E_FORMAT: no report; ISO_E_RANGE: nothing to show, an unknown method, options outside their limits;
 * ISO_E_MISSING without gnuplot. */
iso_status iso_figure_make(const char *report_dir, const iso_figure_options *opt, const char *out_dir, iso_error *err);

#endif

/* SPDX-License-Identifier: MIT */
/* tf_bar.h - a transfer function as a bar: its colors over value, as opaque as a length of them is, over gray squares. */
#ifndef ISO_FIGURE_TF_BAR_H
#define ISO_FIGURE_TF_BAR_H

#include "figure/picture.h"

/* The length that a table's opacities are stated for; 1 mm where it has none. */
double iso_figure_tf_unit_mm(const iso_tf_table *t);
/* 1 - exp(-extinction * length). */
double iso_figure_opacity(double extinction_per_mm, double length_mm);
/* All values that the table or the volume has. */
void iso_figure_tf_range(const iso_tf_table *t, const iso_level *level0, double range[2]);

/* The bar with an axis of values below it. box is that of the bar alone; wanted_ticks: about so many, 0: as the plot has
 * them. */
void iso_figure_put_tf_bar(iso_page *page, const iso_page_box *box, const iso_tf_table *t, const double range[2],
                           int wanted_ticks);

/* The bar under rendered pictures. Zeroed: there is none. */
typedef struct iso_figure_tf_foot {
    const iso_tf_table *tf; /* borrowed */
    double range[2];        /* values at its ends */
    bool of_level0;         /* coarser levels have other transfer functions */
} iso_figure_tf_foot;
/* None for label maps, which are no matter of opacity over value. */
iso_figure_tf_foot iso_figure_tf_foot_of(const iso_figure_subject *s);
/* How high the bar with its texts is; 0: there is none. */
double iso_figure_tf_foot_mm(const iso_figure_tf_foot *foot);
/* It ends above_mm over the page's lower edge, and the caption says what it is. */
void iso_figure_put_tf_foot(const iso_figure_tf_foot *foot, iso_page *page, double above_mm);

#endif
